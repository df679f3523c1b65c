/* Linear complementarity with bounds on all unknowns: which of them are free, and which at a bound. First by principal pivots,
 * each of the unknown that is at the wrong place by most energy: R. W. Cottle, J.-S. Pang and R. E. Stone, The Linear
 * Complementarity Problem, 1992, chapter 4. What is found is solved anew, and corrected where rounding has grown.
 *
 * Where that does not end, as the least of x A x / 2 - b x within the bounds, by an active set:
 * solve for the free unknowns; as long as some of these leave their bounds, keep them there; when all are within, free those
 * at a bound that press inwards. Each such round lowers the least value, so that it ends, rounding apart. J. Nocedal and
 * S. J. Wright, Numerical Optimization, 2006, chapters 16.5 and 16.7. */
#include "boxes.h"

#include <math.h>
#include <string.h>

enum { ATTEMPTS = 100 };     /* in all: ODE's solver is quicker than more of them, of which many would not end */
enum { PIVOTS = 4 };         /* for each unknown */
enum { EXCHANGES = 4 };      /* of all that are at the wrong place, before the active set */
#define SINGULAR 1e-14       /* of a diagonal element: what is left is rounding */
#define ROUNDING 1e-13       /* of the terms of a sum */
#define NEGLIGIBLE 1e-24     /* of the largest energy */

/* The sum of products, in four chains, so that the processor need not wait for each addition. */
static inline double dot_of(const double *a, const double *b, int64_t n)
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

static inline void add(double *restrict x, double by, const double *restrict y, int64_t n)
{
    int64_t i;
    for (i = 0; i < n; i++)
        x[i] += by * y[i];
}

static int bounds_are_one(const box_problem *p, int64_t i) { return p->lower[i] == p->upper[i]; }

/* List the free unknowns, and set the others to their bounds; how many are free. */
static int64_t list_free(const box_problem *p)
{
    int64_t i, count = 0;
    for (i = 0; i < p->count; i++)
        if (p->place[i] == FREE)
            p->listed[count++] = i;
        else
            p->result[i] = p->place[i] == LOW ? p->lower[i] : p->upper[i];
    return count;
}

/* Solve for the free unknowns, while the others are at their bounds: by an upper factor with reciprocals on its diagonal. */
static void solve_free(const box_problem *p)
{
    int64_t n = p->count, m = list_free(p), i, k;
    double *u = p->scratch, *x = u + n * n;
    for (i = 0; i < m; i++) {
        const double *row = p->matrix + p->listed[i] * n;
        for (k = i; k < m; k++)
            u[i * n + k] = row[p->listed[k]];
        x[i] = p->right[p->listed[i]];
    }
    for (k = 0; k < n; k++)
        if (p->place[k] != FREE && p->result[k] != 0.0)
            for (i = 0; i < m; i++)
                x[i] -= p->matrix[k * n + p->listed[i]] * p->result[k];
    for (k = 0; k < m; k++) {
        double *line = u + k * n, least = SINGULAR * p->matrix[p->listed[k] * (n + 1)];
        double inverse = 1.0 / sqrt(line[k] > least ? line[k] : least);
        for (i = k + 1; i < m; i++)
            line[i] *= inverse;
        line[k] = inverse;
        x[k] *= inverse;
        for (i = k + 1; i < m; i++) {
            if (line[i] == 0.0)
                continue;
            x[i] -= line[i] * x[k];
            add(u + i * n + i, -line[i], line + i, m - i);
        }
    }
    for (k = m - 1; k >= 0; k--)
        p->result[p->listed[k]] = x[k] = (x[k] - dot_of(u + k * n + k + 1, x + k + 1, m - k - 1)) * u[k * n + k];
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

/* Move all free unknowns that have left their bounds there, and free all that press inwards at one; how many. */
static int64_t exchange(const box_problem *p, double slack)
{
    int64_t i, count = 0;
    for (i = 0; i < p->count; i++) {
        int64_t place = FREE;
        if (bounds_are_one(p, i))
            continue;
        if (p->place[i] == FREE)
            place = p->result[i] < p->lower[i] - slack ? LOW : p->result[i] > p->upper[i] + slack ? HIGH : FREE;
        else {
            double sum = missing(p, i);
            if (p->place[i] == LOW ? sum >= 0.0 : sum <= 0.0)
                place = p->place[i];
        }
        count += place != p->place[i];
        p->place[i] = place;
    }
    return count;
}

/* The largest of the results, not a number if one is none. */
static double largest_of(const box_problem *p)
{
    double largest = 0.0;
    int64_t i;
    for (i = 0; i < p->count; i++)
        if (!(fabs(p->result[i]) <= largest))
            largest = fabs(p->result[i]);
    return largest;
}

static void clamp(const box_problem *p, double *x)
{
    int64_t i;
    for (i = 0; i < p->count; i++)
        x[i] = p->result[i] < p->lower[i] ? p->lower[i] : p->result[i] > p->upper[i] ? p->upper[i] : p->result[i];
}

/* Solve, and exchange as many at once as are wrong, in so many rounds; 0 if this does not come to an end. */
static int solve_by_exchange(const box_problem *p, int rounds)
{
    for (; rounds > 0; rounds--) {
        double largest;
        solve_free(p);
        largest = largest_of(p);
        if (!isfinite(largest))
            return 0;
        if (!exchange(p, ROUNDING * largest))
            return 1;
    }
    return 0;
}

/* The values of free unknowns, and what the rows of the others miss, as linear functions of the others' values and of what the
 * rows of free ones miss. */
typedef struct {
    int64_t count;
    double *matrix;
    double *value; /* of a free unknown; what the row of another one misses */
} tableau;

/* Exchange an unknown and what its row misses. */
static void pivot(const tableau *t, int64_t k)
{
    int64_t n = t->count, i;
    double *row = t->matrix + k * n, inverse = 1.0 / row[k];
    for (i = 0; i < n; i++) {
        double *line = t->matrix + i * n, part = line[k] * inverse;
        if (i == k || part == 0.0)
            continue;
        add(line, -part, row, n);
        line[k] = part;
    }
    for (i = 0; i < n; i++)
        row[i] *= -inverse;
    row[k] = inverse;
}

/* Change what the values depend on. */
static void shift(const tableau *t, int64_t k, double by)
{
    int64_t i;
    for (i = 0; i < t->count; i++)
        t->value[i] += t->matrix[i * t->count + k] * by;
}

/* How far an unknown is at the wrong place: from its bounds, or in what its row misses; 0 if it is right there. */
static double wrong_by(const box_problem *p, const tableau *t, int64_t k)
{
    double value = t->value[k];
    if (p->place[k] == FREE)
        return value < p->lower[k] ? p->lower[k] - value : value > p->upper[k] ? p->upper[k] - value : 0.0;
    return (value < 0.0 && p->result[k] < p->upper[k]) || (value > 0.0 && p->result[k] > p->lower[k]) ? value : 0.0;
}

/* Put a free unknown at the bound that it is beyond. */
static void put_at_bound(const box_problem *p, const tableau *t, int64_t k, double by)
{
    double needs = by / t->matrix[k * (t->count + 1)];
    shift(t, k, needs);
    t->value[k] = needs;
    p->result[k] = by > 0.0 ? p->lower[k] : p->upper[k];
    p->place[k] = by > 0.0 ? LOW : HIGH;
    pivot(t, k);
}

/* Let an unknown go to where its row misses nothing, or to its other bound. */
static void let_go(const box_problem *p, const tableau *t, int64_t k)
{
    double by = -t->value[k] / t->matrix[k * (t->count + 1)], to = p->result[k] + by;
    if (to < p->lower[k] || to > p->upper[k]) {
        p->place[k] = by < 0.0 ? LOW : HIGH;
        to = by < 0.0 ? p->lower[k] : p->upper[k];
        shift(t, k, to - p->result[k]);
        p->result[k] = to;
        return;
    }
    shift(t, k, by);
    t->value[k] = to;
    p->place[k] = FREE;
    pivot(t, k);
}

/* Find the places by pivots, from 0 or the bound that is next to it; 0 if they are not found. */
static int find_places(const box_problem *p)
{
    int64_t n = p->count, i, k, most = PIVOTS * n + 8;
    tableau t = {n, p->scratch, p->scratch + n * (n + 2)};
    double scale = 0.0;
    memcpy(t.matrix, p->matrix, (size_t)(n * n) * sizeof *t.matrix);
    for (i = 0; i < n; i++) {
        t.value[i] = -p->right[i];
        if (p->matrix[i * (n + 1)] > 0.0)
            scale = fmax(scale, p->right[i] * p->right[i] / p->matrix[i * (n + 1)]);
        p->place[i] = LOW; /* or between both bounds */
    }
    for (i = 0; i < n; i++) {
        p->result[i] = p->lower[i] > 0.0 ? p->lower[i] : p->upper[i] < 0.0 ? p->upper[i] : 0.0;
        if (p->result[i] != 0.0)
            shift(&t, i, p->result[i]);
    }
    while (most-- > 0) {
        double largest = NEGLIGIBLE * scale;
        for (k = -1, i = 0; i < n; i++) {
            double wrong = wrong_by(p, &t, i), own = t.matrix[i * (n + 1)];
            if (wrong == 0.0 || (p->place[i] != FREE && own <= SINGULAR * p->matrix[i * (n + 1)]) ||
                wrong * wrong <= largest * own)
                continue;
            largest = wrong * wrong / own;
            k = i;
        }
        if (k < 0)
            break;
        if (p->place[k] == FREE)
            put_at_bound(p, &t, k, wrong_by(p, &t, k));
        else
            let_go(p, &t, k);
    }
    for (i = 0; i < n; i++)
        if (p->place[i] != FREE)
            p->place[i] = p->result[i] <= p->lower[i] ? LOW : p->result[i] >= p->upper[i] ? HIGH : FREE;
    return solve_by_exchange(p, EXCHANGES);
}

int solve_box(box_problem *p)
{
    int64_t n = p->count, i, first, most = ATTEMPTS;
    double *x = p->scratch + n * (n + 1), *trial = x + n, way;
    for (i = 0; i < n; i++)
        p->place[i] = bounds_are_one(p, i) ? LOW : FREE;
    if (solve_by_exchange(p, 1) || find_places(p)) {
        clamp(p, p->result); /* rounding apart, free unknowns are within their bounds */
        return 1;
    }
    list_free(p);
    clamp(p, x);
    while (most-- > 0) {
        double largest;
        solve_free(p);
        largest = largest_of(p);
        if (!isfinite(largest))
            return 0;
        way = first_stop(p, x, ROUNDING * largest, &first);
        if (first >= 0) {
            stop_at_bounds(p, x, trial, ROUNDING * largest, first, way);
            continue;
        }
        clamp(p, x);
        clamp(p, p->result);
        if (!free_some(p))
            return 1;
    }
    return 0;
}
