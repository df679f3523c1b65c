/* Linear complementarity with bounds on all unknowns, as the least of x A x / 2 - b x within the bounds, by an active set:
 * solve for the free unknowns; as long as some of these leave their bounds, keep them there; when all are within, free those
 * at a bound that press inwards. Each such round lowers the least value, so that it ends, rounding apart. J. Nocedal and
 * S. J. Wright, Numerical Optimization, 2006, chapters 16.5 and 16.7. */
#include "boxes.h"

#include <math.h>

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

/* How much the sum of a row misses, 0 where that is rounding. */
static double missing(const box_problem *p, int64_t i)
{
    const double *row = p->matrix + i * p->count;
    double sum = -p->right[i], size = fabs(p->right[i]);
    int64_t j;
    for (j = 0; j < p->count; j++) {
        sum += row[j] * p->result[j];
        size += fabs(row[j] * p->result[j]);
    }
    return fabs(sum) > ROUNDING * size ? sum : 0.0;
}

/* Free the unknowns at a bound that press inwards; how many. */
static int64_t free_some(const box_problem *p)
{
    int64_t i, count = 0;
    for (i = 0; i < p->count; i++) {
        double sum;
        if (p->place[i] == FREE || bounds_are_one(p, i))
            continue;
        sum = missing(p, i);
        if (p->place[i] == LOW ? sum >= 0.0 : sum <= 0.0)
            continue;
        p->place[i] = FREE;
        count++;
    }
    return count;
}

static double value(const box_problem *p, const double *x)
{
    int64_t i;
    double sum = 0.0;
    for (i = 0; i < p->count; i++)
        sum += x[i] * (0.5 * dot_of(p->matrix + i * p->count, x, p->count) - p->right[i]);
    return sum;
}

/* Where on the way from x to the result the first free unknown leaves its bounds, and which; 1 if none does. */
static double first_stop(const box_problem *p, const double *x, double slack, int64_t *which)
{
    double way = 1.0;
    int64_t i;
    *which = -1;
    for (i = 0; i < p->count; i++) {
        double to = p->result[i], bound = to < p->lower[i] - slack ? p->lower[i] : p->upper[i], part;
        if (p->place[i] != FREE || (to >= p->lower[i] - slack && to <= p->upper[i] + slack))
            continue;
        part = (bound - x[i]) / (to - x[i]);
        if (*which < 0 || part < way) {
            way = part;
            *which = i;
        }
    }
    return way;
}

/* Keep free unknowns that have left their bounds there: all of them if that lowers the value, else the first one. */
static void stop_at_bounds(const box_problem *p, double *x, double *trial, double slack, int64_t first, double way)
{
    int64_t i;
    for (i = 0; i < p->count; i++)
        trial[i] = fmin(fmax(p->result[i], p->lower[i]), p->upper[i]);
    if (value(p, trial) < value(p, x)) {
        for (i = 0; i < p->count; i++) {
            if (p->place[i] == FREE && p->result[i] < p->lower[i] - slack)
                p->place[i] = LOW;
            else if (p->place[i] == FREE && p->result[i] > p->upper[i] + slack)
                p->place[i] = HIGH;
            x[i] = trial[i];
        }
        return;
    }
    p->place[first] = p->result[first] < p->lower[first] ? LOW : HIGH;
    for (i = 0; i < p->count; i++)
        x[i] += way * (p->result[i] - x[i]);
    x[first] = p->place[first] == LOW ? p->lower[first] : p->upper[first];
}

int solve_box(box_problem *p)
{
    int64_t n = p->count, i, first, most = ATTEMPTS;
    double *x = p->scratch + n * (n + 1), *trial = x + n, way;
    for (i = 0; i < n; i++) {
        x[i] = fmin(fmax(p->result[i], p->lower[i]), p->upper[i]);
        if (bounds_are_one(p, i))
            p->place[i] = LOW;
    }
    while (most-- > 0) {
        double largest = 0.0;
        solve_free(p);
        for (i = 0; i < n; i++) {
            if (!isfinite(p->result[i]))
                return 0;
            largest = fmax(largest, fabs(p->result[i]));
        }
        way = first_stop(p, x, ROUNDING * largest, &first);
        if (first >= 0) {
            stop_at_bounds(p, x, trial, ROUNDING * largest, first, way);
            continue;
        }
        for (i = 0; i < n; i++) /* rounding apart, free unknowns are within their bounds */
            x[i] = p->result[i] = fmin(fmax(p->result[i], p->lower[i]), p->upper[i]);
        if (!free_some(p))
            return 1;
    }
    return 0;
}
