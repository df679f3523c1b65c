"""The tree solver finds the velocities and forces that ODE's exact solver finds."""

import ctypes
import os

import numpy as np
import pytest
from engine_parts import box, ground, solid, use_classic
from random_islands import island

import libgz
from libgz.base.files import installed_worlds
from libgz.ode import step
from libgz.ode.lib import ode
from libgz.ode.step import library_path
from libgz.ode.types import dParamFMax, dParamHiStop, dParamLoStop, dParamVel
from libgz.physics.couplings import TieJoint
from libgz.physics.engine import Engine

TRIALS = int(os.environ.get("TRIAL_ISLANDS", "10000"))


def moved(seed, solver, loops):
    """States after a step, and what the joints did to their bodies."""
    engine, _bodies, joints = island(seed, solver, loops=loops)
    for joint in joints:
        joint.provide_feedback(True)
    engine.step()
    found = engine.states.copy(), np.array([tuple(part) for joint in joints for part in joint.feedback])
    engine.close()
    return found


def differences(seed, loops=False):
    """Of states and of efforts, relative to the largest."""
    pairs = zip(moved(seed, "world", loops), moved(seed, "tree", loops), strict=True)
    return [np.abs(one - two).max() / np.abs(one).max() for one, two in pairs]


def test_random_trees_move_as_with_the_exact_solver():
    for seed in range(150):
        state, effort = differences(seed)
        assert state <= 1e-9, seed
        assert effort <= 1e-6, seed


def test_random_loops_move_as_with_the_exact_solver():
    """Where constraints nearly say the same twice, there is no one answer."""
    found = [differences(seed, loops=True)[0] for seed in range(100)]
    assert np.quantile(found, 0.95) <= 1e-9
    assert max(found) <= 1e-6


@pytest.mark.trial
@pytest.mark.parametrize("loops", [False, True])
def test_many_random_islands(loops):
    found = [differences(seed, loops)[0] for seed in range(1000, 1000 + TRIALS)]
    assert np.quantile(found, 0.99 if loops else 0.999) <= 1e-9
    assert max(found) <= (1e-5 if loops else 1e-7)


@pytest.mark.parametrize("name", ["pioneer2at", "shrimp", "wheelchair", "gripper"])
def test_robots_move_as_with_the_exact_solver(name):
    path = installed_worlds() / f"{name}.world"
    with libgz.World.from_file(path) as one, libgz.World.from_file(path, solver="tree") as two:
        assert two.engine.solver == "tree"
        for world in (one, two) if name == "pioneer2at" else ():
            world.interface("position", "robot1").command(vx=0.3, vyaw=0.5)  # its wheels skid
        one.step(100)
        two.step(100)
        assert np.abs(one.engine.states - two.engine.states).max() < 1e-9


CHAIN = "".join(
    f"<link name='l{i}'><pose>{0.2 * i} 0 0 0 0 0</pose><inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy>"
    f"<izz>.01</izz></inertia></inertial></link><joint name='j{i}' type='revolute'>"
    f"<parent>{f'l{i - 1}' if i else 'world'}</parent><child>l{i}</child><axis><xyz>0 1 0</xyz></axis></joint>"
    for i in range(20)
)
SDF = (
    "<sdf version='1.6'><world name='w'><physics type='ode'><max_step_size>0.001</max_step_size>"
    "<ode><solver><type>{}</type></solver></ode></physics>"
    f"<model name='m'><pose>0 0 10 0 0 0</pose>{CHAIN}</model></world></sdf>"
)


def energy(world):
    """Kinetic and potential energy of the chain [J]."""
    state = world.engine.states[:20]
    linear, angular = state[:, 10:13], state[:, 13:16]
    return 0.5 * (linear**2).sum() + 0.005 * (angular**2).sum() + 9.8 * state[:, 2].sum()


def test_a_swinging_chain_holds_together_and_keeps_its_energy():
    with libgz.World.from_string(SDF.format("tree")) as world:
        assert world.engine.solver == "tree"
        before = energy(world)
        world.step(1000)
        lengths = np.linalg.norm(np.diff(world.engine.states[:20, :3], axis=0), axis=1)
        assert np.abs(lengths - 0.2).max() < 2e-4
        assert energy(world) == pytest.approx(before, abs=0.01 * 9.8 * 20 * 2)


def test_a_chain_without_contacts_hangs_together_as_with_the_tree_solver():
    """Gazebo 11.1, which iterates, has the joints up to 8.8e-6 m apart in the same time."""
    with libgz.World.from_string(SDF.format("quick")) as one, libgz.World.from_string(SDF.format("tree")) as two:
        assert one.engine.solver == "quick"
        for _ in range(25):
            one.step(10)
            two.step(10)
            lengths = np.linalg.norm(np.diff(one.engine.states[:20, :3], axis=0), axis=1)
            assert np.abs(lengths - 0.2).max() < 8e-6
        assert np.abs(one.engine.states - two.engine.states).max() < 1e-9


def test_a_state_continues_to_the_bit():
    path = installed_worlds() / "pioneer2at.world"
    with libgz.World.from_file(path, solver="tree") as world:
        world.step(50)
        state = world.get_state()
        world.step(50)
        after = world.get_state()
        world.set_state(state)
        world.step(50)
        assert world.get_state() == after


def test_motors_and_efforts_wake_what_sleeps():
    """An island of which one body sleeps is solved whole."""
    engine, bodies, _joints = island(3, "tree")
    for body in bodies[1:]:
        body.Enable(False)
    engine.step()
    assert all(body.IsEnabled() for body in bodies)
    engine.close()


def states_of(solver, change, steps=50):
    """States of an island whose bodies were changed by a function of ODE."""
    engine, bodies, _joints = island(5, solver)
    for body in bodies:
        change(body)
    for _ in range(steps):
        engine.step()
    found = engine.states.copy()
    engine.close()
    return found


def called(name, *values):
    """A function that calls one of ODE's with a body."""
    kinds = [ctypes.c_double if isinstance(value, float) else ctypes.c_int for value in values]
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, *kinds)(ode().address(name))
    return lambda body: function(body.id, *values)


@pytest.mark.parametrize(
    "change",
    [
        lambda body: body.set_auto_disable(True),
        called("dBodySetFiniteRotationMode", 1),
        called("dBodySetLinearDamping", 0.1),
        called("dBodySetAngularDamping", 0.1),
        called("dBodySetMaxAngularSpeed", 1e-3),
    ],
    ids=["sleep", "finite", "linear", "angular", "speed"],
)
def test_bodies_of_which_ode_does_more_than_to_move_them(change):
    plain, exact, tree = states_of("tree", lambda body: None), states_of("world", change), states_of("tree", change)
    assert np.abs(tree - exact).max() <= 1e-9 * np.abs(exact).max()
    assert "sleep" in str(change) or not np.array_equal(plain, tree)


def test_bodies_are_moved_beside_others_that_sleep_or_that_ode_moves():
    """Some islands are solved along their tree, one has to sleep, one has a body past the library."""

    def run(solver):
        engine = Engine(solver=solver)
        found = []
        for number in range(3):
            one, two = (solid(engine, box(0.2, 0.2, 0.2), 1.0, (3.0 * number, x, 1.0)) for x in (0.0, 0.5))
            joint = libgz.HingeJoint(engine)
            joint.Attach(two, one)
            joint.SetAnchor((3.0 * number, 0.25, 1.0))
            joint.SetAxis((1, 0, 0))
            two.SetAngularVel((0.5, 0.0, 0.0))
            found += [one, two]
        found[2].set_auto_disable(True)
        hang_unknown(engine, found[5])
        for _ in range(20):
            engine.step()
        states = engine.states.copy()
        assert all(body.IsEnabled() for body in found)
        engine.close()
        return states

    exact, tree = run("world"), run("tree")
    assert np.abs(tree - exact).max() <= 1e-9 * np.abs(exact).max()
    assert np.array_equal(tree[4:], exact[4:])


def test_a_joint_without_rows_lets_ode_move_no_body_once_more():
    """ODE enables what enabled joints connect to a body that it moves, such as a kinematic one."""

    def run(solver):
        engine = Engine(solver=solver)
        engine.gravity = 0, 0, 0
        base, arm, hand = (solid(engine, box(0.2, 0.2, 0.2), 1.0, (0.5 * i, 0.0, 0.0)) for i in range(3))
        hinge, tie = libgz.HingeJoint(engine), TieJoint(engine)
        hinge.Attach(hand, arm)
        hinge.SetAnchor((0.75, 0.0, 0.0))
        hinge.SetAxis((0, 0, 1))
        tie.Attach(arm, base)
        base.set_kinematic(True)
        base.SetLinearVel((0.0, 0.0, 1.0))
        arm.SetLinearVel((0.0, 1.0, 0.0))
        for _ in range(3):
            engine.step()
        states = engine.states.copy()
        engine.close()
        return states

    exact, tree = run("world"), run("tree")
    assert np.abs(tree - exact).max() <= 1e-9 * np.abs(exact).max()
    assert tree[0, 9] == pytest.approx(0.06)


def hang_unknown(engine, body):
    """A body that is in no table."""
    other = ode().dBodyCreate(engine.world)
    ode().dBodySetData(other, 1 << 40)
    hold = ode().dJointCreateFixed(engine.world, None)
    ode().dJointAttach(hold, other, body.id)
    ode().dJointSetFixed(hold)


def hang_often(engine, body):
    """Loops of more rows than the tree solver takes."""
    other = solid(engine, box(0.2, 0.2, 0.2))
    for _ in range(180):
        hold = libgz.FixedJoint(engine)
        hold.Attach(other, body)
        hold.SetFixed()


def turned_by_a_motor_at_its_stop(solver, hang):
    """The states of an arm that drives away from its stop, with something on it."""
    engine = Engine(solver=solver)
    engine.gravity = 0, 0, 0
    body = solid(engine, box(0.2, 0.2, 0.2))
    joint = libgz.HingeJoint(engine)
    joint.Attach(body, None)
    joint.SetAxis((0, 0, 1))
    for parameter, value in ((dParamLoStop, 0.0), (dParamHiStop, 1.0)):
        joint.SetParam(parameter, value)
    engine.step()
    hang(engine, body)
    joint.SetParam(dParamVel, 1.0)
    joint.SetParam(dParamFMax, 0.5)
    engine.step()
    found = engine.states.copy()
    engine.close()
    return found


@pytest.mark.parametrize("hang", [hang_unknown, hang_often])
def test_what_cannot_be_solved_is_left_to_the_exact_solver_as_it_was(hang):
    exact = turned_by_a_motor_at_its_stop("world", hang)
    assert exact[0, 15] > 0.0
    assert np.array_equal(turned_by_a_motor_at_its_stop("tree", hang), exact)


def test_the_first_step_moves_bodies_past_the_library_once():
    engine, _bodies, _joints = island(3, "tree")
    other = ode().dBodyCreate(engine.world)
    ode().dBodySetLinearVel(other, 1.0, 0.0, 0.0)
    engine.step()
    assert ode().dBodyGetPosition(other)[0][0] == pytest.approx(engine.step_time)
    engine.close()


def driven_chain(solver, effort):
    """States and rates of a chain of four boxes after a step in which motors with so much effort turn its joints."""
    engine = Engine(solver=solver)
    bodies = [solid(engine, box(0.2, 0.2, 0.2), 1.0, (0.5 * i, 0.0, 0.0)) for i in range(4)]
    joints = []
    for i in range(1, 4):
        joints.append(libgz.HingeJoint(engine))
        joints[-1].Attach(bodies[i], bodies[i - 1])
        joints[-1].SetAnchor((0.5 * i - 0.25, 0.0, 0.0))
        joints[-1].SetAxis((0, 0, 1))
        joints[-1].SetParam(dParamVel, 2.0)
        joints[-1].SetParam(dParamFMax, effort)
    engine.step()
    found = engine.states.copy(), [joint.GetAngleRate() for joint in joints]
    engine.close()
    return found


@pytest.mark.parametrize(("effort", "reached"), [(0.05, 0), (1.8, 2), (500.0, 3)])
def test_motors_turn_joints_as_far_as_their_efforts_go(effort, reached):
    """Whether those that were taken to reach their speed do so, or some, or none."""
    (exact, _), (states, rates) = driven_chain("world", effort), driven_chain("tree", effort)
    assert np.abs(states - exact).max() <= 1e-9
    assert sum(rate == pytest.approx(2.0) for rate in rates) == reached


def lifted_arm(solver):
    """How fast an arm turns that a force lifts off the ground, on which its carrier stands; friction is infinite."""
    engine = Engine(solver=solver)
    ground(engine, friction=np.inf)
    carrier, arm = (
        solid(engine, box(0.2, 0.2, 0.2), mass, (x, 0.0, 0.0999), friction=np.inf)
        for mass, x in ((1000.0, 0.0), (1.0, 0.5))
    )
    hinge = libgz.HingeJoint(engine)
    hinge.Attach(arm, carrier)
    hinge.SetAnchor((0.25, 0.0, 0.3))
    hinge.SetAxis((0, 1, 0))
    arm.AddForce(0.0, 0.0, 500.0)
    engine.step()
    rate = hinge.GetAngleRate()
    engine.close()
    return rate


def test_infinite_friction_holds_nothing_that_does_not_press():
    rate = lifted_arm("world")
    assert abs(rate) > 0.1
    assert lifted_arm("tree") == pytest.approx(rate, rel=1e-6)


def hanging_chains(count):
    """Where the bodies of the first one of some chains are after a step; they hang on a kinematic body."""
    engine = Engine(solver="quick")
    use_classic(engine)
    carrier = solid(engine, box(0.1, 0.1, 0.1), position=(0.0, 0.0, 10.0))
    carrier.set_kinematic(True)
    for side in range(count):
        above = carrier
        for i in range(1, 28):
            body = solid(engine, box(0.1, 0.1, 0.1), position=((0.3 * i, -0.3 * i)[side], 0.0, 10.0))
            joint = libgz.HingeJoint(engine)
            joint.Attach(body, above)
            joint.SetAnchor(((0.3 * i - 0.15) * (1, -1)[side], 0.0, 10.0))
            joint.SetAxis((0, 1, 0))
            above = body
        if not side:
            hang_unknown(engine, above)
    engine.step()
    found = engine.states[:28].copy()
    engine.close()
    return found


def test_a_chain_that_cannot_be_solved_is_iterated_beside_one_that_can():
    assert np.array_equal(hanging_chains(1), hanging_chains(2))


def test_joints_that_export_only_how_they_count_rows_are_left_to_the_exact_solver(monkeypatch):
    """As those of an ODE in which they write rows in another way."""
    library, address = ctypes.CDLL(str(library_path())), ode().address

    def found(name):
        if "getInfo2" in name:
            raise AttributeError(name)
        return address(name)

    monkeypatch.setattr(ode(), "address", found)
    try:
        step._bind_joints(library)
        one, two = moved(3, "world", False), moved(3, "tree", False)
    finally:
        monkeypatch.undo()
        step._bind_joints(library)
    assert all(np.array_equal(*pair) for pair in zip(one, two, strict=True))
