/* Linear complementarity with bounds on all unknowns, by block principal pivoting: J. J. Judice and F. M. Pires, A block
 * principal pivoting algorithm for large-scale strictly monotone linear complementarity problems, 1994. All unknowns that
 * are on the wrong side change their place at once; if that does not help, only the last one does, which would always end
 * without rounding. */
#include "boxes.h"

#include <math.h>

enum { BLOCKS = 6 };         /* attempts to change many places without fewer of them being wrong */
enum { ATTEMPTS = 100 };     /* in all: ODE's solver is quicker than more of them, of which many would not end */
#define SINGULAR 1e-14       /* of a diagonal element: what is left is rounding */
#define ROUNDING 1e-13       /* of the terms of a sum */

/* The sum of products, in four chains, so that the processor need not wait for each addition. */
static double dot_of(const double *a, const double *b, int64_t n)
{
    double sums[4] = {0.0, 0.0, 0.0, 0.0};
    int64_t k, i;
    for (k = 0; k + 4 <= n; k += 4)
        for (i = 0; i < 4; i++)
            sums[i] += a[k + i] * b[k + i];
    for (; k < n; k++)
        sums[0] += a[k] * b[k];
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

static int bounds_are_one(const box_problem *p, int64_t i) { return p->lower[i] == p->upper[i]; }

/* Solve for the free unknowns, while the others are at their bounds. */
static void solve_free(const box_problem *p)
{
    int64_t n = p->count, i, j, k, free = 0;
    double *l = p->scratch, *x = p->scratch + n * n;
    for (i = 0; i < n; i++)
        if (p->place[i] != FREE)
            p->result[i] = p->place[i] == LOW ? p->lower[i] : p->upper[i];
    for (i = 0; i < n; i++) {
        const double *row = p->matrix + i * n;
        double *line = l + free * n, sum, pivot; /* the next row of the lower factor, with a reciprocal at its end */
        int64_t column = 0;
        if (p->place[i] != FREE)
            continue;
        sum = p->right[i];
        for (j = 0; j < n; j++)
            if (p->place[j] != FREE)
                sum -= row[j] * p->result[j];
        for (j = 0; j < i; j++) {
            const double *other = l + column * n;
            if (p->place[j] != FREE)
                continue;
            line[column] = (row[j] - dot_of(line, other, column)) * other[column];
            column++;
        }
        pivot = row[i] - dot_of(line, line, column);
        line[column] = 1.0 / sqrt(fmax(pivot, SINGULAR * row[i]));
        x[free++] = (sum - dot_of(line, x, column)) * line[column];
    }
    for (i = n - 1; i >= 0; i--) {
        if (p->place[i] != FREE)
            continue;
        free--;
        x[free] *= l[free * n + free];
        for (k = 0; k < free; k++)
            x[k] -= l[free * n + k] * x[free];
        p->result[i] = x[free];
    }
}

/* Where an unknown belongs, by what was found. */
static int64_t right_place(const box_problem *p, int64_t i, double largest)
{
    const double *row = p->matrix + i * p->count;
    double sum = -p->right[i], size = fabs(p->right[i]);
    int64_t j;
    if (bounds_are_one(p, i))
        return LOW;
    if (p->place[i] == FREE) {
        if (p->result[i] < p->lower[i] - ROUNDING * largest)
            return LOW;
        return p->result[i] > p->upper[i] + ROUNDING * largest ? HIGH : FREE;
    }
    for (j = 0; j < p->count; j++) {
        sum += row[j] * p->result[j];
        size += fabs(row[j] * p->result[j]);
    }
    if (p->place[i] == LOW)
        return sum < -ROUNDING * size ? FREE : LOW;
    return sum > ROUNDING * size ? FREE : HIGH;
}

int solve_box(box_problem *p)
{
    int64_t n = p->count, i, wrong, last = 0, fewest = n + 1, left = BLOCKS, most = ATTEMPTS;
    for (i = 0; i < n; i++)
        if (bounds_are_one(p, i))
            p->place[i] = LOW;
    while (most-- > 0) {
        double largest = 0.0;
        solve_free(p);
        for (i = 0; i < n; i++) {
            if (!isfinite(p->result[i]))
                return 0;
            largest = fmax(largest, fabs(p->result[i]));
        }
        for (wrong = 0, i = 0; i < n; i++)
            if (right_place(p, i, largest) != p->place[i]) {
                wrong++;
                last = i;
            }
        if (!wrong) {
            for (i = 0; i < n; i++) /* rounding apart, free unknowns are within their bounds */
                p->result[i] = fmin(fmax(p->result[i], p->lower[i]), p->upper[i]);
            return 1;
        }
        if (wrong < fewest) {
            fewest = wrong;
            left = BLOCKS;
        } else
            left--;
        if (left > 0) {
            for (i = 0; i < n; i++) {
                double *x = p->scratch; /* decided before any place changes */
                x[i] = (double)right_place(p, i, largest);
            }
            for (i = 0; i < n; i++)
                p->place[i] = (int64_t)p->scratch[i];
        } else
            p->place[last] = right_place(p, last, largest);
    }
    return 0;
}
