/* What a crew does: see crew.c. */

#ifndef LIBGZ_ODE_CREW_H
#define LIBGZ_ODE_CREW_H

#include <stdint.h>

/* JobRecord in records.py: the rows of a world. */
typedef struct job {
    const void *updates;
    int64_t count;  /* of the rows */
    int64_t *steps; /* to do; out: those that are left */
    double seconds; /* after which it ends */
    int64_t row;    /* out: that Python has to do, or `count` */
    struct job *next;
} job;

#endif
