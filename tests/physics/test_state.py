"""States of engines: what follows after `set_state` is the same to the bit as what followed after `get_state`."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from engine_parts import box, busy_world, cylinder, ground, solid, use_classic

import libgz
from libgz.base.errors import StateError
from libgz.base.geometry import GzPose, GzVector
from libgz.ode.types import Surface, dParamFMax, dParamHiStop, dParamLoStop, dParamVel
from libgz.physics.couplings import Gears, PistonJoint, Thread
from libgz.physics.engine import Engine
from libgz.physics.space import Space
from libgz.simulation.state import decode, encode

STEPS = 300


def seen(engine):
    """All that can be seen of an engine after a step."""
    bodies, joints = engine.bodies.values(), engine.joints.values()
    rates = [joint._value(column) for joint in joints if any(joint.bodies) for column in range(4)]
    return (
        engine.states[[body.row for body in bodies]].tobytes(),
        np.array(rates).tobytes(),
        engine.contacts.tobytes(),
        tuple(body.IsEnabled() for body in bodies),
        repr([joint.feedback for joint in joints]),
        (engine.contact_count, engine.seed, engine.steps),
    )


def run(engine, command=None, steps=STEPS):
    """What is seen in each of so many steps; `command(i)` is called before each."""
    found = []
    for i in range(steps):
        if command is not None:
            command(i)
        engine.step()
        found.append(seen(engine))
    return found


def check(engine, command=None, change=None, before=STEPS):
    """Run, save, run, change, restore: the same steps follow, and the same state is found, at once and at the end."""
    run(engine, command, before)
    state = engine.get_state()
    assert engine.get_state() == state
    first, end = run(engine, command), engine.get_state()
    if change is not None:
        change()
        run(engine, steps=5)
    engine.set_state(state)
    assert engine.get_state() == state
    for i, (one, two) in enumerate(zip(first, run(engine, command), strict=True)):
        assert one == two, f"step {i}"
    assert engine.get_state() == end
    assert first[0] != first[-1]
    return state


def pile(solver, classic):
    engine = Engine(seed=5, solver=solver, step_time=0.005)
    if classic:
        use_classic(engine)
    engine.record_contacts = True
    ground(engine)
    makers = (box(0.3, 0.2, 0.4), cylinder, lambda b, s: libgz.SphereGeom(b, s, 0.2))
    places = np.random.default_rng(1).uniform(-0.4, 0.4, (12, 2))
    for i, (x, y) in enumerate(places):
        solid(engine, makers[i % 3], position=(x, y, 0.4 + 0.45 * i), friction=0.6)
    return engine


@pytest.mark.parametrize("classic", [False, True])
@pytest.mark.parametrize("solver", ["world", "quick"])
def test_a_pile_in_mid_fall(solver, classic):
    check(pile(solver, classic), before=100)


def test_joints_in_motion():
    engine = busy_world()
    bodies = list(engine.bodies.values())
    check(engine, command=lambda i: bodies[i % 16].AddForce(0.0, 3.0, 5.0))


@pytest.mark.parametrize("awake", [0.3, 0.9, 3.0])
def test_bodies_awake_half_way_to_sleep_and_asleep(awake):
    engine = Engine(step_time=0.005)
    use_classic(engine)
    ground(engine)
    bodies = [solid(engine, box(0.4, 0.4, 0.4), position=(i, 0, 0.2 + 0.002 * i)) for i in range(4)]
    falling = solid(engine, box(0.2, 0.2, 0.2), position=(1, 0, 3 + 5 * awake * awake))
    for body in [*bodies, falling]:
        body.set_auto_disable(True)
    run(engine, steps=int(awake / 0.005))
    state, asleep = engine.get_state(), [body.IsEnabled() for body in bodies]
    first = run(engine, steps=900)
    assert any(not all(step[3]) for step in first)  # some fall asleep
    engine.set_state(state)
    assert [body.IsEnabled() for body in bodies] == asleep
    assert run(engine, steps=900) == first


def hinged(engine, **parameters):
    one, two = (solid(engine, box(0.2, 0.2, 0.6), position=(0, 0, z)) for z in (2.0, 2.6))
    joint = libgz.HingeJoint(engine, name="hinge")
    joint.Attach(one, two)
    joint.SetAnchor((0, 0, 2.3))
    joint.SetAxis((0, 1, 0))
    for name, value in parameters.items():
        joint.SetParam(getattr(libgz, name), value)
    return joint


def test_a_hinge_that_has_turned_more_than_once():
    engine = Engine(gravity=(0, 0, 0), step_time=0.005)
    use_classic(engine)
    joint = hinged(engine, dParamVel=15.0, dParamFMax=50.0)
    joint.provide_feedback(True)
    run(engine, steps=300)
    state, angle = engine.get_state(), joint.GetAngle()
    assert abs(angle) > 2 * math.tau
    first = run(engine)
    joint.SetParam(dParamVel, -15.0)
    run(engine, steps=700)
    assert abs(joint.GetAngle() - angle) > math.tau
    engine.set_state(state)
    assert (joint.GetAngle(), joint.GetParam(dParamVel)) == (angle, 15.0)
    assert run(engine) == first


def test_stops_springs_and_motors_that_were_changed():
    engine = Engine(step_time=0.005)
    ground(engine)
    joint = hinged(engine, dParamLoStop=-0.5, dParamHiStop=0.5)
    joint.set_spring(2.0, 0.1, 0.3)

    def change():
        joint.SetParam(dParamLoStop, -math.inf)
        joint.SetParam(dParamHiStop, math.inf)
        joint.SetParam(dParamVel, 3.0)
        joint.SetParam(dParamFMax, 7.0)
        joint.set_spring(0.0, 0.0)

    check(engine, change=change, before=30)
    assert (joint.GetParam(dParamLoStop), joint.GetParam(dParamFMax)) == (-0.5, 0.0)


def test_anchors_and_bodies_of_joints_that_were_changed():
    engine = Engine(seed=3, solver="quick", step_time=0.01)
    ground(engine)
    bodies = [solid(engine, box(0.3, 0.3, 0.3), position=(0.5 * i, 0, 1.0)) for i in range(5)]
    kinds = (libgz.HingeJoint, libgz.BallJoint, libgz.UniversalJoint, libgz.Hinge2Joint)
    joints = []
    for i, kind in enumerate(kinds):
        joints.append(kind(engine))
        joints[-1].Attach(bodies[i], bodies[i + 1])
        joints[-1].SetAnchor((0.5 * i + 0.25, 0, 1.0))

    def change():
        for joint in joints:
            joint.SetAnchor((0, 0, 3))
        joints[0].SetAxis((1, 1, 0))
        joints[1].Attach(bodies[4], bodies[0])
        joints[0].Detach()

    check(engine, change=change, before=40)
    assert joints[1].bodies == (bodies[1], bodies[2])
    assert list(bodies[1].joints) == joints[:2]


def test_what_was_made_since_is_closed():
    engine = busy_world()
    run(engine, steps=50)
    state = engine.get_state()
    counts = [len(things) for things in (engine.bodies, engine.geoms, engine.joints, engine.spaces, engine.dummies)]
    first = run(engine)
    one = next(iter(engine.bodies.values()))
    added = solid(engine, box(0.5, 0.5, 0.5), position=(0, 0, 1))
    geom = libgz.SphereGeom(one, one.geoms[0].space, 0.3)
    ground(engine)
    joint = libgz.HingeJoint(engine)
    joint.Attach(one, added)
    run(engine, steps=5)
    engine.set_state(state)
    assert all(thing.closed for thing in (added, geom, joint))
    present = [len(things) for things in (engine.bodies, engine.geoms, engine.joints, engine.spaces, engine.dummies)]
    assert present == counts
    assert run(engine) == first


def test_properties_of_bodies_and_geoms_that_were_changed():
    engine = pile("world", classic=True)
    bodies = list(engine.bodies.values())
    plane = next(iter(engine.geoms.values()))

    def change():
        bodies[0].set_kinematic(True)
        bodies[1].SetGravityMode(False)
        bodies[2].set_damping(0.5, 0.5)
        bodies[3].geoms[0].resize(0.6, 0.6, 0.6)
        bodies[4].geoms[0].resize(0.6, 0.6)
        bodies[5].geoms[0].resize(0.5)
        bodies[6].geoms[0].SetRelativePose(GzPose(GzVector(0.1, 0, 0)))
        bodies[7].geoms[0].SetMass(20.0)
        bodies[8].geoms[0].SetCollideBits(0)
        bodies[9].geoms[0].SetFriction(0.0)
        bodies[10].set_auto_disable(True)
        bodies[11].geoms[0].SetColor(libgz.GzColor(1, 0, 0))
        plane.set_surface(Surface.KP, 1e3)
        plane.space.set_bits(0, 0)
        engine.gravity = (0, 3, -1)
        engine.step_time = 0.02
        engine.solver = "quick"
        engine.set_quick_step(5, 1.0)
        engine.set_constraints(0.5, 1e-3, 1.0)
        engine.extend_range()
        engine.max_contacts = 2

    sizes = [vars(body.geoms[0]).copy() for body in bodies]
    check(engine, change=change, before=60)
    for body, size in zip(bodies, sizes, strict=True):
        for name in ("size", "radius", "length", "_relative"):
            assert vars(body.geoms[0]).get(name) == size.get(name)
    assert bodies[7].mass == 1.0
    assert not bodies[0].kinematic
    assert bodies[11].geoms[0].GetDiffuseColor() == libgz.GzColor(0.8, 0.8, 0.8)


def test_a_mesh_that_was_replaced():
    engine = Engine(step_time=0.01)
    corners, sides = np.array([(-9, -9, 0), (9, -9, 0), (9, 9, 0.5), (-9, 9, 0)], float), [(0, 1, 2), (0, 2, 3)]
    mesh = libgz.TriMeshGeom(libgz.Body(engine, dummy=True), Space(engine), corners, sides)
    solid(engine, box(0.3, 0.3, 0.3), position=(0, 0, 1))
    check(engine, change=lambda: mesh.set_mesh(2 * corners, sides), before=20)
    assert (mesh.vertices == corners).all()


def test_static_geoms_that_moved_with_a_dummy():
    engine = Engine(step_time=0.01)
    step = libgz.Body(engine, dummy=True)
    libgz.BoxGeom(step, Space(engine), 4, 4, 0.2)
    solid(engine, box(0.3, 0.3, 0.3), position=(0, 0, 1))
    check(engine, command=lambda i: step.SetPosition((0, 0, 0.001 * i)), change=lambda: step.SetPosition((9, 9, 9)))


def test_parts_of_spaces():
    engine = Engine(seed=1, step_time=0.01)
    walls, outer = libgz.Body(engine, dummy=True), Space(engine)
    for i in range(3):
        inner = Space(engine, parent=outer)
        for j in range(3):
            libgz.BoxGeom(walls, inner, 1, 1, 0.2).SetRelativePosition((i - 1, j - 1, 0))
    for i in range(5):
        solid(engine, box(0.3, 0.2, 0.4), position=(0.1 * i, 0, 1 + 0.5 * i))
    check(engine, change=lambda: walls.SetPosition((0, 0, 0.1)), before=70)


def test_poses_that_were_set_just_before():
    """Geoms that moved since collisions were searched keep their place in the order when they move again."""
    engine = pile("world", classic=False)
    bodies = list(engine.bodies.values())
    run(engine, steps=60)
    for body in bodies[::2]:
        body.Enable(False)
    run(engine, steps=20)
    bodies[4].SetPosition((0, 0, 1))
    state = engine.get_state()

    def follow():
        for index in (5, 4, 2, 0):
            bodies[index].SetPosition((0.05 * index, 0, 1.2 + 0.1 * index))
        return run(engine)

    first = follow()
    engine.set_state(state)
    assert follow() == first


def geared(engine, solver):
    engine.solver = solver
    use_classic(engine)
    ground(engine)
    wheels = [solid(engine, cylinder, position=(x, 0, 3)) for x in (0, 1)]
    for wheel in wheels:
        hinge = libgz.HingeJoint(engine)
        hinge.Attach(wheel, None)
        hinge.SetAnchor(wheel.GetPosition())
        hinge.SetAxis((0, 0, 1))
    gears = Gears(engine, tuple(wheels), (GzVector(0, 0, 1), GzVector(0, 0, 1)), 2.0)
    bolt = solid(engine, cylinder, position=(3, 0, 3))
    piston = PistonJoint(engine, name="piston")
    piston.Attach(bolt, None)
    piston.SetAnchor((3, 0, 3))
    piston.SetAxis((0, 0, 1))
    return wheels, gears, Thread(piston, 4.0)


@pytest.mark.parametrize("solver", ["world", "quick"])
def test_gears_and_threads(solver):
    engine = Engine(step_time=0.002)
    wheels, gears, thread = geared(engine, solver)

    def command(i):
        wheels[0].AddTorque(0, 0, 0.1)
        gears.update(engine.step_time)
        thread.update()

    def change():
        gears.set_ratio(-3.0)
        thread.pitch = 9.0

    check(engine, command=command, change=change, before=50)
    assert (gears.ratio, thread.pitch) == (2.0, 4.0)
    for endless in ([0.0, math.inf], [-math.inf, 0.0]):
        state = engine.get_state()
        state["couplings"][0][1][Gears.SAVED.index("angles")] = endless
        with pytest.raises(StateError, match="a screw or gear has numbers that none has"):
            engine.set_state(state)


def test_motion_records():
    engine = pile("world", classic=True)
    engine.record_motion = True
    run(engine, steps=50)
    body = next(iter(engine.bodies.values()))
    state, acceleration = engine.get_state(), body.GetLinearAccel()
    run(engine, steps=30)
    engine.set_state(state)
    assert body.GetLinearAccel() == acceleration != GzVector()


def test_missing_objects_are_named_before_anything_changes():
    engine = Engine()
    ground(engine)
    bodies = [solid(engine, box(1, 1, 1), position=(2 * i, 0, 2)) for i in range(3)]
    bodies[1].bodyName = "lost"
    state = engine.get_state()
    run(engine, steps=10)
    bodies[1].close()
    before = engine.get_state()
    with pytest.raises(StateError, match=r"body 'lost', BoxGeom of body 'lost'"):
        engine.set_state(state)
    assert engine.get_state() == before


def test_objects_that_were_made_again_take_the_place_of_the_old_ones():
    """As when a model was deleted and inserted again: rows differ, results do not."""

    def build():
        engine = Engine(seed=1, solver="quick")
        use_classic(engine)
        engine.record_contacts = True
        ground(engine)
        return engine

    def fill(engine, count):
        return [solid(engine, box(0.4, 0.3, 0.2), position=(0.1 * i, 0, 0.4 + 0.4 * i)) for i in range(count)]

    first = build()
    fill(first, 6)
    run(first, steps=40)
    state = first.get_state()
    followed = run(first)
    second = build()
    gone = fill(second, 3)
    run(second, steps=10)
    gone[1].close()
    gone[0].close()
    gone[2].close()
    for space in list(second.spaces)[1:]:
        space.close()
    fill(second, 6)
    second.set_state(state)
    assert second.get_state() == state
    assert run(second) == followed


@pytest.mark.parametrize("solver", ["quick", "world"])
def test_bodies_that_were_made_in_another_order(solver):
    """As links of plugins, in a world that was built again: ODE solves bodies in the order in which it made them."""

    def chain(order):
        engine = Engine(seed=1, solver=solver)
        use_classic(engine)
        ground(engine)
        made = {i: solid(engine, box(0.3, 0.2, 0.2), position=(0.4 * i, 0, 0.2)) for i in order}
        for i, body in made.items():
            body.bodyName = f"link{i}"
        for i in range(5):
            joint = libgz.HingeJoint(engine, name=f"joint{i}")
            joint.Attach(made[i], made[i + 1])
            joint.SetAnchor((0.4 * i + 0.2, 0, 0.2))
            joint.SetAxis((0, 1, 1))
        return engine

    first, second = chain(range(6)), chain((3, 0, 5, 1, 4, 2))
    run(first, steps=20)
    state = first.get_state()
    followed = run(first, steps=40)
    for _ in range(2):
        second.set_state(state)
        assert second.get_state() == state
        assert run(second, steps=40) == followed


def test_rows_behind_those_that_are_in_use():
    def hinges(count, closed, order):
        engine = Engine(seed=1)
        bodies = [solid(engine, box(0.3, 0.2, 0.2), position=(i, 0, 1)) for i in range(2)]
        joints = [libgz.HingeJoint(engine, name="hinge") for _ in range(count)]
        for joint in joints:
            joint.Attach(*bodies[::order])
        for joint in joints[:closed]:
            joint.close()
        return engine

    first, second = hinges(40, 38, 1), hinges(2, 0, -1)
    state = first.get_state()
    followed = run(first, steps=10)
    second.set_state(state)
    assert second.get_state() == state
    assert run(second, steps=10) == followed


WORLD = """
import json, sys
sys.path.insert(0, sys.argv[1])
from engine_parts import busy_world
engine = busy_world()
"""
SAVE = """
import base64, pickle
for _ in range(80): engine.step()
state = engine.get_state()
for _ in range(200): engine.step()
print(json.dumps([base64.b64encode(pickle.dumps(state)).decode(), engine.states.tobytes().hex()]))
"""
RESTORE = """
import base64, pickle
state = pickle.loads(base64.b64decode(sys.stdin.read()))
for _ in range(7): engine.step()
engine.set_state(state)
assert engine.get_state() == state
for _ in range(200): engine.step()
print(json.dumps(engine.states.tobytes().hex()))
"""


def test_another_process_that_built_the_same_world():
    def process(code, text=""):
        command = [sys.executable, "-c", WORLD + code, str(Path(__file__).parents[1])]
        return json.loads(subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout)

    state, followed = process(SAVE)
    assert process(RESTORE, state) == followed


def test_it_is_plain_data():
    engine = pile("quick", classic=True)
    run(engine, steps=40)
    state = engine.get_state()
    assert decode(encode(state)) == state


def test_a_state_of_another_build_of_ode_is_refused():
    engine = Engine()
    state = engine.get_state()
    with pytest.raises(StateError, match="another build of ODE"):
        engine.set_state(state | {"ode": "other"})
