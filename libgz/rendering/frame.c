/* Chooses what a view shows of a scene, and submits it to OpenGL. The twins in Python, of the same arithmetic in the same
   order, are in selection.py and submission.py. OpenGL's functions come as addresses, so nothing is linked. */

#include <math.h>
#include <stddef.h>
#include <stdint.h>

/* What a view shows of a scene's items; mirrored by SelectionRecord in selection.py. */
typedef struct {
    /* the view */
    double eye[16];           /* from the world into the eye frame, by rows */
    double near, far;         /* [m] */
    double across, up;        /* tangents of half the fields of view */
    double across_slant, up_slant; /* hypot(1, tangent) */
    double focal;             /* [px] */
    /* the items: state (x, y, z, u, x, y, z), radius of the ball around the body's origin [m] */
    const double *states, *radii;
    int64_t count;
    /* their round geoms, in the order of items: item, centre, half of the axis, radius [m] */
    const int64_t *round_items;
    const double *round_centres, *round_halves, *round_radii;
    const double *round_slacks;  /* how much less a cylinder is off than what is round in two directions */
    const int64_t *round_finest; /* the finest level of each one's item */
    int64_t round_count;
    /* levels of detail, by segments of a full turn */
    const double *segments;
    int64_t level_small, level_large; /* the first one is for what is tiny */
    double tiny, small;       /* [px] */
    double depth_error;       /* of round geoms, as a share of the distance */
    /* lights with a range: place in the eye frame, range [m] */
    const double *lights;
    int64_t light_count;
    /* out: for all items the matrix into the eye frame by columns; and of those that the view shows the place, the level, and a
       bit for each light out of whose range it is */
    double *matrices;
    int64_t *places, *levels, *dark;
} selection;

size_t gz_selection_size(void)
{
    return sizeof(selection);
}

/* The matrix of an item, by columns: the eye's times the pose's. */
static void place(const double *eye, const double *state, double *matrix)
{
    double u = state[3], x = state[4], y = state[5], z = state[6];
    double pose[12] = {
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + u * z), 2.0 * (x * z - u * y),
        2.0 * (x * y - u * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + u * x),
        2.0 * (x * z + u * y), 2.0 * (y * z - u * x), 1.0 - 2.0 * (x * x + y * y),
        state[0], state[1], state[2],
    };
    for (int column = 0; column < 4; column++) {
        const double *from = pose + 3 * column;
        for (int row = 0; row < 3; row++) {
            const double *by = eye + 4 * row;
            double sum = by[0] * from[0] + by[1] * from[1] + by[2] * from[2];
            matrix[4 * column + row] = column < 3 ? sum : sum + by[3];
        }
        matrix[4 * column + 3] = column < 3 ? 0.0 : 1.0;
    }
}

static double dot(const double *one, const double *other)
{
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
}

/* The least product of range and cosine to the normal, from the cosine one pixel from the limb; see `_least`. */
static double least(double facing, double radius, double tangent)
{
    double side = radius * sqrt(facing);
    return sqrt(facing) * tangent / (sqrt(tangent + side * side) + side);
}

/* The least product of range and cosine to the normal of a near round geom; see `_steepest` in selection.py. */
static double steepest(const selection *s, int64_t number, const double *matrix)
{
    const double *centre = s->round_centres + 3 * number, *axis = s->round_halves + 3 * number;
    double radius = s->round_radii[number], middle[3], half[3], point[3], foot[3];
    for (int row = 0; row < 3; row++) {
        const double *by = matrix + row;
        middle[row] = by[0] * centre[0] + by[4] * centre[1] + by[8] * centre[2] + by[12];
        half[row] = by[0] * axis[0] + by[4] * axis[1] + by[8] * axis[2];
    }
    double square = dot(half, half), line = square > 0.0 ? -dot(middle, half) / square : 0.0;
    double share = line < -1.0 ? -1.0 : line > 1.0 ? 1.0 : line;
    for (int row = 0; row < 3; row++) {
        point[row] = middle[row] + share * half[row];
        foot[row] = middle[row] + line * half[row];
    }
    double corner = 1.0 / sqrt(1.0 + s->across * s->across + s->up * s->up);
    double away = dot(point, point), tangent = away - radius * radius;
    if (!(tangent > s->near * s->near))
        return INFINITY;
    double distance = sqrt(away), length = sqrt(tangent), cosine = -point[2] / distance;
    double rest = 1.0 - cosine * cosine, sine = sqrt(rest > 0.0 ? rest : 0.0);
    double angle = cosine * length / distance - sine * radius / distance;
    angle = angle > corner ? angle : corner;
    double pixel = 2.0 * angle * angle / (radius * s->focal), facing = pixel * length;
    facing = facing < 1.0 ? facing : 1.0;
    double farthest = cosine * corner - sine * sqrt(1.0 - corner * corner);
    double inside = 1.0 - away / (radius * radius) * (1.0 - farthest * farthest);
    if (square == 0.0 && farthest > length / distance && inside > facing)
        facing = inside;
    double result = least(facing, radius, tangent), across = sqrt(dot(foot, foot));
    if (line == share || !(across > radius))
        return result;
    double edge = radius + sqrt((line - share) * (line - share) * square) / s->focal;
    across = across > edge ? across : edge;
    double flat = across * across - radius * radius, wide = pixel * sqrt(flat) * distance / across;
    double beyond = least(wide < 1.0 ? wide : 1.0, radius, flat);
    return beyond < result ? beyond : result;
}

/* The level with which depth is right of a round geom of an item; see `needed_segments` in selection.py. */
static int64_t round_level(const selection *s, int64_t number, const double *matrix)
{
    const double *centre = s->round_centres + 3 * number, *half = s->round_halves + 3 * number;
    double radius = s->round_radii[number];
    double depth = -(matrix[2] * centre[0] + matrix[6] * centre[1] + matrix[10] * centre[2]) - matrix[14];
    double reach = radius + fabs(matrix[2] * half[0] + matrix[6] * half[1] + matrix[10] * half[2]);
    double gap = depth - reach > s->near ? depth - reach : s->near;
    double distance = gap + radius;
    double limb = distance / sqrt(radius * s->focal / distance);
    double limit = gap < limb ? gap : limb, near = s->round_slacks[number] * steepest(s, number, matrix);
    double allowed = s->depth_error * (near < limit ? near : limit) / radius;
    double needed = depth + reach < s->near ? 0.0 : M_PI / sqrt(2.0 * (allowed > 1e-9 ? allowed : 1e-9));
    int64_t level = 0;
    while (level < s->round_finest[number] && s->segments[level] < needed)
        level++;
    return level;
}

/* How many items the view shows. */
int64_t gz_select(const selection *s)
{
    int64_t found = 0, next = 0;
    for (int64_t i = 0; i < s->count; i++) {
        double *matrix = s->matrices + 16 * i, radius = s->radii[i];
        place(s->eye, s->states + 7 * i, matrix);
        double x = matrix[12], y = matrix[13], z = matrix[14];
        int64_t first = next;
        while (next < s->round_count && s->round_items[next] == i)
            next++;
        if (!(radius - z >= s->near && -z - radius <= s->far && fabs(x) + s->across * z <= radius * s->across_slant
              && fabs(y) + s->up * z <= radius * s->up_slant))
            continue;
        int64_t level;
        if (first < next) {
            level = 0;
            for (int64_t k = first; k < next; k++) {
                int64_t finer = round_level(s, k, matrix);
                level = finer > level ? finer : level;
            }
        } else {
            double pixels = radius * s->focal / (-z > s->near ? -z : s->near);
            level = pixels <= s->tiny ? 0 : pixels <= s->small ? s->level_small : s->level_large;
        }
        int64_t dark = 0;
        for (int64_t k = 0; k < s->light_count; k++) {
            const double *light = s->lights + 4 * k;
            double dx = light[0] - x, dy = light[1] - y, dz = light[2] - z, reach = light[3] + radius;
            if (dx * dx + dy * dy + dz * dz > reach * reach)
                dark |= (int64_t)1 << k;
        }
        s->places[found] = i;
        s->levels[found] = level;
        s->dark[found] = dark;
        found++;
    }
    return found;
}

/* What is submitted, and with which functions; mirrored by SubmissionRecord in submission.py. */
typedef struct {
    void (*load_matrix)(const double *);
    void (*call_list)(unsigned);
    void (*enable)(unsigned);
    void (*disable)(unsigned);
    void (*color)(const unsigned char *);
    const double *matrices;      /* of all items, by columns */
    const int64_t *places;       /* of the items that are submitted, in this order */
    const uint32_t *lists;       /* of each of them */
    int64_t count;
    const unsigned char *colors; /* of all items, three each; or none */
    const int64_t *dark;         /* a bit for each light that does not reach it; or none */
    const uint32_t *lights;      /* OpenGL's numbers of those lights */
    int64_t light_count;
} submission;

size_t gz_submission_size(void)
{
    return sizeof(submission);
}

static int64_t switch_lights(const submission *s, int64_t now, int64_t wanted)
{
    for (int64_t k = 0; now != wanted && k < s->light_count; k++)
        if ((now ^ wanted) >> k & 1)
            (wanted >> k & 1 ? s->disable : s->enable)(s->lights[k]);
    return wanted;
}

/* Submit a list for each item; all lights are on before and after. */
void gz_submit(const submission *s)
{
    int64_t dark = 0;
    for (int64_t k = 0; k < s->count; k++) {
        int64_t i = s->places[k];
        if (s->colors)
            s->color(s->colors + 3 * i);
        if (s->dark)
            dark = switch_lights(s, dark, s->dark[k]);
        s->load_matrix(s->matrices + 16 * i);
        s->call_list(s->lists[k]);
    }
    switch_lights(s, dark, 0);
}
