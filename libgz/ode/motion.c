/* What moves: states of bodies and joints in the tables, here and in other processes; springs; bodies that diverged.
 *
 * A spring applies k (reference - q) - d q'. ODE has angles within -pi to pi; turns are counted on from the table. */
#include "step.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* A body beyond these has diverged. */
#define MAX_SPEED 1e7      /* [m/s] and [rad/s], before a step */
#define MAX_EFFORT 1e12    /* [N] and [N m], before a step */
#define DIVERGED_SPEED 2e9 /* [m/s] and [rad/s], after a step */
#define TURN 6.2831853071795862 /* 2 pi */

enum { MOTION_COLUMNS = 13 };

/* Wake a body: one that may sleep, or any. */
void gz_wake(void *body, int always)
{
    if (always || dBodyGetAutoDisableFlag(body))
        dBodyEnable(body);
}

enum { MOST_AXES = 2 };

/* The begin of JointRecord in joint_record.py. */
typedef struct {
    double applied[MOST_AXES];
    int64_t applied_at;
    double before[MOST_AXES];
    int64_t before_at;
} effort_record;

/* Note an effort on an axis in this step; those of one step add up. */
void gz_note_effort(const context *c, effort_record *r, int axis, double effort)
{
    if (r->applied_at != c->steps) {
        memcpy(r->before, r->applied, sizeof r->before);
        r->before_at = r->applied_at;
        memset(r->applied, 0, sizeof r->applied);
        r->applied_at = c->steps;
    }
    r->applied[axis] += effort;
}

/* Whether a joint is on a body. */
int gz_is_on(void *joint, void *body) { return dJointGetBody(joint, 0) == body || dJointGetBody(joint, 1) == body; }

/* Whether a number diverged: it is NaN, or beyond twice what may be set (check.py). */
static int is_beyond(double value, double most)
{
    return !(value >= -most && value <= most);
}

static inline void read_body(const context *c, int64_t i, double *row)
{
    void *body = c->bodies[i];
    const double *p = dBodyGetPosition(body), *q = dBodyGetQuaternion(body);
    const double *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    double offset[3];
    int k;
    rotate(q, c->com + 3 * i, offset);
    for (k = 0; k < 3; k++) {
        row[k] = p[k] - offset[k];
        row[7 + k] = p[k];
        row[10 + k] = v[k];
        row[13 + k] = w[k];
    }
    for (k = 0; k < 4; k++)
        row[3 + k] = q[k];
}

/* Copy the state of one body to its row. */
void gz_read_body(context *c, int64_t i) { read_body(c, i, c->body_state + 16 * i); }

/* Copy the states of all bodies to a table; returns how many of them diverged. After a step, find the accelerations in
 * it, where motion is recorded. */
int64_t read_bodies(const context *c, double *state, int stepped)
{
    int64_t i, diverged = 0;
    int k;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        double *row = state + 16 * i;
        double *motion = c->body_motion + MOTION_COLUMNS * i; /* velocities so far, from begin_motion */
        const double *v = row + 10, *w = row + 13;
        int beyond = 0;
        if (!body)
            continue;
        read_body(c, i, row);
        for (k = 0; k < 3; k++) {
            beyond |= is_beyond(row[7 + k], c->max_distance);
            beyond |= is_beyond(v[k], DIVERGED_SPEED) | is_beyond(w[k], DIVERGED_SPEED);
        }
        for (k = 0; stepped && c->record_motion && k < 3; k++) {
            motion[k] = (v[k] - motion[k]) / c->step;
            motion[3 + k] = (w[k] - motion[3 + k]) / c->step;
        }
        diverged += beyond;
    }
    return diverged;
}

/* The angle that is nearest to the one before, so that joints count their turns. ODE's is within -pi to pi. */
static double unwind(const context *c, double before, double angle)
{
    double turns = (before - angle) / TURN;
    return c->count_turns && isfinite(turns) ? angle + TURN * rint(turns) : angle;
}

/* Apply the springs and dampers of hinges and sliders for the coming step. */
void apply_springs(context *c)
{
    int64_t i;
    for (i = 0; i < c->joint_count; i++) {
        void *joint = c->joints[i];
        const double *s = c->springs + 3 * i;
        double at;
        if (!joint || (s[0] == 0.0 && s[1] == 0.0))
            continue;
        if (c->joint_types[i] == JOINT_HINGE) {
            at = unwind(c, c->joint_state[4 * i], dJointGetHingeAngle(joint));
            dJointAddHingeTorque(joint, s[0] * (s[2] - at) - s[1] * dJointGetHingeAngleRate(joint));
        } else if (c->joint_types[i] == JOINT_SLIDER) {
            at = dJointGetSliderPosition(joint);
            dJointAddSliderForce(joint, s[0] * (s[2] - at) - s[1] * dJointGetSliderPositionRate(joint));
        }
    }
}

/* Copy the state of a joint to a row; turns are counted on from those of the own table. */
static void read_joint(const context *c, int64_t i, double *row)
{
    void *joint = c->joints[i];
    const double *before = c->joint_state + 4 * i;
    if (!joint)
        return;
    switch (c->joint_types[i]) {
    case JOINT_HINGE:
        row[0] = unwind(c, before[0], dJointGetHingeAngle(joint));
        row[2] = dJointGetHingeAngleRate(joint);
        break;
    case JOINT_SLIDER:
        row[0] = dJointGetSliderPosition(joint);
        row[2] = dJointGetSliderPositionRate(joint);
        break;
    case JOINT_HINGE2:
        row[0] = unwind(c, before[0], dJointGetHinge2Angle1(joint));
        row[1] = unwind(c, before[1], dJointGetHinge2Angle2(joint));
        row[2] = dJointGetHinge2Angle1Rate(joint);
        row[3] = dJointGetHinge2Angle2Rate(joint);
        break;
    case JOINT_UNIVERSAL:
        row[0] = unwind(c, before[0], dJointGetUniversalAngle1(joint));
        row[1] = unwind(c, before[1], dJointGetUniversalAngle2(joint));
        row[2] = dJointGetUniversalAngle1Rate(joint);
        row[3] = dJointGetUniversalAngle2Rate(joint);
        break;
    case JOINT_PISTON:
        row[0] = unwind(c, before[0], dJointGetPistonAngle(joint));
        row[1] = dJointGetPistonPosition(joint);
        row[2] = dJointGetPistonAngleRate(joint);
        row[3] = dJointGetPistonPositionRate(joint);
        break;
    }
}

/* Copy the states of all joints to a table. */
void read_joints(const context *c, double *state)
{
    int64_t i;
    for (i = 0; i < c->joint_count; i++)
        read_joint(c, i, state + 4 * i);
}

void gz_read_joint(context *c, int64_t i) { read_joint(c, i, c->joint_state + 4 * i); }

static int is_within(const double *v, double most)
{
    return fabs(v[0]) <= most && fabs(v[1]) <= most && fabs(v[2]) <= most;
}

/* Record velocity and applied efforts of each body where that is on, and reset those of diverged bodies: ODE ends the
 * process on non-finite numbers. */
void begin_motion(context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        double *row = c->body_motion + MOTION_COLUMNS * i;
        const double *v, *w, *force, *torque;
        if (!body)
            continue;
        v = dBodyGetLinearVel(body);
        w = dBodyGetAngularVel(body);
        force = dBodyGetForce(body);
        torque = dBodyGetTorque(body);
        if (!(is_within(v, MAX_SPEED) && is_within(w, MAX_SPEED) && is_within(force, MAX_EFFORT) &&
              is_within(torque, MAX_EFFORT))) {
            dBodySetLinearVel(body, 0.0, 0.0, 0.0);
            dBodySetAngularVel(body, 0.0, 0.0, 0.0);
            dBodySetForce(body, 0.0, 0.0, 0.0);
            dBodySetTorque(body, 0.0, 0.0, 0.0);
            c->reset_row = i + 1;
        }
        if (!c->record_motion)
            continue;
        memcpy(row, v, 3 * sizeof(double)); /* the addresses are those of ODE's own numbers */
        memcpy(row + 3, w, 3 * sizeof(double));
        memcpy(row + 6, force, 3 * sizeof(double));
        memcpy(row + 9, torque, 3 * sizeof(double));
        row[12] = dBodyGetGravityMode(body) && !dBodyIsKinematic(body) ? 1.0 : 0.0;
    }
}

/* Add the gyroscopic torque -w x I w of the step's begin to bodies that are awake, as Gazebo's copy of ODE does. */
void add_gyroscopic_torques(context *c)
{
    int64_t i;
    int k;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        const double *r, *w, *torque;
        double own[3], moment[3], global[3], gyroscopic[3];
        body_mass m;
        if (!body || !dBodyIsEnabled(body) || dBodyIsKinematic(body))
            continue;
        r = dBodyGetRotation(body);
        w = dBodyGetAngularVel(body);
        torque = dBodyGetTorque(body);
        dBodyGetMass(body, &m);
        for (k = 0; k < 3; k++)
            own[k] = r[k] * w[0] + r[4 + k] * w[1] + r[8 + k] * w[2];
        for (k = 0; k < 3; k++)
            moment[k] = dot(m.inertia + 4 * k, own);
        for (k = 0; k < 3; k++)
            global[k] = dot(r + 4 * k, moment);
        cross(w, global, gyroscopic);
        dBodySetTorque(body, torque[0] - gyroscopic[0], torque[1] - gyroscopic[1], torque[2] - gyroscopic[2]);
    }
}

void gz_read(context *c)
{
    c->diverged = read_bodies(c, c->body_state, 0);
    read_joints(c, c->joint_state);
}

/* Positions, 3 a row, and rotations, 4 a row, as frames: 7 a row, with rotations of length 1. 0: a coordinate is beyond `most`,
 * or a rotation's length is far from 1. */
int gz_frames(int64_t count, const double *positions, const double *turns, double most, double *frames)
{
    int64_t i;
    int k;
    for (i = 0; i < count; i++, positions += 3, turns += 4, frames += 7) {
        double length = sqrt(turns[0] * turns[0] + turns[1] * turns[1] + turns[2] * turns[2] + turns[3] * turns[3]);
        if (!is_within(positions, most) || !(length > 0.5 && length < 2.0))
            return 0;
        memcpy(frames, positions, 3 * sizeof *frames);
        for (k = 0; k < 4; k++)
            frames[3 + k] = turns[k] / length;
    }
    return 1;
}

/* Put geoms without bodies at rows of such frames. */
void gz_place(void *const *geoms, const int64_t *rows, int64_t count, const double *frames)
{
    int64_t i;
    for (i = 0; i < count; i++) {
        const double *frame = frames + 7 * rows[i];
        dGeomSetPosition(geoms[i], frame[0], frame[1], frame[2]);
        dGeomSetQuaternion(geoms[i], frame + 3);
    }
}

/* Mirrored by Publication in context.py. */
typedef struct {
    char *target;             /* the mapped file */
    char *header;             /* what its first bytes are to be; they hold the sequence counter */
    int64_t header_size, sequence_offset, bodies_offset, joints_offset, fixed_offset;
    const double *fixed;      /* rows of bodies that ODE does not move, which follow the others */
    int64_t fixed_size;       /* [byte] */
    int64_t stale;            /* 1: some rows of the own tables are stale, so ODE is asked for all */
    int64_t copied;           /* 1: the tables there are those of a world at rest */
} publication;

/* Copy header and tables out. The counter is odd meanwhile. Own tables stay as they are, and nothing is read back. */
void gz_publish(const context *c, publication *p)
{
    uint64_t *own = (uint64_t *)(p->header + p->sequence_offset);
    _Atomic uint64_t *shared = (_Atomic uint64_t *)(p->target + p->sequence_offset);
    double *bodies = (double *)(p->target + p->bodies_offset), *joints = (double *)(p->target + p->joints_offset);
    atomic_store_explicit(shared, ++*own, memory_order_relaxed);
    atomic_thread_fence(memory_order_release);
    memcpy(p->target, p->header, (size_t)p->header_size);
    if (p->stale) {
        read_bodies(c, bodies, 0);
        read_joints(c, joints);
        p->copied = 0;
    } else if (c->resting < RESTING || !p->copied) {
        memcpy(bodies, c->body_state, (size_t)c->body_count * 16 * sizeof(double));
        memcpy(joints, c->joint_state, (size_t)c->joint_count * 4 * sizeof(double));
        p->copied = c->resting == RESTING;
    }
    memcpy(p->target + p->fixed_offset, p->fixed, (size_t)p->fixed_size);
    atomic_store_explicit(shared, ++*own, memory_order_release);
}
