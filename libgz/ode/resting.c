/* Contacts of bodies at rest, solved at once.
 *
 * Where every contact carries and none slides, contacts are linear: M v = M v0 + J' p and J v + E p = c, with velocities v,
 * momentum M v0 without contacts, impulses p, softness E and velocities to reach c. Without p this is one positive
 * definite system of the bodies' size, (M + J' E^-1 J) v = M v0 + J' E^-1 c. A stack's matrix is narrow: its Cholesky
 * factor, within the profile, costs in proportion to the number of bodies, where the linear complementarity problem costs
 * the cube of the number of contacts. Contacts that would pull are left out, and the rest is solved again. If friction is
 * exceeded somewhere, it is not this case. */

#include "memory.h"
#include "resting.h"

#include <math.h>
#include <stdlib.h>

enum { SELECTIONS = 12, MOST_SELECTIONS = 100, PASSES = 8 };
enum { UNCHANGED, TAKEN, LEFT_OUT }; /* what became of points in a selection, in this order of weight */
#define SETTLED 1e-8 /* [m/s] */

static int have_memory(resting_memory *m, const resting_body *bodies, int64_t count)
{
    int64_t i, r, size = 0;
    int64_t *starts = enlarged(m->starts, &m->starts_capacity, MOTIONS * count, sizeof *starts);
    double *solution = enlarged(m->solution, &m->solution_capacity, MOTIONS * count, sizeof *solution), *factor;
    if (starts)
        m->starts = starts;
    if (solution)
        m->solution = solution;
    if (!starts || !solution)
        return 0;
    for (i = 0; i < count; i++)
        for (r = 0; r < MOTIONS; r++) {
            starts[MOTIONS * i + r] = size - MOTIONS * bodies[i].nearest; /* so that columns need no other offset */
            size += MOTIONS * (i - bodies[i].nearest) + r + 1;
        }
    factor = enlarged(m->factor, &m->factor_capacity, size, sizeof *factor);
    if (!factor)
        return 0;
    m->factor = factor;
    for (i = 0; i < size; i++)
        factor[i] = 0.0;
    return 1;
}

void gz_free_resting(resting_memory *m)
{
    free(m->factor);
    free(m->solution);
    free(m->starts);
    *m = (resting_memory){0};
}

/* Add one point's weighted rows for two bodies, of which the first is not before the second. */
static void add_block(const resting_memory *m, const resting_point *p, int one, int two)
{
    int64_t row = MOTIONS * p->body[one], column = MOTIONS * p->body[two];
    const double(*columns)[MOTIONS] = p->rows[two];
    int a, b;
    for (a = 0; a < MOTIONS; a++) {
        double *restrict line = m->factor + m->starts[row + a] + column;
        double left[DIRECTIONS] = {p->weight[0] * p->rows[one][0][a], p->weight[1] * p->rows[one][1][a],
                                   p->weight[2] * p->rows[one][2][a]};
        int width = one == two ? a + 1 : MOTIONS;
        for (b = 0; b < width; b++)
            line[b] = ((line[b] + left[0] * columns[0][b]) + left[1] * columns[1][b]) + left[2] * columns[2][b];
    }
}

/* Add the sum of rows times factors to a body's motions. */
static void add_rows(const double rows[DIRECTIONS][MOTIONS], const double *factors, double *restrict sum)
{
    double one = factors[0], two = factors[1], three = factors[2];
    int a;
    for (a = 0; a < MOTIONS; a++)
        sum[a] = ((sum[a] + rows[0][a] * one) + rows[1][a] * two) + rows[2][a] * three;
}

static void assemble(const resting_memory *m, const resting_body *bodies, int64_t body_count,
                     const resting_point *points, int64_t point_count)
{
    double *factor = m->factor;
    const int64_t *starts = m->starts;
    int64_t i;
    int a, b;
    for (i = 0; i < body_count; i++)
        for (a = 0; a < 3; a++) {
            factor[starts[MOTIONS * i + a] + MOTIONS * i + a] = bodies[i].mass;
            for (b = 0; b <= a; b++)
                factor[starts[MOTIONS * i + 3 + a] + MOTIONS * i + 3 + b] = bodies[i].inertia[a][b];
        }
    for (i = 0; i < point_count; i++) {
        const resting_point *p = points + i;
        if (!p->active)
            continue;
        for (a = 0; a < 2; a++)
            if (p->body[a] >= 0)
                add_block(m, p, a, a);
        if (p->body[0] >= 0 && p->body[1] >= 0)
            add_block(m, p, p->body[0] < p->body[1], p->body[0] > p->body[1]);
    }
}

/* Cholesky's factor within the profile; the inverse of its diagonal is stored. 0 if the matrix is not definite. */
static int factorize(const resting_memory *memory, const resting_body *bodies, int64_t body_count)
{
    double *factor = memory->factor;
    const int64_t *starts = memory->starts;
    int64_t i, j, k, m, row = 0;
    for (m = 0; m < body_count; m++) {
        int64_t first = MOTIONS * bodies[m].nearest, end = row + MOTIONS, n;
        for (i = row; i < end; i++) {
            double *restrict line = factor + starts[i], sum;
            for (j = first, n = bodies[m].nearest; j < i; n++) {
                int64_t begin = MOTIONS * bodies[n].nearest, next = MOTIONS * (n + 1);
                for (begin = first > begin ? first : begin; j < next && j < i; j++) {
                    const double *above = factor + starts[j];
                    sum = line[j];
                    for (k = begin; k < j; k++)
                        sum = sum - line[k] * above[k];
                    line[j] = sum * above[j];
                }
            }
            sum = line[i];
            for (k = first; k < i; k++)
                sum = sum - line[k] * line[k];
            if (!(sum > 0.0))
                return 0;
            line[i] = 1.0 / sqrt(sum);
        }
        row = end;
    }
    return 1;
}

/* The velocities, where `solution` holds the momenta. */
static void substitute(const resting_memory *m, const resting_body *bodies, int64_t body_count)
{
    const double *factor = m->factor;
    const int64_t *starts = m->starts;
    double *solution = m->solution;
    int64_t i, k;
    for (i = 0; i < MOTIONS * body_count; i++) {
        const double *line = factor + starts[i];
        double sum = solution[i];
        for (k = MOTIONS * bodies[i / MOTIONS].nearest; k < i; k++)
            sum = sum - line[k] * solution[k];
        solution[i] = sum * line[i];
    }
    for (i = MOTIONS * body_count - 1; i >= 0; i--) {
        const double *line = factor + starts[i];
        solution[i] = solution[i] * line[i];
        for (k = MOTIONS * bodies[i / MOTIONS].nearest; k < i; k++)
            solution[k] = solution[k] - line[k] * solution[i];
    }
}

/* The velocity of a point in a direction. */
static double speed(const resting_memory *m, const resting_point *p, int k)
{
    double sum = 0.0;
    int side, a;
    for (side = 0; side < 2; side++)
        if (p->body[side] >= 0)
            for (a = 0; a < MOTIONS; a++)
                sum = sum + p->rows[side][k][a] * m->solution[MOTIONS * p->body[side] + a];
    return sum;
}

/* One solution with the impulses that were found before; returns how much velocity the slack changed [m/s]. */
static double repeat(const resting_memory *m, const resting_body *bodies, int64_t body_count, resting_point *points,
                     int64_t point_count)
{
    double *solution = m->solution;
    double moved = 0.0, parts[DIRECTIONS];
    int64_t i;
    int k, side, a;
    for (i = 0; i < body_count; i++)
        for (a = 0; a < MOTIONS; a++)
            solution[MOTIONS * i + a] = bodies[i].momentum[a];
    for (i = 0; i < point_count; i++) {
        const resting_point *p = points + i;
        if (!p->active)
            continue;
        for (k = 0; k < DIRECTIONS; k++)
            parts[k] = p->weight[k] * ((k ? 0.0 : p->aim) + p->slack[k] * p->impulse[k]);
        for (side = 0; side < 2; side++)
            if (p->body[side] >= 0)
                add_rows(p->rows[side], parts, solution + MOTIONS * p->body[side]);
    }
    substitute(m, bodies, body_count);
    for (i = 0; i < point_count; i++) {
        resting_point *p = points + i;
        if (!p->active)
            continue;
        for (k = 0; k < DIRECTIONS; k++) {
            double impulse = p->weight[k] * (((k ? 0.0 : p->aim) + p->slack[k] * p->impulse[k]) - speed(m, p, k));
            double change = p->slack[k] * fabs(impulse - p->impulse[k]);
            p->impulse[k] = impulse;
            if (!(change <= moved)) /* so that a number which is none stays */
                moved = change;
        }
    }
    return moved;
}

/* Leave out what pulls, and take back what bodies would enter. */
static int select_points(const resting_memory *m, resting_point *points, int64_t count)
{
    int changed = UNCHANGED, k;
    int64_t i;
    for (i = 0; i < count; i++) {
        resting_point *p = points + i;
        int active = p->active ? p->impulse[0] >= 0.0 : speed(m, p, 0) < p->aim;
        if (active != p->active && changed != LEFT_OUT)
            changed = active ? TAKEN : LEFT_OUT;
        p->active = active;
        if (!active)
            for (k = 0; k < DIRECTIONS; k++)
                p->impulse[k] = 0.0;
    }
    return changed;
}

static int within_friction(const resting_point *points, int64_t count)
{
    int64_t i;
    int k;
    for (i = 0; i < count; i++)
        for (k = 0; k < 2; k++)
            if (fabs(points[i].impulse[k + 1]) > points[i].mu[k] * points[i].impulse[0])
                return 0;
    return 1;
}

static void add_up(resting_body *bodies, int64_t body_count, const resting_point *points, int64_t point_count)
{
    int64_t i;
    int side, a;
    for (i = 0; i < body_count; i++)
        for (a = 0; a < MOTIONS; a++)
            bodies[i].impulse[a] = 0.0;
    for (i = 0; i < point_count; i++)
        for (side = 0; side < 2; side++)
            if (points[i].body[side] >= 0)
                add_rows(points[i].rows[side], points[i].impulse, bodies[points[i].body[side]].impulse);
}

/* Find the impulses of points and bodies; 0 if contacts slide, or without memory. */
int gz_solve_resting(resting_memory *m, resting_body *bodies, int64_t body_count, resting_point *points,
                     int64_t point_count)
{
    int64_t i;
    int selection, pass, k, changed;
    for (i = 0; i < point_count; i++) {
        resting_point *p = points + i;
        p->active = 1;
        for (k = 0; k < DIRECTIONS; k++) {
            p->impulse[k] = 0.0;
            p->weight[k] = k && !(p->mu[k - 1] > 0.0) ? 0.0 : 1.0 / (p->softness[k] + p->slack[k]);
        }
    }
    for (selection = 0; selection < MOST_SELECTIONS; selection++) {
        if (!have_memory(m, bodies, body_count))
            return 0;
        assemble(m, bodies, body_count, points, point_count);
        if (!factorize(m, bodies, body_count))
            return 0;
        for (pass = 0; pass < PASSES; pass++)
            if (repeat(m, bodies, body_count, points, point_count) <= SETTLED)
                break;
        if (pass == PASSES)
            return 0;
        changed = select_points(m, points, point_count);
        if (changed == LEFT_OUT && selection >= SELECTIONS)
            return 0; /* where points are only taken back, there is an end: a stack lands from bottom to top */
        if (changed)
            continue;
        if (!within_friction(points, point_count))
            return 0;
        add_up(bodies, body_count, points, point_count);
        return 1;
    }
    return 0;
}
