"""Plugins of the ROS era and of packages around it: that they act, and what is logged of those that cannot."""

import math
import re

import pytest
from plugin_worlds import GROUND, body, collision, command, plugin, wheel
from topics import Heard, send

from libgz.classic import msgs, sensors

BALL = "<sphere><radius>0.1</radius></sphere>"
SMALL = "<inertial><mass>0.5</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>"
ROS2 = "<ros><namespace>/bot</namespace><remapping>cmd_vel:=go</remapping><argument>odom:=seen</argument></ros>"


def hinge(name, parent, axis="0 0 1", x=0.0, more=""):
    inertia = "<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia>"
    return (
        f"<link name='{name}_link'><pose>{x} 0 0 0 0 0</pose><gravity>false</gravity>"
        f"<inertial><mass>1</mass>{inertia}</inertial></link>"
        f"<joint name='{name}' type='revolute'><parent>{parent}</parent><child>{name}_link</child>"
        f"<axis><xyz>{axis}</xyz>{more}</axis></joint>"
    )


def planar(elements):
    return f"<plugin name='p' filename='libgazebo_ros_planar_move.so'>{elements}</plugin>"


@pytest.mark.parametrize(
    ("elements", "topic", "odometry"),
    [("<odometryRate>50</odometryRate>", "~/box/cmd_vel", "~/box/odom"), (ROS2, "/bot/go", "/bot/seen")],
)
def test_planar_move_goes_sideways_and_turns(elements, topic, odometry, run):
    core, world = run(GROUND, body("box", "0 0 0.1 0 0 1.5707963", link=collision(BALL), inside=planar(elements)))
    poses = Heard(odometry)
    core.step(10)
    message = msgs.Pose()
    message.position.x, message.position.y, message.orientation.w = 0.5, 0.2, 1.0
    kept = send(topic, message)
    core.run(1.0)
    place = world.ModelByName("box").WorldPose().Pos()
    assert (place.X(), place.Y()) == pytest.approx((-0.2, 0.5), abs=0.02)  # it looks along y
    assert poses[-1].pose.position.y == pytest.approx(place.Y(), abs=0.5 / 20 + 1e-3)
    assert len(poses) >= 20
    assert kept


def test_a_planar_robot_stops_without_commands(run):
    elements = "<cmdTimeout>0.2</cmdTimeout>"
    core, world = run(body("box", gravity="false", inside=planar(elements)))
    core.step()
    kept = command("~/box/cmd_vel", 1.0)
    core.run(1.0)
    assert world.ModelByName("box").WorldPose().Pos().X() == pytest.approx(0.2, abs=0.01)
    assert kept


@pytest.mark.parametrize("package", ["gazebo", "roboticsgroup_gazebo", "roboticsgroup_upatras_gazebo"])
def test_a_joint_follows_another_by_the_plugin(package, run):
    mimic = plugin(f"{package}_mimic_joint_plugin", joint="a", mimicJoint="b", multiplier=-2, offset=0.1)
    core, world = run(f"<model name='m'>{hinge('a', 'world')}{hinge('b', 'world', x=2)}{mimic}</model>")
    model = world.ModelByName("m")
    model.GetJoint("a").SetVelocity(0, 0.5)
    core.run(0.5)
    leader, follower = (model.GetJoint(name).Position(0) for name in "ab")
    assert leader == pytest.approx(0.25, abs=0.01)
    assert follower == pytest.approx(-2 * leader + 0.1, abs=2e-3)


def test_a_follower_is_as_strong_as_its_effort(run):
    mimic = plugin("gazebo_mimic_joint_plugin", joint="a", mimicJoint="b", maxEffort=0.1)
    joints = hinge("a", "world") + hinge("b", "world", x=2)
    core, world = run(f"<model name='m'>{joints}{mimic}</model>")
    model = world.ModelByName("m")
    model.GetJoint("a").SetVelocity(0, 1.0)
    core.run(0.1)
    assert model.GetJoint("b").GetVelocity(0) == pytest.approx(0.1 / 0.1 * 0.1, rel=0.05)  # torque / inertia * time


def test_a_link_is_put_to_sleep(run):
    core, world = run(GROUND, body("box", "0 0 2 0 0 0", inside=plugin("gazebo_disable_link_plugin", link="link")))
    core.run(0.5)
    assert world.ModelByName("box").WorldPose().Pos().Z() == 2.0


@pytest.mark.parametrize(("frame", "place"), [("world", (0.5, 0.0)), ("link", (0.0, 0.5))])
def test_a_wrench_acts_until_the_next_one(frame, place, run):
    element = plugin("gazebo_ros_force", bodyName="link", topicName="push", robotNamespace="b", force_frame=frame)
    core, world = run(body("box", "0 0 0 0 0 1.5707963", gravity="false", inside=element))
    core.step()
    wrench = msgs.Wrench()
    wrench.force.x = 1.0
    kept = send("/b/push", wrench)
    core.run(1.0)
    at = world.ModelByName("box").WorldPose().Pos()
    assert (at.X(), at.Y()) == pytest.approx(place, abs=2e-3)  # f t^2 / (2 m)
    wrench.force.x = 0.0
    kept.Publish(wrench)
    core.step()
    speed = world.ModelByName("box").WorldLinearVel().Length()
    core.run(0.2)
    assert world.ModelByName("box").WorldLinearVel().Length() == pytest.approx(speed)


@pytest.mark.parametrize("tag", ["joint_name", "body_name"])
def test_the_sensor_of_a_joint_measures_what_it_carries(tag, run):
    value = "hold" if tag == "joint_name" else "link"
    fixed = "<joint name='hold' type='fixed'><parent>world</parent><child>link</child></joint>"
    element = plugin("gazebo_ros_ft_sensor", **{tag: value}, update_rate=100)
    core, _ = run(body("lamp", mass=2.0, inside=fixed + element))
    found = Heard("~/lamp/wrench")
    core.run(0.5)
    assert found[-1].wrench.force.z == pytest.approx(-2.0 * 9.8, rel=1e-3)
    assert len(found) == pytest.approx(50, abs=2)


def car(inside):
    """A car whose front wheels are steered: wheelbase 0.8 m, track 0.4 m."""
    base = "<link name='base'><pose>0.4 0 0.1 0 0 0</pose><inertial><mass>10</mass></inertial></link>"
    steered = ""
    for name, y in (("left", 0.2), ("right", -0.2)):
        one = wheel(f"front_{name}", 0.8, y).replace("<parent>base<", f"<parent>{name}_knuckle<")
        steered += (
            f"<link name='{name}_knuckle'><pose>0.8 {y} 0.1 0 0 0</pose>{SMALL}</link>"
            f"<joint name='{name}_steer' type='revolute'><parent>base</parent><child>{name}_knuckle</child>"
            f"<axis><xyz>0 0 1</xyz></axis></joint>{one}"
        )
    rear = wheel("rear_left", 0, 0.2) + wheel("rear_right", 0, -0.2)
    return f"<model name='car'>{base}{steered}{rear}{inside}</model>"


def ackermann_car(most):
    """A car with an Ackermann drive, whose wheels turn by so much [rad] at most."""
    joints = {f"{end}_{side}_joint": f"{end}_{side}" for end in ("front", "rear") for side in ("left", "right")}
    joints |= {f"{side}_steering_joint": f"{side}_steer" for side in ("left", "right")}
    gains = {f"{side}_steering_pid_gain": "200 0 4" for side in ("left", "right")}
    gains |= {"linear_velocity_pid_gain": "5 0 0", "max_steer": most}
    return car(plugin("gazebo_ros_ackermann_drive", **joints, **gains))


def test_an_ackermann_car_that_must_not_steer_drives_straight_on(run):
    core, world = run(GROUND, ackermann_car(0))
    kept = command("~/car/cmd_vel", 0.5, 0.3)
    core.run(0.5)
    pose = world.ModelByName("car").WorldPose()
    assert pose.Pos().X() > 0.1
    assert pose.Pos().Y() == pytest.approx(0.0, abs=1e-3)
    assert kept


def test_an_ackermann_car_drives_in_the_circle_of_its_wheels(run):
    core, world = run(GROUND, ackermann_car(0.5))
    core.run(0.2)
    kept = command("~/car/cmd_vel", 0.5, 0.3)
    core.run(2.0)
    model = world.ModelByName("car")
    angles = [model.GetJoint(f"{side}_steer").Position(0) for side in ("left", "right")]
    tangent = math.tan(0.3)
    assert angles == pytest.approx(
        [math.atan2(tangent, 1 - 0.25 * tangent), math.atan2(tangent, 1 + 0.25 * tangent)], abs=0.03
    )
    speed, turn = model.WorldLinearVel().Length(), model.WorldAngularVel().Z()
    assert turn == pytest.approx(0.5 / 0.8 * tangent, rel=0.15)
    assert speed == pytest.approx(0.5, rel=0.15)
    assert kept


def test_a_tricycle_drives_and_steers_by_its_front_wheel(run):
    base = "<link name='base'><pose>0.3 0 0.1 0 0 0</pose><inertial><mass>10</mass></inertial></link>"
    fork = (
        f"<link name='fork'><pose>0.8 0 0.1 0 0 0</pose>{SMALL}</link><joint name='steer' type='revolute'>"
        "<parent>base</parent>"
        "<child>fork</child><axis><xyz>0 0 1</xyz></axis></joint>"
    )
    front = wheel("spin", 0.8, 0).replace("<parent>base<", "<parent>fork<")
    elements = {"steering_joint": "steer", "actuated_wheel_joint": "spin", "max_wheel_torque": 20}
    drive = plugin("gazebo_ros_tricycle_drive", **elements, max_steering_speed=2, max_wheel_acceleration=5)
    core, world = run(
        GROUND, f"<model name='t'>{base}{fork}{front}{wheel('l', 0, 0.3)}{wheel('r', 0, -0.3)}{drive}</model>"
    )
    core.run(0.1)
    kept = command("~/t/cmd_vel", 0.5, 0.4)
    core.run(2.0)
    model = world.ModelByName("t")
    assert model.GetJoint("steer").Position(0) == pytest.approx(0.4, abs=0.02)
    assert model.WorldAngularVel().Z() == pytest.approx(0.5 * math.sin(0.4) / 0.8, rel=0.1)
    assert kept


def test_a_vacuum_gripper_lifts_what_is_near(run):
    grip = plugin("gazebo_ros_vacuum_gripper", link_name="link", fixed="ground_plane", max_distance=0.2)
    hand = body("hand", "0 0 0.2 0 0 0", gravity="false", inside=grip)
    light = body("ball", "0 0 0.1 0 0 0", mass=0.1, link=collision(BALL))
    far = body("other", "1 0 0.1 0 0 0", mass=0.1, link=collision(BALL))
    core, world = run(GROUND, hand, light, far)
    states = Heard("~/hand/grasping")
    core.step(5)
    kept = send("~/hand/switch", msgs.Int(data=1))
    core.step(5)
    world.ModelByName("hand").SetLinearVel((0.0, 0.0, 0.5))
    core.run(1.0)
    assert world.ModelByName("ball").WorldPose().Pos().Z() == pytest.approx(0.6, abs=0.15)
    assert world.ModelByName("other").WorldPose().Pos().Z() == pytest.approx(0.1, abs=0.01)
    kept.Publish(msgs.Int(data=0))
    core.run(1.0)
    assert world.ModelByName("ball").WorldPose().Pos().Z() < 0.3
    assert [one.data for one in states] == [1, 0]


@pytest.mark.parametrize("library", ["gazebo_ros_camera", "gazebo_ros_gps_sensor", "gazebo_ros_imu_sensor"])
def test_a_plugin_of_ros_activates_a_sensor_of_any_type(library, run):
    sensor = f"<sensor name='s' type='gps'><update_rate>10</update_rate>{plugin(library)}</sensor>"
    core, _ = run(body("post", gravity="false", link=sensor))
    core.run(0.3)
    assert sensors.get_sensor("s").IsActive()


def test_missing_plugins_are_logged_once_each_and_places_once(run, caplog):
    inside = plugin("foo") + plugin("foo") + plugin("bar") + plugin("gazebo_ros_state") + plugin("gazebo_ros_state")
    newer = "".join(
        f"<plugin name='{n}' filename='{n}'/>" for n in ("gz-sim-imu-system", "ignition-gazebo-physics-system")
    )
    run(body("a", inside=inside + newer), body("b", inside=plugin("foo")))
    lines = [line for record in caplog.records for line in record.getMessage().splitlines()]
    assert len([line for line in lines if "<plugin>: Failed to load plugin libfoo.so" in line]) == 1
    (bar,) = [line for line in lines if "<plugin>: Failed to load plugin libbar.so" in line]
    assert bar.endswith("No such file or directory; tried the places above")
    assert len([line for line in lines if "(the current directory)" in line]) == 1
    lost = "has no effect without ROS. What is lost: the services that get and set poses; use `libgz model`"
    (state,) = [line for line in lines if "libgazebo_ros_state.so" in line]
    assert state == f"<string>:1: <plugin>: plugin 'libgazebo_ros_state.so' {lost}"
    assert len([line for line in lines if re.search("newer Gazebo", line)]) == 1
