/* How much memory this process may use. */
#ifndef QG_SERVER_BASE_MACHINE_H
#define QG_SERVER_BASE_MACHINE_H

/* Bytes: the smallest of the machine's memory, the limits of the process's control groups and the limit on its address space.
 * Never less than 1. Threads: any. */
double qg_machine_memory(void);

/* The smallest limit (memory.max, memory.high; bytes) of the control group that a file like /proc/self/cgroup names, and of
 * those above it, in a version 2 hierarchy mounted at `mount`. INFINITY when there is none. For qg_machine_memory, and tests. */
double qg_cgroup_memory(const char *mount, const char *membership);

#endif
