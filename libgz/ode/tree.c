/* Islands solved along the tree of their joints, at a cost that grows with their bodies and not with the cube of their rows.
 *
 * ODE says what its joints demand (rows of a Jacobian, as in its own solvers); what is found is given to ODE as efforts on
 * the bodies, and ODE moves them. Rows of joints that form a tree are eliminated from the leaves to the root, block by block:
 * D. Baraff, Linear-time dynamics using Lagrange multipliers, SIGGRAPH 1996. What is left, contacts, joints that close loops,
 * and motors and limits at their bounds, is a small dense problem (boxes.c) in which only paths towards the root meet.
 *
 * With the velocities v, the inertia M, the impulses p, rows J, softness C and aims c: M v = g + J^T p and J v + C p = c,
 * where g is the momentum that the bodies would have without joints. */
#include "boxes.h"
#include "tree.h"

#include <math.h>
#include <string.h>

/* Also compiled for processors with wider vectors, with all that is called: the same operations, to the last bit, for none of
 * them is fused. Chosen when the library is loaded, which needs the GNU C library. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define FOR_WIDE_VECTORS __attribute__((flatten, target_clones("avx2", "default")))
#else
#define FOR_WIDE_VECTORS
#endif

enum { MOST_DENSE = 1000 }; /* rows; ODE solves islands with more of them */
enum { GUESSES = 3 };       /* of which rows are at a bound, before none is made */

/* Small dense algebra ------------------------------------------------------------------------------------------ */

/* The upper factor of a positive matrix, in place, with reciprocals on the diagonal; 0 if it is not positive. Below the diagonal
 * anything may be left. The processor waits for each reciprocal, but not for its root. */
static inline int factorise(double a[][MOTIONS])
{
    int i, j, k;
#pragma GCC unroll 6
    for (k = 0; k < MOTIONS; k++) {
        double inverse = 1.0 / a[k][k], root = sqrt(inverse);
        if (!(a[k][k] > 0.0))
            return 0;
#pragma GCC unroll 6
        for (i = k + 1; i < MOTIONS; i++) {
            double part = a[k][i] * inverse;
            for (j = i; j < MOTIONS; j++)
                a[i][j] -= part * a[k][j];
        }
        for (j = k + 1; j < MOTIONS; j++)
            a[k][j] *= root;
        a[k][k] = root;
    }
    return 1;
}

/* Solve for the transpose of such a factor, forward. */
static inline void solve_forward(const double u[][MOTIONS], double *x)
{
    int i, k;
#pragma GCC unroll 6
    for (k = 0; k < MOTIONS; k++) {
        x[k] *= u[k][k];
        for (i = k + 1; i < MOTIONS; i++)
            x[i] -= u[k][i] * x[k];
    }
}

static inline void solve_backward(const double u[][MOTIONS], double *x)
{
    int i, k;
#pragma GCC unroll 6
    for (i = MOTIONS - 1; i >= 0; i--) {
        for (k = i + 1; k < MOTIONS; k++)
            x[i] -= u[i][k] * x[k];
        x[i] *= u[i][i];
    }
}

static inline double dot_of(const double *a, const double *b)
{
    return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]) + (a[4] * b[4] + a[5] * b[5]);
}

/* Matrices with so many columns as `width` says, a constant, so that the compiler makes vectors of their rows. */

/* Solve for all columns of x, forward. */
static inline void solve_columns(const double u[][MOTIONS], double *restrict x, int width)
{
    int i, k, n;
#pragma GCC unroll 6
    for (k = 0; k < MOTIONS; k++) {
        double row[MOTIONS];
        for (n = 0; n < width; n++)
            row[n] = x[k * width + n];
        for (i = 0; i < k; i++)
            for (n = 0; n < width; n++)
                row[n] -= u[i][k] * x[i * width + n];
        for (n = 0; n < width; n++)
            x[k * width + n] = row[n] * u[k][k];
    }
}

enum { ADD, TAKE, SET, SET_MINUS };

/* The product of the transpose of a, which has `rows` columns, and b; both have MOTIONS rows. */
static inline void multiply(double *restrict result, int how, const double *restrict a, int rows, const double *restrict b,
                            int width)
{
    int i, k, n;
    for (i = 0; i < rows; i++) {
        double row[MOTIONS];
        for (n = 0; n < width; n++)
            row[n] = how == ADD || how == TAKE ? result[i * width + n] : 0.0;
        for (k = 0; k < MOTIONS; k++)
            for (n = 0; n < width; n++)
                if (how == ADD || how == SET)
                    row[n] += a[k * rows + i] * b[k * width + n];
                else
                    row[n] -= a[k * rows + i] * b[k * width + n];
        for (n = 0; n < width; n++)
            result[i * width + n] = row[n];
    }
}

static const tree_row no_row = {.softness = 1.0}; /* where a joint or a panel has less than it could have */

/* Solving ----------------------------------------------------------------------------------------------------- */

/* Begin with each body alone. */
static void begin_elimination(island *w)
{
    int64_t at;
    int i, k;
    w->guesses = 0;
    for (at = 0; at < w->body_count; at++) {
        tree_body *b = w->bodies + at;
        for (i = 0; i < 3; i++)
            for (k = 0; k < 3; k++) {
                b->factor[i][k] = i == k ? b->mass : 0.0;
                b->factor[i][3 + k] = b->factor[3 + i][k] = 0.0;
                b->factor[3 + i][3 + k] = b->inertia[i][k];
            }
        memcpy(b->load, b->momentum, sizeof b->load);
        b->met = -1;
    }
}

/* Choose the rows of a joint that are part of the tree, and solve their lines forward, after the body that hangs on it; 0 if
 * that is not possible. */
static int eliminate_joint(island *w, tree_joint *j, const tree_body *b)
{
    double softness[MOST_ROWS];
    int i, k;
    for (i = j->held = 0; i < j->rows; i++) {
        const tree_row *r = w->rows + j->first + i;
        if (r->apart)
            continue;
        w->guesses += !is_unbounded(r);
        j->row[j->held++] = j->first + i;
    }
    for (i = 0; i < MOST_ROWS; i++) {
        const tree_row *r = i < j->held ? w->rows + j->row[i] : &no_row;
        for (k = 0; k < MOTIONS; k++)
            j->child[k][i] = r->line[j->side][k];
        memcpy(j->parent[i], r->line[1 - j->side], sizeof j->parent[i]);
        j->load[i] = r->aim;
        softness[i] = r->softness;
    }
    solve_columns(b->factor, j->child[0], MOST_ROWS);
    multiply(j->load, TAKE, b->load, 1, j->child[0], MOST_ROWS);
    multiply(j->factor[0], SET, j->child[0], MOST_ROWS, j->child[0], MOST_ROWS);
    for (i = 0; i < MOST_ROWS; i++)
        j->factor[i][i] += softness[i];
    if (!factorise(j->factor))
        return 0;
    solve_forward(j->factor, j->load);
    if (b->parent >= 0)
        solve_columns(j->factor, j->parent[0], MOTIONS);
    return 1;
}

/* Factorise from the leaves to the root, with the loads; 0 if that is not possible. */
static int eliminate(island *w)
{
    int64_t at;
    begin_elimination(w);
    for (at = w->order_count - 1; at >= 0; at--) {
        tree_body *b = w->bodies + w->order[at], *p;
        tree_joint *j;
        if (!factorise(b->factor))
            return 0;
        solve_forward(b->factor, b->load);
        if (b->joint < 0)
            continue;
        j = w->joints + b->joint;
        if (!eliminate_joint(w, j, b))
            return 0;
        if (b->parent < 0)
            continue;
        p = w->bodies + b->parent;
        multiply(p->load, ADD, j->load, 1, j->parent[0], MOTIONS);
        multiply(p->factor[0], ADD, j->parent[0], MOTIONS, j->parent[0], MOTIONS);
    }
    return 1;
}

/* The two bodies on which a row of the dense problem acts. */
static const int64_t *ends_of(const island *w, int64_t place)
{
    return w->joints[w->rows[w->dense[place]].joint].body;
}

/* List the rows that are no part of the tree. */
static int list_dense(island *w)
{
    int64_t i;
    w->dense_count = w->panel_count = 0;
    for (i = 0; i < w->row_count; i++) {
        panel *last;
        if (w->joints[w->rows[i].joint].side >= 0 && !w->rows[i].apart)
            continue;
        GROW(dense, dense_capacity, w->dense_count + 1);
        w->rows[i].place = w->dense_count;
        w->dense[w->dense_count++] = i;
        last = w->panel_count ? w->panels + w->panel_count - 1 : NULL;
        if (last && last->count < LANES &&
            !memcmp(ends_of(w, last->first), w->joints[w->rows[i].joint].body, 2 * sizeof(int64_t))) {
            last->count++;
            continue;
        }
        GROW(panels, panel_capacity, w->panel_count + 1);
        w->panels[w->panel_count++] = (panel){w->dense_count - 1, 1};
    }
    return w->dense_count <= MOST_DENSE;
}

/* Carry a panel forward along the paths from its bodies to the root. */
static int follow(island *w, int64_t number)
{
    const panel *p = w->panels + number;
    int64_t ends[2];
    double carried[2][MOTIONS][LANES];
    int i, k;
    memcpy(ends, ends_of(w, p->first), sizeof ends);
    for (i = 0; i < LANES; i++) {
        const tree_row *r = i < p->count ? w->rows + w->dense[p->first + i] : &no_row;
        for (k = 0; k < MOTIONS; k++) {
            carried[0][k][i] = r->line[0][k];
            carried[1][k][i] = r->line[1][k];
        }
    }
    while (ends[0] >= 0 || ends[1] >= 0) {
        /* The end that is farther from the root; both where they meet. */
        int64_t ranks[2] = {ends[0] < 0 ? -1 : w->bodies[ends[0]].rank, ends[1] < 0 ? -1 : w->bodies[ends[1]].rank};
        int far = ranks[1] > ranks[0];
        tree_body *b = w->bodies + ends[far];
        const tree_joint *j = b->joint < 0 ? NULL : w->joints + b->joint;
        station *s;
        GROW(stations, station_capacity, w->station_count + 1);
        s = w->stations + w->station_count;
        s->panel = number;
        s->at = ends[far];
        s->previous = b->met;
        b->met = w->station_count++;
        memcpy(s->body, carried[far], sizeof s->body);
        if (ranks[0] == ranks[1]) {
            for (k = 0; k < MOTIONS; k++)
                for (i = 0; i < LANES; i++)
                    s->body[k][i] += carried[1 - far][k][i];
            ends[1 - far] = -1;
        }
        solve_columns(b->factor, s->body[0], LANES);
        ends[far] = b->parent;
        if (!j) {
            memset(s->joint, 0, sizeof s->joint);
            continue;
        }
        multiply(s->joint[0], SET_MINUS, j->child[0], MOST_ROWS, s->body[0], LANES);
        solve_columns(j->factor, s->joint[0], LANES);
        multiply(carried[far][0], SET, j->parent[0], MOTIONS, s->joint[0], LANES);
    }
    return 1;
}

/* Take from what the rows of a panel miss the share of a body and the joint there. */
static void take_share(const island *w, const station *s, double *missing)
{
    const tree_body *b = w->bodies + s->at;
    double sums[LANES];
    int64_t i;
    multiply(sums, SET, b->load, 1, s->body[0], LANES);
    if (b->joint >= 0)
        multiply(sums, TAKE, w->joints[b->joint].load, 1, s->joint[0], LANES);
    for (i = 0; i < w->panels[s->panel].count; i++)
        missing[w->panels[s->panel].first + i] -= sums[i];
}

/* The matrix of the dense problem, and what its rows still miss: only rows that meet at a body know of each other. */
static void compare(const island *w, int64_t n, double *a, double *missing)
{
    int64_t at, i, k, l;
    memset(a, 0, (size_t)(n * n) * sizeof *a);
    for (i = 0; i < n; i++)
        missing[i] = w->rows[w->dense[i]].aim;
    for (at = 0; at < w->station_count; at++) {
        const station *one = w->stations + at;
        const panel *rows = w->panels + one->panel;
        take_share(w, one, missing);
        for (k = at; k >= 0; k = w->stations[k].previous) {
            const station *two = w->stations + k;
            const panel *columns = w->panels + two->panel;
            double block[LANES][LANES];
            multiply(block[0], SET, one->body[0], LANES, two->body[0], LANES);
            multiply(block[0], TAKE, one->joint[0], LANES, two->joint[0], LANES);
            for (i = 0; i < rows->count; i++)
                for (l = 0; l < columns->count; l++)
                    a[(rows->first + i) * n + columns->first + l] += block[i][l];
        }
    }
    for (i = 0; i < n; i++) {
        a[i * n + i] += w->rows[w->dense[i]].softness;
        for (k = 0; k < i; k++)
            a[k * n + i] = a[i * n + k];
    }
}

/* The velocities, and the impulses of the tree's rows, from the root to the leaves. */
static void substitute(island *w)
{
    int64_t i, at;
    int k;
    for (at = 0; at < w->body_count; at++) {
        tree_body *b = w->bodies + at;
        memcpy(b->velocity, b->load, sizeof b->velocity);
        if (b->joint >= 0)
            memcpy(w->joints[b->joint].impulse, w->joints[b->joint].load, sizeof w->joints[0].impulse);
    }
    for (at = 0; at < w->station_count; at++) {
        const station *s = w->stations + at;
        const panel *p = w->panels + s->panel;
        tree_body *b = w->bodies + s->at;
        double x[LANES] = {0.0};
        for (i = 0; i < p->count; i++)
            x[i] = w->rows[w->dense[p->first + i]].impulse;
        for (k = 0; k < MOTIONS; k++)
            b->velocity[k] += (x[0] * s->body[k][0] + x[1] * s->body[k][1]) + (x[2] * s->body[k][2] + x[3] * s->body[k][3]);
        for (k = 0; b->joint >= 0 && k < MOST_ROWS; k++)
            w->joints[b->joint].impulse[k] +=
                (x[0] * s->joint[k][0] + x[1] * s->joint[k][1]) + (x[2] * s->joint[k][2] + x[3] * s->joint[k][3]);
    }
    for (at = 0; at < w->body_count; at++) {
        tree_body *b = w->bodies + w->order[at];
        if (b->joint >= 0) {
            tree_joint *j = w->joints + b->joint;
            for (k = 0; b->parent >= 0 && k < MOST_ROWS; k++)
                j->impulse[k] -= dot_of(j->parent[k], w->bodies[b->parent].velocity);
            solve_backward(j->factor, j->impulse);
            for (k = 0; k < j->held; k++)
                w->rows[j->row[k]].impulse = j->impulse[k];
            for (k = 0; k < MOTIONS; k++)
                b->velocity[k] += dot_of(j->child[k], j->impulse);
        }
        solve_backward(b->factor, b->velocity);
    }
}

/* Whether a row is part of the tree as if it had no bounds. */
static int is_guessed(const island *w, const tree_row *r)
{
    return w->joints[r->joint].side >= 0 && !r->apart && !is_unbounded(r);
}

/* Take out of the tree what was guessed, or as much of it as has left its bounds; how many rows. */
static int part_guessed(island *w, int all)
{
    int64_t i;
    int found = 0;
    for (i = 0; i < w->row_count; i++) {
        tree_row *r = w->rows + i;
        if (!is_guessed(w, r) || (!all && r->impulse >= r->low && r->impulse <= r->high))
            continue;
        r->apart = 1;
        found++;
    }
    return found;
}

static int have_numbers(island *w, int64_t n)
{
    GROW(places, place_capacity, 2 * n);
    GROW(numbers, number_capacity, n * n + 4 * n + n * (n + 3));
    return 1;
}

enum { NO_ANSWER, OTHER_ROWS, ANSWER };

/* Take what the dense problem found; whether what was guessed is within its bounds. */
static int complete(island *w, const double *x)
{
    int64_t i;
    for (i = 0; i < w->dense_count; i++)
        w->rows[w->dense[i]].impulse = x[i];
    substitute(w);
    return part_guessed(w, 0) ? OTHER_ROWS : ANSWER;
}

/* Solve the island as if motors and limits in the tree had no bounds: most are within them, and those that are not are taken
 * out of the tree for the next attempt. As in ODE, friction has the bounds that the contacts' normal impulses have without
 * friction. */
FOR_WIDE_VECTORS static int attempt(island *w)
{
    int64_t i, n;
    double *a, *b, *low, *high, *x;
    box_problem problem;
    int rubs = 0;
    if (!eliminate(w))
        return part_guessed(w, 1) ? OTHER_ROWS : NO_ANSWER;
    if (!list_dense(w) || !have_numbers(w, w->dense_count))
        return NO_ANSWER;
    n = w->dense_count;
    a = w->numbers;
    b = a + n * n;
    low = b + n;
    high = low + n;
    x = high + n;
    w->station_count = 0;
    for (i = 0; i < w->panel_count; i++)
        if (!follow(w, i))
            return NO_ANSWER;
    compare(w, n, a, b);
    for (i = 0; i < n; i++) {
        const tree_row *r = w->rows + w->dense[i];
        low[i] = r->normal < 0 ? r->low : 0.0;
        high[i] = r->normal < 0 ? r->high : 0.0;
    }
    problem = (box_problem){n, a, b, low, high, w->places, w->places + n, x, x + n};
    if (!solve_box(&problem))
        return NO_ANSWER;
    for (i = 0; i < n; i++) {
        const tree_row *r = w->rows + w->dense[i];
        double pressing;
        if (r->normal < 0)
            continue;
        pressing = x[w->rows[r->normal].place];
        high[i] = pressing == 0.0 ? 0.0 : fabs(r->high * pressing); /* where r->high is infinite, too */
        low[i] = -high[i];
        rubs |= high[i] > 0.0;
    }
    if ((!rubs || w->guesses) && complete(w, x) == OTHER_ROWS)
        return OTHER_ROWS;
    if (!rubs)
        return ANSWER;
    return solve_box(&problem) ? complete(w, x) : NO_ANSWER;
}

/* Whether all impulses and velocities are numbers. */
static int is_finite(const island *w)
{
    int64_t i;
    int k;
    for (i = 0; i < w->row_count; i++)
        if (!isfinite(w->rows[i].impulse))
            return 0;
    for (i = 0; i < w->body_count; i++)
        for (k = 0; k < MOTIONS; k++)
            if (!isfinite(w->bodies[i].velocity[k]))
                return 0;
    return 1;
}

/* What a joint does to its bodies. */
static void find_efforts(const context *c, const island *w, const tree_joint *j, double effort[2][MOTIONS])
{
    double rate = 1.0 / c->step;
    int k, side, row;
    memset(effort, 0, 2 * sizeof *effort);
    for (row = 0; row < j->rows; row++) {
        const tree_row *r = w->rows + j->first + row;
        for (side = 0; side < 2; side++)
            for (k = 0; k < MOTIONS; k++)
                effort[side][k] += r->impulse * rate * r->line[side][k];
    }
}

static void report(feedback *f, double effort[2][MOTIONS])
{
    memcpy(f->f1, effort[0], 3 * sizeof(double));
    memcpy(f->t1, effort[0] + 3, 3 * sizeof(double));
    memcpy(f->f2, effort[1], 3 * sizeof(double));
    memcpy(f->t2, effort[1] + 3, 3 * sizeof(double));
}

/* Take the joints of the island out of ODE's step, and report what they do; `acts`: they act as efforts on the bodies. */
static int take_out(const context *c, island *w, int acts)
{
    int64_t i;
    int k, side;
    GROW(disabled, disabled_capacity, w->disabled_count + w->joint_count);
    for (i = 0; i < w->joint_count; i++) {
        const tree_joint *j = w->joints + i;
        feedback *f = dJointGetFeedback(j->joint);
        double effort[2][MOTIONS];
        if (acts && !j->rows)
            continue; /* without effect, but for the order in which ODE moves bodies */
        if (f || acts)
            find_efforts(c, w, j, effort);
        if (f)
            report(f, effort);
        for (side = 0; acts && side < 2; side++)
            if (j->body[side] >= 0)
                for (k = 0; k < MOTIONS; k++)
                    w->bodies[j->body[side]].effort[k] += effort[side][k];
        dJointDisable(j->joint);
        w->disabled[w->disabled_count++] = j->joint;
    }
    return 1;
}

/* Let ODE move the island, with efforts in place of its joints. */
static int apply(const context *c, island *w)
{
    int64_t i;
    if (!take_out(c, w, 1))
        return 0;
    for (i = 0; i < w->body_count; i++) {
        const tree_body *b = w->bodies + i;
        const double *force = dBodyGetForce(b->body), *torque = dBodyGetTorque(b->body), *e = b->effort;
        dBodySetForce(b->body, force[0] + e[0], force[1] + e[1], force[2] + e[2]);
        dBodySetTorque(b->body, torque[0] + e[3], torque[1] + e[4], torque[2] + e[5]);
    }
    return 1;
}

/* Whether ODE would do no more with the bodies of the island than to add their velocities to their places. */
static int is_plain(const island *w)
{
    int64_t i;
    for (i = 0; i < w->body_count; i++) {
        void *body = w->bodies[i].body;
        if (dBodyGetAutoDisableFlag(body) || dBodyGetFiniteRotationMode(body) || dBodyGetLinearDamping(body) != 0.0 ||
            dBodyGetAngularDamping(body) != 0.0 || dBodyGetMaxAngularSpeed(body) < HUGE_VAL)
            return 0;
    }
    return 1;
}

/* Move the island, whose bodies have no part in ODE's step. */
static int move(const context *c, island *w)
{
    double h = c->step, half = 0.5 * c->step;
    int64_t i;
    if (!take_out(c, w, 0))
        return 0;
    for (i = 0; i < w->body_count; i++) {
        void *body = w->bodies[i].body;
        const double *v = w->bodies[i].velocity, *o = v + 3, *p = dBodyGetPosition(body), *q = dBodyGetQuaternion(body);
        const double turned[4] = {
            q[0] + half * (-o[0] * q[1] - o[1] * q[2] - o[2] * q[3]),
            q[1] + half * (o[0] * q[0] + o[1] * q[3] - o[2] * q[2]),
            q[2] + half * (-o[0] * q[3] + o[1] * q[0] + o[2] * q[1]),
            q[3] + half * (o[0] * q[2] - o[1] * q[1] + o[2] * q[0]),
        };
        dBodySetLinearVel(body, v[0], v[1], v[2]);
        dBodySetAngularVel(body, o[0], o[1], o[2]);
        dBodySetPosition(body, p[0] + h * v[0], p[1] + h * v[1], p[2] + h * v[2]);
        dBodySetQuaternion(body, turned);
        dBodySetForce(body, 0.0, 0.0, 0.0);
        dBodySetTorque(body, 0.0, 0.0, 0.0);
        set_body_aside(c, row_of(body));
    }
    return 1;
}

/* 0 without memory. */
int have_trees(const context *c)
{
    if (!c->work->trees)
        c->work->trees = calloc(1, sizeof *c->work->trees);
    return c->work->trees != NULL;
}

/* 0 if ODE has to solve the island. */
static int solve_island(const context *c, island *w, int64_t row)
{
    int tried = 0, found;
    if (!collect(c, w, row) || !w->row_count || !grow_tree(w))
        return 0;
    while ((found = attempt(w)) == OTHER_ROWS)
        if (++tried == GUESSES)
            part_guessed(w, 1);
    if (found != ANSWER || !is_finite(w))
        return 0;
    return c->solver == TREE && is_plain(w) ? move(c, w) : apply(c, w);
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

/* Whether a body is awake, and its island was not looked at. */
int waits_for_tree(const context *c, int64_t row)
{
    return moves(c->bodies[row]) && dBodyIsEnabled(c->bodies[row]) && c->work->members[row].place < 0;
}

/* Solve the island of a body; 0: it is left to ODE, as it was. */
int solve_tree(const context *c, int64_t row)
{
    island *w = c->work->trees;
    if (solve_island(c, w, row))
        return 1;
    take_back(w);
    return 0;
}

/* Give the joints back to ODE. */
void release_trees(const context *c)
{
    island *w = c->work->trees;
    while (w && w->disabled_count > 0)
        dJointEnable(w->disabled[--w->disabled_count]);
}

/* Give back those of a step in which the process forked: only joints in the tables are surely still there. */
void recover_trees(const context *c)
{
    island *w = c->work->trees;
    int64_t i, k;
    for (i = 0; w && i < w->disabled_count; i++)
        for (k = 0; k < c->joint_count; k++)
            if (c->joints[k] == w->disabled[i])
                dJointEnable(c->joints[k]);
    if (w)
        w->disabled_count = 0;
}

void free_trees(struct trees *w)
{
    if (!w)
        return;
    free(w->bodies);
    free(w->joints);
    free(w->rows);
    free(w->order);
    free(w->roots);
    free(w->dense);
    free(w->places);
    free(w->panels);
    free(w->stations);
    free(w->numbers);
    free(w->disabled);
    free(w);
}
