/* The queue of calls into which ODE divides a step.
 *
 * ODE's own queue is shared by all worlds of the process. Calls of a step that was abandoned stay in it for ever, and
 * every later step of any world walks past them: after 20,000 such steps, that of a single box takes 300 times as long.
 * So each world has a queue of its own, which can be emptied. It does the calls in the order in which ODE's own does them
 * without threads: the last one that is ready comes first.
 */
#include "calls.h"

#include <stdlib.h>

typedef struct call {
    struct call *older; /* of all */
    struct call *next;  /* in the queue, or of those that are unused */
    struct call *then;  /* the one that waits for this one; or NULL */
    size_t waits_for;   /* so many; once it was started, itself included */
    int started;
    int failed;         /* 1: it failed, or one that it waited for */
    int *result;        /* out: `failed`; or NULL */
    call_function *function;
    void *argument;
    size_t index;
} call;

static void set_aside(call_queue *q, call *c)
{
    c->next = q->unused;
    q->unused = c;
}

void gz_drop_calls(call_queue *q)
{
    call *c;
    q->queue = q->unused = NULL;
    for (c = q->all; c; c = c->older)
        set_aside(q, c);
}

void gz_free_calls(call_queue *q)
{
    while (q->all) {
        call *c = q->all;
        q->all = c->older;
        free(c);
    }
    *q = (call_queue){0};
}

static int make_call(call_queue *q)
{
    call *c = malloc(sizeof *c);
    if (!c)
        return 0;
    c->older = q->all;
    q->all = c;
    q->made++;
    set_aside(q, c);
    return 1;
}

static int reserve(void *owner, size_t count)
{
    call_queue *q = owner;
    while ((size_t)q->made < count)
        if (!make_call(q))
            return 0;
    return 1;
}

static void post(void *owner, int *failed, void **posted, size_t waits_for, void *then, void *wait,
                 call_function *function, void *argument, size_t index, const char *name)
{
    call_queue *q = owner;
    call *c;
    (void)wait;
    (void)name;
    if (!q->unused && !make_call(q))
        gz_abandon_step();
    c = q->unused;
    q->unused = c->next;
    *c = (call){c->older, q->queue, then, waits_for, 0, 0, failed, function, argument, index};
    q->queue = c;
    if (posted)
        *posted = c;
}

static void add_waits(void *owner, void *target, ptrdiff_t count)
{
    (void)owner;
    ((call *)target)->waits_for += (size_t)count;
}

/* The first one that waits for nothing; NULL without any. */
static call *take(call_queue *q)
{
    call **place = &q->queue, *c;
    while (*place && (*place)->waits_for)
        place = &(*place)->next;
    c = *place;
    if (c) {
        *place = c->next;
        c->started = 1;
        c->waits_for = 1;
    }
    return c;
}

/* One thing less to wait for; a call that was started and waits for nothing more is over, also for the one after it. */
static void release(call_queue *q, call *c)
{
    while (c && !--c->waits_for && c->started) {
        call *then = c->then;
        if (c->result)
            *c->result = c->failed;
        if (then)
            then->failed |= c->failed;
        set_aside(q, c);
        c = then;
    }
}

static void run(void *owner, int *done, void *wait, const void *timeout, const char *name)
{
    call *c;
    (void)wait;
    (void)timeout;
    (void)name;
    while ((c = take(owner))) {
        if (!c->function(c->argument, c->index, c))
            c->failed = 1;
        release(owner, c);
    }
    if (done)
        *done = 1;
}

/* One thread does all, so nothing has to be locked or waited for. */
static void *make_locks(void *owner, unsigned count, const char *const *names)
{
    (void)count;
    (void)names;
    return owner;
}

static void ignore(void *owner, void *object)
{
    (void)owner;
    (void)object;
}

static void ignore_lock(void *owner, void *locks, unsigned index)
{
    (void)owner;
    (void)locks;
    (void)index;
}

static void *make_wait(void *owner) { return owner; }

static unsigned count_threads(void *owner)
{
    (void)owner;
    return 0; /* none besides the one that steps */
}

const call_functions gz_call_functions = {
    sizeof(call_functions), make_locks, ignore, ignore_lock, ignore_lock, make_wait, ignore, ignore, post, add_waits,
    run, count_threads, reserve,
};
