/* The contact points of a step as they are reported: places and depths from the search, forces from the feedback that
 * ODE keeps for a joint (dJointSetFeedback). */
#include "memory.h"
#include "step.h"

#include <stdlib.h>
#include <string.h>

/* Allocate so many records; 0 without memory. */
static int have_records(context *c, int64_t capacity)
{
    contact_record *records;
    pending_contact *pending;
    if (capacity <= c->record_capacity)
        return 1;
    records = realloc(c->records, (size_t)capacity * sizeof(contact_record));
    if (!records)
        return 0;
    c->records = records;
    pending = realloc(c->pending, (size_t)capacity * sizeof(pending_contact));
    if (!pending)
        return 0;
    c->pending = pending;
    c->record_capacity = capacity;
    return 1;
}

/* Record a contact point; its joint may be NULL. Without memory it is not recorded. */
void record_point(context *c, const contact *point, void *geom1, void *geom2, void *joint)
{
    contact_record *r;
    if (c->record_count == c->record_capacity &&
        !have_records(c, c->record_capacity ? 2 * c->record_capacity : 64))
        return;
    r = c->records + c->record_count;
    memset(r, 0, sizeof *r);
    r->geom1 = (intptr_t)dGeomGetData(geom1);
    r->geom2 = (intptr_t)dGeomGetData(geom2);
    memcpy(r->position, point->geom.pos, sizeof r->position);
    memcpy(r->normal, point->geom.normal, sizeof r->normal);
    r->depth = point->geom.depth;
    c->pending[c->record_count].joint = joint;
    c->pending[c->record_count].reversed = !dGeomGetBody(geom1);
    c->record_count++;
}

/* Begin the records of a step, and keep those of the step before. */
void begin_records(context *c)
{
    c->earlier_count = 0;
    if (c->record_contacts && c->record_count) {
        contact_record *kept = enlarged(c->earlier, &c->earlier_capacity, c->record_count, sizeof *kept);
        if (kept) {
            memcpy(kept, c->records, (size_t)c->record_count * sizeof *kept);
            c->earlier = kept;
            c->earlier_count = c->record_count;
        }
    }
    c->record_count = 0;
}

/* Request the forces of the recorded contacts of this step from ODE. */
void request_feedback(context *c)
{
    int64_t i;
    for (i = 0; i < c->record_count; i++) {
        pending_contact *p = c->pending + i;
        memset(&p->result, 0, sizeof p->result);
        if (p->joint)
            dJointSetFeedback(p->joint, &p->result);
    }
}

static int same_pair(const contact_record *one, const contact_record *other)
{
    return one->geom1 == other->geom1 && one->geom2 == other->geom2;
}

/* The place of a pair's first record in the step before, searched for from `from` on; -1 without any. */
static int64_t find_pair(const context *c, const contact_record *r, int64_t from)
{
    int64_t n;
    for (n = 0; n < c->earlier_count; n++) {
        int64_t i = (from + n) % c->earlier_count;
        if (same_pair(c->earlier + i, r) && (i == 0 || !same_pair(c->earlier + i - 1, r)))
            return i;
    }
    return -1;
}

/* ODE does not solve contacts of bodies that are asleep: they carry what they carried in the step before, point by point. */
void carry_on(context *c)
{
    int64_t i, place = -1, from = 0;
    for (i = 0; i < c->record_count; i++) {
        contact_record *r = c->records + i;
        void *joint = c->pending[i].joint;
        if (!joint || is_awake(dJointGetBody(joint, 0)) || is_awake(dJointGetBody(joint, 1)))
            continue;
        if (i == 0 || !same_pair(r - 1, r))
            place = find_pair(c, r, from);
        else if (place >= 0)
            place = place + 1 < c->earlier_count && same_pair(c->earlier + place + 1, r) ? place + 1 : -1;
        if (place < 0)
            continue;
        from = place;
        memcpy(r->force1, c->earlier[place].force1, 4 * sizeof r->force1);
    }
}

/* Copy the forces to the records. ODE's first body is never missing; for a missing second one there is no feedback. */
void collect_feedback(context *c)
{
    int64_t i;
    carry_on(c);
    for (i = 0; i < c->record_count; i++) {
        pending_contact *p = c->pending + i;
        contact_record *r = c->records + i;
        if (!p->joint)
            continue;
        if (!is_awake(dJointGetBody(p->joint, 0)) && !is_awake(dJointGetBody(p->joint, 1))) {
            p->joint = NULL;
            continue;
        }
        memcpy(p->reversed ? r->force2 : r->force1, p->result.f1, sizeof r->force1);
        memcpy(p->reversed ? r->torque2 : r->torque1, p->result.t1, sizeof r->torque1);
        if (!p->reversed) {
            memcpy(r->force2, p->result.f2, sizeof r->force2);
            memcpy(r->torque2, p->result.t2, sizeof r->torque2);
        }
        p->joint = NULL;
    }
}

/* Replace the records of the last step. */
void gz_set_contacts(context *c, const contact_record *records, int64_t count)
{
    int64_t i;
    c->record_count = have_records(c, count) ? count : 0;
    if (!c->record_count)
        return;
    memcpy(c->records, records, (size_t)count * sizeof(contact_record));
    for (i = 0; i < count; i++)
        c->pending[i].joint = NULL;
}
