/* Ray scans: dCollide() of each ray with the geoms whose bounding boxes it meets, by the slab method; height fields are
 * walked through cell by cell. */
#include "step.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

typedef struct {
    void *geom;
    const height_field *field; /* NULL if it is none */
    double box[6];             /* its bounding box: x min, x max, y min, ... */
} candidate;

typedef struct {
    const context *c;
    int64_t owner;
    candidate *list;
    int64_t count, capacity;
} gathering;

static void gather(void *data, void *geom1, void *geom2)
{
    gathering *g = data;
    void *geom = geom1 == g->c->probe ? geom2 : geom1;
    int64_t k;
    if (dGeomIsSpace(geom)) {
        dSpaceCollide2(g->c->probe, geom, g, gather);
        return;
    }
    if (g->owner && g->c->owner[(intptr_t)dGeomGetData(geom)] == g->owner)
        return;
    if (g->count == g->capacity) {
        int64_t capacity = g->capacity ? 2 * g->capacity : 64;
        candidate *list = realloc(g->list, (size_t)capacity * sizeof(candidate));
        if (!list)
            return;
        g->list = list;
        g->capacity = capacity;
    }
    g->list[g->count].geom = geom;
    g->list[g->count].field = NULL;
    if (dGeomGetClass(geom) == HEIGHTFIELD_CLASS)
        for (k = 0; k < g->c->field_count; k++)
            if (g->c->fields[k].geom == geom)
                g->list[g->count].field = &g->c->fields[k];
    dGeomGetAABB(geom, g->list[g->count].box);
    g->count++;
}

/* Whether the segment start + t dir, 0 <= t <= length, meets the box enlarged by a small margin (the slab method). */
static int may_hit(const double *start, const double *dir, double length, const double *box)
{
    double from = 0.0, to = length;
    int k;
    for (k = 0; k < 3; k++) {
        double low = box[2 * k] - 1e-9 - start[k], high = box[2 * k + 1] + 1e-9 - start[k];
        if (dir[k] > -1e-12 && dir[k] < 1e-12) {
            if (low > 0.0 || high < 0.0)
                return 0;
        } else {
            double a = low / dir[k], b = high / dir[k];
            if (a > b) {
                double swap = a;
                a = b;
                b = swap;
            }
            if (a - 1e-9 > from)
                from = a - 1e-9;
            if (b + 1e-9 < to)
                to = b + 1e-9;
            if (from > to)
                return 0;
        }
    }
    return 1;
}

/* The height of the ground at (u, v), in cells from its corner; each cell is two triangles, as ODE's collider has them. */
static double ground(const height_field *f, double u, double v)
{
    int64_t i = (int64_t)fmin(fmax(u, 0.0), (double)(f->columns - 2));
    int64_t j = (int64_t)fmin(fmax(v, 0.0), (double)(f->rows - 2));
    const double *low = f->heights + j * f->columns + i, *high = low + f->columns;
    u -= (double)i;
    v -= (double)j;
    return u + v < 1.0 ? low[0] + (low[1] - low[0]) * u + (high[0] - low[0]) * v
                       : high[1] + (high[0] - high[1]) * (1.0 - u) + (low[1] - high[1]) * (1.0 - v);
}

/* Where t, along a coordinate x + t dx, reaches the next whole number; beyond all lengths if it never does. */
static double next_line(double x, double dx, double t)
{
    double at = x + t * dx, line;
    if (dx == 0.0)
        return DBL_MAX;
    line = dx > 0.0 ? floor(at) + 1.0 : ceil(at) - 1.0;
    if ((line - x) / dx <= t) /* by rounding it is on that line already */
        line += dx > 0.0 ? 1.0 : -1.0;
    return (line - x) / dx;
}

/* How far along a ray (global) the surface of a height field is; a negative number if the ray does not meet it. Between
 * the lines of its cells and their diagonals the surface is plane, so that the ray's height above it is linear. */
static double meet_field(const height_field *f, const double *start, const double *dir, double length)
{
    const double *p = dGeomGetPosition(f->geom), *r = dGeomGetRotation(f->geom);
    double gap[3], x[3], d[3], from = 0.0, to = length, t, above, u, v, du, dv, most[2];
    int64_t left = 3 * (f->rows + f->columns);
    int k;

    for (k = 0; k < 3; k++)
        gap[k] = start[k] - p[k];
    for (k = 0; k < 3; k++) { /* ODE's field lies in x and z, with its heights along y; our y is its -z */
        x[k] = r[k] * gap[0] + r[4 + k] * gap[1] + r[8 + k] * gap[2];
        d[k] = r[k] * dir[0] + r[4 + k] * dir[1] + r[8 + k] * dir[2];
    }
    most[0] = (double)(f->columns - 1);
    most[1] = (double)(f->rows - 1);
    u = (x[0] / f->width + 0.5) * most[0];
    du = d[0] / f->width * most[0];
    v = (0.5 - x[2] / f->length) * most[1];
    dv = -d[2] / f->length * most[1];
    for (k = 0; k < 2; k++) {
        double at = k ? v : u, speed = k ? dv : du, a, b;
        if (speed == 0.0) {
            if (at < 0.0 || at > most[k])
                return -1.0;
            continue;
        }
        a = -at / speed;
        b = (most[k] - at) / speed;
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    if (!(from <= to))
        return -1.0;
    t = from;
    above = x[1] + t * d[1] - ground(f, u + t * du, v + t * dv);
    while (t < to && left-- > 0) {
        double next = fmin(fmin(next_line(u, du, t), next_line(v, dv, t)), fmin(next_line(u + v, du + dv, t), to));
        double then = x[1] + next * d[1] - ground(f, u + next * du, v + next * dv);
        if (above * then <= 0.0 && above != then)
            return t + (next - t) * above / (above - then);
        t = next;
        above = then;
    }
    return -1.0;
}

/* Cast `count` rays, each 7 doubles in the sensor's frame: start, unit direction, length.
 * `frame` is that frame: position and quaternion. Geoms of the body numbered `owner` are not seen (0: all are).
 * Out: for each ray the distance from its start, DBL_MAX if nothing was hit, and the geom's row, or -1. */
static void scan(context *c, const double *frame, const double *rays, int64_t count, int64_t owner, double *ranges,
                 int64_t *rows)
{
    gathering g = {c, owner, NULL, 0, 0};
    double *world_rays = malloc((size_t)(count > 0 ? count : 1) * 6 * sizeof(double));
    double low[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    int64_t i, j;
    int k;

    for (i = 0; i < count; i++) {
        ranges[i] = DBL_MAX;
        rows[i] = -1;
    }
    if (!world_rays || count <= 0) {
        free(world_rays);
        return;
    }
    for (i = 0; i < count; i++) {
        double *start = world_rays + 6 * i, *dir = start + 3, from[3], to[3];
        int finite = 1;
        rotate(frame + 3, rays + 7 * i, start);
        rotate(frame + 3, rays + 7 * i + 3, dir);
        for (k = 0; k < 3; k++) {
            start[k] += frame[k];
            from[k] = start[k];
            to[k] = start[k] + rays[7 * i + 6] * dir[k];
            finite &= isfinite(from[k]) && isfinite(to[k]);
        }
        /* ODE's assertions fail on such numbers, and on a ray without a direction. */
        if (!finite || !(dir[0] || dir[1] || dir[2])) {
            start[0] = NAN;
            continue;
        }
        for (k = 0; k < 3; k++) {
            double a = from[k] < to[k] ? from[k] : to[k], b = from[k] < to[k] ? to[k] : from[k];
            if (a < low[k])
                low[k] = a;
            if (b > high[k])
                high[k] = b;
        }
    }
    if (low[0] > high[0]) { /* no ray is finite */
        free(world_rays);
        return;
    }
    dGeomBoxSetLengths(c->probe, high[0] - low[0] + 1e-6, high[1] - low[1] + 1e-6, high[2] - low[2] + 1e-6);
    dGeomSetPosition(c->probe, 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]));
    dSpaceCollide2(c->probe, c->space, &g, gather);

    for (i = 0; i < count; i++) {
        const double *start = world_rays + 6 * i, *dir = start + 3;
        double length = rays[7 * i + 6];
        int set = 0;
        if (isnan(start[0]))
            continue;
        for (j = 0; j < g.count; j++) {
            contact_geom hit;
            if (!may_hit(start, dir, length, g.list[j].box))
                continue;
            if (g.list[j].field) {
                double depth = meet_field(g.list[j].field, start, dir, length);
                if (depth >= 0.0 && depth < ranges[i]) {
                    ranges[i] = depth;
                    rows[i] = (int64_t)(intptr_t)dGeomGetData(g.list[j].geom);
                }
                continue;
            }
            if (!set) {
                dGeomRaySetLength(c->ray, length);
                dGeomRaySet(c->ray, start[0], start[1], start[2], dir[0], dir[1], dir[2]);
                set = 1;
            }
            if (collide_pair(c, c->ray, g.list[j].geom, 1, &hit, sizeof hit) && hit.depth < ranges[i]) {
                ranges[i] = hit.depth;
                rows[i] = (int64_t)(intptr_t)dGeomGetData(g.list[j].geom);
            }
        }
    }
    free(g.list);
    free(world_rays);
}

void gz_scan(context *c, const double *frame, const double *rays, int64_t count, int64_t owner, double *ranges,
             int64_t *rows)
{
    enter_ode(c);
    scan(c, frame, rays, count, owner, ranges, rows);
    leave_ode();
}
