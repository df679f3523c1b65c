"""Random islands: bodies in chains, trees and loops, with motors, limits and contacts, alike in two engines."""

import numpy as np
from engine_parts import box, ground, solid

import libgz
from libgz.ode.types import dParamFMax, dParamHiStop, dParamLoStop, dParamVel
from libgz.physics.engine import Engine

KINDS = (libgz.HingeJoint, libgz.SliderJoint, libgz.BallJoint, libgz.UniversalJoint, libgz.FixedJoint)


def _join(engine, random, one, two, place):
    kind = KINDS[random.choice(5, p=(0.5, 0.15, 0.15, 0.1, 0.1))]
    axis, low, high, fmax, speed = random.normal(size=3), *random.uniform(0.2, 1.0, 2), *random.uniform(0.0, 5.0, 2)
    motor, stop = random.random(2) < (0.4, 0.3)
    made = kind(engine)
    made.Attach(one, two)
    if kind is libgz.FixedJoint:
        made.SetFixed()
    elif kind is libgz.UniversalJoint:
        made.SetAnchor(place)
        made.SetAxes(axis, np.cross(axis, (0.3, -0.7, 0.5)))
    elif kind is libgz.BallJoint:
        made.SetAnchor(place)
    else:
        made.SetAxis(axis)
        if kind is libgz.HingeJoint:
            made.SetAnchor(place)
        if motor:
            made.SetParam(dParamVel, speed)
            made.SetParam(dParamFMax, fmax)
        if stop:
            made.SetParam(dParamLoStop, -low)
            made.SetParam(dParamHiStop, high)
    return made


def island(seed, solver, *, loops=False):
    """An engine with an island, above the ground or partly in it; its bodies and joints."""
    random = np.random.default_rng(seed)
    engine = Engine(step_time=float(random.choice((0.001, 0.005, 0.02))), solver=solver)
    if random.random() < 0.5:
        ground(engine, friction=float(random.choice((0.0, 0.5, 1.0))))
    count = int(random.integers(2, 13))
    height = random.uniform(0.15, 1.0)
    bodies = []
    for _ in range(count):
        place = random.uniform((-0.6, -0.6, height), (0.6, 0.6, height + 1.2))
        bodies.append(
            solid(
                engine,
                box(*random.uniform(0.05, 0.3, 3)),
                float(random.uniform(0.2, 3.0)),
                tuple(place),
                kp=1e5,
                kd=1e3,
            )
        )
        bodies[-1].SetLinearVel(tuple(random.normal(size=3)))
        bodies[-1].SetAngularVel(tuple(random.normal(size=3)))
    joints = []
    for i in range(1, count):
        other = bodies[i - 1 if random.random() < 0.5 else int(random.integers(0, i))]
        joints.append(_join(engine, random, bodies[i], other, tuple(bodies[i].GetPosition())))
    if random.random() < 0.3:
        joints.append(_join(engine, random, bodies[0], None, tuple(bodies[0].GetPosition())))
    for _ in range(int(random.integers(1, 3)) if loops else 0):
        one, two = random.choice(count, 2, replace=False)
        joints.append(_join(engine, random, bodies[one], bodies[two], tuple(bodies[one].GetPosition())))
    return engine, bodies, joints
