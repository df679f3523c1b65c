/* States: ODE's memory that decides what comes next, copied out and back; libgz/ode/memory.py finds where it lies. */
#include "step.h"

#include <string.h>

enum { MOST_KINDS = 16 };

/* Offsets in ODE's objects; mirrored by Layout in memory.py, which finds and explains them. */
typedef struct {
    int64_t body_flags, body[2], damping[2], joint, joint_end[MOST_KINDS], geom_flags, geom, geom_end[MOST_KINDS];
    int64_t dirty, stale_place, stale_box;
} layout;

typedef struct {
    void *memory;
    int64_t size;
} block;

/* What a state is of; mirrored by Parts in parts.py. Bodies and joints are in order of construction, geoms by row (NULL:
 * one that touches nothing, or a free row), the top space is the first of the spaces. Blocks are rows of the tables. */
typedef struct {
    layout where;
    void *const *bodies;
    int64_t body_count;
    void *const *joints;
    int64_t joint_count;
    void *const *geoms;
    int64_t geom_count;
    void *const *spaces;
    int64_t space_count;
    const block *blocks;
    int64_t block_count;
} parts;

size_t gz_parts_size(void) { return sizeof(parts); }

/* What a state is copied to, or from; beyond its end it is only measured. */
typedef struct {
    unsigned char *bytes;
    int64_t size, at;
    int reading; /* 1: from the bytes into ODE's memory */
} tape;

/* ODE's memory, padded to words. */
static void copy(tape *t, void *object, int64_t begin, int64_t end)
{
    unsigned char *memory = (unsigned char *)object + begin;
    int64_t size = end - begin, padded = (size + 7) / 8 * 8;
    if (t->at + padded > t->size)
        ;
    else if (t->reading)
        memcpy(memory, t->bytes + t->at, (size_t)size);
    else {
        memset(t->bytes + t->at + size, 0, (size_t)(padded - size));
        memcpy(t->bytes + t->at, memory, (size_t)size);
    }
    t->at += padded;
}

static int64_t number(tape *t, int64_t value)
{
    copy(t, &value, 0, sizeof value);
    return value;
}

static uint32_t *marks(const parts *p, void *geom) { return (uint32_t *)((char *)geom + p->where.geom_flags); }

enum { POSR_SIZE = 16 * 8 }; /* a position and a rotation, as ODE keeps them */

static void copy_bodies(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->body_count; i++) {
        copy(t, p->bodies[i], p->where.body_flags, p->where.body_flags + 4);
        copy(t, p->bodies[i], p->where.body[0], p->where.body[1]);
        copy(t, p->bodies[i], p->where.damping[0], p->where.damping[1]);
    }
}

static void copy_joints(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->joint_count; i++)
        copy(t, p->joints[i], p->where.joint, p->where.joint_end[dJointGetType(p->joints[i])]);
}

/* Geoms: bits, lengths and place; the offset from the body, or where there is none the place itself. */
static void copy_geoms(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->geom_count; i++) {
        void *geom = p->geoms[i];
        int class;
        if (!geom)
            continue;
        class = dGeomGetClass(geom);
        copy(t, geom, p->where.geom, p->where.geom_end[class]);
        if (class == PLANE_CLASS)
            continue;
        if (!dGeomGetBody(geom))
            copy(t, (void *)dGeomGetPosition(geom), 0, POSR_SIZE);
        else if (dGeomIsOffset(geom))
            copy(t, (void *)dGeomGetOffsetPosition(geom), 0, POSR_SIZE);
        else {
            if (!t->reading && t->at + POSR_SIZE <= t->size)
                memset(t->bytes + t->at, 0, POSR_SIZE);
            t->at += POSR_SIZE;
        }
    }
}

static void copy_blocks(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->block_count; i++)
        copy(t, p->blocks[i].memory, 0, p->blocks[i].size);
}

/* The marks of geoms, last of all. */
static void copy_marks(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->geom_count; i++)
        if (p->geoms[i])
            copy(t, marks(p, p->geoms[i]), 0, 4);
    for (i = 0; i < p->space_count; i++) {
        copy(t, marks(p, p->spaces[i]), 0, 4);
        copy(t, p->spaces[i], p->where.geom, p->where.geom + 16);
    }
}

/* A geom or space of the world as a number: its row, or ~ its index. */
static int64_t code(void *geom)
{
    int64_t value = (intptr_t)dGeomGetData(geom);
    return dGeomIsSpace(geom) ? ~value : value;
}

static void *coded(const parts *p, int64_t value)
{
    if (value < 0)
        return ~value < p->space_count ? p->spaces[~value] : NULL;
    return value < p->geom_count ? p->geoms[value] : NULL;
}

/* The order of geoms in every space, and on every body: from it follows the order of contacts. */
static void write_order(const parts *p, tape *t)
{
    int64_t i, count;
    int k;
    void *geom;
    for (i = 0; i < p->space_count; i++)
        dGeomSetData(p->spaces[i], (void *)(intptr_t)i);
    for (i = p->space_count - 1; i >= 0; i--) {
        count = number(t, dSpaceGetNumGeoms(p->spaces[i]));
        for (k = 0; k < count; k++)
            number(t, code(dSpaceGetGeom(p->spaces[i], k)));
    }
    for (i = 0; i < p->body_count; i++) {
        count = 0;
        for (geom = dBodyGetFirstGeom(p->bodies[i]); geom; geom = dBodyGetNextGeom(geom))
            count++;
        number(t, count);
        for (geom = dBodyGetFirstGeom(p->bodies[i]); geom; geom = dBodyGetNextGeom(geom))
            number(t, code(geom));
    }
}

/* Whether the geoms are in the spaces, and on the bodies, in which the state has them. */
static int fits(const parts *p, tape *t)
{
    int64_t i, k, count;
    void *geom;
    for (i = p->space_count - 1; i >= 0; i--) {
        count = number(t, 0);
        if (count != dSpaceGetNumGeoms(p->spaces[i]))
            return 0;
        for (k = 0; k < count; k++) {
            geom = coded(p, number(t, 0));
            if (!geom || dGeomGetSpace(geom) != p->spaces[i])
                return 0;
        }
    }
    for (i = 0; i < p->body_count; i++) {
        count = number(t, 0);
        for (geom = dBodyGetFirstGeom(p->bodies[i]); geom; geom = dBodyGetNextGeom(geom))
            count--;
        if (count)
            return 0;
        t->at -= 8;
        count = number(t, 0);
        for (k = 0; k < count; k++) {
            geom = coded(p, number(t, 0));
            if (!geom || dGeomGetBody(geom) != p->bodies[i])
                return 0;
        }
    }
    return 1;
}

/* Bring the geoms of a space into the order of the state. */
static void order_space(const parts *p, tape *t, void *space)
{
    int64_t count = number(t, 0), k;
    const int64_t *codes = (const int64_t *)(t->bytes + t->at);
    t->at += 8 * count;
    for (k = count - 1; k >= 0; k--) { /* each goes to the front */
        void *geom = coded(p, codes[k]);
        dSpaceRemove(space, geom);
        dSpaceAdd(space, geom);
    }
}

/* Bring all geoms into the order of the state. A space may move in its parent while it is
 * changed, so parents, which are older, come last, here and in the state. */
static void read_order(const parts *p, tape *t)
{
    const int64_t *codes;
    int64_t i, k, count;
    void *geom;
    for (i = p->space_count - 1; i >= 0; i--)
        order_space(p, t, p->spaces[i]);
    for (i = 0; i < p->body_count; i++) {
        count = number(t, 0);
        codes = (const int64_t *)(t->bytes + t->at);
        t->at += 8 * count;
        for (k = 0, geom = dBodyGetFirstGeom(p->bodies[i]); k < count && geom == coded(p, codes[k]); k++)
            geom = dBodyGetNextGeom(geom);
        for (k = k < count ? count - 1 : -1; k >= 0; k--) {
            geom = coded(p, codes[k]);
            dGeomSetBody(geom, NULL);
            dGeomSetBody(geom, p->bodies[i]);
            dGeomSetOffsetPosition(geom, 0.0, 0.0, 0.0);
        }
    }
}

/* Returns how many bytes a state has; if there are more than `size`, those written are none. */
int64_t gz_get_state(const parts *p, unsigned char *bytes, int64_t size)
{
    tape t = {bytes, size, 0, 0};
    enter_ode(NULL);
    write_order(p, &t);
    copy_bodies(p, &t);
    copy_joints(p, &t);
    copy_geoms(p, &t);
    copy_blocks(p, &t);
    copy_marks(p, &t);
    leave_ode();
    return t.at;
}

/* Returns 0, and has changed nothing, if a geom is not where the state has it, or the state has another size. */
int gz_set_state(const parts *p, unsigned char *bytes, int64_t size)
{
    tape t = {bytes, size, 0, 1};
    double box[6];
    int64_t i;
    int done;
    if (gz_get_state(p, NULL, 0) != size)
        return 0;
    enter_ode(NULL);
    done = fits(p, &t);
    if (done) {
        t.at = 0;
        read_order(p, &t);
        copy_bodies(p, &t);
        copy_joints(p, &t);
        copy_geoms(p, &t);
        copy_blocks(p, &t);
        for (i = 0; i < p->geom_count; i++)
            if (p->geoms[i])
                *marks(p, p->geoms[i]) |= (uint32_t)(p->where.dirty | p->where.stale_box |
                                                     (dGeomGetBody(p->geoms[i]) ? p->where.stale_place : 0));
        for (i = 0; i < p->space_count; i++)
            *marks(p, p->spaces[i]) |= (uint32_t)(p->where.dirty | p->where.stale_box);
        dSpaceClean(p->spaces[0]);
        for (i = 0; i < p->geom_count; i++)
            if (p->geoms[i])
                dGeomGetAABB(p->geoms[i], box);
        copy_marks(p, &t);
    }
    leave_ode();
    return done;
}
