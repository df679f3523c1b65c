/* The memory of a world's step. It belongs to the world, so that worlds may step beside each other. */
#include "step.h"

#include <stdlib.h>

/* Give a world the memory of its step, and have ODE queue its calls there; 0 without memory. ODE makes its own memory in a
 * step; it needs it to write the rows of motors at a limit (tree.c), so it makes one while there is nothing to move. */
int gz_open(context *c)
{
    c->work = calloc(1, sizeof *c->work);
    if (!c->work)
        return 0;
    dWorldSetStepThreadingImplementation(c->world, &gz_call_functions, &c->work->calls);
    c->work->stepped = dWorldStep(c->world, 1.0);
    return 1;
}

int64_t gz_calls_made(const context *c) { return c->work->calls.made; }

/* Free it, and what is recorded in a step, after the world. */
void gz_close(context *c)
{
    struct workspace *w = c->work;
    free(c->records);
    free(c->pending);
    free(c->touches);
    free(c->overlaps);
    free(c->points);
    free(c->earlier);
    if (w) {
        free(w->members);
        free(w->groups);
        free(w->held);
        free(w->ranked);
        free(w->resting_bodies);
        free(w->resting_points);
        free(w->movable_boxes);
        free(w->far);
        free(w->stops);
        free(w->kept_bodies);
        gz_free_resting(&w->resting);
        gz_free_calls(&w->calls);
        free_trees(w->trees);
        free(w);
    }
    c->work = NULL;
    c->records = NULL;
    c->pending = NULL;
    c->touches = NULL;
    c->overlaps = NULL;
    c->points = NULL;
    c->earlier = NULL;
    c->record_count = c->record_capacity = c->touch_count = c->touch_capacity = 0;
    c->overlap_count = c->overlap_capacity = c->point_count = c->point_capacity = 0;
    c->earlier_count = c->earlier_capacity = 0;
}
