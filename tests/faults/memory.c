/* Memory that runs out when told to: put before the C library by LD_PRELOAD, for the tests of whole programs.
 *
 * Every malloc, calloc, realloc, posix_memalign, aligned_alloc, memalign, and every mmap of anonymous memory in the process,
 * whoever makes it: quietgear's own code, CHOLMOD, OpenBLAS, SQLite, libmicrohttpd, GnuTLS, libcurl, the C library itself. A
 * program makes a hundred thousand of them, but most are the same one again; so a call is known by its site, which is a hash of
 * the return addresses of its $QG_MEMORY_DEPTH (5) innermost callers, each taken as module and offset, so that it is the same
 * number in each run. What fails (one of):
 *   $QG_MEMORY_SITE, $QG_MEMORY_CALL   the call of that number (from 1; 1 unless told otherwise) at the site, in hexadecimal;
 *   $QG_MEMORY_FIRST, $QG_MEMORY_LAST  the calls of these numbers (LAST: FIRST unless told otherwise), whoever makes them;
 *   $QG_MEMORY_ABOVE                   every call that wants so many bytes or more.
 * With $QG_MEMORY_ARM, nothing is counted and nothing fails before a file of that name exists.
 * $QG_MEMORY_SITES names a file to which, at the end of the program, a line per site goes: its hash, how often it was called,
 * the largest size, and its callers as module+offset. $QG_MEMORY_TRACE names one to which a line goes for the first call
 * that failed: its size and its callers.
 *
 * Under AddressSanitizer, whose own allocator has to be used, memory comes from that: then leaks are seen as well.
 * Threads: any. Nothing here allocates: the table of sites is static, files are written by write(2).
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
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <unwind.h>

#include <link.h>

enum { FRAMES_KEPT = 24, SITES_MAX = 1 << 16, LINE_ROOM = 4096 };

/* The C library's allocator under its other names, and AddressSanitizer's where that is there. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *block, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void *__interceptor_malloc(size_t size) __attribute__((weak));
void *__interceptor_calloc(size_t count, size_t size) __attribute__((weak));
void *__interceptor_realloc(void *block, size_t size) __attribute__((weak));
void *__interceptor_memalign(size_t alignment, size_t size) __attribute__((weak));
void *memalign(size_t alignment, size_t size);

struct site {
    atomic_ullong hash; /* 0: nobody's */
    atomic_ulong calls, largest;
    int depth;
    uintptr_t frame[FRAMES_KEPT];
};

/* What the environment asks for; read at the first call, constant afterwards. */
static struct {
    unsigned long long site;
    unsigned long call, first, last, above;
    unsigned depth;
    const char *arm, *sites, *trace;
    bool wanted; /* anything of it is */
} plan;

static atomic_int ready; /* 0: not read, 1: being read, 2: read */
static atomic_bool armed, told;
static atomic_ulong calls, site_calls;
static struct site sites[SITES_MAX];
static __thread bool inside __attribute__((tls_model("initial-exec"))); /* our own calls are nobody's */

static unsigned long number_of(const char *name, unsigned long otherwise, int base) {
    const char *text = getenv(name);
    return text ? strtoul(text, NULL, base) : otherwise;
}

static void read_plan(void) {
    plan.site = number_of("QG_MEMORY_SITE", 0, 16);
    plan.call = number_of("QG_MEMORY_CALL", 1, 10);
    plan.first = number_of("QG_MEMORY_FIRST", 0, 10);
    plan.last = number_of("QG_MEMORY_LAST", plan.first, 10);
    plan.above = number_of("QG_MEMORY_ABOVE", 0, 10);
    plan.depth = (unsigned)number_of("QG_MEMORY_DEPTH", 5, 10);
    plan.arm = getenv("QG_MEMORY_ARM");
    plan.sites = getenv("QG_MEMORY_SITES");
    plan.trace = getenv("QG_MEMORY_TRACE");
    plan.wanted = plan.site || plan.first || plan.above || plan.sites;
}

/* True once the plan is read and says that there is something to do now. */
static bool is_on(void) {
    int expected = 0;
    if (atomic_load(&ready) != 2) {
        if (!environ || !atomic_compare_exchange_strong(&ready, &expected, 1))
            return false;
        read_plan();
        atomic_store(&ready, 2);
    }
    if (!plan.wanted)
        return false;
    if (plan.arm && !atomic_load(&armed)) {
        int before = errno;
        if (access(plan.arm, F_OK) == 0)
            atomic_store(&armed, true);
        errno = before;
    }
    return !plan.arm || atomic_load(&armed);
}

/* --- who calls --- */

struct walk {
    uintptr_t frame[FRAMES_KEPT];
    unsigned depth, skipped;
};

static _Unwind_Reason_Code visit(struct _Unwind_Context *context, void *self) {
    enum { OURS = 3 }; /* take_stack, must_fail and the wrapper itself */
    struct walk *walk = self;
    if (walk->skipped++ < OURS)
        return _URC_NO_REASON;
    uintptr_t address = _Unwind_GetIP(context);
    if (!address || walk->depth == FRAMES_KEPT)
        return _URC_END_OF_STACK;
    walk->frame[walk->depth++] = address;
    return _URC_NO_REASON;
}

__attribute__((noinline)) static void take_stack(struct walk *walk) {
    walk->depth = walk->skipped = 0;
    _Unwind_Backtrace(visit, walk);
}

/* Module and offset of an address, which a run under another layout shares. */
static const char *place_of(uintptr_t address, uintptr_t *offset) {
    struct dl_find_object found;
    *offset = address;
    if (_dl_find_object((void *)address, &found) != 0)
        return "?";
    *offset = address - found.dlfo_link_map->l_addr;
    const char *name = found.dlfo_link_map->l_name, *slash = strrchr(name, '/');
    return *name ? (slash ? slash + 1 : name) : "program";
}

/* FNV-1a over what the callers are. */
static unsigned long long hash_of(const struct walk *walk) {
    unsigned long long hash = 14695981039346656037ULL;
    for (unsigned i = 0; i < walk->depth && i < plan.depth; i++) {
        uintptr_t offset;
        for (const char *name = place_of(walk->frame[i], &offset); *name; name++)
            hash = (hash ^ (unsigned char)*name) * 1099511628211ULL;
        for (unsigned shift = 0; shift < 64; shift += 8)
            hash = (hash ^ (offset >> shift & 255)) * 1099511628211ULL;
    }
    return hash ? hash : 1;
}

/* Counts a call at its site. */
static void count(const struct walk *walk, unsigned long long hash, size_t size) {
    for (unsigned i = 0; i < SITES_MAX; i++) {
        struct site *site = &sites[(hash + i) % SITES_MAX];
        unsigned long long there = 0;
        if (atomic_compare_exchange_strong(&site->hash, &there, hash)) {
            site->depth = (int)walk->depth;
            memcpy(site->frame, walk->frame, sizeof site->frame);
        } else if (there != hash) {
            continue;
        }
        atomic_fetch_add(&site->calls, 1);
        unsigned long largest = atomic_load(&site->largest);
        while (size > largest && !atomic_compare_exchange_weak(&site->largest, &largest, size))
            ;
        return;
    }
}

/* --- files of figures --- */

static int write_stack(char *line, int at, const uintptr_t *frame, int depth) {
    for (int i = 0; i < depth && at < LINE_ROOM - 128; i++) {
        uintptr_t offset;
        const char *module = place_of(frame[i], &offset);
        at += snprintf(line + at, (size_t)(LINE_ROOM - at), " %.60s+0x%lx", module, (unsigned long)offset);
    }
    line[at++] = '\n';
    return at;
}

static void put(int file, const char *line, int length) {
    if (syscall(SYS_write, file, line, (size_t)length) < 0)
        _exit(125);
}

/* Leaves a trace of the first call that fails. */
static void tell(const struct walk *walk, size_t size) {
    char line[LINE_ROOM];
    if (!plan.trace || atomic_exchange(&told, true))
        return;
    int file = (int)syscall(SYS_open, plan.trace, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0)
        return;
    put(file, line, write_stack(line, snprintf(line, sizeof line, "%zu", size), walk->frame, (int)walk->depth));
    close(file);
}

__attribute__((destructor)) static void list_sites(void) {
    char line[LINE_ROOM];
    inside = true;
    int file = plan.sites ? (int)syscall(SYS_open, plan.sites, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600) : -1;
    for (unsigned i = 0; i < SITES_MAX && file >= 0; i++) {
        struct site *site = &sites[i];
        if (!atomic_load(&site->calls))
            continue;
        int at = snprintf(line, sizeof line, "%llx %lu %lu", (unsigned long long)atomic_load(&site->hash),
                          atomic_load(&site->calls), atomic_load(&site->largest));
        put(file, line, write_stack(line, at, site->frame, site->depth));
    }
    if (file >= 0)
        close(file);
    inside = false;
}

/* --- the calls --- */

/* True when this call of so many bytes has to fail. errno says why, as that of the call itself would. */
__attribute__((noinline)) static bool must_fail(size_t size) {
    struct walk walk = {.depth = 0};
    if (inside || !is_on())
        return false;
    inside = true;
    unsigned long call = atomic_fetch_add(&calls, 1) + 1;
    bool fails = (plan.above && size >= plan.above) || (plan.first && call >= plan.first && call <= plan.last);
    if (plan.site || plan.sites || fails)
        take_stack(&walk);
    unsigned long long hash = plan.site || plan.sites ? hash_of(&walk) : 0;
    if (plan.sites)
        count(&walk, hash, size);
    if (plan.site && hash == plan.site)
        fails = atomic_fetch_add(&site_calls, 1) + 1 == plan.call;
    if (fails)
        tell(&walk, size);
    inside = false;
    if (fails)
        errno = ENOMEM;
    return fails;
}

void *malloc(size_t size) {
    if (must_fail(size))
        return NULL;
    return __interceptor_malloc ? __interceptor_malloc(size) : __libc_malloc(size);
}

void *calloc(size_t number, size_t size) {
    if (must_fail(number * size))
        return NULL;
    return __interceptor_calloc ? __interceptor_calloc(number, size) : __libc_calloc(number, size);
}

void *realloc(void *block, size_t size) {
    if (size && must_fail(size))
        return NULL;
    return __interceptor_realloc ? __interceptor_realloc(block, size) : __libc_realloc(block, size);
}

static void *aligned(size_t alignment, size_t size) {
    return __interceptor_memalign ? __interceptor_memalign(alignment, size) : __libc_memalign(alignment, size);
}

void *memalign(size_t alignment, size_t size) {
    return must_fail(size) ? NULL : aligned(alignment, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
    return must_fail(size) ? NULL : aligned(alignment, size);
}

int posix_memalign(void **block, size_t alignment, size_t size) {
    int before = errno;
    void *got = must_fail(size) ? NULL : aligned(alignment, size);
    errno = before;
    if (got)
        *block = got;
    return got ? 0 : ENOMEM;
}

void *mmap(void *address, size_t size, int protection, int flags, int file, off_t at) {
    if ((flags & MAP_ANONYMOUS) && must_fail(size))
        return MAP_FAILED;
    return (void *)syscall(SYS_mmap, address, size, protection, flags, file, at);
}
