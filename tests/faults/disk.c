/* A disk that fails when told to: put before the C library by LD_PRELOAD, for the tests of the daemon.
 *
 * Calls that write to files named in the pattern of $QG_FAULT_NAMES (default "quietgear.db") are counted: pwrite, write,
 * ftruncate, fallocate, fsync, fdatasync. They fail
 *   - while the file $QG_FAULT_FILE exists, with the number in it as errno; when that is negative they do not come back
 *     before the file is gone;
 *   - from the $QG_FAULT_FIRST-th to the $QG_FAULT_LAST-th (default: the same) of them, with errno $QG_FAULT_ERRNO;
 * so does access(2) where errno is EROFS; and the count goes to $QG_FAULT_COUNT, if that names a file, when the program ends. Which file a descriptor belongs to is
 * asked of /proc, so nothing has to be known about opening. Threads: any.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static atomic_long calls;

static long number_of(const char *name, long otherwise) {
    const char *text = getenv(name);
    return text ? strtol(text, NULL, 10) : otherwise;
}

/* True when the descriptor is of a file that the test is about. */
static bool is_meant(int descriptor) {
    char link[64], path[1024];
    const char *names = getenv("QG_FAULT_NAMES");
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length <= 0)
        return false;
    path[length] = '\0';
    return strstr(path, names ? names : "quietgear.db");
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

/* True, with errno set, when this call has to fail. */
static bool fails(int descriptor) {
    int before = errno;
    if (!is_meant(descriptor)) {
        errno = before;
        return false;
    }
    long call = atomic_fetch_add(&calls, 1) + 1, first = number_of("QG_FAULT_FIRST", 0);
    int error = asked_for();
    for (; error < 0; error = asked_for())
        usleep(10000);
    if (!error && first > 0 && call >= first && call <= number_of("QG_FAULT_LAST", first))
        error = (int)number_of("QG_FAULT_ERRNO", ENOSPC);
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
        return fails(descriptor) ? (type)-1 : real arguments;                                                          \
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
