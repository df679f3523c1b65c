/* What others are compared with: a scene stepped by a plain C program with the same calls of ODE.
 *
 *   cc -O2 reference.c -l:libode.so.8 -lm -o reference && ./reference < scene
 *
 * reference.py writes the scene: `end` closes it. Each number n that follows runs n steps, and prints real time and
 * processor time [s], and where body 0 is [m]. ODE's headers are not needed: what is called is declared here.
 */
#define _GNU_SOURCE
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ipc.h>
#include <sys/mman.h>
#include <sys/sem.h>
#include <time.h>
#include <unistd.h>

typedef void *id;
typedef struct { int mode; double mu, mu2, rho, rho2, rhoN, bounce, bounce_vel, erp, cfm, m1, m2, mN, s1, s2; } surface;
typedef struct { double pos[4], normal[4], depth; id g1, g2; int side1, side2; } point;
typedef struct { surface surface; point geom; double fdir1[4]; } contact;
typedef struct { double mass, c[4], I[12]; } mass;
typedef void near_callback(void *, id, id);

int dInitODE2(unsigned), dCollide(id, id, int, point *, int), dGeomIsSpace(id), dAreConnectedExcluding(id, id, int);
int dWorldStep(id, double), dJointGetType(id);
id dWorldCreate(void), dHashSpaceCreate(id), dSimpleSpaceCreate(id), dJointGroupCreate(int), dBodyCreate(id);
id dCreatePlane(id, double, double, double, double), dCreateBox(id, double, double, double), dCreateSphere(id, double);
id dCreateCylinder(id, double, double), dCreateCapsule(id, double, double), dCreateRay(id, double);
id dJointCreateHinge(id, id), dJointCreateSlider(id, id), dJointCreateFixed(id, id);
id dJointCreateContact(id, id, const contact *), dGeomGetBody(id);
void dWorldSetGravity(id, double, double, double), dGeomSetBody(id, id), dGeomSetData(id, void *), *dGeomGetData(id);
void dGeomSetPosition(id, double, double, double), dGeomSetQuaternion(id, const double *);
void dGeomSetOffsetPosition(id, double, double, double), dGeomSetOffsetQuaternion(id, const double *);
void dBodySetMass(id, const mass *), dBodySetPosition(id, double, double, double);
void dBodySetQuaternion(id, const double *), dBodySetLinearVel(id, double, double, double);
void dBodySetAngularVel(id, double, double, double), dBodySetGravityMode(id, int), dBodySetFiniteRotationMode(id, int);
void dJointAttach(id, id, id), dJointSetHingeAnchor(id, double, double, double);
void dJointSetHingeAxis(id, double, double, double), dJointSetHingeParam(id, int, double);
void dJointSetSliderAxis(id, double, double, double), dJointSetSliderParam(id, int, double), dJointSetFixed(id);
void dJointGroupEmpty(id), dSpaceCollide(id, void *, near_callback *), dSpaceClean(id);
void dSpaceCollide2(id, id, void *, near_callback *);
void dGeomRaySet(id, double, double, double, double, double, double), dGeomRaySetLength(id, double);
const double *dBodyGetPosition(id), *dBodyGetQuaternion(id), *dBodyGetLinearVel(id), *dBodyGetAngularVel(id);
double dJointGetHingeAngle(id), dJointGetHingeAngleRate(id), dJointGetSliderPosition(id), dJointGetSliderPositionRate(id);

enum { CONTACT = 4, HINGE = 2, SLIDER = 3, MOST_CONTACTS = 10, VELOCITY = 2, SEMAPHORES = 16, MOST = 40000 };

typedef struct { double kp, kd, mu, bounce; } material;
typedef struct { int joint; double target, gain, damping, from; } servo;
typedef struct { int body, count; double *rays, *ranges; } cast;
typedef struct { char kind; int offset, count, stride; double far, near, add, smooth; int *first, *second; double *share; } writing;
typedef struct { char *memory; int file, count; writing *writings; const cast *cast; } share;
typedef struct { char kind; int period; cast cast; share share; } action; /* d: due, c: cast, w: share, p: post */

static id world, top, contacts, ray, spaces[MOST], bodies[MOST], joints[MOST];
static material materials[MOST];
static servo servos[MOST];
static action actions[MOST];
static double states[MOST][13], angles[MOST][2], h, now;
static int space_count, body_count, joint_count, geom_count, servo_count, action_count, advance_at, set = -1;
static long steps;

static double number(void)
{
    char text[64];
    if (scanf("%63s", text) != 1)
        exit(1);
    return strtod(text, NULL);
}

static int whole(void) { return (int)number(); }

static double *numbers(int count)
{
    double *list = malloc((size_t)(count + 1) * sizeof *list);
    int i;
    for (i = 0; i < count; i++)
        list[i] = number();
    return list;
}

static int *wholes(int count)
{
    int *list = malloc((size_t)(count + 1) * sizeof *list), i;
    for (i = 0; i < count; i++)
        list[i] = whole();
    return list;
}

/* The scene --------------------------------------------------------------------------------------------------- */

static void read_body(void)
{
    id body = bodies[body_count++] = dBodyCreate(world);
    double *p = numbers(3), *q = numbers(4), *v = numbers(3), *w = numbers(3);
    mass m = {0};
    int i;
    m.mass = number();
    for (i = 0; i < 12; i++)
        m.I[i] = number();
    dBodySetMass(body, &m);
    dBodySetPosition(body, p[0], p[1], p[2]);
    dBodySetQuaternion(body, q);
    dBodySetLinearVel(body, v[0], v[1], v[2]);
    dBodySetAngularVel(body, w[0], w[1], w[2]);
    dBodySetGravityMode(body, whole());
    dBodySetFiniteRotationMode(body, whole());
}

static void read_geom(void)
{
    char kind[16];
    id space, geom = NULL;
    double *d, *p, *q;
    int body;
    if (scanf("%15s", kind) != 1)
        exit(1);
    space = spaces[whole()];
    body = whole();
    d = numbers(4);
    switch (kind[0]) {
    case 'p': geom = dCreatePlane(space, d[0], d[1], d[2], d[3]); break;
    case 'b': geom = dCreateBox(space, d[0], d[1], d[2]); break;
    case 's': geom = dCreateSphere(space, d[0]); break;
    case 'c': geom = kind[1] == 'y' ? dCreateCylinder(space, d[0], d[1]) : dCreateCapsule(space, d[0], d[1]); break;
    default: exit(1);
    }
    p = numbers(3);
    q = numbers(4);
    if (body >= 0) {
        dGeomSetBody(geom, bodies[body]);
        dGeomSetOffsetPosition(geom, p[0], p[1], p[2]);
        dGeomSetOffsetQuaternion(geom, q);
    } else if (kind[0] != 'p') {
        dGeomSetPosition(geom, p[0], p[1], p[2]);
        dGeomSetQuaternion(geom, q);
    }
    materials[geom_count] = (material){number(), number(), number(), number()};
    dGeomSetData(geom, (void *)(intptr_t)geom_count++);
}

static void read_joint(void)
{
    int type = whole(), one = whole(), two = whole(), count, i;
    double *anchor = numbers(3), *axis = numbers(4);
    id joint = type == HINGE ? dJointCreateHinge(world, NULL)
               : type == SLIDER ? dJointCreateSlider(world, NULL) : dJointCreateFixed(world, NULL);
    joints[joint_count++] = joint;
    dJointAttach(joint, one < 0 ? NULL : bodies[one], two < 0 ? NULL : bodies[two]);
    if (type == HINGE) {
        dJointSetHingeAnchor(joint, anchor[0], anchor[1], anchor[2]);
        dJointSetHingeAxis(joint, axis[0], axis[1], axis[2]);
    } else if (type == SLIDER)
        dJointSetSliderAxis(joint, axis[0], axis[1], axis[2]);
    else
        dJointSetFixed(joint);
    count = whole();
    for (i = 0; i < count; i++) {
        int parameter = whole();
        (type == SLIDER ? dJointSetSliderParam : dJointSetHingeParam)(joint, parameter, number());
    }
}

static cast read_cast(void)
{
    cast c = {whole(), whole(), NULL, NULL};
    c.rays = numbers(7 * c.count);
    c.ranges = malloc((size_t)c.count * sizeof(double));
    return c;
}

static share read_share(const cast *last)
{
    int size = whole(), locked = whole(), i;
    share s = {NULL, -1, 0, NULL, last};
    char name[] = "/tmp/referenceXXXXXX";
    if (locked) {
        s.file = mkstemp(name);
        unlink(name);
        if (ftruncate(s.file, size))
            exit(1);
    }
    s.memory = mmap(NULL, (size_t)size, PROT_READ | PROT_WRITE, locked ? MAP_SHARED : MAP_PRIVATE | MAP_ANONYMOUS, s.file, 0);
    s.count = whole();
    s.writings = calloc((size_t)s.count + 1, sizeof(writing));
    for (i = 0; i < s.count; i++) {
        writing *w = s.writings + i;
        if (scanf(" %c", &w->kind) != 1)
            exit(1);
        w->offset = whole();
        w->count = whole();
        w->stride = whole();
        w->far = number();
        if (w->kind == 's') {
            w->near = number();
            w->add = number();
            w->smooth = number();
            w->first = wholes(w->count);
            w->second = wholes(w->count);
            w->share = numbers(w->count);
        }
    }
    return s;
}

static void read_scene(void)
{
    char word[16];
    const cast *last = NULL;
    int i;
    while (scanf("%15s", word) == 1 && strcmp(word, "end")) {
        action *a = actions + action_count;
        if (!strcmp(word, "world")) {
            double *g;
            h = number();
            g = numbers(3);
            dWorldSetGravity(world, g[0], g[1], g[2]);
        } else if (!strcmp(word, "space"))
            spaces[space_count++] = dSimpleSpaceCreate(top);
        else if (!strcmp(word, "body"))
            read_body();
        else if (!strcmp(word, "geom"))
            read_geom();
        else if (!strcmp(word, "joint"))
            read_joint();
        else if (!strcmp(word, "servo")) {
            servo *s = servos + servo_count++;
            *s = (servo){whole(), number(), number(), number(), 0.0};
            s->from = number();
        } else if (!strcmp(word, "advance"))
            advance_at = action_count;
        else {
            a->kind = word[0];
            action_count++;
            if (word[0] == 'd')
                a->period = whole();
            else if (word[0] == 'c') {
                a->cast = read_cast();
                last = &a->cast;
            } else if (word[0] == 'w')
                a->share = read_share(last);
            else if (set < 0)
                set = semget(IPC_PRIVATE, SEMAPHORES, 0600 | IPC_CREAT);
        }
    }
    dSpaceClean(top);
    for (i = 0; i < body_count; i++) {
        const double *p = dBodyGetPosition(bodies[i]);
        dBodySetPosition(bodies[i], p[0], p[1], p[2]);
    }
}

/* A step ------------------------------------------------------------------------------------------------------ */

static void near(void *data, id a, id b)
{
    contact c[MOST_CONTACTS];
    id one, two;
    int n, i;
    if (dGeomIsSpace(a) || dGeomIsSpace(b)) {
        dSpaceCollide2(a, b, data, near);
        return;
    }
    one = dGeomGetBody(a);
    two = dGeomGetBody(b);
    if ((!one && !two) || (one && two && dAreConnectedExcluding(one, two, CONTACT)))
        return;
    n = dCollide(a, b, MOST_CONTACTS, &c[0].geom, sizeof(contact));
    for (i = 0; i < n; i++) {
        const material *s = materials + (intptr_t)dGeomGetData(a), *t = materials + (intptr_t)dGeomGetData(b);
        double softness = 1 / s->kp + 1 / t->kp, spring = h * (1 / softness), kd = s->kd + t->kd;
        memset(&c[i].surface, 0, sizeof c[i].surface);
        c[i].surface.mode = 0x3018;
        c[i].surface.mu = s->mu < t->mu ? s->mu : t->mu;
        c[i].surface.erp = softness > 0 ? spring / (spring + kd) : 1;
        c[i].surface.cfm = softness > 0 ? 1 / (spring + kd) : 0;
        c[i].surface.bounce = s->bounce > t->bounce ? s->bounce : t->bounce;
        c[i].surface.mode |= c[i].surface.bounce > 0 ? 4 : 0;
        dJointAttach(dJointCreateContact(world, contacts, &c[i]), one, two);
    }
}

static void rotate(const double *q, const double *v, double *out)
{
    double x = 2 * (q[2] * v[2] - q[3] * v[1]), y = 2 * (q[3] * v[0] - q[1] * v[2]), z = 2 * (q[1] * v[1] - q[2] * v[0]);
    out[0] = v[0] + q[0] * x + q[2] * z - q[3] * y;
    out[1] = v[1] + q[0] * y + q[3] * x - q[1] * z;
    out[2] = v[2] + q[0] * z + q[1] * y - q[2] * x;
}

typedef struct { id owner; double range; } hit;

static void ray_hits(void *data, id a, id b)
{
    hit *found = data;
    id other = a == ray ? b : a;
    point p;
    if (dGeomIsSpace(other))
        dSpaceCollide2(ray, other, data, ray_hits);
    else if ((!found->owner || dGeomGetBody(other) != found->owner) && dCollide(ray, other, 1, &p, sizeof p) && p.depth < found->range)
        found->range = p.depth;
}

static void cast_rays(cast *c)
{
    id body = bodies[c->body];
    const double *p = dBodyGetPosition(body), *q = dBodyGetQuaternion(body);
    int i;
    for (i = 0; i < c->count; i++) {
        const double *r = c->rays + 7 * i;
        double start[3], direction[3];
        hit found = {body, DBL_MAX};
        rotate(q, r, start);
        rotate(q, r + 3, direction);
        dGeomRaySetLength(ray, r[6]);
        dGeomRaySet(ray, p[0] + start[0], p[1] + start[1], p[2] + start[2], direction[0], direction[1], direction[2]);
        dSpaceCollide2(ray, top, &found, ray_hits);
        c->ranges[i] = found.range;
    }
}

static double distance(const writing *w, double range) { return (range < w->far ? range : w->far) + w->near; }

static void write_numbers(const writing *w, char *memory, const cast *c)
{
    static const double zero;
    int i;
    for (i = 0; i < w->count; i++) {
        char *to = memory + w->offset + w->stride * i;
        double value = zero, a, b;
        switch (w->kind) {
        case 'i': memcpy(to, &zero, sizeof(int)); continue;
        case 'n': value = now; break;
        case 'r': value = c->ranges[i] < w->far ? c->ranges[i] : w->far; break;
        case 's':
            a = distance(w, c->ranges[w->first[i]]);
            b = distance(w, c->ranges[w->second[i]]);
            value = fabs(a - b) < w->smooth ? (1 - w->share[i]) * a + w->share[i] * b : a < b ? a : b;
            value += w->add;
        }
        memcpy(to, &value, sizeof value);
    }
}

static void exchange(const share *s)
{
    int i;
    if (s->file >= 0)
        flock(s->file, LOCK_EX | LOCK_NB);
    for (i = 0; i < s->count; i++)
        write_numbers(s->writings + i, s->memory, s->cast);
    if (s->file >= 0)
        flock(s->file, LOCK_UN);
}

static void post(void)
{
    static unsigned short ones[SEMAPHORES] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    semctl(set, 0, SETALL, ones);
}

static void act(int begin, int end)
{
    int i, due = 1;
    for (i = begin; i < end; i++) {
        action *a = actions + i;
        if (a->kind == 'd')
            due = !a->period || steps % a->period == 0;
        else if (!due)
            continue;
        else if (a->kind == 'c')
            cast_rays(&a->cast);
        else if (a->kind == 'w')
            exchange(&a->share);
        else
            post();
    }
}

static void step(void)
{
    int i;
    act(0, advance_at);
    for (i = 0; i < servo_count; i++) {
        const servo *s = servos + i;
        double rate = s->gain * (s->target - (angles[s->joint][0] + s->from)) - s->damping * angles[s->joint][1];
        dJointSetHingeParam(joints[s->joint], VELOCITY, rate);
    }
    dSpaceCollide(top, NULL, near);
    dWorldStep(world, h);
    dJointGroupEmpty(contacts);
    for (i = 0; i < body_count; i++) {
        double *s = states[i];
        memcpy(s, dBodyGetPosition(bodies[i]), 3 * sizeof(double));
        memcpy(s + 3, dBodyGetQuaternion(bodies[i]), 4 * sizeof(double));
        memcpy(s + 7, dBodyGetLinearVel(bodies[i]), 3 * sizeof(double));
        memcpy(s + 10, dBodyGetAngularVel(bodies[i]), 3 * sizeof(double));
    }
    for (i = 0; i < joint_count; i++) {
        int type = dJointGetType(joints[i]);
        if (type == HINGE) {
            angles[i][0] = dJointGetHingeAngle(joints[i]);
            angles[i][1] = dJointGetHingeAngleRate(joints[i]);
        } else if (type == SLIDER) {
            angles[i][0] = dJointGetSliderPosition(joints[i]);
            angles[i][1] = dJointGetSliderPositionRate(joints[i]);
        }
    }
    steps++;
    now += h;
    act(advance_at, action_count);
}

static double clock_of(clockid_t kind)
{
    struct timespec t;
    clock_gettime(kind, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(void)
{
    long count, i;
    dInitODE2(0);
    world = dWorldCreate();
    top = dHashSpaceCreate(NULL);
    contacts = dJointGroupCreate(0);
    ray = dCreateRay(NULL, 1);
    read_scene();
    while (scanf("%ld", &count) == 1) {
        double wall = clock_of(CLOCK_MONOTONIC), cpu = clock_of(CLOCK_PROCESS_CPUTIME_ID);
        for (i = 0; i < count; i++)
            step();
        wall = clock_of(CLOCK_MONOTONIC) - wall;
        cpu = clock_of(CLOCK_PROCESS_CPUTIME_ID) - cpu;
        printf("%.9f %.9f %.12f %.12f %.12f\n", wall, cpu, states[0][0], states[0][1], states[0][2]);
        fflush(stdout);
    }
    if (set >= 0)
        semctl(set, 0, IPC_RMID);
    return 0;
}
