/* What a submission, a claim and a page of the list cost in the store itself, with few jobs queued and with many.
 *
 *   claims [FEW [MANY]]     one JSON line for each depth of the queue; 100 and 10 000 unless told otherwise
 *
 * Times are medians in ms. A submission and a claim end with a sync of the disk, so they are the disk's rather than ours; what
 * counts is that they do not grow with the queue.
 */
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "server/store/store.h"

enum { SAMPLES = 50, PAGE = 100 };

static double now_ms(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

/* Ends the program when the store has failed: a measurement without it would mean nothing. */
static void require(enum qg_store_status status, const char *what) {
    if (status == QG_STORE_OK)
        return;
    fprintf(stderr, "%s failed with %d\n", what, (int)status);
    exit(1);
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double times[SAMPLES]) {
    qsort(times, SAMPLES, sizeof *times, compare);
    return times[SAMPLES / 2];
}

static double submit_one(struct qg_store *store) {
    const struct qg_submission submission = {
        .name = "queued", .kind = "evaluate", .labels = "[\"load\"]", .document = "{\"kind\":\"evaluate\"}"};
    struct qg_job_row row = {0};
    double start = now_ms();
    require(qg_store_submit(store, &submission, &row), "submitting");
    double took = now_ms() - start;
    qg_job_row_finish(&row);
    return took;
}

static double claim_one(struct qg_store *store) {
    struct qg_claim claim;
    struct qg_text document = {0};
    double start = now_ms();
    require(qg_store_claim(store, 600000, &claim, &document), "claiming");
    double took = now_ms() - start;
    qg_text_finish(&document);
    return took;
}

/* Reads one page from a cursor on, which it moves to the next page; 0 is the newest end. */
static double read_page(struct qg_store *store, int64_t *before) {
    static struct qg_job_row rows[PAGE];
    const struct qg_job_filter filter = {.state = QG_STATE_QUEUED, .before = *before, .limit = PAGE};
    size_t count;
    int64_t next;
    double start = now_ms();
    require(qg_store_list(store, &filter, rows, &count, &next), "listing");
    double took = now_ms() - start;
    *before = next;
    for (size_t i = 0; i < count; i++)
        qg_job_row_finish(&rows[i]);
    return took;
}

/* Fills the queue up to `depth` jobs and measures there; returns how many jobs are queued then. */
static size_t measure(struct qg_store *store, size_t queued, size_t depth) {
    double submissions[SAMPLES] = {0}, claims[SAMPLES], pages[SAMPLES];
    int64_t cursor = 0;
    for (; queued < depth; queued++)
        submissions[queued % SAMPLES] = submit_one(store);
    for (size_t i = 0; i < SAMPLES; i++)
        pages[i] = read_page(store, &cursor);
    for (size_t i = 0; i < SAMPLES; i++)
        claims[i] = claim_one(store);
    printf("{\"row\":{\"queued jobs\":%zu,\"submission, ms\":%.3f,\"claim, ms\":%.3f,\"page of %d, ms\":%.3f}}\n",
           depth, median(submissions), median(claims), PAGE, median(pages));
    return queued - SAMPLES;
}

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *ftw) {
    (void)status;
    (void)type;
    (void)ftw;
    return remove(path);
}

int main(int argc, char **argv) {
    char directory[] = "/tmp/quietgear-claims-XXXXXX", message[QG_STORE_MESSAGE_ROOM];
    size_t few = argc > 1 ? strtoul(argv[1], NULL, 10) : 100, many = argc > 2 ? strtoul(argv[2], NULL, 10) : 10000;
    struct qg_store *store = mkdtemp(directory) ? qg_store_open(directory, message) : NULL;
    if (!store || few < SAMPLES || many < few) {
        fprintf(stderr, "no store, or not %d <= FEW <= MANY\n", SAMPLES);
        return 1;
    }
    measure(store, measure(store, 0, few), many);
    qg_store_close(store);
    nftw(directory, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    return 0;
}
