/* Updates: what models do in each step, as a table of rows that one call works through.
 *
 * Most rows are laws (laws.c). The others are what is no arithmetic: whether a rate is due, rays, the step itself, and what
 * other processes see. gz_updates_run() stops at a row that it cannot do, and returns its number: then Python does that
 * row, and calls again from the next one on. A row is done either wholly here or wholly there, with the same arithmetic
 * in the same order; a test compares the bits.
 */
#define _GNU_SOURCE
#include <linux/futex.h>
#include <string.h>
#include <sys/sem.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "crew.h"
#include "updates.h"

#define NAP 4e-3 /* [s] at least that an idle world sleeps: the steps that were due meanwhile follow each other then */

/* Kind in records.py. */
enum { PYTHON, BEGIN, DUE, LAW, CAST, ADVANCE, PUBLISH, POST };

typedef struct {
    int64_t kind;
    int64_t jump; /* where to continue if a rate is not due, or the condition of a law does not hold */
    void *part;
} row;

typedef struct {
    double period, last, slack; /* [s] */
    int64_t beyond;             /* 1: the period has to be exceeded */
} rate_record;

static int is_due(rate_record *r, double now)
{
    double elapsed = now - r->last;
    if ((elapsed >= 0.0 && elapsed < r->period - r->slack) || (r->beyond && elapsed == r->period))
        return 0;
    r->last = now;
    return 1;
}

static int is_unmet(const law *l)
{
    return l->condition && *l->condition == 0.0;
}

static int cast_rays(tables *t, const cast *c)
{
    if (t->bodies[c->body] != c->handle)
        return 0;
    memcpy(c->frame, fresh_body(t, c->body), 7 * sizeof(double));
    gz_scan(t->context, c->frame, c->rays, c->count, c->owner, c->ranges, c->rows);
    return 1;
}

/* Steps at which Python looks for bodies that fell out of the world. */
typedef struct {
    int64_t period;
    int64_t at_start; /* 1: sim time grows at the beginning of a step */
} beginning;

/* States for other processes; Python looks first if something else than states may have changed. */
typedef struct {
    void *publication;
    char *numbers;     /* in the header: revision, steps, paused; sim, pause and real time */
    int64_t revision;
    int64_t ready;     /* 0: Python looks */
    int64_t changes;   /* those of the tables that Python has seen */
    double next_look;  /* of Python, on the monotonic clock */
    int64_t process;   /* that owns the memory */
} publishing;

typedef struct {
    int64_t set; /* of semaphores */
    const unsigned short *values;
} posting;

typedef struct {
    tables *tables;
    clock_record *clock;
    const row *rows;
    const int64_t *wanted; /* not 0: another thread waits for the world */
} updates;

typedef struct {
    double speed;     /* simulated seconds per second of real time */
    double start;     /* [s] on the monotonic clock */
    double simulated; /* [s] of sim time at the start */
    double debt;      /* [s] of being late, beyond which Python counts anew */
    double longest;   /* [s] of steps without Python */
} pace_record;

union semun {
    int val;
    struct semid_ds *buf;
    unsigned short *array;
};

static int is_wanted(const updates *u) { return *(const volatile int64_t *)u->wanted != 0; }

static int begin(const tables *t, clock_record *clock, const beginning *b)
{
    if ((clock->iterations + 1) % b->period == 0)
        return 0;
    clock->iterations++;
    clock->sim_time += b->at_start ? t->step : 0.0;
    return 1;
}

static void advance(tables *t, clock_record *clock, const beginning *b)
{
    clock->sim_time += b->at_start ? 0.0 : t->step;
    t->done = gz_step(t->context);
    if (t->touched) {
        memset(t->body_fresh, 1, (size_t)t->body_size);
        memset(t->joint_fresh, 1, (size_t)t->joint_size);
        t->touched = 0;
    }
}

static int publish(const tables *t, const clock_record *clock, const publishing *p)
{
    int64_t whole[3] = {p->revision, clock->iterations, 0};
    double now = now_monotonic(), times[3] = {clock->sim_time, clock->pause_time, now - clock->start};
    if (!p->ready || p->changes != t->changes || t->touched || now >= p->next_look || p->process != getpid())
        return 0;
    memcpy(p->numbers, whole, sizeof whole);
    memcpy(p->numbers + sizeof whole, times, sizeof times);
    gz_publish(t->context, p->publication);
    return 1;
}

static int post(const posting *p)
{
    union semun argument;
    argument.array = (unsigned short *)p->values;
    return p->set < 0 || semctl((int)p->set, 0, SETALL, argument) >= 0;
}

/* Do rows, from i up to an end, and return the number of the row that Python has to do, or the end. */
int64_t gz_updates_run(const updates *u, int64_t i, int64_t end)
{
    tables *t = u->tables;
    while (i < end) {
        const row *r = u->rows + i;
        int done = 1;
        switch (r->kind) {
        case BEGIN:
            done = begin(t, u->clock, r->part);
            break;
        case DUE:
            if (!is_due(r->part, u->clock->sim_time)) {
                i = r->jump;
                continue;
            }
            break;
        case LAW:
            done = obey(t, u->clock, r->part);
            if (done && is_unmet(r->part)) {
                i = r->jump;
                continue;
            }
            break;
        case CAST:
            done = cast_rays(t, r->part);
            break;
        case ADVANCE: /* where the step went wrong, Python recovers from it */
            advance(t, u->clock, r->part);
            done = t->done == 1;
            break;
        case PUBLISH:
            done = publish(t, u->clock, r->part);
            break;
        case POST:
            done = post(r->part);
            break;
        default:
            done = 0;
        }
        if (!done)
            break;
        i++;
    }
    return i;
}

enum { SEMAPHORES = 16 };

/* Whether a client has waited for the end of a step since the last one. */
static int was_awaited(const posting *p)
{
    unsigned short now[SEMAPHORES];
    union semun argument;
    argument.array = now;
    return p->set >= 0 && (semctl((int)p->set, 0, GETALL, argument) < 0 || memcmp(now, p->values, sizeof now));
}

/* Whether nobody can see when a step is made: nothing moves, and no client waits. */
static int is_idle(const updates *u, int64_t count)
{
    int64_t i;
    if (!gz_is_at_rest(u->tables->context))
        return 0;
    for (i = 0; i < count; i++)
        if (u->rows[i].kind == POST && was_awaited(u->rows[i].part))
            return 0;
    return 1;
}

/* Note that another thread wants the world, and wake the one that sleeps until a step is due. */
void gz_interrupt(int64_t *wanted)
{
    *(volatile int64_t *)wanted = 1;
    syscall(SYS_futex, wanted, FUTEX_WAKE_PRIVATE, 1, NULL, NULL, 0);
}

/* Sleep, at most until another thread wants the world. */
static void nap(const int64_t *wanted, double seconds)
{
    struct timespec time = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    syscall(SYS_futex, wanted, FUTEX_WAIT_PRIVATE, 0, &time, NULL, 0);
}

/* How long it is until the next step is due in real time [s]. */
static double time_left(const updates *u, const pace_record *p)
{
    double passed = (u->clock->sim_time + u->clock->pause_time - p->simulated) / p->speed;
    return p->start + passed - now_monotonic();
}

/* Wait until the next step is to be made; 0 if that is after the end, if another thread wants the world, or if Python has to
 * count anew. Whoever wants it finds no step missing that was due while an idle world slept. */
static int wait_until_due(const updates *u, int64_t count, const pace_record *p, double end)
{
    for (;;) {
        double ahead = time_left(u, p);
        if (ahead <= 0.0)
            return ahead > -p->debt && (!is_wanted(u) || gz_is_at_rest(u->tables->context));
        if (is_wanted(u))
            return 0;
        if (ahead < NAP && is_idle(u, count))
            ahead = NAP;
        if (now_monotonic() + ahead >= end)
            return 0;
        nap(u->wanted, ahead);
    }
}

/* Do all rows of a job, step after step. It ends with a row that Python has to do, after the steps, after some seconds, or if
 * another thread wants the world. */
void gz_updates_work(job *j)
{
    const updates *u = j->updates;
    const pace_record *pace = j->pace;
    double end = now_monotonic() + (pace ? pace->longest : j->seconds);
    int goes = 1;
    while (goes) {
        j->row = gz_updates_run(u, 0, j->count);
        goes = j->row == j->count && --j->steps > 0 && now_monotonic() < end &&
               (pace ? wait_until_due(u, j->count, pace, end) : !is_wanted(u));
    }
    j->obeyed = j->law && j->row == j->count && j->steps <= 0 && obey(u->tables, u->clock, j->law);
}

/* The sizes of the structs that records.py mirrors, in its order; ends with 0. */
const int64_t *gz_updates_sizes(void)
{
    static const int64_t sizes[] = {
        sizeof(tables),    sizeof(clock_record), sizeof(span),       sizeof(link_record), sizeof(row),
        sizeof(rate_record), sizeof(cast),       sizeof(operation),  sizeof(law),         sizeof(beginning),
        sizeof(publishing), sizeof(posting),     sizeof(updates),    sizeof(switch_record), sizeof(text_record),
        sizeof(pace_record), sizeof(job), 0};
    return sizes;
}
