/* How the step reaches ODE: the addresses of its functions, the lock, and the way out where an assertion fails.
 *
 * ODE's debug handler may not return: on_failed_assertion() jumps to where the step, or the pair of geoms, began. */
#include "step.h"

#include <pthread.h>

#define DEFINE(result, name, arguments) result(*name) arguments;
ODE_FUNCTIONS(DEFINE)

__thread jump escape;
__thread int guarded;
static message_handler *other_handler;

/* Names in the order in which gz_step_bind() takes addresses; ends with NULL. */
const char *const *gz_step_needs(void)
{
#define NAME(result, name, arguments) #name,
    static const char *const names[] = {ODE_FUNCTIONS(NAME) NULL};
    return names;
}

static void on_failed_assertion(int number, const char *text, va_list arguments)
{
    if (guarded)
        JUMP_BACK(escape);
    if (other_handler)
        other_handler(number, text, arguments);
}

/* Only solve() has ODE post calls. */
void gz_abandon_step(void) { JUMP_BACK(escape); }

void gz_step_bind(void *const *addresses)
{
#define BIND(result, name, arguments) *(void **)&name = *addresses++;
    ODE_FUNCTIONS(BIND)
    other_handler = dGetDebugHandler();
    dSetDebugHandler(on_failed_assertion);
}

/* Have ODE queue the calls of this world's steps in calls.c. */
void gz_use_calls(void *world) { dWorldSetStepThreadingImplementation(world, &gz_call_functions, &gz_calls); }

/* ODE's solver and mesh colliders use memory that all worlds of a process share, and ctypes lets other threads run
 * meanwhile; so only one thread at a time may be in ODE. */
static pthread_mutex_t ode_lock = PTHREAD_MUTEX_INITIALIZER;

/* A forked child does not have the thread that may hold the lock, and its step is not continued. */
static void free_in_child(void)
{
    gz_drop_calls();
    pthread_mutex_init(&ode_lock, NULL);
}

void enter_ode(void)
{
    static int prepared;
    pthread_mutex_lock(&ode_lock);
    if (!prepared)
        prepared = !pthread_atfork(NULL, NULL, free_in_child);
}

void leave_ode(void) { pthread_mutex_unlock(&ode_lock); }
