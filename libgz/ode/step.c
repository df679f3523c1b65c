/* The native step: contacts, the ODE step, the copy of all states, and ray scans, without a Python call inside.
 *
 * It is linked against nothing. gz_step_needs() lists the ODE functions it calls, gz_step_bind() takes their
 * addresses in that order; so it builds without ODE's headers and cannot meet another ODE than the one in use.
 * libgz/ode/python_step.py holds its twin in Python. Both do the same arithmetic in the same order: their trajectories are
 * equal to the last bit, and a test says so.
 */
#include <float.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef void near_callback(void *data, void *geom1, void *geom2);
typedef void message_handler(int number, const char *text, va_list arguments);

typedef struct {
    int mode;
    double mu, mu2, rho, rho2, rhoN, bounce, bounce_vel, soft_erp, soft_cfm, motion1, motion2, motionN, slip1, slip2;
} surface_parameters;

typedef struct {
    double pos[4], normal[4], depth;
    void *g1, *g2;
    int side1, side2;
} contact_geom;

typedef struct {
    surface_parameters surface;
    contact_geom geom;
    double fdir1[4];
} contact;

/* What a joint did to its bodies in a step. */
typedef struct {
    double f1[4], t1[4], f2[4], t2[4];
} feedback;

/* Where a world gets the memory that it steps in. */
typedef struct {
    unsigned size; /* of this struct */
    void *(*get)(size_t size);
    void *(*shrink)(void *block, size_t size, size_t smaller);
    void (*drop)(void *block, size_t size);
} memory_functions;

#define ODE_FUNCTIONS(X)                                                        \
    X(void, dSpaceCollide, (void *, void *, near_callback *))                   \
    X(void, dSpaceCollide2, (void *, void *, void *, near_callback *))          \
    X(int, dCollide, (void *, void *, int, contact_geom *, int))                \
    X(int, dGeomIsSpace, (void *))                                              \
    X(int, dGeomGetClass, (void *))                                             \
    X(const double *, dGeomGetPosition, (void *))                               \
    X(const double *, dGeomGetRotation, (void *))                               \
    X(void, dGeomSetRotation, (void *, const double *))                         \
    X(void, dGeomCylinderGetParams, (void *, double *, double *))               \
    X(void, dGeomCapsuleGetParams, (void *, double *, double *))                \
    X(void *, dGeomGetBody, (void *))                                           \
    X(void *, dGeomGetData, (void *))                                           \
    X(void, dGeomGetAABB, (void *, double *))                                   \
    X(void, dGeomSetPosition, (void *, double, double, double))                 \
    X(void, dGeomBoxSetLengths, (void *, double, double, double))               \
    X(void, dGeomRaySet, (void *, double, double, double, double, double, double)) \
    X(void, dGeomRaySetLength, (void *, double))                                \
    X(int, dAreConnectedExcluding, (void *, void *, int))                       \
    X(int, dBodyIsEnabled, (void *))                                            \
    X(int, dBodyIsKinematic, (void *))                                          \
    X(int, dBodyGetGravityMode, (void *))                                       \
    X(void *, dJointCreateContact, (void *, void *, const contact *))           \
    X(void, dJointSetFeedback, (void *, feedback *))                            \
    X(void, dJointAttach, (void *, void *, void *))                             \
    X(void, dJointGroupEmpty, (void *))                                         \
    X(int, dWorldStep, (void *, double))                                        \
    X(int, dWorldQuickStep, (void *, double))                                   \
    X(void, dWorldCleanupWorkingMemory, (void *))                               \
    X(int, dWorldSetStepMemoryManager, (void *, const memory_functions *))      \
    X(void, dRandSetSeed, (unsigned long))                                      \
    X(unsigned long, dRandGetSeed, (void))                                      \
    X(message_handler *, dGetDebugHandler, (void))                              \
    X(void, dSetDebugHandler, (message_handler *))                              \
    X(const double *, dBodyGetPosition, (void *))                               \
    X(const double *, dBodyGetQuaternion, (void *))                             \
    X(const double *, dBodyGetLinearVel, (void *))                              \
    X(const double *, dBodyGetAngularVel, (void *))                             \
    X(const double *, dBodyGetForce, (void *))                                  \
    X(void, dBodySetLinearVel, (void *, double, double, double))                \
    X(void, dBodySetAngularVel, (void *, double, double, double))               \
    X(void, dBodySetForce, (void *, double, double, double))                    \
    X(void, dBodySetTorque, (void *, double, double, double))                   \
    X(const double *, dBodyGetTorque, (void *))                                 \
    X(double, dJointGetHingeAngle, (void *))                                    \
    X(double, dJointGetHingeAngleRate, (void *))                                \
    X(void, dJointAddHingeTorque, (void *, double))                             \
    X(void, dJointAddSliderForce, (void *, double))                             \
    X(double, dJointGetSliderPosition, (void *))                                \
    X(double, dJointGetSliderPositionRate, (void *))                            \
    X(double, dJointGetHinge2Angle1, (void *))                                  \
    X(double, dJointGetHinge2Angle2, (void *))                                  \
    X(double, dJointGetHinge2Angle1Rate, (void *))                              \
    X(double, dJointGetHinge2Angle2Rate, (void *))                              \
    X(double, dJointGetUniversalAngle1, (void *))                               \
    X(double, dJointGetUniversalAngle2, (void *))                               \
    X(double, dJointGetUniversalAngle1Rate, (void *))                           \
    X(double, dJointGetUniversalAngle2Rate, (void *))                           \
    X(double, dJointGetPistonAngle, (void *))                                   \
    X(double, dJointGetPistonPosition, (void *))                                \
    X(double, dJointGetPistonAngleRate, (void *))                               \
    X(double, dJointGetPistonPositionRate, (void *))

#define DECLARE(result, name, arguments) static result(*name) arguments;
ODE_FUNCTIONS(DECLARE)

/* Names in the order in which gz_step_bind() takes addresses; ends with NULL. */
const char *const *gz_step_needs(void)
{
#define NAME(result, name, arguments) #name,
    static const char *const names[] = {ODE_FUNCTIONS(NAME) NULL};
    return names;
}

/* ODE's assertions end the process. In the middle of solving they mean that numbers ran away, and then the step is
 * given up: what is left behind is mended by who called (Engine). Where the contacts of a pair are looked for, the pair
 * is given up. */
/* GCC's own jump saves three words where the library's saves all registers, and that for each pair of geoms. */
#ifdef __GNUC__
typedef void *jump[5];
#define SET_JUMP(place) __builtin_setjmp(place)
#define JUMP_BACK(place) __builtin_longjmp(place, 1)
#else
typedef jmp_buf jump;
#define SET_JUMP(place) setjmp(place)
#define JUMP_BACK(place) longjmp(place, 1)
#endif
static __thread jump given_up;
static __thread int guarded;
static message_handler *other_handler;

static void on_assertion(int number, const char *text, va_list arguments)
{
    if (guarded)
        JUMP_BACK(given_up);
    if (other_handler)
        other_handler(number, text, arguments);
}

void gz_step_bind(void *const *addresses)
{
#define BIND(result, name, arguments) *(void **)&name = *addresses++;
    ODE_FUNCTIONS(BIND)
    other_handler = dGetDebugHandler();
    dSetDebugHandler(on_assertion);
}

/* One contact point of a step, as it is told to who asks; CONTACT in context.py is the same. */
typedef struct {
    int64_t geom1, geom2; /* rows */
    double position[3], normal[3], depth;
    double force1[3], torque1[3], force2[3], torque2[3];
} contact_record;

/* The joint of a recorded contact until it is solved: NULL for a point that does not push. */
typedef struct {
    feedback told;
    void *joint;
    int64_t reversed; /* ODE's first body is that of the second geom */
} pending_contact;

/* Mirrored by StepContext in context.py; gz_step_context_size() guards against drift. */
typedef struct {
    void *world, *space, *contacts, *ray, *probe, *stand_in;
    int64_t no_cylinder_pairs; /* 1: this ODE cannot collide cylinders with each other or with capsules */
    double step;
    int64_t quick;         /* 1: dWorldQuickStep */
    int64_t contact_rule;  /* LEGACY_RULE or CLASSIC_RULE */
    int64_t count_turns;   /* 1: angles of joints go on beyond pi; 0: they stay in -pi to pi */
    int64_t check_divergence; /* read by the Python form only; this one always looks for diverged bodies */
    uint64_t seed;         /* ODE's random state, one per world */
    int64_t steps;         /* so far */
    int64_t contact_count; /* of the last step */
    int64_t max_contacts;  /* of a pair of geoms, under the classic rule */
    int64_t cone;          /* 1: under the classic rule friction acts against the motion, as in a cone */
    double gravity[3];     /* what the cone looks ahead with */
    int64_t record;        /* 1: contact points are recorded */
    int64_t record_count, record_room;
    contact_record *records;
    pending_contact *pending; /* one for each record */
    const double *surface; /* 24 a geom: see the SURFACE_ columns below */
    const int64_t *owner;  /* a number a geom: that of its body */
    int64_t body_count;
    void *const *bodies;   /* NULL: a free row */
    const double *com;     /* centre of mass in the body frame, 3 a row */
    double *body_state;    /* 16 a row: position, quaternion, centre of mass, linear and angular velocity */
    int64_t watch;         /* 1: body_start is filled */
    double *body_start;    /* 12 a row, as a step begins: linear and angular velocity, force and torque put on it */
    int64_t joint_count;
    void *const *joints;
    const int64_t *joint_types;
    double *joint_state;   /* 4 a row: angle 1 and 2, rate 1 and 2 */
    const double *springs; /* 3 a row, for hinges and sliders: stiffness, damping, reference */
    int64_t halted;        /* 1 + the row of a body that ran away and was halted; 0: none */
    int64_t gave_up;       /* 1: the last step was given up */
    double farthest;       /* [m] from the origin to where bodies are lost */
    int64_t careful;       /* 1: a step was given up before, and no memory is kept from one to the next */
    int64_t lost;          /* bodies whose numbers ran away */
    int64_t baffled;       /* 1: an assertion ended the search for the contacts of a pair, or for what a ray hits */
    int64_t baffled_by[2]; /* rows of the geoms of the last such pair; -1: a ray */
} context;

enum { LEGACY_RULE = 0, CLASSIC_RULE = 1 };

size_t gz_step_context_size(void) { return sizeof(context); }

enum { MAX_CONTACTS = 10, MOST_CONTACTS = 250 }; /* of a pair: legacy; what classic chooses the deepest from */
enum { JOINT_HINGE = 2, JOINT_SLIDER = 3, JOINT_CONTACT = 4, JOINT_UNIVERSAL = 5, JOINT_HINGE2 = 6 };
enum { JOINT_PISTON = 14 };
enum { CAPSULE_CLASS = 2, CYLINDER_CLASS = 3, PLANE_CLASS = 4, RAY_CLASS = 5, HEIGHTFIELD_CLASS = 9 };
enum { MU2 = 0x001, FDIR1 = 0x002, BOUNCE = 0x004, SOFT_ERP = 0x008, SOFT_CFM = 0x010, SLIP1 = 0x100, SLIP2 = 0x200 };
enum { ROLLING = 0x400, APPROX1 = 0x3000, APPROX1_N = 0x4000 };
/* Columns of the surface table; fdir1 is in the geom's frame, and zero where it is not used. */
enum {
    SURFACE_KP,
    SURFACE_KD,
    SURFACE_MU,
    SURFACE_BOUNCE,
    SURFACE_MU2,
    SURFACE_SLIP1,
    SURFACE_SLIP2,
    SURFACE_BOUNCE_VEL,
    SURFACE_FDIR1,
    SURFACE_MAX_CONTACTS = SURFACE_FDIR1 + 3,
    SURFACE_MAX_VEL,
    SURFACE_MIN_DEPTH,
    SURFACE_BITS,
    SURFACE_GHOST,      /* 1: points are found and told, and do not push */
    SURFACE_GHOST_BITS, /* a pair with a ghost and without a common bit of these has no points either */
    SURFACE_TORSION,
    SURFACE_BY_PATCH, /* 1: torsion goes by the patch radius, 0: by the surface radius and depth */
    SURFACE_PATCH_RADIUS,
    SURFACE_RADIUS,
    SURFACE_COLUMNS = 24
};
#define LOST_SPEED 2e9 /* [m/s] and [rad/s], after a step */
#define FASTEST 1e7    /* [m/s] and [rad/s] */
#define STRONGEST 1e12 /* [N] and [N m] */
#define TURN 6.2831853071795862 /* 2 pi */
#define PATCH_LEVER 0.58904862254808621 /* 3 pi / 16: mean lever of friction in a patch under Hertz's pressure */

static double smaller(double a, double b) { return a < b ? a : b; }
static double larger(double a, double b) { return a > b ? a : b; }

/* A contact is a spring and damper in series with its partner: erp = h kp / (h kp + kd), cfm = 1 / (h kp + kd). */
static void make_surface(const context *c, const double *a, const double *b, surface_parameters *s)
{
    double softness = 1.0 / a[SURFACE_KP] + 1.0 / b[SURFACE_KP];
    double kd = a[SURFACE_KD] + b[SURFACE_KD];
    s->mode = SOFT_ERP | SOFT_CFM | APPROX1;
    s->mu = smaller(a[SURFACE_MU], b[SURFACE_MU]);
    s->soft_erp = 1.0;
    s->soft_cfm = 0.0;
    if (softness > 0.0) {
        double spring = c->step * (1.0 / softness);
        s->soft_erp = spring / (spring + kd);
        s->soft_cfm = 1.0 / (spring + kd);
    }
    s->bounce = larger(a[SURFACE_BOUNCE], b[SURFACE_BOUNCE]);
    s->bounce_vel = 0.0;
    if (c->contact_rule == CLASSIC_RULE) {
        s->bounce = smaller(a[SURFACE_BOUNCE], b[SURFACE_BOUNCE]);
        s->bounce_vel = smaller(a[SURFACE_BOUNCE_VEL], b[SURFACE_BOUNCE_VEL]);
        s->mu2 = smaller(a[SURFACE_MU2], b[SURFACE_MU2]);
        s->mode |= MU2;
    }
    if (s->bounce > 0.0)
        s->mode |= BOUNCE;
}

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* dCollide, without an end of the process: no contacts where an assertion of ODE's fails. */
static int collide_pair(context *c, void *geom1, void *geom2, int most, contact_geom *points, int skip)
{
    void *geoms[2] = {geom1, geom2};
    double position[2][4], rotation[2][12];
    int class1 = dGeomGetClass(geom1), class2 = dGeomGetClass(geom2), count, k;
    int moved = (class1 == HEIGHTFIELD_CLASS && class2 != PLANE_CLASS) ||
                (class2 == HEIGHTFIELD_CLASS && class1 != PLANE_CLASS);

    /* ODE moves what meets a height field into its frame, and back when it is done. */
    for (k = 0; moved && k < 2; k++) {
        memcpy(position[k], dGeomGetPosition(geoms[k]), sizeof position[k]);
        memcpy(rotation[k], dGeomGetRotation(geoms[k]), sizeof rotation[k]);
    }
    guarded = 1;
    if (SET_JUMP(given_up)) {
        guarded = 0;
        for (k = 0; moved && k < 2; k++) {
            memcpy((double *)dGeomGetPosition(geoms[k]), position[k], sizeof position[k]);
            memcpy((double *)dGeomGetRotation(geoms[k]), rotation[k], sizeof rotation[k]);
        }
        c->baffled = 1;
        for (k = 0; k < 2; k++)
            c->baffled_by[k] = dGeomGetClass(geoms[k]) == RAY_CLASS ? -1 : (int64_t)(intptr_t)dGeomGetData(geoms[k]);
        return 0;
    }
    count = dCollide(geom1, geom2, most, points, skip);
    guarded = 0;
    return count;
}

/* Put the stand-in where a cylinder is: a box `radial` long towards the other's axis, `tangential` across it. */
static void place_stand_in(void *box, const double *position, const double *x, const double *y, const double *axis,
                           double radial, double tangential, double length)
{
    double rotation[12];
    int k;
    for (k = 0; k < 3; k++) {
        rotation[4 * k] = x[k];
        rotation[4 * k + 1] = y[k];
        rotation[4 * k + 2] = axis[k];
        rotation[4 * k + 3] = 0.0;
    }
    dGeomBoxSetLengths(box, 2.0 * radial, 2.0 * tangential, length);
    dGeomSetPosition(box, position[0], position[1], position[2]);
    dGeomSetRotation(box, rotation);
}

/* Contacts of a cylinder with a cylinder or capsule, which ODE lacks without libccd. The cylinder is taken as two
 * boxes inside it: a strip that points at the other's axis, so that sides touch at the true radius, and the square
 * inscribed in its ends, so that one can stand on the other. */
static int collide_cylinder(context *c, void *geom1, void *geom2, int class2, contact *points)
{
    void *cylinder = class2 == CYLINDER_CLASS ? geom2 : geom1, *other = cylinder == geom2 ? geom1 : geom2;
    const double *p = dGeomGetPosition(cylinder), *q = dGeomGetPosition(other);
    const double *r = dGeomGetRotation(cylinder), *s = dGeomGetRotation(other);
    double radius, length, other_radius, other_length, along, square, t, size;
    double axis[3], other_axis[3], gap[3], aim[3], side[3];
    int k, count;

    dGeomCylinderGetParams(cylinder, &radius, &length);
    if (dGeomGetClass(other) == CYLINDER_CLASS)
        dGeomCylinderGetParams(other, &other_radius, &other_length);
    else
        dGeomCapsuleGetParams(other, &other_radius, &other_length);
    for (k = 0; k < 3; k++) {
        axis[k] = r[4 * k + 2];
        other_axis[k] = s[4 * k + 2];
        gap[k] = q[k] - p[k];
    }
    /* The point of the other's axis that is nearest to ours, seen across our axis. */
    along = dot(gap, axis);
    t = dot(other_axis, axis);
    for (k = 0; k < 3; k++) {
        gap[k] = gap[k] - along * axis[k];
        other_axis[k] = other_axis[k] - t * axis[k];
    }
    square = dot(other_axis, other_axis);
    t = square > 1e-9 ? -dot(gap, other_axis) / square : 0.0;
    if (t > 0.5 * other_length)
        t = 0.5 * other_length;
    if (t < -0.5 * other_length)
        t = -0.5 * other_length;
    for (k = 0; k < 3; k++)
        aim[k] = gap[k] + t * other_axis[k];
    size = dot(aim, aim);
    if (size < 1e-18) {
        for (k = 0; k < 3; k++)
            aim[k] = r[4 * k];
        size = 1.0;
    }
    size = sqrt(size);
    for (k = 0; k < 3; k++)
        aim[k] = aim[k] / size;
    side[0] = axis[1] * aim[2] - axis[2] * aim[1];
    side[1] = axis[2] * aim[0] - axis[0] * aim[2];
    side[2] = axis[0] * aim[1] - axis[1] * aim[0];

    place_stand_in(c->stand_in, p, aim, side, axis, radius, 0.2 * radius, length);
    geom1 = cylinder == geom1 ? c->stand_in : geom1;
    geom2 = cylinder == geom2 ? c->stand_in : geom2;
    count = collide_pair(c, geom1, geom2, MAX_CONTACTS / 2, &points[0].geom, sizeof(contact));
    place_stand_in(c->stand_in, p, aim, side, axis, radius * 0.70710678118654752, radius * 0.70710678118654752, length);
    count += collide_pair(c, geom1, geom2, MAX_CONTACTS / 2, &points[count].geom, sizeof(contact));
    return count;
}

/* The direction in which mu counts: that of the geom with the smaller mu, laid into the contact's plane. */
static int friction_direction(const double *a, const double *b, void *geom1, void *geom2, contact *point)
{
    const double *local = a + SURFACE_FDIR1, *r, *n = point->geom.normal;
    void *geom = geom1;
    double along, size;
    int k;

    if (dot(local, local) == 0.0 || (b[SURFACE_MU] < a[SURFACE_MU] && dot(b + SURFACE_FDIR1, b + SURFACE_FDIR1) > 0.0)) {
        local = b + SURFACE_FDIR1;
        geom = geom2;
    }
    if (dot(local, local) == 0.0)
        return 0;
    r = dGeomGetRotation(geom);
    for (k = 0; k < 3; k++)
        point->fdir1[k] = r[4 * k] * local[0] + r[4 * k + 1] * local[1] + r[4 * k + 2] * local[2];
    along = dot(point->fdir1, n);
    for (k = 0; k < 3; k++)
        point->fdir1[k] = point->fdir1[k] - along * n[k];
    size = sqrt(dot(point->fdir1, point->fdir1));
    if (size < 1e-9)
        return 0;
    for (k = 0; k < 3; k++)
        point->fdir1[k] = point->fdir1[k] / size;
    return 1;
}

/* Velocity of a body at a point at the end of the step if nothing but gravity acts, added with a sign. */
static void add_velocity(const context *c, void *body, const double *at, double sign, double *sum)
{
    const double *x, *v, *w;
    double arm[3], share;
    int k;
    if (!body)
        return;
    x = dBodyGetPosition(body);
    v = dBodyGetLinearVel(body);
    w = dBodyGetAngularVel(body);
    share = dBodyGetGravityMode(body) && !dBodyIsKinematic(body) ? c->step : 0.0;
    for (k = 0; k < 3; k++)
        arm[k] = at[k] - x[k];
    sum[0] = sum[0] + sign * (v[0] + (w[1] * arm[2] - w[2] * arm[1]) + share * c->gravity[0]);
    sum[1] = sum[1] + sign * (v[1] + (w[2] * arm[0] - w[0] * arm[2]) + share * c->gravity[1]);
    sum[2] = sum[2] + sign * (v[2] + (w[0] * arm[1] - w[1] * arm[0]) + share * c->gravity[2]);
}

/* The direction in which the geoms slide on each other: a pyramid laid along it rubs as a cone does. */
static int sliding_direction(const context *c, void *geom1, void *geom2, contact *point)
{
    double slide[3] = {0.0, 0.0, 0.0}, along, size;
    int k;
    add_velocity(c, dGeomGetBody(geom1), point->geom.pos, 1.0, slide);
    add_velocity(c, dGeomGetBody(geom2), point->geom.pos, -1.0, slide);
    along = dot(slide, point->geom.normal);
    for (k = 0; k < 3; k++)
        slide[k] = slide[k] - along * point->geom.normal[k];
    size = sqrt(dot(slide, slide));
    if (size < 1e-9)
        return 0;
    for (k = 0; k < 3; k++)
        point->fdir1[k] = slide[k] / size;
    return 1;
}

/* Torsion: a torque about the normal of at most mu 3 pi / 16 times the radius of the patch times the normal force. */
static void add_torsion(const double *a, const double *b, contact *point)
{
    double lever = larger(a[SURFACE_PATCH_RADIUS], b[SURFACE_PATCH_RADIUS]), bend = 0.0;
    if (a[SURFACE_BY_PATCH] == 0.0 || b[SURFACE_BY_PATCH] == 0.0) {
        if (a[SURFACE_RADIUS] > 0.0)
            bend = bend + 1.0 / a[SURFACE_RADIUS];
        if (b[SURFACE_RADIUS] > 0.0)
            bend = bend + 1.0 / b[SURFACE_RADIUS];
        lever = bend > 0.0 && point->geom.depth > 0.0 ? sqrt(point->geom.depth / bend) : 0.0;
    }
    if (!(lever > 0.0))
        return;
    lever = PATCH_LEVER * lever * smaller(a[SURFACE_TORSION], b[SURFACE_TORSION]);
    if (!(lever > 0.0))
        return;
    point->surface.mode |= ROLLING | APPROX1_N;
    point->surface.rho = point->surface.rho2 = -1.0; /* 0 would cost rows of the solver */
    point->surface.rhoN = lever;
}

/* What classic adds to one contact point: slip, a direction of friction, torsion, a slack depth, a bound on how fast a
 * penetration is pushed out. */
static void refine_point(const context *c, const double *a, const double *b, void *geom1, void *geom2, int count,
                         contact *point)
{
    surface_parameters *s = &point->surface;
    double limit = larger(a[SURFACE_MAX_VEL], b[SURFACE_MAX_VEL]);
    s->slip1 = (a[SURFACE_SLIP1] + b[SURFACE_SLIP1]) * count;
    s->slip2 = (a[SURFACE_SLIP2] + b[SURFACE_SLIP2]) * count;
    if (s->slip1 > 0.0)
        s->mode |= SLIP1;
    if (s->slip2 > 0.0)
        s->mode |= SLIP2;
    if (friction_direction(a, b, geom1, geom2, point) || (c->cone && sliding_direction(c, geom1, geom2, point)))
        s->mode |= FDIR1;
    add_torsion(a, b, point);
    point->geom.depth = larger(0.0, point->geom.depth - larger(a[SURFACE_MIN_DEPTH], b[SURFACE_MIN_DEPTH]));
    if (point->geom.depth > 0.0)
        s->soft_erp = smaller(s->soft_erp, limit * c->step / point->geom.depth);
}

/* Keep the `most` deepest of `count` contacts, in their order. */
static int deepest(contact *points, int count, int most)
{
    while (count > most) {
        int shallow = 0, i;
        for (i = 1; i < count; i++)
            if (points[i].geom.depth < points[shallow].geom.depth)
                shallow = i;
        for (i = shallow; i + 1 < count; i++)
            points[i] = points[i + 1];
        count--;
    }
    return count;
}

/* Note a contact point; its joint may be NULL. Without memory it goes unnoted. */
static void record_point(context *c, const contact *point, void *geom1, void *geom2, void *joint)
{
    contact_record *r;
    if (c->record_count == c->record_room) {
        int64_t room = c->record_room ? 2 * c->record_room : 64;
        contact_record *records = realloc(c->records, (size_t)room * sizeof(contact_record));
        pending_contact *pending;
        if (!records)
            return;
        c->records = records;
        pending = realloc(c->pending, (size_t)room * sizeof(pending_contact));
        if (!pending)
            return;
        c->pending = pending;
        c->record_room = room;
    }
    r = c->records + c->record_count;
    memset(r, 0, sizeof *r);
    r->geom1 = (intptr_t)dGeomGetData(geom1);
    r->geom2 = (intptr_t)dGeomGetData(geom2);
    memcpy(r->position, point->geom.pos, sizeof r->position);
    memcpy(r->normal, point->geom.normal, sizeof r->normal);
    r->depth = point->geom.depth;
    c->pending[c->record_count].joint = joint;
    c->pending[c->record_count].reversed = !dGeomGetBody(geom1);
    c->record_count++;
}

/* Whether a pair of geoms touches under the classic rule; *ghost: only so that it is known. */
static int may_touch(const context *c, const double *a, const double *b, void *body1, void *body2, int *ghost)
{
    if (!((uint32_t)a[SURFACE_BITS] & (uint32_t)b[SURFACE_BITS]))
        return 0;
    *ghost = a[SURFACE_GHOST] != 0.0 || b[SURFACE_GHOST] != 0.0;
    if (*ghost)
        return c->record && ((uint32_t)a[SURFACE_GHOST_BITS] & (uint32_t)b[SURFACE_GHOST_BITS]);
    if (c->record)
        return 1;
    return (body1 && dBodyIsEnabled(body1)) || (body2 && dBodyIsEnabled(body2)); /* both asleep: nothing to do */
}

static void collide_geoms(context *c, void *geom1, void *geom2)
{
    contact points[MOST_CONTACTS];
    surface_parameters surface;
    const double *a, *b;
    void *body1 = dGeomGetBody(geom1), *body2 = dGeomGetBody(geom2), *joint = NULL;
    int most = c->contact_rule == CLASSIC_RULE ? MOST_CONTACTS : MAX_CONTACTS, count, i, class1, class2, ghost = 0;

    if (!body1 && !body2)
        return;
    if (body1 && body2 && dAreConnectedExcluding(body1, body2, JOINT_CONTACT))
        return;
    a = c->surface + SURFACE_COLUMNS * (intptr_t)dGeomGetData(geom1);
    b = c->surface + SURFACE_COLUMNS * (intptr_t)dGeomGetData(geom2);
    if (c->contact_rule == CLASSIC_RULE && !may_touch(c, a, b, body1, body2, &ghost))
        return;
    class1 = dGeomGetClass(geom1);
    class2 = dGeomGetClass(geom2);
    if (c->no_cylinder_pairs && ((class1 == CYLINDER_CLASS && (class2 == CYLINDER_CLASS || class2 == CAPSULE_CLASS)) ||
                                 (class1 == CAPSULE_CLASS && class2 == CYLINDER_CLASS)))
        count = collide_cylinder(c, geom1, geom2, class2, points);
    else
        count = collide_pair(c, geom1, geom2, most, &points[0].geom, sizeof(contact));
    if (!count)
        return;
    make_surface(c, a, b, &surface);
    if (c->contact_rule == CLASSIC_RULE)
        count = deepest(points, count,
                        (int)smaller(smaller(a[SURFACE_MAX_CONTACTS], b[SURFACE_MAX_CONTACTS]), (double)c->max_contacts));
    for (i = 0; i < count; i++) {
        double depth = points[i].geom.depth;
        points[i].surface = surface;
        if (c->contact_rule == CLASSIC_RULE)
            refine_point(c, a, b, geom1, geom2, count, &points[i]);
        if (!ghost) {
            joint = dJointCreateContact(c->world, c->contacts, &points[i]);
            dJointAttach(joint, body1, body2);
            c->contact_count++;
        }
        if (c->record) {
            points[i].geom.depth = depth;
            record_point(c, &points[i], geom1, geom2, joint);
        }
    }
}

static void collide(void *data, void *geom1, void *geom2)
{
    if (dGeomIsSpace(geom1) || dGeomIsSpace(geom2))
        dSpaceCollide2(geom1, geom2, data, collide);
    else
        collide_geoms(data, geom1, geom2);
}

/* v rotated by the quaternion q; the same operations in the same order as libgz.geometry.rotate. */
static void rotate(const double *q, const double *v, double *out)
{
    double tx = 2.0 * (q[2] * v[2] - q[3] * v[1]);
    double ty = 2.0 * (q[3] * v[0] - q[1] * v[2]);
    double tz = 2.0 * (q[1] * v[1] - q[2] * v[0]);
    out[0] = v[0] + q[0] * tx + (q[2] * tz - q[3] * ty);
    out[1] = v[1] + q[0] * ty + (q[3] * tx - q[1] * tz);
    out[2] = v[2] + q[0] * tz + (q[1] * ty - q[2] * tx);
}

/* Whether a number ran away: it is beyond twice what may be set (check.py), or none at all. */
static int is_lost(double value, double most)
{
    return !(value >= -most && value <= most);
}

static void read_bodies(context *c)
{
    int64_t i;
    int k;
    c->lost = 0;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        double *row = c->body_state + 16 * i;
        const double *p, *q, *v, *w;
        double offset[3];
        int lost = 0;
        if (!body)
            continue;
        p = dBodyGetPosition(body);
        q = dBodyGetQuaternion(body);
        v = dBodyGetLinearVel(body);
        w = dBodyGetAngularVel(body);
        rotate(q, c->com + 3 * i, offset);
        for (k = 0; k < 3; k++) {
            row[k] = p[k] - offset[k];
            row[7 + k] = p[k];
            row[10 + k] = v[k];
            row[13 + k] = w[k];
            lost |= is_lost(p[k], c->farthest) | is_lost(v[k], LOST_SPEED) | is_lost(w[k], LOST_SPEED);
        }
        for (k = 0; k < 4; k++)
            row[3 + k] = q[k];
        c->lost += lost;
    }
}

/* What bodies do, and what is done to them, as a step begins. */
static void watch_bodies(context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        double *row = c->body_start + 12 * i;
        if (!body)
            continue;
        memcpy(row, dBodyGetLinearVel(body), 3 * sizeof(double));
        memcpy(row + 3, dBodyGetAngularVel(body), 3 * sizeof(double));
        memcpy(row + 6, dBodyGetForce(body), 3 * sizeof(double));
        memcpy(row + 9, dBodyGetTorque(body), 3 * sizeof(double));
    }
}

/* The angle that is nearest to the one before, so that joints count their turns. ODE's lies in -pi to pi. */
static double unwind(const context *c, double before, double angle)
{
    double turns = (before - angle) / TURN;
    return c->count_turns && isfinite(turns) ? angle + TURN * rint(turns) : angle;
}

/* Springs and dampers of hinges and sliders push for the coming step. */
static void push_joints(context *c)
{
    int64_t i;
    for (i = 0; i < c->joint_count; i++) {
        void *joint = c->joints[i];
        const double *s = c->springs + 3 * i;
        double at;
        if (!joint || (s[0] == 0.0 && s[1] == 0.0))
            continue;
        if (c->joint_types[i] == JOINT_HINGE) {
            at = unwind(c, c->joint_state[4 * i], dJointGetHingeAngle(joint));
            dJointAddHingeTorque(joint, s[0] * (s[2] - at) - s[1] * dJointGetHingeAngleRate(joint));
        } else if (c->joint_types[i] == JOINT_SLIDER) {
            at = dJointGetSliderPosition(joint);
            dJointAddSliderForce(joint, s[0] * (s[2] - at) - s[1] * dJointGetSliderPositionRate(joint));
        }
    }
}

static void read_joints(context *c)
{
    int64_t i;
    for (i = 0; i < c->joint_count; i++) {
        void *joint = c->joints[i];
        double *row = c->joint_state + 4 * i;
        if (!joint)
            continue;
        switch (c->joint_types[i]) {
        case JOINT_HINGE:
            row[0] = unwind(c, row[0], dJointGetHingeAngle(joint));
            row[2] = dJointGetHingeAngleRate(joint);
            break;
        case JOINT_SLIDER:
            row[0] = dJointGetSliderPosition(joint);
            row[2] = dJointGetSliderPositionRate(joint);
            break;
        case JOINT_HINGE2:
            row[0] = unwind(c, row[0], dJointGetHinge2Angle1(joint));
            row[1] = unwind(c, row[1], dJointGetHinge2Angle2(joint));
            row[2] = dJointGetHinge2Angle1Rate(joint);
            row[3] = dJointGetHinge2Angle2Rate(joint);
            break;
        case JOINT_UNIVERSAL:
            row[0] = unwind(c, row[0], dJointGetUniversalAngle1(joint));
            row[1] = unwind(c, row[1], dJointGetUniversalAngle2(joint));
            row[2] = dJointGetUniversalAngle1Rate(joint);
            row[3] = dJointGetUniversalAngle2Rate(joint);
            break;
        case JOINT_PISTON:
            row[0] = unwind(c, row[0], dJointGetPistonAngle(joint));
            row[1] = dJointGetPistonPosition(joint);
            row[2] = dJointGetPistonAngleRate(joint);
            row[3] = dJointGetPistonPositionRate(joint);
            break;
        }
    }
}

/* The first half of a step: find contacts and make joints of them. */
static void find_contacts(context *c)
{
    c->contact_count = c->record_count = 0;
    dSpaceCollide(c->space, c, collide);
}

/* Ask ODE for the forces of the recorded contacts of this step. */
static void ask_contacts(context *c)
{
    int64_t i;
    for (i = 0; i < c->record_count; i++) {
        pending_contact *p = c->pending + i;
        memset(&p->told, 0, sizeof p->told);
        if (p->joint)
            dJointSetFeedback(p->joint, &p->told);
    }
}

/* Take the answers over; ODE's first body is never missing, its second may be, and then it tells nothing of it. */
static void read_contacts(context *c)
{
    int64_t i;
    for (i = 0; i < c->record_count; i++) {
        pending_contact *p = c->pending + i;
        contact_record *r = c->records + i;
        if (!p->joint)
            continue;
        memcpy(p->reversed ? r->force2 : r->force1, p->told.f1, sizeof r->force1);
        memcpy(p->reversed ? r->torque2 : r->torque1, p->told.t1, sizeof r->torque1);
        if (!p->reversed) {
            memcpy(r->force2, p->told.f2, sizeof r->force2);
            memcpy(r->torque2, p->told.t2, sizeof r->torque2);
        }
        p->joint = NULL;
    }
}

/* Give the memory of the records back. */
void gz_forget_contacts(context *c)
{
    free(c->records);
    free(c->pending);
    c->records = NULL;
    c->pending = NULL;
    c->record_count = c->record_room = 0;
}

static int is_within(const double *v, double most)
{
    return fabs(v[0]) <= most && fabs(v[1]) <= most && fabs(v[2]) <= most;
}

/* Halt bodies that run away: ODE ends the process on numbers that are none. */
static void halt_runaways(context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        if (!body || (is_within(dBodyGetLinearVel(body), FASTEST) && is_within(dBodyGetAngularVel(body), FASTEST) &&
                      is_within(dBodyGetForce(body), STRONGEST) && is_within(dBodyGetTorque(body), STRONGEST)))
            continue;
        dBodySetLinearVel(body, 0.0, 0.0, 0.0);
        dBodySetAngularVel(body, 0.0, 0.0, 0.0);
        dBodySetForce(body, 0.0, 0.0, 0.0);
        dBodySetTorque(body, 0.0, 0.0, 0.0);
        c->halted = i + 1;
    }
}

/* A step that is given up loses sight of the memory it works in. So from the first such step on a world keeps none from
 * one step to the next: what is still there when a step is over was lost, and is given back here. */
enum { MOST_BLOCKS = 64 };
static __thread void *blocks[MOST_BLOCKS];
static __thread int block_count;

static void *get_block(size_t size)
{
    void *block = malloc(size);
    if (block && block_count < MOST_BLOCKS)
        blocks[block_count++] = block;
    return block;
}

static void *shrink_block(void *block, size_t size, size_t smaller)
{
    (void)size;
    (void)smaller;
    return block;
}

static void drop_block(void *block, size_t size)
{
    int i;
    (void)size;
    for (i = 0; i < block_count; i++)
        if (blocks[i] == block)
            blocks[i] = blocks[--block_count];
    free(block);
}

static void give_memory_back(context *c)
{
    static const memory_functions own = {sizeof own, get_block, shrink_block, drop_block};
    dWorldCleanupWorkingMemory(c->world);
    while (block_count > 0)
        free(blocks[--block_count]);
    if (!c->careful)
        dWorldSetStepMemoryManager(c->world, &own);
    c->careful = 1;
}

enum { NOT_ALL_WELL = 2 };

/* The second half: move everything, drop the contacts, copy the states out. Returns 1, 0 when ODE ran out of memory, or
 * NOT_ALL_WELL: what happened stands in the context. */
static int solve(context *c)
{
    volatile int done = 1; /* as it stays when the step is given up */
    dRandSetSeed((unsigned long)c->seed);
    ask_contacts(c);
    push_joints(c);
    c->halted = 0;
    halt_runaways(c);
    if (c->watch)
        watch_bodies(c);
    c->gave_up = 0;
    guarded = 1;
    if (SET_JUMP(given_up))
        c->gave_up = 1;
    else
        done = c->quick ? dWorldQuickStep(c->world, c->step) : dWorldStep(c->world, c->step);
    guarded = 0;
    if (c->gave_up || c->careful)
        give_memory_back(c);
    read_contacts(c);
    dJointGroupEmpty(c->contacts);
    c->seed = dRandGetSeed();
    c->steps++;
    read_bodies(c);
    read_joints(c);
    if (done && (c->halted || c->gave_up || c->lost || c->baffled))
        return NOT_ALL_WELL;
    return done != 0;
}

/* ODE's solver and mesh colliders keep memory that all worlds of a process share, and ctypes lets other threads run
 * while these are called: one of them at a time. */
static pthread_mutex_t in_ode = PTHREAD_MUTEX_INITIALIZER;

/* A child must not wait for a thread that it does not have. */
static void free_in_child(void)
{
    pthread_mutex_init(&in_ode, NULL);
}

static void enter_ode(void)
{
    static int told;
    pthread_mutex_lock(&in_ode);
    if (!told)
        told = !pthread_atfork(NULL, NULL, free_in_child);
}

void gz_collide(context *c)
{
    enter_ode();
    find_contacts(c);
    pthread_mutex_unlock(&in_ode);
}

int gz_solve(context *c)
{
    int done;
    enter_ode();
    done = solve(c);
    pthread_mutex_unlock(&in_ode);
    return done;
}

int gz_step(context *c)
{
    int done;
    enter_ode();
    find_contacts(c);
    done = solve(c);
    pthread_mutex_unlock(&in_ode);
    return done;
}

void gz_read(context *c)
{
    read_bodies(c);
    read_joints(c);
}

/* Ray scans -------------------------------------------------------------------------------------------------- */

typedef struct {
    void *geom;
    double box[6]; /* its bounding box: x min, x max, y min, ... */
} candidate;

typedef struct {
    const context *c;
    int64_t owner;
    candidate *list;
    int64_t count, room;
} gathering;

static void gather(void *data, void *geom1, void *geom2)
{
    gathering *g = data;
    void *geom = geom1 == g->c->probe ? geom2 : geom1;
    if (dGeomIsSpace(geom)) {
        dSpaceCollide2(g->c->probe, geom, g, gather);
        return;
    }
    if (g->owner && g->c->owner[(intptr_t)dGeomGetData(geom)] == g->owner)
        return;
    if (g->count == g->room) {
        int64_t room = g->room ? 2 * g->room : 64;
        candidate *list = realloc(g->list, (size_t)room * sizeof(candidate));
        if (!list)
            return;
        g->list = list;
        g->room = room;
    }
    g->list[g->count].geom = geom;
    dGeomGetAABB(geom, g->list[g->count].box);
    g->count++;
}

/* Whether the segment start + t dir, 0 <= t <= length, meets the box grown by a hair (the slab method). */
static int may_hit(const double *start, const double *dir, double length, const double *box)
{
    double from = 0.0, to = length;
    int k;
    for (k = 0; k < 3; k++) {
        double low = box[2 * k] - 1e-9 - start[k], high = box[2 * k + 1] + 1e-9 - start[k];
        if (dir[k] > -1e-12 && dir[k] < 1e-12) {
            if (low > 0.0 || high < 0.0)
                return 0;
        } else {
            double a = low / dir[k], b = high / dir[k];
            if (a > b) {
                double swap = a;
                a = b;
                b = swap;
            }
            if (a - 1e-9 > from)
                from = a - 1e-9;
            if (b + 1e-9 < to)
                to = b + 1e-9;
            if (from > to)
                return 0;
        }
    }
    return 1;
}

/* Cast `count` rays, each 7 doubles in the sensor's frame: start, unit direction, length.
 * `frame` is that frame: position and quaternion. Geoms of the body numbered `owner` are not seen (0: all are).
 * Out: for each ray the distance from its start, DBL_MAX if nothing was hit, and the geom's row, or -1. */
static void scan(context *c, const double *frame, const double *rays, int64_t count, int64_t owner, double *ranges,
                 int64_t *rows)
{
    gathering g = {c, owner, NULL, 0, 0};
    double *world_rays = malloc((size_t)(count > 0 ? count : 1) * 6 * sizeof(double));
    double low[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    int64_t i, j;
    int k;

    for (i = 0; i < count; i++) {
        ranges[i] = DBL_MAX;
        rows[i] = -1;
    }
    if (!world_rays || count <= 0) {
        free(world_rays);
        return;
    }
    for (i = 0; i < count; i++) {
        double *start = world_rays + 6 * i, *dir = start + 3;
        rotate(frame + 3, rays + 7 * i, start);
        rotate(frame + 3, rays + 7 * i + 3, dir);
        for (k = 0; k < 3; k++) {
            double a, b;
            start[k] += frame[k];
            a = start[k];
            b = a + rays[7 * i + 6] * dir[k];
            if (a > b) {
                double swap = a;
                a = b;
                b = swap;
            }
            if (a < low[k])
                low[k] = a;
            if (b > high[k])
                high[k] = b;
        }
    }
    dGeomBoxSetLengths(c->probe, high[0] - low[0] + 1e-6, high[1] - low[1] + 1e-6, high[2] - low[2] + 1e-6);
    dGeomSetPosition(c->probe, 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]));
    dSpaceCollide2(c->probe, c->space, &g, gather);

    for (i = 0; i < count; i++) {
        const double *start = world_rays + 6 * i, *dir = start + 3;
        double length = rays[7 * i + 6];
        int set = 0;
        for (j = 0; j < g.count; j++) {
            contact_geom hit;
            if (!may_hit(start, dir, length, g.list[j].box))
                continue;
            if (!set) {
                dGeomRaySetLength(c->ray, length);
                dGeomRaySet(c->ray, start[0], start[1], start[2], dir[0], dir[1], dir[2]);
                set = 1;
            }
            if (collide_pair(c, c->ray, g.list[j].geom, 1, &hit, sizeof hit) && hit.depth < ranges[i]) {
                ranges[i] = hit.depth;
                rows[i] = (int64_t)(intptr_t)dGeomGetData(g.list[j].geom);
            }
        }
    }
    free(g.list);
    free(world_rays);
}

void gz_scan(context *c, const double *frame, const double *rays, int64_t count, int64_t owner, double *ranges,
             int64_t *rows)
{
    enter_ode();
    scan(c, frame, rays, count, owner, ranges, rows);
    pthread_mutex_unlock(&in_ode);
}
