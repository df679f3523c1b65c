/* The native step: contacts, the ODE step, the copy of all states, and ray scans, without a Python call inside.
 *
 * It is not linked with ODE. gz_step_needs() lists the ODE functions it calls, gz_step_bind() takes their addresses in
 * that order; so it builds without ODE's headers and always uses the ODE library that is loaded.
 * tests/ode/recorded.json holds motions that it repeats to the last bit.
 */
#include "calls.h"
#include "memory.h"
#include "resting.h"

#include <float.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
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
    double mass, c[4], inertia[12];
} body_mass;

typedef struct {
    surface_parameters surface;
    contact_geom geom;
    double fdir1[4];
} contact;

/* What a joint did to its bodies in a step. */
typedef struct {
    double f1[4], t1[4], f2[4], t2[4];
} feedback;

/* The allocator of the memory that a world uses during a step. */
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
    X(void, dGeomSetData, (void *, void *))                                     \
    X(void, dGeomSetBody, (void *, void *))                                     \
    X(void *, dGeomGetSpace, (void *))                                          \
    X(int, dGeomIsOffset, (void *))                                             \
    X(const double *, dGeomGetOffsetPosition, (void *))                         \
    X(void, dGeomSetOffsetPosition, (void *, double, double, double))           \
    X(int, dSpaceGetNumGeoms, (void *))                                         \
    X(void *, dSpaceGetGeom, (void *, int))                                     \
    X(void, dSpaceAdd, (void *, void *))                                        \
    X(void, dSpaceRemove, (void *, void *))                                     \
    X(void, dSpaceClean, (void *))                                              \
    X(void *, dBodyGetFirstGeom, (void *))                                      \
    X(void *, dBodyGetNextGeom, (void *))                                       \
    X(int, dJointGetType, (void *))                                             \
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
    X(void *, dJointGetBody, (void *, int))                                     \
    X(void, dBodyGetMass, (void *, body_mass *))                                \
    X(void *, dBodyGetData, (void *))                                           \
    X(void, dBodySetData, (void *, void *))                                     \
    X(void, dBodyEnable, (void *))                                              \
    X(void, dBodyDisable, (void *))                                             \
    X(int, dBodyGetAutoDisableFlag, (void *))                                   \
    X(void, dBodySetAutoDisableFlag, (void *, int))                             \
    X(int, dBodyGetAutoDisableSteps, (void *))                                  \
    X(void, dBodySetAutoDisableSteps, (void *, int))                            \
    X(double, dBodyGetAutoDisableTime, (void *))                                \
    X(void, dBodySetAutoDisableTime, (void *, double))                          \
    X(void, dWorldCleanupWorkingMemory, (void *))                               \
    X(int, dWorldSetStepMemoryManager, (void *, const memory_functions *))      \
    X(void, dWorldSetStepThreadingImplementation, (void *, const call_functions *, void *)) \
    X(void, dRandSetSeed, (unsigned long))                                      \
    X(unsigned long, dRandGetSeed, (void))                                      \
    X(message_handler *, dGetDebugHandler, (void))                              \
    X(void, dSetDebugHandler, (message_handler *))                              \
    X(double, dWorldGetCFM, (void *))                                           \
    X(double, dWorldGetContactMaxCorrectingVel, (void *))                       \
    X(void, dJointDisable, (void *))                                            \
    X(const double *, dBodyGetRotation, (void *))                               \
    X(const double *, dBodyGetPosition, (void *))                               \
    X(const double *, dBodyGetQuaternion, (void *))                             \
    X(const double *, dBodyGetLinearVel, (void *))                              \
    X(const double *, dBodyGetAngularVel, (void *))                             \
    X(const double *, dBodyGetForce, (void *))                                  \
    X(void, dBodySetPosition, (void *, double, double, double))                 \
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

/* A failed assertion in ODE would end the process. While a step is being solved, it means that numbers diverged: the
 * step is abandoned, and the caller (Engine) recovers the bodies. During collision detection, the pair of geoms is
 * skipped. */
/* GCC's builtin saves three words where the library's setjmp saves all registers; it runs for each pair of geoms. */
#ifdef __GNUC__
typedef void *jump[5];
#define SET_JUMP(place) __builtin_setjmp(place)
#define JUMP_BACK(place) __builtin_longjmp(place, 1)
#else
typedef jmp_buf jump;
#define SET_JUMP(place) setjmp(place)
#define JUMP_BACK(place) longjmp(place, 1)
#endif
static __thread jump escape;
static __thread int guarded;
static message_handler *other_handler;

static void on_failed_assertion(int number, const char *text, va_list arguments)
{
    if (guarded)
        JUMP_BACK(escape);
    if (other_handler)
        other_handler(number, text, arguments);
}

/* Only solve() has ODE post calls. */
void gz_abandon_step(void) { JUMP_BACK(escape); }

void gz_step_bind(void *const *addresses)
{
#define BIND(result, name, arguments) *(void **)&name = *addresses++;
    ODE_FUNCTIONS(BIND)
    other_handler = dGetDebugHandler();
    dSetDebugHandler(on_failed_assertion);
}

/* Have ODE queue the calls of this world's steps in calls.c. */
void gz_use_calls(void *world) { dWorldSetStepThreadingImplementation(world, &gz_call_functions, &gz_calls); }

/* One contact point of a step, as it is reported; the same as CONTACT in context.py. */
typedef struct {
    int64_t geom1, geom2; /* rows */
    double position[3], normal[3], depth;
    double force1[3], torque1[3], force2[3], torque2[3];
} contact_record;

/* The joint of a recorded contact until it is solved: NULL for the contact of a ghost, which has no joint. */
typedef struct {
    feedback result;
    void *joint;
    int64_t reversed; /* ODE's first body is that of the second geom */
} pending_contact;

/* Bodies that touch in a step, by row, and in how many points; body2 is -1 where the world is touched. */
typedef struct {
    int64_t body1, body2, count;
    int64_t first; /* of its points */
    int64_t next;  /* of the same island, or -1 */
} touch_record;

/* A contact of such bodies. */
typedef struct {
    contact point;
    void *joint;
    int64_t record; /* or -1 */
} touch_point;

/* A contact point that may not push its bodies apart as fast as it should; one of them may be NULL, the world. */
typedef struct {
    void *body1, *body2;
    double normal[3]; /* into body1 */
    double depth;     /* [m] by which they are set apart */
    double softness;  /* [m/N] */
    double share;     /* of the shift, found by iteration */
} overlap_record;

/* Mirrored by StepContext in context.py; gz_step_context_size() guards against drift. */
typedef struct {
    void *world, *space, *contacts, *ray, *probe, *stand_in;
    int64_t no_cylinder_pairs; /* 1: boxes stand in for a cylinder against cylinders and capsules */
    double step;
    int64_t quick;            /* 1: dWorldQuickStep */
    int64_t contact_rule;     /* LEGACY_RULE or CLASSIC_RULE */
    int64_t count_turns;      /* 1: joint angles continue beyond pi; 0: they stay within -pi to pi */
    uint64_t seed;            /* ODE's random state, one per world */
    int64_t steps;            /* so far */
    int64_t contact_count;    /* of the last step */
    int64_t max_contacts;     /* of a pair of geoms, under the classic rule */
    int64_t cone;             /* 1: under the classic rule friction acts against the motion, as in a cone */
    double gravity[3];        /* from which the cone predicts velocities */
    int64_t record_contacts;  /* 1: contact points are recorded */
    int64_t record_count, record_capacity;
    contact_record *records;
    pending_contact *pending; /* one for each record */
    const double *surface;    /* SURFACE_COLUMNS a geom, see below */
    const int64_t *owner;     /* a number a geom: that of its body */
    int64_t body_count;
    void *const *bodies;      /* NULL: a free row */
    const double *com;        /* centre of mass in the body frame, 3 a row */
    double *body_state;       /* 16 a row: position, quaternion, centre of mass, linear and angular velocity */
    int64_t record_motion;    /* 1: body_motion is filled */
    double *body_motion;      /* 13 a row, of the last step: linear and angular acceleration, applied force and torque,
                                 1 if gravity acted */
    int64_t joint_count;
    void *const *joints;
    const int64_t *joint_types;
    double *joint_state;      /* 4 a row: angle 1 and 2, rate 1 and 2 */
    const double *springs;    /* 3 a row, for hinges and sliders: stiffness, damping, reference */
    int64_t reset_row;        /* 1 + the row of a body that diverged and whose velocity was reset; 0: none */
    int64_t abandoned;        /* 1: the last step was abandoned */
    double max_distance;      /* [m] from the origin; bodies beyond have diverged */
    int64_t own_memory;       /* 1: a step was abandoned before, and no memory is kept from one step to the next */
    int64_t diverged;         /* number of bodies that diverged in the last step */
    int64_t collision_failed; /* 1: an assertion failed in the collision detection of a pair, or of a ray with a geom */
    int64_t failed_rows[2];   /* rows of the geoms of the last such pair; -1: a ray */
    int64_t exact_rest;       /* 1: under the classic rule contacts keep a depth, and calm islands are solved exactly */
    int64_t touch_count, touch_capacity;
    touch_record *touches;    /* of this step, where the quick solver needs them */
    int64_t overlap_count, overlap_capacity;
    overlap_record *overlaps; /* of this step */
    int64_t parted;           /* 1: some bodies are set aside, while others are solved */
    double surface_layer;     /* [m] of depth that is not corrected under the classic rule */
    int64_t resting;          /* steps in a row, at most 2, after which no body was awake; 0 after any change from outside */
    int64_t next_checked;     /* body that is looked at next while all rest */
    int64_t point_count, point_capacity;
    touch_point *points;      /* of the touches */
    int64_t earlier_count, earlier_capacity;
    contact_record *earlier;  /* the records of the step before */
} context;

enum { LEGACY_RULE = 0, CLASSIC_RULE = 1 };

size_t gz_step_context_size(void) { return sizeof(context); }

enum { MAX_CONTACTS = 10, MOST_CONTACTS = 250 }; /* of a pair: legacy; those of which classic keeps the deepest */
enum { JOINT_HINGE = 2, JOINT_SLIDER = 3, JOINT_CONTACT = 4, JOINT_UNIVERSAL = 5, JOINT_HINGE2 = 6 };
enum { JOINT_PISTON = 14 };
enum { CAPSULE_CLASS = 2, CYLINDER_CLASS = 3, PLANE_CLASS = 4, RAY_CLASS = 5, HEIGHTFIELD_CLASS = 9 };
enum { MU2 = 0x001, FDIR1 = 0x002, BOUNCE = 0x004, SOFT_ERP = 0x008, SOFT_CFM = 0x010, SLIP1 = 0x100, SLIP2 = 0x200 };
enum { MOTION1 = 0x020, MOTION_N = 0x080, ROLLING = 0x400, APPROX1 = 0x3000, APPROX1_N = 0x4000 };
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
    SURFACE_GHOST,      /* 1: contact points are recorded, without joints */
    SURFACE_GHOST_BITS, /* a pair with a ghost and without a common bit of these has no points */
    SURFACE_TORSION,
    SURFACE_BY_PATCH, /* 1: torsion depends on the patch radius, 0: on the surface radius and depth */
    SURFACE_PATCH_RADIUS,
    SURFACE_RADIUS,
    SURFACE_COMPLIANCE, /* [1/Pa] (1 - nu^2) / E; 0: not elastic */
    SURFACE_CURVATURE,  /* [1/m] of its shape; 0: flat */
    SURFACE_TRACK,       /* 1: the surface runs round the axis fdir1; 2: and what it carries turns about a pivot */
    SURFACE_TRACK_SPEED, /* [m/s] at which it runs, by the right-hand rule */
    SURFACE_PIVOT,       /* global; three columns */
    SURFACE_COLUMNS = SURFACE_PIVOT + 3
};
/* A body beyond these has diverged. */
#define MAX_SPEED 1e7      /* [m/s] and [rad/s], before a step */
#define MAX_EFFORT 1e12    /* [N] and [N m], before a step */
#define DIVERGED_SPEED 2e9 /* [m/s] and [rad/s], after a step */
#define SOFT_RATIO 0.25 /* of step^2 kp / mass, up to which a spring is soft: its oscillation takes 12 steps or more */
#define REST_DEPTH 3e-6 /* [m] that rigid contacts keep, so that none is lost from one step to the next */
#define REST_ERP 0.2    /* share of the difference to it that is corrected in a step, at most */
#define REST_CFM 1e-7   /* softness of rigid contacts [s/kg], at least, for a body of 1 kg */
#define SOFTNESS_SPREAD 0.3 /* share by which the softness of rigid contacts differs from place to place */
#define DEPTH_SPREAD 0.05   /* share of REST_DEPTH, per second of a step, by which the depth differs that they keep */
#define CALM_SPEED 0.1    /* [m/s] and [rad/s] of a body, up to which its island may be solved exactly */
#define FALLING_STEPS 2.0 /* and so many steps of falling add to it */
#define FLANK 0.70710678118654752 /* sine of the angle from which ODE takes a normal as upright */
#define STICKING 40.0 /* [m/s^2] at which friction of 1 may stop what touches within one step, so that it sticks */
#define LARGE 1e6         /* [m] beyond which what lies in a hash space counts as infinite */
enum { SMALL_LEVEL = -2, LARGE_LEVEL = 9 }; /* of Gazebo's hash space; the large are in no cell */
#define TURN 6.2831853071795862 /* 2 pi */
#define PATCH_LEVER 0.58904862254808621 /* 3 pi / 16: mean lever of friction in a patch under Hertz's pressure */

static double smaller(double a, double b) { return a < b ? a : b; }
static double larger(double a, double b) { return a > b ? a : b; }

/* A contact is a spring and damper in series with its partner: erp = h kp / (h kp + kd), cfm = 1 / (h kp + kd). */
static void make_surface(const context *c, const double *a, const double *b, surface_parameters *s)
{
    double softness = 1.0 / a[SURFACE_KP] + 1.0 / b[SURFACE_KP];
    double kd = a[SURFACE_KD] + b[SURFACE_KD];
    memset(s, 0, sizeof *s);
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

static void cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* A vector in the frame of a geom or body, as a global one. */
static void to_global(const double *rotation, const double *local, double *global)
{
    int k;
    for (k = 0; k < 3; k++)
        global[k] = rotation[4 * k] * local[0] + rotation[4 * k + 1] * local[1] + rotation[4 * k + 2] * local[2];
}

/* dCollide; no contacts, instead of the end of the process, if an assertion fails in it. */
static int collide_pair(context *c, void *geom1, void *geom2, int most, contact_geom *points, int skip)
{
    void *geoms[2] = {geom1, geom2};
    double position[2][4], rotation[2][12];
    int class1 = dGeomGetClass(geom1), class2 = dGeomGetClass(geom2), count, k;
    int moved = (class1 == HEIGHTFIELD_CLASS && class2 != PLANE_CLASS) ||
                (class2 == HEIGHTFIELD_CLASS && class1 != PLANE_CLASS);

    /* ODE moves a geom that collides with a height field into the field's frame, and back afterwards. */
    for (k = 0; moved && k < 2; k++) {
        memcpy(position[k], dGeomGetPosition(geoms[k]), sizeof position[k]);
        memcpy(rotation[k], dGeomGetRotation(geoms[k]), sizeof rotation[k]);
    }
    guarded = 1;
    if (SET_JUMP(escape)) {
        guarded = 0;
        for (k = 0; moved && k < 2; k++) {
            memcpy((double *)dGeomGetPosition(geoms[k]), position[k], sizeof position[k]);
            memcpy((double *)dGeomGetRotation(geoms[k]), rotation[k], sizeof rotation[k]);
        }
        c->collision_failed = 1;
        for (k = 0; k < 2; k++)
            c->failed_rows[k] = dGeomGetClass(geoms[k]) == RAY_CLASS ? -1 : (int64_t)(intptr_t)dGeomGetData(geoms[k]);
        return 0;
    }
    count = dCollide(geom1, geom2, most, points, skip);
    guarded = 0;
    return count;
}

/* Place the stand-in at a cylinder: a box `radial` long towards the other's axis, `tangential` across it. */
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

/* Contacts of a cylinder with a cylinder or capsule, which ODE lacks without libccd. The cylinder is approximated by
 * two boxes inside it: a strip that points at the other's axis, so that sides touch at the true radius, and the square
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
    /* The point of the other axis that is nearest to this axis, perpendicular to it. */
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
    cross(axis, aim, side);

    place_stand_in(c->stand_in, p, aim, side, axis, radius, 0.2 * radius, length);
    geom1 = cylinder == geom1 ? c->stand_in : geom1;
    geom2 = cylinder == geom2 ? c->stand_in : geom2;
    count = collide_pair(c, geom1, geom2, MAX_CONTACTS / 2, &points[0].geom, sizeof(contact));
    place_stand_in(c->stand_in, p, aim, side, axis, radius * 0.70710678118654752, radius * 0.70710678118654752, length);
    count += collide_pair(c, geom1, geom2, MAX_CONTACTS / 2, &points[count].geom, sizeof(contact));
    return count;
}

/* Project a direction onto the contact plane and make it that of friction; 0 if nothing remains of it. */
static int set_friction_direction(contact *point, const double *aim)
{
    const double *n = point->geom.normal;
    double along = dot(aim, n), size;
    int k;
    for (k = 0; k < 3; k++)
        point->fdir1[k] = aim[k] - along * n[k];
    size = sqrt(dot(point->fdir1, point->fdir1));
    if (size < 1e-9)
        return 0;
    for (k = 0; k < 3; k++)
        point->fdir1[k] = point->fdir1[k] / size;
    return 1;
}

/* The rotation of a geom; a plane has none in ODE, and its friction direction is global. */
static const double *rotation_of(void *geom)
{
    static const double none[12] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    return dGeomGetClass(geom) == PLANE_CLASS ? none : dGeomGetRotation(geom);
}

/* A pair of geoms that touch under the classic rule. */
typedef struct {
    const double *a, *b; /* their surfaces */
    void *geom1, *geom2, *body1, *body2;
    double max_vel, min_depth;
    double kept; /* depth that is not corrected */
    double withheld; /* depth of a point that would be corrected without max_vel */
    int rigid;   /* 1: the springs stand for rigid surfaces */
    const double *aim; /* direction in which mu applies, in the frame of a geom; NULL: none */
    void *aiming;
} touching;

/* The level of a hash space to which what a link has belongs: its extent is between half of 2^level and 2^level. Of a
 * geom without a body, all that its model has. */
static int level_of(const context *c, void *geom)
{
    double box[6], all[6], extent = 0.0;
    void *body = dGeomGetBody(geom), *space = dGeomGetSpace(geom), *part = NULL;
    int level, k;
    if (dGeomGetClass(geom) == PLANE_CLASS)
        return LARGE_LEVEL;
    dGeomGetAABB(body || !space || space == c->space ? geom : space, all);
    if (body)
        part = dBodyGetFirstGeom(body);
    for (; part; part = dBodyGetNextGeom(part)) {
        dGeomGetAABB(part, box);
        for (k = 0; k < 6; k += 2) {
            all[k] = smaller(all[k], box[k]);
            all[k + 1] = larger(all[k + 1], box[k + 1]);
        }
    }
    for (k = 0; k < 6; k += 2)
        extent = larger(extent, all[k + 1] - all[k]);
    if (!(extent < LARGE))
        return LARGE_LEVEL;
    frexp(extent, &level);
    return level < SMALL_LEVEL ? SMALL_LEVEL : level > LARGE_LEVEL ? LARGE_LEVEL : level;
}

/* Whether Gazebo's hash space finds the second geom of a pair first: the one of the lower level, then what does not
 * move, then what was made last. */
static int second_first(const context *c, void *geom1, void *geom2)
{
    void *body1 = dGeomGetBody(geom1), *body2 = dGeomGetBody(geom2);
    int level1 = level_of(c, geom1), level2 = level_of(c, geom2);
    if (level1 != level2)
        return level2 < level1;
    return !body2 || (body1 && c->owner[(intptr_t)dGeomGetData(geom2)] > c->owner[(intptr_t)dGeomGetData(geom1)]);
}

/* Find whose direction is that in which mu applies: as in Gazebo, that of the geom which its hash space finds first. */
static void choose_direction(const context *c, touching *t)
{
    const double *one = t->a + SURFACE_FDIR1, *two = t->b + SURFACE_FDIR1;
    t->aim = NULL;
    if (dot(one, one) == 0.0 && dot(two, two) == 0.0)
        return;
    t->aim = one;
    t->aiming = t->geom1;
    if (second_first(c, t->geom1, t->geom2)) {
        t->aim = two;
        t->aiming = t->geom2;
    }
    if (dot(t->aim, t->aim) == 0.0)
        t->aim = NULL;
}

/* The direction in which mu applies; 0: there is none. */
static int friction_direction(const touching *t, contact *point)
{
    double aim[3];
    if (!t->aim)
        return 0;
    to_global(rotation_of(t->aiming), t->aim, aim);
    return set_friction_direction(point, aim);
}

/* The direction in which the surface of a track runs at a contact whose normal points out of it; 0: it has none. */
static int track_direction(const double *row, void *geom, const double *normal, double sign, double *way)
{
    double axis[3], size;
    int k;
    to_global(rotation_of(geom), row + SURFACE_FDIR1, axis);
    cross(axis, normal, way);
    size = sqrt(dot(way, way));
    if (size < 1e-9)
        return 0;
    for (k = 0; k < 3; k++)
        way[k] = sign * way[k] / size;
    return 1;
}

/* Friction on a surface that runs: mu acts along the way of the track, or round the pivot, and mu2 across. */
static int set_track(const double *a, const double *b, void *geom1, void *geom2, contact *point)
{
    const double *n = point->geom.normal, *pivot = NULL, *rows[2];
    double way[3], motion[3] = {0.0, 0.0, 0.0}, arm[3], aim[3], first, sign;
    void *geoms[2];
    int found = 0, i, k;
    rows[0] = a, rows[1] = b, geoms[0] = geom1, geoms[1] = geom2;
    first = dGeomGetBody(geom1) ? 1.0 : -1.0; /* the joint measures velocities of its first body against the other */
    for (i = 0; i < 2; i++) {
        sign = i ? 1.0 : -1.0; /* the normal points into geom 1 */
        if (rows[i][SURFACE_TRACK] == 0.0 || !track_direction(rows[i], geoms[i], n, sign, way))
            continue;
        if (rows[i][SURFACE_TRACK] == 2.0)
            pivot = rows[i] + SURFACE_PIVOT;
        for (k = 0; k < 3; k++) {
            motion[k] = motion[k] + first * sign * rows[i][SURFACE_TRACK_SPEED] * way[k];
            if (!found)
                point->fdir1[k] = way[k];
        }
        found = 1;
    }
    if (!found)
        return 0;
    if (pivot) {
        for (k = 0; k < 3; k++)
            arm[k] = point->geom.pos[k] - pivot[k];
        cross(n, arm, aim);
        memcpy(way, point->fdir1, sizeof way);
        if (!set_friction_direction(point, aim)) /* the pivot itself */
            memcpy(point->fdir1, way, sizeof way);
    }
    point->surface.motion1 = dot(motion, point->fdir1);
    point->surface.mode |= FDIR1 | MOTION1;
    return 1;
}

/* Velocity of a body at a point at the end of the step if nothing but gravity acts, added with a sign. */
static void add_velocity(const context *c, void *body, const double *at, double sign, double *sum)
{
    const double *x, *v, *w;
    double arm[3], spin[3], share;
    int k;
    if (!body)
        return;
    x = dBodyGetPosition(body);
    v = dBodyGetLinearVel(body);
    w = dBodyGetAngularVel(body);
    share = dBodyGetGravityMode(body) && !dBodyIsKinematic(body) ? c->step : 0.0;
    for (k = 0; k < 3; k++)
        arm[k] = at[k] - x[k];
    cross(w, arm, spin);
    for (k = 0; k < 3; k++)
        sum[k] = sum[k] + sign * (v[k] + spin[k] + share * c->gravity[k]);
}

/* ODE's own choice of the direction at right angles to a normal in which mu acts. */
static void default_direction(const double *n, double *one)
{
    double k;
    if (fabs(n[2]) > FLANK) {
        k = 1.0 / sqrt(n[1] * n[1] + n[2] * n[2]);
        one[0] = 0.0, one[1] = -n[2] * k, one[2] = n[1] * k;
    } else {
        k = 1.0 / sqrt(n[0] * n[0] + n[1] * n[1]);
        one[0] = -n[1] * k, one[1] = n[0] * k, one[2] = 0.0;
    }
}

/* Friction as in a cone: against the sliding velocity v, with mu v1 / |v| along the first direction and mu2 v2 / |v| along
 * the second. What already slides has no friction across that: else a force across would be resisted as if it stuck, and
 * skidding wheels would not turn. `aimed`: the contact has a first direction. */
static void set_cone(const context *c, const touching *t, contact *point, int aimed)
{
    surface_parameters *s = &point->surface;
    const double *n = point->geom.normal;
    double slide[3] = {0.0, 0.0, 0.0}, one[3], two[3], along, across, size, mu;
    int k;
    if (!(s->mu < HUGE_VAL && s->mu2 < HUGE_VAL))
        return;
    add_velocity(c, t->body1, point->geom.pos, 1.0, slide);
    add_velocity(c, t->body2, point->geom.pos, -1.0, slide);
    if (aimed)
        memcpy(one, point->fdir1, sizeof one);
    else
        default_direction(n, one);
    cross(n, one, two);
    along = dot(slide, one);
    across = dot(slide, two);
    size = sqrt(along * along + across * across);
    if (size < 1e-9)
        return;
    along = s->mu * along / size;
    across = s->mu2 * across / size;
    mu = sqrt(along * along + across * across);
    if (!(mu > 0.0))
        return;
    for (k = 0; k < 3; k++)
        point->fdir1[k] = (along * one[k] + across * two[k]) / mu;
    s->mu = mu;
    s->mu2 = size > c->step * (STICKING * mu) ? 0.0 : mu;
    s->mode |= FDIR1;
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

/* max_vel and min_depth of a pair: the smaller of both bodies'. A geom without a body has no influence. */
static double of_bodies(const touching *t, int column)
{
    if (!t->body1)
        return t->b[column];
    return t->body2 ? smaller(t->a[column], t->b[column]) : t->a[column];
}

static void set_limits(const context *c, touching *t)
{
    /* Geoms of legacy models have no limit; their contacts are so soft that with one they would sink into the other. */
    int limited = t->a[SURFACE_MAX_VEL] < HUGE_VAL && t->b[SURFACE_MAX_VEL] < HUGE_VAL;
    t->max_vel = t->body1 && t->body2 && !limited ? HUGE_VAL : of_bodies(t, SURFACE_MAX_VEL);
    t->min_depth = larger(of_bodies(t, SURFACE_MIN_DEPTH), c->surface_layer);
}

/* Bodies that a joint connects with the world, by row, for the search of contacts; guarded by ode_lock. */
static char *held;
static int64_t held_capacity;

static void find_held(const context *c)
{
    int64_t i;
    char *grown = enlarged(held, &held_capacity, c->body_count, 1);
    if (!grown)
        return;
    held = grown;
    memset(held, 0, (size_t)c->body_count);
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i]) {
            void *one = dJointGetBody(c->joints[i], 0), *two = dJointGetBody(c->joints[i], 1);
            if ((one != NULL) != (two != NULL))
                held[(intptr_t)dBodyGetData(one ? one : two)] = 1;
        }
}

/* Whether a body is held so, or is the world. */
static int is_held(void *body)
{
    int64_t row = body ? (int64_t)(intptr_t)dBodyGetData(body) : -1;
    return row < 0 || (row < held_capacity && held[row]);
}

/* The smaller mass of two bodies, or that of the one that moves [kg]. */
static double lighter(void *body1, void *body2)
{
    body_mass one, two;
    if (!body1 || !body2) {
        dBodyGetMass(body1 ? body1 : body2, &one);
        return one.mass;
    }
    dBodyGetMass(body1, &one);
    dBodyGetMass(body2, &two);
    return smaller(one.mass, two.mass);
}

/* Whether a body is slow, or nothing that moves. */
static int is_calm(const context *c, void *body)
{
    double calm = CALM_SPEED + FALLING_STEPS * c->step * sqrt(dot(c->gravity, c->gravity));
    const double *v, *w;
    if (!body)
        return 1;
    v = dBodyGetLinearVel(body);
    w = dBodyGetAngularVel(body);
    return dot(v, v) + dot(w, w) <= calm * calm;
}

/* Springs that are too stiff to be simulated stand for rigid surfaces. A body that these move out to depth 0 loses its
 * contacts by the error of the solver, falls for a step and is caught again: so they keep REST_DEPTH. One that they move
 * out within a step keeps the velocity that it takes, and bounces: so they get a damper where bodies are calm. And the
 * exact solver fails on redundant contacts without any softness. Bodies that joints hold to the world are left out: there
 * contact and joint share the load, and a softer contact would carry nothing. */
static void make_rigid(const context *c, touching *t, surface_parameters *s)
{
    double softness = 1.0 / t->a[SURFACE_KP] + 1.0 / t->b[SURFACE_KP], mass;
    t->kept = 0.0;
    t->rigid = 0;
    if (!c->exact_rest || (is_held(t->body1) && is_held(t->body2)))
        return;
    mass = lighter(t->body1, t->body2);
    if (c->step * c->step <= SOFT_RATIO * mass * softness)
        return;
    t->rigid = 1;
    if (s->soft_erp > REST_ERP && is_calm(c, t->body1) && is_calm(c, t->body2)) {
        s->soft_cfm = s->soft_cfm * (REST_ERP / s->soft_erp);
        s->soft_erp = REST_ERP;
    }
    s->soft_cfm = larger(s->soft_cfm, REST_CFM / mass);
}

/* The stiffness [N/m] of two elastic surfaces at a depth: F / depth of Hertz' contact, 4 / 3 E sqrt(R depth), or of a flat
 * punch of a patch's radius, 2 E a; 0 if one surface is not elastic, or there is no radius. */
static double elastic_stiffness(const touching *t, double depth)
{
    double compliance = t->a[SURFACE_COMPLIANCE] + t->b[SURFACE_COMPLIANCE];
    double curvature = t->a[SURFACE_CURVATURE] + t->b[SURFACE_CURVATURE];
    if (t->a[SURFACE_COMPLIANCE] <= 0.0 || t->b[SURFACE_COMPLIANCE] <= 0.0 || depth <= 0.0)
        return 0.0;
    if (curvature > 0.0)
        return 4.0 / 3.0 / compliance * sqrt(depth / curvature);
    return 2.0 / compliance * larger(t->a[SURFACE_PATCH_RADIUS], t->b[SURFACE_PATCH_RADIUS]);
}

/* Points of equal depth and softness are redundant, and the exact solver, Dantzig's, may stop halfway at what is degenerate:
 * a stack falls apart then. So rigid ones differ a little, by a triangular wave of the place, which does not change for
 * what rests. */
static void vary(const context *c, touching *t, contact *point)
{
    const double *p = point->geom.pos;
    double wave = 6.0 * p[0] + 8.45 * p[1] + 11.35 * p[2];
    wave = 2.0 * fabs(wave - floor(wave) - 0.5);
    point->surface.soft_cfm = point->surface.soft_cfm * (1.0 + SOFTNESS_SPREAD * wave);
    t->kept = larger(0.0, REST_DEPTH - t->min_depth) - REST_DEPTH * DEPTH_SPREAD * c->step * wave;
    point->geom.depth = larger(0.0, point->geom.depth - t->kept);
}

/* Let a contact push out no faster than max_vel; set_apart does the rest. Its softness shrinks with its correction: the
 * spring carries the same force where the bodies are at rest. */
static void limit_speed(const context *c, touching *t, surface_parameters *s, double depth)
{
    double most = t->max_vel * c->step / depth;
    if (most >= s->soft_erp)
        return;
    t->withheld = (s->soft_erp - most) * depth;
    s->soft_cfm = larger(s->soft_cfm * (most / s->soft_erp), REST_CFM / lighter(t->body1, t->body2));
    s->soft_erp = most;
}

/* What a contact point corrects: the depth that was found, without what is kept and min_depth, no faster than max_vel.
 * One that is not as deep as what is kept lets the bodies approach. */
static void set_depth(const context *c, touching *t, double found, contact *point)
{
    surface_parameters *s = &point->surface;
    double stiffness = elastic_stiffness(t, found);
    if (stiffness > 0.0) {
        double spring = c->step * stiffness, kd = t->a[SURFACE_KD] + t->b[SURFACE_KD];
        s->soft_erp = spring / (spring + kd);
        s->soft_cfm = 1.0 / (spring + kd);
        point->geom.depth = found;
        return;
    }
    point->geom.depth = larger(0.0, point->geom.depth - t->min_depth);
    if (point->geom.depth > 0.0)
        limit_speed(c, t, s, point->geom.depth);
    else if (found < t->kept && !(s->mode & BOUNCE)) {
        s->motionN = s->soft_erp * (found - t->kept) / c->step;
        s->mode |= MOTION_N;
    }
}

/* What classic adds to one contact point: slip, a friction direction, torsion, a minimum depth, a limit on the
 * push-out velocity. */
static void refine_point(const context *c, touching *t, int count, double found, contact *point)
{
    surface_parameters *s = &point->surface;
    const double *a = t->a, *b = t->b;
    s->slip1 = (a[SURFACE_SLIP1] + b[SURFACE_SLIP1]) * count;
    s->slip2 = (a[SURFACE_SLIP2] + b[SURFACE_SLIP2]) * count;
    if (s->slip1 > 0.0)
        s->mode |= SLIP1;
    if (s->slip2 > 0.0)
        s->mode |= SLIP2;
    if ((a[SURFACE_TRACK] == 0.0 && b[SURFACE_TRACK] == 0.0) || !set_track(a, b, t->geom1, t->geom2, point)) {
        int aimed = friction_direction(t, point);
        if (aimed)
            s->mode |= FDIR1;
        if (c->cone)
            set_cone(c, t, point, aimed);
    }
    add_torsion(a, b, point);
    t->withheld = 0.0;
    set_depth(c, t, found, point);
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

/* Allocate so many records; 0 without memory. */
static int have_records(context *c, int64_t capacity)
{
    contact_record *records;
    pending_contact *pending;
    if (capacity <= c->record_capacity)
        return 1;
    records = realloc(c->records, (size_t)capacity * sizeof(contact_record));
    if (!records)
        return 0;
    c->records = records;
    pending = realloc(c->pending, (size_t)capacity * sizeof(pending_contact));
    if (!pending)
        return 0;
    c->pending = pending;
    c->record_capacity = capacity;
    return 1;
}

/* Record a contact point; its joint may be NULL. Without memory it is not recorded. */
static void record_point(context *c, const contact *point, void *geom1, void *geom2, void *joint)
{
    contact_record *r;
    if (c->record_count == c->record_capacity &&
        !have_records(c, c->record_capacity ? 2 * c->record_capacity : 64))
        return;
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

static int is_awake(void *body) { return body && dBodyIsEnabled(body); }

/* Whether a pair of geoms touches under the classic rule; *ghost: without contact joints, only recorded. */
static int may_touch(const context *c, const double *a, const double *b, void *body1, void *body2, int *ghost)
{
    if (!((uint32_t)a[SURFACE_BITS] & (uint32_t)b[SURFACE_BITS]))
        return 0;
    *ghost = a[SURFACE_GHOST] != 0.0 || b[SURFACE_GHOST] != 0.0;
    if (*ghost)
        return c->record_contacts && ((uint32_t)a[SURFACE_GHOST_BITS] & (uint32_t)b[SURFACE_GHOST_BITS]);
    if (c->record_contacts)
        return 1;
    return is_awake(body1) || is_awake(body2); /* both disabled: nothing to do */
}

/* The contact points of two geoms; ODE's own, or those of a cylinder's stand-ins. */
static int find_points(context *c, void *geom1, void *geom2, int most, contact *points)
{
    if (c->no_cylinder_pairs) {
        int class1 = dGeomGetClass(geom1), class2 = dGeomGetClass(geom2);
        if ((class1 == CYLINDER_CLASS && (class2 == CYLINDER_CLASS || class2 == CAPSULE_CLASS)) ||
            (class1 == CAPSULE_CLASS && class2 == CYLINDER_CLASS))
            return collide_cylinder(c, geom1, geom2, class2, points);
    }
    return collide_pair(c, geom1, geom2, most, &points[0].geom, sizeof(contact));
}

/* Whether small calm islands are solved exactly. */
static int solves_islands(const context *c)
{
    return c->exact_rest && c->quick && c->contact_rule == CLASSIC_RULE;
}

/* Note that two bodies touch. Without memory they are not noted, and so not taken for one island. */
static void note_touch(context *c, void *body1, void *body2, int count)
{
    touch_record *t = enlarged(c->touches, &c->touch_capacity, c->touch_count + 1, sizeof *t);
    if (!t)
        return;
    c->touches = t;
    t += c->touch_count++;
    t->body1 = (intptr_t)dBodyGetData(body1 ? body1 : body2);
    t->body2 = body1 && body2 ? (intptr_t)dBodyGetData(body2) : -1;
    t->count = count;
    t->first = c->point_count;
    t->next = -1;
}

/* Note a contact of the bodies that were noted last. Without memory it is missing, and its island is solved by ODE. */
static void note_point(context *c, const contact *point, void *joint)
{
    touch_point *p = enlarged(c->points, &c->point_capacity, c->point_count + 1, sizeof *p);
    if (!p)
        return;
    c->points = p;
    p += c->point_count++;
    p->point = *point;
    p->joint = joint;
    p->record = c->record_contacts ? c->record_count : -1;
}

/* Note a point whose bodies are to be set apart. Without memory it is not noted. */
static void note_overlap(context *c, const touching *t, const contact *point)
{
    overlap_record *o = enlarged(c->overlaps, &c->overlap_capacity, c->overlap_count + 1, sizeof *o);
    if (!o)
        return;
    c->overlaps = o;
    o += c->overlap_count++;
    o->body1 = t->body1;
    o->body2 = t->body2;
    memcpy(o->normal, point->geom.normal, sizeof o->normal);
    o->depth = t->withheld;
    o->softness = 1.0 / t->a[SURFACE_KP] + 1.0 / t->b[SURFACE_KP];
    o->share = 0.0;
}

static void collide_geoms(context *c, void *geom1, void *geom2)
{
    contact points[MOST_CONTACTS];
    surface_parameters surface;
    touching pair;
    const double *a, *b;
    void *body1 = dGeomGetBody(geom1), *body2 = dGeomGetBody(geom2), *joint = NULL;
    int classic = c->contact_rule == CLASSIC_RULE, count, i, ghost = 0;

    if (!body1 && !body2)
        return;
    if (body1 && body2 && dAreConnectedExcluding(body1, body2, JOINT_CONTACT))
        return;
    a = c->surface + SURFACE_COLUMNS * (intptr_t)dGeomGetData(geom1);
    b = c->surface + SURFACE_COLUMNS * (intptr_t)dGeomGetData(geom2);
    if (classic && !may_touch(c, a, b, body1, body2, &ghost))
        return;
    count = find_points(c, geom1, geom2, classic ? MOST_CONTACTS : MAX_CONTACTS, points);
    if (!count)
        return;
    pair = (touching){a, b, geom1, geom2, body1, body2, 0.0, 0.0, 0.0, 0.0, 0, NULL, NULL};
    make_surface(c, a, b, &surface);
    if (classic) {
        count = deepest(points, count, (int)smaller(smaller(a[SURFACE_MAX_CONTACTS], b[SURFACE_MAX_CONTACTS]),
                                                    (double)c->max_contacts));
        set_limits(c, &pair);
        choose_direction(c, &pair);
        make_rigid(c, &pair, &surface);
        if (!ghost && solves_islands(c))
            note_touch(c, body1, body2, count);
    }
    for (i = 0; i < count; i++) {
        double found = points[i].geom.depth;
        points[i].surface = surface;
        if (pair.rigid)
            vary(c, &pair, &points[i]);
        if (classic)
            refine_point(c, &pair, count, found, &points[i]);
        if (!ghost) {
            joint = dJointCreateContact(c->world, c->contacts, &points[i]);
            dJointAttach(joint, body1, body2);
            c->contact_count++;
            if (classic && solves_islands(c))
                note_point(c, &points[i], joint);
            if (pair.withheld > 0.0 && c->exact_rest)
                note_overlap(c, &pair, &points[i]);
        }
        if (c->record_contacts) {
            points[i].geom.depth = found;
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

/* v rotated by the quaternion q; the same operations in the same order as libgz.base.geometry.rotate. */
static void rotate(const double *q, const double *v, double *out)
{
    double tx = 2.0 * (q[2] * v[2] - q[3] * v[1]);
    double ty = 2.0 * (q[3] * v[0] - q[1] * v[2]);
    double tz = 2.0 * (q[1] * v[1] - q[2] * v[0]);
    out[0] = v[0] + q[0] * tx + (q[2] * tz - q[3] * ty);
    out[1] = v[1] + q[0] * ty + (q[3] * tx - q[1] * tz);
    out[2] = v[2] + q[0] * tz + (q[1] * ty - q[2] * tx);
}

int gz_may_sleep(void *body) { return dBodyGetAutoDisableFlag(body); }

/* Whether a number diverged: it is NaN, or beyond twice what may be set (check.py). */
static int is_beyond(double value, double most)
{
    return !(value >= -most && value <= most);
}

enum { MOTION_COLUMNS = 13 };

/* Copy the states of all bodies to a table; returns how many of them diverged. After a step, find the accelerations in
 * it, where motion is recorded. */
static int64_t read_bodies(const context *c, double *state, int stepped)
{
    int64_t i, diverged = 0;
    int k;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        double *row = state + 16 * i;
        double *motion = c->body_motion + MOTION_COLUMNS * i; /* velocities so far, from begin_motion */
        const double *p, *q, *v, *w;
        double offset[3];
        int beyond = 0;
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
            beyond |= is_beyond(p[k], c->max_distance);
            beyond |= is_beyond(v[k], DIVERGED_SPEED) | is_beyond(w[k], DIVERGED_SPEED);
        }
        for (k = 0; k < 4; k++)
            row[3 + k] = q[k];
        for (k = 0; stepped && c->record_motion && k < 3; k++) {
            motion[k] = (v[k] - motion[k]) / c->step;
            motion[3 + k] = (w[k] - motion[3 + k]) / c->step;
        }
        diverged += beyond;
    }
    return diverged;
}

/* The angle that is nearest to the one before, so that joints count their turns. ODE's is within -pi to pi. */
static double unwind(const context *c, double before, double angle)
{
    double turns = (before - angle) / TURN;
    return c->count_turns && isfinite(turns) ? angle + TURN * rint(turns) : angle;
}

/* Apply the springs and dampers of hinges and sliders for the coming step. */
static void apply_springs(context *c)
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

/* Copy the states of all joints to a table; turns are counted on from those of the own table. */
static void read_joints(const context *c, double *state)
{
    int64_t i;
    for (i = 0; i < c->joint_count; i++) {
        void *joint = c->joints[i];
        const double *before = c->joint_state + 4 * i;
        double *row = state + 4 * i;
        if (!joint)
            continue;
        switch (c->joint_types[i]) {
        case JOINT_HINGE:
            row[0] = unwind(c, before[0], dJointGetHingeAngle(joint));
            row[2] = dJointGetHingeAngleRate(joint);
            break;
        case JOINT_SLIDER:
            row[0] = dJointGetSliderPosition(joint);
            row[2] = dJointGetSliderPositionRate(joint);
            break;
        case JOINT_HINGE2:
            row[0] = unwind(c, before[0], dJointGetHinge2Angle1(joint));
            row[1] = unwind(c, before[1], dJointGetHinge2Angle2(joint));
            row[2] = dJointGetHinge2Angle1Rate(joint);
            row[3] = dJointGetHinge2Angle2Rate(joint);
            break;
        case JOINT_UNIVERSAL:
            row[0] = unwind(c, before[0], dJointGetUniversalAngle1(joint));
            row[1] = unwind(c, before[1], dJointGetUniversalAngle2(joint));
            row[2] = dJointGetUniversalAngle1Rate(joint);
            row[3] = dJointGetUniversalAngle2Rate(joint);
            break;
        case JOINT_PISTON:
            row[0] = unwind(c, before[0], dJointGetPistonAngle(joint));
            row[1] = dJointGetPistonPosition(joint);
            row[2] = dJointGetPistonAngleRate(joint);
            row[3] = dJointGetPistonPositionRate(joint);
            break;
        }
    }
}

/* Begin the records of a step, and keep those of the step before. */
static void begin_records(context *c)
{
    c->earlier_count = 0;
    if (c->record_contacts && c->record_count) {
        contact_record *kept = enlarged(c->earlier, &c->earlier_capacity, c->record_count, sizeof *kept);
        if (kept) {
            memcpy(kept, c->records, (size_t)c->record_count * sizeof *kept);
            c->earlier = kept;
            c->earlier_count = c->record_count;
        }
    }
    c->record_count = 0;
}

/* The first half of a step: find contacts and make joints of them. */
static void find_contacts(context *c)
{
    int64_t i;
    begin_records(c);
    c->contact_count = c->touch_count = c->point_count = c->overlap_count = 0;
    if (c->exact_rest && c->contact_rule == CLASSIC_RULE) {
        for (i = 0; i < c->body_count; i++)
            if (c->bodies[i])
                dBodySetData(c->bodies[i], (void *)(intptr_t)i);
        find_held(c);
    }
    dSpaceCollide(c->space, c, collide);
}

/* Request the forces of the recorded contacts of this step from ODE. */
static void request_feedback(context *c)
{
    int64_t i;
    for (i = 0; i < c->record_count; i++) {
        pending_contact *p = c->pending + i;
        memset(&p->result, 0, sizeof p->result);
        if (p->joint)
            dJointSetFeedback(p->joint, &p->result);
    }
}

static int same_pair(const contact_record *one, const contact_record *other)
{
    return one->geom1 == other->geom1 && one->geom2 == other->geom2;
}

/* The place of a pair's first record in the step before, searched for from `from` on; -1 without any. */
static int64_t find_pair(const context *c, const contact_record *r, int64_t from)
{
    int64_t n;
    for (n = 0; n < c->earlier_count; n++) {
        int64_t i = (from + n) % c->earlier_count;
        if (same_pair(c->earlier + i, r) && (i == 0 || !same_pair(c->earlier + i - 1, r)))
            return i;
    }
    return -1;
}

/* ODE does not solve contacts of bodies that are asleep: they carry what they carried in the step before, point by point. */
static void carry_on(context *c)
{
    int64_t i, place = -1, from = 0;
    for (i = 0; i < c->record_count; i++) {
        contact_record *r = c->records + i;
        void *joint = c->pending[i].joint;
        if (!joint || is_awake(dJointGetBody(joint, 0)) || is_awake(dJointGetBody(joint, 1)))
            continue;
        if (i == 0 || !same_pair(r - 1, r))
            place = find_pair(c, r, from);
        else if (place >= 0)
            place = place + 1 < c->earlier_count && same_pair(c->earlier + place + 1, r) ? place + 1 : -1;
        if (place < 0)
            continue;
        from = place;
        memcpy(r->force1, c->earlier[place].force1, 4 * sizeof r->force1);
    }
}

/* Copy the forces to the records. ODE's first body is never missing; for a missing second one there is no feedback. */
static void collect_feedback(context *c)
{
    int64_t i;
    carry_on(c);
    for (i = 0; i < c->record_count; i++) {
        pending_contact *p = c->pending + i;
        contact_record *r = c->records + i;
        if (!p->joint)
            continue;
        if (!is_awake(dJointGetBody(p->joint, 0)) && !is_awake(dJointGetBody(p->joint, 1))) {
            p->joint = NULL;
            continue;
        }
        memcpy(p->reversed ? r->force2 : r->force1, p->result.f1, sizeof r->force1);
        memcpy(p->reversed ? r->torque2 : r->torque1, p->result.t1, sizeof r->torque1);
        if (!p->reversed) {
            memcpy(r->force2, p->result.f2, sizeof r->force2);
            memcpy(r->torque2, p->result.t2, sizeof r->torque2);
        }
        p->joint = NULL;
    }
}

/* Replace the records of the last step. */
void gz_set_contacts(context *c, const contact_record *records, int64_t count)
{
    int64_t i;
    c->record_count = have_records(c, count) ? count : 0;
    if (!c->record_count)
        return;
    memcpy(c->records, records, (size_t)count * sizeof(contact_record));
    for (i = 0; i < count; i++)
        c->pending[i].joint = NULL;
}

/* Free the memory of what is recorded in a step. */
void gz_free_contacts(context *c)
{
    free(c->records);
    free(c->pending);
    free(c->touches);
    free(c->overlaps);
    free(c->points);
    free(c->earlier);
    c->points = NULL;
    c->earlier = NULL;
    c->point_count = c->point_capacity = c->earlier_count = c->earlier_capacity = 0;
    c->overlaps = NULL;
    c->overlap_count = c->overlap_capacity = 0;
    c->records = NULL;
    c->pending = NULL;
    c->touches = NULL;
    c->record_count = c->record_capacity = c->touch_count = c->touch_capacity = 0;
}

static int is_within(const double *v, double most)
{
    return fabs(v[0]) <= most && fabs(v[1]) <= most && fabs(v[2]) <= most;
}

/* Record velocity and applied efforts of each body where that is on, and reset those of diverged bodies: ODE ends the
 * process on non-finite numbers. */
static void begin_motion(context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        double *row = c->body_motion + MOTION_COLUMNS * i;
        const double *v, *w, *force, *torque;
        if (!body)
            continue;
        v = dBodyGetLinearVel(body);
        w = dBodyGetAngularVel(body);
        force = dBodyGetForce(body);
        torque = dBodyGetTorque(body);
        if (!(is_within(v, MAX_SPEED) && is_within(w, MAX_SPEED) && is_within(force, MAX_EFFORT) &&
              is_within(torque, MAX_EFFORT))) {
            dBodySetLinearVel(body, 0.0, 0.0, 0.0);
            dBodySetAngularVel(body, 0.0, 0.0, 0.0);
            dBodySetForce(body, 0.0, 0.0, 0.0);
            dBodySetTorque(body, 0.0, 0.0, 0.0);
            c->reset_row = i + 1;
        }
        if (!c->record_motion)
            continue;
        memcpy(row, v, 3 * sizeof(double)); /* the addresses are those of ODE's own numbers */
        memcpy(row + 3, w, 3 * sizeof(double));
        memcpy(row + 6, force, 3 * sizeof(double));
        memcpy(row + 9, torque, 3 * sizeof(double));
        row[12] = dBodyGetGravityMode(body) && !dBodyIsKinematic(body) ? 1.0 : 0.0;
    }
}

/* An abandoned step does not free its memory. So from the first such step on, a world keeps no memory from one step to
 * the next, and what is still allocated after a step is freed here. */
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

static void free_step_memory(context *c)
{
    static const memory_functions own = {sizeof own, get_block, shrink_block, drop_block};
    dWorldCleanupWorkingMemory(c->world);
    while (block_count > 0)
        free(blocks[--block_count]);
    if (!c->own_memory)
        dWorldSetStepMemoryManager(c->world, &own);
    c->own_memory = 1;
}

/* Islands: bodies that joints and contacts connect. Those that are small and calm are solved exactly, for they rest in
 * no other way, by resting.c where there are no joints and nothing slides; those that are fast only if they have no
 * contacts, for the exact solver does not let wheels slip as they should; and if they are so small that it is the quicker
 * way. */
enum { EXACT_ROWS = 150, FAST_ROWS = 60, ROWS_OF_JOINT = 6, ROWS_OF_POINT = 3 };
enum { ALL_EXACT, ALL_QUICK, MIXED };

typedef struct {
    int64_t root; /* the member that stands for the island, or one that is nearer to it */
    int64_t rows; /* of the solver, in the root's */
    int fast;     /* 1: a body of the island is, in the root's */
    int touching; /* 1: the island has contacts, in the root's */
    int joined;   /* 1: it has joints, in the root's */
    int quick;    /* 1: to be solved by iteration */
    int solved;   /* 1: its contacts were solved by resting.c, in the root's */
    int aside;    /* 1: the body was awake and is disabled for a part of the step */
    int64_t next;               /* body of the island, or -1 */
    int64_t first, last;        /* body of the island, in the root's; -1 before it has any */
    int64_t touch, last_touch;  /* first and last touch of the island, in the root's; -1 without any */
    int64_t place;              /* among the island's bodies */
    double fallen;              /* its position along gravity [m^2/s^2] */
} member;

static member alone(int64_t row, int fast)
{
    return (member){.root = row, .fast = fast, .next = -1, .first = -1, .last = -1, .touch = -1, .last_touch = -1};
}

static member *members; /* by row of body; guarded by ode_lock */
static int64_t member_capacity;

static int have_members(int64_t count)
{
    member *grown = enlarged(members, &member_capacity, count, sizeof *grown);
    if (grown)
        members = grown;
    return grown != NULL;
}

static int64_t root_of(int64_t i)
{
    while (members[i].root != i)
        i = members[i].root = members[members[i].root].root;
    return i;
}

/* Take two bodies, one of which may be the world (-1), for one island. */
static void connect(const context *c, int64_t one, int64_t two, int64_t rows, int touching)
{
    if (one < 0 || !c->bodies[one])
        one = two;
    if (one < 0 || !c->bodies[one])
        return;
    one = root_of(one);
    members[one].rows += rows;
    members[one].touching |= touching;
    members[one].joined |= !touching;
    if (two < 0 || !c->bodies[two])
        return;
    two = root_of(two);
    if (two == one)
        return;
    members[two].root = one;
    members[one].rows += members[two].rows;
    members[one].fast |= members[two].fast;
    members[one].touching |= members[two].touching;
    members[one].joined |= members[two].joined;
}

static int64_t row_of(void *body) { return body ? (int64_t)(intptr_t)dBodyGetData(body) : -1; }

/* What contacts may have, to be solved by resting.c: no bouncing and no torsion. */
enum { PLAIN = MU2 | FDIR1 | SOFT_ERP | SOFT_CFM | MOTION_N | SLIP1 | SLIP2 | APPROX1 };
enum { RESTING_WORK = 400 }; /* bodies squared, in the profile of larger islands: what a stack of a hundred takes */
#define SLACK 1e-5 /* [-] of the inverse mass, that every direction yields at least while a system is solved */
#define SURELY 2.0 /* times as fast as friction can stop in a step: contacts slide, however the load is shared */

static resting_body *resting_bodies; /* guarded by ode_lock */
static resting_point *resting_points;
static int64_t *ranked; /* rows of an island's bodies, by place */
static int64_t resting_body_capacity, resting_point_capacity, ranked_capacity;

/* List the bodies and touches of each island, in their order. */
static void list_members(const context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        member *root;
        if (!c->bodies[i])
            continue;
        root = members + root_of(i);
        if (root->first < 0)
            root->first = i;
        else
            members[root->last].next = i;
        root->last = i;
    }
    for (i = 0; i < c->touch_count; i++) {
        touch_record *t = c->touches + i;
        member *root = members + root_of(t->body1);
        if (root->touch < 0)
            root->touch = i;
        else
            c->touches[root->last_touch].next = i;
        root->last_touch = i;
    }
}

/* Impulse that acts on a body in the step, without contacts. */
static void find_load(const context *c, void *body, double mass, double *load)
{
    const double *force = dBodyGetForce(body);
    int i, falls = dBodyGetGravityMode(body);
    for (i = 0; i < 3; i++)
        load[i] = c->step * (force[i] + (falls ? mass * c->gravity[i] : 0.0));
}

/* Momentum and inertia of a body that has no contacts. */
static void describe_body(const context *c, void *body, resting_body *b)
{
    const double *r = dBodyGetRotation(body), *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    const double *torque = dBodyGetTorque(body);
    double turned[3][3], angular[3], gyroscopic[3], load[3];
    int i, k;
    body_mass m;
    dBodyGetMass(body, &m);
    b->mass = m.mass;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++)
            turned[i][k] = r[4 * i] * m.inertia[k] + r[4 * i + 1] * m.inertia[4 + k] + r[4 * i + 2] * m.inertia[8 + k];
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++)
            b->inertia[i][k] = dot(turned[i], r + 4 * k);
    for (i = 0; i < 3; i++)
        angular[i] = dot(b->inertia[i], w);
    cross(w, angular, gyroscopic);
    find_load(c, body, m.mass, load);
    for (i = 0; i < 3; i++) {
        b->momentum[i] = m.mass * v[i] + load[i];
        b->momentum[3 + i] = angular[i] + c->step * (torque[i] - gyroscopic[i]);
    }
}

/* The directions of a contact as ODE has them: the normal, and two of friction. */
static void find_directions(const contact *p, double directions[DIRECTIONS][3])
{
    const double *n = p->geom.normal;
    double *one = directions[1], *two = directions[2];
    memcpy(directions[0], n, 3 * sizeof(double));
    if (p->surface.mode & FDIR1)
        memcpy(one, p->fdir1, 3 * sizeof(double));
    else
        default_direction(n, one);
    cross(n, one, two);
}

/* Softness of a contact, and coefficients of friction. */
static void find_friction(const context *c, const contact *p, double world_cfm, double *softness, double *mu)
{
    const surface_parameters *s = &p->surface;
    softness[0] = s->soft_cfm / c->step;
    softness[1] = (s->mode & SLIP1 ? s->slip1 : world_cfm) / c->step;
    softness[2] = (s->mode & SLIP2 ? s->slip2 : world_cfm) / c->step;
    mu[0] = s->mu;
    mu[1] = s->mode & MU2 ? s->mu2 : s->mu;
}

static void describe_point(const context *c, const touch_record *t, const contact *p, double world_cfm, double fastest,
                           resting_point *found)
{
    const surface_parameters *s = &p->surface;
    double directions[DIRECTIONS][3], mass = HUGE_VAL;
    int side, k, i;
    find_directions(p, directions);
    for (side = 0; side < 2; side++) {
        int64_t row = side ? t->body2 : t->body1;
        const double *place;
        double arm[3];
        found->body[side] = row < 0 ? -1 : members[row].place;
        if (row < 0)
            continue;
        place = dBodyGetPosition(c->bodies[row]);
        mass = smaller(mass, resting_bodies[members[row].place].mass);
        for (k = 0; k < 3; k++)
            arm[k] = p->geom.pos[k] - place[k];
        for (k = 0; k < DIRECTIONS; k++) {
            double *line = found->rows[side][k];
            memcpy(line, directions[k], 3 * sizeof(double));
            cross(arm, directions[k], line + 3);
            if (side)
                for (i = 0; i < MOTIONS; i++)
                    line[i] = -line[i];
        }
    }
    found->aim = s->soft_erp * p->geom.depth / c->step + (s->mode & MOTION_N ? s->motionN : 0.0);
    found->aim = smaller(found->aim, fastest);
    find_friction(c, p, world_cfm, found->softness, found->mu);
    for (k = 0; k < DIRECTIONS; k++)
        found->slack[k] = larger(0.0, SLACK / mass - found->softness[k]);
}

/* Number the bodies of an island from top to bottom, so that those that touch are near each other; how many there are, 0 if
 * some do not move or are asleep. */
static int64_t rank_bodies(const context *c, const member *root)
{
    int64_t i, k, count = 0;
    for (i = root->first; i >= 0; i = members[i].next) {
        int64_t *grown = enlarged(ranked, &ranked_capacity, count + 1, sizeof *ranked);
        double fallen = dot(dBodyGetPosition(c->bodies[i]), c->gravity);
        if (!grown || !dBodyIsEnabled(c->bodies[i]) || dBodyIsKinematic(c->bodies[i]))
            return 0;
        ranked = grown;
        members[i].fallen = fallen;
        for (k = count++; k > 0 && members[ranked[k - 1]].fallen > fallen; k--)
            ranked[k] = ranked[k - 1];
        ranked[k] = i;
    }
    for (i = 0; i < count; i++)
        members[ranked[i]].place = i;
    return count;
}

/* Count and number the members of an island, and find which are near each other; 0 if it is of another kind. */
static int survey_island(const context *c, const member *root, int64_t *bodies, int64_t *points)
{
    int64_t i, k, work = 0;
    void *grown;
    *points = 0;
    *bodies = rank_bodies(c, root);
    if (!*bodies)
        return 0;
    grown = enlarged(resting_bodies, &resting_body_capacity, *bodies, sizeof *resting_bodies);
    if (!grown)
        return 0;
    resting_bodies = grown;
    for (i = 0; i < *bodies; i++)
        resting_bodies[i].nearest = i;
    for (i = root->touch; i >= 0; i = c->touches[i].next) {
        const touch_record *t = c->touches + i;
        int64_t one = members[t->body1].place, two = t->body2 < 0 ? one : members[t->body2].place;
        resting_body *later = resting_bodies + (one > two ? one : two);
        if (t->first + t->count > c->point_count)
            return 0;
        for (k = 0; k < t->count; k++)
            if (c->points[t->first + k].point.surface.mode & ~PLAIN)
                return 0;
        later->nearest = later->nearest < one ? later->nearest : one;
        later->nearest = later->nearest < two ? later->nearest : two;
        *points += t->count;
    }
    for (i = 0; i < *bodies; i++)
        work += (i - resting_bodies[i].nearest + 1) * (i - resting_bodies[i].nearest + 1);
    return root->rows <= EXACT_ROWS || work <= RESTING_WORK;
}

/* Describe an island to resting.c; the number of its points, 0 if it is of another kind. */
static int64_t describe_island(const context *c, const member *root, int64_t *body_count)
{
    double world_cfm = dWorldGetCFM(c->world), fastest = dWorldGetContactMaxCorrectingVel(c->world);
    int64_t i, k, points;
    resting_point *p;
    void *grown;
    if (!survey_island(c, root, body_count, &points))
        return 0;
    grown = enlarged(resting_points, &resting_point_capacity, points, sizeof *resting_points);
    if (!grown)
        return 0;
    p = resting_points = grown;
    for (i = root->first; i >= 0; i = members[i].next)
        describe_body(c, c->bodies[i], resting_bodies + members[i].place);
    for (i = root->touch; i >= 0; i = c->touches[i].next)
        for (k = 0; k < c->touches[i].count; k++)
            describe_point(c, c->touches + i, &c->points[c->touches[i].first + k].point, world_cfm, fastest, p++);
    return points;
}

/* Force and torque of a contact on one of its bodies. */
static void find_effort(const context *c, const resting_point *p, int side, double *force, double *torque)
{
    int a, k;
    for (a = 0; a < 3; a++) {
        force[a] = torque[a] = 0.0;
        for (k = 0; k < DIRECTIONS; k++) {
            force[a] = force[a] + p->rows[side][k][a] * p->impulse[k];
            torque[a] = torque[a] + p->rows[side][k][3 + a] * p->impulse[k];
        }
        force[a] = force[a] / c->step;
        torque[a] = torque[a] / c->step;
    }
}

/* Let the contacts of an island act as efforts; their joints have no part in the step. */
static void apply_solution(context *c, const member *root)
{
    const resting_point *p = resting_points;
    int64_t i, k;
    for (i = root->first; i >= 0; i = members[i].next) {
        const double *impulse = resting_bodies[members[i].place].impulse;
        const double *force = dBodyGetForce(c->bodies[i]), *torque = dBodyGetTorque(c->bodies[i]);
        dBodySetForce(c->bodies[i], force[0] + impulse[0] / c->step, force[1] + impulse[1] / c->step,
                      force[2] + impulse[2] / c->step);
        dBodySetTorque(c->bodies[i], torque[0] + impulse[3] / c->step, torque[1] + impulse[4] / c->step,
                       torque[2] + impulse[5] / c->step);
    }
    for (i = root->touch; i >= 0; i = c->touches[i].next)
        for (k = 0; k < c->touches[i].count; k++, p++) {
            const touch_point *point = c->points + c->touches[i].first + k;
            dJointDisable(point->joint);
            if (point->record >= 0 && point->record < c->record_count) {
                feedback *result = &c->pending[point->record].result;
                find_effort(c, p, 0, result->f1, result->t1);
                if (p->body[1] >= 0)
                    find_effort(c, p, 1, result->f2, result->t2);
            }
        }
}

/* Whether a contact of a body with the world slides faster than friction could stop it in the step, if the whole island's
 * load and mass pressed there. */
static int point_slides(const context *c, void *body, double mass, double load, double whole_mass, const contact *p)
{
    const double *place = dBodyGetPosition(body), *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    double directions[DIRECTIONS][3], softness[DIRECTIONS], mu[2], arm[3], velocity[3], press;
    int k;
    for (k = 0; k < 3; k++)
        arm[k] = p->geom.pos[k] - place[k];
    cross(w, arm, velocity);
    for (k = 0; k < 3; k++)
        velocity[k] = v[k] + velocity[k];
    find_directions(p, directions);
    find_friction(c, p, dWorldGetCFM(c->world), softness, mu);
    press = load + whole_mass * larger(0.0, -dot(directions[0], velocity));
    for (k = 0; k < 2; k++)
        if (mu[k] > 0.0 &&
            fabs(dot(directions[k + 1], velocity)) > SURELY * (mu[k] * press * (1.0 / mass + softness[k + 1])))
            return 1;
    return 0;
}

/* Whether an island surely slides, at each of its contacts with the world: it is not worth an attempt, which would fail.
 * Where that would not fail, as with a ball that friction turns at once, ODE finds the same motion. What rests has no
 * velocity, and so never seems to slide. */
static int slides(const context *c, const member *root)
{
    double whole[3] = {0.0, 0.0, 0.0}, whole_mass = 0.0, load[3];
    int64_t i, k, found = 0;
    body_mass m;
    for (i = root->first; i >= 0; i = members[i].next) {
        dBodyGetMass(c->bodies[i], &m);
        find_load(c, c->bodies[i], m.mass, load);
        whole_mass = whole_mass + m.mass;
        for (k = 0; k < 3; k++)
            whole[k] = whole[k] + load[k];
    }
    for (i = root->touch; i >= 0; i = c->touches[i].next) {
        const touch_record *t = c->touches + i;
        void *body = c->bodies[t->body1];
        if (t->body2 >= 0)
            continue;
        if (t->first + t->count > c->point_count)
            return 0;
        dBodyGetMass(body, &m);
        for (k = 0; k < t->count; k++, found++)
            if (!point_slides(c, body, m.mass, sqrt(dot(whole, whole)), whole_mass, &c->points[t->first + k].point))
                return 0;
    }
    return found > 0;
}

/* Whether a body stands for an island that may rest: calm bodies that only touch. */
static int may_rest(const context *c, int64_t i)
{
    const member *root = members + i;
    return c->bodies[i] && root->root == i && root->touching && !root->fast && !root->joined;
}

/* Solve islands that rest; those that cannot be solved so are left to ODE. */
static void solve_resting(context *c)
{
    int64_t i;
    int listed = 0;
    for (i = 0; i < c->body_count; i++) {
        member *root = members + i;
        int64_t points, bodies;
        if (!may_rest(c, i))
            continue;
        if (!listed)
            list_members(c);
        listed = 1;
        if (root->touch < 0 || slides(c, root))
            continue;
        points = describe_island(c, root, &bodies);
        if (points && gz_solve_resting(resting_bodies, bodies, resting_points, points)) {
            root->solved = 1;
            apply_solution(c, root);
        }
    }
}

/* Find the islands, and which of them are solved exactly. */
static int sort_islands(context *c)
{
    int64_t i;
    int exact = 0, quick = 0;
    for (i = 0; i < c->body_count; i++) {
        if (!c->bodies[i])
            continue;
        members[i] = alone(i, !is_calm(c, c->bodies[i]));
        dBodySetData(c->bodies[i], (void *)(intptr_t)i);
    }
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i])
            connect(c, row_of(dJointGetBody(c->joints[i], 0)), row_of(dJointGetBody(c->joints[i], 1)), ROWS_OF_JOINT,
                    0);
    for (i = 0; i < c->touch_count; i++)
        connect(c, c->touches[i].body1, c->touches[i].body2, ROWS_OF_POINT * c->touches[i].count, 1);
    solve_resting(c);
    for (i = 0; i < c->body_count; i++) {
        const member *root;
        if (!c->bodies[i])
            continue;
        root = members + root_of(i);
        members[i].quick = root->rows > (root->fast ? root->touching ? 0 : FAST_ROWS : EXACT_ROWS);
        if (!root->rows || root->solved || !dBodyIsEnabled(c->bodies[i]))
            continue;
        exact |= !members[i].quick;
        quick |= members[i].quick;
    }
    return !quick ? ALL_EXACT : exact ? MIXED : ALL_QUICK;
}

/* Disable the bodies that are, or are not, solved by iteration. */
static void set_aside(const context *c, int quick)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i] && members[i].quick == quick && dBodyIsEnabled(c->bodies[i])) {
            members[i].aside = 1;
            dBodyDisable(c->bodies[i]);
        }
}

/* Enable all bodies that were set aside, without restarting the time they have been idle for. */
static void bring_back(const context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++) {
        void *body = c->bodies[i];
        int steps;
        double time;
        if (!body || !members[i].aside)
            continue;
        members[i].aside = 0;
        if (!dBodyGetAutoDisableFlag(body)) {
            dBodyEnable(body);
            continue;
        }
        steps = dBodyGetAutoDisableSteps(body);
        time = dBodyGetAutoDisableTime(body);
        dBodySetAutoDisableFlag(body, 0); /* which enables the body */
        dBodySetAutoDisableFlag(body, 1);
        dBodySetAutoDisableSteps(body, steps);
        dBodySetAutoDisableTime(body, time);
    }
}

/* Move everything; 0 when ODE ran out of memory. */
static int move(context *c)
{
    int kind = !c->quick ? ALL_EXACT : ALL_QUICK, done;
    if (solves_islands(c) && have_members(c->body_count))
        kind = sort_islands(c);
    if (kind == ALL_QUICK)
        return dWorldQuickStep(c->world, c->step);
    if (kind == ALL_EXACT)
        return dWorldStep(c->world, c->step);
    c->parted = 1;
    set_aside(c, 1);
    done = dWorldStep(c->world, c->step);
    bring_back(c);
    set_aside(c, 0);
    done = dWorldQuickStep(c->world, c->step) && done;
    bring_back(c);
    c->parted = 0;
    return done;
}

/* Bodies that overlap are set apart without velocity, as in Gazebo: by what max_vel withholds from their contacts, and
 * together with all that joints connect them with, which is not turned. What touches from both sides is a compromise:
 * each contact yields, by YIELDING of what it weighs. Springs keep the depth at which they carry SPARED times the weight;
 * without it bodies would fall on, and be set apart in each step. */
enum { SETTING_ROUNDS = 10 };
#define YIELDING 0.25
#define SPARED 2.0

typedef struct {
    double mass;     /* [kg] of all its bodies; 0: it does not move */
    double shift[3]; /* [m] */
} group;

/* `find_contacts` has numbered the bodies. */
static group *groups; /* by the row of a body that stands for the group; guarded by ode_lock */
static int64_t group_capacity;

static int have_groups(int64_t count)
{
    group *grown = enlarged(groups, &group_capacity, count, sizeof *grown);
    if (grown)
        groups = grown;
    return grown != NULL;
}

/* The group of a body; NULL if it cannot move. */
static group *group_of(void *body)
{
    group *found = body ? groups + root_of(row_of(body)) : NULL;
    return found && found->mass > 0.0 ? found : NULL;
}

static void find_groups(const context *c)
{
    int64_t i;
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i]) {
            members[i] = alone(i, 0);
            groups[i] = (group){0.0, {0.0, 0.0, 0.0}};
        }
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i])
            connect(c, row_of(dJointGetBody(c->joints[i], 0)), row_of(dJointGetBody(c->joints[i], 1)), 0, 0);
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i]) {
            body_mass one;
            dBodyGetMass(c->bodies[i], &one);
            groups[root_of(i)].mass += one.mass;
        }
    for (i = 0; i < c->body_count; i++)
        if (c->bodies[i] && dBodyIsKinematic(c->bodies[i]))
            groups[root_of(i)].mass = 0.0;
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i]) {
            int64_t one = row_of(dJointGetBody(c->joints[i], 0)), two = row_of(dJointGetBody(c->joints[i], 1));
            if ((one < 0) != (two < 0)) /* not by `held`: another world may have collided since */
                groups[root_of(one < 0 ? two : one)].mass = 0.0;
        }
}

static void add_shift(group *g, const double *normal, double distance)
{
    int k;
    for (k = 0; k < 3; k++)
        g->shift[k] += normal[k] * distance;
}

static void spare(const context *c, overlap_record *o)
{
    const group *one = group_of(o->body1), *two = group_of(o->body2);
    double mass = one && two ? smaller(one->mass, two->mass) : one ? one->mass : two ? two->mass : 0.0;
    o->depth = larger(0.0, o->depth - SPARED * o->softness * mass * sqrt(dot(c->gravity, c->gravity)));
}

/* One step of projected Gauss-Seidel for one contact. */
static void balance(overlap_record *o)
{
    group *one = group_of(o->body1), *two = group_of(o->body2);
    double lightness = (one ? 1.0 / one->mass : 0.0) + (two ? 1.0 / two->mass : 0.0), missing = o->depth, share;
    if (one == two)
        return;
    if (one)
        missing -= dot(o->normal, one->shift);
    if (two)
        missing += dot(o->normal, two->shift);
    share = larger(0.0, o->share + (missing / lightness - YIELDING * o->share) / (1.0 + YIELDING));
    if (one)
        add_shift(one, o->normal, (share - o->share) / one->mass);
    if (two)
        add_shift(two, o->normal, -(share - o->share) / two->mass);
    o->share = share;
}

static void set_apart(const context *c)
{
    int64_t i;
    int round;
    if (!c->overlap_count || !have_members(c->body_count) || !have_groups(c->body_count))
        return;
    find_groups(c);
    for (i = 0; i < c->overlap_count; i++)
        spare(c, c->overlaps + i);
    for (round = 0; round < SETTING_ROUNDS; round++)
        for (i = 0; i < c->overlap_count; i++)
            balance(c->overlaps + i);
    for (i = 0; i < c->body_count; i++) {
        const group *g = c->bodies[i] ? group_of(c->bodies[i]) : NULL;
        const double *p;
        if (!g || !(dot(g->shift, g->shift) > 0.0))
            continue;
        p = dBodyGetPosition(c->bodies[i]);
        dBodySetPosition(c->bodies[i], p[0] + g->shift[0], p[1] + g->shift[1], p[2] + g->shift[2]);
    }
}

/* Whether some bodies are asleep, from one on; of so many of them if there are more. */
static int are_asleep(const context *c, int64_t first, int64_t most)
{
    int64_t i, count = c->body_count < most ? c->body_count : most;
    for (i = 0; i < count; i++) {
        void *body = c->bodies[(first + i) % c->body_count];
        if (body && dBodyIsEnabled(body))
            return 0;
    }
    return 1;
}

static int have_springs(const context *c)
{
    int64_t i;
    for (i = 0; i < c->joint_count; i++)
        if (c->joints[i] && (c->springs[3 * i] != 0.0 || c->springs[3 * i + 1] != 0.0))
            return 1;
    return 0;
}

/* After a step that began and ended without a body awake, the next one changes nothing; springs act on sleeping bodies. */
enum { RESTING = 2, CHECKED = 64 };

static void note_rest(context *c)
{
    if (!c->body_count || !are_asleep(c, 0, c->body_count) || have_springs(c))
        c->resting = 0;
    else if (c->resting < RESTING)
        c->resting++;
}

/* Whether a step can be left out. A look at some bodies finds those that were woken past the tables. */
static int rests(context *c)
{
    if (c->resting < RESTING || c->record_contacts || !c->body_count)
        return 0;
    if (!are_asleep(c, c->next_checked, CHECKED)) {
        c->resting = 0;
        return 0;
    }
    c->next_checked = (c->next_checked + CHECKED) % c->body_count;
    return 1;
}

void gz_disturb(context *c) { c->resting = 0; }

enum { STEP_NEEDS_RECOVERY = 2 };

/* The second half: move everything, drop the contacts, copy the states out. Returns 1, 0 when ODE ran out of memory, or
 * STEP_NEEDS_RECOVERY: the context holds what happened. */
static int solve(context *c)
{
    volatile int done = 1; /* kept when the step is abandoned */
    dRandSetSeed((unsigned long)c->seed);
    request_feedback(c);
    apply_springs(c);
    c->reset_row = 0;
    begin_motion(c);
    c->abandoned = 0;
    guarded = 1;
    if (SET_JUMP(escape))
        c->abandoned = 1;
    else
        done = move(c);
    guarded = 0;
    if (c->parted) { /* the step was abandoned meanwhile */
        c->parted = 0;
        bring_back(c);
    }
    if (c->abandoned)
        gz_drop_calls();
    if (c->abandoned || c->own_memory)
        free_step_memory(c);
    if (done && !c->abandoned)
        set_apart(c);
    collect_feedback(c);
    dJointGroupEmpty(c->contacts);
    c->seed = dRandGetSeed();
    c->steps++;
    c->diverged = read_bodies(c, c->body_state, 1);
    read_joints(c, c->joint_state);
    note_rest(c);
    if (done && (c->reset_row || c->abandoned || c->diverged || c->collision_failed))
        return STEP_NEEDS_RECOVERY;
    return done != 0;
}

/* ODE's solver and mesh colliders use memory that all worlds of a process share, and ctypes lets other threads run
 * meanwhile; so only one thread at a time may be in ODE. */
static pthread_mutex_t ode_lock = PTHREAD_MUTEX_INITIALIZER;

/* A forked child does not have the thread that may hold the lock, and its step is not continued. */
static void free_in_child(void)
{
    gz_drop_calls();
    pthread_mutex_init(&ode_lock, NULL);
}

static void enter_ode(void)
{
    static int prepared;
    pthread_mutex_lock(&ode_lock);
    if (!prepared)
        prepared = !pthread_atfork(NULL, NULL, free_in_child);
}

void gz_collide(context *c)
{
    enter_ode();
    find_contacts(c);
    carry_on(c);
    pthread_mutex_unlock(&ode_lock);
}

int gz_solve(context *c)
{
    int done;
    enter_ode();
    done = solve(c);
    pthread_mutex_unlock(&ode_lock);
    return done;
}

int gz_step(context *c)
{
    int done;
    if (rests(c)) {
        c->steps++;
        return 1;
    }
    enter_ode();
    find_contacts(c);
    done = solve(c);
    pthread_mutex_unlock(&ode_lock);
    return done;
}

/* Depth of the deepest contact point of two geoms; -1 without any, and if their collision detection fails. */
double gz_overlap(context *c, void *geom1, void *geom2)
{
    contact points[MOST_CONTACTS];
    double deepest = -1.0;
    int count, i;
    enter_ode();
    count = find_points(c, geom1, geom2, MAX_CONTACTS, points);
    for (i = 0; i < count; i++)
        deepest = larger(deepest, points[i].geom.depth);
    c->collision_failed = 0;
    pthread_mutex_unlock(&ode_lock);
    return deepest;
}

void gz_read(context *c)
{
    c->diverged = read_bodies(c, c->body_state, 0);
    read_joints(c, c->joint_state);
}

/* Tables for other processes ---------------------------------------------------------------------------------- */

/* Mirrored by Publication in context.py. */
typedef struct {
    char *target;             /* the mapped file */
    char *header;             /* what its first bytes are to be; they hold the sequence counter */
    int64_t header_size, sequence_offset, bodies_offset, joints_offset, fixed_offset;
    const double *fixed;      /* rows of bodies that ODE does not move, which follow the others */
    int64_t fixed_size;       /* [byte] */
    int64_t stale;            /* 1: some rows of the own tables are stale, so ODE is asked for all */
    int64_t copied;           /* 1: the tables there are those of a world at rest */
} publication;

/* Copy header and tables out. The counter is odd meanwhile. Own tables stay as they are, and nothing is read back. */
void gz_publish(const context *c, publication *p)
{
    uint64_t *own = (uint64_t *)(p->header + p->sequence_offset);
    _Atomic uint64_t *shared = (_Atomic uint64_t *)(p->target + p->sequence_offset);
    double *bodies = (double *)(p->target + p->bodies_offset), *joints = (double *)(p->target + p->joints_offset);
    atomic_store_explicit(shared, ++*own, memory_order_relaxed);
    atomic_thread_fence(memory_order_release);
    memcpy(p->target, p->header, (size_t)p->header_size);
    if (p->stale) {
        read_bodies(c, bodies, 0);
        read_joints(c, joints);
        p->copied = 0;
    } else if (c->resting < RESTING || !p->copied) {
        memcpy(bodies, c->body_state, (size_t)c->body_count * 16 * sizeof(double));
        memcpy(joints, c->joint_state, (size_t)c->joint_count * 4 * sizeof(double));
        p->copied = c->resting == RESTING;
    }
    memcpy(p->target + p->fixed_offset, p->fixed, (size_t)p->fixed_size);
    atomic_store_explicit(shared, ++*own, memory_order_release);
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
    int64_t count, capacity;
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
    if (g->count == g->capacity) {
        int64_t capacity = g->capacity ? 2 * g->capacity : 64;
        candidate *list = realloc(g->list, (size_t)capacity * sizeof(candidate));
        if (!list)
            return;
        g->list = list;
        g->capacity = capacity;
    }
    g->list[g->count].geom = geom;
    dGeomGetAABB(geom, g->list[g->count].box);
    g->count++;
}

/* Whether the segment start + t dir, 0 <= t <= length, meets the box enlarged by a small margin (the slab method). */
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
        double *start = world_rays + 6 * i, *dir = start + 3, from[3], to[3];
        int finite = 1;
        rotate(frame + 3, rays + 7 * i, start);
        rotate(frame + 3, rays + 7 * i + 3, dir);
        for (k = 0; k < 3; k++) {
            start[k] += frame[k];
            from[k] = start[k];
            to[k] = start[k] + rays[7 * i + 6] * dir[k];
            finite &= isfinite(from[k]) && isfinite(to[k]);
        }
        /* ODE's assertions fail on such numbers, and on a ray without a direction. */
        if (!finite || !(dir[0] || dir[1] || dir[2])) {
            start[0] = NAN;
            continue;
        }
        for (k = 0; k < 3; k++) {
            double a = from[k] < to[k] ? from[k] : to[k], b = from[k] < to[k] ? to[k] : from[k];
            if (a < low[k])
                low[k] = a;
            if (b > high[k])
                high[k] = b;
        }
    }
    if (low[0] > high[0]) { /* no ray is finite */
        free(world_rays);
        return;
    }
    dGeomBoxSetLengths(c->probe, high[0] - low[0] + 1e-6, high[1] - low[1] + 1e-6, high[2] - low[2] + 1e-6);
    dGeomSetPosition(c->probe, 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]));
    dSpaceCollide2(c->probe, c->space, &g, gather);

    for (i = 0; i < count; i++) {
        const double *start = world_rays + 6 * i, *dir = start + 3;
        double length = rays[7 * i + 6];
        int set = 0;
        if (isnan(start[0]))
            continue;
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
    pthread_mutex_unlock(&ode_lock);
}

/* States ----------------------------------------------------------------------------------------------------- */

enum { MOST_KINDS = 16 };

/* Offsets in ODE's objects; mirrored by Layout in memory.py, which finds and explains them. */
typedef struct {
    int64_t body_flags, body[2], damping[2], joint, joint_end[MOST_KINDS], geom_flags, geom, geom_end[MOST_KINDS];
    int64_t dirty, stale_place, stale_box;
} layout;

typedef struct {
    void *memory;
    int64_t size;
} block;

/* What a state is of; mirrored by Parts in parts.py. Bodies and joints are in order of construction, geoms by row (NULL:
 * one that touches nothing, or a free row), the top space is the first of the spaces. Blocks are rows of the tables. */
typedef struct {
    layout where;
    void *const *bodies;
    int64_t body_count;
    void *const *joints;
    int64_t joint_count;
    void *const *geoms;
    int64_t geom_count;
    void *const *spaces;
    int64_t space_count;
    const block *blocks;
    int64_t block_count;
} parts;

size_t gz_parts_size(void) { return sizeof(parts); }

/* What a state is copied to, or from; beyond its end it is only measured. */
typedef struct {
    unsigned char *bytes;
    int64_t size, at;
    int reading; /* 1: from the bytes into ODE's memory */
} tape;

/* ODE's memory, padded to words. */
static void copy(tape *t, void *object, int64_t begin, int64_t end)
{
    unsigned char *memory = (unsigned char *)object + begin;
    int64_t size = end - begin, padded = (size + 7) / 8 * 8;
    if (t->at + padded > t->size)
        ;
    else if (t->reading)
        memcpy(memory, t->bytes + t->at, (size_t)size);
    else {
        memset(t->bytes + t->at + size, 0, (size_t)(padded - size));
        memcpy(t->bytes + t->at, memory, (size_t)size);
    }
    t->at += padded;
}

static int64_t number(tape *t, int64_t value)
{
    copy(t, &value, 0, sizeof value);
    return value;
}

static uint32_t *marks(const parts *p, void *geom) { return (uint32_t *)((char *)geom + p->where.geom_flags); }

enum { POSR_SIZE = 16 * 8 }; /* a position and a rotation, as ODE keeps them */

static void copy_bodies(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->body_count; i++) {
        copy(t, p->bodies[i], p->where.body_flags, p->where.body_flags + 4);
        copy(t, p->bodies[i], p->where.body[0], p->where.body[1]);
        copy(t, p->bodies[i], p->where.damping[0], p->where.damping[1]);
    }
}

static void copy_joints(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->joint_count; i++)
        copy(t, p->joints[i], p->where.joint, p->where.joint_end[dJointGetType(p->joints[i])]);
}

/* Geoms: bits, lengths and place; the offset from the body, or where there is none the place itself. */
static void copy_geoms(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->geom_count; i++) {
        void *geom = p->geoms[i];
        int class;
        if (!geom)
            continue;
        class = dGeomGetClass(geom);
        copy(t, geom, p->where.geom, p->where.geom_end[class]);
        if (class == PLANE_CLASS)
            continue;
        if (!dGeomGetBody(geom))
            copy(t, (void *)dGeomGetPosition(geom), 0, POSR_SIZE);
        else if (dGeomIsOffset(geom))
            copy(t, (void *)dGeomGetOffsetPosition(geom), 0, POSR_SIZE);
        else
            t->at += POSR_SIZE;
    }
}

static void copy_blocks(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->block_count; i++)
        copy(t, p->blocks[i].memory, 0, p->blocks[i].size);
}

/* The marks of geoms, last of all. */
static void copy_marks(const parts *p, tape *t)
{
    int64_t i;
    for (i = 0; i < p->geom_count; i++)
        if (p->geoms[i])
            copy(t, marks(p, p->geoms[i]), 0, 4);
    for (i = 0; i < p->space_count; i++) {
        copy(t, marks(p, p->spaces[i]), 0, 4);
        copy(t, p->spaces[i], p->where.geom, p->where.geom + 16);
    }
}

/* A geom or space of the world as a number: its row, or ~ its index. */
static int64_t code(void *geom)
{
    int64_t value = (intptr_t)dGeomGetData(geom);
    return dGeomIsSpace(geom) ? ~value : value;
}

static void *coded(const parts *p, int64_t value)
{
    if (value < 0)
        return ~value < p->space_count ? p->spaces[~value] : NULL;
    return value < p->geom_count ? p->geoms[value] : NULL;
}

/* The order of geoms in every space, and on every body: from it follows the order of contacts. */
static void write_order(const parts *p, tape *t)
{
    int64_t i, count;
    int k;
    void *geom;
    for (i = 0; i < p->space_count; i++)
        dGeomSetData(p->spaces[i], (void *)(intptr_t)i);
    for (i = p->space_count - 1; i >= 0; i--) {
        count = number(t, dSpaceGetNumGeoms(p->spaces[i]));
        for (k = 0; k < count; k++)
            number(t, code(dSpaceGetGeom(p->spaces[i], k)));
    }
    for (i = 0; i < p->body_count; i++) {
        count = 0;
        for (geom = dBodyGetFirstGeom(p->bodies[i]); geom; geom = dBodyGetNextGeom(geom))
            count++;
        number(t, count);
        for (geom = dBodyGetFirstGeom(p->bodies[i]); geom; geom = dBodyGetNextGeom(geom))
            number(t, code(geom));
    }
}

/* Whether the geoms are in the spaces, and on the bodies, in which the state has them. */
static int fits(const parts *p, tape *t)
{
    int64_t i, k, count;
    void *geom;
    for (i = p->space_count - 1; i >= 0; i--) {
        count = number(t, 0);
        if (count != dSpaceGetNumGeoms(p->spaces[i]))
            return 0;
        for (k = 0; k < count; k++) {
            geom = coded(p, number(t, 0));
            if (!geom || dGeomGetSpace(geom) != p->spaces[i])
                return 0;
        }
    }
    for (i = 0; i < p->body_count; i++) {
        count = number(t, 0);
        for (geom = dBodyGetFirstGeom(p->bodies[i]); geom; geom = dBodyGetNextGeom(geom))
            count--;
        if (count)
            return 0;
        t->at -= 8;
        count = number(t, 0);
        for (k = 0; k < count; k++) {
            geom = coded(p, number(t, 0));
            if (!geom || dGeomGetBody(geom) != p->bodies[i])
                return 0;
        }
    }
    return 1;
}

/* Bring the geoms of a space into the order of the state. */
static void order_space(const parts *p, tape *t, void *space)
{
    int64_t count = number(t, 0), k;
    const int64_t *codes = (const int64_t *)(t->bytes + t->at);
    t->at += 8 * count;
    for (k = count - 1; k >= 0; k--) { /* each goes to the front */
        void *geom = coded(p, codes[k]);
        dSpaceRemove(space, geom);
        dSpaceAdd(space, geom);
    }
}

/* Bring all geoms into the order of the state. A space may move in its parent while it is
 * changed, so parents, which are older, come last, here and in the state. */
static void read_order(const parts *p, tape *t)
{
    const int64_t *codes;
    int64_t i, k, count;
    void *geom;
    for (i = p->space_count - 1; i >= 0; i--)
        order_space(p, t, p->spaces[i]);
    for (i = 0; i < p->body_count; i++) {
        count = number(t, 0);
        codes = (const int64_t *)(t->bytes + t->at);
        t->at += 8 * count;
        for (k = 0, geom = dBodyGetFirstGeom(p->bodies[i]); k < count && geom == coded(p, codes[k]); k++)
            geom = dBodyGetNextGeom(geom);
        for (k = k < count ? count - 1 : -1; k >= 0; k--) {
            geom = coded(p, codes[k]);
            dGeomSetBody(geom, NULL);
            dGeomSetBody(geom, p->bodies[i]);
            dGeomSetOffsetPosition(geom, 0.0, 0.0, 0.0);
        }
    }
}

/* Returns how many bytes a state has; if there are more than `size`, those written are none. */
int64_t gz_get_state(const parts *p, unsigned char *bytes, int64_t size)
{
    tape t = {bytes, size, 0, 0};
    enter_ode();
    write_order(p, &t);
    copy_bodies(p, &t);
    copy_joints(p, &t);
    copy_geoms(p, &t);
    copy_blocks(p, &t);
    copy_marks(p, &t);
    pthread_mutex_unlock(&ode_lock);
    return t.at;
}

/* Returns 0, and has changed nothing, if a geom is not where the state has it, or the state has another size. */
int gz_set_state(const parts *p, unsigned char *bytes, int64_t size)
{
    tape t = {bytes, size, 0, 1};
    double box[6];
    int64_t i;
    int done;
    if (gz_get_state(p, NULL, 0) != size)
        return 0;
    enter_ode();
    done = fits(p, &t);
    if (done) {
        t.at = 0;
        read_order(p, &t);
        copy_bodies(p, &t);
        copy_joints(p, &t);
        copy_geoms(p, &t);
        copy_blocks(p, &t);
        for (i = 0; i < p->geom_count; i++)
            if (p->geoms[i])
                *marks(p, p->geoms[i]) |= (uint32_t)(p->where.dirty | p->where.stale_box |
                                                     (dGeomGetBody(p->geoms[i]) ? p->where.stale_place : 0));
        for (i = 0; i < p->space_count; i++)
            *marks(p, p->spaces[i]) |= (uint32_t)(p->where.dirty | p->where.stale_box);
        dSpaceClean(p->spaces[0]);
        for (i = 0; i < p->geom_count; i++)
            if (p->geoms[i])
                dGeomGetAABB(p->geoms[i], box);
        copy_marks(p, &t);
    }
    pthread_mutex_unlock(&ode_lock);
    return done;
}
