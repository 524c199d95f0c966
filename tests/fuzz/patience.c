/* Waiting that a stalled machine does not disturb. See patience.h. */
#include "tests/fuzz/patience.h"

#include <dirent.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { SLICE_MS = 20 };

/* Reads a file of a thread into out, without its line's end; "" when it cannot be read. */
static void read_entry(const char *thread, const char *name, char out[512]) {
    char path[96];
    snprintf(path, sizeof path, "/proc/self/task/%.20s/%.20s", thread, name);
    FILE *file = fopen(path, "re");
    size_t length = file ? fread(out, 1, 511, file) : 0;
    if (file)
        fclose(file);
    out[length] = '\0';
    out[strcspn(out, "\n")] = '\0';
}

/* The letter of a thread's state; '?' when it is gone. */
static char state_of(const char *thread) {
    char text[512];
    read_entry(thread, "stat", text);
    const char *end = strrchr(text, ')'); /* of its name, which may hold anything */
    return end && end[1] == ' ' ? end[2] : '?';
}

/* True when every thread but this one is asleep of its own will. */
static bool are_others_asleep(void) {
    bool asleep = true;
    DIR *threads = opendir("/proc/self/task");
    if (!threads)
        abort();
    for (const struct dirent *entry; asleep && (entry = readdir(threads));)
        if (entry->d_name[0] != '.' && atoi(entry->d_name) != gettid()) {
            char state = state_of(entry->d_name);
            asleep = state == 'S' || state == '?';
        }
    closedir(threads);
    return asleep;
}

static double milliseconds_of(clockid_t clock) {
    struct timespec time;
    clock_gettime(clock, &time);
    return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}

/* Processor time of the other threads, ms. */
static double computed(void) {
    return milliseconds_of(CLOCK_PROCESS_CPUTIME_ID) - milliseconds_of(CLOCK_THREAD_CPUTIME_ID);
}

enum verdict patience_wait(int descriptor, const struct patience *patience) {
    struct pollfd ready = {.fd = descriptor, .events = POLLIN};
    double begin = computed();
    int asleep = 0;
    while (poll(&ready, 1, SLICE_MS) != 1) {
        if (are_others_asleep())
            asleep += SLICE_MS;
        enum verdict verdict = asleep >= patience->asleep                  ? PATIENCE_HANGS
                               : computed() - begin >= patience->computing ? PATIENCE_SPINS
                                                                           : PATIENCE_READY;
        if (verdict != PATIENCE_READY)
            return poll(&ready, 1, 0) == 1 ? PATIENCE_READY : verdict;
    }
    return PATIENCE_READY;
}

void patience_print_threads(void) {
    char name[512], place[512];
    DIR *threads = opendir("/proc/self/task");
    for (const struct dirent *entry; threads && (entry = readdir(threads));) {
        if (entry->d_name[0] == '.')
            continue;
        read_entry(entry->d_name, "comm", name);
        read_entry(entry->d_name, "wchan", place);
        fprintf(stderr, "thread %s %s: state %c in %s\n", entry->d_name, name, state_of(entry->d_name), place);
    }
    if (threads)
        closedir(threads);
}
