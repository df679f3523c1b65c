/* Bodies that overlap are set apart without velocity, as in Gazebo: by what max_vel withholds from their contacts, and
 * together with all that joints connect them with, which is not turned. What touches from both sides is a compromise:
 * each contact yields by its softness, and by YIELDING of what it weighs at least. Springs keep the depth at which they
 * carry SPARED times the weight; without it bodies would fall on, and be set apart in each step. */
#include "memory.h"
#include "step.h"

#include <math.h>
#include <string.h>

enum { SETTING_ROUNDS = 10 };
#define YIELDING 0.25
#define SPARED 2.0

/* Note a point whose bodies are to be set apart. Without memory it is not noted. */
void note_overlap(context *c, const touching *t, const contact *point)
{
    overlap_record *o = enlarged(c->overlaps, &c->overlap_capacity, c->overlap_count + 1, sizeof *o);
    if (!o)
        return;
    c->overlaps = o;
    o += c->overlap_count++;
    o->body1 = t->body1;
    o->body2 = t->body2;
    memcpy(o->normal, point->geom.normal, sizeof o->normal);
    o->depth = t->withheld;
    o->softness = t->erp * (1.0 / t->a[SURFACE_KP] + 1.0 / t->b[SURFACE_KP]);
    o->yielding = t->cfm / c->step;
    o->share = 0.0;
}

static int have_groups(const context *c)
{
    group *grown = enlarged(c->work->groups, &c->work->group_capacity, c->body_count, sizeof *grown);
    if (grown)
        c->work->groups = grown;
    return grown != NULL;
}

/* The group of a body, which `find_contacts` has numbered; NULL if it cannot move. */
static group *group_of(const context *c, void *body)
{
    group *found = body ? c->work->groups + root_of(c->work->members, row_of(body)) : NULL;
    return found && found->mass > 0.0 ? found : NULL;
}

static void find_groups(const context *c)
{
    member *members = c->work->members;
    group *groups = c->work->groups;
    int64_t i;
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i]) {
            members[i] = alone(i, 0);
            groups[i] = (group){0.0, {0.0, 0.0, 0.0}};
        }
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i])
            unite(c, row_of(dJointGetBody(c->joints[i], 0)), row_of(dJointGetBody(c->joints[i], 1)), 0, 0);
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i]) {
            body_mass one;
            dBodyGetMass(c->bodies[i], &one);
            groups[root_of(members, i)].mass += one.mass;
        }
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i] && dBodyIsKinematic(c->bodies[i]))
            groups[root_of(members, i)].mass = 0.0;
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i]) {
            int64_t one = row_of(dJointGetBody(c->joints[i], 0)), two = row_of(dJointGetBody(c->joints[i], 1));
            if ((one < 0) != (two < 0))
                groups[root_of(members, one < 0 ? two : one)].mass = 0.0;
        }
}

static void add_shift(group *g, const double *normal, double distance)
{
    int k;
    for (k = 0; k < 3; k++)
        g->shift[k] += normal[k] * distance;
}

static void spare(const context *c, overlap_record *o)
{
    const group *one = group_of(c, o->body1), *two = group_of(c, o->body2);
    double mass = one && two ? smaller(one->mass, two->mass) : one ? one->mass : two ? two->mass : 0.0;
    o->depth = larger(0.0, o->depth - SPARED * o->softness * mass * sqrt(dot(c->gravity, c->gravity)));
}

/* One step of projected Gauss-Seidel for one contact. */
static void balance(const context *c, overlap_record *o)
{
    group *one = group_of(c, o->body1), *two = group_of(c, o->body2);
    double lightness = (one ? 1.0 / one->mass : 0.0) + (two ? 1.0 / two->mass : 0.0), missing = o->depth, share;
    double yielding;
    if (one == two)
        return;
    yielding = larger(YIELDING, o->yielding / lightness);
    if (one)
        missing -= dot(o->normal, one->shift);
    if (two)
        missing += dot(o->normal, two->shift);
    share = larger(0.0, o->share + (missing / lightness - yielding * o->share) / (1.0 + yielding));
    if (one)
        add_shift(one, o->normal, (share - o->share) / one->mass);
    if (two)
        add_shift(two, o->normal, -(share - o->share) / two->mass);
    o->share = share;
}

void set_apart(const context *c)
{
    int64_t i;
    int round;
    if (!c->overlap_count || !have_members(c) || !have_groups(c))
        return;
    find_groups(c);
    for (i = 0; i < c->overlap_count; i++)
        spare(c, c->overlaps + i);
    for (round = 0; round < SETTING_ROUNDS; round++)
        for (i = 0; i < c->overlap_count; i++)
            balance(c, c->overlaps + i);
    for (i = 0; i < c->body_count; i++) {
        const group *g = c->bodies[i] ? group_of(c, c->bodies[i]) : NULL;
        const double *p;
        if (!g || !(dot(g->shift, g->shift) > 0.0))
            continue;
        p = dBodyGetPosition(c->bodies[i]);
        dBodySetPosition(c->bodies[i], p[0] + g->shift[0], p[1] + g->shift[1], p[2] + g->shift[2]);
    }
}
