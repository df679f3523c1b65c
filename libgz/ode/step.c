/* The step: contacts, ODE's step, and the copy of all states, without a Python call inside.
 *
 * Each of its parts has a file of its own, named in step.h. A step of a world in which all bodies sleep is left out. It is
 * not linked with ODE: gz_step_needs() lists the ODE functions it calls, gz_step_bind() takes their addresses in that
 * order; so it builds without ODE's headers and always uses the ODE library that is loaded.
 * tests/ode/recorded.json holds motions that it repeats to the last bit. */
#include "step.h"

#include <stdlib.h>

size_t gz_step_context_size(void) { return sizeof(context); }

/* An abandoned step does not free its memory. So from the first such step on, a world keeps no memory from one step to
 * the next, and what is still allocated after a step is freed here. */
enum { MOST_BLOCKS = 64 };
static __thread void *blocks[MOST_BLOCKS];
static __thread int block_count;

static void *get_block(size_t size)
{
    void *block = malloc(size);
    if (block && block_count < MOST_BLOCKS)
        blocks[block_count++] = block;
    return block;
}

static void *shrink_block(void *block, size_t size, size_t smaller)
{
    (void)size;
    (void)smaller;
    return block;
}

static void drop_block(void *block, size_t size)
{
    int i;
    (void)size;
    for (i = 0; i < block_count; i++)
        if (blocks[i] == block)
            blocks[i] = blocks[--block_count];
    free(block);
}

static void free_step_memory(context *c)
{
    static const memory_functions own = {sizeof own, get_block, shrink_block, drop_block};
    dWorldCleanupWorkingMemory(c->world);
    c->work->stepped = 0;
    while (block_count > 0)
        free(blocks[--block_count]);
    if (!c->own_memory)
        dWorldSetStepMemoryManager(c->world, &own);
    c->own_memory = 1;
}

/* Whether some bodies are asleep, from one on; of so many of them if there are more. */
static int are_asleep(const context *c, int64_t first, int64_t most)
{
    int64_t i, count = c->body_count < most ? c->body_count : most;
    for (i = 0; i < count; i++) {
        void *body = c->bodies[(first + i) % c->body_count];
        if (body && dBodyIsEnabled(body))
            return 0;
    }
    return 1;
}

static int have_springs(const context *c)
{
    int64_t i;
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i] && (c->springs[3 * i] != 0.0 || c->springs[3 * i + 1] != 0.0))
            return 1;
    return 0;
}

static void note_rest(context *c)
{
    if (!are_asleep(c, 0, c->body_count) || have_springs(c))
        c->resting = 0;
    else if (c->resting < RESTING)
        c->resting++;
}

/* Whether steps can be left out, as far as the tables say: what is left in a world without bodies has no effect. */
int gz_is_at_rest(const context *c) { return c->resting >= RESTING && !c->record_contacts && !c->held_count; }

/* Whether a step can be left out. A look at some bodies finds those that were woken past the tables. */
static int rests(context *c)
{
    if (!gz_is_at_rest(c))
        return 0;
    if (!are_asleep(c, c->next_checked, CHECKED)) {
        c->resting = 0;
        return 0;
    }
    c->next_checked = c->body_count ? (c->next_checked + CHECKED) % c->body_count : 0;
    return 1;
}

void gz_disturb(context *c) { c->resting = 0; }

enum { STEP_NEEDS_RECOVERY = 2 };

static void bring_back_parted(context *c)
{
    if (c->parted)
        bring_back(c);
    c->parted = 0;
}

/* The second half: move everything, drop the contacts, copy the states out. Returns 1, 0 when ODE ran out of memory, or
 * STEP_NEEDS_RECOVERY: the context holds what happened. */
static int solve(context *c)
{
    volatile int done = 1; /* kept when the step is abandoned */
    /* What a step left behind in which the process forked. */
    gz_drop_calls(&c->work->calls);
    recover_trees(c);
    bring_back_parted(c);
    restore_stops(c);
    request_feedback(c);
    apply_springs(c);
    c->reset_row = 0;
    c->iterating = 0;
    begin_motion(c);
    if (c->explicit_gyroscopic)
        add_gyroscopic_torques(c);
    c->abandoned = 0;
    guarded = 1;
    if (SET_JUMP(escape))
        c->abandoned = 1;
    else
        done = move_from_stops(c);
    guarded = 0;
    restore_stops(c); /* the step was abandoned meanwhile */
    end_iterations(c);
    release_trees(c);
    bring_back_parted(c); /* the step was abandoned meanwhile */
    if (c->abandoned)
        gz_drop_calls(&c->work->calls);
    if (c->abandoned || c->own_memory)
        free_step_memory(c);
    if (done && !c->abandoned)
        set_apart(c);
    collect_feedback(c);
    dJointGroupEmpty(c->contacts);
    c->steps++;
    c->diverged = read_bodies(c, c->body_state, 1);
    read_joints(c, c->joint_state);
    note_rest(c);
    if (done && (c->reset_row || c->abandoned || c->diverged || c->collision_failed))
        return STEP_NEEDS_RECOVERY;
    return done != 0;
}

static void apply_held_efforts(const context *c)
{
    int64_t i;
    int side;
    for (i = 0; i < c->held_count; i++) {
        const held_effort *h = c->held + i;
        if (!h->joint)
            continue; /* it was destroyed meanwhile */
        for (side = 0; h->wakes && side < 2; side++) {
            void *body = dJointGetBody(h->joint, side);
            if (body)
                gz_wake(body, 0);
        }
        if (h->type == JOINT_SLIDER)
            dJointAddSliderForce(h->joint, h->effort);
        else
            dJointAddHingeTorque(h->joint, h->effort);
    }
}

void gz_collide(context *c)
{
    enter_ode(c);
    apply_held_efforts(c);
    find_contacts(c);
    carry_on(c);
    leave_ode();
}

int gz_solve(context *c)
{
    int done;
    enter_ode(NULL);
    done = solve(c);
    leave_ode();
    return done;
}

int gz_step(context *c)
{
    int done;
    if (rests(c)) {
        c->steps++;
        return 1;
    }
    enter_ode(c);
    apply_held_efforts(c);
    find_contacts(c);
    let_others_in(c);
    done = solve(c);
    leave_ode();
    return done;
}
