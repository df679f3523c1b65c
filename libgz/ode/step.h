/* What the parts of the step share: ODE's types and functions, the context, and small vectors. */

#ifndef LIBGZ_ODE_STEP_H
#define LIBGZ_ODE_STEP_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include "calls.h" /* the queue of ODE's calls */
#include "resting.h"

/* ODE -------------------------------------------------------------------------------------------------------- */

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
    X(void, dGeomSetQuaternion, (void *, const double *))                       \
    X(void, dGeomSetData, (void *, void *))                                     \
    X(void, dGeomSetBody, (void *, void *))                                     \
    X(void *, dGeomGetSpace, (void *))                                          \
    X(int, dGeomIsOffset, (void *))                                             \
    X(const double *, dGeomGetOffsetPosition, (void *))                         \
    X(void, dGeomSetOffsetPosition, (void *, double, double, double))           \
    X(void, dGeomEnable, (void *))                                              \
    X(void, dGeomDisable, (void *))                                             \
    X(int, dGeomIsEnabled, (void *))                                            \
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
    X(void, dJointEnable, (void *))                                             \
    X(int, dJointIsEnabled, (void *))                                           \
    X(feedback *, dJointGetFeedback, (void *))                                  \
    X(int, dBodyGetNumJoints, (void *))                                         \
    X(void *, dBodyGetJoint, (void *, int))                                     \
    X(int, dBodyGetGyroscopicMode, (void *))                                    \
    X(int, dBodyGetFiniteRotationMode, (void *))                                \
    X(double, dBodyGetLinearDamping, (void *))                                  \
    X(double, dBodyGetAngularDamping, (void *))                                 \
    X(double, dBodyGetMaxAngularSpeed, (void *))                                \
    X(double, dWorldGetERP, (void *))                                           \
    X(const double *, dBodyGetRotation, (void *))                               \
    X(const double *, dBodyGetPosition, (void *))                               \
    X(const double *, dBodyGetQuaternion, (void *))                             \
    X(const double *, dBodyGetLinearVel, (void *))                              \
    X(const double *, dBodyGetAngularVel, (void *))                             \
    X(const double *, dBodyGetForce, (void *))                                  \
    X(void, dBodySetPosition, (void *, double, double, double))                 \
    X(void, dBodySetQuaternion, (void *, const double *))                       \
    X(void, dBodySetLinearVel, (void *, double, double, double))                \
    X(void, dBodySetAngularVel, (void *, double, double, double))               \
    X(void, dBodySetForce, (void *, double, double, double))                    \
    X(void, dBodySetTorque, (void *, double, double, double))                   \
    X(const double *, dBodyGetTorque, (void *))                                 \
    X(double, dJointGetHingeAngle, (void *))                                    \
    X(double, dJointGetHingeAngleRate, (void *))                                \
    X(void, dJointAddHingeTorque, (void *, double))                             \
    X(void, dJointAddSliderForce, (void *, double))                             \
    X(double, dJointGetHingeParam, (void *, int))                               \
    X(void, dJointSetHingeParam, (void *, int, double))                         \
    X(double, dJointGetSliderParam, (void *, int))                              \
    X(void, dJointSetSliderParam, (void *, int, double))                        \
    X(double, dJointGetUniversalParam, (void *, int))                           \
    X(void, dJointSetUniversalParam, (void *, int, double))                     \
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

#ifdef __GNUC__
#pragma GCC visibility push(hidden) /* the names are those of ODE, and of the C library */
#endif

#define DECLARE(result, name, arguments) extern result(*name) arguments;
ODE_FUNCTIONS(DECLARE)

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
extern __thread jump escape;
extern __thread int guarded; /* 1: failed assertions jump to `escape` */

/* The context ------------------------------------------------------------------------------------------------- */

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

/* A height field, whose heights rays read themselves; ODE's collider looks at all cells in the box of a ray. */
typedef struct {
    void *geom;
    const double *heights;  /* [m] rows along its y, columns along its x */
    int64_t rows, columns;  /* two at least */
    double width, length;   /* [m] along x and y */
} height_field;

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
    double softness;  /* [m/N], of what its spring corrects in this step */
    double yielding;  /* [1/kg] to what weighs on it */
    double share;     /* of the shift, found by iteration */
} overlap_record;

/* Mirrored by StepContext in context.py; gz_step_context_size() guards against drift. */
typedef struct {
    void *joint;
    int64_t type;     /* JOINT_HINGE or JOINT_SLIDER */
    double effort;    /* [N m or N] */
    int64_t wakes;    /* 1: its bodies, if they may sleep */
} held_effort;

typedef struct {
    void *world, *space, *contacts, *ray, *probe, *stand_in;
    int64_t no_cylinder_pairs; /* 1: boxes stand in for a cylinder against cylinders and capsules */
    double step;
    int64_t solver;           /* EXACT, QUICK or TREE */
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
    int64_t resting;          /* steps in a row, at most 2, after which no body was awake; 0 after any change from outside */
    int64_t next_checked;     /* body that is looked at next while all rest */
    int64_t point_count, point_capacity;
    touch_point *points;      /* of the touches */
    int64_t earlier_count, earlier_capacity;
    contact_record *earlier;  /* the records of the step before */
    int64_t held_count;
    const held_effort *held;  /* applied in each step, for as long as they are there */
    struct workspace *work;
    int64_t alone;            /* not 0: others leave ODE to this world while it collides */
    int64_t iterating;        /* 1: it has ODE's random numbers */
    int64_t explicit_gyroscopic; /* 1: the step adds gyroscopic torques, and ODE's bodies are in the mode without */
    int64_t field_count;
    const height_field *fields;
} context;

enum { LEGACY_RULE = 0, CLASSIC_RULE = 1 };
enum { EXACT, QUICK, TREE }; /* dWorldStep, dWorldQuickStep, tree.c; as SOLVERS in context.py */

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

/* After a step that began and ended without a body awake, the next one changes nothing; springs act on sleeping bodies. */
enum { RESTING = 2, CHECKED = 64 };

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
    double damper;   /* softness of the damper of what is rigid [s/kg] */
    double erp, cfm; /* of a point whose springs are no rigid surface, without max_vel; else 1 and 0 */
} touching;

/* A body as a member of an island. */
typedef struct {
    int64_t root; /* the member that stands for the island, or one that is nearer to it */
    int64_t rows; /* of the solver, in the root's */
    int fast;     /* 1: a body of the island is, in the root's */
    int touching; /* 1: the island has contacts, in the root's */
    int joined;   /* 1: it has joints, in the root's */
    int quick;    /* 1: to be solved by iteration */
    int solved;   /* 1: by resting.c or tree.c, -1: a part of it could not be, in the root's */
    int aside;    /* 1: the body was awake and is disabled for a part of the step */
    int64_t next;               /* body of the island, or -1 */
    int64_t first, last;        /* body of the island, in the root's; -1 before it has any */
    int64_t touch, last_touch;  /* first and last touch of the island, in the root's; -1 without any */
    int64_t place;              /* among the island's bodies; -1: it has none yet */
    double fallen;              /* its position along gravity [m^2/s^2] */
} member;

enum { EXACT_ROWS = 150 }; /* of the solver, of islands that are small */

/* Bodies that joints connect, and that are set apart together; see overlaps.c. */
typedef struct {
    double mass;     /* [kg] of all its bodies; 0: it does not move */
    double shift[3]; /* [m] */
} group;

/* A joint that is far beyond a stop; see stops.c. */
typedef struct {
    void *joint;
    int64_t type; /* JOINT_HINGE, JOINT_SLIDER or JOINT_UNIVERSAL */
    int axis;     /* SECOND of a universal joint, or 0 */
    double erp;  /* of its stops */
    double slow; /* with which they send it back at the largest speed, or at none */
} far_stop;

/* A body in a step that is solved twice. */
typedef struct {
    double position[3], quaternion[4], linear[3], angular[3], force[3], torque[3];
} kept_body;

/* Memory of the step of a world, which is kept from step to step; memory.c frees it. */
struct workspace {
    call_queue calls;
    member *members; /* by row of body, like the next two */
    group *groups;   /* by the row of a body that stands for the group */
    char *held;      /* 1: a joint connects the body with the world */
    int64_t *ranked; /* rows of an island's bodies, by place */
    resting_body *resting_bodies;
    resting_point *resting_points;
    int64_t member_capacity, group_capacity, held_capacity, ranked_capacity;
    int64_t resting_body_capacity, resting_point_capacity;
    resting_memory resting;
    double (*movable_boxes)[6];
    void **far; /* geoms and spaces that are left out of the search for pairs */
    int64_t movable_capacity, far_capacity, far_count;
    struct trees *trees;
    int stepped; /* 1: ODE has the memory of its own step */
    far_stop *stops;
    kept_body *kept_bodies; /* by row */
    int64_t stop_count, stop_capacity, kept_capacity;
};

static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }

static inline double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* A vector in the frame of a geom or body, as a global one. */
static inline void to_global(const double *rotation, const double *local, double *global)
{
    int k;
    for (k = 0; k < 3; k++)
        global[k] = rotation[4 * k] * local[0] + rotation[4 * k + 1] * local[1] + rotation[4 * k + 2] * local[2];
}

static inline int is_awake(void *body) { return body && dBodyIsEnabled(body); }

/* Whether small calm islands are solved exactly. */
static inline int solves_islands(const context *c)
{
    return c->exact_rest && c->solver == QUICK && c->contact_rule == CLASSIC_RULE;
}

/* v rotated by the quaternion q; the same operations in the same order as libgz.base.geometry.rotate. */
static inline void rotate(const double *q, const double *v, double *out)
{
    double tx = 2.0 * (q[2] * v[2] - q[3] * v[1]);
    double ty = 2.0 * (q[3] * v[0] - q[1] * v[2]);
    double tz = 2.0 * (q[1] * v[1] - q[2] * v[0]);
    out[0] = v[0] + q[0] * tx + (q[2] * tz - q[3] * ty);
    out[1] = v[1] + q[0] * ty + (q[3] * tx - q[1] * tz);
    out[2] = v[2] + q[0] * tz + (q[1] * ty - q[2] * tx);
}

static inline int64_t row_of(void *body) { return body ? (int64_t)(intptr_t)dBodyGetData(body) : -1; }

static inline int64_t root_of(member *members, int64_t i)
{
    while (members[i].root != i)
        i = members[i].root = members[members[i].root].root;
    return i;
}

/* locking.c */
void enter_ode(const context *c);
void leave_ode(void);
void let_others_in(const context *c);
void begin_iterations(context *c);
void end_iterations(context *c);

/* collision.c */
int collide_pair(context *c, void *geom1, void *geom2, int most, contact_geom *points, int skip);
int find_points(context *c, void *geom1, void *geom2, int most, contact *points);

/* surfaces.c */
void make_surface(const context *c, const double *a, const double *b, surface_parameters *s);
void set_limits(const context *c, touching *t);
void choose_direction(const context *c, touching *t);
void make_rigid(const context *c, touching *t, surface_parameters *s);
void vary(const context *c, touching *t, contact *point);
void refine_point(const context *c, touching *t, int count, double found, contact *point);
void default_direction(const double *n, double *one);
void find_held(const context *c);
int is_calm(const context *c, void *body);

/* statics.c */
void leave_out_far(context *c);
int may_meet(const context *c);
void bring_back_far(const context *c);

/* contacts.c */
void find_contacts(context *c);

/* contact_records.c */
void begin_records(context *c);
void record_point(context *c, const contact *point, void *geom1, void *geom2, void *joint);
void request_feedback(context *c);
void carry_on(context *c);
void collect_feedback(context *c);

/* motion.c */
void gz_wake(void *body, int always);
int64_t read_bodies(const context *c, double *state, int stepped);
void read_joints(const context *c, double *state);
void apply_springs(context *c);
void begin_motion(context *c);
void add_gyroscopic_torques(context *c);

/* islands.c */
member alone(int64_t row, int fast);
int have_members(const context *c);
void unite(const context *c, int64_t one, int64_t two, int64_t rows, int touching);
void set_body_aside(const context *c, int64_t row);
void bring_back(const context *c);
int move_bodies(context *c);

/* resting_islands.c */
void solve_resting(context *c);

/* tree.c */
int have_trees(const context *c);
int waits_for_tree(const context *c, int64_t row);
int solve_tree(const context *c, int64_t row);
void release_trees(const context *c);
void recover_trees(const context *c);
void free_trees(struct trees *w);

/* stops.c */
int move_from_stops(context *c);
void restore_stops(context *c);

/* overlaps.c */
void note_overlap(context *c, const touching *t, const contact *point);
void set_apart(const context *c);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
