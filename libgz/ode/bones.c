/* Bones of a skeleton: their poses between two keys of an animation, and in the world. Positions are 3 numbers a bone,
 * rotations 4: quaternions of length 1, u first. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "step.h"

static const double NEAR = 1e-9; /* sine of half an angle between rotations that are taken as equal */

/* Between two rotations, along the shorter way. */
static void turn_between(const double *a, const double *b, double share, double *out)
{
    double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3], sign = cosine < 0.0 ? -1.0 : 1.0;
    double angle = acos(smaller(fabs(cosine), 1.0)), sine = sin(angle), length = 0.0;
    double of_a = sine < NEAR ? 1.0 - share : sin((1.0 - share) * angle) / sine;
    double of_b = sign * (sine < NEAR ? share : sin(share * angle) / sine);
    int k;
    for (k = 0; k < 4; k++) {
        out[k] = of_a * a[k] + of_b * b[k];
        length += out[k] * out[k];
    }
    length = sqrt(length);
    for (k = 0; k < 4; k++)
        out[k] /= length;
}

void gz_blend_bones(int64_t count, const double *const *keys, double share, double *positions, double *turns)
{
    const double *before = keys[0], *after = keys[1], *turns_before = keys[2], *turns_after = keys[3];
    int64_t i;
    for (i = 0; i < 3 * count; i++)
        positions[i] = (1.0 - share) * before[i] + share * after[i];
    for (i = 0; i < count; i++)
        turn_between(turns_before + 4 * i, turns_after + 4 * i, share, turns + 4 * i);
}

static void multiply(const double *a, const double *b, double *out)
{
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

/* From the frames of parents, which come first, into that of the root's, whose pose is there already. */
void gz_join_bones(int64_t count, const int64_t *parents, const double *positions, const double *turns, double *places,
                   double *rotations)
{
    int64_t i;
    int k;
    for (i = 1; i < count; i++) {
        int64_t up = parents[i];
        rotate(rotations + 4 * up, positions + 3 * i, places + 3 * i);
        for (k = 0; k < 3; k++)
            places[3 * i + k] += places[3 * up + k];
        multiply(rotations + 4 * up, turns + 4 * i, rotations + 4 * i);
    }
}
