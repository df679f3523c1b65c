"""Actors: trajectories, skeletons, skins in images, states."""

import math

import numpy as np
import pytest
from bone_files import two_bones
from sample_files import sample

import libgz
from libgz.base.geometry import GzQuaternToEuler
from libgz.physics.geoms import SkinGeom
from libgz.sdfworld.actor import SdfActor

FRAME = 0.034  # [s] between two poses at 1 ms


def waypoints(*rows):
    return "".join(f"<waypoint><time>{time}</time><pose>{pose}</pose></waypoint>" for time, pose in rows)


def trajectory(*rows, kind="walk", number=0, more=""):
    return f"<trajectory id='{number}' type='{kind}' {more}>{waypoints(*rows)}</trajectory>"


def actor(script="", inside="", name="a", pose="0 0 0 0 0 0"):
    return f"<actor name='{name}'><pose>{pose}</pose>{inside}<script>{script}</script></actor>"


def skin(file="media/models/walk.dae", more="", name="walk", path_along_x=True):
    return (
        f"<skin><filename>{file}</filename>{more}</skin><animation name='{name}'><filename>{file}</filename>{more}"
        f"<interpolate_x>{str(path_along_x).lower()}</interpolate_x></animation>"
    )


@pytest.fixture
def load():
    worlds = []

    def make(*parts, **options):
        text = f"<sdf version='1.6'><world name='default'>{''.join(parts)}</world></sdf>"
        worlds.append(libgz.World.from_string(text, **options))
        return worlds[-1]

    yield make
    for world in worlds:
        world.close()


def go_to(world, time):
    while world.GetSimTime() < time - 1e-9:
        world.Step()


LINE = ((0, "0 0 1 0 0 0"), (1, "1 0 1 0 0 0"), (2, "2 0 1 0 0 0"), (3, "3 0 1 0 0 0"))


def test_an_actor_moves_through_its_waypoints(load):
    world = load(actor(trajectory(*LINE)))
    found = world.model("a")
    for time in (1.0, 1.5, 2.0):
        go_to(world, time)
        # between inner waypoints of one distance the velocity is constant; the last pose is a frame old at most
        assert found.GetPose().pos.x == pytest.approx(time, abs=FRAME)
        assert found.GetPose().pos.x <= time + 1e-9
        if time > 1.0:
            assert found.GetPose().pos.x == pytest.approx(found.script_time, abs=1e-12)
        assert found.GetPose().pos.z == 1.0


def test_an_actor_turns_and_goes_through_all_its_trajectories(load):
    first = trajectory((0, "0 0 0 0 0 3"), (1, "0 0 0 0 0 3.2831853"))
    second = trajectory((0, "0 0 0 0 0 0"), (1, "0 4 0 0 0 0"), kind="walk", number=1)
    world = load(actor(second + first))
    go_to(world, 0.5)
    assert abs(GzQuaternToEuler(world.model("a").GetPose().rot).z) > 3.0
    go_to(world, 1.999)
    assert world.model("a").GetPose().pos.y == pytest.approx(4.0, abs=0.2)


def test_a_single_waypoint_lasts_until_its_time(load):
    """As in Gazebo: so actors wait, or walk on the spot."""
    stays, goes = trajectory((2, "5 0 0 0 0 0")), trajectory((0, "0 0 0 0 0 0"), (1, "0 4 0 0 0 0"), number=1)
    world = load(actor(stays + goes))
    go_to(world, 1.9)
    assert tuple(world.model("a").GetPose().pos) == (5.0, 0.0, 0.0)
    go_to(world, 2.999)
    assert world.model("a").GetPose().pos.y == pytest.approx(4.0, abs=0.2)


def test_scripts_are_delayed_and_repeated_or_end(load):
    def script(loop):
        return f"<loop>{loop}</loop><delay_start>0.5</delay_start>{trajectory(*LINE)}"

    world = load(
        actor(script("true"), name="again", pose="0 5 1 0 0 0"),
        actor(script("false"), name="once"),
        actor(f"<auto_start>false</auto_start>{trajectory(*LINE)}", name="never", pose="7 0 0 0 0 0"),
    )
    go_to(world, 0.49)
    assert tuple(world.model("again").GetPose().pos) == (0.0, 5.0, 1.0)
    go_to(world, 3.99)  # the delay comes before each cycle, whose first pose was already taken
    assert world.model("again").GetPose().pos.x < 2 * FRAME
    go_to(world, 5.0)
    assert world.model("again").GetPose().pos.x == pytest.approx(1.0, abs=2 * FRAME)
    assert world.model("once").GetPose().pos.x == 3.0
    assert world.model("never").GetPose().pos.x == 7.0


def test_tension_straightens_a_way(load):
    rows = ((0, "0 0 0 0 0 0"), (1, "1 0 0 0 0 0"), (2, "1 1 0 0 0 0"))
    world = load(actor(trajectory(*rows, more="tension='1'")), actor(trajectory(*rows), name="b"))
    off = {"a": 0.0, "b": 0.0}
    while world.GetSimTime() < 1.0:
        world.Step()
        for name in off:
            off[name] = max(off[name], abs(world.model(name).GetPose().pos.y))
    assert off["a"] < 1e-3
    assert off["b"] > 0.02


def test_an_actor_without_trajectories_plays_its_animation_where_it_stands(load):
    bare = actor(inside=skin(), name="none", pose="5 0 1 0 0 0.7").replace("<script></script>", "")
    world = load(
        bare,
        actor(inside=skin(), name="empty", pose="0 5 1 0 0 0.7"),
        actor(inside="<skin><filename>walk.dae</filename></skin>", name="skin", pose="0 9 1 0 0 0.7"),
        actor("<auto_start>0</auto_start>", skin(), name="still", pose="9 9 1 0 0 0.7"),
        actor(trajectory(), skin(), name="walks", pose="-9 0 1 0 0 0"),
        actor(name="box", inside="<link name='l'/>", pose="9 0 1 0 0 0.7").replace("<script></script>", ""),
    )
    places = {"none": (5, 0), "empty": (0, 5), "skin": (0, 9), "still": (9, 9), "box": (9, 0)}
    knees = set()
    for time in (0.4, 0.9, 1.7):
        go_to(world, time)
        for name, place in places.items():
            assert (*world.model(name).GetPose().pos,)[:2] == pytest.approx(place, abs=1e-9)
        bones = world.model("empty").frame_links
        knees.add(max(body.GetPosition().x for body in bones))
        assert world.model("walks").GetPose().pos.x > -9.0  # a trajectory without waypoints has the root's way
    assert len(knees) == 3


def test_links_of_an_actor_move_with_it(load):
    link = "<link name='cart'><pose>0 0 0.5 0 0 0</pose><collision name='c'><geometry><box><size>1 1 1</size></box>"
    link += "</geometry></collision></link>"
    world = load(actor(trajectory(*LINE), link))
    go_to(world, 2.0)
    place = world.model("a").GetBody("cart").GetPose().pos
    assert place.x == pytest.approx(2.0, abs=FRAME)
    assert place.z == pytest.approx(1.5)


def test_bones_are_links_at_the_poses_of_the_animation(load, tmp_path):
    (tmp_path / "arm.dae").write_text(two_bones())
    file = tmp_path / "arm.dae"
    world = load(actor("", skin(file, path_along_x=False), pose="1 2 3 0 0 0"))
    found = world.model("a")
    assert list(found.links) == ["a_pose", "shoulder", "elbow"]
    go_to(world, 1.0)
    elbow = found.GetBody("elbow")
    assert tuple(elbow.GetPosition()) == pytest.approx((2.0, 2.0, 3.0))
    turned = GzQuaternToEuler(elbow.GetRotation()).z
    assert turned == pytest.approx(math.radians(45.0) * found.script_time, abs=1e-9)
    (shape,) = [geom for geom in found.bodies[0].geoms if isinstance(geom, SkinGeom)]
    shape.bend()
    ends = shape.vertices[8:].mean(axis=0)
    np.testing.assert_allclose(ends, (1.0 + math.cos(turned), math.sin(turned), 0.0), atol=1e-9)


def test_python_has_no_part_in_steps_between_two_poses(load, monkeypatch):
    times, update = [], SdfActor.MasterUpdate

    def noted(self, step):
        times.append(self.world.GetSimTime())
        update(self, step)

    world = load(actor(trajectory(*LINE), skin()))
    monkeypatch.setattr(SdfActor, "MasterUpdate", noted)
    for _ in range(500):
        world.Step()
    assert len(times) == 500 // 34  # each calls it: 34 ms are the first multiple of a step after 1/30 s
    np.testing.assert_allclose(np.diff(times), FRAME, atol=1e-9)
    world.model("a").stop()
    place = world.model("a").GetPose().pos
    for _ in range(100):
        world.Step()
    assert world.model("a").GetPose().pos == place


def test_the_way_chooses_the_pose_of_a_walk(load):
    world = load(actor(trajectory(*LINE), skin()))
    found = world.model("a")
    go_to(world, 2.0)
    motion = found.clips["walk"].animation
    positions, _ = motion.at_x(found.script_time)
    assert found.GetPose().pos.x == pytest.approx(found.script_time, abs=1e-3)  # the root has no way of its own
    assert found.GetPose().pos.z == pytest.approx(1.0 + positions[0][2], abs=2e-3)


def test_scale_makes_skin_and_bones_larger(load):
    world = load(actor("", skin(more="<scale>2</scale>")))
    found = world.model("a")
    go_to(world, 0.1)
    assert found.GetBody("Head").GetPosition().z == pytest.approx(3.0, abs=0.2)


def test_cameras_see_the_skin_bend(load):
    looking = actor(trajectory((0, "0 0 0 0 0 0"), (9, "0 0 0 0 0 0")), skin(path_along_x=False))
    camera = (
        "<model name='eye'><static>true</static><pose>2.5 0 1 0 0 3.14159</pose><link name='l'>"
        "<sensor name='cam' type='camera'><always_on>true</always_on><update_rate>10</update_rate><camera>"
        "<horizontal_fov>0.9</horizontal_fov><image><width>64</width><height>64</height></image>"
        "<clip><near>0.1</near><far>20</far></clip></camera></sensor></link></model>"
    )
    world = load(looking, camera)
    from libgz.classic.sensors import SensorManager

    images = []
    for time in (0.35, 0.65):
        go_to(world, time)
        sensor = SensorManager.Instance().GetSensor("cam")
        images.append(np.frombuffer(sensor.ImageData(), dtype=np.uint8).reshape(64, 64, 3).astype(int))
    background = images[0][0, 0]
    for image in images:
        body = np.abs(image - background).sum(axis=2) > 60
        rows, columns = np.nonzero(body)
        assert 250 < len(rows) < 1500
        assert rows.max() - rows.min() > 35  # a person from head to foot
        assert columns.max() - columns.min() < 35
    assert (np.abs(images[0] - images[1]).sum(axis=2) > 60).sum() > 60


def test_an_actor_is_in_the_state_and_in_clones(load):
    world = load(actor(trajectory(*LINE), skin()))
    found = world.model("a")
    start = found.GetPose()
    assert start.pos.z == pytest.approx(1.95, abs=0.01)  # it begins with the first pose of its script
    go_to(world, 1.3)
    state = world.get_state()

    def run(which):
        poses = []
        for _ in range(150):
            which.Step()
            poses.append([body.GetPose() for body in which.model("a").bodies])
        return poses

    first = run(world)
    world.set_state(state)
    assert run(world) == first
    other = world.clone()
    try:
        other.set_state(state)
        assert run(other) == first
    finally:
        other.close()
    world.Reset()
    assert found.GetPose() == start
    go_to(world, 1.0)
    assert found.GetPose().pos.x == pytest.approx(1.0, abs=FRAME)


def test_what_an_actor_walks_into_is_pushed(load):
    ball = (
        "<model name='ball'><pose>1 0 1 0 0 0</pose><link name='l'><gravity>0</gravity><collision name='c'><geometry>"
        "<sphere><radius>0.2</radius></sphere></geometry></collision></link></model>"
    )
    cart = "<link name='cart'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link>"
    world = load(actor(trajectory(*LINE), cart), ball)
    go_to(world, 1.0)
    assert world.model("ball").GetPose().pos.x > 1.0
    assert world.model("a").GetPose().pos.x == pytest.approx(1.0, abs=FRAME)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        (actor(trajectory(*LINE), skin("no.dae")), "Unable to find uri[no.dae]"),
        (actor(trajectory(*LINE), skin("a.bvh")), "Unable to find uri[a.bvh]"),
        (
            actor(trajectory(*LINE, kind="run"), skin()),
            "Resource not found for trajectory of type run: its animations are",
        ),
    ],
)
def test_what_is_missing_is_a_warning_and_the_actor_moves(load, caplog, parts, message):
    world = load(parts)
    assert message in caplog.text
    go_to(world, 2.0)
    assert world.model("a").GetPose().pos.x == pytest.approx(2.0, abs=FRAME)


def test_skeletons_that_do_not_fit_are_a_warning(load, tmp_path, caplog):
    (tmp_path / "arm.dae").write_text(two_bones())
    inside = (
        f"<skin><filename>media/models/walk.dae</filename></skin><animation name='arm'><filename>{tmp_path}/arm.dae"
    )
    load(actor("", inside + "</filename></animation>"))
    assert "Skin and animation arm skeletons are not compatible: 17 and 2 bones" in caplog.text


def test_times_before_the_start_are_the_start_with_a_warning(load, caplog):
    load(actor(trajectory((-1, "0 0 0 0 0 0"))))
    assert "<time>: '-1' is out of range; '0" in caplog.text


MOTION = sample("bvh").decode()


@pytest.fixture
def captured(tmp_path):
    """Elements of an actor whose two bones play a captured motion."""
    (tmp_path / "arm.dae").write_text(two_bones())
    (tmp_path / "arm.bvh").write_text(MOTION)
    return (
        f"<skin><filename>{tmp_path}/arm.dae</filename></skin><animation name='walk'>"
        f"<filename>{tmp_path}/arm.bvh</filename><scale>0.02</scale></animation>"
    )


def test_a_captured_motion_moves_the_bones(load, captured, caplog):
    world = load(actor(inside=captured, pose="0 0 0 0 0 0"))
    go_to(world, 0.5)
    elbow, shoulder = (world.model("a").GetBody(name).GetPose() for name in ("elbow", "shoulder"))
    # y up and z ahead, 0.02 m each: 0.8 m high, 1 m ahead after 0.5 s; the elbow turns about the axis that is up.
    assert np.subtract(elbow.pos, shoulder.pos) == pytest.approx((1, 0, 0), abs=1e-6)
    assert shoulder.pos.z == pytest.approx(0.8)
    assert GzQuaternToEuler(elbow.rot).z == pytest.approx(math.pi / 4, abs=0.06)
    assert not caplog.records


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("HIERARCHY", "", "'ROOT' stands where 'HIERARCHY' is expected"),
        ("Frames: 3", "Frames: 4", "27 numbers; 4 frames of 9 are stated"),
        ("0 40 100", "0 40 nan", "27 numbers"),
        ("JOINT elbow", "ROOT elbow", "ROOT is not allowed here"),
        ("Zrotation Xrotation Yrotation\n    End", "Zrotation Xrotation Wrotation\n    End", "channel 'Wrotation'"),
        ("MOTION", "", "'Frames:' is not expected"),
        ("Frame Time: 0.5", "Frame Time: 0", "every 0 s"),
        (MOTION, "HIERARCHY ROOT", "it ends too early"),
        (MOTION, "HIERARCHY ROOT a { CHANNELS 3 Xrotation", "it ends too early"),
        ("JOINT", "CHANNELS 1 Xrotation JOINT", "'CHANNELS' is not expected"),
    ],
)
def test_a_damaged_motion_is_a_warning(load, captured, tmp_path, caplog, old, new, message):
    (tmp_path / "arm.bvh").write_text(MOTION.replace(old, new, 1))
    load(actor(inside=captured)).Step()
    assert message in caplog.text
    assert "the actor has no such animation" in caplog.text
