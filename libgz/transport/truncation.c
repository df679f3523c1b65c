/* Survives the truncation of mapped interface files.
 *
 * Access to mapped memory beyond the end of its file raises SIGBUS, and any client may truncate a file in the very
 * moment in which the server writes it. The handler extends the file again, and the access repeats. Where that does
 * not help, because the disk is full or the descriptor is another file's in a forked child, the page becomes private
 * memory: its clients are lost, the process continues.
 *
 * The handler is async-signal-safe: it makes system calls only, takes no lock, and reads rows that are published
 * atomically and never freed. Rows are claimed by compare-and-swap, so that threads and forked children need no lock.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "status.h"

enum { BLOCK = 256, BLOCKS = 256, MOST_TRIES = 10000 };

static const uintptr_t CLAIMED = 1; /* a row that is being filled; no mapping starts there */

/* Counts of one mapping, which Python reads. */
struct counts {
    _Atomic int64_t recovered; /* accesses after which the file was extended */
    _Atomic int64_t lost;      /* pages that became private memory */
};

struct mapping {
    struct counts counts; /* first: the address of a row is that of its counts */
    _Atomic uintptr_t start; /* 0: the row is free */
    _Atomic size_t length;   /* rounded up to pages */
    _Atomic int64_t size;    /* of the file */
    _Atomic int descriptor;  /* -1: the file is closed, the memory is still mapped */
    dev_t device;
    ino_t inode;
    _Atomic int64_t last; /* when an access last failed although the file was long enough [ns] */
    _Atomic int tries;    /* how often since then, in quick succession */
};

static struct mapping *_Atomic blocks[BLOCKS]; /* never freed: the handler may read them at any time */
static struct sigaction before;
static _Atomic long chained; /* the thread that runs the handler from before */
static uintptr_t page = 4096;

static struct mapping *find(uintptr_t address)
{
    for (int b = 0; b < BLOCKS; b++) {
        struct mapping *block = atomic_load(&blocks[b]);
        if (block == NULL)
            return NULL;
        for (int i = 0; i < BLOCK; i++) {
            uintptr_t start = atomic_load(&block[i].start);
            if (start > CLAIMED && address >= start && address - start < atomic_load(&block[i].length)
                && atomic_load(&block[i].start) == start)
                return &block[i];
        }
    }
    return NULL;
}

/* Whether a page failed so often in quick succession that its file cannot be the cause. */
static int hopeless(struct mapping *mapping)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    int64_t now = (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
    if (now - atomic_exchange(&mapping->last, now) > 1000000)
        atomic_store(&mapping->tries, 0);
    return atomic_fetch_add(&mapping->tries, 1) >= MOST_TRIES;
}

/* Make the file long enough for an access; 0 if that is impossible. */
static int extend(struct mapping *mapping, uintptr_t address)
{
    int descriptor = atomic_load(&mapping->descriptor);
    int64_t size = atomic_load(&mapping->size);
    struct stat about;
    /* In a child that closed its descriptors, the number may belong to a file that must not be touched. */
    if (descriptor < 0 || status_of(descriptor, &about) != 0)
        return 0;
    if (about.st_dev != mapping->device || about.st_ino != mapping->inode)
        return 0;
    if (about.st_size < size) {
        int result;
        do
            result = ftruncate(descriptor, (off_t)size);
        while (result != 0 && errno == EINTR);
        return result == 0;
    }
    /* Either somebody else has extended the file since, or there is no space for the page: allocate it to find out. */
    off_t offset = (off_t)((address - atomic_load(&mapping->start)) & ~(page - 1));
    off_t left = (off_t)size - offset;
    off_t wanted = left < (off_t)page ? left : (off_t)page;
    if (fallocate(descriptor, FALLOC_FL_KEEP_SIZE, offset, wanted) != 0 && (errno == ENOSPC || errno == EDQUOT))
        return 0;
    return !hopeless(mapping);
}

static int recover(struct mapping *mapping, uintptr_t address, int broken)
{
    if (!broken && extend(mapping, address)) {
        atomic_fetch_add(&mapping->counts.recovered, 1);
        return 1;
    }
    void *start = (void *)(address & ~(page - 1));
    if (mmap(start, page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) == MAP_FAILED)
        return 0;
    atomic_fetch_add(&mapping->counts.lost, 1);
    return 1;
}

/* Pass a signal that is none of ours to the handler from before. */
static void chain(int number, siginfo_t *info, void *context)
{
    long thread = syscall(SYS_gettid);
    int handled = (before.sa_flags & SA_SIGINFO) || (before.sa_handler != SIG_DFL && before.sa_handler != SIG_IGN);
    if (!handled || atomic_load(&chained) == thread) {
        /* None, or one that called us in turn: the access repeats, and ends the process as it would without us. */
        struct sigaction plain = {0};
        plain.sa_handler = SIG_DFL;
        sigaction(number, &plain, NULL);
        if (info->si_code <= 0)
            raise(number); /* sent by a process: nothing repeats */
        return;
    }
    atomic_store(&chained, thread);
    if (before.sa_flags & SA_SIGINFO)
        before.sa_sigaction(number, info, context);
    else
        before.sa_handler(number);
    atomic_store(&chained, 0);
}

static void on_sigbus(int number, siginfo_t *info, void *context)
{
    int saved = errno;
    /* Only the kernel's own signals have an address. */
    uintptr_t address = info->si_code > 0 ? (uintptr_t)info->si_addr : 0;
    struct mapping *mapping = address != 0 ? find(address) : NULL;
    int broken = info->si_code != BUS_ADRERR; /* such as failed memory: repeating does not help */
    if (mapping == NULL || !recover(mapping, address, broken))
        chain(number, info, context);
    errno = saved;
}

/* Install the handler before any other that was installed meanwhile; 0, or -1. */
static int install(void)
{
    struct sigaction action = {0}, now;
    if (sigaction(SIGBUS, NULL, &now) != 0)
        return -1;
    if ((now.sa_flags & SA_SIGINFO) && now.sa_sigaction == on_sigbus)
        return 0;
    before = now;
    action.sa_sigaction = on_sigbus;
    /* SA_NODEFER: the handler from before may fail in turn. */
    action.sa_flags = SA_SIGINFO | SA_NODEFER | SA_ONSTACK;
    sigemptyset(&action.sa_mask);
    return sigaction(SIGBUS, &action, NULL);
}

static struct mapping *new_block(int b)
{
    size_t bytes = sizeof(struct mapping) * BLOCK;
    struct mapping *block = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED)
        return NULL;
    struct mapping *other = NULL;
    if (atomic_compare_exchange_strong(&blocks[b], &other, block))
        return block;
    munmap(block, bytes); /* another thread was quicker */
    return other;
}

/* Watch a mapping of a whole file; the row, whose first numbers are `struct counts`, or NULL if that is impossible. */
void *gz_truncation_watch(void *start, size_t size, int descriptor)
{
    struct stat about;
    page = (uintptr_t)sysconf(_SC_PAGESIZE);
    if (status_of(descriptor, &about) != 0 || install() != 0)
        return NULL;
    for (int b = 0; b < BLOCKS; b++) {
        struct mapping *block = atomic_load(&blocks[b]);
        if (block == NULL && (block = new_block(b)) == NULL)
            return NULL;
        for (int i = 0; i < BLOCK; i++) {
            struct mapping *row = &block[i];
            uintptr_t none = 0;
            if (!atomic_compare_exchange_strong(&row->start, &none, CLAIMED))
                continue;
            atomic_store(&row->counts.recovered, 0);
            atomic_store(&row->counts.lost, 0);
            atomic_store(&row->length, (size + page - 1) & ~(page - 1));
            atomic_store(&row->size, (int64_t)size);
            atomic_store(&row->descriptor, descriptor);
            row->device = about.st_dev;
            row->inode = about.st_ino;
            atomic_store(&row->tries, 0);
            atomic_store(&row->start, (uintptr_t)start);
            return row;
        }
    }
    return NULL;
}

/* The descriptor of a watched mapping is closed: from now on truncated pages become private memory. */
void gz_truncation_release(void *row)
{
    atomic_store(&((struct mapping *)row)->descriptor, -1);
}

/* The memory of a watched mapping is unmapped. */
void gz_truncation_forget(void *row)
{
    atomic_store(&((struct mapping *)row)->start, 0);
}
