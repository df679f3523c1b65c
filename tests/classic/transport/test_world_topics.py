"""The topics of an SDF world."""

import math

import pytest

import libgz
from libgz.classic import msgs, physics, transport
from libgz.classic.math import Color, Pose3d, Vector3d
from libgz.sdfworld.world import SdfWorld

BOX = """
<model name='{name}'><pose>{pose}</pose>
  <link name='link'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link>
</model>
"""
ARM = """
<model name='arm'>
  <link name='base'><pose>0 0 1 0 0 0</pose></link>
  <link name='rod'><pose>0 0 1 0 0 0</pose><gravity>0</gravity></link>
  <joint name='fix' type='fixed'><parent>world</parent><child>base</child></joint>
  <joint name='hinge' type='revolute'><parent>base</parent><child>rod</child><axis><xyz>0 0 1</xyz></axis></joint>
</model>
"""
LAMP = "<light name='lamp' type='point'><pose>0 0 5 0 0 0</pose></light>"
GROUND = "<include><uri>model://ground_plane</uri></include>"


@pytest.fixture
def core(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    inside = GROUND + BOX.format(name="box", pose="0 0 0.5 0 0 0") + ARM + LAMP
    world = libgz.World.from_string(f"<sdf version='1.6'><world name='topics'>{inside}</world></sdf>")
    yield world
    world.close()


@pytest.fixture
def view(core):
    return physics.get_world("topics")


@pytest.fixture
def node(view):
    node = transport.Node()
    node.Init("topics")
    yield node
    node.Fini()


@pytest.fixture
def send(node, core):
    """Publish a message and let the world act on it."""

    def publish(topic, message):
        publisher = node.Advertise(type(message), topic)
        publisher.Publish(message)
        core.step(2)

    return publish


def test_statistics_and_poses_are_published(core, view, node):
    received = {}
    kept = [
        node.Subscribe(topic, lambda message, topic=topic: received.__setitem__(topic, message))
        for topic in ("~/world_stats", "~/pose/info", "~/physics/contacts")
    ]
    core.step(5)
    statistics = received["~/world_stats"]
    assert (statistics.model_count, statistics.paused) == (3, False)
    assert statistics.iterations >= 1
    poses = {pose.name: pose for pose in received["~/pose/info"].pose}
    assert poses["box"].position.z == pytest.approx(0.5, abs=1e-3)
    assert poses["arm::rod"].position.z == pytest.approx(1.0)
    assert "lamp" in poses
    assert received["~/physics/contacts"].contact[0].collision2.startswith(("box", "ground"))
    assert len(kept) == 3


# What `gz topic -i` of Gazebo 11.1 says of the topics to which only its server subscribes: `gz topic -p` needs that.
COMMANDED = {
    "atmosphere": "Atmosphere", "box/link/wrench": "Wrench", "arm/rod/wrench": "Wrench", "arm/joint_cmd": "JointCmd",
    "factory": "Factory", "physics": "Physics", "undo_redo": "UndoRedo",
    "user_cmd": "UserCmd", "wind": "Wind", "world_control": "WorldControl",
}  # fmt: skip


def test_the_types_of_all_topics_are_known(core, node):
    manager = transport.TopicManager.Instance()
    found = {name: manager.TopicInfo(name).msg_type.removeprefix("gazebo.msgs.") for name in manager.TopicNames()}
    assert {name: found.get(f"/gazebo/topics/{name}") for name in COMMANDED} == COMMANDED
    assert found["/gazebo/server/control"] == "ServerControl"
    assert [name for name, kind in found.items() if not kind] == []


def test_the_factory_makes_models_from_text_file_and_copy(view, send):
    send("~/factory", msgs.Factory(sdf=f"<sdf version='1.6'>{BOX.format(name='new', pose='3 0 9 0 0 0')}</sdf>"))
    assert view.ModelByName("new").WorldPose().Pos().X() == pytest.approx(3.0)
    pose = msgs.Convert(Pose3d(-4, 1, 7, 0, 0, 0))
    send("~/factory", msgs.Factory(clone_model_name="new", pose=pose, edit_name="twin"))
    assert view.ModelByName("twin").WorldPose().Pos().X() == pytest.approx(-4.0)
    send("~/factory", msgs.Factory(sdf_filename="model://ground_plane", edit_name="floor"))
    assert view.ModelByName("floor").IsStatic()


def test_a_taken_name_is_refused_unless_renaming_is_allowed(view, send, caplog):
    text = f"<sdf version='1.6'>{BOX.format(name='box', pose='5 0 9 0 0 0')}</sdf>"
    send("~/factory", msgs.Factory(sdf=text, allow_renaming=False))
    assert "A model named [box] already exists and allow_renaming is false. Model won't be inserted." in caplog.text
    send("~/factory", msgs.Factory(sdf=text, allow_renaming=True))
    assert view.ModelByName("box_0").WorldPose().Pos().X() == pytest.approx(5.0)
    view.ModelByName("box_0").SetName("other")
    send("~/factory", msgs.Factory(sdf=text.replace("'box'", "'other'"), allow_renaming=False))
    assert "A model named [other] already exists" in caplog.text


def test_an_invalid_message_is_reported_and_the_world_runs_on(view, core, send, caplog):
    send("~/factory", msgs.Factory())
    send("~/model/modify", msgs.Model(name="boxx"))
    send("~/arm/joint_cmd", msgs.JointCmd(name="arm::hing", force=1.0))
    assert "~/factory: it names neither sdf, sdf_filename nor clone_model_name" in caplog.text
    assert "there is no model 'boxx'; did you mean 'box'?" in caplog.text
    assert "there is no joint 'arm::hing'" in caplog.text
    assert view.Iterations() == 6


def test_the_world_is_paused_stepped_and_reset(view, core, send):
    send("~/world_control", msgs.WorldControl(pause=True))
    at = view.Iterations()
    core.step(5)
    assert view.Iterations() == at
    send("~/world_control", msgs.WorldControl(multi_step=7))
    core.step(10)
    assert view.Iterations() == at + 7
    assert view.IsPaused()
    send("~/world_control", msgs.WorldControl(step=False))  # Gazebo asks only whether it is there
    core.step(3)
    assert view.Iterations() == at + 8
    send("~/world_control", msgs.WorldControl(pause=False))
    core.step(3)
    send("~/world_control", msgs.WorldControl(pause=False, multi_step=4))
    before = view.Iterations()
    core.step(10)
    assert view.IsPaused()
    assert before <= view.Iterations() <= before + 4
    reset = msgs.WorldControl(pause=False)
    reset.reset.all = True
    view.ModelByName("box").SetWorldPose(Pose3d(9, 9, 9, 0, 0, 0))
    send("~/world_control", reset)
    assert view.ModelByName("box").WorldPose().Pos().X() == pytest.approx(0.0, abs=1e-6)
    assert view.SimTime().Double() < 0.01


@pytest.mark.parametrize(
    ("parts", "expected"),  # iterations, as Gazebo 11.1 counts them
    [({"all": True}, 29), ({"time_only": True}, 29), ({"model_only": True}, 130)],
    ids=["all", "time", "models"],
)
@pytest.mark.parametrize("paused", [True, False])
def test_a_reset_comes_before_the_steps_of_its_message(view, core, send, parts, expected, paused):
    send("~/world_control", msgs.WorldControl(pause=True))
    send("~/world_control", msgs.WorldControl(multi_step=100 - view.Iterations()))
    core.step(150)
    assert view.Iterations() == 100
    both = msgs.WorldControl(multi_step=30, pause=paused)
    for part in parts:
        setattr(both.reset, part, True)
    send("~/world_control", both)
    core.step(60)
    assert (view.Iterations(), view.IsPaused()) == (expected, True)


def test_a_reset_does_not_end_requested_steps_and_the_world_is_paused_after_them(view, core, send):
    send("~/world_control", msgs.WorldControl(multi_step=50))
    core.step(20)
    assert not view.IsPaused()
    view.Reset()
    core.step(60)
    assert view.IsPaused()
    assert 25 <= view.Iterations() <= 40
    send("~/world_control", msgs.WorldControl(step=True, multi_step=5))
    before = view.Iterations()
    core.step(10)
    assert before <= view.Iterations() <= before + 5


@pytest.mark.parametrize(
    ("parts", "moved", "time"),
    [
        ({"time_only": True}, True, 0.0),
        ({"model_only": True}, False, 0.05),
        ({"time_only": True, "model_only": True}, False, 0.0),
        ({"time_only": True, "all": True}, False, 0.0),
        ({}, False, 0.0),
    ],
)
def test_a_reset_may_be_of_the_time_or_of_the_models(view, core, send, parts, moved, time):
    core.step(50)
    view.ModelByName("box").SetWorldPose(Pose3d(9, 9, 0.5, 0, 0, 0))
    message = msgs.WorldControl()
    message.reset.SetInParent()
    for name, value in parts.items():
        setattr(message.reset, name, value)
    send("~/world_control", message)
    assert view.ModelByName("box").WorldPose().X() == pytest.approx(9.0 if moved else 0.0, abs=1e-3)
    assert view.SimTime().Double() == pytest.approx(time, abs=0.004)


def test_physics_models_lights_and_joints_are_changed(view, core, send):
    physics_message = msgs.Physics(max_step_size=0.002, iters=70)
    msgs.Set(physics_message.gravity, Vector3d(0, 0, -1.5))
    send("~/physics", physics_message)
    assert view.Physics().GetMaxStepSize() == 0.002
    assert view.Physics().GetParam("iters") == 70
    assert view.Gravity().Z() == -1.5
    moved = msgs.Model(name="box", pose=msgs.Convert(Pose3d(1, 2, 0.5, 0, 0, 0)))
    send("~/model/modify", moved)
    assert view.ModelByName("box").WorldPose().Pos().Y() == pytest.approx(2.0, abs=1e-6)
    green = msgs.Light(name="lamp", diffuse=msgs.Color(r=0, g=1, b=0, a=1), range=3.5)
    send("~/light/modify", green)
    assert view.LightByName("lamp").DiffuseColor().G() == 1.0
    assert view.LightByName("lamp").Range() == pytest.approx(3.5)
    send("~/arm/joint_cmd", msgs.JointCmd(name="arm::hinge", force=2.0))
    core.step(100)
    hinge = view.ModelByName("arm").GetJoint("hinge")
    assert hinge.GetVelocity(0) == pytest.approx(2.0 * 0.002 * 101, rel=0.03)


def test_requests_are_answered(view, node, core):
    answers = []
    kept = node.Subscribe("~/response", answers.append)
    publisher = node.Advertise(msgs.Request, "~/request")
    for number, (request, data) in enumerate(
        (("entity_list", ""), ("entity_info", "arm"), ("entity_info", "none"), ("physics_info", ""), ("world_sdf", ""),
         ("scene_info", ""), ("entity_delete", "box"))
    ):  # fmt: skip
        publisher.Publish(msgs.Request(id=number, request=request, data=data))
    core.step(3)
    assert [a.response for a in answers] == ["success", "success", "nonexistent", *["success"] * 4]
    assert answers[2].type == "error"
    models = msgs.Model_V.FromString(answers[0].serialized_data).models
    assert [model.name for model in models] == ["ground_plane", "box", "arm"]
    arm = msgs.Model.FromString(answers[1].serialized_data)
    assert [joint.name for joint in arm.joint] == ["arm::fix", "arm::hinge"]
    assert msgs.Physics.FromString(answers[3].serialized_data).max_step_size == 0.001
    text = msgs.GzString.FromString(answers[4].serialized_data).data
    copy = libgz.World.from_string(text)
    assert [model.GetId() for model in copy.entities] == ["ground_plane", "box", "arm", "lamp"]
    copy.close()
    scene = msgs.Scene.FromString(answers[5].serialized_data)
    assert [model.name for model in scene.model] == ["ground_plane", "box", "arm"]
    assert view.ModelByName("box") is None
    assert kept.GetTopic() == "/gazebo/topics/response"


def test_the_world_saves_its_present_poses(view, core, tmp_path):
    view.ModelByName("box").SetWorldPose(Pose3d(1, 2, 0.5, 0, 0, 0.3))
    view.Save(str(tmp_path / "saved.world"))
    again = libgz.World.from_file(tmp_path / "saved.world")
    pose = again.model("box").GetPose()
    assert (pose.pos.x, pose.pos.y) == pytest.approx((1.0, 2.0))
    again.close()


def test_all_messages_to_the_factory_of_one_iteration_take_effect(core, view, node):
    factory = node.Advertise(msgs.Factory, "~/factory")
    text = f"<sdf version='1.6'>{BOX.format(name='box', pose='5 0 9 0 0 0')}</sdf>"
    for _ in range(3):
        factory.Publish(msgs.Factory(sdf=text, allow_renaming=True))
        factory.Publish(msgs.Factory(clone_model_name="arm"))
    factory.Publish(msgs.Factory(clone_model_name="box_1"))
    core.step(1)
    made = {model.GetName() for model in view.Models()} - {"box", "arm", "ground_plane"}
    assert made == {"box_0", "box_1", "box_2", "arm_clone", "arm_clone_0", "arm_clone_1", "box_1_clone"}


def test_a_light_from_the_factory_has_the_values_of_the_message(core, view, send):
    lamp = msgs.Light(name="new", type=msgs.Light.SPOT, range=7.0, attenuation_linear=0.5)
    msgs.Set(lamp.pose, Pose3d(1, 2, 3, 0, 0, 0))
    msgs.Set(lamp.diffuse, Color(1, 0, 0, 1))
    send("~/factory/light", lamp)
    light = view.LightByName("new")
    assert (light.LightType(), light.Range(), light.Attenuation()[1]) == ("spot", 7.0, 0.5)
    assert light.WorldPose().Pos() == Vector3d(1, 2, 3)
    assert tuple(light.DiffuseColor())[:3] == (1, 0, 0)


@pytest.mark.parametrize(
    ("message", "given"),
    [
        (msgs.Light(), "a light needs a name"),
        (msgs.Light(name="new", attenuation_linear=math.nan), "attenuation is"),
        (msgs.Light(name="new", range=math.nan), "the range of a light"),
        (msgs.Light(name="new", spot_outer_angle=math.nan), "the cone of the light is"),
        (msgs.Light(name="new", direction=msgs.Vector3d(x=1e308, y=0, z=0)), "direction is"),
        (msgs.Light(name="new", direction=msgs.Vector3d(x=0, y=math.inf, z=0)), "direction is"),
    ],
)
def test_an_invalid_light_is_not_made(view, send, caplog, message, given):
    send("~/factory/light", message)
    assert given in caplog.text
    assert [light.GetName() for light in view.Lights()] == ["lamp"]


@pytest.mark.parametrize("name", ["topics", "rod"])
def test_a_light_may_have_the_name_of_the_world_or_a_link(view, send, caplog, name):
    send("~/factory/light", msgs.Light(name=name, range=math.nan))
    assert "the range of a light" in caplog.text
    assert [light.GetName() for light in view.Lights()] == ["lamp"]
    send("~/factory/light", msgs.Light(name=name, range=7.0))
    assert view.LightByName(name).Range() == 7.0
    view.RemoveModel(name)
    assert [light.GetName() for light in view.Lights()] == ["lamp"]


def test_a_world_with_any_wrenches_and_lights_can_be_brought_back(core, view, send):
    """A refused state is undone by one of the world itself, which must therefore never be refused."""
    send("~/light/modify", msgs.Light(name="lamp", attenuation_constant=1e30, range=math.inf))
    for number in (1e308, -1e308):
        message = msgs.Wrench()
        msgs.Set(message.force, Vector3d(number, 0, number))
        msgs.Set(message.torque, Vector3d(number, number, 0))
        msgs.Set(message.force_offset, Vector3d(0, 1e9, -1e9))
        send("~/box/link/wrench", message)
        send("~/box/link/wrench", message)
        view.ModelByName("box").GetLink("link").AddForceAtWorldPosition((number, number, number), (1e9, -1e9, 1e9))
        send("~/model/modify", msgs.Model(name="ground_plane", scale=msgs.Vector3d(x=number, y=math.nan, z=1)))
        core.snapshots.restore(core.get_state(), anew=True)
        core.step(2)
    core.engine.record_contacts = True
    core.step(1)
    view.RemoveModel("ground_plane")  # which is in contact
    core.snapshots.restore(core.get_state(), anew=True)
    assert all(map(math.isfinite, view.ModelByName("box").WorldPose().Pos()))


def test_a_model_is_not_suggested_for_a_light(send, caplog):
    send("~/light/modify", msgs.Light(name="box", range=3.0))
    assert "there is no light 'box'\n" in caplog.text + "\n"
    assert "did you mean" not in caplog.text


def test_contacts_are_recorded_while_there_are_subscribers(core, view, node):
    received = []
    listening = node.Subscribe("~/physics/contacts", received.append)
    core.step(4)
    assert [contact.collision1 for contact in received[-1].contact]
    listening.Unsubscribe()
    core.step(1)
    assert not core.engine.record_contacts


def test_the_magnetic_field_is_kept_in_one_place(core, view, send):
    view.SetMagneticField((1e-5, 2e-5, 3e-5))
    assert core.extension(SdfWorld).settings.magnetic_field == view.MagneticField() == Vector3d(1e-5, 2e-5, 3e-5)
    message = msgs.Physics(real_time_factor=0.5)
    msgs.Set(message.magnetic_field, Vector3d(0, 0, 1e-5))
    send("~/physics", message)
    assert view.Physics().GetParam("magnetic_field") == Vector3d(0, 0, 1e-5)
    assert view.Physics().GetTargetRealTimeFactor() == 0.5


def test_parameters_without_effect_are_those_of_the_file():
    inside = "<real_time_factor>0.25</real_time_factor><ode><solver><precon_iters>3</precon_iters></solver></ode>"
    text = f"<sdf version='1.6'><world name='w'><physics type='ode'>{inside}</physics></world></sdf>"
    with libgz.World.from_string(text):
        physics_engine = physics.get_world().Physics()
        assert physics_engine.GetTargetRealTimeFactor() == physics_engine.GetParam("real_time_factor") == 0.25
        assert physics_engine.GetParam("precon_iters") == 3
        assert physics_engine.GetParam("contact_surface_layer") == 0.001


def poses(view):
    return [view.ModelByName("box").WorldPose().Pos().X(), view.LightByName("lamp").WorldPose().Pos().X()]


def test_user_commands_are_undone_and_repeated(view, core, node, send):
    lists = []
    kept = node.Subscribe("~/user_cmd_stats", lists.append)
    for number in (1.0, 2.0, 3.0):
        command = msgs.UserCmd(description=f"Move to {number}", type="MOVING")
        command.model.add(name="box", pose=msgs.Convert(Pose3d(number, 0, 0.5, 0, 0, 0)))
        command.light.add(name="lamp", pose=msgs.Convert(Pose3d(number, 0, 5, 0, 0, 0)))
        send("~/user_cmd", command)
    assert poses(view) == pytest.approx([3.0, 3.0])
    assert [one.id for one in lists[-1].undo_cmd] == [0, 1, 2]
    send("~/undo_redo", msgs.UndoRedo(undo=True))
    assert poses(view) == pytest.approx([2.0, 2.0])
    assert (lists[-1].undo_cmd_count, lists[-1].redo_cmd_count) == (2, 1)
    send("~/undo_redo", msgs.UndoRedo(undo=True, id=0))
    assert poses(view) == pytest.approx([0.0, 0.0], abs=1e-6)
    assert [one.description for one in lists[-1].redo_cmd] == ["Move to 3.0", "Move to 2.0", "Move to 1.0"]
    send("~/undo_redo", msgs.UndoRedo(undo=False))
    assert poses(view) == pytest.approx([1.0, 1.0])
    send("~/undo_redo", msgs.UndoRedo(undo=False, id=2))
    assert poses(view) == pytest.approx([3.0, 3.0])
    assert (lists[-1].undo_cmd_count, lists[-1].redo_cmd_count) == (3, 0)
    send("~/undo_redo", msgs.UndoRedo(undo=True))
    command.model[0].pose.position.x = 7.0
    send("~/user_cmd", command)
    assert poses(view)[0] == pytest.approx(7.0)
    assert (lists[-1].undo_cmd_count, lists[-1].redo_cmd_count) == (3, 0)
    del kept


def test_what_cannot_be_undone_is_reported(view, send, caplog):
    send("~/undo_redo", msgs.UndoRedo(undo=True))
    assert "~/undo_redo: no command can be undone" in caplog.text
    command = msgs.UserCmd(description="Pause", type="WORLD_CONTROL")
    command.world_control.pause = True
    send("~/user_cmd", command)
    assert view.IsPaused()
    send("~/undo_redo", msgs.UndoRedo(undo=True, id=5))
    assert "command 5 cannot be undone; those that can are [0]" in caplog.text


def test_a_deletion_and_a_wrench_are_user_commands_too(view, core, send):
    command = msgs.UserCmd(description="Reset", type="WORLD_CONTROL")
    view.ModelByName("box").SetWorldPose(Pose3d(4, 0, 0.5, 0, 0, 0))
    command.world_control.reset.all = True
    send("~/user_cmd", command)
    assert poses(view)[0] == pytest.approx(0.0, abs=1e-6)
    send("~/undo_redo", msgs.UndoRedo(undo=True))
    assert poses(view)[0] == pytest.approx(4.0, abs=1e-6)
    push = msgs.UserCmd(description="Push", type="WRENCH", entity_name="arm::rod")
    push.wrench.force.x = push.wrench.force.y = push.wrench.force.z = 0.0
    push.wrench.torque.x = push.wrench.torque.y = 0.0
    push.wrench.torque.z = 10.0
    send("~/user_cmd", push)
    assert view.ModelByName("arm").GetJoint("hinge").GetVelocity(0) == pytest.approx(10.0 * 0.001, rel=0.05)
    send("~/arm/rod/wrench", push.wrench)
    assert view.ModelByName("arm").GetJoint("hinge").GetVelocity(0) == pytest.approx(20.0 * 0.001, rel=0.05)


def test_the_look_of_the_scene_is_changed(view, core, node, send):
    message = msgs.Scene(name="topics", shadows=False)
    msgs.Set(message.ambient, Color(0.1, 0.2, 0.3, 1))
    msgs.Set(message.background, Color(0.4, 0.5, 0.6, 1))
    message.fog.type, message.fog.density = "LINEAR", 0.5
    send("~/scene", message)
    assert tuple(core.backdrop.ambient)[:3] == pytest.approx((0.1, 0.2, 0.3))
    assert tuple(core.skyColor)[:3] == pytest.approx((0.4, 0.5, 0.6))
    assert (core.backdrop.shadows, core.fogEnable, core.fogDensity) == (False, True, 0.5)
    answers = []
    kept = node.Subscribe("~/response", answers.append)
    send("~/request", msgs.Request(id=1, request="scene_info"))
    scene = msgs.Scene.FromString(answers[0].serialized_data)
    assert (scene.ambient.g, scene.background.b) == pytest.approx((0.2, 0.6))
    del kept


def test_changes_are_published(view, core, node, send):
    received = {}
    kept = [
        node.Subscribe(topic, lambda message, topic=topic: received.__setitem__(topic, message))
        for topic in ("~/model/info", "~/light", "~/joint", "~/diagnostics")
    ]
    send("~/model/modify", msgs.Model(name="box", pose=msgs.Convert(Pose3d(2, 0, 0.5, 0, 0, 0))))
    assert received["~/model/info"].pose.position.x == pytest.approx(2.0)
    send("~/light/modify", msgs.Light(name="lamp", range=7.0))
    assert (received["~/light"].name, received["~/light"].range) == ("lamp", 7.0)
    view.InsertModelString(f"<sdf version='1.6'>{ARM.replace('arm', 'arm2')}</sdf>")
    core.step(2)
    assert received["~/joint"].name == "arm2::hinge"
    send("~/arm2/joint_cmd", msgs.JointCmd(name="arm2::hinge", force=2.0))
    core.step(10)
    assert view.ModelByName("arm2").GetJoint("hinge").GetVelocity(0) > 0.0
    assert received["~/diagnostics"].sim_time.nsec > 0
    assert len(kept) == 4


def test_repeated_and_long_errors_of_messages_do_not_fill_the_log(core, node, caplog):
    factory = node.Advertise(msgs.Factory, "~/factory")
    inside = "<link name='a'/><joint name='j' type='x'/>"
    text = f"<sdf version='1.6'><model name='{'x' * 50_000}'>{inside}</model></sdf>"
    for _ in range(150):
        factory.Publish(msgs.Factory(sdf=text))
    core.step(2)
    errors = [record.getMessage() for record in caplog.records if "~/factory" in record.getMessage()]
    assert len(errors) == 2
    assert "(100 times so far)" in errors[1]
    assert all(len(text) < 3000 for text in errors)


INSERTED = {
    "warnings of the reader, the file and a sensor": (
        "<model name='m'><include><uri>model://none</uri></include><link name='l'><other/>"
        "<sensor name='s' type='none'/></link></model>",
        3,
    ),
    "a plugin that fails": ("<model name='m'><link name='l'/><plugin name='p' filename='failing.py'/></model>", 1),
}
FAILING = """from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
class Failing(ModelPlugin):
    def Load(self, model, sdf):
        raise ValueError
GZ_REGISTER_MODEL_PLUGIN(Failing)
"""


@pytest.mark.parametrize("name", INSERTED)
def test_what_insertions_cause_does_not_fill_the_log(name, core, node, caplog, tmp_path, monkeypatch):
    (tmp_path / "failing.py").write_text(FAILING)
    monkeypatch.chdir(tmp_path)
    factory, (text, lines) = node.Advertise(msgs.Factory, "~/factory"), INSERTED[name]
    for _ in range(150):
        factory.Publish(msgs.Factory(sdf=f"<sdf version='1.6'>{text}</sdf>"))
        core.step(2)
        core.remove(core.entities[-1:])
    assert len(caplog.messages) == 2 * lines
    assert all(text.endswith("(100 times so far)") for text in caplog.messages[lines:])
    assert all("\\n" not in text for text in caplog.messages)  # tracebacks can be read
    assert len(core.warnings) + len(core.errors) >= 150 * lines  # all are problems
