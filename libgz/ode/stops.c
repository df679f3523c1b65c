/* Joints far beyond a stop, as robots have that begin outside their limits.
 *
 * ODE sends such a joint back at erp times the way per step, and it keeps that speed. Gazebo moves it as far, but where that
 * speed is above contact_max_correcting_vel, it gives the joint this one from a lower stop, and none from an upper one. So a
 * step is solved twice here: poses are those of ODE, velocities those of stops that send back so. Two stops at one place are
 * a spring, and are left to ODE. */
#include "memory.h"
#include "step.h"

#include <math.h>
#include <string.h>

enum { LOW_STOP = 0, HIGH_STOP = 1, STOP_ERP = 9 }; /* dParamLoStop, dParamHiStop, dParamStopERP */
enum { SECOND = 0x100 };                            /* dParamGroup2 */
#define SLIGHT 1e-9 /* [m/s] or [rad/s], up to which joints need no second solution: what rests on its stop has none */

static double stop_number(void *joint, int64_t type, int number)
{
    if (type == JOINT_SLIDER)
        return dJointGetSliderParam(joint, number);
    return type == JOINT_HINGE ? dJointGetHingeParam(joint, number) : dJointGetUniversalParam(joint, number);
}

static void set_erp(const far_stop *s, double erp)
{
    if (s->type == JOINT_SLIDER)
        dJointSetSliderParam(s->joint, STOP_ERP, erp);
    else if (s->type == JOINT_HINGE)
        dJointSetHingeParam(s->joint, STOP_ERP, erp);
    else
        dJointSetUniversalParam(s->joint, s->axis + STOP_ERP, erp);
}

/* Where a joint is, as its stops count it. ODE turns the angles of hinges whose first body is the world, and not their
 * stops. */
static double place_of(void *joint, int64_t type, int axis)
{
    if (type == JOINT_SLIDER)
        return dJointGetSliderPosition(joint);
    if (type == JOINT_UNIVERSAL)
        return axis ? dJointGetUniversalAngle2(joint) : dJointGetUniversalAngle1(joint);
    return dJointGetBody(joint, 0) ? dJointGetHingeAngle(joint) : -dJointGetHingeAngle(joint);
}

/* The way to the stop that a joint is beyond [rad] or [m]: positive to the lower one, negative to the upper one. */
static double way_back(void *joint, int64_t type, int axis)
{
    double low = stop_number(joint, type, axis + LOW_STOP), high = stop_number(joint, type, axis + HIGH_STOP), at;
    if (!(low < high) || (isinf(low) && isinf(high)))
        return 0.0;
    at = place_of(joint, type, axis);
    return at < low ? low - at : at > high ? high - at : 0.0;
}

/* Note an axis that would be sent back too fast. Without memory it is not noted. */
static void note_far_stop(context *c, void *joint, int64_t type, int axis, double fastest)
{
    struct workspace *w = c->work;
    double way = way_back(joint, type, axis), erp;
    far_stop *grown;
    if (way == 0.0)
        return;
    erp = stop_number(joint, type, axis + STOP_ERP);
    if (!(erp * fabs(way) > larger(fastest, SLIGHT) * c->step))
        return;
    grown = enlarged(w->stops, &w->stop_capacity, w->stop_count + 1, sizeof *grown);
    if (!grown)
        return;
    w->stops = grown;
    w->stops[w->stop_count++] = (far_stop){joint, type, axis, erp, larger(0.0, fastest * c->step / way)};
}

/* Find the joints that would be sent back too fast. Universal joints whose first body is the world are left to ODE. */
static int64_t find_far_stops(context *c)
{
    struct workspace *w = c->work;
    double fastest = dWorldGetContactMaxCorrectingVel(c->world);
    int64_t i;
    w->stop_count = 0;
    if (!isfinite(fastest))
        return 0;
    for (i = 0; i < c->joint_count; i++) {
        void *joint = c->joints[i];
        int64_t type = c->joint_types[i];
        int two = type == JOINT_UNIVERSAL;
        if (!joint || (two && !dJointGetBody(joint, 0)))
            continue;
        if (two || type == JOINT_SLIDER || type == JOINT_HINGE)
            note_far_stop(c, joint, type, 0, fastest);
        if (two)
            note_far_stop(c, joint, type, SECOND, fastest);
    }
    return w->stop_count;
}

/* Give stops their numbers back; after a step in which the process forked, only joints in the tables are surely there. */
void restore_stops(context *c)
{
    struct workspace *w = c->work;
    int64_t i, k;
    for (i = 0; i < w->stop_count; i++)
        for (k = 0; k < c->joint_count; k++)
            if (c->joints[k] == w->stops[i].joint)
                set_erp(w->stops + i, w->stops[i].erp);
    w->stop_count = 0;
}

static void set_pose(void *body, const kept_body *k)
{
    dBodySetPosition(body, k->position[0], k->position[1], k->position[2]);
    dBodySetQuaternion(body, k->quaternion);
}

/* Note all bodies; 0 without memory. */
static int keep_bodies(context *c)
{
    struct workspace *w = c->work;
    kept_body *grown = enlarged(w->kept_bodies, &w->kept_capacity, c->body_count, sizeof *grown);
    int64_t i;
    if (!grown)
        return 0;
    w->kept_bodies = grown;
    for (i = 0; i < c->body_count; i++) {
        kept_body *k = w->kept_bodies + i;
        void *body = c->bodies[i];
        if (!body)
            continue;
        memcpy(k->position, dBodyGetPosition(body), sizeof k->position);
        memcpy(k->quaternion, dBodyGetQuaternion(body), sizeof k->quaternion);
        memcpy(k->linear, dBodyGetLinearVel(body), sizeof k->linear);
        memcpy(k->angular, dBodyGetAngularVel(body), sizeof k->angular);
        memcpy(k->force, dBodyGetForce(body), sizeof k->force);
        memcpy(k->torque, dBodyGetTorque(body), sizeof k->torque);
    }
    return 1;
}

/* Bring all bodies back to where they were, and note where they had come. */
static void begin_again(context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        kept_body *k = c->work->kept_bodies + i, before = *k;
        void *body = c->bodies[i];
        if (!body)
            continue;
        memcpy(k->position, dBodyGetPosition(body), sizeof k->position);
        memcpy(k->quaternion, dBodyGetQuaternion(body), sizeof k->quaternion);
        set_pose(body, &before);
        dBodySetLinearVel(body, k->linear[0], k->linear[1], k->linear[2]);
        dBodySetAngularVel(body, k->angular[0], k->angular[1], k->angular[2]);
        dBodySetForce(body, k->force[0], k->force[1], k->force[2]);
        dBodySetTorque(body, k->torque[0], k->torque[1], k->torque[2]);
    }
}

/* Move everything; 0 when ODE ran out of memory. */
int move_from_stops(context *c)
{
    int64_t i;
    int done;
    if (!find_far_stops(c) || !keep_bodies(c))
        return move_bodies(c);
    done = move_bodies(c);
    release_trees(c);
    begin_again(c);
    for (i = 0; i < c->work->stop_count; i++)
        set_erp(c->work->stops + i, c->work->stops[i].slow);
    done = move_bodies(c) && done;
    restore_stops(c);
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i])
            set_pose(c->bodies[i], c->work->kept_bodies + i);
    return done;
}
