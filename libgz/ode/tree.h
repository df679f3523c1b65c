/* An island, as islands of joints are described (tree_island.c) and solved (tree.c). */

#ifndef LIBGZ_ODE_TREE_H
#define LIBGZ_ODE_TREE_H

#include "memory.h"
#include "step.h"

#include <math.h>

enum { MOST_ROWS = 6 };    /* of a joint, and as many as the motions of a body; loops have this constant length */
enum { LANES = 4 };        /* rows of the dense problem that are carried along their path together */

typedef struct {
    void *body;
    int64_t parent, joint; /* towards the root: -1 for the world, or none */
    int64_t first;         /* of its joints, -1: none */
    int64_t degree;        /* joints that may be part of the tree; -1: the body is in the tree */
    int64_t rank;          /* in the order from the root on */
    int64_t met;           /* the last station at the body, -1: none */
    double applied[MOTIONS]; /* force and torque before the island was described */
    double mass, inertia[3][3];
    double momentum[MOTIONS];        /* without joints, after the step */
    double factor[MOTIONS][MOTIONS]; /* of the inertia of the body and all beyond it, upper triangle */
    double load[MOTIONS];            /* momentum of the same, solved forward */
    double velocity[MOTIONS], effort[MOTIONS];
} tree_body;

typedef struct {
    void *joint;
    int64_t body[2]; /* -1: none that moves */
    int64_t next[2]; /* joint of those bodies, -1: none */
    int64_t first;   /* of its rows */
    int rows;
    int tying;       /* rows that have no bounds: with them the joint may be part of the tree */
    int side;        /* of the body that it leads to the root, -1: it is no part of the tree */
    int held;        /* rows that are part of the tree */
    int64_t row[MOST_ROWS]; /* which */
    double factor[MOST_ROWS][MOST_ROWS]; /* of their matrix, upper triangle */
    double child[MOTIONS][MOST_ROWS], parent[MOST_ROWS][MOTIONS]; /* their lines, solved forward */
    double load[MOST_ROWS], impulse[MOST_ROWS];
} tree_joint;

/* All of it in numbers of eight bytes, for ODE steps over them from row to row. */
typedef struct {
    int64_t joint;
    double line[2][MOTIONS];
    double aim, softness, low, high;
    int64_t normal; /* the row whose impulse scales the bounds, -1: none */
    int64_t place;  /* in the dense problem, unless it is part of the tree */
    int64_t apart;  /* 1: it is no part of the tree */
    double impulse;
} tree_row;

/* Rows of the dense problem that act on the same two bodies. */
typedef struct {
    int64_t first, count; /* at most LANES */
} panel;

/* A panel, solved forward: what its rows are at a body of their path to the root, and at the joint there. */
typedef struct {
    int64_t panel, at;
    int64_t previous; /* station at the body, of an earlier panel; -1: none */
    double body[MOTIONS][LANES], joint[MOST_ROWS][LANES];
} station;

/* The island that is being solved, and joints that have no part in ODE's step. */
struct trees {
    tree_body *bodies;
    tree_joint *joints;
    tree_row *rows;
    int64_t *order;      /* bodies from the root on */
    int64_t *roots;      /* bodies in the order in which they become roots, then what sorts them */
    int64_t *dense;      /* rows of the dense problem */
    int64_t *places;     /* where its unknowns are, and as many for its solver */
    panel *panels;
    station *stations;   /* panel by panel */
    double *numbers;     /* of the dense problem */
    int64_t body_capacity, joint_capacity, row_capacity, order_capacity, dense_capacity, place_capacity, panel_capacity;
    int64_t root_capacity, station_capacity, number_capacity;
    int64_t body_count, joint_count, row_count, order_count, dense_count, panel_count, station_count;
    int guesses;         /* rows with bounds that are part of the tree */
    void **disabled;
    int64_t disabled_count, disabled_capacity;
};

typedef struct trees island;

#define GROW(array, capacity, count)                                                       \
    do {                                                                                   \
        void *grown = enlarged(w->array, &w->capacity, (count), sizeof *w->array);         \
        if (!grown)                                                                        \
            return 0;                                                                      \
        w->array = grown;                                                                  \
    } while (0)

static inline int is_unbounded(const tree_row *r) { return r->low == -HUGE_VAL && r->high == HUGE_VAL; }

#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

/* tree_island.c */
int moves(void *body);
int collect(const context *c, island *w, int64_t row);
int grow_tree(island *w);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
