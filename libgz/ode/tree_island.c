/* What an island consists of, for tree.c: bodies with their inertia and momentum, the rows that ODE's joints demand, and the
 * tree that joints without bounds form. */
#include "tree.h"

#include <math.h>
#include <string.h>

enum { JOINT_KINDS = 18 }; /* ODE's numbers of joint types end below */
enum { NUMBERS_OF_ROW = sizeof(tree_row) / sizeof(double) }; /* ODE writes into rows, aim and softness in one piece */

typedef struct {
    uint8_t rows, unbounded;
} row_count;

typedef void count_rows(void *joint, row_count *found);
typedef void write_rows(void *joint, double rate, double erp, int row_skip, double *one, double *two, int pair_skip,
                        double *aim_softness, double *low_high, int *normal);

static count_rows *counters[JOINT_KINDS];
static write_rows *writers[JOINT_KINDS];

/* Take the addresses of the functions with which ODE's joints count and write their rows, by type; NULL: it exports none. */
void gz_tree_bind(void *const *counting, void *const *writing, size_t count)
{
    count = count < JOINT_KINDS ? count : JOINT_KINDS;
    memcpy(counters, counting, count * sizeof *counters);
    memcpy(writers, writing, count * sizeof *writers);
}

/* Solve a 3x3 system by Cramer's rule; 0 if it is singular. */
static int solve_three(double m[3][3], const double *b, double *x)
{
    double c[3][3], determinant;
    int i;
    cross(m[1], m[2], c[0]);
    cross(m[2], m[0], c[1]);
    cross(m[0], m[1], c[2]);
    determinant = dot(m[0], c[0]);
    if (determinant == 0.0)
        return 0;
    for (i = 0; i < 3; i++)
        x[i] = (c[0][i] * b[0] + c[1][i] * b[1] + c[2][i] * b[2]) / determinant;
    return 1;
}

/* Inertia, and the momentum after the step without joints. Gyroscopic torque as in ODE: C. Lacoursiere, Stabilizing
 * gyroscopic forces in rigid multibody simulations, 2006. */
static void describe(const context *c, tree_body *b)
{
    const double *r = dBodyGetRotation(b->body), *v = dBodyGetLinearVel(b->body), *omega = dBodyGetAngularVel(b->body);
    const double *force = dBodyGetForce(b->body), *torque = dBodyGetTorque(b->body);
    double turned[3][3], angular[3], implicit[3][3], rotated[3];
    int i, k, falls = dBodyGetGravityMode(b->body);
    body_mass m;
    dBodyGetMass(b->body, &m);
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++)
            turned[i][k] = r[4 * i] * m.inertia[k] + r[4 * i + 1] * m.inertia[4 + k] + r[4 * i + 2] * m.inertia[8 + k];
    b->mass = m.mass;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++)
            b->inertia[i][k] = dot(turned[i], r + 4 * k);
    for (i = 0; i < 3; i++)
        angular[i] = dot(b->inertia[i], omega);
    for (i = 0; i < 3; i++) {
        b->momentum[i] = m.mass * v[i] + c->step * (force[i] + (falls ? m.mass * c->gravity[i] : 0.0));
        b->momentum[3 + i] = angular[i] + c->step * torque[i];
    }
    if (dBodyGetGyroscopicMode(b->body)) {
        /* The torque is (I (I - h [L])^-1 - 1) L / h, where [L] is the matrix of the cross product with L. */
        memcpy(implicit, b->inertia, sizeof implicit);
        for (i = 0; i < 3; i++) {
            int j = (i + 1) % 3, l = (i + 2) % 3;
            implicit[i][j] += c->step * angular[l];
            implicit[i][l] -= c->step * angular[j];
        }
        if (solve_three(implicit, angular, rotated))
            for (i = 0; i < 3; i++)
                b->momentum[3 + i] += dot(b->inertia[i], rotated) - angular[i];
    }
    memset(b->effort, 0, sizeof b->effort);
}

int moves(void *body) { return body && !dBodyIsKinematic(body); }

/* A body as a member; NULL if it is not in the tables, as one that a plugin made past the library. */
static member *member_of(const context *c, void *body)
{
    int64_t row = row_of(body);
    return row >= 0 && row < c->body_count && c->bodies[row] == body ? c->work->members + row : NULL;
}

/* Where a body is in the island, -1: it does not move, or is not there. */
static int64_t place_of(const context *c, const island *w, void *body)
{
    const member *m = moves(body) ? member_of(c, body) : NULL;
    return m && m->place >= 0 && m->place < w->body_count && w->bodies[m->place].body == body ? m->place : -1;
}

/* Take a body into the island; 0 without memory. */
static int add_body(island *w, void *body, member *m)
{
    const double *force = dBodyGetForce(body), *torque = dBodyGetTorque(body);
    tree_body *b;
    GROW(bodies, body_capacity, w->body_count + 1);
    b = w->bodies + w->body_count;
    b->body = body;
    memcpy(b->applied, force, 3 * sizeof *force);
    memcpy(b->applied + 3, torque, 3 * sizeof *torque);
    m->place = w->body_count++;
    return 1;
}

/* The bodies of a joint in ODE's order, in which rows are written: the first one is never the world. */
static void find_sides(void *joint, void *bodies[2])
{
    bodies[0] = dJointGetBody(joint, 0);
    bodies[1] = dJointGetBody(joint, 1);
    if (!bodies[0]) {
        bodies[0] = bodies[1];
        bodies[1] = NULL;
    }
}

/* Write a joint's rows behind the others; one without rows belongs to the island, too. 0 without memory. */
static int add_joint(const context *c, island *w, void *joint, void *const *bodies)
{
    double rate = 1.0 / c->step, cfm = dWorldGetCFM(c->world);
    int normal[MOST_ROWS], type = dJointGetType(joint), i, side;
    row_count found = {0, 0};
    tree_joint *j;
    tree_row *rows;
    if (type < 0 || type >= JOINT_KINDS || !counters[type] || !writers[type])
        return 0;
    counters[type](joint, &found);
    if (found.rows > MOST_ROWS)
        return 0;
    GROW(joints, joint_capacity, w->joint_count + 1);
    GROW(rows, row_capacity, w->row_count + MOST_ROWS); /* so that there is a first one in any case */
    rows = w->rows + w->row_count;
    memset(rows, 0, found.rows * sizeof *rows);
    for (i = 0; i < found.rows; i++) {
        rows[i].joint = w->joint_count;
        rows[i].softness = cfm;
        rows[i].low = -HUGE_VAL;
        rows[i].high = HUGE_VAL;
        normal[i] = -1;
    }
    writers[type](joint, rate, dWorldGetERP(c->world), NUMBERS_OF_ROW, rows->line[0], rows->line[1], NUMBERS_OF_ROW,
                  &rows->aim, &rows->low, normal);
    j = w->joints + w->joint_count++;
    j->joint = joint;
    j->tying = 0;
    j->rows = found.rows;
    j->first = w->row_count;
    j->side = -1;
    for (side = 0; side < 2; side++)
        j->body[side] = place_of(c, w, bodies[side]);
    for (i = 0; i < found.rows; i++) {
        tree_row *r = rows + i;
        double scale = normal[i] < 0 ? c->step : 1.0;
        r->softness *= rate;
        r->low *= scale; /* infinite ones stay so */
        r->high *= scale;
        r->normal = normal[i] < 0 ? -1 : j->first + normal[i];
        r->apart = !(r->low < r->high);
        j->tying += type != JOINT_CONTACT && is_unbounded(r);
        for (side = 0; side < 2; side++) {
            double *line = r->line[side];
            if (j->body[side] >= 0)
                continue;
            if (bodies[side]) /* it moves as it does, whatever happens */
                r->aim -= dot(line, dBodyGetLinearVel(bodies[side])) + dot(line + 3, dBodyGetAngularVel(bodies[side]));
            memset(line, 0, sizeof r->line[side]);
        }
    }
    w->row_count += found.rows;
    return 1;
}

/* Collect the island of a body: all that enabled joints connect; it is awake then. 0 if ODE has to solve it. */
int collect(const context *c, island *w, int64_t row)
{
    int64_t at;
    int i, count, whole = 1;
    w->body_count = w->joint_count = w->row_count = 0;
    if (!add_body(w, c->bodies[row], c->work->members + row))
        return 0;
    for (at = 0; at < w->body_count; at++) {
        void *body = w->bodies[at].body;
        count = dBodyGetNumJoints(body);
        for (i = 0; i < count; i++) {
            void *joint = dBodyGetJoint(body, i), *bodies[2], *other;
            if (!dJointIsEnabled(joint))
                continue;
            find_sides(joint, bodies);
            other = bodies[bodies[0] == body];
            if (moves(other)) {
                member *m = member_of(c, other);
                if (m && m->place < 0) {
                    if (!add_body(w, other, m))
                        return 0;
                    if (!dBodyIsEnabled(other))
                        dBodyEnable(other);
                }
                whole &= place_of(c, w, other) >= 0;
            }
            /* By the first body that moves, so that it is once. */
            if (whole && (moves(bodies[0]) ? bodies[0] : bodies[1]) == body && !add_joint(c, w, joint, bodies))
                return 0;
        }
    }
    if (!whole)
        return 0;
    for (at = 0; at < w->body_count; at++) /* now, for motors at a limit have applied efforts */
        describe(c, w->bodies + at);
    return 1;
}

static void take_place(island *w, int64_t body)
{
    w->bodies[body].degree = -1;
    w->bodies[body].rank = w->order_count;
    w->bodies[body].met = -1;
    w->order[w->order_count++] = body;
}

/* Hang a body on another one, or on the world, by a joint. */
static void hang(island *w, int64_t joint, int side)
{
    tree_joint *j = w->joints + joint;
    tree_body *b = w->bodies + j->body[side];
    j->side = side;
    b->joint = joint;
    b->parent = j->body[1 - side];
    take_place(w, j->body[side]);
}

static void list_joints(island *w)
{
    int64_t i;
    int side;
    for (i = 0; i < w->body_count; i++) {
        w->bodies[i].parent = w->bodies[i].joint = w->bodies[i].first = -1;
        w->bodies[i].degree = 0;
    }
    for (i = 0; i < w->joint_count; i++)
        for (side = 0; side < 2; side++) {
            tree_joint *j = w->joints + i;
            tree_body *b;
            if (!j->tying || j->body[side] < 0)
                continue;
            b = w->bodies + j->body[side];
            j->next[side] = b->first;
            b->first = i;
            b->degree++;
        }
}

/* List the bodies by how many joints they have, those with most first, and those with as many in their order. */
static int list_roots(island *w)
{
    int64_t i, most = 2 * w->joint_count, *ends, end = 0;
    GROW(roots, root_capacity, w->body_count + most + 1);
    ends = w->roots + w->body_count; /* by how many joints there are less than the most */
    memset(ends, 0, (size_t)(most + 1) * sizeof *ends);
    for (i = 0; i < w->body_count; i++)
        ends[most - w->bodies[i].degree]++;
    for (i = 0; i <= most; i++) {
        end += ends[i];
        ends[i] = end - ends[i];
    }
    for (i = 0; i < w->body_count; i++)
        w->roots[ends[most - w->bodies[i].degree]++] = i;
    return 1;
}

/* Order the bodies from the root on: first what joints hold to the world; then a tree from the body with most joints. */
int grow_tree(island *w)
{
    int64_t i, at = 0, next_root = 0;
    GROW(order, order_capacity, w->body_count);
    w->order_count = 0;
    list_joints(w);
    if (!list_roots(w))
        return 0;
    for (i = 0; i < w->joint_count; i++) {
        const tree_joint *j = w->joints + i;
        int side = j->body[0] < 0;
        if (j->tying && j->body[1 - side] < 0 && w->bodies[j->body[side]].degree >= 0)
            hang(w, i, side);
    }
    for (;;) {
        for (; at < w->order_count; at++)
            for (i = w->bodies[w->order[at]].first; i >= 0;) {
                const tree_joint *j = w->joints + i;
                int side = j->body[0] == w->order[at];
                int64_t next = j->next[1 - side];
                if (j->body[side] >= 0 && w->bodies[j->body[side]].degree >= 0)
                    hang(w, i, side);
                i = next;
            }
        while (next_root < w->body_count && w->bodies[w->roots[next_root]].degree < 0)
            next_root++;
        if (next_root == w->body_count)
            return 1;
        take_place(w, w->roots[next_root]);
    }
}
