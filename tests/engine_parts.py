"""Parts of an engine's world for tests: ground, solids, makers of geoms."""

import math

import libgz
from libgz.ode.types import ContactRule
from libgz.physics.space import Space

G = 9.8
INF = math.inf


def use_classic(engine):
    """Set the engine as SDF worlds do."""
    engine.contact_rule = ContactRule.CLASSIC
    engine.count_turns = engine.check_divergence = True


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
