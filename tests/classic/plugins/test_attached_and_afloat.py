"""Links that are attached, gripped or afloat."""

import math
from pathlib import Path

import numpy as np
import pytest
from plugin_worlds import body, collision, plugin
from topics import Heard, send

import libgz
from libgz.classic import msgs
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.physics import get_world
from libgz.classic.plugins._water import Wave, height, hull_of, waves_of
from libgz.sdf.reader import SdfFile

READY = Path(__file__).parents[3] / "examples" / "plugins" / "ready"
NAMES = ["hook", "link", "crate", "link"]


@pytest.fixture
def example():
    worlds = []

    def load(name):
        worlds.append(libgz.World.from_file(READY / f"{name}.world"))
        return worlds[-1], get_world()

    yield load
    for world in worlds:
        world.close()


def ask(core, what, names):
    kept = send(f"/link_attacher_node/{what}", msgs.GzString_V(data=names))
    core.step(5)
    return kept


def test_links_of_two_models_are_attached_and_detached(example):
    core, world = example("link_attacher")
    heard = Heard("/link_attacher_node/status")
    core.run(0.2)
    ask(core, "attach", NAMES)
    ask(core, "attach", NAMES)
    world.RemoveModel("shelf")
    core.run(1.0)
    crate, hook = world.ModelByName("crate"), world.ModelByName("hook")
    assert crate.WorldPose().Pos().Z() == pytest.approx(1.5, abs=0.01)
    state = core.get_state()
    ask(core, "detach", ["crate", "link", "hook", "link"])
    core.run(1.0)
    assert crate.WorldPose().Pos().Z() == pytest.approx(0.25, abs=0.01)
    assert hook.GetJointCount() == 1
    core.set_state(state)
    core.run(0.5)
    assert world.ModelByName("crate").WorldPose().Pos().Z() == pytest.approx(1.5, abs=0.01)
    assert [message.data.split()[0] for message in heard][:3] == ["attached", "attached", "detached"]


def test_names_that_are_wrong_are_refused(example, caplog):
    core, _ = example("link_attacher")
    heard = Heard("/link_attacher_node/status")
    for names in (["hook"], ["hok", *NAMES[1:]], ["hook", "lnk", *NAMES[2:]], ["shelf", "link", "shelf", "link"]):
        ask(core, "attach", names)
    ask(core, "detach", NAMES)
    texts = [message.data for message in heard]
    assert all(text.startswith("error: ") for text in texts)
    assert "there must be 4" in texts[0]
    assert "did you mean 'hook'" in texts[1]
    assert "did you mean 'link'" in texts[2]
    assert "do not move" in texts[3]
    assert "are not attached" in texts[4]


def test_a_static_link_holds_another_one(example):
    core, world = example("link_attacher")
    ask(core, "attach", ["shelf", "link", "crate", "link"])
    crate = world.ModelByName("crate")
    crate.SetLinearVel(Vector3d(0.0, 3.0, 3.0))
    core.run(0.5)
    assert tuple(crate.WorldPose().Pos()) == pytest.approx((0.0, 0.0, 1.5), abs=0.02)


def test_a_hand_holds_a_ball_until_it_opens(example):
    core, world = example("grasp_fix")
    hand, ball = world.ModelByName("hand"), world.ModelByName("ball")
    core.run(1.0)
    assert hand.GetJoint("hand__grasp_fix__") is not None
    ball.SetGravityMode(True)
    core.run(1.0)
    assert ball.WorldPose().Pos().Z() == pytest.approx(1.0, abs=0.01)
    for _ in range(300):
        hand.GetJoint("left").SetForce(0, -30.0)
        hand.GetJoint("right").SetForce(0, 30.0)
        core.step(1)
    core.run(1.0)
    assert hand.GetJoint("hand__grasp_fix__") is None
    assert ball.WorldPose().Pos().Z() < 0.2


def test_one_finger_does_not_hold(run):
    text = (READY / "grasp_fix.world").read_text().replace("<gripper_link>right_finger</gripper_link>", "")
    core, world = run(text.partition('<world name="default">')[2].rpartition("</world>")[0])
    core.run(1.0)
    assert world.ModelByName("hand").GetJoint("hand__grasp_fix__") is None


@pytest.mark.parametrize(("density", "depth"), [(250.0, 0.25), (500.0, 0.5), (900.0, 0.9)])
def test_a_box_floats_as_deep_as_its_density_says(density, depth, run):
    box = "<geometry><box><size>1 1 1</size></box></geometry>"
    water = plugin("buoyancy_gazebo_plugin", fluid_density=1000, fluid_level=2, linear_drag=2000, angular_drag=500,
                   buoyancy=f"<link_name>link</link_name>{box}")  # fmt: skip
    core, world = run(body("box", "0 0 2.3 0 0 0", mass=density, inside=water))
    core.run(8.0)
    assert world.ModelByName("box").WorldPose().Pos().Z() == pytest.approx(2.5 - depth, abs=0.01)
    assert world.ModelByName("box").WorldLinearVel().Length() < 0.02


def hull(shape):
    text = f"<sdf version='1.6'><model name='m'><link name='l'>{collision(shape)}</link></model></sdf>"
    return hull_of(next(SdfFile.from_string(text).root.find("geometry")))


def test_volumes_below_are_those_of_formulas():
    pose = Pose3d(1.0, 2.0, 3.0, 0.3, -0.2, 0.5)
    for shape, volume in (
        ("<box><size>1 2 3</size></box>", 6.0),
        ("<cylinder><radius>0.5</radius><length>2</length></cylinder>", 0.5 * math.pi),
        ("<sphere><radius>0.5</radius></sphere>", math.pi / 6.0),
    ):
        below = hull(shape)
        assert below.submerged(pose, 10.0, [], 0.0)[0] == pytest.approx(volume)
        assert tuple(below.submerged(pose, 10.0, [], 0.0)[1]) == pytest.approx((1.0, 2.0, 3.0))
        assert below.submerged(pose, 3.0, [], 0.0)[0] == pytest.approx(volume / 2.0, rel=1e-6)
        assert below.submerged(pose, -10.0, [], 0.0)[0] == 0.0
    volume, centre = hull("<sphere><radius>1</radius></sphere>").submerged(Pose3d(), -0.5, [], 0.0)
    assert volume == pytest.approx(math.pi * 0.25 * 2.5 / 3.0, rel=0.05)  # a cap of height 0.5
    assert centre.Z() == pytest.approx(-0.675, abs=0.02)
    volume, centre = hull("<box><size>1 1 1</size></box>").submerged(Pose3d(), 0.1, [], 0.0)
    assert (volume, centre.Z()) == pytest.approx((0.6, -0.2))


def test_waves_run_as_those_of_deep_water():
    wave = Wave(0.5, 2.0, (0.6, 0.8), 0.3)
    number = 4.0 / 9.8
    x, y = np.array([0.0, 3.0]), np.array([0.0, -1.0])
    assert height([wave], x, y, 0.0) == pytest.approx(0.5 * np.cos(number * (0.6 * x + 0.8 * y) + 0.3))
    later = height([wave], x + 0.6 * 4.0 / number, y + 0.8 * 4.0 / number, 2.0)
    assert later == pytest.approx(height([wave], x, y, 0.0))  # a crest runs at omega / k


def test_a_boat_follows_the_waves_of_another_model(example):
    core, world = example("boat")
    boat = world.ModelByName("boat")
    core.run(6.0)
    waves = waves_of(next(world.ModelByName("sea").GetSDF().named("plugin")))
    assert len(waves) == 3
    errors, heights = [], []
    for _ in range(40):
        core.run(0.1)
        place = boat.WorldPose().Pos()
        surface = float(height(waves, place.X(), place.Y(), world.SimTime().Double()))
        errors.append(place.Z() + 400.0 / 2400.0 - 0.25 - surface)
        heights.append(surface)
    assert max(heights) - min(heights) > 0.2
    assert max(map(abs, errors)) < 0.12


def test_elements_that_are_missing_are_named(run, caplog):
    run(body("a", inside=plugin("buoyancy_gazebo_plugin")))
    run(body("b", inside=plugin("buoyancy_gazebo_plugin", buoyancy="<link_name>link</link_name><geometry/>")))
    wrong = {"buoyancy": "<link_name>link</link_name><geometry><sphere><radius>1</radius></sphere></geometry>"}
    run(body("c", inside=plugin("buoyancy_gazebo_plugin", wave="<period>0</period>", **wrong)))
    run(body("d", inside=plugin("buoyancy_gazebo_plugin", wave_model="sea", **wrong)))
    many = dict.fromkeys(("north", "south"), "<wave><number>60</number></wave>")
    sea, boat = plugin("buoyancy_gazebo_plugin", **many), plugin("buoyancy_gazebo_plugin", wave_model="sea", **wrong)
    run(body("sea", inside=sea) + body("boat", inside=boat))
    steep = "<number>100</number><scale>1e200</scale>"
    run(body("steep", inside=plugin("buoyancy_gazebo_plugin", wave=steep, **wrong)))
    run(body("e", inside=plugin("gazebo_grasp_fix")))
    run(body("f", inside=plugin("gazebo_grasp_fix", arm="<palm_link>lnk</palm_link><gripper_link>link</gripper_link>")))
    for text in ("<buoyancy> is missing", "has no <box>, <cylinder> or <sphere>", "<period> and a <scale> above 0",
                 "there are more than 100 waves", "usable amplitudes",
                 "<wave_model> is 'sea'", "<arm> is missing", "no link 'lnk'; did you mean 'link'?"):  # fmt: skip
        assert text in caplog.text


# Actors ---------------------------------------------------------------------------------------------------------------


def walker(name, **elements):
    """The actor of the example with another plugin."""
    text = (READY / "actor.world").read_text().partition('<world name="default">')[2].rpartition("</world>")[0]
    head, _, tail = text.partition('<plugin name="ActorPlugin"')
    return head + plugin(name, **elements) + tail.partition("</plugin>")[2]


def test_an_actor_walks_by_velocities(run):
    core, world = run(walker("gazebo_ros_actor_command", vel_topic="/go", default_rotation=math.pi / 2.0))
    actor = world.ModelByName("walker")
    before = actor.WorldPose()
    heading = before.Rot().Yaw() - math.pi / 2.0
    message = msgs.Pose()
    msgs.Set(message, Pose3d(2.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    kept = send("/go", message)
    core.run(0.5)
    moved = actor.WorldPose().Pos() - before.Pos()
    assert (moved.X(), moved.Y()) == pytest.approx((math.cos(heading), math.sin(heading)), abs=0.02)
    assert actor.ScriptTime() == pytest.approx(4.0, abs=0.05)  # 4 s a metre
    del kept


def test_an_actor_walks_a_path(run):
    core, world = run(
        walker(
            "gazebo_ros_actor_command", follow_mode="path", path_topic="/way", linear_velocity=4, angular_velocity=10
        )
    )
    path = msgs.PosesStamped()
    for x, y in ((1.0, 2.0), (-1.0, 3.0)):
        msgs.Set(path.pose.add(), Pose3d(x, y, 0.0, 0.0, 0.0, 0.0))
    kept = send("/way", path)
    actor, seen = world.ModelByName("walker"), []
    for _ in range(100):
        core.run(0.02)
        seen.append((actor.WorldPose().Pos().X(), actor.WorldPose().Pos().Y()))
    assert min(math.dist(place, (1.0, 2.0)) for place in seen) < 0.11
    assert math.dist(seen[-1], (-1.0, 3.0)) < 0.11
    del kept


def test_limbs_of_an_actor_collide(run, caplog):
    core, world = run(walker("ActorCollisionsPlugin"))
    plain = [one for link in world.ModelByName("walker").GetLinks() for one in link.GetCollisions()]
    lengths = {one.GetName(): one.GetShape().Size().Z() for one in plain if one.GetName().count("_") >= 2}
    limbs = list(lengths)
    core.close()
    scaling = f"<scaling collision='{limbs[0]}' scale='8 8 1.5'/><scaling collision='{limbs[0]}x' scale='1 1 1'/>"
    text = walker("ActorCollisionsPlugin").replace(
        "libActorCollisionsPlugin.so'>", f"libActorCollisionsPlugin.so'>{scaling}"
    )
    core, world = run(text)
    boxes = {one.GetName(): one for link in world.ModelByName("walker").GetLinks() for one in link.GetCollisions()}
    sides = boxes[limbs[0]].GetShape().Size()
    assert tuple(sides) == pytest.approx((0.16, 0.16, 1.5 * lengths[limbs[0]]))
    assert f"did you mean '{limbs[0]}'" in caplog.text
    link, child = boxes[limbs[0]].GetLink(), limbs[0].removesuffix("_collision")
    ends = [one for one in world.ModelByName("walker").GetLinks() if child.endswith(f"_{one.GetName()}")]
    core.run(0.5)
    middle = (link.WorldPose().Pos() + ends[0].WorldPose().Pos()) * 0.5
    assert boxes[limbs[0]].WorldPose().Pos().Distance(middle) < 1e-3
    core.set_state(core.get_state())


def test_what_is_no_actor_has_no_limbs_and_walks_not(run, caplog):
    run(body("a", inside=plugin("ActorCollisionsPlugin")))
    run(body("b", inside=plugin("gazebo_ros_actor_command")))
    assert "'a' is no <actor> with a skeleton" in caplog.text
    assert "'b' is a model" in caplog.text
