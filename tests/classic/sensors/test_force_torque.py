"""Sensors of force and torque in joints."""

import math

import pytest
from sensor_worlds import G, get, model, sensor, world_of

from libgz.classic import event, physics
from libgz.classic.math import Vector3d


def arm(sensors_1="", sensors_2=""):
    """Two links of 10 kg on two hinges, one on the other, standing upright."""
    inertia = "<inertial><pose>0 0 0.5 0 0 0</pose><mass>10</mass></inertial>"
    hinge = (
        "<joint name='{}' type='revolute'><parent>{}</parent><child>{}</child>"
        "<axis><xyz>1 0 0</xyz><limit><lower>-1.57</lower><upper>1.57</upper></limit></axis>{}</joint>"
    )
    return (
        f"<model name='arm'><link name='one'>{inertia}</link><link name='two'><pose>0 0 1 0 0 0</pose>{inertia}</link>"
        f"{hinge.format('j1', 'world', 'one', sensors_1)}{hinge.format('j2', 'one', 'two', sensors_2)}</model>"
    )


def force_torque(frame, direction, name, **options):
    content = f"<frame>{frame}</frame><measure_direction>{direction}</measure_direction>"
    return sensor("force_torque", f"<force_torque>{content}</force_torque>", name, **options)


def test_row_11_force_and_torque_of_upright_links():
    to_child = force_torque("child", "parent_to_child", "up")
    to_parent = force_torque("parent", "child_to_parent", "down")
    with world_of(
        arm(to_child + to_parent, force_torque("child", "parent_to_child", "upper")), gravity="0 0 -50"
    ) as world:
        world.step(1)
        for _ in range(10):  # the engine's least cfm makes joints soft: 2.5e-6 of the force are missing
            assert tuple(get("up").Force()) == pytest.approx((0, 0, 1000), rel=5e-6, abs=1e-9)
            assert tuple(get("down").Force()) == pytest.approx((0, 0, -1000), rel=5e-6, abs=1e-9)
            assert tuple(get("upper").Force()) == pytest.approx((0, 0, 500), rel=5e-6, abs=1e-9)
            assert tuple(get("up").Torque()) == pytest.approx((0, 0, 0), abs=1e-6)
            world.step(1)
        assert get("up").ScopedName() == "default::arm::j1::up"
        assert get("up").Joint().GetName() == "j1"


def test_a_force_torque_sensor_tells_in_its_own_axes_and_to_listeners():
    inertia = "<inertial><pose>1 0 0 0 0 0</pose><mass>2</mass></inertial>"
    joint = (
        "<joint name='j' type='fixed'><parent>world</parent><child>link</child>"
        f"<pose>0 0 0 0 0 {math.pi / 2}</pose>{{}}</joint>"
    )
    both = force_torque("child", "child_to_parent", "plain")
    both += force_torque("sensor", "child_to_parent", "turned", pose=f"0 0 0 {math.pi / 2} 0 0", on=False)
    with world_of(model("m", inertia, "0 0 5 0 0 0", False, joint.format(both))) as world:
        heard = []
        kept = get("turned").ConnectUpdate(heard.append)
        world.step(5)
        weight = 2 * G
        assert tuple(get("plain").Force()) == pytest.approx((0, 0, -weight), abs=1e-6)
        assert tuple(get("plain").Torque()) == pytest.approx((0, weight, 0), abs=1e-6)
        # The sensor's x is the child's y, its y the child's z, its z the child's x.
        assert tuple(get("turned").Force()) == pytest.approx((0, -weight, 0), abs=1e-6)
        assert tuple(get("turned").Torque()) == pytest.approx((weight, 0, 0), abs=1e-6)
        assert len(heard) == 5
        assert heard[-1].wrench.force.y == pytest.approx(-weight, abs=1e-6)
        assert kept.connected


def held(kind, axes, more=""):
    """Two links out of line; the lower one is fixed to the world, the upper one hangs on a joint of a kind."""
    parts = "".join(f"<{tag}><xyz>{xyz}</xyz></{tag}>" for tag, xyz in zip(("axis", "axis2"), axes, strict=False))
    return (
        "<model name='m'><link name='a'><inertial><mass>3</mass></inertial></link>"
        "<link name='b'><pose>0.3 0.2 1 0 0 0</pose>"
        "<inertial><pose>0.1 0 0.2 0 0 0</pose><mass>2</mass></inertial></link>"
        "<joint name='base' type='fixed'><parent>world</parent><child>a</child>"
        f"{force_torque('child', 'child_to_parent', 'whole')}</joint>"
        f"<joint name='j' type='{kind}'><parent>a</parent><child>b</child>{parts}{more}"
        f"{force_torque('child', 'child_to_parent', 'upper')}</joint></model>"
    )


def spring(joint, index, weight=0.0):
    joint.SetForce(index, weight - 3000 * joint.Position(index) - 300 * joint.GetVelocity(index))


@pytest.mark.parametrize(
    ("kind", "axes", "more", "push"),
    [
        ("revolute", ["0 1 0"], "", lambda j: spring(j, 0)),
        ("prismatic", ["0 0 1"], "", lambda j: spring(j, 0, 2 * G)),
        ("universal", ["1 0 0", "0 1 0"], "", lambda j: [spring(j, i) for i in (0, 1)]),
        ("revolute2", ["0 0 1", "0 1 0"], "", lambda j: [spring(j, i) for i in (0, 1)]),
        ("screw", ["0 0 1"], "<thread_pitch>5</thread_pitch>", lambda j: spring(j, 0)),
        ("screw", ["0 0 1"], "<thread_pitch>5</thread_pitch>", lambda j: spring(j, 1)),
    ],
)
def test_what_holds_a_joint_by_set_force_is_felt(kind, axes, more, push):
    with world_of(held(kind, axes, more)) as world:
        model = physics.get_world().ModelByName("m")
        joint, link = model.GetJoint("j"), model.GetLink("b")
        kept = event.Events.ConnectWorldUpdateBegin(lambda: push(joint))
        world.run(5.0)
        assert kept.connected
        turn, centre = link.WorldPose().Rot(), link.WorldCoGPose().Pos()
        weight = Vector3d(0, 0, -2 * G)
        assert tuple(turn.RotateVector(get("upper").Force())) == pytest.approx(tuple(weight), abs=2e-3)
        torque = (centre - joint.Anchor()).Cross(weight)
        assert tuple(turn.RotateVector(get("upper").Torque())) == pytest.approx(tuple(torque), abs=2e-3)
        # Nothing but weight acts on both from outside.
        assert tuple(get("whole").Force()) == pytest.approx((0, 0, -5 * G), abs=2e-3)
        assert tuple(get("whole").Torque()) == pytest.approx(tuple(centre.Cross(weight)), abs=2e-3)


def test_an_effort_is_felt_in_its_own_step_only():
    content = "<inertial><mass>2</mass><inertia><izz>0.5</izz></inertia></inertial>"
    joint = (
        "<joint name='j' type='revolute'><parent>world</parent><child>link</child><axis><xyz>0 0 1</xyz></axis>"
        f"{force_torque('child', 'parent_to_child', 'felt')}</joint>"
    )
    with world_of(model("m", content, "0 0 0 0 0 0", False, joint)) as world:
        hinge = physics.get_world().ModelByName("m").GetJoint("j")
        for torque in (1.3, 0.0, -0.4):
            if torque:
                hinge.SetForce(0, torque)
            world.step(1)
            assert get("felt").Torque().Z() == pytest.approx(torque, abs=1e-9)
        hinge.SetForce(0, 5.0)  # of the step to come
        assert hinge.GetForceTorque(0).body2Torque.Z() == pytest.approx(0.4, abs=1e-9)


def test_the_first_question_begins_to_record_what_a_joint_carries():
    joint = "<joint name='j' type='fixed'><parent>world</parent><child>link</child></joint>"
    with world_of(model("m", "<inertial><mass>2</mass></inertial>", "0 0 0 0 0 0", False, joint)) as world:
        hinge = physics.get_world().ModelByName("m").GetJoint("j")
        world.step(1)
        assert hinge.GetForceTorque(0).body1Force == Vector3d()
        world.step(3)
        assert tuple(hinge.GetForceTorque(0).body1Force) == pytest.approx((0, 0, 2 * G), rel=1e-5, abs=1e-9)
        assert tuple(hinge.LinkForce(1)) == pytest.approx((0, 0, 2 * G), rel=1e-5, abs=1e-9)
