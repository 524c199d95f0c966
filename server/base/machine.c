/* The memory of the machine, as far as it is ours. See machine.h.
 *
 * Under systemd and in containers the machine's memory is not what counts, but the limit of the control group: the kernel
 * ends a process that goes beyond it. Limits stand in the files memory.max and memory.high of the group and of each group
 * above it, as bytes or the word "max".
 */
#include "server/base/machine.h"

#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* The number in a group's file; INFINITY for the word "max", or when there is no such file. */
static double limit_in(const char *group, const char *file) {
    char path[PATH_MAX];
    double bytes;
    if (snprintf(path, sizeof path, "%s/%s", group, file) >= (int)sizeof path)
        return (double)INFINITY;
    FILE *stream = fopen(path, "re");
    if (!stream)
        return (double)INFINITY;
    int numbers = fscanf(stream, "%lf", &bytes);
    fclose(stream);
    return numbers == 1 && bytes > 0 ? bytes : (double)INFINITY;
}

/* The group's path in a version 2 hierarchy: the line "0::/path". False when there is none. */
static bool read_group(const char *membership, char *out, size_t room) {
    FILE *stream = fopen(membership, "re");
    bool found = false;
    char line[PATH_MAX];
    while (stream && !found && fgets(line, sizeof line, stream)) {
        line[strcspn(line, "\n")] = '\0';
        found = strncmp(line, "0::/", 4) == 0 && snprintf(out, room, "%s", line + 3) < (int)room;
    }
    if (stream)
        fclose(stream);
    return found;
}

double qg_cgroup_memory(const char *mount, const char *membership) {
    char group[PATH_MAX], path[2 * PATH_MAX];
    double least = (double)INFINITY;
    if (!read_group(membership, group, sizeof group))
        return least;
    for (;;) {
        snprintf(path, sizeof path, "%s%s", mount, group);
        least = fmin(least, fmin(limit_in(path, "memory.max"), limit_in(path, "memory.high")));
        char *slash = strrchr(group, '/');
        if (!slash)
            return least;
        *slash = '\0';
    }
}

double qg_machine_memory(void) {
    struct rlimit space;
    double pages = (double)sysconf(_SC_PHYS_PAGES), page = (double)sysconf(_SC_PAGESIZE);
    double least = pages > 0 && page > 0 ? pages * page : (double)INFINITY;
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY)
        least = fmin(least, (double)space.rlim_cur);
    return fmax(1, fmin(least, qg_cgroup_memory("/sys/fs/cgroup", "/proc/self/cgroup")));
}
