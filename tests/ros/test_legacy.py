"""Legacy models for nodes of ROS: each kind of device, TF, commands, the action of a gripper, services of /gazebo."""

import math
from pathlib import Path

import pytest
from ros_node import Node
from ros_peers import open_topic, wait_for

from libgz import World
from libgz.interfaces.catalog import INTERFACES
from libgz.ros.legacy.api import SERVICES
from libgz.ros.legacy.kinds import KINDS
from libgz.ros.packing import codec
from libgz.ros.server import Ros1
from libgz.ros.types import message_type

WORLD = Path(__file__).parent / "legacy.world"
WITHOUT = {"sim", "guicam", "factory", "wifi"}  # interfaces that are no devices, or have no usual messages


@pytest.fixture
def node(master):
    with Ros1([]) as ros, World(seed=1) as core:
        core.LoadFile(WORLD)
        ros.attach(core)
        core.Initialize()
        yield Node(master, core, ros)


def frames_of(node, *wanted):
    """Frames by their names: (parent, transform), once all that are wanted have come."""
    found, read = {}, node.topic("/tf", "tf2_msgs/TFMessage")
    while not set(wanted) <= set(found):
        for one in read().transforms:
            found[one.child_frame_id] = one.header.frame_id, one.transform
    return found


def test_every_interface_has_its_messages():
    assert set(KINDS) == set(INTERFACES) - WITHOUT


def test_a_robot_drives_and_reports_where_it_is(node):
    odometry = node.topic("/robot/odom", "nav_msgs/Odometry")
    first, second = odometry(), odometry()
    assert [first.header.frame_id, first.child_frame_id] == ["robot/odom", "robot/base_link"]
    assert second.header.stamp.seconds - first.header.stamp.seconds == pytest.approx(0.1)
    node.talk("/robot/cmd_vel", "geometry_msgs/Twist")(linear__x=0.3, angular__z=0.2)
    wait_for(lambda: (found := odometry()).twist.twist.linear.x > 0.25 and found.twist.twist.angular.z > 0.15)
    wait_for(lambda: odometry().pose.pose.position.x > 0.3)
    truth = node.topic("/truth/ground_truth", "nav_msgs/Odometry")
    place = truth()
    assert place.header.frame_id == "world"
    assert place.pose.pose.position.x == pytest.approx(odometry().pose.pose.position.x, abs=0.1)
    assert place.twist.twist.linear.x == pytest.approx(0.3, abs=0.05)
    node.talk("/robot/enable_motors", "std_msgs/Bool")(data=False)
    wait_for(lambda: abs(odometry().twist.twist.linear.x) < 0.01)
    assert node.topic("/robot/battery", "sensor_msgs/BatteryState")().voltage > 10.0
    node.talk("/truth/set_pose", "geometry_msgs/Pose")(position__x=-3.0, position__z=0.2, orientation__w=1.0)
    wait_for(lambda: truth().pose.pose.position.x == pytest.approx(-3.0, abs=0.01))


def test_sensors(node):
    scan, sonar = node.topic("/laser/scan", "sensor_msgs/LaserScan"), node.topic("/robot/sonar", "sensor_msgs/Range")
    found = scan()
    assert len(found.ranges) == len(found.intensities) == 181
    assert found.ranges[90] == pytest.approx(1.6 - 0.1, abs=0.01)
    assert found.ranges[0] == math.inf
    assert found.header.frame_id == "laser"
    rings = {(one := sonar()).header.frame_id: one for _ in range(16)}
    assert sorted(rings) == sorted(f"robot/sonar_{index}" for index in range(16))
    assert min(one.range for one in rings.values()) < 1.6
    assert next(iter(rings.values())).radiation_type == 0
    marks = node.topic("/laser/fiducials", "geometry_msgs/PoseArray")()
    assert [round(pose.position.x, 1) for pose in marks.poses] == [1.5]
    fix = node.topic("/gps/fix", "sensor_msgs/NavSatFix")()
    assert (round(fix.latitude), round(fix.longitude)) == (49, 15)
    assert fix.status.status == 2


def test_images(node):
    image, info = (
        node.topic("/head/image_raw", "sensor_msgs/Image"),
        node.topic("/head/camera_info", "sensor_msgs/CameraInfo"),
    )
    found, optics = image(), info()
    assert (found.width, found.height, found.step, found.encoding) == (32, 24, 96, "rgb8")
    served = node.core.interface("camera", "head").image
    assert bytes(found.data) == served.tobytes()
    assert len(set(bytes(found.data))) > 2
    assert optics.K[0] == pytest.approx(16.0)
    assert found.header.frame_id == optics.header.frame_id == "head_optical"
    left, right = (node.topic(f"/eyes/{side}/camera_info", "sensor_msgs/CameraInfo")() for side in ("left", "right"))
    assert (left.P[3], right.P[3]) == (0.0, pytest.approx(-0.15 * right.P[0]))
    pair = node.topic("/eyes/right/image_raw", "sensor_msgs/Image")()
    assert len(pair.data) == 32 * 24 * 3
    shifts = node.topic("/eyes/disparity", "stereo_msgs/DisparityImage")()
    assert (shifts.image.encoding, shifts.f, shifts.T) == ("32FC1", pytest.approx(left.P[0]), pytest.approx(0.15))


def test_frames_lead_from_each_sensor_to_the_odometry(node):
    base = "robot/base_link"
    parents = {base: "robot/odom", "laser": base, "head": base, "robot/sonar_0": base, "gps": "laser", "eyes": "world"}
    parents |= {"head_optical": "head", "laser/fiducial_7": "laser"}
    found = frames_of(node, *parents)
    assert {child: found[child][0] for child in parents} == parents
    place = found["laser"][1].translation
    assert (place.x, place.y) == pytest.approx((0.1, 0.0), abs=1e-3)
    assert place.z == pytest.approx(0.311 + 0.07, abs=1e-3)
    turn = found["head_optical"][1].rotation
    assert (turn.w, turn.x, turn.y, turn.z) == (0.5, -0.5, 0.5, -0.5)


def test_a_head_looks_where_it_is_told(node):
    states = node.topic("/head/joint_states", "sensor_msgs/JointState")
    assert states().name == ["head/pan", "head/tilt", "head/zoom"]
    node.talk("/head/pan/command", "std_msgs/Float64")(data=0.5)
    wait_for(lambda: states().position[0] == pytest.approx(0.5, abs=0.05))


def test_a_gripper_opens_and_closes(node):
    closed, opened = (
        node.topic("/gripper/gripper/closed", "std_msgs/Bool"),
        node.topic("/gripper/gripper/opened", "std_msgs/Bool"),
    )
    result = node.topic("/gripper/gripper_cmd/result", "control_msgs/GripperCommandActionResult")
    send = node.talk("/gripper/gripper_cmd/goal", "control_msgs/GripperCommandActionGoal")
    send(goal_id__id="shut", goal__command__position=0.0)
    done = result()
    assert (done.status.goal_id.id, done.status.status) == ("shut", 3)
    assert (done.result.reached_goal, done.result.position) == (True, 0.0)
    wait_for(lambda: closed().data)
    node.ask("/gripper/gripper/open", "std_srvs/Empty")
    wait_for(lambda: opened().data)
    lifted = node.topic("/gripper/lift/up", "std_msgs/Bool")
    node.ask("/gripper/lift/raise", "std_srvs/Empty")
    wait_for(lambda: lifted().data)


def test_services(node, caplog):
    wait_for(lambda: all(f"/gazebo/{name}" in node.master.services for name in SERVICES), node.core.Step)
    names = node.call("get_world_properties").model_names
    assert {"robot", "laser", "crate"} <= set(names)
    state = node.call("get_model_state", model_name="crate", relative_entity_name="robot")
    assert state.success
    assert state.pose.position.x == pytest.approx(2.0, abs=0.01)
    assert not node.call("get_model_state", model_name="none").success
    properties = node.call("get_model_properties", model_name="robot")
    assert {"laser", "head"} <= set(properties.child_model_names)
    link = node.call("get_link_state", link_name=f"crate::{node.core.model('crate').bodies[0].bodyName}")
    assert link.success
    assert link.link_state.pose.position.x == pytest.approx(2.0, abs=0.01)
    assert node.call("get_physics_properties").time_step == pytest.approx(0.02)
    move = node.talk("/gazebo/set_model_state", "gazebo_msgs/ModelState")
    move(model_name="crate", pose__position__x=4.0, pose__position__z=0.5, pose__orientation__w=1.0)
    wait_for(lambda: node.core.model("crate").GetPose().pos.x > 3.9, node.core.Step)
    node.call("pause_physics")
    before = node.core.GetSimTime()
    node.core.step(3)
    assert node.core.GetSimTime() == before
    node.call("unpause_physics")
    node.core.step(3)
    assert node.core.GetSimTime() > before
    node.call("reset_simulation")
    wait_for(lambda: node.core.model("crate").GetPose().pos.x == pytest.approx(2.0, abs=0.01), node.core.Step)
    assert node.call("delete_model", model_name="robot").success
    wait_for(lambda: not node.master.publishers["/robot/odom"], node.core.Step)
    wait_for(lambda: not node.master.subscribers["/robot/cmd_vel"], node.core.Step)
    states = node.topic("/gazebo/model_states", "gazebo_msgs/ModelStates")()
    assert "robot" not in states.name
    assert states.pose[states.name.index("crate")].position.x == pytest.approx(2.0, abs=0.01)


def test_a_command_to_a_model_that_has_just_left_is_dropped(node, caplog):
    kind = message_type("geometry_msgs/Twist")
    wait_for(lambda: "/robot/cmd_vel" in node.master.subscribers, node.core.Step)
    subscription = node.ros.node._subscribers["/robot/cmd_vel"]
    node.core.DeleteModel("robot")
    subscription.received(codec(kind).pack(kind()))
    node.core.Step()
    assert "ClosedError" not in caplog.text


def test_a_wrong_command_is_refused(node, caplog):
    node.talk("/robot/cmd_vel", "geometry_msgs/Twist")(linear__x=math.nan)
    node.talk("/truth/set_pose", "geometry_msgs/Pose")(position__x=1.0)
    for text in ("topic robot/cmd_vel: a number is not finite", "topic truth/set_pose: its rotation has no length"):
        wait_for(lambda text=text: text in caplog.text, node.core.Step)


def test_steps_go_on_natively_while_nobody_listens(node):
    core = node.core
    (companion,) = core.companions
    wait_for(lambda: companion.idle_until() == math.inf, core.Step)
    wait_for(lambda: node.master.publishers.get("/robot/odom"), core.Step)
    sock, _ = open_topic(node.master, "/robot/odom")
    wait_for(lambda: companion.idle_until() == -math.inf)
    sock.close()
    wait_for(lambda: companion.idle_until() == math.inf, core.Step)
