/* Updates: what models do in each step, as a table of rows that one call works through.
 *
 * A row is one thing to do: whether a rate is due, odometry, a servo, rays, the exchange of numbers with an interface
 * under its lock. gz_updates_run() stops at a row that it cannot do, and returns its number: then Python does that row,
 * and calls again from the next one on. A row is done either wholly here or wholly there, with the same arithmetic in
 * the same order; a test compares the bits. Nothing here knows a struct of an interface: rows hold offsets.
 *
 * libgz/ode/records.py mirrors the structs; gz_updates_sizes() guards against drift.
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
void gz_rotate(const double *quaternion, const double *vector, double *out);
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

/* Rows -------------------------------------------------------------------------------------------------------- */

/* Kind in records.py. */
enum { PYTHON, BEGIN, DUE, DIFFERENTIAL, BICYCLE, SERVO, SPRING, CAST, SHARE, ADVANCE, SETTLE, PUBLISH, POST, MOTION, FORMULA };

typedef struct {
    int64_t kind;
    int64_t jump; /* where to continue if a rate is not due */
    void *part;
} row;

typedef struct {
    double period, last, slack; /* [s] */
    int64_t beyond;             /* 1: the period has to be exceeded */
} rate_record;

/* An axis of a joint. */
typedef struct {
    int64_t joint; /* row */
    void *handle;
    int64_t column; /* of its angle; that of its rate is two further on */
} axis;

static int is_fresh(const tables *t, const axis *a)
{
    return t->joints[a->joint] == a->handle && t->joint_fresh[a->joint];
}

static int all_fresh(const tables *t, const axis *a, int64_t count)
{
    int64_t i;
    for (i = 0; i < count; i++)
        if (!is_fresh(t, a + i))
            return 0;
    return 1;
}

static double angle_of(const tables *t, const axis *a) { return t->joint_state[4 * a->joint + a->column]; }
static double rate_of(const tables *t, const axis *a) { return t->joint_state[4 * a->joint + a->column + 2]; }

static double sum_of(double (*value)(const tables *, const axis *), const tables *t, const axis *a, int64_t count)
{
    double total = 0.0;
    int64_t i;
    for (i = 0; i < count; i++)
        total += value(t, a + i);
    return total;
}

typedef struct {
    double pose[3], velocity[2];
} odometry_record;

typedef struct {
    double level, curve[2];
} battery_record;

static int is_due(rate_record *r, double now)
{
    double elapsed = now - r->last;
    if ((elapsed >= 0.0 && elapsed < r->period - r->slack) || (r->beyond && elapsed == r->period))
        return 0;
    r->last = now;
    return 1;
}

static void move_on(odometry_record *o, double travel, double turn, double step)
{
    o->pose[0] += travel * cos(o->pose[2]);
    o->pose[1] += travel * sin(o->pose[2]);
    o->pose[2] += turn;
    o->velocity[0] = travel / step;
    o->velocity[1] = turn / step;
}

/* Wheels on two sides. */
typedef struct {
    odometry_record *odometry;
    battery_record *battery; /* or NULL */
    const axis *axes;        /* those of the left side first */
    int64_t left, right;
    double diameter, separation;
    int64_t normalise;
    double *counts; /* of two encoders, or NULL */
    double counts_per_turn;
    const double *lean; /* [rad/s], added to the rates of the wheels; or NULL */
} differential;

static int measure_differential(const tables *t, const differential *d)
{
    double step = t->step, travel = step * d->diameter / 2.0, left, right, level, rates[2];
    int k;
    if (!all_fresh(t, d->axes, d->left + d->right))
        return 0;
    rates[0] = sum_of(rate_of, t, d->axes, d->left) / (double)d->left;
    rates[1] = sum_of(rate_of, t, d->axes + d->left, d->right) / (double)d->right;
    for (k = 0; d->lean && k < 2; k++)
        rates[k] += *d->lean;
    left = travel * rates[0];
    right = travel * rates[1];
    move_on(d->odometry, (left + right) / 2.0, (right - left) / d->separation, step);
    if (d->normalise)
        d->odometry->pose[2] = atan2(sin(d->odometry->pose[2]), cos(d->odometry->pose[2]));
    if (d->battery) {
        const double *curve = d->battery->curve;
        level = d->battery->level - (curve[0] * step + curve[1] * (left * left + right * right));
        d->battery->level = level > 0.0 ? level : 0.0;
    }
    for (k = 0; d->counts && k < 2; k++)
        d->counts[k] += d->counts_per_turn * rates[k] * step / (2.0 * M_PI);
    return 1;
}

/* Driven wheels, and steered ones in front of them. */
typedef struct {
    odometry_record *odometry;
    const axis *axes; /* those of the driven wheels first */
    int64_t driven, steered;
    double radius, base;
} bicycle;

static int measure_bicycle(const tables *t, const bicycle *b)
{
    double step = t->step, speed, angle;
    if (!all_fresh(t, b->axes, b->driven + b->steered))
        return 0;
    speed = b->radius * sum_of(rate_of, t, b->axes, b->driven) / (double)b->driven;
    angle = sum_of(angle_of, t, b->axes + b->driven, b->steered) / (double)b->steered;
    move_on(b->odometry, speed * step, speed * step * tan(angle) / b->base, step);
    return 1;
}

/* How a body moves. */
typedef struct {
    int64_t body; /* row */
    void *handle;
    double steep; /* sine of the pitch from which Python computes the attitude */
    double position[3], rotation[4], attitude[3], velocity[3], rate[3], up[3];
} motion;

static int find_motion(const tables *t, motion *m)
{
    static const double z_axis[3] = {0.0, 0.0, 1.0};
    const double *state = t->body_state + 16 * m->body;
    double u = state[3], x = state[4], y = state[5], z = state[6], sine = -2.0 * (x * z - u * y);
    double inverse[4] = {u, -x, -y, -z};
    if (t->bodies[m->body] != m->handle || !t->body_fresh[m->body] || !(fabs(sine) <= m->steep))
        return 0;
    memcpy(m->position, state, sizeof m->position);
    memcpy(m->rotation, state + 3, sizeof m->rotation);
    m->attitude[0] = atan2(2.0 * (y * z + u * x), u * u - x * x - y * y + z * z);
    m->attitude[1] = asin(sine);
    m->attitude[2] = atan2(2.0 * (x * y + u * z), u * u + x * x - y * y - z * z);
    gz_rotate(inverse, state + 10, m->velocity);
    gz_rotate(inverse, state + 13, m->rate);
    gz_rotate(m->rotation, z_axis, m->up);
    return 1;
}

/* A formula: conditions, then arithmetic, then what has effects. */
/* Operation in formula.py. */
enum {
    NEED, AT_LEAST, FINITE, BODY, JOINT, ADD, SUBTRACT, MULTIPLY, DIVIDE, NEGATE, LEAST, MOST, COPY, EFFORT, EFFORTS
};

typedef struct {
    int64_t operation;
    void *one, *two, *result;
} operation;

typedef struct {
    const operation *operations;
    int64_t count;
} formula;

typedef void add_effort(void *joint, double);
typedef void add_efforts(void *body, double, double, double);

static int compute(const tables *t, const formula *f)
{
    int64_t i;
    for (i = 0; i < f->count; i++) {
        const operation *o = f->operations + i;
        const double *a = o->one, *b = o->two;
        double *result = o->result;
        switch (o->operation) {
        case NEED:
            if (!*(const int64_t *)o->one)
                return 0;
            break;
        case AT_LEAST:
            if (!(*a >= *b))
                return 0;
            break;
        case FINITE:
            if (!isfinite(*a))
                return 0;
            break;
        case BODY: /* one that may sleep has to be woken, too */
            if (!o->one || t->bodies[(intptr_t)o->two] != o->one || gz_may_sleep(o->one))
                return 0;
            break;
        case JOINT:
            if (!o->one || t->joints[(intptr_t)o->two] != o->one)
                return 0;
            break;
        case ADD:
            *result = *a + *b;
            break;
        case SUBTRACT:
            *result = *a - *b;
            break;
        case MULTIPLY:
            *result = *a * *b;
            break;
        case DIVIDE:
            *result = *a / *b;
            break;
        case NEGATE:
            *result = -*a;
            break;
        case LEAST:
            *result = *b < *a ? *b : *a;
            break;
        case MOST:
            *result = *b > *a ? *b : *a;
            break;
        case COPY:
            *result = *a;
            break;
        case EFFORT:
            gz_disturb(t->context);
            (*(add_effort **)&o->two)(o->result, *a);
            break;
        case EFFORTS:
            gz_disturb(t->context);
            (*(add_efforts **)&o->two)(o->result, a[0], a[1], a[2]);
            break;
        }
    }
    return 1;
}

/* A motor that turns an axis to an angle. */
typedef struct {
    axis axis;
    void (*set)(void *joint, int parameter, double value);
    int64_t parameter;
    const double *target;
    double sign, gain, damping, most; /* [1], [1/s], [1], [rad/s] */
} servo;

static int turn(const tables *t, const servo *s)
{
    double velocity;
    if (!is_fresh(t, &s->axis))
        return 0;
    velocity = s->gain * (s->sign * *s->target - angle_of(t, &s->axis));
    if (s->damping != 0.0)
        velocity -= s->damping * rate_of(t, &s->axis);
    if (!(velocity >= -s->most && velocity <= s->most))
        return 0;
    s->set(s->axis.handle, (int)s->parameter, velocity);
    return 1;
}

typedef struct {
    axis axis;
    void (*add)(void *joint, double effort);
    double stiffness; /* negative */
} spring;

static int push_back(const tables *t, const spring *s)
{
    double effort;
    if (!is_fresh(t, &s->axis))
        return 0;
    effort = s->stiffness * angle_of(t, &s->axis);
    if (!isfinite(effort))
        return 0;
    s->add(s->axis.handle, effort);
    gz_disturb(t->context);
    return 1;
}

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

static int cast_rays(const tables *t, const cast *c)
{
    if (t->bodies[c->body] != c->handle || !t->body_fresh[c->body])
        return 0;
    memcpy(c->frame, t->body_state + 16 * c->body, 7 * sizeof(double));
    gz_scan(t->context, c->frame, c->rays, c->count, c->owner, c->ranges, c->rows);
    return 1;
}

/* Readings of a scanner, each interpolated between two rays, or that of the nearer hit. */
typedef struct {
    const cast *cast;
    const int64_t *first, *second;
    const double *share;
    double far, near, offset, smooth; /* [m] */
} scanner;

static double distance(const scanner *s, int64_t ray)
{
    double range = s->cast->ranges[ray];
    return (range < s->far ? range : s->far) + s->near;
}

static double reading(const scanner *s, int64_t i)
{
    double a = distance(s, s->first[i]), b = distance(s, s->second[i]);
    double between = (1.0 - s->share[i]) * a + s->share[i] * b;
    return (fabs(a - b) < s->smooth ? between : a < b ? a : b) + s->offset;
}

static int hits_marked(const tables *t, const cast *c)
{
    int64_t i;
    for (i = 0; i < c->count; i++)
        if (c->rows[i] >= 0 && t->marks[c->rows[i]])
            return 1;
    return 0;
}

/* What is exchanged with an interface. First come the conditions: where one is not met, Python does the row. */
/* What in records.py. */
enum {
    REQUIRE, EXPECT_INT, EXPECT_DOUBLE, UNMARKED, NOW, REAL_TIME, INTS, DOUBLES, NEAREST, READINGS, STORE, FETCH, ANGLE, RATE, VECTOR,
    SWITCH, TEXT
};

typedef struct {
    int64_t what;
    int64_t offset; /* in the interface's memory */
    int64_t count;
    int64_t stride; /* in the interface's memory [byte] */
    void *source;
    double limit;
    int64_t type; /* of what is stored or fetched, as numpy's letters: d f i I H B */
} transfer;

/* A vector of a joint. */
typedef struct {
    int64_t joint; /* row */
    void *handle;
    void (*get)(void *joint, double *vector);
    double scale;
} vector;

static void write_vector(const vector *v, char *to)
{
    double found[4];
    int k;
    v->get(v->handle, found);
    for (k = 0; k < 3; k++)
        found[k] = v->scale * found[k];
    memcpy(to, found, 3 * sizeof(double));
}

/* How often other numbers than 0 and 1 were ignored here since Python counted them; more are for Python to report. */
typedef struct {
    int64_t ignored, most_ignored;
} switch_record;

/* A text: as it was at the last exchange that found one, and as it is now. */
typedef struct {
    char *seen, *found;
    int64_t size, time; /* where in the interface to write when it was found */
} text_record;

/* Whether there is no text, or one that has changed since the last exchange: clients may still be writing it. */
static int is_unsettled(const text_record *r, const char *text)
{
    r->found[0] = text[0];
    if (r->found[0])
        memcpy(r->found, text, (size_t)r->size);
    return !r->found[0] || memcmp(r->found, r->seen, (size_t)r->size);
}

typedef struct {
    link_record *link;
    const transfer *transfers;
    int64_t count;
} share;

/* Numbers of any type as doubles. */
#define TYPES(X) X('d', double) X('f', float) X('i', int32_t) X('I', uint32_t) X('H', uint16_t) X('B', uint8_t)

static void store(int64_t type, char *to, double value)
{
#define STORE_AS(letter, kind) case letter: { kind number = (kind)value; memcpy(to, &number, sizeof number); break; }
    switch (type) {
        TYPES(STORE_AS)
    }
}

static double fetch(int64_t type, const char *from)
{
#define FETCH_AS(letter, kind) case letter: { kind number; memcpy(&number, from, sizeof number); return (double)number; }
    switch (type) {
        TYPES(FETCH_AS)
    }
    return 0.0;
}

static int is_met(const tables *t, const transfer *x, const char *memory)
{
    int32_t number;
    double value, expected;
    switch (x->what) {
    case REQUIRE:
        return *(const int64_t *)x->source != 0;
    case EXPECT_INT:
        memcpy(&number, memory + x->offset, sizeof number);
        return number == *(const int64_t *)x->source;
    case EXPECT_DOUBLE:
        memcpy(&value, memory + x->offset, sizeof value);
        expected = *(const double *)x->source;
        return value == expected || (value != value && expected != expected); /* NaN that was refused stays refused */
    case UNMARKED:
        return !hits_marked(t, x->source);
    case SWITCH:
        memcpy(&number, memory + x->offset, sizeof number);
        return number == 0;
    case TEXT:
        return is_unsettled(x->source, memory + x->offset);
    case ANGLE:
    case RATE:
        return is_fresh(t, x->source);
    case VECTOR:
        return t->joints[((const vector *)x->source)->joint] == ((const vector *)x->source)->handle;
    }
    return 1;
}

static void move(const tables *t, const clock_record *clock, const transfer *x, char *memory)
{
    char *to = memory + x->offset;
    double value;
    int64_t i;
    switch (x->what) {
    case NOW:
        memcpy(to, &clock->sim_time, sizeof(double));
        break;
    case REAL_TIME: {
        double passed = now_monotonic() - clock->start;
        memcpy(to, &passed, sizeof passed);
        break;
    }
    case INTS:
        for (i = 0; i < x->count; i++)
            memcpy(to + x->stride * i, x->source, sizeof(int32_t));
        break;
    case DOUBLES:
        for (i = 0; i < x->count; i++)
            memcpy(to + x->stride * i, (const double *)x->source + i, sizeof(double));
        break;
    case NEAREST:
        for (i = 0; i < x->count; i++) {
            double range = ((const double *)x->source)[i];
            range = range < x->limit ? range : x->limit;
            memcpy(to + x->stride * i, &range, sizeof range);
        }
        break;
    case STORE:
        for (i = 0; i < x->count; i++)
            store(x->type, to + x->stride * i, ((const double *)x->source)[i]);
        break;
    case FETCH:
        for (i = 0; i < x->count; i++)
            ((double *)x->source)[i] = fetch(x->type, to + x->stride * i);
        break;
    case ANGLE:
    case RATE:
        value = x->what == ANGLE ? angle_of(t, x->source) : rate_of(t, x->source);
        memcpy(to, &value, sizeof value);
        break;
    case VECTOR:
        write_vector(x->source, to);
        break;
    case TEXT: {
        const text_record *r = x->source;
        if (r->found[0]) {
            memcpy(r->seen, r->found, (size_t)r->size);
            memcpy(memory + r->time, &clock->sim_time, sizeof(double));
        }
        break;
    }
    case READINGS:
        for (i = 0; i < x->count; i++) {
            double range = reading(x->source, i);
            memcpy(to + x->stride * i, &range, sizeof range);
        }
        break;
    }
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
static int is_left_out(const share *s)
{
    int64_t i;
    for (i = 0; i < s->count; i++)
        if (s->transfers[i].what == REQUIRE && !*(const int64_t *)s->transfers[i].source)
            return 0;
    return is_still_blocked(s->link);
}

/* The first condition that is not met, or NULL. */
static const transfer *unmet(const tables *t, const share *s)
{
    int64_t i;
    for (i = 0; i < s->count; i++)
        if (!is_met(t, s->transfers + i, s->link->memory))
            return s->transfers + i;
    return NULL;
}

/* Clear a switch that is neither 0 nor 1, and those after it that mean nothing then; 0 if Python has to look: it is a
 * command, or the log is due. */
static int ignore(const transfer *x, char *memory)
{
    switch_record *r = x->source;
    int32_t number;
    if (x->what != SWITCH || r->ignored >= r->most_ignored)
        return 0;
    memcpy(&number, memory + x->offset, sizeof number);
    if (number == 0 || number == 1)
        return 0;
    r->ignored++;
    memset(memory + x->offset, 0, (size_t)x->count * sizeof number);
    return 1;
}

static const int RESTORATIONS = 8; /* in one exchange: a client may overwrite commands while they are compared */

static int exchange(const tables *t, const clock_record *clock, const share *s)
{
    link_record *l = s->link;
    const transfer *x;
    int64_t i;
    int left = RESTORATIONS;
    if (is_left_out(s))
        return 1;
    if (!take(l))
        return 0;
    while ((x = unmet(t, s))) {
        int overwritten = l->descriptor >= 0 && !is_intact(l);
        if (!left-- || !(overwritten ? restore(l) : ignore(x, l->memory))) {
            release(l); /* Python clears the request and then keeps the commands: a request acts once */
            return 0;
        }
    }
    for (i = 0; i < s->count; i++)
        move(t, clock, s->transfers + i, l->memory);
    give_back(l);
    return 1;
}

/* The whole step ---------------------------------------------------------------------------------------------- */

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
        case DIFFERENTIAL:
            done = measure_differential(t, r->part);
            break;
        case BICYCLE:
            done = measure_bicycle(t, r->part);
            break;
        case SERVO:
            done = turn(t, r->part);
            break;
        case SPRING:
            done = push_back(t, r->part);
            break;
        case MOTION:
            done = find_motion(t, r->part);
            break;
        case FORMULA:
            done = compute(t, r->part);
            break;
        case CAST:
            done = cast_rays(t, r->part);
            break;
        case SHARE:
            done = exchange(t, u->clock, r->part);
            break;
        case ADVANCE:
            advance(t, u->clock, r->part);
            break;
        case SETTLE:
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

/* Do all rows, of which there are `count`, step after step, and return as gz_updates_run() does. It ends with the row that
 * Python has to do, after *steps steps, after some seconds, or if another thread wants the world. *steps: those that are
 * left. */
int64_t gz_updates_repeat(const updates *u, int64_t count, int64_t *steps, double seconds)
{
    double end = now_monotonic() + seconds;
    int64_t i;
    do {
        i = gz_updates_run(u, 0, count);
        if (i < count)
            return i;
    } while (--*steps > 0 && !*(const volatile int64_t *)u->wanted && now_monotonic() < end);
    return count;
}

/* The sizes of the structs that records.py mirrors, in its order; ends with 0. */
const int64_t *gz_updates_sizes(void)
{
    static const int64_t sizes[] = {
        sizeof(tables),       sizeof(clock_record), sizeof(span),     sizeof(link_record), sizeof(row),
        sizeof(rate_record),  sizeof(axis),         sizeof(odometry_record), sizeof(battery_record),
        sizeof(differential), sizeof(bicycle),      sizeof(servo),    sizeof(spring),      sizeof(cast),
        sizeof(scanner),      sizeof(transfer),     sizeof(share),    sizeof(beginning),   sizeof(publishing),  sizeof(posting),
        sizeof(updates),      sizeof(motion),       sizeof(operation), sizeof(formula),
        sizeof(vector),       sizeof(switch_record), sizeof(text_record), 0};
    return sizes;
}
