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

/* Worlds step beside each other, in threads of their own, for ctypes lets other threads run meanwhile; but two things of
 * ODE are shared by all worlds of a process. Its colliders of meshes and height fields use common memory: so a world with
 * such shapes has ODE alone while it collides. And there is one state of random numbers, which only the iterations
 * of the quick solver use: these go one after the other. */
static pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER, iterations = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t left = PTHREAD_COND_INITIALIZER;
static int64_t inside;        /* worlds that are in ODE; -1: one that has it alone */
static int64_t waiting_alone; /* worlds that wait until they have it alone, before others enter */

/* A forked child does not have the threads that may be in ODE, and their steps are not continued. */
static void free_in_child(void)
{
    pthread_mutex_init(&gate, NULL);
    pthread_mutex_init(&iterations, NULL);
    pthread_cond_init(&left, NULL);
    inside = waiting_alone = 0;
}

/* NULL: what is done there collides nothing. */
void enter_ode(const context *c)
{
    static int prepared;
    pthread_mutex_lock(&gate);
    if (!prepared)
        prepared = !pthread_atfork(NULL, NULL, free_in_child);
    if (c && c->alone) {
        waiting_alone++;
        while (inside)
            pthread_cond_wait(&left, &gate);
        waiting_alone--;
        inside = -1;
    } else {
        while (inside < 0 || waiting_alone)
            pthread_cond_wait(&left, &gate);
        inside++;
    }
    pthread_mutex_unlock(&gate);
}

void leave_ode(void)
{
    pthread_mutex_lock(&gate);
    inside = inside < 0 ? 0 : inside - 1;
    if (!inside)
        pthread_cond_broadcast(&left);
    pthread_mutex_unlock(&gate);
}

/* Stay in ODE without having it alone. */
void let_others_in(const context *c)
{
    if (!c->alone)
        return;
    pthread_mutex_lock(&gate);
    inside = 1;
    pthread_cond_broadcast(&left);
    pthread_mutex_unlock(&gate);
}

/* Let ODE's random numbers be those of a world. */
void begin_iterations(context *c)
{
    pthread_mutex_lock(&iterations);
    c->iterating = 1;
    dRandSetSeed((unsigned long)c->seed);
}

/* Keep them; also after a step that was abandoned meanwhile. */
void end_iterations(context *c)
{
    if (!c->iterating)
        return;
    c->iterating = 0;
    c->seed = dRandGetSeed();
    pthread_mutex_unlock(&iterations);
}
