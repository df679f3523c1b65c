/* What the process of a server offers to C++ plugins: the methods that run, the message after a crash, and, with the
 * sources of the C library, the gz_* functions, which reach the server of the process.
 */
#define _GNU_SOURCE
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
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

static const int SIGNALS[] = {SIGSEGV, SIGABRT, SIGFPE, SIGILL};
static const char *const NAMES[] = {"SIGSEGV", "SIGABRT", "SIGFPE", "SIGILL"};
enum { COUNT = sizeof SIGNALS / sizeof SIGNALS[0] };
static struct sigaction before[COUNT];

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

static void on_signal(int number, siginfo_t *info, void *context)
{
    int i;

    (void) info;
    (void) context;
    for (i = 0; i < COUNT; i++)
        if (SIGNALS[i] == number) {
            if (top != NULL) {
                write_frame(NAMES[i]);
                write_text(": the process ends\n");
            }
            /* The instruction repeats, and ends the process as it would have without this handler. */
            sigaction(number, &before[i], NULL);
        }
}

static void on_exit_of_process(void)
{
    if (top == NULL)
        return;
    write_frame("exit() was called");
    write_text("\n");
    top = NULL;
}

/* Handle signals of crashes, and connect the C library with the server of the process. */
void gz_host_install(const struct gz_host *functions)
{
    struct sigaction action;
    int i;

    gz_host = functions;
    memset(&action, 0, sizeof action);
    action.sa_sigaction = on_signal;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_NODEFER;
    sigemptyset(&action.sa_mask);
    for (i = 0; i < COUNT; i++)
        sigaction(SIGNALS[i], &action, &before[i]);
    atexit(on_exit_of_process);
}

/* Report an error as the C library does. */
void gz_host_report(const char *text)
{
    GZ_ERROR("%s", text);
}
