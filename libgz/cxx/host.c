/* What the process of a server offers to C++ plugins: the methods that run, the message after a crash, and, with the
 * sources of the C library, the gz_* functions, which reach the server of the process.
 */
#define _GNU_SOURCE
#include <link.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <ucontext.h>
#include <unistd.h>

#include "error.h"
#include "gazebo/LibgzFrame.h"
#include "host.h"

enum { STACK = 65536 };

/* The functions that plugins call, for plugins to find when they are loaded; and whether Python has ended. */
const void *gz_host_table;
int gz_host_ended;

static __thread libgz_frame *top;
static __thread int has_stack;

static const int SIGNALS[] = {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS};
static const char *const NAMES[] = {"SIGSEGV", "SIGABRT", "SIGFPE", "SIGILL", "SIGBUS"};
enum { COUNT = sizeof SIGNALS / sizeof SIGNALS[0] };
enum { HANDLERS = 16 };
static struct sigaction own, before[COUNT];
static int reported;
/* The handlers that plugins have installed, the newest last. Each of them has found ours before it, and calls that if it
 * hands a signal on: the one that was installed before it follows then.
 */
static struct handlers {
    struct sigaction all[HANDLERS];
    int count;
} of_plugins[COUNT];

/* Forget the handlers whose code lies between two addresses. */
static void forget_handlers(struct handlers *handlers, uintptr_t start, uintptr_t end)
{
    int i, kept = 0;

    for (i = 0; i < handlers->count; i++) {
        uintptr_t code = (uintptr_t) handlers->all[i].sa_sigaction;

        if (code < start || code >= end)
            handlers->all[kept++] = handlers->all[i];
    }
    handlers->count = kept;
}

/* Note a handler as the newest one; above the limit, the oldest is forgotten. */
static void add_handler(struct handlers *handlers, const struct sigaction *handler)
{
    uintptr_t code = (uintptr_t) handler->sa_sigaction;

    forget_handlers(handlers, code, code + 1);
    if (handlers->count == HANDLERS)
        memmove(handlers->all, handlers->all + 1, sizeof handlers->all[0] * --handlers->count);
    handlers->all[handlers->count++] = *handler;
}

/* A stack for signal handlers: after an endless recursion there is none left. */
static void make_stack(void)
{
    stack_t old, stack;

    has_stack = 1;
    if (sigaltstack(NULL, &old) != 0 || !(old.ss_flags & SS_DISABLE))
        return;
    stack.ss_sp = mmap(NULL, STACK, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    stack.ss_size = STACK;
    stack.ss_flags = 0;
    if (stack.ss_sp != MAP_FAILED)
        sigaltstack(&stack, NULL);
}

/* Where this thread keeps the method that runs in it. */
libgz_frame **gz_host_frames(void)
{
    if (!has_stack)
        make_stack();
    return &top;
}

/* Let the method that runs end after the present call: it failed. */
void gz_host_fail(void)
{
    if (top != NULL)
        top->failed = 1;
}

/* Offer the functions to plugins that are loaded later. The copy outlives Python, as objects at file scope do. */
void gz_host_offer(const void *table, size_t size)
{
    void *copy = malloc(size);

    if (copy != NULL)
        gz_host_table = memcpy(copy, table, size);
}

/* Mark that a file is being loaded; frame and texts must last until gz_host_loaded. */
void gz_host_loading(libgz_frame *frame)
{
    frame->below = *gz_host_frames();
    top = frame;
}

void gz_host_loaded(void)
{
    top = top->below;
}

/* Where the code of plugins is and was: in a thread of a plugin's own no method is marked, so that its stack has to say
 * whose it is. */
enum { FILES = 64, LABEL = 512, PAGES = 16, PAGE = 4096 };
static struct code {
    uintptr_t start, end;
    int in_memory;
    char label[LABEL];
} codes[FILES];
static int newest = -1;

struct search {
    const char *path;
    struct code *found;
};

static int note_range(struct dl_phdr_info *info, size_t size, void *data)
{
    struct search *search = data;
    int i;

    (void) size;
    if (strcmp(info->dlpi_name, search->path) != 0)
        return 0;
    for (i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *part = &info->dlpi_phdr[i];
        uintptr_t start = info->dlpi_addr + part->p_vaddr, end = start + part->p_memsz;

        if (part->p_type != PT_LOAD || !(part->p_flags & PF_X))
            continue;
        search->found->start = search->found->end == 0 || start < search->found->start ? start : search->found->start;
        search->found->end = end > search->found->end ? end : search->found->end;
    }
    return 1;
}

/* Note a file that was loaded from a path; returns its number. An entry of an unloaded one is used again. */
int gz_host_opened(const char *path, const char *label)
{
    struct search search;
    int number = (newest + 1) % FILES, i;

    for (i = 0; i < FILES && codes[number].in_memory; i++)
        number = (number + 1) % FILES;
    memset(&codes[number], 0, sizeof codes[number]);
    strncpy(codes[number].label, label, LABEL - 1);
    search.path = path;
    search.found = &codes[number];
    dl_iterate_phdr(note_range, &search);
    codes[number].in_memory = 1;
    newest = number;
    return number;
}

/* Note that it was unloaded. */
void gz_host_closed(int number)
{
    int i;

    codes[number].in_memory = 0;
    for (i = 0; i < COUNT; i++)
        forget_handlers(&of_plugins[i], codes[number].start, codes[number].end);
}

/* The file that has code at an address; a later one may be where an earlier one was. */
static const struct code *code_at(uintptr_t address)
{
    const struct code *found = NULL;
    int i;

    for (i = 0; newest >= 0 && i < FILES; i++) {
        const struct code *one = &codes[(newest - i + FILES) % FILES];
        if (one->start <= address && address < one->end && (found == NULL || one->in_memory))
            found = one;
        if (found != NULL && found->in_memory)
            break;
    }
    return found;
}

/* The file whose code runs at an address, or called what does: the first that the stack names. */
static const struct code *code_of(uintptr_t address, uintptr_t stack)
{
    static uintptr_t words[PAGES * PAGE / sizeof(uintptr_t)];
    const struct code *found = code_at(address);
    struct iovec own = {words, sizeof words}, pages[PAGES];
    ssize_t size, i;

    stack &= ~(uintptr_t) (sizeof(uintptr_t) - 1);
    for (i = 0; i < PAGES; i++) {
        uintptr_t end = (stack / PAGE + 1) * PAGE;

        pages[i].iov_base = (void *) stack;
        pages[i].iov_len = end - stack;
        stack = end;
    }
    /* The system reads up to where the stack ends. */
    size = found == NULL ? process_vm_readv(getpid(), &own, 1, pages, PAGES, 0) : 0;
    for (i = 0; found == NULL && i < size / (ssize_t) sizeof(uintptr_t); i++)
        found = code_at(words[i]);
    return found;
}

static void write_text(const char *text)
{
    if (write(STDERR_FILENO, text, strlen(text)) < 0)
        return;
}

static void write_frame(const char *what)
{
    write_text("\nerror   : ");
    write_text(what);
    write_text(" in ");
    write_text(top->method);
    write_text(" of ");
    write_text(top->label);
}

/* Report what happened in a thread that no method is marked in, whose stack names code of a plugin. */
static void write_thread(const char *what, const struct code *code)
{
    write_text("\nerror   : ");
    write_text(what);
    write_text(code->in_memory ? " in a thread of " : " in a thread that was left by ");
    write_text(code->label);
    if (!code->in_memory)
        write_text(", which was unloaded; its destructor has to join its threads");
}

static void on_signal(int number, siginfo_t *info, void *context)
{
    const ucontext_t *at = context;
    uintptr_t address = 0, stack = 0;
    const struct code *code;
    int i;

#if defined __x86_64__
    address = (uintptr_t) at->uc_mcontext.gregs[REG_RIP], stack = (uintptr_t) at->uc_mcontext.gregs[REG_RSP];
#elif defined __aarch64__
    address = (uintptr_t) at->uc_mcontext.pc, stack = (uintptr_t) at->uc_mcontext.sp;
#else
    (void) at;
#endif
    code = top == NULL ? code_of(address, stack) : NULL;
    for (i = 0; i < COUNT; i++)
        if (SIGNALS[i] == number) {
            struct handlers *handlers = &of_plugins[i];
            const struct sigaction *next = handlers->count == 0 ? &before[i] : &handlers->all[--handlers->count];

            if (reported)
                ; /* by this handler, which the plugin's has called */
            else if (top != NULL)
                write_frame(NAMES[i]);
            else if (code != NULL)
                write_thread(NAMES[i], code);
            if (!reported && (top != NULL || code != NULL))
                write_text(next == &before[i] ? ": the process ends\n" : ": a handler that was installed later follows\n");
            reported = next != &before[i];
            /* The instruction repeats, and ends the process as it would have without this handler. */
            sigaction(number, next, NULL);
            if (info->si_code <= 0)
                raise(number); /* a signal that code has sent */
        }
}

static void on_exit_of_process(void)
{
    const struct code *code = NULL;

    if (reported)
        return; /* a plugin's handler of signals ends the process */
    if (top == NULL && syscall(SYS_gettid) != getpid())
        code = code_of(0, (uintptr_t) __builtin_frame_address(0));
    if (top != NULL)
        write_frame("exit() was called");
    else if (code != NULL)
        write_thread("exit() was called", code);
    if (top != NULL || code != NULL)
        write_text("\n");
    top = NULL;
}

/* Handle signals of crashes, and connect the C library with the server of the process. */
void gz_host_install(const struct gz_host *functions)
{
    int i;

    gz_host = functions;
    own.sa_sigaction = on_signal;
    own.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_NODEFER;
    sigemptyset(&own.sa_mask);
    for (i = 0; i < COUNT; i++)
        sigaction(SIGNALS[i], &own, &before[i]);
    atexit(on_exit_of_process);
    at_quick_exit(on_exit_of_process);
}

/* Come before the handlers that a plugin has installed since, which would say nothing of plugins. */
void gz_host_watch(void)
{
    struct sigaction now;
    int i;

    reported = 0;
    for (i = 0; i < COUNT; i++)
        if (sigaction(SIGNALS[i], NULL, &now) == 0 && now.sa_sigaction != on_signal && now.sa_handler != SIG_IGN) {
            if (now.sa_handler == SIG_DFL)
                of_plugins[i].count = 0;
            else
                add_handler(&of_plugins[i], &now);
            sigaction(SIGNALS[i], &own, NULL);
        }
}

/* Report an error as the C library does. */
void gz_host_report(const char *text)
{
    GZ_ERROR("%s", text);
}
