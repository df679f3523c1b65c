/* The contacts of bodies of which none slides, in closed form: see resting.c. */

#ifndef LIBGZ_ODE_RESTING_H
#define LIBGZ_ODE_RESTING_H

#include <stdint.h>

enum { MOTIONS = 6, DIRECTIONS = 3 }; /* linear and angular; normal, and two of friction */

typedef struct {
    double mass;               /* [kg] */
    double inertia[3][3];      /* [kg m^2] about the centre of mass, global */
    double momentum[MOTIONS];  /* that it would have without contacts: linear [kg m/s], angular [kg m^2/s] */
    double impulse[MOTIONS];   /* out: of its contacts */
    int64_t nearest;           /* of the bodies that it touches, and itself, the first one */
} resting_body;

typedef struct {
    int64_t body[2];                       /* indices; -1: the world */
    double rows[2][DIRECTIONS][MOTIONS];   /* velocity at the point per motion of either body */
    double aim;                            /* [m/s] at which the bodies are to separate */
    double softness[DIRECTIONS];           /* velocity that an impulse leaves uncorrected [1/kg] */
    double slack[DIRECTIONS];              /* [1/kg] that is added, and corrected by repetition */
    double mu[2];                          /* of friction */
    double weight[DIRECTIONS];             /* inverse of softness and slack; 0 without friction */
    double impulse[DIRECTIONS];            /* out [N s] */
    int active;
} resting_point;

/* What is kept from one island to the next; zeros at first. */
typedef struct {
    double *factor, *solution;
    int64_t *starts; /* of the factor's rows */
    int64_t factor_capacity, solution_capacity, starts_capacity;
} resting_memory;

int gz_solve_resting(resting_memory *memory, resting_body *bodies, int64_t body_count, resting_point *points,
                     int64_t point_count);
void gz_free_resting(resting_memory *memory);

#endif
