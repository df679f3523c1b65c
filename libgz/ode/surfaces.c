/* What a contact is like: made of the surfaces of two geoms, and refined point by point under the classic rule.
 *
 * ODE solves a contact as a spring and damper, erp = h kp / (h kp + kd) and cfm = 1 / (h kp + kd), as its manual has it.
 * The legacy rule is that of the old server; the classic rule has Gazebo's slip, friction directions, torsion, tracks,
 * min_depth and max_vel, and keeps rigid bodies at rest. */
#include "memory.h"
#include "step.h"

#include <math.h>
#include <string.h>

#define SOFT_RATIO 0.25 /* of step^2 kp / mass, up to which a spring is soft: its oscillation takes 12 steps or more */
#define REST_DEPTH 3e-6 /* [m] that rigid contacts keep, so that none is lost from one step to the next */
#define REST_ERP 0.2    /* share of the difference to it that is corrected in a step, at most */
#define REST_CFM 1e-7   /* softness of rigid contacts [s/kg], at least, for a body of 1 kg */
#define SOFTNESS_SPREAD 0.3 /* share by which the softness of rigid contacts differs from place to place */
#define DEPTH_SPREAD 0.05   /* share of REST_DEPTH, per second of a step, by which the depth differs that they keep */
#define CALM_SPEED 0.1    /* [m/s] and [rad/s] of a body, up to which its island may be solved exactly */
#define FALLING_STEPS 2.0 /* and so many steps of falling add to it */
#define FLANK 0.70710678118654752 /* sine of the angle from which ODE takes a normal as upright */
#define STICKING 40.0 /* [m/s^2] at which friction of 1 may stop what touches within one step, so that it sticks */
#define LARGE 1e6         /* [m] beyond which what lies in a hash space counts as infinite */
#define PATCH_LEVER 0.58904862254808621 /* 3 pi / 16: mean lever of friction in a patch under Hertz's pressure */
enum { SMALL_LEVEL = -2, LARGE_LEVEL = 9 }; /* of Gazebo's hash space; the large are in no cell */

/* A contact is a spring and damper in series with its partner: erp = h kp / (h kp + kd), cfm = 1 / (h kp + kd). */
void make_surface(const context *c, const double *a, const double *b, surface_parameters *s)
{
    double softness = 1.0 / a[SURFACE_KP] + 1.0 / b[SURFACE_KP];
    double kd = a[SURFACE_KD] + b[SURFACE_KD];
    memset(s, 0, sizeof *s);
    s->mode = SOFT_ERP | SOFT_CFM | APPROX1;
    s->mu = smaller(a[SURFACE_MU], b[SURFACE_MU]);
    s->soft_erp = 1.0;
    s->soft_cfm = 0.0;
    if (softness > 0.0) {
        double spring = c->step * (1.0 / softness);
        s->soft_erp = spring / (spring + kd);
        s->soft_cfm = 1.0 / (spring + kd);
    }
    s->bounce = larger(a[SURFACE_BOUNCE], b[SURFACE_BOUNCE]);
    s->bounce_vel = 0.0;
    if (c->contact_rule == CLASSIC_RULE) {
        s->bounce = smaller(a[SURFACE_BOUNCE], b[SURFACE_BOUNCE]);
        s->bounce_vel = smaller(a[SURFACE_BOUNCE_VEL], b[SURFACE_BOUNCE_VEL]);
        s->mu2 = smaller(a[SURFACE_MU2], b[SURFACE_MU2]);
        s->mode |= MU2;
    }
    if (s->bounce > 0.0)
        s->mode |= BOUNCE;
}

/* Project a direction onto the contact plane and make it that of friction; 0 if nothing remains of it. */
static int set_friction_direction(contact *point, const double *aim)
{
    const double *n = point->geom.normal;
    double along = dot(aim, n), size;
    int k;
    for (k = 0; k < 3; k++)
        point->fdir1[k] = aim[k] - along * n[k];
    size = sqrt(dot(point->fdir1, point->fdir1));
    if (size < 1e-9)
        return 0;
    for (k = 0; k < 3; k++)
        point->fdir1[k] = point->fdir1[k] / size;
    return 1;
}

/* The rotation of a geom; a plane has none in ODE, and its friction direction is global. */
static const double *rotation_of(void *geom)
{
    static const double none[12] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    return dGeomGetClass(geom) == PLANE_CLASS ? none : dGeomGetRotation(geom);
}

/* The level of a hash space to which what a link has belongs: its extent is between half of 2^level and 2^level. Of a
 * geom without a body, all that its model has. */
static int level_of(const context *c, void *geom)
{
    double box[6], all[6], extent = 0.0;
    void *body = dGeomGetBody(geom), *space = dGeomGetSpace(geom), *part = NULL;
    int level, k;
    if (dGeomGetClass(geom) == PLANE_CLASS)
        return LARGE_LEVEL;
    dGeomGetAABB(body || !space || space == c->space ? geom : space, all);
    if (body)
        part = dBodyGetFirstGeom(body);
    for (; part; part = dBodyGetNextGeom(part)) {
        dGeomGetAABB(part, box);
        for (k = 0; k < 6; k += 2) {
            all[k] = smaller(all[k], box[k]);
            all[k + 1] = larger(all[k + 1], box[k + 1]);
        }
    }
    for (k = 0; k < 6; k += 2)
        extent = larger(extent, all[k + 1] - all[k]);
    if (!(extent < LARGE))
        return LARGE_LEVEL;
    frexp(extent, &level);
    return level < SMALL_LEVEL ? SMALL_LEVEL : level > LARGE_LEVEL ? LARGE_LEVEL : level;
}

/* Whether Gazebo's hash space finds the second geom of a pair first: the one of the lower level, then what does not
 * move, then what was made last. */
static int second_first(const context *c, void *geom1, void *geom2)
{
    void *body1 = dGeomGetBody(geom1), *body2 = dGeomGetBody(geom2);
    int level1 = level_of(c, geom1), level2 = level_of(c, geom2);
    if (level1 != level2)
        return level2 < level1;
    return !body2 || (body1 && c->owner[(intptr_t)dGeomGetData(geom2)] > c->owner[(intptr_t)dGeomGetData(geom1)]);
}

/* Find whose direction is that in which mu applies: as in Gazebo, that of the geom which its hash space finds first. */
void choose_direction(const context *c, touching *t)
{
    const double *one = t->a + SURFACE_FDIR1, *two = t->b + SURFACE_FDIR1;
    t->aim = NULL;
    if (dot(one, one) == 0.0 && dot(two, two) == 0.0)
        return;
    t->aim = one;
    t->aiming = t->geom1;
    if (second_first(c, t->geom1, t->geom2)) {
        t->aim = two;
        t->aiming = t->geom2;
    }
    if (dot(t->aim, t->aim) == 0.0)
        t->aim = NULL;
}

/* The direction in which mu applies; 0: there is none. */
static int friction_direction(const touching *t, contact *point)
{
    double aim[3];
    if (!t->aim)
        return 0;
    to_global(rotation_of(t->aiming), t->aim, aim);
    return set_friction_direction(point, aim);
}

/* The direction in which the surface of a track runs at a contact whose normal points out of it; 0: it has none. */
static int track_direction(const double *row, void *geom, const double *normal, double sign, double *way)
{
    double axis[3], size;
    int k;
    to_global(rotation_of(geom), row + SURFACE_FDIR1, axis);
    cross(axis, normal, way);
    size = sqrt(dot(way, way));
    if (size < 1e-9)
        return 0;
    for (k = 0; k < 3; k++)
        way[k] = sign * way[k] / size;
    return 1;
}

/* Friction on a surface that runs: mu acts along the way of the track, or round the pivot, and mu2 across. */
static int set_track(const double *a, const double *b, void *geom1, void *geom2, contact *point)
{
    const double *n = point->geom.normal, *pivot = NULL, *rows[2];
    double way[3], motion[3] = {0.0, 0.0, 0.0}, arm[3], aim[3], first, sign;
    void *geoms[2];
    int found = 0, i, k;
    rows[0] = a, rows[1] = b, geoms[0] = geom1, geoms[1] = geom2;
    first = dGeomGetBody(geom1) ? 1.0 : -1.0; /* the joint measures velocities of its first body against the other */
    for (i = 0; i < 2; i++) {
        sign = i ? 1.0 : -1.0; /* the normal points into geom 1 */
        if (rows[i][SURFACE_TRACK] == 0.0 || !track_direction(rows[i], geoms[i], n, sign, way))
            continue;
        if (rows[i][SURFACE_TRACK] == 2.0)
            pivot = rows[i] + SURFACE_PIVOT;
        for (k = 0; k < 3; k++) {
            motion[k] = motion[k] + first * sign * rows[i][SURFACE_TRACK_SPEED] * way[k];
            if (!found)
                point->fdir1[k] = way[k];
        }
        found = 1;
    }
    if (!found)
        return 0;
    if (pivot) {
        for (k = 0; k < 3; k++)
            arm[k] = point->geom.pos[k] - pivot[k];
        cross(n, arm, aim);
        memcpy(way, point->fdir1, sizeof way);
        if (!set_friction_direction(point, aim)) /* the pivot itself */
            memcpy(point->fdir1, way, sizeof way);
    }
    point->surface.motion1 = dot(motion, point->fdir1);
    point->surface.mode |= FDIR1 | MOTION1;
    return 1;
}

/* Velocity of a body at a point at the end of the step if nothing but gravity acts, added with a sign. */
static void add_velocity(const context *c, void *body, const double *at, double sign, double *sum)
{
    const double *x, *v, *w;
    double arm[3], spin[3], share;
    int k;
    if (!body)
        return;
    x = dBodyGetPosition(body);
    v = dBodyGetLinearVel(body);
    w = dBodyGetAngularVel(body);
    share = dBodyGetGravityMode(body) && !dBodyIsKinematic(body) ? c->step : 0.0;
    for (k = 0; k < 3; k++)
        arm[k] = at[k] - x[k];
    cross(w, arm, spin);
    for (k = 0; k < 3; k++)
        sum[k] = sum[k] + sign * (v[k] + spin[k] + share * c->gravity[k]);
}

/* ODE's own choice of the direction at right angles to a normal in which mu acts. */
void default_direction(const double *n, double *one)
{
    double k;
    if (fabs(n[2]) > FLANK) {
        k = 1.0 / sqrt(n[1] * n[1] + n[2] * n[2]);
        one[0] = 0.0, one[1] = -n[2] * k, one[2] = n[1] * k;
    } else {
        k = 1.0 / sqrt(n[0] * n[0] + n[1] * n[1]);
        one[0] = -n[1] * k, one[1] = n[0] * k, one[2] = 0.0;
    }
}

/* Friction as in a cone: against the sliding velocity v, with mu v1 / |v| along the first direction and mu2 v2 / |v| along
 * the second. What already slides has no friction across that: else a force across would be resisted as if it stuck, and
 * skidding wheels would not turn. `aimed`: the contact has a first direction. */
static void set_cone(const context *c, const touching *t, contact *point, int aimed)
{
    surface_parameters *s = &point->surface;
    const double *n = point->geom.normal;
    double slide[3] = {0.0, 0.0, 0.0}, one[3], two[3], along, across, size, mu;
    int k;
    if (!(s->mu < HUGE_VAL && s->mu2 < HUGE_VAL))
        return;
    add_velocity(c, t->body1, point->geom.pos, 1.0, slide);
    add_velocity(c, t->body2, point->geom.pos, -1.0, slide);
    if (aimed)
        memcpy(one, point->fdir1, sizeof one);
    else
        default_direction(n, one);
    cross(n, one, two);
    along = dot(slide, one);
    across = dot(slide, two);
    size = sqrt(along * along + across * across);
    if (size < 1e-9)
        return;
    along = s->mu * along / size;
    across = s->mu2 * across / size;
    mu = sqrt(along * along + across * across);
    if (!(mu > 0.0))
        return;
    for (k = 0; k < 3; k++)
        point->fdir1[k] = (along * one[k] + across * two[k]) / mu;
    s->mu = mu;
    s->mu2 = size > c->step * (STICKING * mu) ? 0.0 : mu;
    s->mode |= FDIR1;
}

/* Torsion: a torque about the normal of at most mu 3 pi / 16 times the radius of the patch times the normal force. */
static void add_torsion(const double *a, const double *b, contact *point)
{
    double lever = larger(a[SURFACE_PATCH_RADIUS], b[SURFACE_PATCH_RADIUS]), bend = 0.0;
    if (a[SURFACE_BY_PATCH] == 0.0 || b[SURFACE_BY_PATCH] == 0.0) {
        if (a[SURFACE_RADIUS] > 0.0)
            bend = bend + 1.0 / a[SURFACE_RADIUS];
        if (b[SURFACE_RADIUS] > 0.0)
            bend = bend + 1.0 / b[SURFACE_RADIUS];
        lever = bend > 0.0 && point->geom.depth > 0.0 ? sqrt(point->geom.depth / bend) : 0.0;
    }
    if (!(lever > 0.0))
        return;
    lever = PATCH_LEVER * lever * smaller(a[SURFACE_TORSION], b[SURFACE_TORSION]);
    if (!(lever > 0.0))
        return;
    point->surface.mode |= ROLLING | APPROX1_N;
    point->surface.rho = point->surface.rho2 = -1.0; /* 0 would cost rows of the solver */
    point->surface.rhoN = lever;
}

/* max_vel and min_depth of a pair: the smaller of both bodies'. A geom without a body has no influence. */
static double of_bodies(const touching *t, int column)
{
    if (!t->body1)
        return t->b[column];
    return t->body2 ? smaller(t->a[column], t->b[column]) : t->a[column];
}

void set_limits(const context *c, touching *t)
{
    /* Geoms of legacy models have no limit; their contacts are so soft that with one they would sink into the other. */
    int limited = t->a[SURFACE_MAX_VEL] < HUGE_VAL && t->b[SURFACE_MAX_VEL] < HUGE_VAL;
    t->max_vel = t->body1 && t->body2 && !limited ? HUGE_VAL : of_bodies(t, SURFACE_MAX_VEL);
    t->min_depth = of_bodies(t, SURFACE_MIN_DEPTH);
}

/* Find the bodies that a joint connects with the world, for the search of contacts. */
void find_held(const context *c)
{
    int64_t i;
    char *held = enlarged(c->work->held, &c->work->held_capacity, c->body_count, 1);
    if (!held)
        return;
    c->work->held = held;
    memset(held, 0, (size_t)c->body_count);
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i]) {
            void *one = dJointGetBody(c->joints[i], 0), *two = dJointGetBody(c->joints[i], 1);
            if ((one != NULL) != (two != NULL))
                held[(intptr_t)dBodyGetData(one ? one : two)] = 1;
        }
}

/* Whether a body is held so, or is the world. */
static int is_held(const context *c, void *body)
{
    int64_t row = body ? (int64_t)(intptr_t)dBodyGetData(body) : -1;
    return row < 0 || (row < c->work->held_capacity && c->work->held[row]);
}

/* The smaller mass of two bodies, or that of the one that moves [kg]. */
static double lighter(void *body1, void *body2)
{
    body_mass one, two;
    if (!body1 || !body2) {
        dBodyGetMass(body1 ? body1 : body2, &one);
        return one.mass;
    }
    dBodyGetMass(body1, &one);
    dBodyGetMass(body2, &two);
    return smaller(one.mass, two.mass);
}

/* Whether a body is slow, or nothing that moves. */
int is_calm(const context *c, void *body)
{
    double calm = CALM_SPEED + FALLING_STEPS * c->step * sqrt(dot(c->gravity, c->gravity));
    const double *v, *w;
    if (!body)
        return 1;
    v = dBodyGetLinearVel(body);
    w = dBodyGetAngularVel(body);
    return dot(v, v) + dot(w, w) <= calm * calm;
}

/* Springs that are too stiff to be simulated stand for rigid surfaces. A body that these move out to depth 0 loses its
 * contacts by the error of the solver, falls for a step and is caught again: so they keep REST_DEPTH. One that they move
 * out within a step keeps the velocity that it takes, and bounces: so they get a damper where bodies are calm. And the
 * exact solver fails on redundant contacts without any softness. Bodies that joints hold to the world are left out: there
 * contact and joint share the load, and a softer contact would carry nothing. And so is what bounces, while it is fast:
 * the depth that is pushed out adds to its speed. */
void make_rigid(const context *c, touching *t, surface_parameters *s)
{
    double softness = 1.0 / t->a[SURFACE_KP] + 1.0 / t->b[SURFACE_KP], mass;
    int calm;
    t->kept = 0.0;
    t->rigid = 0;
    if (!c->exact_rest || (is_held(c, t->body1) && is_held(c, t->body2)))
        return;
    mass = lighter(t->body1, t->body2);
    if (c->step * c->step <= SOFT_RATIO * mass * softness)
        return;
    calm = is_calm(c, t->body1) && is_calm(c, t->body2);
    if (s->mode & BOUNCE && !calm)
        return;
    t->rigid = 1;
    t->damper = larger(s->soft_cfm, REST_CFM / mass);
    if (s->soft_erp > REST_ERP && calm) {
        s->soft_cfm = s->soft_cfm * (REST_ERP / s->soft_erp);
        s->soft_erp = REST_ERP;
    }
    s->soft_cfm = larger(s->soft_cfm, REST_CFM / mass);
}

/* The stiffness [N/m] of two elastic surfaces at a depth: F / depth of Hertz' contact, 4 / 3 E sqrt(R depth), or of a flat
 * punch of a patch's radius, 2 E a; 0 if one surface is not elastic, or there is no radius. */
static double elastic_stiffness(const touching *t, double depth)
{
    double compliance = t->a[SURFACE_COMPLIANCE] + t->b[SURFACE_COMPLIANCE];
    double curvature = t->a[SURFACE_CURVATURE] + t->b[SURFACE_CURVATURE];
    if (t->a[SURFACE_COMPLIANCE] <= 0.0 || t->b[SURFACE_COMPLIANCE] <= 0.0 || depth <= 0.0)
        return 0.0;
    if (curvature > 0.0)
        return 4.0 / 3.0 / compliance * sqrt(depth / curvature);
    return 2.0 / compliance * larger(t->a[SURFACE_PATCH_RADIUS], t->b[SURFACE_PATCH_RADIUS]);
}

/* Points of equal depth and softness are redundant, and the exact solver, Dantzig's, may stop halfway at what is degenerate:
 * a stack falls apart then. So rigid ones differ a little, by a triangular wave of the place, which does not change for
 * what rests. */
void vary(const context *c, touching *t, contact *point)
{
    const double *p = point->geom.pos;
    double wave = 6.0 * p[0] + 8.45 * p[1] + 11.35 * p[2];
    wave = 2.0 * fabs(wave - floor(wave) - 0.5);
    point->surface.soft_cfm = point->surface.soft_cfm * (1.0 + SOFTNESS_SPREAD * wave);
    t->kept = larger(0.0, REST_DEPTH - t->min_depth) - REST_DEPTH * DEPTH_SPREAD * c->step * wave;
    point->geom.depth = larger(0.0, point->geom.depth - t->kept);
}

/* Let a contact push out no faster than max_vel; set_apart does the rest. Its softness shrinks with its correction: the
 * spring carries the same force where the bodies are at rest. */
static void limit_speed(const context *c, touching *t, surface_parameters *s, double depth)
{
    double most = t->max_vel * c->step / depth;
    if (most >= s->soft_erp)
        return;
    t->withheld = (s->soft_erp - most) * depth;
    t->erp = t->rigid ? 1.0 : s->soft_erp;
    t->cfm = t->rigid ? 0.0 : s->soft_cfm;
    s->soft_cfm = larger(s->soft_cfm * (most / s->soft_erp), REST_CFM / lighter(t->body1, t->body2));
    s->soft_erp = most;
}

/* What a contact point corrects: the depth that was found, without what is kept and min_depth, no faster than max_vel.
 * One that is not as deep as what is kept lets the bodies approach. */
static void set_depth(const context *c, touching *t, double found, contact *point)
{
    surface_parameters *s = &point->surface;
    double stiffness = elastic_stiffness(t, found);
    if (stiffness > 0.0) {
        double spring = c->step * stiffness, kd = t->a[SURFACE_KD] + t->b[SURFACE_KD];
        s->soft_erp = spring / (spring + kd);
        s->soft_cfm = 1.0 / (spring + kd);
        point->geom.depth = found;
        return;
    }
    point->geom.depth = larger(0.0, point->geom.depth - t->min_depth);
    if (point->geom.depth == 0.0 && t->min_depth > 0.0 && t->rigid)
        s->soft_cfm = t->damper; /* it alone acts, and the body sinks */
    if (point->geom.depth > 0.0)
        limit_speed(c, t, s, point->geom.depth);
    else if (found < t->kept && !(s->mode & BOUNCE)) {
        s->motionN = s->soft_erp * (found - t->kept) / c->step;
        s->mode |= MOTION_N;
    }
}

/* What classic adds to one contact point: slip, a friction direction, torsion, a minimum depth, a limit on the
 * push-out velocity. */
void refine_point(const context *c, touching *t, int count, double found, contact *point)
{
    surface_parameters *s = &point->surface;
    const double *a = t->a, *b = t->b;
    s->slip1 = (a[SURFACE_SLIP1] + b[SURFACE_SLIP1]) * count;
    s->slip2 = (a[SURFACE_SLIP2] + b[SURFACE_SLIP2]) * count;
    if (s->slip1 > 0.0)
        s->mode |= SLIP1;
    if (s->slip2 > 0.0)
        s->mode |= SLIP2;
    if ((a[SURFACE_TRACK] == 0.0 && b[SURFACE_TRACK] == 0.0) || !set_track(a, b, t->geom1, t->geom2, point)) {
        int aimed = friction_direction(t, point);
        if (aimed)
            s->mode |= FDIR1;
        if (c->cone)
            set_cone(c, t, point, aimed);
    }
    add_torsion(a, b, point);
    t->withheld = 0.0;
    set_depth(c, t, found, point);
}
