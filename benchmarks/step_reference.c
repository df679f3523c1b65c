/* The yardstick of step.py: the same world and the same ODE calls in bare C.
 *
 *   cc -O2 step_reference.c -l:libode.so.8 -lm -o step_reference && ./step_reference ROBOTS STEPS
 *
 * prints microseconds a step. ODE's headers are not needed: what is called is declared here.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <math.h>
#include <time.h>

typedef void *id;
typedef struct { int mode; double mu, mu2, rho, rho2, rhoN, bounce, bounce_vel, erp, cfm, m1, m2, mN, s1, s2; } surface;
typedef struct { double pos[4], normal[4], depth; id g1, g2; int side1, side2; } point;
typedef struct { surface surface; point geom; double fdir1[4]; } contact;
typedef struct { double mass, c[4], I[12]; } mass;

int dInitODE2(unsigned);
id dWorldCreate(void), dHashSpaceCreate(id), dSimpleSpaceCreate(id), dJointGroupCreate(int), dBodyCreate(id);
id dCreatePlane(id, double, double, double, double), dCreateBox(id, double, double, double), dCreateCylinder(id, double, double);
id dJointCreateHinge(id, id), dJointCreateContact(id, id, const contact *), dGeomGetBody(id);
void dWorldSetGravity(id, double, double, double), dGeomSetBody(id, id), dGeomSetData(id, void *);
void *dGeomGetData(id);
void dMassSetBox(mass *, double, double, double, double), dMassSetCylinder(mass *, double, int, double, double);
void dBodySetQuaternion(id, const double *);
void dMassAdjust(mass *, double), dBodySetMass(id, const mass *), dBodySetPosition(id, double, double, double);
void dJointAttach(id, id, id), dJointSetHingeAnchor(id, double, double, double), dJointSetHingeAxis(id, double, double, double);
void dJointSetHingeParam(id, int, double), dJointGroupEmpty(id);
void dSpaceCollide(id, void *, void (*)(void *, id, id)), dSpaceCollide2(id, id, void *, void (*)(void *, id, id));
int dCollide(id, id, int, point *, int), dGeomIsSpace(id), dAreConnectedExcluding(id, id, int), dWorldStep(id, double);
const double *dBodyGetPosition(id), *dBodyGetQuaternion(id), *dBodyGetLinearVel(id), *dBodyGetAngularVel(id);
double dJointGetHingeAngle(id), dJointGetHingeAngleRate(id);

enum { VEL = 2, FMAX = 5, CONTACT = 4 };
static id world, contacts, bodies[6000], joints[6000];
static double surfaces[6000][3], states[6000][13], angles[6000][2];
static int body_count, joint_count, geom_count;

static void near(void *data, id a, id b)
{
    contact c[10];
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
    n = dCollide(a, b, 10, &c[0].geom, sizeof(contact));
    for (i = 0; i < n; i++) {
        const double *s = surfaces[(intptr_t)dGeomGetData(a)], *t = surfaces[(intptr_t)dGeomGetData(b)];
        double softness = 1 / s[0] + 1 / t[0], spring = 0.01 / softness, kd = s[1] + t[1];
        c[i].surface.mode = 0x3018;
        c[i].surface.mu = s[2] < t[2] ? s[2] : t[2];
        c[i].surface.erp = spring / (spring + kd);
        c[i].surface.cfm = 1 / (spring + kd);
        dJointAttach(dJointCreateContact(world, contacts, &c[i]), one, two);
    }
}

static void surface_of(id geom, double kp, double mu)
{
    surfaces[geom_count][0] = kp;
    surfaces[geom_count][1] = 0;
    surfaces[geom_count][2] = mu;
    dGeomSetData(geom, (void *)(intptr_t)geom_count++);
}

static id body_at(id geom, const mass *m, double x, double y, double z, double kp)
{
    id body = bodies[body_count++] = dBodyCreate(world);
    dBodySetMass(body, m);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, x, y, z);
    surface_of(geom, kp, 1);
    return body;
}

int main(int argc, char **argv)
{
    int robots = argc > 1 ? atoi(argv[1]) : 1, steps = argc > 2 ? atoi(argv[2]) : 1000, i, k, w;
    struct timespec begin, end;
    const double on_its_side[4] = {0.70710678118654757, 0.70710678118654757, 0, 0};
    id top, ground;
    mass m;

    dInitODE2(0);
    world = dWorldCreate();
    top = dHashSpaceCreate(NULL);
    contacts = dJointGroupCreate(0);
    dWorldSetGravity(world, 0, 0, -9.8);
    ground = dSimpleSpaceCreate(top);
    surface_of(dCreatePlane(ground, 0, 0, 1, 0), INFINITY, 1);
    for (i = 0; i < robots; i++) {
        double x = 2.0 * (i % 10), y = 2.0 * (i / 10);
        id space = dSimpleSpaceCreate(top), chassis;
        dMassSetBox(&m, 1, 0.5, 0.35, 0.2);
        dMassAdjust(&m, 10);
        chassis = body_at(dCreateBox(space, 0.5, 0.35, 0.2), &m, x, y, 0.2, 1e4);
        for (w = 0; w < 4; w++) {
            double wx = x + (w < 2 ? 0.13 : -0.13), wy = y + (w % 2 ? -0.19 : 0.19);
            id wheel, hinge;
            dMassSetCylinder(&m, 1, 3, 0.1, 0.05);
            dMassAdjust(&m, 1);
            wheel = body_at(dCreateCylinder(space, 0.1, 0.05), &m, wx, wy, 0.1, 1e4);
            dBodySetQuaternion(wheel, on_its_side);
            hinge = joints[joint_count++] = dJointCreateHinge(world, NULL);
            dJointAttach(hinge, wheel, chassis);
            dJointSetHingeAnchor(hinge, wx, wy, 0.1);
            dJointSetHingeAxis(hinge, 0, 1, 0);
            dJointSetHingeParam(hinge, VEL, 1);
            dJointSetHingeParam(hinge, FMAX, 10);
        }
        space = dSimpleSpaceCreate(top);
        dMassSetBox(&m, 1, 0.3, 0.3, 0.3);
        dMassAdjust(&m, 1);
        body_at(dCreateBox(space, 0.3, 0.3, 0.3), &m, x + 1, y + 1, 0.15, 1e6);
    }
    for (k = -200; k < steps; k++) {
        if (k == 0)
            clock_gettime(CLOCK_MONOTONIC, &begin);
        dSpaceCollide(top, NULL, near);
        dWorldStep(world, 0.01);
        dJointGroupEmpty(contacts);
        for (i = 0; i < body_count; i++) {
            const double *p = dBodyGetPosition(bodies[i]), *q = dBodyGetQuaternion(bodies[i]);
            const double *v = dBodyGetLinearVel(bodies[i]), *o = dBodyGetAngularVel(bodies[i]);
            double *s = states[i];
            s[0] = p[0], s[1] = p[1], s[2] = p[2], s[3] = q[0], s[4] = q[1], s[5] = q[2], s[6] = q[3];
            s[7] = v[0], s[8] = v[1], s[9] = v[2], s[10] = o[0], s[11] = o[1], s[12] = o[2];
        }
        for (i = 0; i < joint_count; i++) {
            angles[i][0] = dJointGetHingeAngle(joints[i]);
            angles[i][1] = dJointGetHingeAngleRate(joints[i]);
        }
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    printf("%.3f %.12f\n", ((end.tv_sec - begin.tv_sec) * 1e9 + (end.tv_nsec - begin.tv_nsec)) / 1e3 / steps, states[0][0]);
    return 0;
}
