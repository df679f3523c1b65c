"""Joint: links, axes, motion and controllers of joints that are made and changed at run time."""

import math

import pytest
from plugin_worlds import GROUND, body, collision

from libgz.base.errors import ParameterError
from libgz.classic import sensors
from libgz.classic.common import PID, NumericAnimation
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.sdf import SDF

AXIS = "<axis><xyz>0 1 0</xyz></axis>"
HINGE = f"<joint name='hinge' type='revolute'><parent>world</parent><child>link</child>{AXIS}{{}}</joint>"
FELT = "<sensor name='{}' type='force_torque'><always_on>1</always_on>{}</sensor>"


@pytest.fixture
def arm(run):
    """The model ``arm`` with the joint ``hinge`` to the world."""
    _, view = run(body("arm", gravity="false", inside=HINGE.format("")))
    return view.ModelByName("arm")


def test_a_joint_created_at_run_time_gets_its_sensors_and_is_controlled(run):
    core, view = run(body("arm", gravity="false", inside=HINGE.format("")))
    arm = view.ModelByName("arm")
    controller = arm.GetJointController()
    controller.SetPositionTarget("hinge", 0.5)
    arm.RemoveJoint("hinge")
    assert controller.GetJoints() == controller.GetPositions() == {}
    core.step(1)
    document = SDF()
    document.SetFromString(
        f"<sdf version='1.6'><model name='m'><link name='link'/>{HINGE.format(FELT.format('felt', ''))}</model></sdf>"
    )
    joint = arm.CreateJoint(document.Root().GetElement("model").GetElement("joint"))
    assert sensors.get_sensor("felt").Joint() is joint
    assert list(controller.GetJoints()) == ["arm::hinge"]
    controller.SetPositionPID("hinge", PID(400, 0, 40))
    assert controller.SetPositionTarget("hinge", 0.5)
    core.run(3.0)
    assert joint.Position(0) == pytest.approx(0.5, abs=1e-3)


def test_a_detached_joint_has_no_links(run):
    core, view = run(body("a"), body("b", "0 0 1 0 0 0"))
    one, two = (view.ModelByName(name).GetLink() for name in "ab")
    joint = view.ModelByName("a").CreateJoint("hook", "revolute", one, two)
    assert (joint.GetParent(), joint.GetChild()) == (one, two)
    joint.Detach()
    assert (joint.GetParent(), joint.GetChild()) == (None, None)
    joint.Attach(one, two)
    view.RemoveModel("b")
    core.step(1)
    assert (joint.GetParent(), joint.GetChild()) == (None, None)


ASKED = {
    "position": lambda j: j.Position(0),
    "velocity": lambda j: j.GetVelocity(0),
    "force": lambda j: j.SetForce(0, 1.0),
    "set position": lambda j: j.SetPosition(0, 1.0),
    "set velocity": lambda j: j.SetVelocity(0, 1.0),
    "parameters": lambda j: (j.SetParam("fmax", 0, 2.0), j.GetParam("fmax", 0), j.SetUpperLimit(0, 1.0)),
    "spring": lambda j: j.SetStiffnessDamping(0, 2.0, 1.0),
    "place": lambda j: (j.Anchor(), j.GlobalAxis(0), j.LocalAxis(0)),
    "new place": lambda j: (j.SetAnchor(0, (1, 2, 3)), j.SetAxis(0, (0, 1, 0))),
    "wrench": lambda j: (j.SetProvideFeedback(True), j.GetForceTorque(0), j.LinkForce(0)),
    "sensor": lambda j: sensors.get_sensor("felt").Update(True),
    "reset": lambda j: (j.Reset(), j.GetWorld().Reset()),
    "detach": lambda j: j.Detach(),
}


@pytest.mark.parametrize("detached", [False, True])
@pytest.mark.parametrize("what", ASKED)
def test_all_methods_of_a_joint_work_after_its_link_was_removed(run, what, detached):
    hook = "<joint name='hook' type='prismatic'><parent>link</parent><child>b::link</child>{}</joint>"
    felt = AXIS + FELT.format("felt", "")
    core, view = run(body("b", "0 0 1 0 0 0"), body("a", inside=hook.format(felt)))
    joint = view.ModelByName("a").GetJoint("hook")
    core.step(2)
    if detached:
        joint.Detach()
    view.RemoveModel("b")
    ASKED[what](joint)
    core.step(3)
    assert joint.Position(0) == joint.GetVelocity(0) == 0.0
    assert sensors.get_sensor("felt").Force() == Vector3d()


@pytest.mark.parametrize(
    "ask",
    [
        lambda model: model.GetJointController().SetPositionPID("arm::hing", PID(1)),
        lambda model: model.GetJointController().SetVelocityPID("arm::hing", PID(1)),
        lambda model: model.SetJointPosition("arm::hing", 1.0),
        lambda model: model.SetJointPositions({"arm::hing": 1.0}),
    ],
)
def test_unknown_joints_of_a_controller_are_reported(run, caplog, ask):
    _, view = run(body("arm", inside=HINGE.format("")))
    ask(view.ModelByName("arm"))
    assert "Could not find joint with name[arm::hing] in model 'arm'; did you mean 'arm::hinge'?" in caplog.text


def test_an_animation_of_a_removed_joint_ends(run, caplog):
    core, view = run(body("arm", inside=HINGE.format("")))
    arm, turn = view.ModelByName("arm"), NumericAnimation("turn", 1.0, True)
    for time in (0.0, 1.0):
        turn.CreateKeyFrame(time).SetValue(time)
    arm.SetJointAnimation({"hinge": turn})
    core.run(0.5)
    assert arm.GetJoint("hinge").Position(0) == pytest.approx(0.5, abs=0.01)
    arm.RemoveJoint("hinge")
    core.step(3)
    assert caplog.text.count("the animation of arm ends: there is no joint 'hinge'") == 1


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
def test_joints_with_two_axes_are_made_at_run_time(run, kind):
    core, view = run(body("a", gravity="false"), body("b", "0 0 -1 0 0 0", gravity="false"))
    model, one, two = view.ModelByName("a"), view.ModelByName("a").GetLink(), view.ModelByName("b").GetLink()
    made = view.Physics().CreateJoint(kind, model)
    made.SetAxis(0, (1, 0, 0))
    made.SetAxis(1, (1, 0, 0))  # parallel to the other, as long as it holds nothing
    with pytest.raises(ParameterError, match="must not be parallel"):
        made.Load(one, two)
    made.SetAxis(1, (0, 1, 0))
    made.Load(one, two, Pose3d(0, 0, 1, 0, 0, 0))
    made.Init()
    made.SetVelocity(1, 0.5)
    core.step(1)
    assert [made.GetVelocity(i) for i in (0, 1)] == pytest.approx([0.0, 0.5], abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "axis"),
    [("revolute", (0, 1, 0)), ("prismatic", (0, 1, 0)), ("screw", (-1, 0, 0)), ("revolute2", (-1, 0, 0))],
)
def test_an_axis_is_set_in_the_frame_of_the_joint_or_of_the_parents_model(run, kind, axis):
    quarter = math.pi / 2
    _, view = run(body("a", f"0 0 1 0 0 {2 * quarter}"), body("b", f"0 0 2 0 0 {quarter}"))
    made = view.Physics().CreateJoint(kind, view.ModelByName("a"))
    made.Load(view.ModelByName("a").GetLink(), view.ModelByName("b").GetLink(), Pose3d())
    made.SetAxis(0, (1, 0, 0))
    assert made.GlobalAxis(0).Equal(Vector3d(*axis), 1e-9)


X_OF_A, Y_OF_A, X_OF_B, Y_OF_B = (0, 1, 0), (-1, 0, 0), (-1, 0, 0), (0, -1, 0)


@pytest.mark.parametrize(
    ("kind", "link", "axes"),
    [
        ("revolute", "b", [X_OF_B]),
        ("prismatic", "b", [X_OF_B]),
        ("screw", "b", [X_OF_B]),
        ("ball", "b", []),
        ("universal", "b", [Y_OF_A, X_OF_B]),
        ("revolute2", "a", [X_OF_A, Y_OF_B]),
    ],
)
def test_a_joint_made_by_name_has_the_anchor_and_axes_of_ode(run, kind, link, axes):
    quarter = math.pi / 2
    _, view = run(body("a", f"0 0 1 0 0 {quarter}"), body("b", f"0 0 2 0 0 {2 * quarter}"))
    links = {name: view.ModelByName(name).GetLink() for name in "ab"}
    for one in links.values():
        one.GetInertial().SetCoG(0.1, 0.0, 0.0)
        one.UpdateMass()
    made = view.ModelByName("a").CreateJoint("made", kind, links["a"], links["b"])
    for index, axis in enumerate(axes):
        assert made.GlobalAxis(index).Equal(Vector3d(*axis), 1e-9)
    assert made.Anchor(0).Equal(links[link].WorldCoGPose().Pos(), 1e-9)
    made.Init()
    assert made.Anchor(0).Equal(links["b"].WorldPose().Pos(), 1e-9)
    made.SetAnchor(0, (1, 2, 3))
    made.Init()
    assert tuple(made.Anchor(0)) == (1, 2, 3)
    if axes:
        made.SetAxis(0, (0, 0, 1))
        assert made.GlobalAxis(0).Equal(Vector3d(0, 0, 1), 1e-9)


def test_a_screw_made_by_name_turns_forwards(run):
    core, view = run(body("a", gravity="false"), body("b", "0 0 -1 0 0 0", gravity="false"))
    one, two = (view.ModelByName(name).GetLink() for name in "ab")
    screw = view.ModelByName("a").CreateJoint("made", "screw", one, two)
    assert screw.GetParam("thread_pitch", 0) == -1.0
    screw.SetForce(0, 1.0)
    core.step(50)
    assert screw.Position(1) == pytest.approx(screw.Position(0), rel=1e-3)
    assert screw.Position(0) > 0.0


def test_a_joint_that_cannot_be_attached_is_detached(run):
    core, view = run(body("a"), body("b", "0 0 1 0 0 0"))
    one, two = (view.ModelByName(name).GetLink() for name in "ab")
    joint = view.ModelByName("a").CreateJoint("j", "prismatic", one, two)
    with pytest.raises(ParameterError, match="with itself"):
        joint.Attach(one, one)
    view.Reset()  # ODE crashes on a slider without bodies
    core.step(2)
    assert joint.GetParent() is None
    joint.Attach(one, two)
    core.step(1)
    assert joint.GetParent() is one


def test_a_joint_that_changes_its_model_is_removed_from_the_first(run):
    _, view = run(body("a"), body("b", "0 0 1 0 0 0"))
    one, two = view.ModelByName("a"), view.ModelByName("b")
    controller = one.GetJointController()
    joint = view.Physics().CreateJoint("revolute", one)
    joint.Load(one.GetLink(), two.GetLink())
    assert list(controller.GetJoints()) == [joint.GetScopedName()]
    joint.SetModel(two)
    assert (one.GetJointCount(), two.GetJointCount(), controller.GetJoints()) == (0, 1, {})
    view.RemoveModel(one)
    assert two.GetJoints() == [joint]


@pytest.mark.parametrize(
    "ask",
    [
        lambda joint: joint.LowerLimit(1),
        lambda joint: joint.GetDamping(2),
        lambda joint: joint.SetStiffness(1, 3.0),
        lambda joint: joint.SetEffortLimit(-1, 3.0),
    ],
)
def test_axes_that_a_joint_does_not_have_are_reported(run, ask):
    _, view = run(body("arm", inside=HINGE.format("")))
    with pytest.raises(ParameterError, match=r"joint 'hinge' has no axis -?\d; it has 1"):
        ask(view.ModelByName("arm").GetJoint("hinge"))


def test_position_and_velocity_are_set_and_integrated(arm):
    joint = arm.GetJoint("hinge")
    assert joint.SetPosition(0, 0.25)
    joint.SetVelocity(0, 2.0)
    arm.GetWorld().Step(100)
    assert joint.GetVelocity(0) == pytest.approx(2.0)
    assert joint.Position() == pytest.approx(0.25 + 0.2)
    assert not joint.SetPosition(1, 0.0)


def test_wheels_that_are_set_in_each_step_turn_a_robot_as_in_gazebo(run):
    moments = "<inertia><ixx>{0}</ixx><iyy>{0}</iyy><izz>{0}</izz></inertia>"
    parts = (
        f"<link name='base'><pose>0 0 .15 0 0 0</pose><inertial><mass>5</mass>{moments.format(0.1)}</inertial></link>"
    )
    for side, y in (("l", 0.2), ("r", -0.2)):
        for x in (0.1, -0.1):
            name = f"{side}{x}"
            parts += (
                f"<link name='{name}'><pose>{x} {y} .1 -1.5707963 0 0</pose><inertial><mass>.5</mass>"
                f"{moments.format(0.002)}</inertial>{collision('<sphere><radius>.1</radius></sphere>')}</link>"
                f"<joint name='{name}' type='revolute'><parent>base</parent><child>{name}</child>"
                "<axis><xyz>0 0 1</xyz></axis></joint>"
            )
    solver = "<iters>1000</iters><exact_rest>false</exact_rest>"
    core, view = run(f"<physics><ode><solver>{solver}</solver></ode></physics>{GROUND}<model name='m'>{parts}</model>")
    model = view.ModelByName("m")
    wheels = [(joint, -2.0 if joint.GetName()[0] == "l" else 2.0) for joint in model.GetJoints()]
    rates = []
    for _ in range(200):
        for joint, rate in wheels:
            joint.SetVelocity(0, rate)
        core.step(1)
        rates.append(model.GetLink("base").WorldAngularVel().Z())
    assert rates[:1] + rates[-1:] == pytest.approx([0.03298, 0.77951], rel=2e-4)  # Gazebo 11.1
    assert model.WorldPose().Rot().Yaw() == pytest.approx(0.146981, rel=1e-3)


def test_efforts_add_up_and_are_limited(arm):
    joint = arm.GetJoint("hinge")
    joint.SetEffortLimit(0, 3.0)
    joint.SetForce(0, 1.0)
    joint.SetForce(0, 5.0)
    assert joint.GetForce(0) == pytest.approx(1.0 + 3.0)
    arm.GetWorld().Step(1)
    assert joint.GetVelocity(0) == pytest.approx(4.0 * 0.001)  # about y, with a moment of 1 kg m^2


def test_damping_and_stiffness_act(arm):
    joint = arm.GetJoint("hinge")
    joint.SetStiffnessDamping(0, 40.0, 10.0, 0.5)
    values = joint.GetStiffness(0), joint.GetDamping(0), joint.GetSpringReferencePosition(0)
    assert values == (40.0, 10.0, 0.5)
    arm.GetWorld().Step(4000)
    assert joint.Position() == pytest.approx(0.5, abs=1e-3)


def test_anchor_and_axes_in_the_world_and_the_joint_frame(arm):
    joint = arm.GetJoint("hinge")
    arm.SetWorldPose(Pose3d(1, 2, 3, 0, 0, 1.5))
    assert tuple(joint.Anchor()) == pytest.approx((1, 2, 3))
    assert tuple(joint.LocalAxis(0)) == pytest.approx((0, 1, 0))
    assert tuple(joint.GlobalAxis(0)) == pytest.approx(tuple(arm.WorldPose().Rot().RotateVector(Vector3d(0, 1, 0))))
    assert joint.AreConnected(None, arm.GetLink())
    assert joint.InertiaRatio(0) == 0.0  # the parent is the world
