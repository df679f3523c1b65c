"""Nodes and tools of a real ROS 1, and libgz's servers of both eras.

LIBGZ_ROS1_ROOT names a root with Debian's packages of ROS 1 (roscore, rostopic, rosservice, rosnode, rosparam, rosbag,
rospy, tf2_ros and the usual messages; robot_state_publisher if it is there), which is entered by chroot, as root.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.trial

ROOT = Path(os.environ.get("LIBGZ_ROS1_ROOT", "/nonexistent"))
WORLDS = Path(__file__).parents[1] / "ros"
PORT = 21411
RATES = {"/odom": 30.0, "/scan": 10.0, "/robot/imu": 50.0, "/robot/joint_states": 50.0, "/truth": 40.0}
LEGACY = {
    "/robot/odom": 'frame_id: "robot/odom"',
    "/robot/battery": "voltage:",
    "/robot/sonar": "radiation_type: 0",
    "/laser/scan": "angle_increment:",
    "/laser/fiducials": "poses:",
    "/gps/fix": "latitude:",
    "/head/joint_states": "head/pan",
    "/head/image_raw": 'encoding: "rgb8"',
    "/head/camera_info": "plumb_bob",
    "/truth/ground_truth": 'frame_id: "world"',
    "/gripper/gripper/opened": "data:",
    "/eyes/left/image_raw": "height: 24",
    "/eyes/disparity": "32FC1",
}
COUNT = """
import time, rospy
from rosgraph_msgs.msg import Clock
got = []
rospy.init_node("counter", disable_rostime=True)
rospy.Subscriber("/clock", Clock, lambda m: got.append(m.clock.to_nsec()), queue_size=None)
print("ready", flush=True)
end = time.time() + 100
while len(got) < 15000 and time.time() < end: time.sleep(0.1)
lost = sum((b - a) // 1000000 - 1 for a, b in zip(got, got[1:]))
print("received", len(got), "lost", lost)
"""
LOOK_UP = """
import sys, rospy, tf2_ros
rospy.init_node("looker")
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
found = buffer.lookup_transform(sys.argv[1], sys.argv[2], rospy.Time(0), rospy.Duration(20)).transform
print(found.translation.x, found.translation.y, found.translation.z)
"""
GRIP = """
import time, rospy
from std_srvs.srv import Empty
rospy.init_node("gripper")
rospy.wait_for_service("/gripper/gripper/close", 20)
rospy.ServiceProxy("/gripper/gripper/close", Empty)()
from std_msgs.msg import Bool
end = time.time() + 40
while not rospy.wait_for_message("/gripper/gripper/closed", Bool, 20).data: assert time.time() < end
print("closed")
"""


def environment():
    found = {"ROS_MASTER_URI": f"http://127.0.0.1:{PORT}", "ROS_IP": "127.0.0.1", "HOME": "/root"}
    return {**found, "PYTHONUNBUFFERED": "1", "PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}


def in_root(*command, patience=60, check=True):
    """What a command prints in the root."""
    done = subprocess.run(
        ["chroot", ROOT, *command], env=environment(), capture_output=True, text=True, timeout=patience, check=False
    )
    assert done.returncode == 0 or not check, (command, done.stdout, done.stderr)
    return done.stdout


def begin(*command, **environment):
    return subprocess.Popen(command, env=os.environ | environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def wait_until(condition, patience=60):
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.3)


class RosCore:
    """A roscore of the root, which can be killed and started again."""

    def start(self):
        self.process = begin("chroot", str(ROOT), "roscore", "-p", str(PORT), HOME="/root", ROS_IP="127.0.0.1")
        wait_until(lambda: "run_id" in in_root("rosparam", "list", check=False))

    def end(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(30)


@pytest.fixture(scope="module")
def core():
    if os.getuid() != 0 or not (ROOT / "usr/bin/rostopic").exists():
        pytest.skip("LIBGZ_ROS1_ROOT names no root with Debian's packages of ROS 1, or this user is not root")
    found = RosCore()
    found.start()
    yield found
    found.end()


@pytest.fixture
def serve(core, tmp_path):
    """Starts a server with a world, and waits for a topic."""
    servers = []

    def serve(command, world, topic):
        more = {"ROS_MASTER_URI": f"http://127.0.0.1:{PORT}", "GAZEBO_MASTER_URI": "http://127.0.0.1:21412"}
        module = f"libgz.apps.{command}"
        words = ("-s", "auto") if command == "gazebo" else ()
        servers.append(
            begin(
                sys.executable,
                "-m",
                module,
                *words,
                "--ros1",
                str(world),
                **more,
                HOME=str(tmp_path),
                TMP=str(tmp_path),
            )
        )
        wait_until(lambda: topic in in_root("rostopic", "list", check=False).split())
        return topic

    yield serve
    for server in servers:
        server.terminate()
        assert server.wait(30) == 0
    assert "/gazebo" not in in_root("rosnode", "list").split()  # it has unregistered


@pytest.fixture
def turtle(serve):
    return serve("gzserver", WORLDS / "turtle.world", "/odom")


def test_the_tools_see_topics_services_and_parameters(turtle):
    listed = set(in_root("rostopic", "list").split())
    assert {"/clock", "/cmd_vel", "/tf", *RATES} <= listed
    assert "Type: nav_msgs/Odometry" in in_root("rostopic", "info", "/odom")
    assert len([one for one in in_root("rosservice", "list").split() if one.startswith("/gazebo/")]) >= 27
    assert "/cmd_vel" in in_root("rosnode", "info", "/gazebo")
    assert in_root("rosparam", "get", "/use_sim_time").strip() == "true"
    for topic in RATES:
        assert "frame_id" in in_root("rostopic", "echo", "-n1", topic) or topic.endswith("joint_states")
    for topic, rate in RATES.items():
        text = in_root("timeout", "-s", "INT", "10", "rostopic", "hz", topic, check=False)
        found = [float(one) for one in re.findall(r"average rate: ([\d.]+)", text)]
        assert found[-1] == pytest.approx(rate, rel=0.02), topic


def test_no_message_is_lost_while_the_master_is_killed_and_returns(turtle, core):
    counter = subprocess.Popen(
        ["chroot", ROOT, "python3", "-c", COUNT], env=environment(), stdout=subprocess.PIPE, text=True
    )
    assert counter.stdout.readline() == "ready\n"
    time.sleep(4.0)
    core.end()
    time.sleep(2.0)
    core.start()
    wait_until(lambda: turtle in in_root("rostopic", "list", check=False).split())
    text, _ = counter.communicate(timeout=130)
    assert "received 150" in text
    assert "lost 0" in text


def test_a_bag_is_recorded_and_played(turtle):
    in_root(
        "rosbag", "record", "-q", "--duration=5", "-O", "/tmp/libgz-trial.bag", *RATES, "/tf", "/clock", patience=90
    )
    about = in_root("rosbag", "info", "/tmp/libgz-trial.bag")
    for topic in (*RATES, "/tf", "/clock"):
        assert topic in about
    in_root(
        "rosbag", "play", "-q", "-u", "1", "/tmp/libgz-trial.bag", "/odom:=/played", "--topics", "/odom", patience=90
    )
    (ROOT / "tmp/libgz-trial.bag").unlink()


def test_commands_and_transforms(turtle):
    twist = "{linear: {x: 0.2}, angular: {z: 0.5}}"
    in_root("rostopic", "pub", "-1", "/cmd_vel", "geometry_msgs/Twist", twist)
    text = in_root("rostopic", "echo", "-n1", "/odom/twist/twist/angular/z")
    assert float(text.split()[0]) == pytest.approx(0.5, abs=0.05)
    in_root("python3", "-c", LOOK_UP, "odom", "left_wheel")


def test_legacy_models(serve):
    serve("gazebo", WORLDS / "legacy.world", "/robot/odom")
    wait_until(lambda: set(LEGACY) <= set(in_root("rostopic", "list").split()))
    assert "gazebo_msgs/ModelStates" in in_root("rostopic", "info", "/gazebo/model_states")
    for topic, text in LEGACY.items():
        assert text in in_root("rostopic", "echo", "-n1", topic), topic
    in_root("rostopic", "pub", "-1", "/robot/cmd_vel", "geometry_msgs/Twist", "{linear: {x: 0.3}}")
    wait_until(lambda: float(in_root("rostopic", "echo", "-n1", "/robot/odom/pose/pose/position/x").split()[0]) > 0.1)
    x, y, z = map(float, in_root("python3", "-c", LOOK_UP, "robot/base_link", "laser").split())
    assert (x, y, z) == pytest.approx((0.1, 0.0, 0.381), abs=2e-3)
    assert "closed" in in_root("python3", "-c", GRIP, patience=90)
    in_root("rosservice", "call", "/gazebo/pause_physics")
    in_root("rosservice", "call", "/gazebo/unpause_physics")


def test_robot_state_publisher_reads_the_joints(turtle):
    if shutil.which("robot_state_publisher", path=str(ROOT / "usr/lib/robot_state_publisher")) is None:
        pytest.skip("the root has no robot_state_publisher")
    links = "<link name='a'/><link name='b'/>"
    joint = (
        "<joint name='left_joint' type='continuous'><parent link='a'/><child link='b'/><origin xyz='0 0 1'/></joint>"
    )
    in_root("rosparam", "set", "/robot_description", f"<robot name='r'>{links}{joint}</robot>")
    node = subprocess.Popen(
        ["chroot", ROOT, "/usr/lib/robot_state_publisher/robot_state_publisher", "joint_states:=/robot/joint_states"],
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    assert in_root("python3", "-c", LOOK_UP, "a", "b").split()[2] == "1.0"
    node.terminate()
    node.wait(20)
