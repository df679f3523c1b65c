/* Ray scans: dCollide() of each ray with the geoms whose bounding boxes it meets, by the slab method. */
#include "step.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

typedef struct {
    void *geom;
    double box[6]; /* its bounding box: x min, x max, y min, ... */
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
