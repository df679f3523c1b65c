/* Laws: the operations that were recorded of a function in Python, with an interface under its lock where they read or
 * write one. Nothing here knows a struct of an interface: operations hold offsets. */
#define _GNU_SOURCE
#include <math.h>
#include <string.h>

#include "updates.h"

/* Operation in libgz/base/law.py: conditions, what is read, arithmetic; then, from STORE on, what has effects. */
enum {
    REQUIRE, EXPECT, UNMARKED, SWITCH, TEXT, TRUE, FALSE, END, BODY, JOINT,
    BODY_STATE, JOINT_STATE, VECTOR, LOAD, REAL_TIME, GATHER,
    COPY, ADD, SUBTRACT, MULTIPLY, DIVIDE, NEGATE, ABSOLUTE, LEAST, MOST, LESS, AT_MOST, EQUAL, AND, OR, SELECT,
    SQRT, COS, SIN, TAN, ASIN, ACOS, ATAN, ATAN2, HYPOT, FMOD, FLOOR, COPYSIGN,
    STORE, SEEN, SET, EFFORT, EFFORTS, VELOCITY, WAKE, NOTE, APPEND
};

typedef void get_vector(void *joint, double *vector);
typedef void set_parameter(void *joint, int parameter, double value);
typedef void add_effort(void *joint, double);
typedef void add_efforts(void *body, double, double, double);
typedef void add_effort_at(void *body, double, double, double, double, double, double);

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

/* A number as an integer, of which fields of less bits keep the last ones; 0 if it is far beyond all of them, or NaN. */
static int64_t integer(double number) { return fabs(number) <= 0x1p62 ? (int64_t)number : 0; }

/* Numbers of any type as doubles: letter, type, and how one is made. */
#define TYPES(X) \
    X('d', double, ) X('f', float, ) \
    X('i', int32_t, integer) X('I', uint32_t, integer) X('H', uint16_t, integer) X('B', uint8_t, integer)

static void store(const operation *o, char *memory)
{
    char *to = (char *)((intptr_t)memory + (intptr_t)o->two); /* without an interface, an address */
    const double *from = o->one;
    int32_t i;
#define STORE_AS(letter, kind, made) \
    case letter: \
        for (i = 0; i < o->count; i++) { \
            kind number = (kind)made(from[i * o->strides[0]]); \
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
#define LOAD_AS(letter, kind, made) \
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

/* Arithmetic for each number of the arrays, mostly single ones; what Python refuses, such as a division by zero, is left to
 * Python. */
#define EACH(expression) \
    if (o->count == 1) { \
        const double x = *one; \
        *r = (expression); \
        break; \
    } \
    for (i = 0; i < o->count; i++) { \
        const double x = one[i * o->strides[0]]; \
        r[i] = (expression); \
    } \
    break
#define EACH_PAIR(expression) \
    if (o->count == 1) { \
        const double x = *one, y = *two; \
        *r = (expression); \
        break; \
    } \
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

/* Set three numbers of a body, such as its velocity, which are in the table from a column on; joints on it are stale. */
static void set_motion(tables *t, const operation *o, const double *v)
{
    int64_t row = (intptr_t)o->three, joint;
    gz_disturb(t->context);
    (*(add_efforts **)&o->two)(o->result, v[0], v[1], v[2]);
    gz_wake(o->result, 0);
    memcpy(t->body_state + 16 * row + o->type, v, 3 * sizeof *v);
    for (joint = 0; joint < t->joint_size; joint++)
        if (t->joints[joint] && gz_is_on(t->joints[joint], o->result))
            t->joint_fresh[joint] = 0;
    t->touched = 1;
}

/* Do an operation; 0 if Python has to do the law. */
static int operate(tables *t, const clock_record *clock, const operation *o, char *memory)
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
    case BODY:
        return o->one && t->bodies[row] == o->one;
    case JOINT:
        return o->one && t->joints[row] == o->one;
    case BODY_STATE:
        if (!o->one || t->bodies[row] != o->one)
            return 0;
        memcpy(r, fresh_body(t, row), 16 * sizeof(double));
        break;
    case JOINT_STATE:
        if (!o->one || t->joints[row] != o->one)
            return 0;
        memcpy(r, fresh_joint(t, row), 4 * sizeof(double));
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
    case ACOS:
        UNLESS(x < -1.0 || x > 1.0)
        EACH(acos(x));
    case ATAN: EACH(atan(x));
    case ATAN2: EACH_PAIR(atan2(x, y));
    case HYPOT: EACH_PAIR(sqrt(x * x + y * y)); /* hypot() of new libraries is not in older ones */
    case FMOD:
        UNLESS_PAIR(y == 0.0 || isinf(x))
        EACH_PAIR(fmod(x, y));
    case FLOOR: /* an int in Python */
        UNLESS(!isfinite(x))
        EACH(floor(x));
    case COPYSIGN: EACH_PAIR(copysign(x, y));
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
        if (o->count == 6)
            (*(add_effort_at **)&o->two)(o->result, one[0], one[1], one[2], one[3], one[4], one[5]);
        else
            (*(add_efforts **)&o->two)(o->result, one[0], one[1], one[2]);
        gz_wake(o->result, 0);
        break;
    case VELOCITY:
        set_motion(t, o, one);
        break;
    case WAKE:
        gz_disturb(t->context);
        gz_wake(o->result, o->type);
        break;
    case NOTE:
        gz_note_effort(t->context, o->result, o->type, *one);
        break;
    case APPEND: /* bytes, `count` of them, to others from a place on; that they fit was required before */
        memcpy((char *)o->two + (int64_t)*three, o->one, (size_t)o->count);
        break;
    }
    return 1;
}

/* The operation for which Python has to do the law, or NULL. Those that have effects come last: none has been done then. */
static const operation *compute(tables *t, const clock_record *clock, const law *l, char *memory)
{
    const operation *o = l->operations, *end = o + l->count;
    for (; o < end; o++) {
        if (o->code == END && *(const double *)o->one != 0.0)
            break;
        if (!operate(t, clock, o, memory))
            return o;
    }
    return NULL;
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

/* Whether nothing is to be done: there are conditions alone, and those hold. To see that takes no lock, whose two system
 * calls are a third of the cost of a step at rest; what is being written now is seen in the next step. */
static int is_quiet(tables *t, const clock_record *clock, const law *l)
{
    int64_t i;
    for (i = 0; i < l->count; i++)
        if (l->operations[i].code != REQUIRE && l->operations[i].code != SWITCH)
            return 0;
    return may_peek(l->link) && !compute(t, clock, l, l->link->memory);
}

static const int RESTORATIONS = 8; /* in one exchange: a client may overwrite commands while they are compared */

/* Do a law, under the lock of its interface if it has one. */
int obey(tables *t, const clock_record *clock, const law *l)
{
    link_record *link = l->link;
    const operation *unmet;
    int left = RESTORATIONS;
    if (!link)
        return !compute(t, clock, l, NULL);
    if (is_left_out(l) || is_quiet(t, clock, l))
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
