/* What a crew does: see crew.c. */

#ifndef LIBGZ_ODE_CREW_H
#define LIBGZ_ODE_CREW_H

#include <stdint.h>

/* JobRecord in records.py: the rows of a world, and a law that is done when all steps are made. */
typedef struct job {
    const void *updates;
    int64_t count;   /* of the rows */
    int64_t steps;   /* to do; out: those that are left */
    double seconds;  /* after which it ends, without a pace */
    const void *pace; /* when steps after the first one are due: PaceRecord; NULL: at once */
    const void *law; /* NULL: none */
    int64_t row;     /* out: that Python has to do, or `count` */
    int64_t obeyed;  /* out: 1: the law was done */
    struct job *next;
} job;

#endif
