/* The memory of ODE's objects: bodies, geoms and joints lie beside each other, whatever Python allocates meanwhile.
 *
 * A step visits all of them several times; scattered over the heap of a Python process they take more of the processor's
 * cache, and a step of 50 robots takes 1.15 times as long. Blocks of one size share slabs, in order of construction. A
 * block's slab knows the size, so that nothing depends on the sizes that ODE gives when it frees.
 */
#define _GNU_SOURCE
#include <pthread.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

typedef void *get_function(size_t size);
typedef void *grow_function(void *block, size_t size, size_t wanted);
typedef void free_function(void *block, size_t size);

enum { GRAIN = 64, CLASSES = 32 }; /* sizes are multiples of a cache line; larger blocks are those of malloc */
enum { SLAB = 16 << 10, SLABS = 1 << 16 };

static char *begin; /* of the address space that is reserved for slabs */
static int64_t used; /* slabs */
static unsigned char classes[SLABS];
static char *next[CLASSES + 1], *end[CLASSES + 1]; /* unused part of the last slab of each class */
static void *freed[CLASSES + 1];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static get_function *other_get;
static grow_function *other_grow;
static free_function *other_free;

static void enter(void) { pthread_mutex_lock(&lock); }
static void leave(void) { pthread_mutex_unlock(&lock); }

static int is_own(const void *block)
{
    return (const char *)block >= begin && (const char *)block < begin + (size_t)SLABS * SLAB;
}

static int add_slab(int class)
{
    char *slab = begin + (size_t)used * SLAB;
    if (used == SLABS || mprotect(slab, SLAB, PROT_READ | PROT_WRITE))
        return 0;
    classes[used++] = (unsigned char)class;
    next[class] = slab;
    end[class] = slab + SLAB;
    return 1;
}

static void *take(int class)
{
    void *block = freed[class];
    if (block) {
        memcpy(&freed[class], block, sizeof block);
        return block;
    }
    if (end[class] - next[class] < class * GRAIN && !add_slab(class))
        return NULL;
    block = next[class];
    next[class] += class * GRAIN;
    return block;
}

static void *get(size_t size)
{
    void *block = NULL;
    if (size <= CLASSES * GRAIN) {
        enter();
        block = take((int)((size + GRAIN - 1) / GRAIN) + !size);
        leave();
    }
    return block ? block : other_get ? other_get(size) : malloc(size);
}

static void drop(void *block, size_t size)
{
    if (is_own(block)) {
        int class = classes[((char *)block - begin) / SLAB];
        enter();
        memcpy(block, &freed[class], sizeof block);
        freed[class] = block;
        leave();
    } else if (other_free)
        other_free(block, size);
    else
        free(block);
}

static void *grow(void *block, size_t size, size_t wanted)
{
    void *grown;
    size_t usable;
    if (!is_own(block))
        return other_grow ? other_grow(block, size, wanted) : realloc(block, wanted);
    usable = (size_t)classes[((char *)block - begin) / SLAB] * GRAIN;
    if (wanted <= usable)
        return block;
    grown = get(wanted);
    if (grown) {
        memcpy(grown, block, usable);
        drop(block, size);
    }
    return grown;
}

/* Let ODE allocate here from now on; what it allocated before is freed as it was. `functions` are those of ODE that get
 * and set how it allocates, reallocates and frees, in this order. */
void gz_use_blocks(void *const *functions)
{
    char *space = mmap(NULL, (size_t)SLABS * SLAB, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (space == MAP_FAILED)
        return;
    if (pthread_atfork(enter, leave, leave)) {
        munmap(space, (size_t)SLABS * SLAB);
        return;
    }
    begin = space;
    other_get = ((get_function * (*)(void)) functions[0])();
    ((void (*)(get_function *))functions[1])(get);
    other_grow = ((grow_function * (*)(void)) functions[2])();
    ((void (*)(grow_function *))functions[3])(grow);
    other_free = ((free_function * (*)(void)) functions[4])();
    ((void (*)(free_function *))functions[5])(drop);
}
