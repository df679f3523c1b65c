/* Islands that rest: described to resting.c, which solves their contacts in closed form, and then given to ODE as the
 * efforts that the contacts exert. */
#include "memory.h"
#include "resting.h"
#include "step.h"

#include <math.h>
#include <string.h>

/* What contacts may have, to be solved by resting.c: no bouncing and no torsion. */
enum { PLAIN = MU2 | FDIR1 | SOFT_ERP | SOFT_CFM | MOTION_N | SLIP1 | SLIP2 | APPROX1 };
enum { RESTING_WORK = 400 }; /* bodies squared, in the profile of larger islands: what a stack of a hundred takes */
#define SLACK 1e-5 /* [-] of the inverse mass, that every direction yields at least while a system is solved */
#define SURELY 2.0 /* times as fast as friction can stop in a step: contacts slide, however the load is shared */

/* List the bodies and touches of each island, in their order. */
static void list_members(const context *c)
{
    member *members = c->work->members;
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        member *root;
        if (!c->bodies[i])
            continue;
        root = members + root_of(members, i);
        if (root->first < 0)
            root->first = i;
        else
            members[root->last].next = i;
        root->last = i;
    }
    for (i = 0; i < c->touch_count; i++) {
        touch_record *t = c->touches + i;
        member *root = members + root_of(members, t->body1);
        if (root->touch < 0)
            root->touch = i;
        else
            c->touches[root->last_touch].next = i;
        root->last_touch = i;
    }
}

/* Impulse that acts on a body in the step, without contacts. */
static void find_load(const context *c, void *body, double mass, double *load)
{
    const double *force = dBodyGetForce(body);
    int i, falls = dBodyGetGravityMode(body);
    for (i = 0; i < 3; i++)
        load[i] = c->step * (force[i] + (falls ? mass * c->gravity[i] : 0.0));
}

/* Momentum and inertia of a body that has no contacts. */
static void describe_body(const context *c, void *body, resting_body *b)
{
    const double *r = dBodyGetRotation(body), *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    const double *torque = dBodyGetTorque(body);
    double turned[3][3], angular[3], gyroscopic[3], load[3];
    int i, k, turns = dBodyGetGyroscopicMode(body);
    body_mass m;
    dBodyGetMass(body, &m);
    b->mass = m.mass;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++)
            turned[i][k] = r[4 * i] * m.inertia[k] + r[4 * i + 1] * m.inertia[4 + k] + r[4 * i + 2] * m.inertia[8 + k];
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++)
            b->inertia[i][k] = dot(turned[i], r + 4 * k);
    for (i = 0; i < 3; i++)
        angular[i] = dot(b->inertia[i], w);
    cross(w, angular, gyroscopic);
    find_load(c, body, m.mass, load);
    for (i = 0; i < 3; i++) {
        b->momentum[i] = m.mass * v[i] + load[i];
        b->momentum[3 + i] = angular[i] + c->step * (torque[i] - (turns ? gyroscopic[i] : 0.0));
    }
}

/* The directions of a contact as ODE has them: the normal, and two of friction. */
static void find_directions(const contact *p, double directions[DIRECTIONS][3])
{
    const double *n = p->geom.normal;
    double *one = directions[1], *two = directions[2];
    memcpy(directions[0], n, 3 * sizeof(double));
    if (p->surface.mode & FDIR1)
        memcpy(one, p->fdir1, 3 * sizeof(double));
    else
        default_direction(n, one);
    cross(n, one, two);
}

/* Softness of a contact, and coefficients of friction. */
static void find_friction(const context *c, const contact *p, double world_cfm, double *softness, double *mu)
{
    const surface_parameters *s = &p->surface;
    softness[0] = s->soft_cfm / c->step;
    softness[1] = (s->mode & SLIP1 ? s->slip1 : world_cfm) / c->step;
    softness[2] = (s->mode & SLIP2 ? s->slip2 : world_cfm) / c->step;
    mu[0] = s->mu;
    mu[1] = s->mode & MU2 ? s->mu2 : s->mu;
}

static void describe_point(const context *c, const touch_record *t, const contact *p, double world_cfm, double fastest,
                           resting_point *found)
{
    const member *members = c->work->members;
    const surface_parameters *s = &p->surface;
    double directions[DIRECTIONS][3], mass = HUGE_VAL;
    int side, k, i;
    find_directions(p, directions);
    for (side = 0; side < 2; side++) {
        int64_t row = side ? t->body2 : t->body1;
        const double *place;
        double arm[3];
        found->body[side] = row < 0 ? -1 : members[row].place;
        if (row < 0)
            continue;
        place = dBodyGetPosition(c->bodies[row]);
        mass = smaller(mass, c->work->resting_bodies[members[row].place].mass);
        for (k = 0; k < 3; k++)
            arm[k] = p->geom.pos[k] - place[k];
        for (k = 0; k < DIRECTIONS; k++) {
            double *line = found->rows[side][k];
            memcpy(line, directions[k], 3 * sizeof(double));
            cross(arm, directions[k], line + 3);
            if (side)
                for (i = 0; i < MOTIONS; i++)
                    line[i] = -line[i];
        }
    }
    found->aim = s->soft_erp * p->geom.depth / c->step + (s->mode & MOTION_N ? s->motionN : 0.0);
    found->aim = smaller(found->aim, fastest);
    find_friction(c, p, world_cfm, found->softness, found->mu);
    for (k = 0; k < DIRECTIONS; k++)
        found->slack[k] = larger(0.0, SLACK / mass - found->softness[k]);
}

/* Number the bodies of an island from top to bottom, so that those that touch are near each other; how many there are, 0 if
 * some do not move or are asleep. */
static int64_t rank_bodies(const context *c, const member *root)
{
    member *members = c->work->members;
    int64_t i, k, count = 0;
    for (i = root->first; i >= 0; i = members[i].next) {
        int64_t *ranked = enlarged(c->work->ranked, &c->work->ranked_capacity, count + 1, sizeof *ranked);
        double fallen = dot(dBodyGetPosition(c->bodies[i]), c->gravity);
        if (!ranked || !dBodyIsEnabled(c->bodies[i]) || dBodyIsKinematic(c->bodies[i]))
            return 0;
        c->work->ranked = ranked;
        members[i].fallen = fallen;
        for (k = count++; k > 0 && members[ranked[k - 1]].fallen > fallen; k--)
            ranked[k] = ranked[k - 1];
        ranked[k] = i;
    }
    for (i = 0; i < count; i++)
        members[c->work->ranked[i]].place = i;
    return count;
}

/* Count and number the members of an island, and find which are near each other; 0 if it is of another kind. */
static int survey_island(const context *c, const member *root, int64_t *bodies, int64_t *points)
{
    const member *members = c->work->members;
    resting_body *resting_bodies;
    int64_t i, k, work = 0;
    *points = 0;
    *bodies = rank_bodies(c, root);
    if (!*bodies)
        return 0;
    resting_bodies =
        enlarged(c->work->resting_bodies, &c->work->resting_body_capacity, *bodies, sizeof *resting_bodies);
    if (!resting_bodies)
        return 0;
    c->work->resting_bodies = resting_bodies;
    for (i = 0; i < *bodies; i++)
        resting_bodies[i].nearest = i;
    for (i = root->touch; i >= 0; i = c->touches[i].next) {
        const touch_record *t = c->touches + i;
        int64_t one = members[t->body1].place, two = t->body2 < 0 ? one : members[t->body2].place;
        resting_body *later = resting_bodies + (one > two ? one : two);
        if (t->first + t->count > c->point_count)
            return 0;
        for (k = 0; k < t->count; k++)
            if (c->points[t->first + k].point.surface.mode & ~PLAIN)
                return 0;
        later->nearest = later->nearest < one ? later->nearest : one;
        later->nearest = later->nearest < two ? later->nearest : two;
        *points += t->count;
    }
    for (i = 0; i < *bodies; i++)
        work += (i - resting_bodies[i].nearest + 1) * (i - resting_bodies[i].nearest + 1);
    return root->rows <= EXACT_ROWS || work <= RESTING_WORK;
}

/* Describe an island to resting.c; the number of its points, 0 if it is of another kind. */
static int64_t describe_island(const context *c, const member *root, int64_t *body_count)
{
    const member *members = c->work->members;
    double world_cfm = dWorldGetCFM(c->world), fastest = dWorldGetContactMaxCorrectingVel(c->world);
    int64_t i, k, points;
    resting_point *p;
    if (!survey_island(c, root, body_count, &points))
        return 0;
    p = enlarged(c->work->resting_points, &c->work->resting_point_capacity, points, sizeof *p);
    if (!p)
        return 0;
    c->work->resting_points = p;
    for (i = root->first; i >= 0; i = members[i].next)
        describe_body(c, c->bodies[i], c->work->resting_bodies + members[i].place);
    for (i = root->touch; i >= 0; i = c->touches[i].next)
        for (k = 0; k < c->touches[i].count; k++)
            describe_point(c, c->touches + i, &c->points[c->touches[i].first + k].point, world_cfm, fastest, p++);
    return points;
}

/* Force and torque of a contact on one of its bodies. */
static void find_effort(const context *c, const resting_point *p, int side, double *force, double *torque)
{
    int a, k;
    for (a = 0; a < 3; a++) {
        force[a] = torque[a] = 0.0;
        for (k = 0; k < DIRECTIONS; k++) {
            force[a] = force[a] + p->rows[side][k][a] * p->impulse[k];
            torque[a] = torque[a] + p->rows[side][k][3 + a] * p->impulse[k];
        }
        force[a] = force[a] / c->step;
        torque[a] = torque[a] / c->step;
    }
}

/* Let the contacts of an island act as efforts; their joints have no part in the step. */
static void apply_solution(context *c, const member *root)
{
    const member *members = c->work->members;
    const resting_point *p = c->work->resting_points;
    int64_t i, k;
    for (i = root->first; i >= 0; i = members[i].next) {
        const double *impulse = c->work->resting_bodies[members[i].place].impulse;
        const double *force = dBodyGetForce(c->bodies[i]), *torque = dBodyGetTorque(c->bodies[i]);
        dBodySetForce(c->bodies[i], force[0] + impulse[0] / c->step, force[1] + impulse[1] / c->step,
                      force[2] + impulse[2] / c->step);
        dBodySetTorque(c->bodies[i], torque[0] + impulse[3] / c->step, torque[1] + impulse[4] / c->step,
                       torque[2] + impulse[5] / c->step);
    }
    for (i = root->touch; i >= 0; i = c->touches[i].next)
        for (k = 0; k < c->touches[i].count; k++, p++) {
            const touch_point *point = c->points + c->touches[i].first + k;
            dJointDisable(point->joint);
            if (point->record >= 0 && point->record < c->record_count) {
                feedback *result = &c->pending[point->record].result;
                find_effort(c, p, 0, result->f1, result->t1);
                if (p->body[1] >= 0)
                    find_effort(c, p, 1, result->f2, result->t2);
            }
        }
}

/* Whether a contact of a body with the world slides faster than friction could stop it in the step, if the whole island's
 * load and mass pressed there. */
static int point_slides(const context *c, void *body, double mass, double load, double whole_mass, const contact *p)
{
    const double *place = dBodyGetPosition(body), *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    double directions[DIRECTIONS][3], softness[DIRECTIONS], mu[2], arm[3], velocity[3], press;
    int k;
    for (k = 0; k < 3; k++)
        arm[k] = p->geom.pos[k] - place[k];
    cross(w, arm, velocity);
    for (k = 0; k < 3; k++)
        velocity[k] = v[k] + velocity[k];
    find_directions(p, directions);
    find_friction(c, p, dWorldGetCFM(c->world), softness, mu);
    press = load + whole_mass * larger(0.0, -dot(directions[0], velocity));
    for (k = 0; k < 2; k++)
        if (mu[k] > 0.0 &&
            fabs(dot(directions[k + 1], velocity)) > SURELY * (mu[k] * press * (1.0 / mass + softness[k + 1])))
            return 1;
    return 0;
}

/* Whether an island surely slides, at each of its contacts with the world: it is not worth an attempt, which would fail.
 * Where that would not fail, as with a ball that friction turns at once, ODE finds the same motion. What rests has no
 * velocity, and so never seems to slide. */
static int slides(const context *c, const member *root)
{
    const member *members = c->work->members;
    double whole[3] = {0.0, 0.0, 0.0}, whole_mass = 0.0, load[3];
    int64_t i, k, found = 0;
    body_mass m;
    for (i = root->first; i >= 0; i = members[i].next) {
        dBodyGetMass(c->bodies[i], &m);
        find_load(c, c->bodies[i], m.mass, load);
        whole_mass = whole_mass + m.mass;
        for (k = 0; k < 3; k++)
            whole[k] = whole[k] + load[k];
    }
    for (i = root->touch; i >= 0; i = c->touches[i].next) {
        const touch_record *t = c->touches + i;
        void *body = c->bodies[t->body1];
        if (t->body2 >= 0)
            continue;
        if (t->first + t->count > c->point_count)
            return 0;
        dBodyGetMass(body, &m);
        for (k = 0; k < t->count; k++, found++)
            if (!point_slides(c, body, m.mass, sqrt(dot(whole, whole)), whole_mass, &c->points[t->first + k].point))
                return 0;
    }
    return found > 0;
}

/* Whether a body stands for an island that may rest: calm bodies that only touch. */
static int may_rest(const context *c, int64_t i)
{
    const member *root = c->work->members + i;
    return c->bodies[i] && root->root == i && root->touching && !root->fast && !root->joined;
}

/* Solve islands that rest; those that cannot be solved so are left to ODE. */
void solve_resting(context *c)
{
    member *members = c->work->members;
    int64_t i;
    int listed = 0;
    for (i = 0; i < c->body_count; i++) {
        member *root = members + i;
        int64_t points, bodies;
        if (!may_rest(c, i))
            continue;
        if (!listed)
            list_members(c);
        listed = 1;
        if (root->touch < 0 || slides(c, root))
            continue;
        points = describe_island(c, root, &bodies);
        if (points && gz_solve_resting(&c->work->resting, c->work->resting_bodies, bodies,
                                       c->work->resting_points, points)) {
            root->solved = 1;
            apply_solution(c, root);
        }
    }
}
