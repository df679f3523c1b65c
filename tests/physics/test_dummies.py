"""Dummies that are put at poses together are where each would be alone."""

import ctypes
import math

import numpy as np
import pytest

import libgz
from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPose, GzQuatern, GzQuaternFromAxis, GzVector
from libgz.ode.lib import ode
from libgz.physics.body import Body, place_dummies
from libgz.physics.geoms import BoxGeom, CylinderGeom, SphereGeom


@pytest.fixture
def world():
    with libgz.World() as world:
        yield world


def limbs(world, count=4):
    """Dummies with geoms: at the body's frame, beside it, and one that ODE turns."""
    bodies = []
    for i in range(count):
        body = Body(world, f"b{i}", dummy=True)
        SphereGeom(body, world.engine.top, 0.1)
        box = BoxGeom(body, world.engine.top, 0.1, 0.2, 0.3)
        box.SetRelativePose(GzPose(GzVector(0.3, 0.0, -0.1), GzQuaternFromAxis(1.0, 2.0, 0.0, 0.4)))
        CylinderGeom(body, world.engine.top, 0.1, 0.2)
        bodies.append(body)
    return bodies


def places(bodies):
    """Of bodies, and of their geoms in ODE."""
    turn = (ctypes.c_double * 4)()
    found = []
    for body in bodies:
        found.append(body.frame())
        for geom in body.geoms:
            ode().dGeomGetQuaternion(geom.id, turn)
            found.append([*geom.bounds()[0], *geom.bounds()[1], *turn])
    return found


def poses(count, scale=1.0):
    """Arbitrary ones; quaternions are not quite of length 1."""
    random = np.random.default_rng(5)
    return random.normal(size=(count, 3)) * scale, random.normal(size=(count, 4))


@pytest.mark.parametrize("scale", [1.0, 1e7])
@pytest.mark.parametrize("length", [1.0, 1e-3])
def test_they_are_where_each_would_be_put_alone(world, scale, length):
    positions, rotations = poses(4, scale)
    rotations *= length / np.linalg.norm(rotations, axis=1, keepdims=True)
    alone, together = limbs(world), limbs(world)
    for body, position, rotation in zip(alone, positions.tolist(), rotations.tolist(), strict=True):
        body.SetPose(GzPose(GzVector(*position), GzQuatern(*rotation)))
    world.engine.moved_dummies.clear()
    before = world.engine.tables.record.changes
    place_dummies(world.engine, together, positions, rotations)
    assert places(together) == places(alone)
    assert set(together) <= world.engine.moved_dummies
    assert world.engine.tables.record.changes > before


def test_whole_numbers_are_places_too(world):
    bodies, turns = limbs(world), np.tile((1.0, 0.0, 0.0, 0.0), (4, 1))
    place_dummies(world.engine, bodies, np.arange(12).reshape(4, 3), turns)
    found = places(bodies)
    place_dummies(world.engine, bodies, np.arange(12.0).reshape(4, 3), turns)
    assert places(bodies) == found


@pytest.mark.parametrize("wrong", [math.nan, math.inf])
def test_what_is_not_finite_is_refused(world, wrong):
    bodies = limbs(world)
    positions, rotations = poses(4)
    positions[2, 1] = wrong
    with pytest.raises(ParameterError, match="position"):
        place_dummies(world.engine, bodies, positions, rotations)
    positions[2, 1], rotations[3] = 0.0, wrong
    with pytest.raises(ParameterError, match="rotation"):
        place_dummies(world.engine, bodies, positions, rotations)


def test_who_sleeps_on_them_wakes(world):
    ground, box = limbs(world, 1), Body(world, "box")
    BoxGeom(box, world.engine.top, 1.0, 1.0, 1.0)
    box.SetPosition((0.0, 0.0, 9.0))
    box.set_auto_disable(True)
    world.Initialize()
    world.Step()
    box.Enable(False)
    assert not box.IsEnabled()
    place_dummies(world.engine, ground, np.array([[0.0, 0.0, 8.9]]), poses(1)[1])
    world.Step()
    assert box.IsEnabled()
