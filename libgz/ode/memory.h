/* Arrays of the native step that grow as they are needed, and are kept from step to step. */

#ifndef LIBGZ_ODE_MEMORY_H
#define LIBGZ_ODE_MEMORY_H

#include <stdint.h>
#include <stdlib.h>

/* An array that holds so many elements, and more than twice as many where it has to grow; NULL without memory. */
static inline void *enlarged(void *array, int64_t *capacity, int64_t count, size_t size)
{
    int64_t most = 2 * count + 64;
    if (array && count <= *capacity)
        return array;
    array = realloc(array, (size_t)most * size);
    if (array)
        *capacity = most;
    return array;
}

#endif
