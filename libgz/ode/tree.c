/* Islands solved along the tree of their joints, at a cost that grows with their bodies and not with the cube of their rows.
 *
 * ODE says what its joints demand (rows of a Jacobian, as in its own solvers); what is found is given to ODE as efforts on
 * the bodies, and ODE moves them. Rows without bounds of joints that form a tree are eliminated from the leaves to the root,
 * block by block: D. Baraff, Linear-time dynamics using Lagrange multipliers, SIGGRAPH 1996. What is left, contacts, motors,
 * limits and joints that close loops, is a small dense problem (boxes.c) in which only paths towards the root meet.
 *
 * With the velocities v, the inertia M, the impulses p, rows J, softness C and aims c: M v = g + J^T p and J v + C p = c,
 * where g is the momentum that the bodies would have without joints. */
#include "boxes.h"
#include "tree.h"

#include <math.h>
#include <string.h>

enum { MOST_DENSE = 1000 }; /* rows; ODE solves islands with more of them */

/* Small dense algebra ------------------------------------------------------------------------------------------ */

/* The lower factor of a positive matrix, in place, with reciprocals on the diagonal; 0 if it is not positive. */
static inline int factorise(double a[][MOTIONS])
{
    int i, j, k;
    for (j = 0; j < MOTIONS; j++) {
        double sum = a[j][j];
        for (k = 0; k < j; k++)
            sum -= a[j][k] * a[j][k];
        if (!(sum > 0.0))
            return 0;
        a[j][j] = 1.0 / sqrt(sum);
        for (i = j + 1; i < MOTIONS; i++) {
            sum = a[i][j];
            for (k = 0; k < j; k++)
                sum -= a[i][k] * a[j][k];
            a[i][j] = sum * a[j][j];
        }
    }
    return 1;
}

static inline void solve_lower(const double l[][MOTIONS], double *x)
{
    int i, k;
#pragma GCC unroll 6
    for (k = 0; k < MOTIONS; k++) {
        x[k] *= l[k][k];
#pragma GCC unroll 6
        for (i = k + 1; i < MOTIONS; i++)
            x[i] -= l[i][k] * x[k];
    }
}

static inline void solve_upper(const double l[][MOTIONS], double *x)
{
    int i, k;
    for (i = MOTIONS - 1; i >= 0; i--) {
        for (k = i + 1; k < MOTIONS; k++)
            x[i] -= l[k][i] * x[k];
        x[i] *= l[i][i];
    }
}

static inline double dot_of(const double *a, const double *b)
{
    return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]) + (a[4] * b[4] + a[5] * b[5]);
}

/* Solving ----------------------------------------------------------------------------------------------------- */

/* Factorise from the leaves to the root, with the loads; 0 if that is not possible. */
static int eliminate(island *w)
{
    int64_t at;
    int i, k, m;
    for (at = w->order_count - 1; at >= 0; at--) {
        tree_body *b = w->bodies + w->order[at], *p;
        tree_joint *j;
        if (!factorise(b->factor))
            return 0;
        solve_lower(b->factor, b->load);
        if (b->joint < 0)
            continue;
        j = w->joints + b->joint;
        m = j->free;
        for (i = 0; i < m; i++) {
            const tree_row *r = w->rows + j->first + i;
            memcpy(j->child[i], r->line[j->side], sizeof j->child[i]);
            solve_lower(b->factor, j->child[i]);
            memcpy(j->parent[i], r->line[1 - j->side], sizeof j->parent[i]);
            j->load[i] = r->aim - dot_of(j->child[i], b->load);
            for (k = 0; k <= i; k++)
                j->factor[i][k] = dot_of(j->child[i], j->child[k]);
            j->factor[i][i] += r->softness;
        }
        for (; i < MOST_ROWS; i++)
            j->factor[i][i] = 1.0; /* the other numbers of these rows are zeros */
        if (!factorise(j->factor))
            return 0;
        solve_lower(j->factor, j->load);
        if (b->parent < 0)
            continue;
        p = w->bodies + b->parent;
        for (i = 0; i < MOST_ROWS; i++) {
            for (k = 0; k < i; k++) {
                int a;
                for (a = 0; a < MOTIONS; a++)
                    j->parent[i][a] -= j->factor[i][k] * j->parent[k][a];
            }
            for (k = 0; k < MOTIONS; k++)
                j->parent[i][k] *= j->factor[i][i];
        }
        for (i = 0; i < MOTIONS; i++) {
            for (k = 0; k < MOST_ROWS; k++)
                p->load[i] += j->parent[k][i] * j->load[k];
            for (k = 0; k <= i; k++) {
                int a;
                for (a = 0; a < MOST_ROWS; a++)
                    p->factor[i][k] += j->parent[a][i] * j->parent[a][k];
            }
        }
    }
    return 1;
}

/* Carry a dense row forward along the paths from its bodies to the root. */
static int follow(island *w, int64_t place)
{
    const tree_row *r = w->rows + w->dense[place];
    int64_t ends[2] = {w->joints[r->joint].body[0], w->joints[r->joint].body[1]};
    double carried[2][MOTIONS];
    int i, k;
    memcpy(carried, r->line, sizeof carried);
    while (ends[0] >= 0 || ends[1] >= 0) {
        /* The end that is farther from the root; both where they meet. */
        int64_t ranks[2] = {ends[0] < 0 ? -1 : w->bodies[ends[0]].rank, ends[1] < 0 ? -1 : w->bodies[ends[1]].rank};
        int far = ranks[1] > ranks[0];
        tree_body *b = w->bodies + ends[far];
        const tree_joint *j = b->joint < 0 ? NULL : w->joints + b->joint;
        station *s;
        GROW(stations, station_capacity, w->station_count + 1);
        s = w->stations + w->station_count;
        s->row = place;
        s->at = ends[far];
        s->previous = b->met;
        b->met = w->station_count++;
        memcpy(s->body, carried[far], sizeof s->body);
        if (ranks[0] == ranks[1]) {
            for (i = 0; i < MOTIONS; i++)
                s->body[i] += carried[1 - far][i];
            ends[1 - far] = -1;
        }
        solve_lower(b->factor, s->body);
        ends[far] = b->parent;
        if (!j) {
            memset(s->joint, 0, sizeof s->joint);
            continue;
        }
        for (i = 0; i < MOST_ROWS; i++)
            s->joint[i] = -dot_of(j->child[i], s->body);
        solve_lower(j->factor, s->joint);
        memset(carried[far], 0, sizeof carried[far]);
        for (k = 0; k < MOST_ROWS; k++)
            for (i = 0; i < MOTIONS; i++)
                carried[far][i] += j->parent[k][i] * s->joint[k];
    }
    return 1;
}

/* List the rows that are no part of the tree. */
static int list_dense(island *w)
{
    int64_t i;
    w->dense_count = w->station_count = 0;
    for (i = 0; i < w->row_count; i++) {
        const tree_joint *j = w->joints + w->rows[i].joint;
        if (j->side >= 0 && i - j->first < j->free)
            continue;
        GROW(dense, dense_capacity, w->dense_count + 1);
        w->rows[i].place = w->dense_count;
        w->dense[w->dense_count++] = i;
    }
    return w->dense_count <= MOST_DENSE;
}

/* The matrix of the dense problem, and what its rows still miss: only rows that meet at a body know of each other. */
static void compare(const island *w, int64_t n, double *a, double *missing)
{
    int64_t i, k;
    memset(a, 0, (size_t)(n * n) * sizeof *a);
    for (i = 0; i < n; i++)
        missing[i] = w->rows[w->dense[i]].aim;
    for (i = 0; i < w->station_count; i++) {
        const station *one = w->stations + i;
        const tree_body *b = w->bodies + one->at;
        double *elements = a + one->row * n;
        missing[one->row] -= dot_of(one->body, b->load);
        if (b->joint >= 0)
            missing[one->row] += dot_of(one->joint, w->joints[b->joint].load);
        for (k = i; k >= 0; k = w->stations[k].previous) {
            const station *two = w->stations + k;
            elements[two->row] += dot_of(one->body, two->body) - dot_of(one->joint, two->joint);
        }
    }
    for (i = 0; i < n; i++) {
        a[i * n + i] += w->rows[w->dense[i]].softness;
        for (k = 0; k < i; k++)
            a[k * n + i] = a[i * n + k];
    }
}

/* Find the impulses of the rows that are no part of the tree. As in ODE, friction has the bounds that the contacts' normal
 * impulses have without friction. */
static int solve_dense(island *w)
{
    int64_t i, n;
    double *a, *b, *low, *high, *x;
    box_problem problem;
    int rubs = 0;
    if (!list_dense(w))
        return 0;
    n = w->dense_count;
    GROW(places, place_capacity, n);
    GROW(numbers, number_capacity, n * n + 4 * n + n * (n + 3));
    a = w->numbers;
    b = a + n * n;
    low = b + n;
    high = low + n;
    x = high + n;
    w->station_count = 0;
    for (i = 0; i < n; i++)
        if (!follow(w, i))
            return 0;
    compare(w, n, a, b);
    for (i = 0; i < n; i++) {
        const tree_row *r = w->rows + w->dense[i];
        low[i] = r->normal < 0 ? r->low : 0.0;
        high[i] = r->normal < 0 ? r->high : 0.0;
        w->places[i] = FREE;
        x[i] = 0.0;
    }
    problem = (box_problem){n, a, b, low, high, w->places, x, x + n};
    if (!solve_box(&problem))
        return 0;
    for (i = 0; i < n; i++) {
        const tree_row *r = w->rows + w->dense[i];
        if (r->normal < 0)
            continue;
        high[i] = fabs(r->high * x[w->rows[r->normal].place]);
        low[i] = -high[i];
        w->places[i] = FREE;
        rubs |= high[i] > 0.0;
    }
    if (rubs && !solve_box(&problem))
        return 0;
    for (i = 0; i < n; i++)
        w->rows[w->dense[i]].impulse = x[i];
    return 1;
}

/* The impulses of the tree's rows, from the root to the leaves. */
static void substitute(island *w)
{
    int64_t i, at;
    int k;
    for (i = 0; i < w->station_count; i++) {
        const station *s = w->stations + i;
        double x = w->rows[w->dense[s->row]].impulse;
        tree_body *b = w->bodies + s->at;
        for (k = 0; k < MOTIONS; k++)
            b->load[k] += x * s->body[k];
        if (b->joint >= 0)
            for (k = 0; k < MOST_ROWS; k++)
                w->joints[b->joint].load[k] += x * s->joint[k];
    }
    for (at = 0; at < w->body_count; at++) {
        tree_body *b = w->bodies + w->order[at];
        memcpy(b->velocity, b->load, sizeof b->velocity);
        if (b->joint >= 0) {
            tree_joint *j = w->joints + b->joint;
            if (b->parent >= 0)
                for (k = 0; k < MOST_ROWS; k++)
                    j->load[k] -= dot_of(j->parent[k], w->bodies[b->parent].velocity);
            solve_upper(j->factor, j->load);
            for (k = 0; k < j->free; k++) {
                int a;
                w->rows[j->first + k].impulse = j->load[k];
                for (a = 0; a < MOTIONS; a++)
                    b->velocity[a] += j->child[k][a] * j->load[k];
            }
        }
        solve_upper(b->factor, b->velocity);
    }
}

/* Whether all impulses are numbers. */
static int is_finite(const island *w)
{
    int64_t i;
    for (i = 0; i < w->row_count; i++)
        if (!isfinite(w->rows[i].impulse))
            return 0;
    return 1;
}

/* Let the joints of the island act as efforts; they have no part in ODE's step. */
static int apply(const context *c, island *w)
{
    double rate = 1.0 / c->step;
    int64_t i;
    int k, side, row;
    GROW(disabled, disabled_capacity, w->disabled_count + w->joint_count);
    for (i = 0; i < w->joint_count; i++) {
        const tree_joint *j = w->joints + i;
        feedback *f = dJointGetFeedback(j->joint);
        double effort[2][MOTIONS] = {{0.0}};
        for (row = 0; row < j->rows; row++)
            for (side = 0; side < 2; side++)
                for (k = 0; k < MOTIONS; k++)
                    effort[side][k] += w->rows[j->first + row].impulse * rate * w->rows[j->first + row].line[side][k];
        for (side = 0; side < 2; side++)
            if (j->body[side] >= 0)
                for (k = 0; k < MOTIONS; k++)
                    w->bodies[j->body[side]].effort[k] += effort[side][k];
        if (f) {
            memcpy(f->f1, effort[0], 3 * sizeof(double));
            memcpy(f->t1, effort[0] + 3, 3 * sizeof(double));
            memcpy(f->f2, effort[1], 3 * sizeof(double));
            memcpy(f->t2, effort[1] + 3, 3 * sizeof(double));
        }
        dJointDisable(j->joint);
        w->disabled[w->disabled_count++] = j->joint;
    }
    for (i = 0; i < w->body_count; i++) {
        const tree_body *b = w->bodies + i;
        const double *force = dBodyGetForce(b->body), *torque = dBodyGetTorque(b->body), *e = b->effort;
        dBodySetForce(b->body, force[0] + e[0], force[1] + e[1], force[2] + e[2]);
        dBodySetTorque(b->body, torque[0] + e[3], torque[1] + e[4], torque[2] + e[5]);
    }
    return 1;
}

/* Number the bodies; 0 without memory. */
int begin_trees(context *c)
{
    int64_t i;
    if (!c->work->trees)
        c->work->trees = calloc(1, sizeof *c->work->trees);
    if (!c->work->trees || !have_members(c))
        return 0;
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i]) {
            c->work->members[i] = alone(i, 0);
            c->work->members[i].place = -1;
            dBodySetData(c->bodies[i], (void *)(intptr_t)i);
        }
    return 1;
}

/* 0 if ODE has to solve the island. */
static int solve_island(const context *c, island *w, int64_t row)
{
    if (!collect(c, w, row) || !w->row_count || !grow_tree(w) || !eliminate(w) || !solve_dense(w))
        return 0;
    substitute(w);
    return is_finite(w) && apply(c, w);
}

/* Take back what motors at a limit have applied: they do so again when ODE asks for their rows. */
static void take_back(const island *w)
{
    int64_t i;
    for (i = 0; i < w->body_count; i++) {
        const double *e = w->bodies[i].applied;
        dBodySetForce(w->bodies[i].body, e[0], e[1], e[2]);
        dBodySetTorque(w->bodies[i].body, e[3], e[4], e[5]);
    }
}

/* Solve all islands that are awake; those that cannot be solved so are left to ODE. */
void solve_trees(context *c)
{
    island *w = c->work->trees;
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        if (!moves(body) || !dBodyIsEnabled(body) || c->work->members[i].place >= 0)
            continue;
        if (!solve_island(c, w, i))
            take_back(w);
    }
}

/* Give the joints back to ODE. */
void release_trees(const context *c)
{
    island *w = c->work->trees;
    while (w && w->disabled_count > 0)
        dJointEnable(w->disabled[--w->disabled_count]);
}

void free_trees(struct trees *w)
{
    if (!w)
        return;
    free(w->bodies);
    free(w->joints);
    free(w->rows);
    free(w->order);
    free(w->dense);
    free(w->places);
    free(w->stations);
    free(w->numbers);
    free(w->disabled);
    free(w);
}
