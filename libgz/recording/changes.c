/* Finds what has changed in pieces of memory since the last look, and writes it down as frames for the log's pipe. */

#include <stdint.h>
#include <string.h>

enum { BLOCK = 32, PATCH = 5, FRAME_HEAD = 7, PATCH_HEAD = 8 };

struct range {
    int64_t offset, size;
};

/* To look at all memory in each step would displace what the step itself needs from the processor's caches. So a row has
   keys, parts of it that change whenever something else does; all of it is compared in every eighth step besides. */
enum { TURNS = 8 };

struct row {
    const uint8_t *memory;
    uint8_t *shadow; /* as it was at the last look */
    int64_t size;    /* of both [byte] */
    int64_t channel;
    int64_t seen; /* whether there was a look */
    const struct range *keys;
    int64_t key_count; /* 0: all of it is compared each time */
};

static uint8_t *put32(uint8_t *at, uint32_t value)
{
    memcpy(at, &value, 4);
    return at + 4;
}

/* The changed blocks of a row, neighbours together: offset, length, bytes. */
static uint8_t *patches(struct row *row, uint8_t *out)
{
    int64_t at = 0;
    while (at < row->size) {
        int64_t start, length = row->size - at < BLOCK ? row->size - at : BLOCK;
        if (!memcmp(row->memory + at, row->shadow + at, (size_t)length)) {
            at += length;
            continue;
        }
        start = at;
        while (at < row->size) {
            length = row->size - at < BLOCK ? row->size - at : BLOCK;
            if (!memcmp(row->memory + at, row->shadow + at, (size_t)length))
                break;
            /* What is written down is the shadow: a client may write the memory meanwhile. */
            memcpy(row->shadow + at, row->memory + at, (size_t)length);
            at += length;
        }
        out = put32(put32(out, (uint32_t)start), (uint32_t)(at - start));
        memcpy(out, row->shadow + start, (size_t)(at - start));
        out += at - start;
    }
    return out;
}

static int changed(const struct row *row, int whole)
{
    for (int64_t i = 0; i < row->key_count; i++) {
        const struct range *key = &row->keys[i];
        if (memcmp(row->memory + key->offset, row->shadow + key->offset, (size_t)key->size))
            return 1;
    }
    return whole && memcmp(row->memory, row->shadow, (size_t)row->size);
}

/* Writes a frame for each row that changed; `out` takes all rows with an eighth more, and 64 bytes for each.
   `turn` counts the calls. Returns the number of bytes. */
int64_t gz_changes(struct row *rows, int64_t count, uint8_t *out, int64_t turn)
{
    uint8_t *end = out;
    for (int64_t i = 0; i < count; i++) {
        struct row *row = &rows[i];
        uint8_t *head = end;
        uint16_t channel = (uint16_t)row->channel;
        if (row->seen && !changed(row, !row->key_count || (i + turn) % TURNS == 0))
            continue;
        end = patches(row, head + FRAME_HEAD);
        if (end == head + FRAME_HEAD && row->seen) { /* a client has undone its change meanwhile */
            end = head;
            continue;
        }
        row->seen = 1;
        head[0] = PATCH;
        memcpy(head + 1, &channel, 2);
        put32(head + 3, (uint32_t)(end - head - FRAME_HEAD));
    }
    return end - out;
}
