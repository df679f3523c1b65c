"""Nodes of a real ROS 1 and gzserver: Debian 12's packages, in a root of their own.

LIBGZ_ROS1_ROOT names the root, which is made by debootstrap if it does not exist (about 0.5 GB, 2 minutes, as root).
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

ROOT = Path(os.environ.get("LIBGZ_ROS1_ROOT", "/opt/ros1"))
WORLD = Path(__file__).parents[1] / "ros" / "turtle.world"
PACKAGES = (
    "python3-roslaunch python3-rostopic python3-rosservice python3-rosnode python3-rosparam python3-rosbag "
    "python3-rospy ros-robot-state-publisher python3-tf2-ros python3-sensor-msgs python3-nav-msgs "
    "python3-geometry-msgs python3-std-srvs python3-tf2-msgs python3-trajectory-msgs"
)
PORT = 21411
COUNT = """
import time, rospy
from rosgraph_msgs.msg import Clock
got = []
rospy.init_node("counter", disable_rostime=True)
rospy.Subscriber("/clock", Clock, lambda m: got.append(m.clock.to_nsec()), queue_size=None)
end = time.time() + 60
while len(got) < 15000 and time.time() < end: time.sleep(0.1)
lost = sum((b - a) // 1000000 - 1 for a, b in zip(got, got[1:]))
print("received", len(got), "lost", lost)
"""


def in_root(*command, patience=30, check=True):
    """What a command prints in the root."""
    environment = {"ROS_MASTER_URI": f"http://127.0.0.1:{PORT}", "ROS_IP": "127.0.0.1", "HOME": "/root"}
    environment |= {"PYTHONUNBUFFERED": "1", "PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}
    done = subprocess.run(
        ["chroot", ROOT, *command], env=environment, capture_output=True, text=True, timeout=patience, check=False
    )
    assert done.returncode == 0 or not check, (command, done.stdout, done.stderr)
    return done.stdout


def begin(*command, **environment):
    return subprocess.Popen(command, env=os.environ | environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def ros():
    if os.getuid() != 0 or shutil.which("debootstrap") is None:
        pytest.skip("a root with ROS 1 is made by debootstrap, as root")
    if not (ROOT / "usr/bin/rostopic").exists():
        subprocess.run(["debootstrap", "--variant=minbase", "bookworm", ROOT], check=True)
        (ROOT / "etc/hosts").write_text("127.0.0.1 localhost\n")
        in_root("apt-get", "update", patience=300)
        in_root("apt-get", "install", "-y", "--no-install-recommends", *PACKAGES.split(), patience=1500)
    master = begin("chroot", str(ROOT), "roscore", "-p", str(PORT), HOME="/root", ROS_IP="127.0.0.1")
    wait_until(lambda: "run_id" in in_root("rosparam", "list", check=False))
    yield
    master.send_signal(signal.SIGINT)
    master.wait(20)


def wait_until(condition):
    end = time.monotonic() + 40
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.3)


@pytest.fixture
def server(ros, tmp_path):
    environment = {"ROS_MASTER_URI": f"http://127.0.0.1:{PORT}", "GAZEBO_MASTER_URI": "http://127.0.0.1:21412"}
    found = begin(sys.executable, "-m", "libgz.apps.gzserver", str(WORLD), **environment, HOME=str(tmp_path))
    wait_until(lambda: "/odom" in in_root("rostopic", "list", check=False))
    yield found
    found.terminate()
    assert found.wait(20) == 0
    assert "/odom" not in in_root("rostopic", "list")


def test_the_tools_see_topics_and_services(server):
    assert {"/clock", "/cmd_vel", "/odom", "/scan", "/tf"} <= set(in_root("rostopic", "list").split())
    assert "Type: nav_msgs/Odometry" in in_root("rostopic", "info", "/odom")
    assert 'frame_id: "odom"' in in_root("rostopic", "echo", "-n1", "/odom")
    assert len([one for one in in_root("rosservice", "list").split() if one.startswith("/gazebo/")]) >= 27
    assert "/cmd_vel" in in_root("rosnode", "info", "/gazebo")
    assert in_root("rosparam", "get", "/use_sim_time").strip() == "true"
    for topic, rate in {"/odom": 30.0, "/scan": 10.0}.items():
        text = in_root("timeout", "-s", "INT", "8", "rostopic", "hz", topic, check=False)
        found = [float(one) for one in re.findall(r"average rate: ([\d.]+)", text)]
        assert found[-1] == pytest.approx(rate, rel=0.02)


def test_no_message_is_lost(server):
    assert "received 150" in (text := in_root("python3", "-c", COUNT, patience=90))
    assert "lost 0" in text


def test_a_command_moves_the_robot(server):
    twist = "{linear: {x: 0.2}, angular: {z: 0.5}}"
    in_root("rostopic", "pub", "-1", "/cmd_vel", "geometry_msgs/Twist", twist)
    text = in_root("rostopic", "echo", "-n1", "/odom/twist/twist/angular/z")
    assert float(text.split()[0]) == pytest.approx(0.5, abs=0.05)
