"""What comes and goes while plugins of Gazebo classic run, are reset, or run: models, joints, their sensors."""

import math
import re
import sys

import pytest
from plugin_worlds import body, collision

import libgz
from libgz.classic import event, physics, sensors
from libgz.classic.math import Pose3d

NEW = "<sdf version='1.6'><model name='new'><pose>3 0 1 0 0 0</pose><link name='l'/></model></sdf>"
BOX = collision("<box><size>1 1 1</size></box>")
AXIS = "<axis><xyz>0 1 0</xyz></axis>"
HINGE = f"<joint name='hinge' type='revolute'><parent>world</parent><child>link</child>{AXIS}{{}}</joint>"
FELT = "<sensor name='{}' type='force_torque'><always_on>1</always_on>{}</sensor>"


@pytest.fixture
def plugin(tmp_path):
    """Writes a plugin file, with a list `notes`; returns its `<plugin>` element."""

    def write(name, text, kind="World"):
        head = f"from libgz.classic import *\n\nnotes = []\n\n\nclass P({kind}Plugin):\n"
        inside = "".join(f"    {line}\n" for line in text.splitlines())
        (tmp_path / f"{name}.py").write_text(f"{head}{inside}\n\nGZ_REGISTER_{kind.upper()}_PLUGIN(P)\n")
        return f"<plugin name='{name}' filename='lib{name}.so'/>"

    return write


def notes(name):
    """What the plugin of a file has noted."""
    return [m for key, m in sys.modules.items() if key.startswith(f"libgz_plugin_{name}_")][-1].notes


def names(view):
    return [model.GetName() for model in view.Models()]


# Load and Reset ------------------------------------------------------------------------------------------------------

SUICIDE = """def Load(self, model, sdf):
    self.model = model
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: notes.append("update"))
    model.GetWorld().RemoveModel(model)
    notes.append(model.GetWorld().ModelByName("box") is model)"""


def test_a_model_that_its_plugin_removes_in_load_is_removed_when_all_are_loaded(run, plugin):
    core, view = run(body("box", inside=plugin("suicide", SUICIDE, "Model")))
    assert names(view) == []
    core.step(2)
    assert notes("suicide") == [True]  # its plugin went with it


def test_models_that_a_plugin_removes_in_load_still_get_their_own_plugins(run, plugin):
    first = plugin("first", "def Load(self, model, sdf):\n    model.GetWorld().RemoveModel('b')", "Model")
    text = """def Load(self, model, sdf):
    notes.append(model.GetLink().GetCollision(0).BoundingBox().Max().X())
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: notes.append("update"))"""
    core, view = run(
        body("a", inside=first), body("b", "2 0 0 0 0 0", link=BOX, inside=plugin("second", text, "Model"))
    )
    assert names(view) == ["a"]
    core.step(2)
    assert notes("second") == [2.5]


def test_a_model_inserted_in_load_exists_when_all_are_loaded(run, plugin):
    text = f"""def Load(self, world, sdf):
    world.InsertModelString("{NEW}")
    notes.append(world.ModelByName("new"))"""
    _, view = run(plugin("insert", text))
    assert notes("insert") == [None]
    assert names(view) == ["new"]


def test_changes_in_reset_are_deferred_until_all_plugins_were_reset(run, plugin):
    text = f"""def Load(self, model, sdf):
    self.model = model
def Reset(self):
    self.model.GetWorld().RemoveModel(self.model)
    self.model.GetWorld().InsertModelString("{NEW}")"""
    last = """def Load(self, world, sdf):
    self.world = world
def Reset(self):
    notes.extend(model.GetName() for model in self.world.Models())"""
    core, view = run(plugin("last", last), body("box", inside=plugin("goes", text, "Model")))
    core.step(3)
    view.Reset()
    assert notes("last") == ["box"]
    assert names(view) == ["new"]
    assert view.Iterations() == 0


def test_an_inserted_model_may_be_removed_by_a_callback_of_its_insertion(run, plugin):
    text = """def Load(self, world, sdf):
    self.c = event.Events.ConnectAddEntity(lambda name: name == "new" and world.RemoveModel(name))"""
    core, view = run(body("box"), plugin("guard", text))
    view.InsertModelString(NEW)
    assert names(view) == ["box"]
    core.step(2)


@pytest.mark.parametrize("call", ["world.Step(1)", "world.core.close()"])
def test_a_world_is_neither_stepped_nor_closed_while_plugins_load(run, plugin, caplog, call):
    core, _ = run(plugin("hasty", f"def Load(self, world, sdf):\n    {call}"))
    assert "while plugins load, are reset, come or go" in caplog.text
    core.step(1)
    assert core.iterations == 1


def test_a_new_initial_pose_applies_to_nested_models(run):
    inner = "<model name='inner'><pose>1 0 0 0 0 0</pose><link name='l'/></model>"
    _, view = run(body("outer", "0 0 2 0 0 0", inside=inner))
    outer, nested = view.ModelByName("outer"), view.ModelByName("outer::inner")
    outer.SetInitialRelativePose(Pose3d(5, 5, 5, 0, 0, math.pi / 2))
    view.Reset()
    assert tuple(outer.WorldPose().Pos()) == pytest.approx((5, 5, 5))
    assert tuple(nested.WorldPose().Pos()) == pytest.approx((5, 6, 5))
    assert tuple(nested.InitialRelativePose().Pos()) == pytest.approx((1, 0, 0))


def test_a_reset_calls_plugins_in_the_order_of_the_start(run, plugin):
    text = """def Load(self, world, sdf):
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: notes.append(self.GetHandle()))
def Reset(self):
    notes.append(f"reset {self.GetHandle()}")"""
    first = plugin("each", text)
    core, view = run(first.replace("name='each'", "name='first'") + first.replace("name='each'", "name='second'"))
    view.RemovePlugin("first")
    view.LoadPlugin("libeach.so", "late")
    view.LoadPlugin("libeach.so", "first")
    core.step(1)
    assert notes("each") == ["second", "late", "first"]
    notes("each").clear()
    core.reset()
    core.step(1)
    assert notes("each") == ["reset first", "reset second", "reset late", "first", "second", "late"]


def test_two_world_plugins_of_one_name_are_two(run, plugin):
    text = """def Load(self, world, sdf):
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: notes.append("update"))
def Reset(self):
    notes.append("reset")"""
    core, view = run(2 * plugin("twin", text))
    core.step(1)
    view.Reset()
    view.RemovePlugin("twin")
    core.step(1)
    view.RemovePlugin("twin")
    core.step(1)
    assert notes("twin") == ["update", "update", "reset", "reset", "update"]


# Things that are asked for after a step ------------------------------------------------------------------------------


@pytest.mark.parametrize("call", ["InsertModelString(None)", "InsertModelFile(3)", "InsertModelSDF('x')"])
def test_an_invalid_insertion_is_refused_at_once(run, plugin, caplog, call):
    text = f"def Load(self, world, sdf):\n    self.c = event.Events.ConnectWorldUpdateBegin(lambda: world.{call})"
    core, _ = run(plugin("wrong", text))
    core.step(2)
    assert len(re.findall(r"ParameterError: (World\.)?InsertModel", caplog.text)) == 1
    assert "wrong.py" in caplog.text


def test_a_failing_deferred_action_does_not_end_the_step(run, plugin, caplog):
    text = """def Load(self, world, sdf):
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: world.core.after_step(lambda: 1 / 0))"""
    core, _ = run(plugin("late", text))
    core.step(3)
    assert core.iterations == 3
    assert "in a deferred change of plugin with name[late]" in caplog.text
    assert caplog.text.count("ZeroDivisionError") == 1


def test_a_world_that_closes_at_once_warns_of_nothing(run, caplog):
    run(body("box"), "<plugin name='p' filename='libSimEventsPlugin.so'/>")[0].close()
    assert "ended right after it began" not in caplog.text


def test_the_argument_of_a_callback_does_not_change_later(run):
    core, _ = run(body("box"))
    infos = []
    kept = event.Events.ConnectWorldUpdateBegin(infos.append)
    core.step(3)
    assert kept.connected
    assert [info.simTime.Double() for info in infos] == pytest.approx([0.001, 0.002, 0.003])


def test_sensors_of_a_joint_are_removed_with_it(run, plugin):
    text = """def Load(self, sensor, sdf):
    self.c = sensor.ConnectUpdated(lambda: notes.append(sensor.LastUpdateTime().Double()))"""
    felt = FELT.format("felt", plugin("felt", text, "Sensor"))
    core, view = run(body("arm", inside=HINGE.format(felt)))
    core.step(2)
    sensor = sensors.get_sensor("felt")
    assert view.ModelByName("arm").RemoveJoint("hinge")
    core.step(2)
    assert notes("felt") == pytest.approx([0.001, 0.002])
    assert sensors.get_sensor("felt") is None
    assert not sensor.IsActive()


# Settings ------------------------------------------------------------------------------------------------------------


def test_models_without_a_world_run_with_the_settings_of_sdf():
    with libgz.World.from_string(NEW) as core:
        view = physics.get_world()
        assert (view.Name(), view.SDF().GetName()) == ("default", "world")
        assert view.Physics().GetMaxStepSize() == 0.001
        assert view.Physics().GetParam("solver_type") == "quick"
        core.run(0.5)
        assert view.ModelByName("new").WorldPose().Pos().Z() == pytest.approx(1 - 9.8 * 0.5**2 / 2, abs=3e-3)
