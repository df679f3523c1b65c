/* Links: interfaces in the memory of files, under their locks. A lock that a client keeps, and a file that has to be repaired,
 * are for Python. */
#define _GNU_SOURCE
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "updates.h"

static const double CHECK_PERIOD = 0.05; /* [s]; that of interface.py */

static int is_long_enough(const link_record *l) { return lseek((int)l->descriptor, 0, SEEK_END) >= l->size; }

int is_intact(const link_record *l) { return !memcmp(l->memory, l->head, (size_t)l->head_size); }

/* Restore the head, and the commands beside it, where a client overwrote them; 0 if Python has to: the file was
 * truncated, or the log is due. */
int restore(link_record *l)
{
    static const char no_head[HEAD];
    int64_t i, at = 0;
    if (is_intact(l))
        return 1;
    if (l->restored >= l->most_restored || !memcmp(l->memory, no_head, (size_t)l->head_size))
        return 0;
    l->restored++;
    memcpy(l->memory, l->head, (size_t)l->head_size);
    for (i = 0; l->kept_any && i < l->command_count; at += l->commands[i++].size)
        memcpy(l->memory + l->commands[i].offset, l->kept + at, (size_t)l->commands[i].size);
    return 1;
}

static int is_whole(link_record *l)
{
    double now = now_monotonic();
    int due = now >= l->next_check;
    if ((due || !l->counts) && !is_long_enough(l))
        return 0;
    if (due && l->counts && (l->counts[0] != l->seen[0] || l->counts[1] != l->seen[1]))
        return 0;
    if (!restore(l))
        return 0;
    if (due) {
        l->next_check = now + CHECK_PERIOD;
        l->keeps = 1;
    }
    return 1;
}

/* Whether the memory may be read without the lock: the file is as long as it should be, and nothing has to be kept. */
int may_peek(const link_record *l)
{
    return l->memory && l->counts && !l->blocked && !l->keeps && now_monotonic() < l->next_check && is_intact(l);
}

static const int ATTEMPTS = 32; /* some 20 us: clients mostly hold a lock for less */

/* Try the lock at most so often. */
static int seize(link_record *l, int64_t attempts)
{
    while (attempts-- > 0)
        if (!flock((int)l->descriptor, LOCK_EX | LOCK_NB)) {
            l->attempts = ATTEMPTS;
            return 1;
        }
    return 0;
}

/* Take the lock; 0, and it is not held, if Python has to wait for it, or to repair the file. */
int take(link_record *l)
{
    if (!l->memory)
        return 0;
    if (l->descriptor < 0)
        return 1;
    if (!seize(l, l->blocked ? 1 : ATTEMPTS))
        return 0;
    if (!is_whole(l)) {
        flock((int)l->descriptor, LOCK_UN);
        return 0;
    }
    l->blocked = 0;
    return 1;
}

/* Keep the commands, unless a client has overwritten the head meanwhile. */
static void keep_commands(link_record *l)
{
    int64_t i, at = 0;
    l->keeps = 0;
    for (i = 0; i < l->command_count; i++) {
        const span *s = l->commands + i;
        if (s->text)
            memset(l->found + at, 0, (size_t)s->size);
        else
            memcpy(l->found + at, l->memory + s->offset, (size_t)s->size);
        at += s->size;
    }
    if (!is_intact(l))
        return;
    memcpy(l->kept, l->found, (size_t)at);
    l->kept_any = 1;
}

void release(link_record *l)
{
    l->exchanges++;
    if (l->descriptor >= 0)
        flock((int)l->descriptor, LOCK_UN);
}

void give_back(link_record *l)
{
    if (l->keeps && l->descriptor >= 0)
        keep_commands(l);
    release(l);
}

/* Whether a client still holds a lock that Python has waited for in vain; each time it is tried half as often. */
int is_still_blocked(link_record *l)
{
    if (!l->memory || l->descriptor < 0 || !l->blocked)
        return 0;
    if (seize(l, l->attempts > 1 ? l->attempts : 1))
        return 0;
    l->attempts /= 2;
    return 1;
}
