/* The n-th allocation, the n-th write and the n-th call of SQLite's files fail, for every n (some sixty, spread evenly, unless
 * $QG_FAULT_STRIDE says otherwise): the right answer comes, or a clear error, and what was promised before holds.
 *
 * malloc, calloc, realloc and strdup of our own code are wrapped by the linker (-Wl,--wrap), those of SQLite, cJSON, CHOLMOD
 * and libcurl by their own hooks; they are counted, and one of them returns NULL. SQLite's files are those of a VFS of ours
 * that hands every call on, counts, and lets one fail. A scenario is run once undisturbed to count, and then once for every
 * n. Under AddressSanitizer nothing may leak. Figures go to the file $QG_FAULT_FIGURES, if that is set.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <SuiteSparse_config.h>
#include <cjson/cJSON.h>
#include <curl/curl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "schema/drawing.h"
#include "schema/result.h"
#include "server/base/address.h"
#include "server/store/internal.h"

/* --- what fails --- */

static struct {
    long calls, failing; /* counted so far; which one fails, 0: none */
    bool counts;
} memory, files;

/* True for the call that has to fail. */
static bool fails(long *calls, long failing, bool counts) {
    return counts && ++*calls == failing;
}

static bool memory_fails(void) {
    return fails(&memory.calls, memory.failing, memory.counts);
}

static bool file_fails(void) {
    return fails(&files.calls, files.failing, files.counts);
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
char *__real_strdup(const char *text);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);
char *__wrap_strdup(const char *text);

void *__wrap_malloc(size_t size) {
    return memory_fails() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size) {
    return memory_fails() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *block, size_t size) {
    return memory_fails() ? NULL : __real_realloc(block, size);
}

char *__wrap_strdup(const char *text) {
    return memory_fails() ? NULL : __real_strdup(text);
}

/* --- SQLite's memory and files --- */

static sqlite3_mem_methods plain_memory;

static void *sqlite_malloc(int size) {
    return memory_fails() ? NULL : plain_memory.xMalloc(size);
}

static void *sqlite_realloc(void *block, int size) {
    return memory_fails() ? NULL : plain_memory.xRealloc(block, size);
}

/* A file of ours: its methods, and behind them the real file. */
struct file {
    sqlite3_file base;
    sqlite3_io_methods methods;
    sqlite3_file *real;
};

static sqlite3_file *real_of(sqlite3_file *file) {
    return ((struct file *)file)->real;
}

#define HANDED_ON(name, error, parameters, arguments)                                                                  \
    static int file_##name parameters {                                                                                \
        return file_fails() ? (error) : real_of(file)->pMethods->x##name arguments;                                    \
    }
HANDED_ON(Read, SQLITE_IOERR_READ, (sqlite3_file * file, void *to, int size, sqlite3_int64 at),
          (real_of(file), to, size, at))
HANDED_ON(Write, SQLITE_FULL, (sqlite3_file * file, const void *from, int size, sqlite3_int64 at),
          (real_of(file), from, size, at))
HANDED_ON(Truncate, SQLITE_IOERR_TRUNCATE, (sqlite3_file * file, sqlite3_int64 size), (real_of(file), size))
HANDED_ON(Sync, SQLITE_IOERR_FSYNC, (sqlite3_file * file, int flags), (real_of(file), flags))
HANDED_ON(FileSize, SQLITE_IOERR_FSTAT, (sqlite3_file * file, sqlite3_int64 *size), (real_of(file), size))
HANDED_ON(Lock, SQLITE_IOERR_LOCK, (sqlite3_file * file, int lock), (real_of(file), lock))
HANDED_ON(ShmMap, SQLITE_IOERR_SHMMAP, (sqlite3_file * file, int page, int size, int extend, void volatile **out),
          (real_of(file), page, size, extend, out))
HANDED_ON(ShmLock, SQLITE_IOERR_SHMLOCK, (sqlite3_file * file, int offset, int n, int flags),
          (real_of(file), offset, n, flags))

/* Undisturbed: their failures have no meaning, or would leave a lock behind. */
static int file_Close(sqlite3_file *file) {
    int code = real_of(file)->pMethods ? real_of(file)->pMethods->xClose(real_of(file)) : SQLITE_OK;
    sqlite3_free(real_of(file));
    return code;
}

static int file_Unlock(sqlite3_file *file, int lock) {
    return real_of(file)->pMethods->xUnlock(real_of(file), lock);
}

static int file_CheckReservedLock(sqlite3_file *file, int *out) {
    return real_of(file)->pMethods->xCheckReservedLock(real_of(file), out);
}

static int file_FileControl(sqlite3_file *file, int operation, void *argument) {
    return real_of(file)->pMethods->xFileControl(real_of(file), operation, argument);
}

static int file_SectorSize(sqlite3_file *file) {
    return real_of(file)->pMethods->xSectorSize(real_of(file));
}

static int file_DeviceCharacteristics(sqlite3_file *file) {
    return real_of(file)->pMethods->xDeviceCharacteristics(real_of(file));
}

static void file_ShmBarrier(sqlite3_file *file) {
    real_of(file)->pMethods->xShmBarrier(real_of(file));
}

static int file_ShmUnmap(sqlite3_file *file, int delete) {
    return real_of(file)->pMethods->xShmUnmap(real_of(file), delete);
}

static const sqlite3_io_methods file_methods = {
    2,
    file_Close,
    file_Read,
    file_Write,
    file_Truncate,
    file_Sync,
    file_FileSize,
    file_Lock,
    file_Unlock,
    file_CheckReservedLock,
    file_FileControl,
    file_SectorSize,
    file_DeviceCharacteristics,
    file_ShmMap,
    file_ShmLock,
    file_ShmBarrier,
    file_ShmUnmap,
    NULL,
    NULL,
};

static int open_file(sqlite3_vfs *vfs, const char *name, sqlite3_file *file, int flags, int *out) {
    sqlite3_vfs *real = vfs->pAppData;
    struct file *ours = (struct file *)file;
    ours->base.pMethods = NULL;
    if (file_fails())
        return SQLITE_CANTOPEN;
    bool counted = memory.counts;
    memory.counts = false; /* this block is the test's own */
    ours->real = sqlite3_malloc(real->szOsFile);
    memory.counts = counted;
    assert_non_null(ours->real);
    memset(ours->real, 0, (size_t)real->szOsFile);
    int code = real->xOpen(real, name, ours->real, flags, out);
    if (code == SQLITE_OK)
        ours->base.pMethods = &file_methods;
    else
        sqlite3_free(ours->real);
    return code;
}

static int set_up(void **state) {
    (void)state;
    static sqlite3_mem_methods failing_memory;
    static sqlite3_vfs vfs;
    cJSON_Hooks hooks = {__wrap_malloc, free};
    assert_int_equal(sqlite3_config(SQLITE_CONFIG_GETMALLOC, &plain_memory), SQLITE_OK);
    failing_memory = plain_memory;
    failing_memory.xMalloc = sqlite_malloc;
    failing_memory.xRealloc = sqlite_realloc;
    assert_int_equal(sqlite3_config(SQLITE_CONFIG_MALLOC, &failing_memory), SQLITE_OK);
    assert_int_equal(sqlite3_config(SQLITE_CONFIG_LOOKASIDE, 0, 0), SQLITE_OK);
    assert_int_equal(sqlite3_initialize(), SQLITE_OK);
    sqlite3_vfs *real = sqlite3_vfs_find(NULL);
    vfs = *real;
    vfs.zName = "faults";
    vfs.pAppData = real;
    vfs.szOsFile = (int)sizeof(struct file);
    vfs.xOpen = open_file;
    assert_int_equal(sqlite3_vfs_register(&vfs, 1), SQLITE_OK);
    cJSON_InitHooks(&hooks);
    SuiteSparse_config.malloc_func = __wrap_malloc;
    SuiteSparse_config.calloc_func = __wrap_calloc;
    SuiteSparse_config.realloc_func = __wrap_realloc;
    assert_int_equal(
        curl_global_init_mem(CURL_GLOBAL_DEFAULT, __wrap_malloc, free, __wrap_realloc, __wrap_strdup, __wrap_calloc),
        CURLE_OK);
    return 0;
}

/* --- running a scenario again and again --- */

/* From one n to the next: $QG_FAULT_STRIDE, or what gives some sixty of them. */
static long step_through(long all) {
    const char *text = getenv("QG_FAULT_STRIDE");
    long step = text ? strtol(text, NULL, 10) : (all + 59) / 60;
    return step > 0 ? step : 1;
}

static void report(const char *what, const char *scenario, long calls, long tried, long errors) {
    const char *name = getenv("QG_FAULT_FIGURES");
    FILE *file = name ? fopen(name, "ae") : NULL;
    if (!file)
        return;
    fprintf(
        file,
        "{\"row\":{\"scenario\":\"%s\",\"what fails\":\"%s\",\"calls in it\":%ld,\"tried\":%ld,\"right answers\":%ld,"
        "\"clear errors\":%ld}}\n",
        scenario, what, calls, tried, tried - errors, errors);
    fclose(file);
}

/* Runs the scenario with no fault, then with each. It returns true for the right answer, false for a clear error, and fails
 * the test itself for anything else. */
static void for_every_memory(const char *name, bool (*scenario)(void)) {
    long errors = 0, tried = 0;
    memory.calls = memory.failing = 0;
    assert_true(scenario());
    long all = memory.calls;
    assert_true(all > 0);
    for (long n = 1; n <= all; n += step_through(all), tried++) {
        memory.calls = 0;
        memory.failing = n;
        errors += !scenario();
    }
    memory.failing = 0;
    assert_true(scenario());
    report("an allocation", name, all, tried, errors);
    assert_true(errors > 0);
}

static void for_every_file_call(const char *name, bool (*scenario)(void)) {
    long errors = 0, tried = 0;
    files.calls = files.failing = 0;
    assert_true(scenario());
    long all = files.calls;
    assert_true(all > 0);
    for (long n = 1; n <= all; n += step_through(all), tried++) {
        files.calls = 0;
        files.failing = n;
        errors += !scenario();
    }
    files.failing = 0;
    report("a call of SQLite's files", name, all, tried, errors);
    assert_true(errors > 0);
}

/* --- the store --- */

static char directory[64];

static void remove_store(void) {
    static const char *const names[] = {"quietgear.db", "quietgear.db-wal", "quietgear.db-shm", "lock"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char path[128];
        snprintf(path, sizeof path, "%s/%s", directory, names[i]);
        unlink(path);
    }
    rmdir(directory);
}

/* What the store has promised by answering QG_STORE_OK. */
struct promises {
    char id[QG_JOB_ID_ROOM];
    bool submitted, finished;
    size_t evaluations;
};

/* From an empty directory to a finished job. True when all of it was done. */
static bool use_store(struct promises *made) {
    char message[QG_STORE_MESSAGE_ROOM];
    struct qg_text document = {0};
    struct qg_job_row row;
    struct qg_claim claim;
    const struct qg_evaluation evaluations[3] = {{.number = 0}, {.number = 1, .f_dte = 0.5}, {.number = 2}};
    const struct qg_output output = {QG_OUTPUT_RESULT, "{}"};
    const struct qg_submission submission = {
        .name = "n", .kind = "optimize", .labels = "[]", .document = "{}", .idempotency_key = "k"};
    const struct qg_ending ending = {.state = QG_STATE_SUCCEEDED, .outputs = &output, .output_count = 1};
    struct qg_store *store = qg_store_open(directory, message);
    if (!store)
        return false;
    if (qg_store_submit(store, &submission, &row) == QG_STORE_OK) {
        made->submitted = true;
        strcpy(made->id, row.id);
        qg_job_row_finish(&row);
    }
    bool held = made->submitted && qg_store_claim(store, 60000, &claim, &document) == QG_STORE_OK;
    qg_text_finish(&document);
    if (held && qg_store_record(store, &claim, evaluations, 3) == QG_STORE_OK)
        made->evaluations = 3;
    made->finished = made->evaluations && qg_store_finish(store, &claim, &ending) == QG_STORE_OK;
    qg_store_close(store);
    return made->finished;
}

/* Opens what was left, without faults, and holds it against the promises. */
static void hold_to(const struct promises *made) {
    char message[QG_STORE_MESSAGE_ROOM] = "";
    struct qg_job_row row;
    struct qg_evaluation evaluations[4];
    size_t count;
    struct qg_store *store = qg_store_open(directory, message);
    if (!store)
        fail_msg("%s", message);
    assert_int_equal(qg_store_check(store->writer), QG_STORE_OK);
    if (made->submitted) {
        assert_int_equal(qg_store_job(store, made->id, &row), QG_STORE_OK);
        assert_int_equal(qg_store_evaluations(store, row.sequence, 0, 4, evaluations, &count), QG_STORE_OK);
        assert_true(count == 3 || (!made->evaluations && count == 0));
        assert_true(!made->finished || row.state == QG_STATE_SUCCEEDED);
        qg_job_row_finish(&row);
    }
    qg_store_close(store);
}

static bool store_scenario(void) {
    struct promises made = {0};
    /* in memory, if there is such a place: each scenario waits for the disk some twenty times */
    strcpy(directory, access("/dev/shm", W_OK) == 0 ? "/dev/shm/quietgear-XXXXXX" : "/tmp/quietgear-XXXXXX");
    assert_non_null(mkdtemp(directory));
    memory.counts = files.counts = true;
    bool done = use_store(&made);
    memory.counts = files.counts = false;
    hold_to(&made);
    remove_store();
    return done;
}

static void the_store_without_memory(void **state) {
    (void)state;
    for_every_memory("store: open, submit, claim, record, finish", store_scenario);
}

static void the_store_on_failing_files(void **state) {
    (void)state;
    for_every_file_call("store: open, submit, claim, record, finish", store_scenario);
}

/* --- documents and studies --- */

/* One design with coarse figures. */
static const char document[] =
    "{\"kind\":\"evaluate\",\"name\":\"faults\",\"gear_pair\":{\"module_mm\":3,\"pressure_angle_deg\":20,"
    "\"center_distance_mm\":111,\"pinion\":{\"teeth\":28,\"profile_shift_mm\":1.927,\"outside_radius_mm\":46.55,"
    "\"root_radius_mm\":39.55,\"hob_tip_radius_mm\":0.9,\"bore_diameter_mm\":40,\"face_width_mm\":27},"
    "\"gear\":{\"teeth\":43,\"profile_shift_mm\":2.748,\"outside_radius_mm\":69.55,\"root_radius_mm\":63.1,"
    "\"hob_tip_radius_mm\":0.9,\"bore_diameter_mm\":40,\"face_width_mm\":22.5},\"material\":{\"youngs_modulus_mpa\":"
    "206000,"
    "\"poisson_ratio\":0.3,\"density_kg_per_m3\":7850},\"damping_ratio\":0.01,\"nominal_torque_nm\":470},"
    "\"load_cases\":[{\"torque_fraction\":1}],\"analysis\":{\"mesh_positions\":14,\"harmonics\":6,"
    "\"speeds\":{\"min\":0.2,\"max\":1.4,\"count\":20}}}";

/* The first text that a scenario gave; each later one has to be the same. */
static struct qg_text first;

static bool compare(struct qg_text *text) {
    bool complete = !text->failed && text->data;
    if (complete && !first.data)
        qg_text_add(&first, text->data, text->length);
    if (complete)
        assert_string_equal(text->data, first.data);
    qg_text_finish(text);
    return complete;
}

static bool document_scenario(void) {
    struct qg_text text = {0};
    struct qg_job *job = __real_calloc(1, sizeof *job);
    struct qg_faults *faults = __real_calloc(1, sizeof *faults);
    memory.counts = true;
    enum qg_document_status status = qg_document_read(document, sizeof document - 1, job, faults, NULL);
    if (status == QG_DOCUMENT_OK)
        qg_document_write(&text, job);
    memory.counts = false;
    assert_true(status == QG_DOCUMENT_OK || status == QG_DOCUMENT_NO_MEMORY);
    assert_int_equal(faults->count, 0);
    free(faults);
    free(job);
    return compare(&text);
}

static void documents_without_memory(void **state) {
    (void)state;
    for_every_memory("document: read, check, write", document_scenario);
    qg_text_finish(&first);
}

/* Reads it as a design, which may lack its kind, or as a result. */
static bool read_design(const char *bytes, bool result) {
    static struct qg_job job;
    static struct qg_faults faults;
    struct qg_text text = {0};
    memory.counts = true;
    enum qg_document_status status = result ? qg_result_design_read(bytes, strlen(bytes), &job)
                                            : qg_design_read(bytes, strlen(bytes), &job, &faults, NULL);
    if (status == QG_DOCUMENT_OK)
        qg_document_write(&text, &job);
    memory.counts = false;
    assert_true(status == QG_DOCUMENT_OK || status == QG_DOCUMENT_NO_MEMORY);
    return compare(&text);
}

static bool design_scenario(void) {
    char bytes[sizeof document];
    snprintf(bytes, sizeof bytes, "{%s", strchr(document, ',') + 1);
    return read_design(bytes, false);
}

static bool result_scenario(void) {
    char bytes[sizeof document + 200];
    snprintf(bytes, sizeof bytes,
             "{\"job\":%s,\"design\":{\"relief\":{\"pinion\":{\"tip\":{\"start_radius_mm\":44.54,"
             "\"amplitude_mm\":0.016}}}}}",
             document);
    return read_design(bytes, true);
}

static void designs_without_memory(void **state) {
    (void)state;
    for_every_memory("design: read, check, write", design_scenario);
    qg_text_finish(&first);
    for_every_memory("design of a result: read, check, write", result_scenario);
    qg_text_finish(&first);
}

/* A URL that may be used is never said to be wrong, and one that has a user, which only a part of it tells, never right. */
static bool url_scenario(void) {
    static const char rules[] = "http://a.example.com/ https://plm.example.com/hooks";
    memory.counts = true;
    const char *good = qg_url_refusal("https://plm.example.com/hooks/x?y=1", rules, "");
    const char *bad = qg_url_refusal("https://somebody@plm.example.com/hooks/", rules, "");
    memory.counts = false;
    assert_true(!good || good == qg_url_no_memory);
    assert_non_null(bad);
    return !good && bad != qg_url_no_memory;
}

static void urls_without_memory(void **state) {
    (void)state;
    for_every_memory("URL of a webhook: judge", url_scenario);
}

static bool study_scenario(void) {
    static struct qg_job job;
    static struct qg_faults faults;
    struct qg_text text = {0};
    struct qg_study_result result;
    const struct qg_means means = {.executor = qg_serial_executor};
    assert_int_equal(qg_document_read(document, sizeof document - 1, &job, &faults, NULL), QG_DOCUMENT_OK);
    memory.counts = true;
    enum qg_status status = qg_study_run(&job.study, &means, NULL, &result);
    if (status == QG_OK)
        qg_result_write(&text, &job, &result, 1);
    memory.counts = false;
    assert_true(status == QG_OK || status == QG_OUT_OF_MEMORY);
    qg_study_result_finish(&result);
    return compare(&text);
}

static void studies_without_memory(void **state) {
    (void)state;
    for_every_memory("study: compliance to result", study_scenario);
    qg_text_finish(&first);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(documents_without_memory),   cmocka_unit_test(designs_without_memory),
        cmocka_unit_test(urls_without_memory),        cmocka_unit_test(the_store_without_memory),
        cmocka_unit_test(the_store_on_failing_files), cmocka_unit_test(studies_without_memory),
    };
    if (!freopen("/dev/null", "a", stderr)) /* the store logs every failure, which are thousands here */
        return 1;
    qg_numerics_init(1);
    return cmocka_run_group_tests_name("faults", tests, set_up, NULL);
}
