"""Actor: what plugins do with actors."""

import pytest

import libgz
from libgz.base.errors import ParameterError
from libgz.classic.common import SkeletonAnimation
from libgz.classic.physics import Actor, Base, Model, TrajectoryInfo
from libgz.classic.server import attach

SKIN = (
    "<skin><filename>media/models/walk.dae</filename></skin>"
    "<animation name='walking'><filename>media/models/walk.dae</filename></animation>"
)
SCRIPT = (
    "<script><trajectory id='0' type='walking'><waypoint><time>0</time><pose>0 0 0 0 0 0</pose></waypoint>"
    "<waypoint><time>2</time><pose>2 0 0 0 0 0</pose></waypoint></trajectory></script>"
)
ACTOR = f"<actor name='man'><pose>0 0 0 0 0 0</pose>{SKIN}{SCRIPT}%s</actor>"

PLUGIN = """
from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.event import Events
from libgz.classic.math import Pose3d
from libgz.classic.physics import TrajectoryInfo


class Walk(ModelPlugin):
    STATE = ("x",)

    def Load(self, actor, sdf):
        self.actor, self.x = actor, 0.0
        info = TrajectoryInfo()
        info.type = "walking"
        assert "walking" in actor.SkeletonAnimations()
        actor.SetCustomTrajectory(info)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self, info):
        self.x += 0.001
        self.actor.SetWorldPose(Pose3d(self.x, 5, 1.2, 1.5707, 0, 1.5707))
        self.actor.SetScriptTime(self.actor.ScriptTime() + 0.001)


GZ_REGISTER_MODEL_PLUGIN(Walk)
"""


def test_an_actor_is_a_model_with_animations(run):
    core, world = run(ACTOR % "")
    actor = world.ModelByName("man")
    assert isinstance(actor, Actor)
    assert isinstance(actor, Model)
    assert actor.HasType(Base.ACTOR)
    assert actor.IsStatic()
    animation = actor.SkeletonAnimations()["walking"]
    assert isinstance(animation, SkeletonAnimation)
    assert animation.Length() == pytest.approx(1.2)
    assert animation.NodeCount() == 17
    assert animation.HasNode("Head")
    assert animation.PoseAt(0.0)["Hips"].Pos().Z() == pytest.approx(0.95, abs=0.01)
    assert animation.PoseAtX(0.72, "Hips")["Hips"].Pos().X() == pytest.approx(0.72)
    assert actor.GetLink("LeftHand").WorldPose().Pos().Z() > 0.5
    core.step(1000)
    assert actor.ScriptTime() == pytest.approx(1.0, abs=0.034)
    actor.Stop()
    assert not actor.IsActive()
    before = actor.WorldPose()
    core.step(500)
    assert actor.WorldPose() == before
    actor.Play()
    core.step(34)
    assert actor.WorldPose().Pos().X() < 0.1


def test_a_plugin_moves_an_actor(run, tmp_path):
    (tmp_path / "walk.py").write_text(PLUGIN)
    core, world = run(ACTOR % "<plugin name='walk' filename='libwalk.so'/>")
    actor = world.ModelByName("man")
    core.step(500)
    pose = actor.WorldPose()
    assert pose.Pos().X() == pytest.approx(0.5)
    assert pose.Pos().Y() == 5.0
    assert actor.CustomTrajectory().type == "walking"
    assert actor.GetLink("Head").WorldPose().Pos().Z() == pytest.approx(1.8, abs=0.1)
    state = core.get_state()
    core.step(200)
    later = [link.WorldPose() for link in actor.GetLinks()]
    core.set_state(state)
    core.step(200)
    assert [link.WorldPose() for link in actor.GetLinks()] == later
    actor.ResetCustomTrajectory()
    assert actor.CustomTrajectory() is None


def test_wrong_values_are_errors(run):
    _, world = run(ACTOR % "")
    actor = world.ModelByName("man")
    with pytest.raises(ParameterError, match="no animation 'run'; it has walking"):
        actor.SetCustomTrajectory(TrajectoryInfo(type="run"))
    with pytest.raises(ParameterError, match="script time"):
        actor.SetScriptTime(float("nan"))


def test_actors_are_inserted_removed_and_saved(run, tmp_path):
    core, world = run("")
    world.InsertModelString(f"<sdf version='1.6'>{ACTOR % ''}</sdf>")
    core.step(40)
    actor = world.ModelByName("man")
    assert isinstance(actor, Actor)
    core.step(500)
    assert actor.ScriptTime() == pytest.approx(0.5, abs=0.04)
    world.Save(str(tmp_path / "saved.world"))
    assert (tmp_path / "saved.world").read_text().count("<actor") == 1
    world.RemoveModel("man")
    core.step(2)
    assert world.ModelByName("man") is None


def test_an_actor_of_a_plugin_begins_at_its_pose():
    still = f"<actor name='man'><pose>0 1 1.2 0 0 0</pose>{SKIN}</actor>"
    text = f"<sdf version='1.6'><world name='w'>{still}</world></sdf>"
    with libgz.World.from_string(text) as world:
        actor = attach(world).world.ModelByName("man")
        actor.SetCustomTrajectory(TrajectoryInfo(type="walking"))
        assert list(actor.WorldPose().Pos()) == [0.0, 1.0, 1.2]
