/* What links.c, laws.c and updates.c share. libgz/base/records.py mirrors the structs; gz_updates_sizes() guards against
 * drift. */
#ifndef GZ_UPDATES_H
#define GZ_UPDATES_H

#include <stdint.h>
#include <time.h>

/* Where states are. The arrays are those of the step; a byte of `fresh` is 1 where a row is up to date. */
typedef struct {
    void *context;
    double step;
    void *const *bodies;
    double *body_state;
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

/* step.c, motion.c, rays.c: exported; the context of a step is opaque here. */
int gz_step(void *context);
void gz_disturb(void *context);
int gz_is_at_rest(const void *context);
void gz_wake(void *body, int always);
void gz_read_body(void *context, int64_t row);
void gz_read_joint(void *context, int64_t row);
void gz_note_effort(void *context, void *efforts, int axis, double effort);
int gz_is_on(void *joint, void *body);
void gz_scan(void *context, const double *frame, const double *rays, int64_t count, int64_t owner, double *ranges,
             int64_t *rows);
void gz_publish(const void *context, void *publication);

#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

static inline double now_monotonic(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Rows, which are read from ODE if they are stale. */
static inline const double *fresh_body(tables *t, int64_t row)
{
    if (!t->body_fresh[row]) {
        gz_read_body(t->context, row);
        t->body_fresh[row] = 1;
    }
    return t->body_state + 16 * row;
}

static inline const double *fresh_joint(tables *t, int64_t row)
{
    if (!t->joint_fresh[row]) {
        gz_read_joint(t->context, row);
        t->joint_fresh[row] = 1;
    }
    return t->joint_state + 4 * row;
}

/* links.c */
int take(link_record *l);
int may_peek(const link_record *l);
void release(link_record *l);
void give_back(link_record *l);
int is_intact(const link_record *l);
int restore(link_record *l);
int is_still_blocked(link_record *l);

/* laws.c */
int obey(tables *t, const clock_record *clock, const law *l);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
