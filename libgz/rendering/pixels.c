/* Converts images of four bytes a pixel, as OpenGL stores them, to three bytes a pixel, as libgz serves them. */

#include <stddef.h>

/* GCC makes the loop's vector form for processors that have it; all others run the plain one. */
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
__attribute__((target_clones("default", "avx2")))
#endif
void gz_drop_alpha(const unsigned char *restrict from, unsigned char *restrict to, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        to[3 * i] = from[4 * i];
        to[3 * i + 1] = from[4 * i + 1];
        to[3 * i + 2] = from[4 * i + 2];
    }
}
