"""What comes and goes while plugins of Gazebo classic load, are reset, or run: models, joints, their sensors."""

import math
import sys

import pytest
from plugin_worlds import body, collision, keep_to, worlds_of_elements

import libgz
from libgz.classic import event, physics, sensors
from libgz.classic.common import PID, NumericAnimation
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.sdf import SDF
from libgz.errors import ClosedError, ParameterError

NEW = "<sdf version='1.6'><model name='new'><pose>3 0 1 0 0 0</pose><link name='l'/></model></sdf>"
BOX = collision("<box><size>1 1 1</size></box>")
AXIS = "<axis><xyz>0 1 0</xyz></axis>"
HINGE = f"<joint name='hinge' type='revolute'><parent>world</parent><child>link</child>{AXIS}{{}}</joint>"
FELT = "<sensor name='{}' type='force_torque'><always_on>1</always_on>{}</sensor>"


@pytest.fixture
def load(tmp_path, monkeypatch):
    keep_to(tmp_path, monkeypatch)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    yield from worlds_of_elements()


@pytest.fixture
def plugin(tmp_path):
    """Writes a plugin file; its `<plugin>` element."""

    def write(name, text, kind="World"):
        head = f"from libgz.classic import *\n\ntold = []\n\n\nclass P({kind}Plugin):\n"
        inside = "".join(f"    {line}\n" for line in text.splitlines())
        (tmp_path / f"{name}.py").write_text(f"{head}{inside}\n\nGZ_REGISTER_{kind.upper()}_PLUGIN(P)\n")
        return f"<plugin name='{name}' filename='lib{name}.so'/>"

    return write


def told(name):
    """What the plugin of a file has noted."""
    return [m for key, m in sys.modules.items() if key.startswith(f"libgz_plugin_{name}_")][-1].told


def names(view):
    return [model.GetName() for model in view.Models()]


# Load and Reset ------------------------------------------------------------------------------------------------------

SUICIDE = """def Load(self, model, sdf):
    self.model = model
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: told.append("update"))
    model.GetWorld().RemoveModel(model)
    told.append(model.GetWorld().ModelByName("box") is model)"""


def test_a_model_that_its_plugin_removes_in_load_goes_when_all_are_loaded(load, plugin):
    core, view = load(body("box", inside=plugin("suicide", SUICIDE, "Model")))
    assert names(view) == []
    core.step(2)
    assert told("suicide") == [True]  # its plugin went with it


def test_models_that_a_plugin_removes_in_load_still_get_their_own_plugins(load, plugin):
    first = plugin("first", "def Load(self, model, sdf):\n    model.GetWorld().RemoveModel('b')", "Model")
    text = """def Load(self, model, sdf):
    told.append(model.GetLink().GetCollision(0).BoundingBox().Max().X())
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: told.append("update"))"""
    core, view = load(
        body("a", inside=first), body("b", "2 0 0 0 0 0", link=BOX, inside=plugin("second", text, "Model"))
    )
    assert names(view) == ["a"]
    core.step(2)
    assert told("second") == [2.5]


def test_a_model_inserted_in_load_is_there_when_all_are_loaded(load, plugin):
    text = f"""def Load(self, world, sdf):
    world.InsertModelString("{NEW}")
    told.append(world.ModelByName("new"))"""
    _, view = load(plugin("insert", text))
    assert told("insert") == [None]
    assert names(view) == ["new"]


def test_what_reset_removes_and_inserts_waits_until_all_plugins_were_reset(load, plugin):
    text = f"""def Load(self, model, sdf):
    self.model = model
def Reset(self):
    self.model.GetWorld().RemoveModel(self.model)
    self.model.GetWorld().InsertModelString("{NEW}")"""
    last = """def Load(self, world, sdf):
    self.world = world
def Reset(self):
    told.extend(model.GetName() for model in self.world.Models())"""
    core, view = load(plugin("last", last), body("box", inside=plugin("goes", text, "Model")))
    core.step(3)
    view.Reset()
    assert told("last") == ["box"]
    assert names(view) == ["new"]
    assert view.Iterations() == 0


def test_what_comes_may_be_taken_out_again_by_who_hears_of_it(load, plugin):
    text = """def Load(self, world, sdf):
    self.c = event.Events.ConnectAddEntity(lambda name: name == "new" and world.RemoveModel(name))"""
    core, view = load(body("box"), plugin("guard", text))
    view.InsertModelString(NEW)
    assert names(view) == ["box"]
    core.step(2)


@pytest.mark.parametrize("call", ["world.Step(1)", "world.core.close()"])
def test_a_world_is_neither_stepped_nor_closed_while_plugins_load(load, plugin, caplog, call):
    core, _ = load(plugin("hasty", f"def Load(self, world, sdf):\n    {call}"))
    assert "while plugins load, are reset, come or go" in caplog.text
    core.step(1)
    assert core.iterations == 1


def test_a_new_place_to_begin_at_takes_nested_models_along(load):
    inner = "<model name='inner'><pose>1 0 0 0 0 0</pose><link name='l'/></model>"
    _, view = load(body("outer", "0 0 2 0 0 0", inside=inner))
    outer, nested = view.ModelByName("outer"), view.ModelByName("outer::inner")
    outer.SetInitialRelativePose(Pose3d(5, 5, 5, 0, 0, math.pi / 2))
    view.Reset()
    assert tuple(outer.WorldPose().Pos()) == pytest.approx((5, 5, 5))
    assert tuple(nested.WorldPose().Pos()) == pytest.approx((5, 6, 5))
    assert tuple(nested.InitialRelativePose().Pos()) == pytest.approx((1, 0, 0))


def test_two_world_plugins_of_one_name_are_two(load, plugin):
    text = """def Load(self, world, sdf):
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: told.append("update"))
def Reset(self):
    told.append("reset")"""
    core, view = load(2 * plugin("twin", text))
    core.step(1)
    view.Reset()
    view.RemovePlugin("twin")
    core.step(1)
    view.RemovePlugin("twin")
    core.step(1)
    assert told("twin") == ["update", "update", "reset", "reset", "update"]


# Things that are asked for after a step ------------------------------------------------------------------------------


@pytest.mark.parametrize("call", ["InsertModelString(None)", "InsertModelFile(3)", "InsertModelSDF('x')"])
def test_what_cannot_be_inserted_is_refused_at_once(load, plugin, caplog, call):
    text = f"def Load(self, world, sdf):\n    self.c = event.Events.ConnectWorldUpdateBegin(lambda: world.{call})"
    core, _ = load(plugin("wrong", text))
    core.step(2)
    assert caplog.text.count("ParameterError: InsertModel") == 1
    assert "wrong.py" in caplog.text


def test_what_fails_after_a_step_does_not_end_it(load, plugin, caplog):
    text = """def Load(self, world, sdf):
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: world.core.after_step(lambda: 1 / 0))"""
    core, _ = load(plugin("late", text))
    core.step(3)
    assert core.iterations == 3
    assert "in a deferred change of plugin with name[late]" in caplog.text
    assert caplog.text.count("ZeroDivisionError") == 1


def test_a_world_that_closes_at_once_warns_of_nothing(load, caplog):
    load(body("box"), "<plugin name='p' filename='libSimEventsPlugin.so'/>")[0].close()
    assert "ended right after it began" not in caplog.text


def test_what_a_callback_is_told_stays_as_it_was(load):
    core, _ = load(body("box"))
    infos = []
    kept = event.Events.ConnectWorldUpdateBegin(infos.append)
    core.step(3)
    assert kept.connected
    assert [info.simTime.Double() for info in infos] == pytest.approx([0.001, 0.002, 0.003])


# Joints --------------------------------------------------------------------------------------------------------------


def test_the_sensors_of_a_joint_go_with_it(load, plugin):
    text = """def Load(self, sensor, sdf):
    self.c = sensor.ConnectUpdated(lambda: told.append(sensor.LastUpdateTime().Double()))"""
    felt = FELT.format("felt", plugin("felt", text, "Sensor"))
    core, view = load(body("arm", inside=HINGE.format(felt)))
    core.step(2)
    sensor = sensors.get_sensor("felt")
    assert view.ModelByName("arm").RemoveJoint("hinge")
    core.step(2)
    assert told("felt") == pytest.approx([0.001, 0.002])
    assert sensors.get_sensor("felt") is None
    assert not sensor.IsActive()


def test_a_joint_made_at_run_time_gets_its_sensors_and_is_held_by_the_controller(load):
    core, view = load(body("arm", gravity="false", inside=HINGE.format("")))
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


def test_a_joint_that_holds_nothing_has_no_links(load):
    core, view = load(body("a"), body("b", "0 0 1 0 0 0"))
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
def test_a_joint_whose_link_has_gone_can_be_asked_for_anything(load, what, detached):
    hook = "<joint name='hook' type='prismatic'><parent>link</parent><child>b::link</child>{}</joint>"
    felt = AXIS + FELT.format("felt", "")
    core, view = load(body("b", "0 0 1 0 0 0"), body("a", inside=hook.format(felt)))
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
def test_joints_that_a_controller_does_not_know_are_told_of(load, caplog, ask):
    _, view = load(body("arm", inside=HINGE.format("")))
    ask(view.ModelByName("arm"))
    assert "Could not find joint with name[arm::hing] in model 'arm'; did you mean 'arm::hinge'?" in caplog.text


def test_an_animation_of_a_joint_that_goes_ends(load, caplog):
    core, view = load(body("arm", inside=HINGE.format("")))
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
def test_joints_with_two_axes_are_made_at_run_time(load, kind):
    core, view = load(body("a", gravity="false"), body("b", "0 0 -1 0 0 0", gravity="false"))
    model, one, two = view.ModelByName("a"), view.ModelByName("a").GetLink(), view.ModelByName("b").GetLink()
    named = model.CreateJoint("named", kind, one, two)
    assert [tuple(named.GlobalAxis(i)) for i in (0, 1)] == [(0, 0, 1), (1, 0, 0)]
    model.RemoveJoint("named")
    made = view.Physics().CreateJoint(kind, model)
    made.SetAxis(0, (1, 0, 0))  # parallel to the other, as long as it holds nothing
    with pytest.raises(ParameterError, match="must not be parallel"):
        made.Load(one, two)
    made.SetAxis(1, (0, 1, 0))
    made.Load(one, two, Pose3d(0, 0, 1, 0, 0, 0))
    made.Init()
    made.SetVelocity(1, 0.5)
    core.step(1)
    assert [made.GetVelocity(i) for i in (0, 1)] == pytest.approx([0.0, 0.5], abs=1e-6)


def test_a_joint_that_cannot_be_attached_holds_nothing(load):
    core, view = load(body("a"), body("b", "0 0 1 0 0 0"))
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


def test_a_joint_that_changes_its_model_leaves_the_first(load):
    _, view = load(body("a"), body("b", "0 0 1 0 0 0"))
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
def test_axes_that_a_joint_does_not_have_are_named(load, ask):
    _, view = load(body("arm", inside=HINGE.format("")))
    with pytest.raises(ParameterError, match=r"joint 'hinge' has no axis -?\d; it has 1"):
        ask(view.ModelByName("arm").GetJoint("hinge"))


def test_a_model_that_has_left_is_given_no_link(load):
    _, view = load(body("box"))
    box = view.ModelByName("box")
    view.RemoveModel(box)
    with pytest.raises(ClosedError, match="has left the world"):
        box.CreateLink("more")


def test_collide_modes_go_back_to_the_bits_that_were_set(load):
    _, view = load(body("box", link=BOX))
    shape = view.ModelByName("box").GetLink().GetCollision(0)
    shape.GetSurface().collideBitmask = 2
    shape.SetCollideMode("none")
    shape.SetCollideMode("all")
    assert shape.GetSurface().collideBitmask == 2


# Settings ------------------------------------------------------------------------------------------------------------


def test_models_without_a_world_run_with_the_settings_of_sdf():
    with libgz.World.from_string(NEW) as core:
        view = physics.get_world()
        assert (view.Name(), view.SDF().GetName()) == ("default", "world")
        assert view.Physics().GetMaxStepSize() == 0.001
        assert view.Physics().GetParam("solver_type") == "quick"
        core.run(0.5)
        assert view.ModelByName("new").WorldPose().Pos().Z() == pytest.approx(1 - 9.8 * 0.5**2 / 2, abs=3e-3)
