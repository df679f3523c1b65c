/* An island, as islands of joints are described (tree_island.c) and solved (tree.c). */

#ifndef LIBGZ_ODE_TREE_H
#define LIBGZ_ODE_TREE_H

#include "memory.h"
#include "step.h"

enum { MOST_ROWS = 6 };    /* of a joint, and as many as the motions of a body; loops have this constant length */

typedef struct {
    void *body;
    int64_t parent, joint; /* towards the root: -1 for the world, or none */
    int64_t first;         /* of its joints, -1: none */
    int64_t degree;        /* joints that may be part of the tree; -1: the body is in the tree */
    int64_t rank;          /* in the order from the root on */
    int64_t met;           /* the last station at the body, -1: none */
    double applied[MOTIONS]; /* force and torque before the island was described */
    double factor[MOTIONS][MOTIONS]; /* of the inertia of the body and all beyond it, lower triangle */
    double load[MOTIONS];            /* momentum, then solved forward */
    double velocity[MOTIONS], effort[MOTIONS];
} tree_body;

typedef struct {
    void *joint;
    int64_t body[2]; /* -1: none that moves */
    int64_t next[2]; /* joint of those bodies, -1: none */
    int64_t first;   /* of its rows */
    int rows, free;  /* free: those without bounds, which come first */
    int side;        /* of the body that it leads to the root, -1: it is no part of the tree */
    double factor[MOST_ROWS][MOST_ROWS], child[MOST_ROWS][MOTIONS], parent[MOST_ROWS][MOTIONS];
    double load[MOST_ROWS];
} tree_joint;

typedef struct {
    int64_t joint;
    double line[2][MOTIONS];
    double aim, softness, low, high;
    int64_t normal; /* the row whose impulse scales the bounds, -1: none */
    int64_t place;  /* in the dense problem, unless it is part of the tree */
    double impulse;
} tree_row;

/* A row of the dense problem, solved forward: what it is at a body of its path to the root, and at the joint there. */
typedef struct {
    int64_t row, at;  /* of the dense problem; the body */
    int64_t previous; /* station at the body, of an earlier row; -1: none */
    double body[MOTIONS], joint[MOST_ROWS];
} station;

/* The island that is being solved, and joints that have no part in ODE's step. */
struct trees {
    tree_body *bodies;
    tree_joint *joints;
    tree_row *rows;
    int64_t *order;      /* bodies from the root on */
    int64_t *dense;      /* rows of the dense problem */
    int64_t *places;     /* where its unknowns are */
    station *stations;   /* row by row */
    double *numbers;     /* of the dense problem */
    int64_t body_capacity, joint_capacity, row_capacity, order_capacity, dense_capacity, place_capacity, station_capacity;
    int64_t number_capacity;
    int64_t body_count, joint_count, row_count, order_count, dense_count, station_count;
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
