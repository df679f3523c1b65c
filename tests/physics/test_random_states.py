"""States of worlds made at random, of all that an engine has, with changes at random after the state was saved."""

import math
import random

import pytest
from engine_parts import box, cylinder, ground, solid, use_classic

import libgz
from libgz.physics.couplings import PistonJoint
from libgz.physics.engine import Engine
from libgz.physics.space import Space

STEPS = 120
KINDS = (
    libgz.HingeJoint,
    libgz.SliderJoint,
    libgz.BallJoint,
    libgz.FixedJoint,
    libgz.UniversalJoint,
    libgz.Hinge2Joint,
    PistonJoint,
)


def capsule(body, space):
    return libgz.CapsuleGeom(body, space, 0.1, 0.3)


def sphere(body, space):
    return libgz.SphereGeom(body, space, 0.2)


def mesh(body, space):
    corners = [(0, 0, 0), (0.3, 0, 0), (0, 0.3, 0), (0, 0, 0.3)]
    return libgz.TriMeshGeom(body, space, corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])


class RandomWorld:
    """An engine with bodies and joints, and what may happen to them."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.engine = Engine(
            seed=seed, solver=self.random.choice(["quick", "world"]), step_time=self.random.choice([0.002, 0.01, 0.02])
        )
        if self.random.random() < 0.5:
            use_classic(self.engine)
        self.engine.record_contacts = self.random.random() < 0.5
        self.make_ground()
        self.bodies = [self.make_body(i) for i in range(self.random.randint(2, 12))]
        for _ in range(self.random.randint(0, 5)):
            self.make_joint()

    def make_ground(self):
        body, kind = libgz.Body(self.engine, dummy=True), self.random.choice(["plane", "mesh", "field"])
        if kind == "plane":
            ground(self.engine)
        elif kind == "field":
            libgz.HeightfieldGeom(body, Space(self.engine), [[0, 0.1, 0], [0.2, 0, 0.1], [0, 0, 0.3]], 20, 20)
        else:
            corners = [(-20, -20, 0), (20, -20, 0.3), (20, 20, 0), (-20, 20, 0.2)]
            libgz.TriMeshGeom(body, Space(self.engine), corners, [(0, 1, 2), (0, 2, 3)])

    def make_body(self, i):
        chance = self.random.random
        make = self.random.choice([box(0.3, 0.2, 0.4), cylinder, sphere, capsule, mesh])
        place = (self.random.uniform(-0.6, 0.6), self.random.uniform(-0.6, 0.6), 0.4 + 0.4 * i)
        body = solid(self.engine, make, mass=self.random.uniform(0.2, 3), position=place, friction=chance())
        if chance() < 0.3:
            libgz.BoxGeom(body, Space(self.engine), 0.1, 0.1, 0.1).SetRelativePosition((0.2, 0, 0))
        body.set_auto_disable(chance() < 0.4)
        body.SetGravityMode(chance() < 0.9)
        body.set_kinematic(chance() < 0.1)
        if chance() < 0.2:
            body.set_damping(0.01, 0.02)
        return body

    def make_joint(self):
        kind, (one, two) = self.random.choice(KINDS), self.random.sample(self.bodies, 2)
        joint = kind(self.engine, name=f"joint {len(self.engine.joints)}")
        joint.Attach(one, two)
        self.aim(joint)
        joint.provide_feedback(self.random.random() < 0.5)
        self.drive(joint)

    def aim(self, joint):
        body = joint.bodies[0]
        if body is None:
            return
        joint.SetAnchor(body.GetPosition())
        slope = self.random.uniform(-1, 1)
        if isinstance(joint, (libgz.HingeJoint, PistonJoint)):
            joint.SetAxis((slope, 1, 0))
        elif isinstance(joint, libgz.SliderJoint):
            joint.SetAxis(slope, 1, 0)
        elif isinstance(joint, libgz.FixedJoint):
            joint.SetFixed()

    def drive(self, joint):
        if joint.motors:
            joint.SetParam(libgz.dParamVel, self.random.uniform(-20, 20))
            joint.SetParam(libgz.dParamFMax, self.random.uniform(0, 5))
        if isinstance(joint, libgz.HingeJoint):
            joint.SetParam(libgz.dParamLoStop, self.random.choice([-0.5, -math.inf]))
            joint.SetParam(libgz.dParamHiStop, self.random.choice([0.5, math.inf]))
            joint.set_spring(self.random.uniform(0, 5), self.random.uniform(0, 0.1), self.random.uniform(-1, 1))

    def change(self):
        """A few changes at random."""
        for _ in range(self.random.randint(1, 6)):
            self.random.choice(self.changes())()

    def changes(self):
        """What may happen to a body and a joint."""
        engine, pick = self.engine, self.random
        body, joint = pick.choice(self.bodies), pick.choice(list(engine.joints.values()) or [None])
        changes = [
            self.make_joint,
            lambda: solid(engine, sphere, position=(0, 0, pick.uniform(1, 5))),
            lambda: sphere(body, body.geoms[0].space).SetRelativePosition((0, 0, 0.2)),
            lambda: body.geoms[0].SetMass(7.0),
            lambda: body.geoms[0].SetCollideBits(0),
            lambda: body.geoms[0].SetFriction(0.1),
            lambda: body.SetPosition((1, 1, pick.uniform(1, 3))),
            lambda: body.AddTorque(1, 2, 3),
            lambda: body.set_kinematic(not body.kinematic),
            lambda: body.SetGravityMode(not body.GetGravityMode()),
            lambda: body.set_auto_disable(not body.auto_disable),
            lambda: setattr(engine, "gravity", (0, 1, -3)),
            lambda: setattr(engine, "count_turns", not engine.count_turns),
            engine.extend_range,
        ]
        if joint is not None:
            changes += [
                lambda: self.aim(joint),
                lambda: self.drive(joint),
                lambda: joint.Attach(*pick.sample(self.bodies, 2)),
                joint.Detach,
            ]
        if isinstance(body.geoms[0], libgz.TriMeshGeom):
            changes.append(lambda: body.geoms[0].set_mesh(2 * body.geoms[0].vertices, body.geoms[0].triangles))
        return changes

    def run(self):
        """The states after each of some steps with commands."""
        found = []
        for i in range(STEPS):
            if i % 7 == 0:
                self.bodies[0].AddForce(0.2 * i, 0, 1)
            if i % 11 == 0:
                self.bodies[-1].SetPosition((0, 0.1 * (i % 5), 1.5))
            self.engine.step()
            rows = [body.row for body in self.engine.bodies.values()]
            found.append((self.engine.states[rows].tobytes(), self.engine.contacts.tobytes(), self.engine.seed))
        return found


@pytest.mark.parametrize("seed", range(8))
def test_the_same_follows(seed):
    world = RandomWorld(seed)
    world.run()
    if seed % 2:
        world.change()
    state = world.engine.get_state()
    first, end = world.run(), world.engine.get_state()
    for _ in range(2):
        world.change()
        for _ in range(world.random.randint(0, 20)):
            world.engine.step()
        world.engine.set_state(state)
        assert world.engine.get_state() == state
        for i, (one, two) in enumerate(zip(first, world.run(), strict=True)):
            assert one == two, f"step {i}"
        assert world.engine.get_state() == end


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_equal_worlds_have_equal_states(seed):
    def state():
        world = RandomWorld(seed)
        world.run()
        return world.engine.get_state()

    assert state() == state()
