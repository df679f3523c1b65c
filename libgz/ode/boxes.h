/* Small dense problems with bounds: see boxes.c. */

#ifndef LIBGZ_ODE_BOXES_H
#define LIBGZ_ODE_BOXES_H

#include <stdint.h>

enum { FREE, LOW, HIGH }; /* where an unknown is */

/* A x = b where lower < x < upper; elsewhere A x >= b at the lower bound, and A x <= b at the upper one. */
typedef struct {
    int64_t count;
    const double *matrix; /* symmetric and positive, both triangles */
    const double *right, *lower, *upper;
    int64_t *place;  /* FREE, LOW or HIGH: where each unknown is */
    int64_t *listed; /* count numbers for its use */
    double *result;
    double *scratch; /* count * (count + 3) numbers */
} box_problem;

#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

/* 0 if it does not come to an end soon. */
int solve_box(box_problem *p);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
