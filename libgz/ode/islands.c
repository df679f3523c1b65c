/* Islands: bodies that joints and contacts connect. Those that are small and calm are solved exactly, for they rest in
 * no other way, by resting.c where there are no joints and nothing slides; those that are fast only if they have no
 * contacts, for the exact solver does not let wheels slip as they should; and if they are so small that it is the quicker
 * way. Larger ones without contacts are solved along the tree of their joints.
 *
 * dWorldStep() solves an island exactly, by Dantzig's algorithm, at the cost of the cube of its rows; dWorldQuickStep()
 * by projected Gauss-Seidel. Islands are found by union and find. */
#include "memory.h"
#include "step.h"

enum { FAST_ROWS = 60, ROWS_OF_JOINT = 6, ROWS_OF_POINT = 3 };
enum { ALL_EXACT, ALL_QUICK, MIXED };

member alone(int64_t row, int fast)
{
    return (member){.root = row, .fast = fast, .next = -1, .first = -1, .last = -1, .touch = -1, .last_touch = -1, .place = -1};
}

int have_members(const context *c)
{
    member *grown = enlarged(c->work->members, &c->work->member_capacity, c->body_count, sizeof *grown);
    if (grown)
        c->work->members = grown;
    return grown != NULL;
}

/* Take two bodies, one of which may be the world (-1), for one island. */
void unite(const context *c, int64_t one, int64_t two, int64_t rows, int touching)
{
    member *members = c->work->members;
    if (one < 0 || !c->bodies[one])
        one = two;
    if (one < 0 || !c->bodies[one])
        return;
    one = root_of(members, one);
    members[one].rows += rows;
    members[one].touching |= touching;
    members[one].joined |= !touching;
    if (two < 0 || !c->bodies[two])
        return;
    two = root_of(members, two);
    if (two == one)
        return;
    members[two].root = one;
    members[one].rows += members[two].rows;
    members[one].fast |= members[two].fast;
    members[one].touching |= members[two].touching;
    members[one].joined |= members[two].joined;
}

/* Disable a body for a part of the step. */
void set_body_aside(const context *c, int64_t row)
{
    c->work->members[row].aside = 1;
    dBodyDisable(c->bodies[row]);
}

/* Disable the bodies that are, or are not, solved by iteration. */
static void set_aside(const context *c, int quick)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i] && c->work->members[i].quick == quick && dBodyIsEnabled(c->bodies[i]))
            set_body_aside(c, i);
}

/* Enable all bodies that were set aside, without restarting the time they have been idle for. */
void bring_back(const context *c)
{
    member *members = c->work->members;
    int64_t i, known = c->work->member_capacity; /* less where a process that forked in a step has made bodies since */
    for (i = 0; i < c->body_count && i < known; i++) {
        void *body = c->bodies[i];
        int steps;
        double time;
        if (!body || !members[i].aside)
            continue;
        members[i].aside = 0;
        if (!dBodyGetAutoDisableFlag(body)) {
            dBodyEnable(body);
            continue;
        }
        steps = dBodyGetAutoDisableSteps(body);
        time = dBodyGetAutoDisableTime(body);
        dBodySetAutoDisableFlag(body, 0); /* which enables the body */
        dBodySetAutoDisableFlag(body, 1);
        dBodySetAutoDisableSteps(body, steps);
        dBodySetAutoDisableTime(body, time);
    }
}

/* The quick solver's step; 0 when ODE ran out of memory. */
static int iterate(context *c)
{
    int done;
    begin_iterations(c);
    done = dWorldQuickStep(c->world, c->step);
    end_iterations(c);
    return done;
}

/* Whether islands can be solved along trees. After a step that was abandoned, the memory that ODE needs to write rows is made
 * anew, in a step in which nothing moves that is in the tables. */
static int have_tree_memory(context *c)
{
    if (!have_trees(c))
        return 0;
    if (!c->work->stepped) {
        c->parted = 1;
        set_aside(c, 0);
        c->work->stepped = dWorldStep(c->world, c->step);
        bring_back(c);
        c->parted = 0;
    }
    return c->work->stepped;
}

/* Number the bodies, each as an island of its own. */
static void number_bodies(const context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i]) {
            c->work->members[i] = alone(i, 0);
            dBodySetData(c->bodies[i], (void *)(intptr_t)i);
        }
}

/* Solve all islands along their trees that can be. */
static void use_trees(context *c)
{
    int64_t i;
    if (!have_members(c))
        return;
    number_bodies(c);
    if (!have_tree_memory(c))
        return;
    c->parted = 1; /* what is moved along its tree has no part in ODE's step */
    for (i = 0; i < c->body_count; i++)
        if (waits_for_tree(c, i))
            solve_tree(c, i);
}

/* How many rows an island may have to be solved exactly by ODE. */
static int64_t most_rows(const member *root)
{
    return root->fast ? root->touching ? 0 : FAST_ROWS : EXACT_ROWS;
}

/* Solve larger islands without contacts along their trees. */
static void solve_hanging(context *c)
{
    member *members = c->work->members;
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        member *root;
        if (!waits_for_tree(c, i))
            continue;
        root = members + root_of(members, i);
        if (root->touching || root->rows <= most_rows(root))
            continue;
        if (!have_tree_memory(c))
            return;
        /* A body that does not move, as it is kinematic, may connect several that are solved one by one. */
        root->solved = solve_tree(c, i) && root->solved >= 0 ? 1 : -1;
    }
}

/* Find the islands, and which of them are solved exactly. */
static int sort_islands(context *c)
{
    member *members = c->work->members;
    int64_t i;
    int exact = 0, quick = 0;
    /* Nothing touches, and whether they are fast or calm, all islands are small. */
    if (!c->touch_count && ROWS_OF_JOINT * c->joint_count <= FAST_ROWS)
        return ALL_EXACT;
    for (i = 0; i < c->body_count; i++) {
        if (!c->bodies[i])
            continue;
        members[i] = alone(i, !is_calm(c, c->bodies[i]));
        dBodySetData(c->bodies[i], (void *)(intptr_t)i);
    }
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i])
            unite(c, row_of(dJointGetBody(c->joints[i], 0)), row_of(dJointGetBody(c->joints[i], 1)), ROWS_OF_JOINT,
                    0);
    for (i = 0; i < c->touch_count; i++)
        unite(c, c->touches[i].body1, c->touches[i].body2, ROWS_OF_POINT * c->touches[i].count, 1);
    solve_resting(c);
    solve_hanging(c);
    for (i = 0; i < c->body_count; i++) {
        const member *root;
        if (!c->bodies[i])
            continue;
        root = members + root_of(members, i);
        members[i].quick = root->rows > most_rows(root);
        if (!root->rows || root->solved > 0 || !dBodyIsEnabled(c->bodies[i]))
            continue;
        exact |= !members[i].quick;
        quick |= members[i].quick;
    }
    return !quick ? ALL_EXACT : exact ? MIXED : ALL_QUICK;
}

/* Move everything; 0 when ODE ran out of memory. */
int move_bodies(context *c)
{
    int kind = c->solver == QUICK ? ALL_QUICK : ALL_EXACT, done;
    if (solves_islands(c) && have_members(c))
        kind = sort_islands(c);
    if (c->solver == TREE)
        use_trees(c);
    if (kind == ALL_QUICK)
        return iterate(c);
    if (kind == MIXED) {
        c->parted = 1;
        set_aside(c, 1);
    }
    done = dWorldStep(c->world, c->step);
    if (c->parted)
        bring_back(c);
    if (kind == MIXED) {
        set_aside(c, 0);
        done = iterate(c) && done;
        bring_back(c);
    }
    c->parted = 0;
    return done;
}
