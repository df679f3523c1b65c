"""What goes wrong in worlds of Gazebo classic: absurd numbers, callbacks that raise, steps within steps."""

import math
import os

import numpy as np
import pytest

import libgz
from libgz.base.errors import GazeboError, ParameterError
from libgz.classic import common, event, msgs, physics, sensors, transport
from libgz.classic.common import PID
from libgz.classic.math import Vector3d
from libgz.classic.sdf import SDF
from libgz.simulation.event import Event

BOX = """<model name='box'><pose>0 0 0.5 0 0 0</pose><link name='link'>
<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>
<battery name='b'><voltage>12</voltage></battery>
<sensor name='imu' type='imu'><always_on>1</always_on><imu><angular_velocity><x><noise type='gaussian'><mean>0</mean>
<stddev>0.1</stddev></noise></x></angular_velocity></imu></sensor></link></model>"""
GROUND = """<model name='ground'><static>1</static><link name='l'><collision name='c'><geometry><plane/></geometry>
</collision></link></model>"""
ARM = """<model name='arm'><pose>0 5 2 0 0 0</pose><link name='base'/><link name='leaf'><pose>1 0 0 0 0 0</pose></link>
<joint name='joint_1' type='fixed'><parent>world</parent><child>base</child></joint>
<joint name='hinge' type='revolute'><parent>base</parent><child>leaf</child><axis><xyz>0 0 1</xyz></axis></joint>
</model>"""


def sdf(inside):
    return f"<sdf version='1.6'><world name='errors'>{inside}</world></sdf>"


@pytest.fixture
def core():
    with libgz.World.from_string(sdf(GROUND + BOX + ARM), seed=3) as world:
        yield world


@pytest.fixture
def view(core):
    return physics.get_world("errors")


@pytest.fixture
def plugin(tmp_path, monkeypatch):
    """A world with a World plugin of this text."""
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))

    def load(body, name="p"):
        head = "from libgz.classic import *\nfrom libgz.classic.math import *\n\n\nclass P(WorldPlugin):\n"
        text = head + "".join(f"    {line}\n" for line in body.splitlines()) + "GZ_REGISTER_WORLD_PLUGIN(P)\n"
        (tmp_path / f"{name}.py").write_text(text)
        plugins = f"<plugin name='{name}' filename='lib{name}.so'/>"
        return libgz.World.from_string(sdf(GROUND + BOX + ARM + plugins), seed=3)

    return load


# Numbers -------------------------------------------------------------------------------------------------------------

RUNAWAYS = {
    "force": lambda view, link: link.AddForce((1e30, 0, 0)),
    "torque": lambda view, link: link.AddTorque((1e30, 1e30, 0)),
    "overflow": lambda view, link: [link.AddForce((1e308, 0, 0)) for _ in range(3)],
    "joint": lambda view, link: view.ModelByName("arm").GetJoint("hinge").SetForce(0, 1e300),
    "spring": lambda view, link: view.ModelByName("arm").GetJoint("hinge").SetStiffnessDamping(0, 1e300, 0, 1),
    "moments": lambda view, link: [link.GetInertial().SetIZZ(1e-300), link.UpdateMass(), link.AddTorque((0, 0, 1e20))],
}


@pytest.mark.parametrize("what", RUNAWAYS)
def test_diverging_bodies_are_stopped_and_reported(core, view, caplog, what):
    RUNAWAYS[what](view, view.ModelByName("box").GetLink())
    core.step(20)
    assert view.Iterations() == 20
    assert "diverged; its velocity was reset" in caplog.text
    for model in view.Models():
        for link in model.GetLinks():
            assert all(map(math.isfinite, (*link.WorldPose().Pos(), *link.WorldLinearVel())))


def test_the_largest_softness_keeps_bodies_finite(core, view):
    view.Physics().SetParam("cfm", 1e308)
    core.step(20)
    assert view.Iterations() == 20
    assert np.isfinite(core.engine.states).all()


def test_a_body_is_reported_once(core, view, caplog):
    for _ in range(3):
        view.ModelByName("box").GetLink().AddForce((1e30, 0, 0))
        core.step(2)
    assert caplog.text.count("body box::link diverged") == 1


@pytest.mark.parametrize(
    "call",
    [
        lambda view, link: view.EntityBelowPoint((math.nan, 0, 0)),
        lambda view, link: view.Physics().CreateShape("ray").SetPoints((0, 0, 0), (1e300, 0, 0)),
        lambda view, link: [link.GetInertial().SetCoG(1e20, 0, 0), link.UpdateMass()],
        lambda view, link: link.GetCollision(0).SetRelativePose(libgz.GzPose(libgz.GzVector(1e30, 0, 0))),
        lambda view, link: link.SetWorldPose(libgz.GzPose(libgz.GzVector(), libgz.GzQuatern(0, 0, 0, 0))),
        lambda view, link: view.Physics().SetParam("iters", 10**9),
        lambda view, link: view.ModelByName("arm").GetJointController().SetPositionTarget("hinge", math.nan),
        lambda view, link: view.ModelByName("arm").GetJointController().SetPositionPID("hinge", 3.0),
        lambda view, link: link.SetAnimation("nothing"),
        lambda view, link: event.Events.ConnectWorldUpdateBegin(None),
    ],
)
def test_invalid_arguments_are_refused(core, view, call):
    with pytest.raises(ParameterError):
        call(view, view.ModelByName("box").GetLink())
    core.step(3)
    assert view.ModelByName("box").WorldPose().Pos().Z() == pytest.approx(0.5, abs=1e-3)


def test_a_controller_with_invalid_gains_drops_its_targets(core, view, caplog):
    controller = view.ModelByName("arm").GetJointController()
    controller.SetPositionPID("hinge", PID(math.nan))
    controller.SetPositionTarget("hinge", 1.0)
    core.step(3)
    assert caplog.text.count("joint arm::hinge is not controlled any more") == 1
    assert controller.GetPositions() == {}


# Callbacks -----------------------------------------------------------------------------------------------------------


def test_a_disconnected_callback_is_not_called_by_the_running_signal():
    notes, happened = [], Event("x")
    first = happened.Connect(lambda: (notes.append(1), second.Disconnect()))
    second = happened.Connect(lambda: notes.append(2))
    happened()
    assert notes == [1]
    assert first.connected
    assert not second.connected


def test_a_plugin_that_raises_has_no_other_callback_called(plugin, caplog):
    body = """notes = []
def Load(self, world, sdf):
    self.a = event.Events.ConnectWorldUpdateBegin(self.fail)
    self.b = event.Events.ConnectWorldUpdateBegin(lambda: self.notes.append(1))
def fail(self):
    raise ValueError("no")"""
    with plugin(body) as core:
        seen = next(iter(core.companions)).plugins.of_world["p"].plugin_class.notes
        core.step(3)
        assert seen == []
    assert caplog.text.count("Exception occured in a callback of event WorldUpdateBegin") == 1


@pytest.mark.parametrize(
    ("what", "body"),
    [
        (
            "the end of the animation of box",
            """def Load(self, world, sdf):
    way = common.PoseAnimation("way", 0.002, False)
    for time in (0, 0.002):
        way.CreateKeyFrame(time).Translation(Vector3d(0, 0, 0.5))
    world.ModelByName("box").SetAnimation(way, self.fail)""",
        ),
        (
            "the rule of battery 'b'",
            """def Load(self, world, sdf):
    world.ModelByName("box").GetLink().Battery("b").SetUpdateFunc(self.fail)""",
        ),
        (
            "the noise callback",
            """def Load(self, world, sdf):
    imu = sensors.get_sensor("imu")
    imu.Noise(sensors.SensorNoiseType.IMU_ANGVEL_X_NOISE_RADIANS_PER_S).SetCustomNoiseCallback(self.fail)""",
        ),
    ],
)
def test_functions_of_a_plugin_that_are_called_later_are_guarded(plugin, caplog, what, body):
    with plugin(body + "\ndef fail(self, *values):\n    raise ValueError('oh')") as core:
        core.step(6)
        assert core.iterations == 6
    assert f"Exception occured in {what} of plugin with name[p] and filename[libp.so]" in caplog.text
    assert "p.py" in caplog.text
    assert caplog.text.count("ValueError: oh") == 1


def test_an_invalid_animation_ends(core, view, caplog):
    view.ModelByName("box").SetAnimation(common.PoseAnimation("way", 1.0, False))
    core.step(3)
    assert "the animation of box ends: animation 'way' has no key frames" in caplog.text


def test_failures_outside_plugins_have_one_wording(core, view, caplog):
    node = transport.Node()
    node.Init("errors")
    publisher = node.Advertise(msgs.Vector3d, "~/x")
    way = common.PoseAnimation("way", 0.002, False)
    for time in (0, 0.002):
        way.CreateKeyFrame(time).Translation(Vector3d(0, 0, 0.5))

    def fail(*values):
        raise ValueError("oh")

    kept = [event.Events.ConnectWorldUpdateEnd(fail), node.Subscribe("~/x", fail)]
    view.ModelByName("box").SetAnimation(way, fail)
    core.after_step(lambda: publisher.Publish(msgs.Vector3d()))
    core.step(6)
    assert kept
    notes = [record.getMessage().partition("\n")[0] for record in caplog.records if "ValueError" in record.getMessage()]
    name = fail.__qualname__
    assert sorted(notes) == [
        "a callback of event WorldUpdateEnd failed and is not called any more:",
        f"the callback {name} of topic /gazebo/errors/x failed and is not called any more:",
        "the end of the animation of box failed and is not called any more:",
    ]


@pytest.mark.parametrize("call", ["world.Step(1)", "world.core.close()"])
def test_a_callback_can_neither_step_nor_close_its_world(plugin, caplog, call):
    body = f"""def Load(self, world, sdf):
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: {call})"""
    with plugin(body) as core:
        core.step(3)
        assert core.iterations == 3
    assert "in a callback: its step is under way" in caplog.text


def test_a_failing_deferred_action_names_the_plugin(plugin, caplog):
    body = """def Load(self, world, sdf):
    self.c = event.Events.ConnectWorldUpdateBegin(lambda: world.InsertModelString("<sdf"))"""
    with plugin(body) as core:
        core.step(1)
    assert "plugin with name[p] and filename[libp.so]: " in caplog.text


def test_errors_without_a_frame_of_the_plugin_name_its_file(plugin, caplog):
    plugin("def Load(self, world):\n    pass").close()
    assert "p.py" in caplog.text
    assert "takes 2 positional arguments but 3 were given" in caplog.text


def test_a_syntax_error_is_reported_without_frames_of_the_library(plugin, caplog):
    plugin("def Load(self world):\n    pass").close()
    assert "SyntaxError" in caplog.text
    assert "importlib" not in caplog.text


def test_what_a_sensor_callback_removes_is_removed_after_the_step(plugin, caplog):
    body = """def Load(self, world, sdf):
    self.world, self.model = world, world.ModelByName("box")
    self.c = sensors.get_sensor("imu").ConnectUpdated(self.out)
def out(self):
    self.world.RemoveModel("box")
    self.model.WorldPose()"""
    with plugin(body) as core:
        core.step(3)
        assert physics.get_world("errors").ModelByName("box") is None
    assert "Exception" not in caplog.text


# Contacts ------------------------------------------------------------------------------------------------------------


def test_a_contact_filter_publishes_its_collisions_only(core, view):
    manager = view.Physics().GetContactManager()
    topic = manager.CreateFilter("box::mine", ["errors::box::link::c"])
    other = manager.CreateFilter("arm", "arm::leaf::c")
    assert topic == "~/box/mine/contacts"
    assert manager.HasFilter("box::mine")
    assert manager.GetFilterCount() == 2
    received = {topic: [], other: []}
    node = transport.Node()
    node.Init("errors")
    kept = [node.Subscribe(name, notes.append) for name, notes in received.items()]
    core.step(4)
    assert kept
    assert not any(message.contact for message in received[other])
    (contact,) = received[topic][-1].contact
    assert {contact.collision1, contact.collision2} == {"box::link::c", "ground::l::c"}
    assert sum(wrench.body_1_wrench.force.z for wrench in contact.wrench) == pytest.approx(
        9.8 if contact.collision1.startswith("box") else -9.8, rel=0.05
    )
    manager.RemoveFilter("box::mine")
    assert not manager.HasFilter("box::mine")
    with pytest.raises(ParameterError, match="already"):
        manager.CreateFilter("arm", "x")


def test_contacts_are_always_those_of_the_last_step(core, view):
    manager, notes = view.Physics().GetContactManager(), {"Begin": [], "End": []}
    manager.want()
    kept = [
        event.Events.ConnectWorldUpdateBegin(lambda: notes["Begin"].append(manager.GetContacts())),
        event.Events.ConnectWorldUpdateEnd(lambda: notes["End"].append(manager.GetContacts())),
    ]
    core.step(3)
    assert kept
    assert notes["Begin"][1:] == notes["End"][:-1]
    assert notes["Begin"][1] is not notes["End"][1]


# Messages, steps, files ----------------------------------------------------------------------------------------------


def test_messages_name_the_python_form_of_cpp_idioms():
    for name, given in (
        ("contact_size", "len(message.contact)"),
        ("add_contact", "message.contact.append(value)"),
        ("mutable_time", "in Python that is message.time"),
        ("has_time", "HasField('time')"),
        ("contacts", "did you mean 'contact'"),
    ):
        with pytest.raises(AttributeError, match="has no field") as raised:
            getattr(msgs.Contacts(), name)
        assert given in str(raised.value)


def test_many_requested_steps_do_not_block_the_server(core, view):
    node = transport.Node()
    node.Init("errors")
    control = node.Advertise(msgs.WorldControl, "~/world_control")
    control.Publish(msgs.WorldControl(pause=True, multi_step=4_000_000_000))
    core.step(10)
    assert view.Iterations() == 10
    control.Publish(msgs.WorldControl(pause=False))
    core.step(5)
    assert not view.IsPaused()


def test_a_joint_created_at_run_time_gets_a_free_name(core, view):
    arm = view.ModelByName("arm")
    made = view.Physics().CreateJoint("fixed")
    made.core.name = "joint_1"
    made.Load(arm.GetLink("leaf"), view.ModelByName("box").GetLink())
    made.SetModel(arm)
    assert arm.GetJointCount() == 3
    made.Fini()
    assert arm.GetJoint("joint_1") is not None


def test_a_run_after_a_reset_is_the_same_to_the_bit():
    tilted = "".join(
        BOX.replace("'box'", f"'b{i}'").replace("<pose>0 0 0.5 0 0 0<", f"<pose>0.{i} -0.{i} {1 + i} 0.{i} 1.{i} 0<")
        for i in range(4)
    )
    with libgz.World.from_string(sdf(GROUND + ARM + tilted), seed=5) as core:

        def run():
            rows = []
            for _ in range(150):
                core.step(4)
                rows.append(core.engine.states.tobytes())
                rows += [tuple(sensor.AngularVelocity()) for sensor in sensors.SensorManager.Instance().GetSensors()]
            return rows

        first = run()
        core.Reset()
        assert run() == first


def test_an_edited_plugin_is_run_again(plugin, tmp_path):
    for number in (1, 2):
        with plugin(f"number = {number}\ndef Load(self, world, sdf):\n    pass") as core:
            os.utime(tmp_path / "p.py", ns=(number, number))
            (server,) = core.companions
            assert server.plugins.of_world["p"].plugin.number == number


def test_profiles_are_created_used_and_suggested(view):
    presets = view.PresetMgr()
    presets.CreateProfile("fast")
    presets.SetProfileParam("fast", "iters", 20)
    assert presets.CurrentProfile("fast")
    assert view.Physics().GetParam("iters") == 20
    with pytest.raises(GazeboError, match="did you mean 'fast'"):
        presets.CurrentProfile("fasst")


def test_parameters_without_effect_are_kept_and_reported(view, caplog):
    engine = view.Physics()
    assert engine.GetParam("precon_iters") == 0
    engine.SetParam("precon_iters", 2)
    assert engine.GetParam("precon_iters") == 2
    assert "precon_iters is kept, and has no effect" in caplog.text
    assert engine.GetParam("explicit_gyroscopic") is False
    engine.SetParam("explicit_gyroscopic", True)
    assert view.core.engine.explicit_gyroscopic
    engine.SetParam("magnetic_field", Vector3d(1, 2, 3))
    assert view.MagneticField() == Vector3d(1, 2, 3)


def test_texts_of_sdf_are_stripped():
    root = SDF()
    plugin = "<plugin name='p' filename='f'><topic>\n a b\n </topic></plugin>"
    root.SetFromString(f"<sdf version='1.6'><model name=' m '><link name='l'/>{plugin}</model></sdf>")
    model = root.Root().GetElement("model")
    assert model.Get(str, "name") == "m"
    assert model.GetElement("plugin").Get(str, "topic") == "a b"


def test_accelerations_are_right_at_the_first_call(core, view):
    box = view.ModelByName("box").GetLink()
    box.AddForce(Vector3d(0, 0, 20))
    core.step(1)
    assert box.WorldLinearAccel().Z() == pytest.approx(10.2, rel=0.01)


# Imports --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line",
    [
        "from gazebo import *",
        "import gazebo.physics",
        "from libgz import WorldPlugin",
        "from libgz import GZ_REGISTER_WORLD_PLUGIN",
    ],
)
def test_a_wrong_import_leads_to_the_right_one(tmp_path, monkeypatch, caplog, line):
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    (tmp_path / "wrong.py").write_text(f"{line}\n")
    with libgz.World.from_string(sdf("<plugin name='wrong' filename='libwrong.so'/>")):
        assert "`from libgz.classic import *`" in caplog.text
        assert "docs/plugins.md" in caplog.text


def test_a_plugin_class_is_not_searched_in_libgz():
    with pytest.raises(AttributeError, match=r"from libgz\.classic import ModelPlugin is for plugins of SDF worlds"):
        _ = libgz.ModelPlugin
    with pytest.raises(AttributeError, match="did you mean 'Model'"):
        _ = libgz.Modell


def test_a_source_in_cxx_beside_the_world_is_to_be_built_or_ported(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    (tmp_path / "push.cc").write_text("#include <gazebo/gazebo.hh>\n")
    with libgz.World.from_string(sdf("<plugin name='push' filename='libpush.so'/>")):
        assert "push.cc is C++ source: build it, `libgz cxx build " in caplog.text
        assert "or port it to Python as push.py" in caplog.text
