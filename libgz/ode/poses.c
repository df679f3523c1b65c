/* Poses: bodies that are moved as one. Python's forms are GzCoordPoseAdd, GzCoordPoseSub and rotate in geometry.py, whose
 * arithmetic this is, in the same order. */
#define _GNU_SOURCE
#include "step.h"

#include <math.h>
#include <string.h>

#include "updates.h"

typedef struct {
    double at[3], turn[4];
} pose;

static void multiply(const double *a, const double *b, double *result)
{
    result[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    result[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    result[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    result[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

static int may_be(const context *c, const pose *p)
{
    double longest = 0.0;
    int i;
    for (i = 0; i < 3; i++)
        if (!(fabs(p->at[i]) <= 0.5 * c->max_distance))
            return 0;
    for (i = 0; i < 4; i++) {
        if (!(fabs(p->turn[i]) <= 1e150))
            return 0;
        longest = fmax(longest, fabs(p->turn[i]));
    }
    return longest >= 1e-150;
}

/* Put a body at a pose, at rest if wanted, and read it back; joints are stale then. 0, and nothing has changed, if the
 * pose is for Python to refuse. */
static int put(tables *t, int64_t row, const pose *p, int still)
{
    context *c = t->context;
    void *body = c->bodies[row];
    const double *q = p->turn;
    double turn[4], offset[3], length;
    int i;
    if (!may_be(c, p))
        return 0;
    length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (i = 0; i < 4; i++)
        turn[i] = q[i] / length;
    rotate(turn, c->com + 3 * row, offset);
    dBodySetPosition(body, p->at[0] + offset[0], p->at[1] + offset[1], p->at[2] + offset[2]);
    dBodySetQuaternion(body, turn);
    gz_wake(body, 0);
    if (still) {
        dBodySetLinearVel(body, 0.0, 0.0, 0.0);
        dBodySetAngularVel(body, 0.0, 0.0, 0.0);
    }
    gz_disturb(c);
    t->touched = 1;
    memset(t->joint_fresh, 0, (size_t)t->joint_size);
    gz_read_body(c, row);
    t->body_fresh[row] = 1;
    return 1;
}

/* How bodies move; 17 doubles in step.py. */
typedef struct {
    pose from, to;
    double slide[3];
} motion;

/* Turn bodies about a point by a rotation, and slide them, at rest then if wanted; the number of those that were moved: the
 * next one is for Python. */
int64_t gz_turn_bodies(tables *t, const int64_t *rows, int64_t count, const motion *m, int still)
{
    int64_t i;
    int k;
    for (i = 0; i < count; i++) {
        const double *state = fresh_body(t, rows[i]);
        double arm[3], turned[3];
        pose p;
        for (k = 0; k < 3; k++)
            arm[k] = state[k] - m->from.at[k];
        rotate(m->to.turn, arm, turned);
        for (k = 0; k < 3; k++)
            p.at[k] = m->from.at[k] + turned[k] + m->slide[k];
        multiply(m->to.turn, state + 3, p.turn);
        if (!put(t, rows[i], &p, still))
            break;
    }
    return i;
}

/* Move bodies with a frame, from one pose of it to another; the number of those that were moved, likewise. */
int64_t gz_carry_bodies(tables *t, const int64_t *rows, int64_t count, const motion *m, int still)
{
    int64_t i;
    int k;
    for (i = 0; i < count; i++) {
        const double *state = fresh_body(t, rows[i]);
        const double *turn = m->from.turn, back[4] = {turn[0], -turn[1], -turn[2], -turn[3]};
        double arm[3];
        pose relative, p;
        for (k = 0; k < 3; k++)
            arm[k] = state[k] - m->from.at[k];
        rotate(back, arm, relative.at);
        multiply(back, state + 3, relative.turn);
        rotate(m->to.turn, relative.at, arm);
        for (k = 0; k < 3; k++)
            p.at[k] = m->to.at[k] + arm[k];
        multiply(m->to.turn, relative.turn, p.turn);
        if (!put(t, rows[i], &p, still))
            break;
    }
    return i;
}
