"""What an SDF world says and hears on Gazebo's topics."""

import pytest

import libgz
from libgz.classic import msgs, physics, transport
from libgz.classic.math import Pose3d, Vector3d

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
def say(node, core):
    """Publish a message and let the world act on it."""

    def publish(topic, message):
        publisher = node.Advertise(type(message), topic)
        publisher.Publish(message)
        core.step(2)

    return publish


def test_statistics_and_poses_are_told(core, view, node):
    heard = {}
    kept = [
        node.Subscribe(topic, lambda message, topic=topic: heard.__setitem__(topic, message))
        for topic in ("~/world_stats", "~/pose/info", "~/physics/contacts")
    ]
    core.step(5)
    statistics = heard["~/world_stats"]
    assert (statistics.model_count, statistics.paused) == (3, False)
    assert statistics.iterations >= 1
    poses = {pose.name: pose for pose in heard["~/pose/info"].pose}
    assert poses["box"].position.z == pytest.approx(0.5, abs=1e-3)
    assert poses["arm::rod"].position.z == pytest.approx(1.0)
    assert "lamp" in poses
    assert heard["~/physics/contacts"].contact[0].collision2.startswith(("box", "ground"))
    assert len(kept) == 3


def test_a_factory_makes_models_from_text_file_and_copy(view, say):
    say("~/factory", msgs.Factory(sdf=f"<sdf version='1.6'>{BOX.format(name='new', pose='3 0 9 0 0 0')}</sdf>"))
    assert view.ModelByName("new").WorldPose().Pos().X() == pytest.approx(3.0)
    pose = msgs.Convert(Pose3d(-4, 1, 7, 0, 0, 0))
    say("~/factory", msgs.Factory(clone_model_name="new", pose=pose, edit_name="twin"))
    assert view.ModelByName("twin").WorldPose().Pos().X() == pytest.approx(-4.0)
    say("~/factory", msgs.Factory(sdf_filename="model://ground_plane", edit_name="floor"))
    assert view.ModelByName("floor").IsStatic()


def test_a_taken_name_is_refused_unless_renaming_is_allowed(view, say, caplog):
    text = f"<sdf version='1.6'>{BOX.format(name='box', pose='5 0 9 0 0 0')}</sdf>"
    say("~/factory", msgs.Factory(sdf=text))
    assert "the world has a 'box' already" in caplog.text
    say("~/factory", msgs.Factory(sdf=text, allow_renaming=True))
    assert view.ModelByName("box_0").WorldPose().Pos().X() == pytest.approx(5.0)


def test_what_is_wrong_with_a_message_is_told_and_the_world_runs_on(view, core, say, caplog):
    say("~/factory", msgs.Factory())
    say("~/model/modify", msgs.Model(name="boxx"))
    say("~/joint", msgs.JointCmd(name="arm::hing", force=1.0))
    assert "~/factory: it names neither sdf, sdf_filename nor clone_model_name" in caplog.text
    assert "there is no model 'boxx'; did you mean 'box'?" in caplog.text
    assert "there is no joint 'arm::hing'" in caplog.text
    assert view.Iterations() == 6


def test_the_world_is_paused_stepped_and_reset(view, core, say):
    say("~/world_control", msgs.WorldControl(pause=True))
    at = view.Iterations()
    core.step(5)
    assert view.Iterations() == at
    say("~/world_control", msgs.WorldControl(multi_step=7))
    core.step(10)
    assert view.Iterations() == at + 7
    assert view.IsPaused()
    reset = msgs.WorldControl(pause=False)
    reset.reset.all = True
    view.ModelByName("box").SetWorldPose(Pose3d(9, 9, 9, 0, 0, 0))
    say("~/world_control", reset)
    assert view.ModelByName("box").WorldPose().Pos().X() == pytest.approx(0.0, abs=1e-6)
    assert view.SimTime().Double() < 0.01


def test_physics_models_lights_and_joints_are_changed(view, core, say):
    physics_message = msgs.Physics(max_step_size=0.002, iters=70)
    msgs.Set(physics_message.gravity, Vector3d(0, 0, -1.5))
    say("~/physics", physics_message)
    assert view.Physics().GetMaxStepSize() == 0.002
    assert view.Physics().GetParam("iters") == 70
    assert view.Gravity().Z() == -1.5
    moved = msgs.Model(name="box", pose=msgs.Convert(Pose3d(1, 2, 0.5, 0, 0, 0)))
    say("~/model/modify", moved)
    assert view.ModelByName("box").WorldPose().Pos().Y() == pytest.approx(2.0, abs=1e-6)
    green = msgs.Light(name="lamp", diffuse=msgs.Color(r=0, g=1, b=0, a=1), range=3.5)
    say("~/light/modify", green)
    assert view.LightByName("lamp").DiffuseColor().G() == 1.0
    assert view.LightByName("lamp").Range() == pytest.approx(3.5)
    say("~/joint", msgs.JointCmd(name="arm::hinge", force=2.0))
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
    names = msgs.GzString_V.FromString(answers[0].serialized_data).data
    assert list(names) == ["ground_plane", "box", "arm", "lamp"]
    arm = msgs.Model.FromString(answers[1].serialized_data)
    assert [joint.name for joint in arm.joint] == ["arm::fix", "arm::hinge"]
    assert msgs.Physics.FromString(answers[3].serialized_data).max_step_size == 0.001
    text = msgs.GzString.FromString(answers[4].serialized_data).data
    copy = libgz.World.from_string(text)
    assert [model.GetId() for model in copy.models] == ["ground_plane", "box", "arm", "lamp"]
    copy.close()
    scene = msgs.Scene.FromString(answers[5].serialized_data)
    assert [model.name for model in scene.model] == ["ground_plane", "box", "arm"]
    assert view.ModelByName("box") is None
    assert kept.GetTopic() == "/gazebo/topics/response"


def test_the_world_saves_what_it_is(view, core, tmp_path):
    view.ModelByName("box").SetWorldPose(Pose3d(1, 2, 0.5, 0, 0, 0.3))
    view.Save(str(tmp_path / "saved.world"))
    again = libgz.World.from_file(tmp_path / "saved.world")
    pose = again.model("box").GetPose()
    assert (pose.pos.x, pose.pos.y) == pytest.approx((1.0, 2.0))
    again.close()
