"""Parts of an engine's world for tests: ground, solids, makers of geoms."""

import math

import numpy as np

import libgz
from libgz.ode.types import ContactRule, Surface
from libgz.physics.engine import Engine
from libgz.physics.space import Space

G = 9.8
INF = math.inf


def use_classic(engine):
    """Set the engine as SDF worlds do."""
    engine.contact_rule = ContactRule.CLASSIC
    engine.exact_rest = engine.count_turns = True


def ground(engine, friction=1.0):
    body, space = libgz.Body(engine, dummy=True), Space(engine)
    space.set_fixed()
    plane = libgz.PlaneGeom(body, space, 0.0, (0, 0, 1))
    plane.SetHardness(INF, 0)
    plane.SetFriction(friction)
    return plane


def solid(engine, make, mass=1.0, position=(0, 0, 0), friction=1.0, kp=1e6, kd=0.0):
    body = libgz.Body(engine)
    geom = make(body, Space(engine))
    geom.SetMass(mass)
    geom.SetFriction(friction)
    geom.SetHardness(kp, kd)
    body.SetPosition(position)
    return body


def box(*size):
    return lambda body, space: libgz.BoxGeom(body, space, *size)


def cylinder(body, space):
    return libgz.CylinderGeom(body, space, 0.2, 0.5)


def dress(geom, mu=1.0, mu2=None, fdir1=(0, 0, 0), **more):
    """Set contact properties, by default those of a collision in SDF."""
    for name, value in {"KP": 1e12, "KD": 1.0, "MAX_VEL": 0.01, "BOUNCE_VEL": 1e5, **more}.items():
        geom.set_surface(Surface[name], value)
    geom.SetFriction(mu, mu2)
    for i, value in enumerate(fdir1):
        geom.set_surface(Surface.FDIR1 + i, value)
    return geom


def dressed_ground(engine, **surface):
    plane = libgz.PlaneGeom(libgz.Body(engine, dummy=True), Space(engine), 0.0, (0, 0, 1))
    return dress(plane, **surface)


def dressed_box(engine, position, mass=1.0, height=1.0, **surface):
    body = libgz.Body(engine)
    geom = libgz.BoxGeom(body, Space(engine), 1, 1, height)
    geom.SetMass(mass)
    body.SetPosition(position)
    return dress(geom, **surface)


def busy_world():
    engine = Engine(seed=7, solver="quick")
    ground(engine)
    generator = np.random.default_rng(3)
    makers = (
        box(0.3, 0.2, 0.4),
        cylinder,
        lambda b, s: libgz.SphereGeom(b, s, 0.2),
        lambda b, s: libgz.CapsuleGeom(b, s, 0.1, 0.3),
    )
    bodies = [
        solid(engine, makers[i % 4], position=(*generator.uniform(-0.5, 0.5, 2), 0.5 + 0.5 * i), friction=0.7)
        for i in range(16)
    ]
    for one, two in zip(bodies[::4], bodies[1::4], strict=True):
        hinge = libgz.HingeJoint(engine)
        hinge.Attach(one, two)
        hinge.SetAnchor(one.GetPosition())
        hinge.SetAxis((0, 1, 0))
    return engine


def unsolvable():
    """A world whose steps ODE cannot solve, and the body whose rotation is the cause."""
    engine = Engine(gravity=(0, 0, 0))
    one, two = (solid(engine, box(0.1, 0.1, 0.1), position=(x, 0, 0)) for x in (0, 1))
    joint = libgz.UniversalJoint(engine)
    joint.Attach(one, two)
    joint.SetAxes((0, 0, 1), (0, 1, 0))
    two.SetRotation((0.5, 0.5, 0.5, 0.5))  # y to z, which brings the axes together
    return engine, two
