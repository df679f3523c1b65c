/* The calls that ODE queues within a step: see calls.c. */

#ifndef LIBGZ_ODE_CALLS_H
#define LIBGZ_ODE_CALLS_H

#include <stddef.h>
#include <stdint.h>

typedef int call_function(void *argument, size_t index, void *call);

/* ODE's struct dThreadingFunctionsInfo. Locks and waits need no memory; `owner` is the queue. */
typedef struct {
    unsigned size; /* of this struct */
    void *(*make_locks)(void *owner, unsigned count, const char *const *names);
    void (*free_locks)(void *owner, void *locks);
    void (*lock)(void *owner, void *locks, unsigned index);
    void (*unlock)(void *owner, void *locks, unsigned index);
    void *(*make_wait)(void *owner);
    void (*reset_wait)(void *owner, void *wait);
    void (*free_wait)(void *owner, void *wait);
    void (*post)(void *owner, int *failed, void **posted, size_t waits_for, void *then, void *wait,
                 call_function *function, void *argument, size_t index, const char *name);
    void (*add_waits)(void *owner, void *call, ptrdiff_t count);
    void (*run)(void *owner, int *done, void *wait, const void *timeout, const char *name);
    unsigned (*count_threads)(void *owner);
    int (*reserve)(void *owner, size_t count);
} call_functions;

extern const call_functions gz_call_functions;

/* The calls of a world; zeros at first. Its address is the owner for ODE. */
typedef struct {
    struct call *all, *queue, *unused;
    int64_t made;
} call_queue;

/* Forget the calls of a step that was abandoned. */
void gz_drop_calls(call_queue *q);
void gz_free_calls(call_queue *q);

/* locking.c: abandon the step in which this happens. */
void gz_abandon_step(void);

#endif
