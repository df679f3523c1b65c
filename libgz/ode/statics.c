/* What does not move, and that nothing movable is near, is left out while ODE looks for pairs: its hash space makes a table
 * of all boxes in each step. The pairs that are left come in the same order, because that is the order of the geoms. Of few
 * boxes it is quicker to see first whether any two meet at all. */
#include "memory.h"
#include "step.h"

#include <math.h>

enum { FEW = 16 };           /* geoms and spaces, of which none is left out */
enum { MOST_MOVABLE = 64 };  /* beyond them, only the box around all counts */

typedef double bounds[6]; /* least and most x, y, z */

static int is_movable(void *geom)
{
    int i, count;
    if (!dGeomIsSpace(geom))
        return dGeomGetBody(geom) != NULL;
    count = dSpaceGetNumGeoms(geom);
    for (i = 0; i < count; i++)
        if (is_movable(dSpaceGetGeom(geom, i)))
            return 1;
    return 0;
}

/* ODE's own test. */
static int are_apart(const double *a, const double *b)
{
    return a[0] > b[1] || a[1] < b[0] || a[2] > b[3] || a[3] < b[2] || a[4] > b[5] || a[5] < b[4];
}

static int is_far(const double *box, bounds *movable, int64_t count, const double *around)
{
    int64_t i;
    if (are_apart(box, around))
        return 1;
    for (i = 0; count <= MOST_MOVABLE && i < count; i++)
        if (!are_apart(box, movable[i]))
            return 0;
    return count <= MOST_MOVABLE;
}

/* A number that is NaN changes nothing. */
static void widen(double *around, const double *box)
{
    int k;
    for (k = 0; k < 6; k += 2) {
        around[k] = smaller(box[k], around[k]);
        around[k + 1] = larger(box[k + 1], around[k + 1]);
    }
}

/* Leave out what is far; where there is no memory, nothing. */
void leave_out_far(context *c)
{
    struct workspace *w = c->work;
    int64_t movable = 0, i, found = 0;
    int count = dSpaceGetNumGeoms(c->space), n;
    bounds around = {HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL}, box, *boxes;
    void **far;
    w->far_count = 0;
    if (count < FEW)
        return;
    boxes = enlarged(w->movable_boxes, &w->movable_capacity, count, sizeof *boxes);
    w->movable_boxes = boxes ? boxes : w->movable_boxes;
    far = enlarged(w->far, &w->far_capacity, count, sizeof *far);
    w->far = far ? far : w->far;
    if (!boxes || !far)
        return;
    for (n = 0; n < count; n++) {
        void *geom = dSpaceGetGeom(c->space, n);
        if (!dGeomIsEnabled(geom))
            continue;
        if (is_movable(geom)) {
            dGeomGetAABB(geom, boxes[movable]);
            widen(around, boxes[movable++]);
        } else
            far[found++] = geom;
    }
    for (i = 0; i < found; i++) {
        dGeomGetAABB(far[i], box);
        if (!is_far(box, boxes, movable, around))
            continue;
        dGeomDisable(far[i]);
        far[w->far_count++] = far[i];
    }
}

/* Whether ODE's search may find a pair. The geoms have their places and order then, as after the search. */
int may_meet(const context *c)
{
    bounds boxes[FEW];
    int count = dSpaceGetNumGeoms(c->space), found = 0, n, i;
    if (count < 2 || count >= FEW)
        return 1;
    dSpaceClean(c->space);
    for (n = 0; n < count; n++) {
        void *geom = dSpaceGetGeom(c->space, n);
        if (!dGeomIsEnabled(geom) || (dGeomIsSpace(geom) && !dSpaceGetNumGeoms(geom)))
            continue;
        dGeomGetAABB(geom, boxes[found]);
        for (i = 0; i < found; i++)
            if (!are_apart(boxes[i], boxes[found]))
                return 1;
        found++;
    }
    return 0;
}

void bring_back_far(const context *c)
{
    int64_t i;
    for (i = 0; i < c->work->far_count; i++)
        dGeomEnable(c->work->far[i]);
    c->work->far_count = 0;
}
