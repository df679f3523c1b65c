/* A crew: threads that do the rows of many worlds beside each other.
 *
 * Python starts the threads, which stay in gz_crew_work() until gz_crew_end(). Its own thread adds a job as soon as it
 * has prepared one, so that others work while it prepares the next; gz_crew_next() then gives it a job that is done, and
 * until there is one it does jobs itself. A thread is woken for several jobs, because to wake it can cost as much as a short
 * one. Worlds share nothing that decides their numbers, so these do not depend on how many threads there are, nor on the
 * order of jobs.
 */
#include "crew.h"

#include <pthread.h>
#include <stdlib.h>

void gz_updates_work(job *j);

enum { WAKING = 4 }; /* jobs for which a thread is woken */

typedef struct {
    job *first, *last;
} job_list;

typedef struct {
    pthread_mutex_t lock;
    pthread_cond_t added, done;
    job_list todo, over;
    int64_t given; /* jobs that were added and not given back yet */
    int64_t added_now; /* jobs since the last one was given back */
    int64_t ended;
} crew;

static void put(job_list *l, job *j)
{
    j->next = NULL;
    if (l->first)
        l->last->next = j;
    else
        l->first = j;
    l->last = j;
}

static job *take(job_list *l)
{
    job *j = l->first;
    if (j)
        l->first = j->next;
    return j;
}

/* NULL without memory. */
crew *gz_crew_new(void)
{
    crew *c = calloc(1, sizeof *c);
    if (c) {
        pthread_mutex_init(&c->lock, NULL);
        pthread_cond_init(&c->added, NULL);
        pthread_cond_init(&c->done, NULL);
    }
    return c;
}

/* Do jobs until the crew ends. */
void gz_crew_work(crew *c)
{
    pthread_mutex_lock(&c->lock);
    while (!c->ended) {
        job *j = take(&c->todo);
        if (!j) {
            pthread_cond_wait(&c->added, &c->lock);
            continue;
        }
        pthread_mutex_unlock(&c->lock);
        gz_updates_work(j);
        pthread_mutex_lock(&c->lock);
        put(&c->over, j);
        pthread_cond_signal(&c->done);
    }
    pthread_mutex_unlock(&c->lock);
}

void gz_crew_add(crew *c, job *j)
{
    int wakes;
    pthread_mutex_lock(&c->lock);
    put(&c->todo, j);
    c->given++;
    wakes = ++c->added_now % WAKING == 0;
    pthread_mutex_unlock(&c->lock);
    if (wakes)
        pthread_cond_signal(&c->added);
}

/* Wake all threads once no more jobs come at present, if one is left to do: those that work already cost nothing. */
static void wake(crew *c)
{
    if (c->added_now && c->todo.first)
        pthread_cond_broadcast(&c->added);
    c->added_now = 0;
}

/* A job that is done, of those that were added and not given back yet; NULL without any. */
job *gz_crew_next(crew *c)
{
    job *j = NULL;
    int undone = 0;
    pthread_mutex_lock(&c->lock);
    if (c->given) {
        c->given--;
        while (!(j = take(&c->over)) && !(undone = (j = take(&c->todo)) != NULL))
            pthread_cond_wait(&c->done, &c->lock);
        wake(c);
    }
    pthread_mutex_unlock(&c->lock);
    if (undone)
        gz_updates_work(j);
    return j;
}

/* Let the threads return. */
void gz_crew_end(crew *c)
{
    pthread_mutex_lock(&c->lock);
    c->ended = 1;
    pthread_mutex_unlock(&c->lock);
    pthread_cond_broadcast(&c->added);
}

/* Free it, once they have. */
void gz_crew_free(crew *c)
{
    pthread_cond_destroy(&c->added);
    pthread_cond_destroy(&c->done);
    pthread_mutex_destroy(&c->lock);
    free(c);
}
