/* A disk that fails when told to: put before the C library by LD_PRELOAD, for the tests of the daemon.
 *
 * Calls that write to files whose path contains $QG_FAULT_NAMES (default "quietgear.db") are counted: pwrite, write,
 * ftruncate, fallocate, fsync, fdatasync. They fail
 *   - while the file $QG_FAULT_FILE exists, with the number in it as errno; when that is negative they do not come back
 *     before the file is gone; so does access(2) where errno is EROFS;
 *   - from the $QG_FAULT_FIRST-th to the $QG_FAULT_LAST-th (default: the same) of them, with errno $QG_FAULT_ERRNO. Then mkdir,
 *     rename, unlink, and open where it may make a file, are counted as well.
 * The count goes to $QG_FAULT_COUNT, if that names a file, when the program ends, and a line about the first call that failed
 * to $QG_FAULT_TRACE. Which file a descriptor belongs to is asked of /proc, so nothing has to be known about opening.
 * Threads: any.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

static atomic_long calls;
static atomic_bool told;

static long number_of(const char *name, long otherwise) {
    const char *text = getenv(name);
    return text ? strtol(text, NULL, 10) : otherwise;
}

/* True when the path is of a file that the test is about. */
static bool is_meant(const char *path) {
    const char *names = getenv("QG_FAULT_NAMES");
    return strstr(path, names ? names : "quietgear.db");
}

/* The path of the descriptor's file; "" when it has none. */
static void find_path(int descriptor, char path[1024]) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, path, 1023);
    path[length > 0 ? length : 0] = '\0';
}

/* The errno that the test's file asks for now; 0 without one. */
static int asked_for(void) {
    const char *file = getenv("QG_FAULT_FILE");
    FILE *stream = file ? fopen(file, "re") : NULL;
    int number = 0;
    if (stream && fscanf(stream, "%d", &number) != 1)
        number = EIO;
    if (stream)
        fclose(stream);
    return number;
}

/* Writes down which call failed first. */
static void tell_failure(const char *call, const char *path) {
    const char *file = getenv("QG_FAULT_TRACE");
    FILE *stream = file && !atomic_exchange(&told, true) ? fopen(file, "we") : NULL;
    if (stream) {
        fprintf(stream, "%s %s\n", call, path);
        fclose(stream);
    }
}

/* Counts a call; the errno with which it has to fail by its number, or 0. */
static int number_says(const char *name, const char *path) {
    long call = atomic_fetch_add(&calls, 1) + 1, first = number_of("QG_FAULT_FIRST", 0);
    if (first <= 0 || call < first || call > number_of("QG_FAULT_LAST", first))
        return 0;
    tell_failure(name, path);
    return (int)number_of("QG_FAULT_ERRNO", ENOSPC);
}

/* True, with errno set, when this call on a descriptor has to fail. */
static bool fails(const char *name, int descriptor) {
    char path[1024];
    int before = errno, error = 0;
    find_path(descriptor, path);
    if (is_meant(path)) {
        for (error = asked_for(); error < 0; error = asked_for())
            usleep(10000);
        if (!error)
            error = number_says(name, path);
    }
    errno = error ? error : before;
    return error;
}

/* The same for a call on a path. */
static bool path_fails(const char *name, const char *path) {
    int before = errno, error = getenv("QG_FAULT_NAMES") && is_meant(path) ? number_says(name, path) : 0;
    errno = error ? error : before;
    return error;
}

/* The function behind ours. */
static void *next(const char *name) {
    return dlsym(RTLD_NEXT, name);
}

int access(const char *path, int mode) {
    int (*real)(const char *, int) = (int (*)(const char *, int))(uintptr_t)next("access");
    if (!strstr(path, "quietgear.db") || asked_for() != EROFS || !(mode & W_OK))
        return real(path, mode);
    errno = EROFS;
    return -1;
}

__attribute__((destructor)) static void tell(void) {
    const char *file = getenv("QG_FAULT_COUNT");
    FILE *stream = file ? fopen(file, "we") : NULL;
    if (stream) {
        fprintf(stream, "%ld\n", atomic_load(&calls));
        fclose(stream);
    }
}

#define WRITER(type, name, parameters, arguments)                                                                      \
    type name parameters;                                                                                              \
    type name parameters {                                                                                             \
        type(*real) parameters = (type(*) parameters)(uintptr_t)next(#name);                                           \
        return fails(#name, descriptor) ? (type)-1 : real arguments;                                                   \
    }
WRITER(ssize_t, write, (int descriptor, const void *bytes, size_t count), (descriptor, bytes, count))
WRITER(ssize_t, pwrite, (int descriptor, const void *bytes, size_t count, off_t at), (descriptor, bytes, count, at))
WRITER(ssize_t, pwrite64, (int descriptor, const void *bytes, size_t count, off64_t at), (descriptor, bytes, count, at))
WRITER(int, ftruncate, (int descriptor, off_t length), (descriptor, length))
WRITER(int, ftruncate64, (int descriptor, off64_t length), (descriptor, length))
WRITER(int, fallocate, (int descriptor, int mode, off_t at, off_t length), (descriptor, mode, at, length))
WRITER(int, fallocate64, (int descriptor, int mode, off64_t at, off64_t length), (descriptor, mode, at, length))
WRITER(int, fsync, (int descriptor), (descriptor))
WRITER(int, fdatasync, (int descriptor), (descriptor))

#define CHANGER(name, parameters, arguments)                                                                           \
    int name parameters {                                                                                              \
        int(*real) parameters = (int(*) parameters)(uintptr_t)next(#name);                                             \
        return path_fails(#name, path) ? -1 : real arguments;                                                          \
    }
CHANGER(mkdir, (const char *path, mode_t mode), (path, mode))
CHANGER(rename, (const char *path, const char *to), (path, to))
CHANGER(unlink, (const char *path), (path))

#define OPENER(name)                                                                                                   \
    int name(const char *path, int flags, ...) {                                                                       \
        int (*real)(const char *, int, ...) = (int (*)(const char *, int, ...))(uintptr_t)next(#name);                 \
        va_list rest;                                                                                                  \
        va_start(rest, flags);                                                                                         \
        mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;                                                      \
        va_end(rest);                                                                                                  \
        return (flags & O_CREAT) && path_fails(#name, path) ? -1 : real(path, flags, mode);                            \
    }
OPENER(open)
OPENER(open64)
