/* Takes what has changed in pieces of memory since the last look, and appends it as frames to what waits for the log's
   pipe: a step of the log by one call. */

#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

enum { BLOCK = 32, STRETCH = 512, FRAME_HEAD = 7, PATCH_HEAD = 8 };
enum { TICK = 0, END = 3, PATCH = 5 }; /* Kind in frames.py */

struct range {
    int64_t offset, size;
};

/* Of an array: the size of an element, and where a 32-bit number says how many are in use. Otherwise both are 0. */
struct part {
    int64_t offset, size, element, used;
};

/* To look at all memory in each step would displace what the step itself needs from the processor's caches. So a row has
   a count of its server's writes, and keys, parts of it that others write or that change whenever something else does.
   If they have changed, parts that are in use are compared; all of it is in every 128th step. */
enum { TURNS = 128 };

struct row {
    const uint8_t *memory;
    uint8_t *shadow; /* as it was at the last look */
    int64_t size;    /* of both [byte] */
    int64_t channel;
    int64_t seen;          /* whether there was a look */
    const int64_t *writes; /* how often its server has written; NULL: not counted */
    int64_t writes_seen;
    const struct range *keys;
    int64_t key_count; /* 0: all of it is compared each time */
    const struct part *parts;
    int64_t part_count;
};

struct recorder {
    uint8_t *data;    /* what waits for the pipe */
    int64_t used;     /* of it [byte] */
    struct row *rows; /* the first one is that of bodies and joints */
    int64_t count;
    int64_t turn;                  /* counts the calls */
    int64_t first;                 /* row to look at */
    int64_t log_time, sim_time;    /* of this step [ns] */
    const uint8_t *before, *after; /* other frames of this step */
    int64_t before_size, after_size;
    int64_t limit; /* of what waits, up to which there is space for the changes of a step */
};

/* Moments in changes.py: what is known of the steps of a world. */
struct moments {
    double time, due;    /* [s] of the log: of the last step, and from when states are recorded again */
    double period;       /* [s] between states */
    double sent;         /* [s] when something was sent last, on the monotonic clock */
    double send_period;  /* [s] */
    int64_t send_size;   /* [byte] that are sent at once */
    const double *step, *sim_time; /* [s] of the world */
    const int64_t *revision;       /* of its scene */
    int64_t revision_seen;
};

static const double LATEST = 9.2e18; /* [ns] of a record */

static uint8_t *put(uint8_t *at, const void *bytes, int64_t size)
{
    memcpy(at, bytes, (size_t)size);
    return at + size;
}

static uint8_t *put_head(uint8_t *at, int kind, int64_t channel, int64_t length)
{
    uint16_t number = (uint16_t)channel;
    uint32_t size = (uint32_t)length;
    *at = (uint8_t)kind;
    return put(put(at + 1, &number, 2), &size, 4);
}

static int differs(const uint8_t *a, const uint8_t *b)
{
    uint64_t x[BLOCK / 8], y[BLOCK / 8], found = 0;
    int i;
    memcpy(x, a, BLOCK);
    memcpy(y, b, BLOCK);
    for (i = 0; i < BLOCK / 8; i++)
        found |= x[i] ^ y[i];
    return found != 0;
}

/* Where the bytes from `at` on differ: the start of a block, or `end`. Stretches that are equal are passed at once. */
static int64_t first_change(const struct row *row, int64_t at, int64_t end)
{
    const uint8_t *memory = row->memory, *shadow = row->shadow;
    while (end - at >= STRETCH && !memcmp(memory + at, shadow + at, STRETCH))
        at += STRETCH;
    while (end - at >= BLOCK && !differs(memory + at, shadow + at))
        at += BLOCK;
    if (end - at < BLOCK && !memcmp(memory + at, shadow + at, (size_t)(end - at)))
        at = end;
    return at;
}

/* The changed blocks of a row from `at` to `end`, neighbours together: offset, length, bytes. */
static uint8_t *patches(struct row *row, int64_t at, int64_t end, uint8_t *out)
{
    const uint8_t *memory = row->memory;
    uint8_t *shadow = row->shadow;
    while ((at = first_change(row, at, end)) < end) {
        int64_t start = at;
        uint32_t head[2];
        do {
            int64_t length = end - at < BLOCK ? end - at : BLOCK;
            /* What is written down is the shadow: a client may write the memory meanwhile. */
            memcpy(shadow + at, memory + at, (size_t)length);
            at += length;
        } while (end - at >= BLOCK && differs(memory + at, shadow + at));
        head[0] = (uint32_t)start, head[1] = (uint32_t)(at - start);
        out = put(put(out, head, PATCH_HEAD), shadow + start, at - start);
    }
    return out;
}

/* The end of what is in use of a part. */
static int64_t end_of(const struct row *row, const struct part *part)
{
    int64_t size = part->size;
    if (part->element) {
        uint32_t count;
        memcpy(&count, row->memory + part->used, sizeof count);
        if (count < part->size / part->element)
            size = count * part->element;
    }
    return part->offset + size;
}

static int changed(struct row *row)
{
    int64_t i;
    if (row->writes && *row->writes != row->writes_seen) {
        row->writes_seen = *row->writes;
        return 1;
    }
    for (i = 0; i < row->key_count; i++) {
        const struct range *key = &row->keys[i];
        if (memcmp(row->memory + key->offset, row->shadow + key->offset, (size_t)key->size))
            return 1;
    }
    return 0;
}

/* A frame for each row that changed. */
static uint8_t *take(struct recorder *r, uint8_t *end)
{
    int64_t i, j;
    for (i = r->first; i < r->count; i++) {
        struct row *row = &r->rows[i];
        uint8_t *head = end;
        int whole = !row->seen || !row->key_count || (i + r->turn) % TURNS == 0;
        if (!changed(row) && !whole)
            continue;
        end += FRAME_HEAD;
        if (whole || !row->part_count)
            end = patches(row, 0, row->size, end);
        else
            for (j = 0; j < row->part_count; j++)
                end = patches(row, row->parts[j].offset, end_of(row, &row->parts[j]), end);
        if (end == head + FRAME_HEAD && row->seen) { /* nothing has changed */
            end = head;
            continue;
        }
        row->seen = 1;
        put_head(head, PATCH, row->channel, end - head - FRAME_HEAD);
    }
    return end;
}

/* Appends the frames of a step: its times, frames that come before, those of rows that changed, frames that come after.
   There is space for them. Returns how many bytes wait now. */
int64_t gz_record(struct recorder *r)
{
    uint8_t *end = put_head(r->data + r->used, TICK, 0, 16);
    r->turn++;
    end = put(put(end, &r->log_time, 8), &r->sim_time, 8);
    end = take(r, put(end, r->before, r->before_size));
    end = put_head(put(end, r->after, r->after_size), END, 0, 0);
    return r->used = end - r->data;
}

static double monotonic(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Appends the frames of the next step of a world. Returns 1 if it is time to send what waits, 0 if not, and -1 if Python
   has to record this step: the scene is another one, there is no space left, or its time is out of range. */
int64_t gz_record_step(struct recorder *r, struct moments *m)
{
    double time = m->time + *m->step, times[2] = {rint(time * 1e9), rint(*m->sim_time * 1e9)};
    if (*m->revision != m->revision_seen || r->used > r->limit || !(times[0] < LATEST && times[1] < LATEST))
        return -1;
    m->time = time;
    r->first = time < m->due - 1e-9; /* states are the first row */
    if (!r->first)
        m->due = time + m->period;
    r->log_time = (int64_t)times[0], r->sim_time = times[1] > 0.0 ? (int64_t)times[1] : 0;
    return gz_record(r) > m->send_size || monotonic() - m->sent >= m->send_period;
}
