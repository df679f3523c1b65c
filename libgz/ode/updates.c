/* Updates: what models do in each step, as a table of rows that one call works through.
 *
 * Most rows are laws: the operations that were recorded of a function in Python, with an interface under its lock where
 * they read or write one. The others are what is no arithmetic: whether a rate is due, rays, the step itself, and what
 * other processes see. gz_updates_run() stops at a row that it cannot do, and returns its number: then Python does that
 * row, and calls again from the next one on. A row is done either wholly here or wholly there, with the same arithmetic
 * in the same order; a test compares the bits. Nothing here knows a struct of an interface: operations hold offsets.
 *
 * libgz/base/records.py mirrors the structs; gz_updates_sizes() guards against drift.
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdint.h>
#include <string.h>
#include <sys/file.h>
#include <sys/sem.h>
#include <time.h>
#include <unistd.h>

int gz_step(void *context);
void gz_scan(void *context, const double *frame, const double *rays, int64_t count, int64_t owner, double *ranges,
             int64_t *rows);
void gz_publish(const void *context, void *publication);
int gz_may_sleep(void *body);
void gz_disturb(void *context);

/* Where states are. The arrays are those of the step; a byte of `fresh` is 1 where a row is up to date. */
typedef struct {
    void *context;
    double step;
    void *const *bodies;
    const double *body_state;
    char *body_fresh;
    int64_t body_size; /* rows of the arrays */
    void *const *joints;
    const double *joint_state;
    char *joint_fresh;
    int64_t joint_size;
    const char *marks; /* a byte a geom: 1 if it reflects, or has a fiducial number */
    int64_t touched;   /* 1: not all rows are fresh */
    int64_t changes;   /* grows with each row of a table that is taken or freed */
    int64_t done;      /* what the last step returned */
} tables;

typedef struct {
    double sim_time, pause_time;
    int64_t iterations;
    double start; /* on the monotonic clock */
} clock_record;

typedef struct {
    int64_t offset, size, text; /* texts are requests, which are kept as zeros */
} span;

enum { HEAD = 152 };

/* The memory of an interface, and what its lock needs. */
typedef struct {
    char *memory; /* NULL: it is not open */
    int64_t size;
    int64_t descriptor; /* -1: memory of this process */
    int64_t blocked;    /* 1: a client held the lock at the last attempt */
    int64_t attempts;   /* how often to try next time, while it is blocked */
    int64_t keeps;      /* 1: commands are kept at the next release of the lock */
    double next_check;  /* of the length, on the monotonic clock */
    const int64_t *counts;
    int64_t seen[2]; /* accesses beyond the end of the file; NULL: these end the process */
    const span *commands;
    int64_t command_count;
    char *kept, *found; /* commands when the file was last found whole; space for a copy */
    int64_t kept_any;
    int64_t exchanges; /* grows with each release of the lock, of a server */
    int64_t restored, most_restored; /* heads restored here since Python counted them; more are for Python to report */
    int64_t head_size;
    char head[HEAD]; /* as the server wrote it */
} link_record;

static const double CHECK_PERIOD = 0.05; /* [s]; that of interface.py */

#define NAP 1e-3 /* [s] at most between two looks whether another thread wants the world */

static double now_monotonic(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int is_long_enough(const link_record *l) { return lseek((int)l->descriptor, 0, SEEK_END) >= l->size; }

static int is_intact(const link_record *l) { return !memcmp(l->memory, l->head, (size_t)l->head_size); }

/* Restore the head, and the commands beside it, where a client overwrote them; 0 if Python has to: the file was
 * truncated, or the log is due. */
static int restore(link_record *l)
{
    static const char no_head[HEAD];
    int64_t i, at = 0;
    if (is_intact(l))
        return 1;
    if (l->restored >= l->most_restored || !memcmp(l->memory, no_head, (size_t)l->head_size))
        return 0;
    l->restored++;
    memcpy(l->memory, l->head, (size_t)l->head_size);
    for (i = 0; l->kept_any && i < l->command_count; at += l->commands[i++].size)
        memcpy(l->memory + l->commands[i].offset, l->kept + at, (size_t)l->commands[i].size);
    return 1;
}

static int is_whole(link_record *l)
{
    double now = now_monotonic();
    int due = now >= l->next_check;
    if ((due || !l->counts) && !is_long_enough(l))
        return 0;
    if (due && l->counts && (l->counts[0] != l->seen[0] || l->counts[1] != l->seen[1]))
        return 0;
    if (!restore(l))
        return 0;
    if (due) {
        l->next_check = now + CHECK_PERIOD;
        l->keeps = 1;
    }
    return 1;
}

static const int ATTEMPTS = 32; /* some 20 us: clients mostly hold a lock for less */

/* Try the lock at most so often. */
static int seize(link_record *l, int64_t attempts)
{
    while (attempts-- > 0)
        if (!flock((int)l->descriptor, LOCK_EX | LOCK_NB)) {
            l->attempts = ATTEMPTS;
            return 1;
        }
    return 0;
}

/* Take the lock; 0, and it is not held, if Python has to wait for it, or to repair the file. */
static int take(link_record *l)
{
    if (!l->memory)
        return 0;
    if (l->descriptor < 0)
        return 1;
    if (!seize(l, l->blocked ? 1 : ATTEMPTS))
        return 0;
    if (!is_whole(l)) {
        flock((int)l->descriptor, LOCK_UN);
        return 0;
    }
    l->blocked = 0;
    return 1;
}

/* Keep the commands, unless a client has overwritten the head meanwhile. */
static void keep_commands(link_record *l)
{
    int64_t i, at = 0;
    l->keeps = 0;
    for (i = 0; i < l->command_count; i++) {
        const span *s = l->commands + i;
        if (s->text)
            memset(l->found + at, 0, (size_t)s->size);
        else
            memcpy(l->found + at, l->memory + s->offset, (size_t)s->size);
        at += s->size;
    }
    if (!is_intact(l))
        return;
    memcpy(l->kept, l->found, (size_t)at);
    l->kept_any = 1;
}

static void release(link_record *l)
{
    l->exchanges++;
    if (l->descriptor >= 0)
        flock((int)l->descriptor, LOCK_UN);
}

static void give_back(link_record *l)
{
    if (l->keeps && l->descriptor >= 0)
        keep_commands(l);
    release(l);
}

/* Laws -------------------------------------------------------------------------------------------------------- */

/* Operation in libgz/base/law.py: conditions, what is read, arithmetic; then, from STORE on, what has effects. */
enum {
    REQUIRE, EXPECT, UNMARKED, SWITCH, TEXT, TRUE, FALSE, BODY, JOINT,
    BODY_STATE, JOINT_STATE, VECTOR, LOAD, REAL_TIME, GATHER,
    COPY, ADD, SUBTRACT, MULTIPLY, DIVIDE, NEGATE, ABSOLUTE, LEAST, MOST, LESS, AT_MOST, EQUAL, AND, OR, SELECT,
    SQRT, COS, SIN, TAN, ASIN, ATAN, ATAN2, HYPOT, FMOD, FLOOR,
    STORE, SEEN, SET, EFFORT, EFFORTS
};

/* What is done with arrays of `count` doubles; an operand with the stride 0 is a single number. Operations on bodies and
 * joints have the handle in `one` and the row in `two`; those on an interface an offset in `two`. */
typedef struct {
    int32_t code, count;
    int32_t strides[3]; /* [double]; of LOAD and STORE the second is that in the interface [byte] */
    int32_t type;       /* of numbers in an interface, as numpy's letters: d f i I H B */
    void *one, *two, *three, *result;
} operation;

typedef struct {
    link_record *link; /* NULL: without an interface */
    const operation *operations;
    int64_t count;
    const double *condition; /* whether the rows up to `jump` follow; NULL: they do */
} law;

/* How often other numbers than 0 and 1 were ignored here since Python counted them; more are for Python to report. */
typedef struct {
    int64_t ignored, most_ignored;
} switch_record;

/* A text: as it was at the last exchange that found one, and as it is now. */
typedef struct {
    char *seen, *found;
    int64_t size, time; /* where in the interface to write when it was found */
} text_record;

/* Rays from a body. */
typedef struct {
    int64_t body; /* row */
    void *handle;
    double *frame;
    const double *rays;
    int64_t count, owner;
    double *ranges;
    int64_t *rows;
} cast;

typedef void get_vector(void *joint, double *vector);
typedef void set_parameter(void *joint, int parameter, double value);
typedef void add_effort(void *joint, double);
typedef void add_efforts(void *body, double, double, double);

static int hits_marked(const tables *t, const cast *c)
{
    int64_t i;
    for (i = 0; i < c->count; i++)
        if (c->rows[i] >= 0 && t->marks[c->rows[i]])
            return 1;
    return 0;
}

/* Whether there is no text, or one that has changed since the last exchange: clients may still be writing it. */
static int is_unsettled(const text_record *r, const char *text)
{
    r->found[0] = text[0];
    if (r->found[0])
        memcpy(r->found, text, (size_t)r->size);
    return !r->found[0] || memcmp(r->found, r->seen, (size_t)r->size);
}

static int is_switched(const operation *o, const char *memory)
{
    int32_t number;
    memcpy(&number, memory + (intptr_t)o->two, sizeof number);
    return number != 0;
}

/* Numbers of any type as doubles. */
#define TYPES(X) X('d', double) X('f', float) X('i', int32_t) X('I', uint32_t) X('H', uint16_t) X('B', uint8_t)

static void store(const operation *o, char *memory)
{
    char *to = memory + (intptr_t)o->two;
    const double *from = o->one;
    int32_t i;
#define STORE_AS(letter, kind) \
    case letter: \
        for (i = 0; i < o->count; i++) { \
            kind number = (kind)from[i * o->strides[0]]; \
            memcpy(to + i * o->strides[1], &number, sizeof number); \
        } \
        break;
    switch (o->type) {
        TYPES(STORE_AS)
    }
}

static void load(const operation *o, const char *memory)
{
    const char *from = memory + (intptr_t)o->two;
    double *to = o->result;
    int32_t i;
#define LOAD_AS(letter, kind) \
    case letter: \
        for (i = 0; i < o->count; i++) { \
            kind number; \
            memcpy(&number, from + i * o->strides[1], sizeof number); \
            to[i] = (double)number; \
        } \
        break;
    switch (o->type) {
        TYPES(LOAD_AS)
    }
}

/* Arithmetic for each number of the arrays; what Python refuses, such as a division by zero, is left to Python. */
#define EACH(expression) \
    for (i = 0; i < o->count; i++) { \
        const double x = one[i * o->strides[0]]; \
        r[i] = (expression); \
    } \
    break
#define EACH_PAIR(expression) \
    for (i = 0; i < o->count; i++) { \
        const double x = one[i * o->strides[0]], y = two[i * o->strides[1]]; \
        r[i] = (expression); \
    } \
    break
#define UNLESS(refused) \
    for (i = 0; i < o->count; i++) { \
        const double x = one[i * o->strides[0]]; \
        if (refused) \
            return 0; \
    }
#define UNLESS_PAIR(refused) \
    for (i = 0; i < o->count; i++) { \
        const double x = one[i * o->strides[0]], y = two[i * o->strides[1]]; \
        (void)x; \
        if (refused) \
            return 0; \
    }

/* Do an operation; 0 if Python has to do the law. */
static int operate(const tables *t, const clock_record *clock, const operation *o, char *memory)
{
    const double *one = o->one, *two = o->two, *three = o->three;
    const intptr_t row = (intptr_t)o->two;
    double *r = o->result;
    int32_t i;
    switch (o->code) {
    case REQUIRE:
    case TRUE:
        return *one != 0.0;
    case FALSE:
        return *one == 0.0;
    case EXPECT: /* NaN that was refused stays refused */
        load(o, memory);
        return *r == *one || (*r != *r && *one != *one);
    case UNMARKED:
        return !hits_marked(t, o->one);
    case SWITCH:
        return !is_switched(o, memory);
    case TEXT:
        return is_unsettled(o->one, memory + row);
    case BODY: /* one that may sleep has to be woken, too */
        return o->one && t->bodies[row] == o->one && !gz_may_sleep(o->one);
    case JOINT:
        return o->one && t->joints[row] == o->one;
    case BODY_STATE:
        if (!o->one || t->bodies[row] != o->one || !t->body_fresh[row])
            return 0;
        memcpy(r, t->body_state + 16 * row, 16 * sizeof(double));
        break;
    case JOINT_STATE:
        if (!o->one || t->joints[row] != o->one || !t->joint_fresh[row])
            return 0;
        memcpy(r, t->joint_state + 4 * row, 4 * sizeof(double));
        break;
    case VECTOR:
        if (!o->one || t->joints[row] != o->one)
            return 0;
        (*(get_vector **)&o->three)(o->one, r);
        break;
    case LOAD:
        load(o, memory);
        break;
    case REAL_TIME:
        *r = now_monotonic() - clock->start;
        break;
    case GATHER:
        for (i = 0; i < o->count; i++)
            r[i] = one[((const int64_t *)o->two)[i]];
        break;
    case COPY: EACH(x);
    case ADD: EACH_PAIR(x + y);
    case SUBTRACT: EACH_PAIR(x - y);
    case MULTIPLY: EACH_PAIR(x * y);
    case DIVIDE:
        UNLESS_PAIR(y == 0.0)
        EACH_PAIR(x / y);
    case NEGATE: EACH(-x);
    case ABSOLUTE: EACH(fabs(x));
    case LEAST: EACH_PAIR(y < x ? y : x);
    case MOST: EACH_PAIR(y > x ? y : x);
    case LESS: EACH_PAIR(x < y);
    case AT_MOST: EACH_PAIR(x <= y);
    case EQUAL: EACH_PAIR(x == y);
    case AND: EACH_PAIR(x != 0.0 && y != 0.0);
    case OR: EACH_PAIR(x != 0.0 || y != 0.0);
    case SELECT:
        for (i = 0; i < o->count; i++)
            r[i] = one[i * o->strides[0]] != 0.0 ? two[i * o->strides[1]] : three[i * o->strides[2]];
        break;
    case SQRT:
        UNLESS(x < 0.0)
        EACH(sqrt(x));
    case COS:
        UNLESS(isinf(x))
        EACH(cos(x));
    case SIN:
        UNLESS(isinf(x))
        EACH(sin(x));
    case TAN:
        UNLESS(isinf(x))
        EACH(tan(x));
    case ASIN:
        UNLESS(x < -1.0 || x > 1.0)
        EACH(asin(x));
    case ATAN: EACH(atan(x));
    case ATAN2: EACH_PAIR(atan2(x, y));
    case HYPOT: EACH_PAIR(sqrt(x * x + y * y)); /* hypot() of new libraries is not in older ones */
    case FMOD:
        UNLESS_PAIR(y == 0.0 || isinf(x))
        EACH_PAIR(fmod(x, y));
    case FLOOR: /* an int in Python */
        UNLESS(!isfinite(x))
        EACH(floor(x));
    case STORE:
        store(o, memory);
        break;
    case SEEN: {
        const text_record *text = o->one;
        if (text->found[0]) {
            memcpy(text->seen, text->found, (size_t)text->size);
            memcpy(memory + text->time, &clock->sim_time, sizeof(double));
        }
        break;
    }
    case SET:
        (*(set_parameter **)&o->two)(o->result, o->type, *one);
        break;
    case EFFORT:
        gz_disturb(t->context);
        (*(add_effort **)&o->two)(o->result, *one);
        break;
    case EFFORTS:
        gz_disturb(t->context);
        (*(add_efforts **)&o->two)(o->result, one[0], one[1], one[2]);
        break;
    }
    return 1;
}

/* The operation for which Python has to do the law, or NULL. Those that have effects come last: none has been done then. */
static const operation *compute(const tables *t, const clock_record *clock, const law *l, char *memory)
{
    const operation *o = l->operations, *end = o + l->count;
    for (; o < end; o++)
        if (!operate(t, clock, o, memory))
            return o;
    return NULL;
}

/* Whether a client still holds a lock that Python has waited for in vain; each time it is tried half as often. */
static int is_still_blocked(link_record *l)
{
    if (!l->memory || l->descriptor < 0 || !l->blocked)
        return 0;
    if (seize(l, l->attempts > 1 ? l->attempts : 1))
        return 0;
    l->attempts /= 2;
    return 1;
}

/* Whether the exchange is left out, for as long as a client holds the lock. */
static int is_left_out(const law *l)
{
    int64_t i;
    for (i = 0; i < l->count; i++)
        if (l->operations[i].code == REQUIRE && *(const double *)l->operations[i].one == 0.0)
            return 0;
    return is_still_blocked(l->link);
}

/* Clear a switch that is neither 0 nor 1, and those after it that mean nothing then; 0 if Python has to look: it is a
 * command, or the log is due. */
static int ignore(const operation *o, char *memory)
{
    switch_record *r = o->one;
    int32_t number;
    if (o->code != SWITCH || r->ignored >= r->most_ignored)
        return 0;
    memcpy(&number, memory + (intptr_t)o->two, sizeof number);
    if (number == 0 || number == 1)
        return 0;
    r->ignored++;
    memset(memory + (intptr_t)o->two, 0, (size_t)o->count * sizeof number);
    return 1;
}

static const int RESTORATIONS = 8; /* in one exchange: a client may overwrite commands while they are compared */

/* Do a law, under the lock of its interface if it has one. */
static int obey(const tables *t, const clock_record *clock, const law *l)
{
    link_record *link = l->link;
    const operation *unmet;
    int left = RESTORATIONS;
    if (!link)
        return !compute(t, clock, l, NULL);
    if (is_left_out(l))
        return 1;
    if (!take(link))
        return 0;
    while ((unmet = compute(t, clock, l, link->memory))) {
        int overwritten = link->descriptor >= 0 && !is_intact(link);
        if (!left-- || !(overwritten ? restore(link) : ignore(unmet, link->memory))) {
            release(link); /* Python clears the request and then keeps the commands: a request acts once */
            return 0;
        }
    }
    give_back(link);
    return 1;
}

/* Rows -------------------------------------------------------------------------------------------------------- */

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

static int cast_rays(const tables *t, const cast *c)
{
    if (t->bodies[c->body] != c->handle || !t->body_fresh[c->body])
        return 0;
    memcpy(c->frame, t->body_state + 16 * c->body, 7 * sizeof(double));
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
} pace_record;

union semun {
    int val;
    struct semid_ds *buf;
    unsigned short *array;
};

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

/* Wait until the next step is due in real time; 0 if that is after the end, or if Python has to count anew. */
static int wait_until_due(const updates *u, const pace_record *p, double end)
{
    double passed = (u->clock->sim_time + u->clock->pause_time - p->simulated) / p->speed;
    for (;;) {
        double now = now_monotonic(), ahead = p->start + passed - now;
        struct timespec nap = {0, (long)(1e9 * (ahead < NAP ? ahead : NAP))};
        if (ahead <= 0.0)
            return ahead > -p->debt;
        if (now + ahead >= end || *(const volatile int64_t *)u->wanted)
            return 0;
        nanosleep(&nap, NULL);
    }
}

/* Do all rows, of which there are `count`, step after step, and return as gz_updates_run() does. It ends with the row that
 * Python has to do, after *steps steps, after some seconds, or if another thread wants the world. *steps: those that are
 * left. pace: when steps after the first one are due; NULL for at once. */
int64_t gz_updates_repeat(const updates *u, int64_t count, int64_t *steps, double seconds, const pace_record *pace)
{
    double end = now_monotonic() + seconds;
    int64_t i;
    do {
        i = gz_updates_run(u, 0, count);
        if (i < count)
            return i;
    } while (--*steps > 0 && !*(const volatile int64_t *)u->wanted && now_monotonic() < end &&
             (!pace || wait_until_due(u, pace, end)));
    return count;
}

/* The sizes of the structs that records.py mirrors, in its order; ends with 0. */
const int64_t *gz_updates_sizes(void)
{
    static const int64_t sizes[] = {
        sizeof(tables),    sizeof(clock_record), sizeof(span),       sizeof(link_record), sizeof(row),
        sizeof(rate_record), sizeof(cast),       sizeof(operation),  sizeof(law),         sizeof(beginning),
        sizeof(publishing), sizeof(posting),     sizeof(updates),    sizeof(switch_record), sizeof(text_record),
        sizeof(pace_record), 0};
    return sizes;
}
