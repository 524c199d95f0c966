/* The table of bad documents (bad.tsv): each is refused with the status and at the place that the table says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "schema/faults.h"
#include "tests/schema/support.h"

struct row {
    char file[80], pointer[QG_POINTER_ROOM];
    int status;
};

static struct qg_job job;
static struct qg_faults faults;

static void check_fault(const struct row *row, const struct qg_fault *fault) {
    const char *texts[] = {fault->pointer, fault->detail};
    for (int i = 0; i < 2; i++)
        for (const char *at = texts[i]; *at;) {
            const size_t step = qg_utf8_length(at, strlen(at));
            if (step == 0 || (unsigned char)*at < 0x20)
                fail_msg("%s: a fault with bad text: %s", row->file, fault->detail);
            at += step;
        }
    if (fault->detail[0] == '\0' || (fault->pointer[0] && fault->pointer[0] != '/'))
        fail_msg("%s: a fault without words or with a bad pointer: %s", row->file, fault->pointer);
}

static void check_row(const struct row *row) {
    char name[120];
    size_t length;
    snprintf(name, sizeof name, "tests/schema/bad/%s", row->file);
    char *text = read_source_file(name, &length);
    const enum qg_document_status status = qg_document_read(text, length, &job, &faults, NULL);
    free(text);
    if (status != (row->status == 400 ? QG_DOCUMENT_NOT_JSON : QG_DOCUMENT_INVALID))
        fail_msg("%s: status %d", row->file, (int)status);
    if (!has_fault_at(&faults, row->pointer))
        fail_msg("%s: no fault at \"%s\", the first is at %s: %s", row->file, row->pointer, faults.item[0].pointer,
                 faults.item[0].detail);
    for (size_t i = 0; i < faults.count; i++)
        check_fault(row, &faults.item[i]);
}

static void every_bad_document_is_refused_as_the_table_says(void **state) {
    size_t length, rows = 0;
    (void)state;
    char *table = read_source_file("tests/schema/bad.tsv", &length);
    table[length - 1] = '\0';
    char *rest = NULL;
    for (char *line = strtok_r(table, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        struct row row;
        if (line[0] == '#')
            continue;
        assert_int_equal(sscanf(line, "%79[^\t]\t%d\t%159[^\t]", row.file, &row.status, row.pointer), 3);
        if (strcmp(row.pointer, "\"\"") == 0)
            row.pointer[0] = '\0';
        check_row(&row);
        rows++;
    }
    assert_true(rows >= 70);
    free(table);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_bad_document_is_refused_as_the_table_says)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
