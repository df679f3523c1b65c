/* The contact points of two geoms: those of dCollide(), or of the boxes that stand in for a cylinder where ODE has no
 * collider of its own, and in legacy worlds. */
#include "step.h"

#include <math.h>
#include <string.h>

/* dCollide; no contacts, instead of the end of the process, if an assertion fails in it. */
int collide_pair(context *c, void *geom1, void *geom2, int most, contact_geom *points, int skip)
{
    void *geoms[2] = {geom1, geom2};
    double position[2][4], rotation[2][12];
    int class1 = dGeomGetClass(geom1), class2 = dGeomGetClass(geom2), count, k;
    int moved = (class1 == HEIGHTFIELD_CLASS && class2 != PLANE_CLASS) ||
                (class2 == HEIGHTFIELD_CLASS && class1 != PLANE_CLASS);

    /* ODE moves a geom that collides with a height field into the field's frame, and back afterwards. */
    for (k = 0; moved && k < 2; k++) {
        memcpy(position[k], dGeomGetPosition(geoms[k]), sizeof position[k]);
        memcpy(rotation[k], dGeomGetRotation(geoms[k]), sizeof rotation[k]);
    }
    guarded = 1;
    if (SET_JUMP(escape)) {
        guarded = 0;
        for (k = 0; moved && k < 2; k++) {
            memcpy((double *)dGeomGetPosition(geoms[k]), position[k], sizeof position[k]);
            memcpy((double *)dGeomGetRotation(geoms[k]), rotation[k], sizeof rotation[k]);
        }
        c->collision_failed = 1;
        for (k = 0; k < 2; k++)
            c->failed_rows[k] = dGeomGetClass(geoms[k]) == RAY_CLASS ? -1 : (int64_t)(intptr_t)dGeomGetData(geoms[k]);
        return 0;
    }
    count = dCollide(geom1, geom2, most, points, skip);
    guarded = 0;
    return count;
}

/* Place the stand-in at a cylinder: a box `radial` long towards the other's axis, `tangential` across it. */
static void place_stand_in(void *box, const double *position, const double *x, const double *y, const double *axis,
                           double radial, double tangential, double length)
{
    double rotation[12];
    int k;
    for (k = 0; k < 3; k++) {
        rotation[4 * k] = x[k];
        rotation[4 * k + 1] = y[k];
        rotation[4 * k + 2] = axis[k];
        rotation[4 * k + 3] = 0.0;
    }
    dGeomBoxSetLengths(box, 2.0 * radial, 2.0 * tangential, length);
    dGeomSetPosition(box, position[0], position[1], position[2]);
    dGeomSetRotation(box, rotation);
}

/* Contacts of a cylinder with a cylinder or capsule, which ODE lacks without libccd. The cylinder is approximated by
 * two boxes inside it: a strip that points at the other's axis, so that sides touch at the true radius, and the square
 * inscribed in its ends, so that one can stand on the other. */
static int collide_cylinder(context *c, void *geom1, void *geom2, int class2, contact *points)
{
    void *cylinder = class2 == CYLINDER_CLASS ? geom2 : geom1, *other = cylinder == geom2 ? geom1 : geom2;
    const double *p = dGeomGetPosition(cylinder), *q = dGeomGetPosition(other);
    const double *r = dGeomGetRotation(cylinder), *s = dGeomGetRotation(other);
    double radius, length, other_radius, other_length, along, square, t, size;
    double axis[3], other_axis[3], gap[3], aim[3], side[3];
    int k, count;

    dGeomCylinderGetParams(cylinder, &radius, &length);
    if (dGeomGetClass(other) == CYLINDER_CLASS)
        dGeomCylinderGetParams(other, &other_radius, &other_length);
    else
        dGeomCapsuleGetParams(other, &other_radius, &other_length);
    for (k = 0; k < 3; k++) {
        axis[k] = r[4 * k + 2];
        other_axis[k] = s[4 * k + 2];
        gap[k] = q[k] - p[k];
    }
    /* The point of the other axis that is nearest to this axis, perpendicular to it. */
    along = dot(gap, axis);
    t = dot(other_axis, axis);
    for (k = 0; k < 3; k++) {
        gap[k] = gap[k] - along * axis[k];
        other_axis[k] = other_axis[k] - t * axis[k];
    }
    square = dot(other_axis, other_axis);
    t = square > 1e-9 ? -dot(gap, other_axis) / square : 0.0;
    if (t > 0.5 * other_length)
        t = 0.5 * other_length;
    if (t < -0.5 * other_length)
        t = -0.5 * other_length;
    for (k = 0; k < 3; k++)
        aim[k] = gap[k] + t * other_axis[k];
    size = dot(aim, aim);
    if (size < 1e-18) {
        for (k = 0; k < 3; k++)
            aim[k] = r[4 * k];
        size = 1.0;
    }
    size = sqrt(size);
    for (k = 0; k < 3; k++)
        aim[k] = aim[k] / size;
    cross(axis, aim, side);

    place_stand_in(c->stand_in, p, aim, side, axis, radius, 0.2 * radius, length);
    geom1 = cylinder == geom1 ? c->stand_in : geom1;
    geom2 = cylinder == geom2 ? c->stand_in : geom2;
    count = collide_pair(c, geom1, geom2, MAX_CONTACTS / 2, &points[0].geom, sizeof(contact));
    place_stand_in(c->stand_in, p, aim, side, axis, radius * 0.70710678118654752, radius * 0.70710678118654752, length);
    count += collide_pair(c, geom1, geom2, MAX_CONTACTS / 2, &points[count].geom, sizeof(contact));
    return count;
}

/* The contact points of two geoms; ODE's own, or those of a cylinder's stand-ins. */
int find_points(context *c, void *geom1, void *geom2, int most, contact *points)
{
    if (c->no_cylinder_pairs) {
        int class1 = dGeomGetClass(geom1), class2 = dGeomGetClass(geom2);
        if ((class1 == CYLINDER_CLASS && (class2 == CYLINDER_CLASS || class2 == CAPSULE_CLASS)) ||
            (class1 == CAPSULE_CLASS && class2 == CYLINDER_CLASS))
            return collide_cylinder(c, geom1, geom2, class2, points);
    }
    return collide_pair(c, geom1, geom2, most, &points[0].geom, sizeof(contact));
}

/* Depth of the deepest contact point of two geoms; -1 without any, and if their collision detection fails. */
double gz_overlap(context *c, void *geom1, void *geom2)
{
    contact points[MOST_CONTACTS];
    double deepest = -1.0;
    int count, i;
    enter_ode(c);
    count = find_points(c, geom1, geom2, MAX_CONTACTS, points);
    for (i = 0; i < count; i++)
        deepest = larger(deepest, points[i].geom.depth);
    c->collision_failed = 0;
    leave_ode();
    return deepest;
}
