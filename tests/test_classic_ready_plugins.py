"""The plugins that come with libgz, each against a formula."""

import gc
import json
import logging
import math
import os
import subprocess
import sys
import textwrap

import pytest

import libgz
from libgz.classic import gui, msgs, physics, transport
from libgz.classic.loading import new_plugin
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.sdf.element import Element

HINGE = """<joint name='{name}' type='revolute'>
  <parent>world</parent><child>link</child><axis><xyz>0 0 1</xyz></axis>
</joint>"""
GROUND = "<include><uri>model://ground_plane</uri></include>"


@pytest.fixture(autouse=True)
def own_places(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for variable in ("GAZEBO_PLUGIN_PATH", "GAZEBO_MODEL_PATH"):
        monkeypatch.delenv(variable, raising=False)


@pytest.fixture
def run():
    """Makes a world of some elements: (engine's world, view)."""
    worlds = []

    def load(*inside, version="1.6", **options):
        text = f"<sdf version='{version}'><world name='default'>{''.join(inside)}</world></sdf>"
        worlds.append(libgz.World.from_string(text, **options))
        return worlds[-1], physics.get_world()

    yield load
    for world in worlds:
        world.close()


def plugin(name, **elements):
    inside = "".join(f"<{key}>{value}</{key}>" for key, value in elements.items())
    return f"<plugin name='{name}' filename='lib{name.removeprefix('lib')}.so'>{inside}</plugin>"


def body(name, pose="0 0 0 0 0 0", mass=1.0, inside="", link="", gravity="true"):
    inertia = "<inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>"
    return (
        f"<model name='{name}'><pose>{pose}</pose><link name='link'><gravity>{gravity}</gravity>"
        f"<inertial><mass>{mass}</mass>{inertia}</inertial>{link}</link>{inside}</model>"
    )


def collision(shape, pose="0 0 0 0 0 0", name="c"):
    return f"<collision name='{name}'><pose>{pose}</pose><geometry>{shape}</geometry></collision>"


def command(topic, speed, turn=0.0):
    node = transport.Node()
    node.Init("default")
    publisher = node.Advertise(msgs.Pose, topic)
    message = msgs.Pose()
    msgs.Set(message, Pose3d(speed, 0.0, 0.0, 0.0, 0.0, turn))
    publisher.Publish(message)
    return publisher


# Wheels --------------------------------------------------------------------------------------------------------------


def pioneer(*plugins, pose="0 0 0 0 0 0"):
    return f"{GROUND}<include><uri>model://pioneer2dx</uri><pose>{pose}</pose>{''.join(plugins)}</include>"


# Without a motor the wheels have their speed at the beginning of each step, and lose some of it in turns.
@pytest.mark.parametrize(("torque", "slip", "rate_slip"), [({}, 0.2, 0.4), ({"torque": 5}, 0.06, 0.06)])
def test_diff_drive_turns_with_the_rate_it_is_told_right_if_positive(torque, slip, rate_slip, run):
    wheels = {"left_joint": "left_wheel_hinge", "right_joint": "right_wheel_hinge"}
    core, world = run(pioneer(plugin("DiffDrivePlugin", **wheels, **torque), pose="0 0 0 0 0 0.7"))
    robot = world.ModelByName("pioneer2dx")
    kept = command("~/pioneer2dx/vel_cmd", 0.0, 0.5)
    core.run(2.0)
    assert robot.WorldPose().Yaw() == pytest.approx(0.7 - 0.5 * 2.0, abs=slip)
    rates = [robot.GetJoint(f"{side}_wheel_hinge").GetVelocity(0) for side in ("left", "right")]
    assert rates == pytest.approx([0.5 * 0.175 / 0.095, -0.5 * 0.175 / 0.095], rel=rate_slip)
    core.Reset()
    core.run(0.5)
    assert robot.GetJoint("left_wheel_hinge").GetVelocity(0) == pytest.approx(0.0, abs=0.06)
    del kept


def test_diff_drive_tells_what_it_misses(run, caplog):
    run(pioneer(plugin("DiffDrivePlugin", left_joint="left_hinge", right_joint="right_wheel_hinge")))
    assert "has no joint 'left_hinge'" in caplog.text
    run(pioneer(plugin("DiffDrivePlugin", left_joint="left_wheel_hinge")))
    assert "<right_joint> is missing" in caplog.text


def four_wheels():
    def wheel(name, x, y):
        shape = "<cylinder><radius>0.1</radius><length>0.05</length></cylinder>"
        inertia = "<inertia><ixx>0.002</ixx><iyy>0.002</iyy><izz>0.003</izz></inertia>"
        return (
            f"<link name='{name}_wheel'><pose>{x} {y} 0.1 -1.5707963 0 0</pose>"
            f"<inertial><mass>0.5</mass>{inertia}</inertial>{collision(shape)}</link>"
            f"<joint name='{name}' type='revolute'><parent>base</parent><child>{name}_wheel</child>"
            "<axis><xyz>0 0 1</xyz></axis></joint>"
        )

    places = {
        "left_front": (0.2, 0.2),
        "right_front": (0.2, -0.2),
        "left_rear": (-0.2, 0.2),
        "right_rear": (-0.2, -0.2),
    }
    wheels = "".join(wheel(name, *place) for name, place in places.items())
    base = "<link name='base'><pose>0 0 0.15 0 0 0</pose><inertial><mass>5</mass></inertial></link>"
    return f"<model name='rover'>{base}{wheels}{plugin('SkidSteerDrivePlugin', max_force=20)}</model>"


def test_skid_steer_drives_both_sides(run):
    core, world = run(GROUND, four_wheels())
    rover = world.ModelByName("rover")
    kept = command("~/rover/vel_cmd", 0.5)
    core.run(3.0)
    assert rover.WorldPose().Pos().X() == pytest.approx(1.5, abs=0.05)
    kept = command("~/rover/vel_cmd", 0.0, 0.5)
    core.run(1.0)
    rates = {name: rover.GetJoint(name).GetVelocity(0) for name in ("left_front", "right_rear")}
    assert rates == pytest.approx({"left_front": -0.5 * 0.4 / 0.1, "right_rear": 0.5 * 0.4 / 0.1}, abs=0.02)
    assert rover.WorldAngularVel().Z() > 0.2
    del kept


# The legacy era ------------------------------------------------------------------------------------------------------

POSITION = {"leftJoint": "left_wheel_hinge", "rightJoint": "right_wheel_hinge", "id": "robot1"}


def test_position_serves_odometry_of_the_wheels_and_obeys(run):
    core, world = run(pioneer(plugin("libgz_position", **POSITION)))
    robot, position = world.ModelByName("pioneer2dx"), core.interface("position", "robot1")
    position.command(vx=0.3, vyaw=0.4)
    core.run(4.0)
    pose, (x, y, yaw) = robot.WorldPose(), position.pose
    assert yaw == pytest.approx(0.4 * 4.0, abs=0.06)  # left is positive
    # An arc: radius 0.3 / 0.4.
    assert (x, y) == pytest.approx((0.75 * math.sin(1.6), 0.75 * (1.0 - math.cos(1.6))), abs=0.06)
    assert (pose.Pos().X(), pose.Pos().Y(), pose.Yaw()) == pytest.approx((x, y, yaw), abs=0.12)
    assert position.vel_pos[0] == pytest.approx(0.3, abs=0.01)
    assert position.vel_rot[2] == pytest.approx(0.4, abs=0.02)
    position.enable_motors(False)
    core.run(0.5)
    assert robot.WorldLinearVel().Length() < 0.01


def test_position_begins_again_after_a_reset_and_doubts_wild_numbers(run, caplog):
    core, _ = run(pioneer(plugin("libgz_position", **POSITION, torque=5)))
    position = core.interface("position", "robot1")
    position.command(vx=0.2)
    core.run(1.0)
    core.Reset()
    core.run(0.5)
    assert position.pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
    position.command(vx=0.2)
    core.run(1.0)
    assert position.pose[0] == pytest.approx(0.2, abs=0.02)
    position.command(vx=math.nan)
    core.run(1.0)
    assert position.pose[0] == pytest.approx(0.4, abs=0.02)
    assert "is nan, and is ignored" in caplog.text


CLIENT = """
import sys, time, libgz
with libgz.Client(int(sys.argv[1])) as client:
    position = client.position("robot1")
    position.command(vx=0.25)
    end = time.monotonic() + 60.0
    while position.pose[0] < 0.2 and time.monotonic() < end:
        client.wait()
    print(f"{position.pose[0]:.3f}")
"""


def test_position_is_driven_by_a_client_in_another_process(run, monkeypatch, tmp_path):
    server_id = 300 + os.getpid() % 600
    monkeypatch.setenv("TMP", str(tmp_path))
    core, world = run(pioneer(plugin("libgz_position", **POSITION)), server_id=server_id)
    client = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(CLIENT), str(server_id)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    for _ in range(60_000):
        core.step()
        if client.poll() is not None:
            break
    out, fault = client.communicate(timeout=10)
    assert client.returncode == 0, fault
    assert float(out) >= 0.2
    assert world.ModelByName("pioneer2dx").WorldPose().Pos().X() > 0.18


LEGACY = """
<plugin name='legacy' filename='libgz_legacy.so'>
  <model:Pioneer2AT xmlns:model='http://playerstage.sourceforge.net/gazebo/xmlschema/#model'>
    <id>robot1</id><xyz>0 0 0</xyz>
  </model:Pioneer2AT>
  <model:SimpleSolid xmlns:model='http://playerstage.sourceforge.net/gazebo/xmlschema/#model'>
    <id>ball</id><xyz>0 2 1</xyz><shape>sphere</shape><size>0.5</size>
  </model:SimpleSolid>
</plugin>
"""


def test_legacy_models_drive_among_sdf_models_and_all_are_reset(run):
    shape = "<box><size>0.5 0.5 0.5</size></box>"
    core, world = run(GROUND, body("box", "1.0 0 0.25 0 0 0", 2.0, link=collision(shape)), LEGACY)
    places = {model.GetName(): model.WorldPose().Pos() for model in world.Models()}
    assert set(places) == {"ground_plane", "box", "robot1", "ball"}
    for _ in range(2):
        core.interface("position", "robot1").command(vx=0.3)
        core.run(5.0)
        assert world.ModelByName("robot1").WorldPose().Pos().X() == pytest.approx(1.5, abs=0.1)
        assert core.interface("position", "robot1").time == pytest.approx(5.0, abs=0.11)
        assert world.ModelByName("box").WorldPose().Pos().X() > 1.8  # pushed along
        assert world.ModelByName("ball").WorldPose().Pos().Z() < 0.6
        core.Reset()
        for name, place in places.items():
            assert world.ModelByName(name).WorldPose().Pos().Equal(place, 1e-12), name


def test_faults_of_legacy_models_are_told_and_the_world_runs(run, caplog):
    text = "<model:Pioneer3AT xmlns:model='model'><id>a</id></model:Pioneer3AT>"
    core, world = run(GROUND, f"<plugin name='legacy' filename='libgz_legacy.so'>{text}</plugin>")
    core.step(2)
    assert "Pioneer3AT" in caplog.text
    assert "This plugin will not run." in caplog.text
    assert world.ModelCount() == 1


# Forces --------------------------------------------------------------------------------------------------------------


def test_initial_velocity_is_given_again_after_a_reset(run):
    extra = plugin("InitialVelocityPlugin", linear="1 2 0", angular="0 0 3")
    core, world = run(body("stone", "0 0 5 0 0 0", inside=extra, gravity="false"))
    stone = world.ModelByName("stone")
    for _ in range(2):
        core.run(0.5)
        assert tuple(stone.WorldPose().Pos()) == pytest.approx((0.5, 1.0, 5.0), abs=1e-9)
        assert stone.WorldPose().Yaw() == pytest.approx(1.5, abs=1e-3)
        core.Reset()


def test_joint_trajectory_follows_the_cosine(run):
    joint = HINGE.format(name="j")
    joint = joint.replace("0 0 1", "0 1 0").replace("<parent>", "<pose>-1 0 0 0 0 0</pose><parent>")
    core, world = run(body("arm", inside=joint + plugin("JointTrajectoryPlugin", joint="j")))
    for _ in range(3):
        core.run(2.0)
        now, joint = core.GetSimTime(), world.ModelByName("arm").GetJoint("j")
        # The step after it was set has taken the joint on.
        assert joint.Position(0) == pytest.approx(math.cos(now + 0.001), abs=1e-5)
        assert joint.GetVelocity(0) == pytest.approx(-math.sin(now), abs=1e-2)


WING = {"link_name": "link", "a0": 0.1, "cla": 4.0, "cda": 0.2, "alpha_stall": 0.3, "cla_stall": -2.0, "cda_stall": 1.5,
        "area": 0.5, "air_density": 1.2, "forward": "1 0 0", "upward": "0 0 1"}  # fmt: skip


@pytest.mark.parametrize(
    ("velocity", "alpha", "cl", "cd"),
    [
        ((10.0, 0.0, 0.0), 0.1, 0.4, 0.02),
        ((10.0, 0.0, -1.0), 0.1 + math.atan(0.1), 4.0 * (0.1 + math.atan(0.1)), 0.2 * (0.1 + math.atan(0.1))),
        ((10.0, 0.0, 2.0), 0.1 - math.atan(0.2), 4.0 * (0.1 - math.atan(0.2)), 0.2 * (math.atan(0.2) - 0.1)),
        ((10.0, 0.0, -4.0), None, None, None),  # beyond the stall
    ],
)
def test_lift_and_drag_are_those_of_the_formula(velocity, alpha, cl, cd, run):
    core, world = run(body("plane", inside=plugin("LiftDragPlugin", **WING), gravity="false"))
    plane = world.ModelByName("plane")
    plane.SetLinearVel(velocity)
    core.step()
    force = (plane.GetLink().WorldCoGLinearVel() - Vector3d(*velocity)) / 0.001
    if alpha is None:
        alpha = 0.1 + math.atan(0.4)
        cl = 4.0 * 0.3 - 2.0 * (alpha - 0.3)
        cd = 0.2 * 0.3 + 1.5 * (alpha - 0.3)
    speed2 = sum(v * v for v in velocity)
    pressure = 0.5 * 1.2 * speed2 * 0.5
    along = Vector3d(*velocity) / math.sqrt(speed2)
    across = Vector3d(-along.Z(), 0.0, along.X())  # up for a wing that flies forward
    assert tuple(force) == pytest.approx(tuple(across * (cl * pressure) - along * (cd * pressure)), abs=1e-6)


def test_lift_acts_at_the_centre_of_pressure_and_shrinks_with_sweep(run):
    wing = {**WING, "a0": 0.0, "cda": 0.0, "cp": "0 1 0"}
    core, world = run(body("plane", inside=plugin("LiftDragPlugin", **wing), gravity="false"))
    plane = world.ModelByName("plane")
    plane.SetLinearVel((10.0, 10.0, -1.0))
    core.step()
    link = plane.GetLink()
    alpha = math.atan(0.1)
    sweep = math.asin(10.0 / math.sqrt(201.0))
    lift = 4.0 * alpha * math.cos(sweep) ** 2 * 0.5 * 1.2 * 101.0 * 0.5
    along = Vector3d(10.0, 0.0, -1.0) / math.sqrt(101.0)
    force = (link.WorldCoGLinearVel() - Vector3d(10.0, 10.0, -1.0)) / 0.001
    assert tuple(force) == pytest.approx(tuple(Vector3d(-along.Z(), 0.0, along.X()) * lift), abs=1e-6)
    # Torque: (0, 1, 0) x force, on unit moments of inertia.
    assert tuple(link.WorldAngularVel() / 0.001) == pytest.approx((force.Z(), 0.0, -force.X()), abs=1e-3)


def test_a_flap_adds_lift(run):
    flap = (
        "<link name='flap'><gravity>false</gravity><inertial><mass>0.001</mass></inertial></link>"
        "<joint name='flap_joint' type='revolute'><parent>link</parent><child>flap</child>"
        "<axis><xyz>0 1 0</xyz></axis></joint>"
    )
    wing = {**WING, "a0": 0.0, "cda": 0.0, "control_joint_name": "flap_joint", "control_joint_rad_to_cl": 3.0}
    core, world = run(body("plane", inside=flap + plugin("LiftDragPlugin", **wing), gravity="false"))
    plane = world.ModelByName("plane")
    plane.GetJoint("flap_joint").SetPosition(0, 0.2)
    plane.SetLinearVel((10.0, 0.0, 0.0))
    core.step()
    lift = 3.0 * 0.2 * 0.5 * 1.2 * 100.0 * 0.5
    assert plane.WorldLinearVel().Z() / 0.001 == pytest.approx(lift / 1.001, rel=1e-3)


def test_a_body_of_revolution_is_lifted_wherever_the_air_comes_from(run):
    wing = {**WING, "a0": 0.0, "cda": 0.0, "radial_symmetry": "true"}
    core, world = run(body("rocket", inside=plugin("LiftDragPlugin", **wing), gravity="false"))
    rocket = world.ModelByName("rocket")
    lift = 4.0 * math.atan(0.1) * 0.5 * 1.2 * 101.0 * 0.5 / math.sqrt(1.01)
    for velocity, side in (((10.0, 1.0, 0.0), (-0.1, 1.0, 0.0)), ((10.0, 0.0, -1.0), (-0.1, 0.0, -1.0))):
        rocket.SetLinearVel(velocity)
        core.step()
        force = (rocket.GetLink().WorldCoGLinearVel() - Vector3d(*velocity)) / 0.001
        # Against the motion to the side, across the velocity.
        assert tuple(force) == pytest.approx(tuple(Vector3d(*side) * -lift), abs=1e-6)


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        ("<box><size>1 2 0.5</size></box>", 1.0),
        ("<sphere><radius>0.5</radius></sphere>", math.pi / 6.0),
        ("<cylinder><radius>0.5</radius><length>2</length></cylinder>", math.pi / 2.0),
    ],
)
def test_buoyancy_is_the_weight_of_the_fluid(shape, volume, run):
    extra = plugin("BuoyancyPlugin", fluid_density=1000)
    core, world = run(body("float", "0 0 9 0.4 0 0", 500.0, extra, collision(shape)))
    core.step(10)
    g = (1000.0 * volume / 500.0 - 1.0) * 9.8
    assert world.ModelByName("float").WorldLinearVel().Z() == pytest.approx(g * 0.01, rel=1e-6)


def test_buoyancy_acts_at_the_centre_of_volume(run):
    shapes = collision("<box><size>1 1 1</size></box>", "1 0 0 0 0 0") + collision(
        "<box><size>1 1 1</size></box>", "2 0 0 0 0 0", "d"
    )
    extra = plugin("BuoyancyPlugin", fluid_density=2.0)
    core, world = run(body("float", "0 0 9 0 0 1.0", 4.0, extra, shapes))
    core.step()
    link = world.ModelByName("float").GetLink()
    assert link.WorldCoGLinearVel().Length() == pytest.approx(0.0, abs=1e-12)
    # Centre of volume at x 1.5 of the link, which is turned about z; 4 N/g up there turns it about its own -y.
    turn = link.RelativeAngularVel() / 0.001
    assert tuple(turn) == pytest.approx((0.0, -1.5 * 4.0 * 9.8, 0.0), abs=1e-6)


def test_buoyancy_believes_what_the_file_says(run, caplog):
    said = "<link name='link'><volume>2</volume><center_of_volume>0 0 0</center_of_volume></link>"
    text = plugin("BuoyancyPlugin", fluid_density=1.0).replace("</plugin>", f"{said}<link name='keel'/></plugin>")
    caplog.set_level(logging.WARNING)
    core, world = run(body("float", "0 0 9 0 0 0", 2.0, text))
    core.step(5)
    assert world.ModelByName("float").WorldLinearVel().Z() == pytest.approx(0.0, abs=1e-12)
    assert "Specified link [keel] not found." in caplog.text


# Events --------------------------------------------------------------------------------------------------------------

SIM_EVENTS = """
<plugin name='events' filename='libSimEventsPlugin.so'>
  <region><name>below</name><volume><min>-1 -1 -99</min><max>1 1 4</max></volume></region>
  <event><name>fallen</name><type>inclusion</type><model>stone</model><region>below</region></event>
  <event><name>quiet</name><type>inclusion</type><active>false</active><model>stone</model><region>below</region></event>
  <event><name>turned</name><type>joint</type><model>whe</model><joint>axle</joint>
    <range><type>normalized_angle</type><min>3</min></range></event>
  <event><name>new</name><type>existence</type><model>guest</model></event>
  <event><name>pause</name><type>sim_state</type></event>
  <event><name>full</name><type>occupied</type><region>below</region><topic>~/full</topic><msg_data>yes</msg_data></event>
</plugin>
"""


def test_sim_events_are_published_when_they_happen(run):
    axle = HINGE.format(name="axle")
    spin = plugin("InitialVelocityPlugin", angular="0 0 2")
    core, world = run(body("stone", "0 0 5 0 0 0"), body("wheel", "5 0 5 0 0 0", inside=axle + spin), SIM_EVENTS)
    node, heard, full = transport.Node(), [], []
    node.Init("default")
    kept = [node.Subscribe("/gazebo/sim_events", heard.append), node.Subscribe("~/full", full.append)]
    core.run(3.0)

    # The stone is 1 m lower after sqrt(2 / 9.8) s; the wheel is at 3 rad after 1.5 s, and back at -pi after 1.57 s.
    times = [(m.name, json.loads(m.data)["state"], m.world_statistics.sim_time) for m in heard]
    found = [(name, state, time.sec + 1e-9 * time.nsec) for name, state, time in times]
    assert [(name, state) for name, state, _ in found] == [
        ("fallen", "inside"), ("turned", "in_range"), ("turned", "out_of_range"),
    ]  # fmt: skip
    assert [time for _, _, time in found] == pytest.approx([math.sqrt(2.0 / 9.8), 1.5, math.pi / 2.0], abs=3e-3)
    assert json.loads(heard[0].data) == {"state": "inside", "region": "below", "model": "stone"}
    assert heard[0].type == "inclusion"
    assert {message.data for message in full} == {"yes"}
    assert len(full) == pytest.approx((3.0 - math.sqrt(2.0 / 9.8)) / 0.001, abs=3)

    heard.clear()
    world.InsertModelString(f"<sdf version='1.6'>{body('guest_7', '0 0 50 0 0 0')}</sdf>")
    core.step(2)
    world.RemoveModel("guest_7")
    core.step(2)
    world.SetPaused(True)
    world.SetPaused(False)
    core.step(2)
    assert [(m.name, json.loads(m.data)["state"]) for m in heard] == [
        ("new", "creation"), ("new", "deletion"), ("pause", "paused"), ("pause", "running"),
    ]  # fmt: skip
    assert json.loads(heard[0].data)["model"] == "guest_7"
    del kept


def test_sim_events_tell_what_they_do_not_know(run, caplog):
    for wrong in ("<type>inclusoin</type>", "<type>inclusion</type><region>nowhere</region>"):
        caplog.clear()
        run(f"<plugin name='events' filename='libSimEventsPlugin.so'><event><name>a</name>{wrong}</event></plugin>")
        assert "did you mean 'inclusion'" in caplog.text or "there is no region 'nowhere'" in caplog.text


# Keys ----------------------------------------------------------------------------------------------------------------


def test_plane_demo_is_flown_by_keys(run):
    text = """
    <plugin name='plane' filename='libPlaneDemoPlugin.so'>
      <engine><joint_name>j</joint_name><inc_key>119</inc_key><dec_key>115</dec_key>
        <inc_val>0.5</inc_val><min_val>-1</min_val><max_val>1</max_val></engine>
      <thruster><link_name>link</link_name><inc_key>116</inc_key><dec_key>103</dec_key>
        <inc_val>0 0 2</inc_val><min_val>0 0 0</min_val><max_val>0 0 3</max_val></thruster>
    </plugin>"""
    axle = HINGE.format(name="j").replace("child>link", "child>rotor").replace("parent>world", "parent>link")
    rotor = "<link name='rotor'><gravity>false</gravity></link>"
    core, world = run(body("plane", inside=rotor + axle + text, gravity="false"))
    plane = world.ModelByName("plane")
    node = transport.Node()
    node.Init("default")
    publisher = node.Advertise(msgs.Any, "~/keyboard/keypress")

    def press(*keys):
        for key in keys:
            publisher.Publish(msgs.Any(int_value=key))
        core.step()

    press(*[ord("w")] * 3, ord("t"), ord("t"), ord("x"))
    plane.SetLinearVel((0, 0, 0))
    core.step(100)
    assert plane.GetJoint("j").GetVelocity(0) == pytest.approx(2.0 * 1.0 * 0.1, rel=1e-3)  # both have 1 kg m^2
    assert plane.WorldLinearVel().Z() == pytest.approx(3.0 / 2.0 * 0.1, rel=1e-3)  # of 2 kg
    core.Reset()
    core.step(50)
    assert plane.WorldLinearVel().Length() == pytest.approx(0.0, abs=1e-9)


def test_plane_demo_holds_its_control_surfaces(run):
    text = """
    <plugin name='plane' filename='libPlaneDemoPlugin.so'>
      <control><joint_name>j</joint_name><inc_key>104</inc_key><dec_key>106</dec_key><inc_val>0.2</inc_val>
        <min_val>-0.5</min_val><max_val>0.5</max_val><p>50</p><i>0</i><d>10</d></control>
    </plugin>"""
    core, world = run(body("plane", inside=HINGE.format(name="j") + text, gravity="false"))
    joint = world.ModelByName("plane").GetJoint("j")
    node = transport.Node()
    node.Init("default")
    publisher = node.Advertise(msgs.Any, "~/keyboard/keypress")
    for keys, position in (("h", 0.2), ("hh", 0.5), ("jjj", -0.1), ("c", 0.0)):
        for key in keys:
            publisher.Publish(msgs.Any(int_value=ord(key)))
        core.run(3.0)
        assert joint.Position(0) == pytest.approx(position, abs=0.01), keys


# Sensors -------------------------------------------------------------------------------------------------------------

SMALL = "<camera><image><width>8</width><height>6</height></image></camera>"
RAY = """<ray>
  <scan><horizontal><samples>3</samples><min_angle>-0.1</min_angle><max_angle>0.1</max_angle></horizontal></scan>
  <range><min>0.1</min><max>9</max></range>
</ray>"""
SENSORS = {
    "CameraPlugin": f"<sensor name='s' type='camera'>{SMALL}",
    "DepthCameraPlugin": f"<sensor name='s' type='depth'>{SMALL}",
    "RayPlugin": f"<sensor name='s' type='ray'>{RAY}",
    "GpuRayPlugin": f"<sensor name='s' type='gpu_ray'>{RAY}",
    "ContactPlugin": "<sensor name='s' type='contact'><contact><collision>c</collision></contact>",
    "ImuSensorPlugin": "<sensor name='s' type='imu'>",
    "SonarPlugin": "<sensor name='s' type='sonar'>",
    "ForceTorquePlugin": "<sensor name='s' type='force_torque'>",
}


@pytest.mark.parametrize("name", SENSORS)
def test_sensor_hooks_switch_the_sensor_on_and_are_called(name, run, monkeypatch):
    from libgz.classic.plugins import hooks

    kind, calls = getattr(hooks, name), []
    hook = next(word for word in vars(kind) if word.startswith("On"))
    monkeypatch.setattr(kind, hook, lambda _self, *values: calls.append(values))
    sensor = f"{SENSORS[name]}<update_rate>100</update_rate>{plugin(name)}</sensor>"
    shape = collision("<box><size>1 1 1</size></box>")
    joint = HINGE.format(name="j").replace("</joint>", f"{sensor}</joint>") if name == "ForceTorquePlugin" else ""
    core, _ = run(body("thing", "0 0 0.5 0 0 0", link=shape + (sensor if not joint else ""), inside=joint))
    (loaded,) = core.companions[0].sensors.plugins()
    assert loaded.plugin.sensor.IsActive()
    core.run(0.1)
    assert len(calls) == pytest.approx(10, abs=1)
    assert len(calls[0]) == {"OnNewFrame": 5, "OnNewDepthFrame": 5, "OnNewLaserScans": 0}.get(hook, len(calls[0]))


def test_a_hook_is_made_for_deriving(run, tmp_path, monkeypatch, capsys):
    (tmp_path / "nearest.py").write_text(
        textwrap.dedent("""
        from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN
        from libgz.classic.plugins.hooks import RayPlugin

        class Nearest(RayPlugin):
            def OnNewLaserScans(self):
                print(f"{min(self.sensor.Ranges()):.2f}")

        GZ_REGISTER_SENSOR_PLUGIN(Nearest)
        """)
    )
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    ray = f"<sensor name='s' type='ray'>{RAY}{plugin('nearest')}</sensor>"
    wall = body("wall", "3 0 0 0 0 0", link=collision("<box><size>1 9 9</size></box>"), gravity="false")
    core, _ = run(body("eye", link=ray, gravity="false"), wall)
    core.step()
    assert capsys.readouterr().out.split() == ["2.50"]


def test_keys_of_the_client_drive_a_robot(run):
    wheels = {"left_joint": "left_wheel_hinge", "right_joint": "right_wheel_hinge", "torque": 5}
    topic = "~/pioneer2dx/vel_cmd"
    keys = plugin("KeysToCmdVelPlugin", cmd_vel_topic=topic, max_linear_vel=0.5, linear_increment=0.2)
    core, world = run(pioneer(plugin("DiffDrivePlugin", **wheels), keys))
    robot, heard, node = world.ModelByName("pioneer2dx"), [], transport.Node()
    node.Init("default")

    def hear(message):
        heard.append((message.position.x, Quaterniond(msgs.ConvertIgn(message.orientation)).Yaw()))

    kept = node.Subscribe(topic, hear)
    keyboard = new_plugin("GUI", "libKeyboardGUIPlugin.so", "keyboard", "System", core.events)
    assert keyboard.start(Element("plugin"))
    up, down, left, space = 16777235, 16777237, 37, {"text": " "}
    for key in (up, up, up, down, left, 120):
        gui.Events.keyPress(msgs.KeyEvent(key=key))
    core.run(2.0)
    assert heard == [pytest.approx(pair) for pair in [(0.2, 0), (0.4, 0), (0.5, 0), (0.3, 0), (0.3, -0.5)]]
    assert robot.WorldLinearVel().Length() == pytest.approx(0.3, abs=0.03)
    assert robot.WorldPose().Yaw() > 0.7  # left
    gui.Events.keyPress(msgs.KeyEvent(**space))
    core.run(0.5)
    assert robot.WorldLinearVel().Length() < 0.02
    del kept
    keyboard.drop()
    gui.Events.keyPress(msgs.KeyEvent(key=up))
    core.step(3)
    assert len(heard) == 6


def test_keys_can_be_chosen(run, caplog):
    controls = "<key_controls><accelerate>119</accelerate><accelerate>87</accelerate><stop>120</stop></key_controls>"
    core, _ = run(body("cart", inside=plugin("KeysToCmdVelPlugin").replace("</plugin>", f"{controls}</plugin>")))
    assert "Key left has no assigned keycode." in caplog.text
    node, heard = transport.Node(), []
    node.Init("default")
    kept = node.Subscribe("~/cmd_vel", lambda message: heard.append(message.position.x))
    publisher = node.Advertise(msgs.Any, "~/keyboard/keypress")
    for key in "wWsx":
        publisher.Publish(msgs.Any(int_value=ord(key)))
    core.step(3)
    assert heard == [0.5, 1.0, 0.0]
    del kept


# Batteries -----------------------------------------------------------------------------------------------------------


def test_a_battery_is_used_up_by_its_consumers(run):
    which = {"link_name": "link", "battery_name": "main"}
    cell = {"open_circuit_voltage_constant_coef": 12.0, "open_circuit_voltage_linear_coef": -2.0, "capacity": 0.01,
            "initial_charge": 0.01, "resistance": 0.5, "smooth_current_tau": 0.05}  # fmt: skip
    drain = plugin("LinearBatteryConsumerPlugin", **which, power_load=12)
    extra = plugin("LinearBatteryPlugin", **which, **cell) + drain
    link = "<battery name='main'><voltage>12</voltage></battery>"
    core, world = run(body("robot", inside=extra, link=link, gravity="false"))
    battery = world.ModelByName("robot").GetLink().Battery("main")
    voltages = []
    for _ in range(2):
        core.run(1.0)
        # Its current is P / V, after the time constant; V falls by r i, and by e1 times the share that is gone.
        current = 12.0 / battery.Voltage()
        gone = current * (1.0 - 0.05) / 3600.0 / 0.01
        assert battery.Voltage() == pytest.approx(12.0 - 2.0 * gone - 0.5 * current, abs=2e-3)
        voltages.append(battery.Voltage())
        core.Reset()
    assert voltages[0] == pytest.approx(voltages[1], abs=1e-9)
    world.ModelByName("robot").plugins[-1].drop()
    gc.collect()
    core.run(1.0)
    assert battery.PowerLoads() == {}
    assert battery.Voltage() == pytest.approx(12.0, abs=1e-3)


def test_a_battery_that_is_not_there_is_told(run, caplog):
    link = "<battery name='main'><voltage>12</voltage></battery>"
    wrong = plugin("LinearBatteryConsumerPlugin", link_name="link", battery_name="mian", power_load=1)
    run(body("robot", inside=wrong, link=link))
    assert "did you mean 'main'" in caplog.text
