/* The first half of a step: which geoms touch, and a contact joint for each of their points.
 *
 * dSpaceCollide() calls collide() for each pair whose bounding boxes meet. Bodies that a joint connects do not touch.
 * collision.c finds the points, surfaces.c says what they are like, contact_records.c what is reported of them. */
#include "memory.h"
#include "step.h"

#include <string.h>

/* Keep the `most` deepest of `count` contacts, in their order. */
static int deepest(contact *points, int count, int most)
{
    while (count > most) {
        int shallow = 0, i;
        for (i = 1; i < count; i++)
            if (points[i].geom.depth < points[shallow].geom.depth)
                shallow = i;
        for (i = shallow; i + 1 < count; i++)
            points[i] = points[i + 1];
        count--;
    }
    return count;
}

/* How many points of a pair act under the classic rule; 0 and less are no bound, as in Gazebo. */
static int most_points(const context *c, const double *a, const double *b)
{
    const double bounds[] = {a[SURFACE_MAX_CONTACTS], b[SURFACE_MAX_CONTACTS], (double)c->max_contacts};
    double most = MOST_CONTACTS;
    int i;
    for (i = 0; i < 3; i++)
        if (bounds[i] >= 1.0)
            most = smaller(most, bounds[i]);
    return (int)most;
}

/* Whether a pair of geoms touches under the classic rule; *ghost: without contact joints, only recorded. */
static int may_touch(const context *c, const double *a, const double *b, void *body1, void *body2, int *ghost)
{
    if (!((uint32_t)a[SURFACE_BITS] & (uint32_t)b[SURFACE_BITS]))
        return 0;
    *ghost = a[SURFACE_GHOST] != 0.0 || b[SURFACE_GHOST] != 0.0;
    if (*ghost)
        return c->record_contacts && ((uint32_t)a[SURFACE_GHOST_BITS] & (uint32_t)b[SURFACE_GHOST_BITS]);
    if (c->record_contacts)
        return 1;
    return is_awake(body1) || is_awake(body2); /* both disabled: nothing to do */
}

/* Note that two bodies touch. Without memory they are not noted, and so not taken for one island. */
static void note_touch(context *c, void *body1, void *body2, int count)
{
    touch_record *t = enlarged(c->touches, &c->touch_capacity, c->touch_count + 1, sizeof *t);
    if (!t)
        return;
    c->touches = t;
    t += c->touch_count++;
    t->body1 = (intptr_t)dBodyGetData(body1 ? body1 : body2);
    t->body2 = body1 && body2 ? (intptr_t)dBodyGetData(body2) : -1;
    t->count = count;
    t->first = c->point_count;
    t->next = -1;
}

/* Note a contact of the bodies that were noted last. Without memory it is missing, and its island is solved by ODE. */
static void note_point(context *c, const contact *point, void *joint)
{
    touch_point *p = enlarged(c->points, &c->point_capacity, c->point_count + 1, sizeof *p);
    if (!p)
        return;
    c->points = p;
    p += c->point_count++;
    p->point = *point;
    p->joint = joint;
    p->record = c->record_contacts ? c->record_count : -1;
}

static void collide_geoms(context *c, void *geom1, void *geom2)
{
    contact points[MOST_CONTACTS];
    surface_parameters surface;
    touching pair;
    const double *a, *b;
    void *body1 = dGeomGetBody(geom1), *body2 = dGeomGetBody(geom2), *joint = NULL;
    int classic = c->contact_rule == CLASSIC_RULE, count, i, ghost = 0;

    if (!body1 && !body2)
        return;
    if (body1 && body2 && dAreConnectedExcluding(body1, body2, JOINT_CONTACT))
        return;
    a = c->surface + SURFACE_COLUMNS * (intptr_t)dGeomGetData(geom1);
    b = c->surface + SURFACE_COLUMNS * (intptr_t)dGeomGetData(geom2);
    if (classic && !may_touch(c, a, b, body1, body2, &ghost))
        return;
    count = find_points(c, geom1, geom2, classic ? MOST_CONTACTS : MAX_CONTACTS, points);
    if (!count)
        return;
    pair = (touching){a, b, geom1, geom2, body1, body2, 0.0, 0.0, 0.0, 0.0, 0, NULL, NULL};
    make_surface(c, a, b, &surface);
    if (classic) {
        count = deepest(points, count, most_points(c, a, b));
        set_limits(c, &pair);
        choose_direction(c, &pair);
        make_rigid(c, &pair, &surface);
        if (!ghost && solves_islands(c))
            note_touch(c, body1, body2, count);
    }
    for (i = 0; i < count; i++) {
        double found = points[i].geom.depth;
        points[i].surface = surface;
        if (pair.rigid)
            vary(c, &pair, &points[i]);
        if (classic)
            refine_point(c, &pair, count, found, &points[i]);
        if (!ghost) {
            joint = dJointCreateContact(c->world, c->contacts, &points[i]);
            dJointAttach(joint, body1, body2);
            c->contact_count++;
            if (classic && solves_islands(c))
                note_point(c, &points[i], joint);
            if (pair.withheld > 0.0 && c->exact_rest)
                note_overlap(c, &pair, &points[i]);
        }
        if (c->record_contacts) {
            points[i].geom.depth = found;
            record_point(c, &points[i], geom1, geom2, joint);
        }
    }
}

static void collide(void *data, void *geom1, void *geom2)
{
    if (dGeomIsSpace(geom1) || dGeomIsSpace(geom2))
        dSpaceCollide2(geom1, geom2, data, collide);
    else
        collide_geoms(data, geom1, geom2);
}

/* The first half of a step: find contacts and make joints of them. */
void find_contacts(context *c)
{
    int64_t i;
    begin_records(c);
    c->contact_count = c->touch_count = c->point_count = c->overlap_count = 0;
    if (c->exact_rest && c->contact_rule == CLASSIC_RULE) {
        for (i = 0; i < c->body_count; i++)
            if (c->bodies[i])
                dBodySetData(c->bodies[i], (void *)(intptr_t)i);
        find_held(c);
    }
    leave_out_far(c);
    if (may_meet(c))
        dSpaceCollide(c->space, c, collide);
    bring_back_far(c);
}
