"""Real nodes of ROS 2: TEST_ROS2 names the Python of a ready environment, such as one that `libgz ros venv` made."""

import json
import os
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import pytest
from ros2_robots import ARM, CONTROL, DRIVE, ROBOT, WAGON, wagon
from ros_peers import wait_for

from libgz.ros import bridged

HERE = Path(__file__).parent
PYTHON = os.environ.get("TEST_ROS2", "")

WHY = "TEST_ROS2 names no Python that has rclpy; `libgz ros venv` makes one"
pytestmark = pytest.mark.skipif(not PYTHON, reason=WHY)


class Node:
    """A process with rclpy."""

    def __init__(self, environment):
        program = HERE.parent / "ros2_node.py"
        self.process = subprocess.Popen(
            [PYTHON, program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, text=True, cwd="/"
        )

    def __getattr__(self, name):
        def ask(**values):
            self.process.stdin.write(json.dumps([name, values]) + "\n")
            self.process.stdin.flush()
            return json.loads(self.process.stdout.readline())

        return ask

    def close(self):
        self.process.kill()
        self.process.communicate()


@pytest.fixture
def environment(tmp_path):
    domain = str(os.getpid() % 100 + 1)
    return {
        **os.environ,
        "GAZEBO_MASTER_URI": "http://127.0.0.1:0",
        "LIBGZ_ROS2_PYTHON": PYTHON,
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": domain,
        "TMP": str(tmp_path),  # of the interfaces of legacy worlds, apart from those of other servers
    }


@pytest.fixture
def serve(environment, tmp_path):
    """Runs a command with a world; gives a node beside it."""
    running = []

    def serve(world, *words, command="gzserver"):
        code = f"import sys; from libgz.apps.{command} import main; sys.exit(main(sys.argv[1:]))"
        log = (tmp_path / "server.log").open("w")
        server = subprocess.Popen(
            [sys.executable, "-P", "-c", code, "--ros2", str(world), *words], env=environment, stderr=log, stdout=log
        )
        node = Node(environment)
        running.extend((node, server, log))
        node.server = server
        return node

    yield serve
    for one in running:
        if isinstance(one, subprocess.Popen):
            one.terminate()
            one.wait(20)
        else:
            one.close()


def bridge_of(server):
    """The process id of a server's bridge."""
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if (
                b"bridge/program.py" in path.read_bytes()
                and f"\nPPid:\t{server.pid}\n" in (path.parent / "status").read_text()
            ):
                return int(path.parent.name)
        except OSError:
            continue
    return None


def test_one_topic_each_way_and_a_service(serve):
    node = serve(HERE / "robot2.world")
    assert node.first(topic="/clock", kind="rosgraph_msgs/msg/Clock", best_effort=True) is not None
    assert node.first(topic="/clock", kind="rosgraph_msgs/msg/Clock", patience=2.0) is None  # it is best effort
    assert node.publish(topic="/bot/go", kind="geometry_msgs/msg/Twist", values={"linear": {"x": 0.5}})
    odometry = node.first(topic="/bot/odom", kind="nav_msgs/msg/Odometry")
    assert odometry["twist"]["twist"]["linear"]["x"] == pytest.approx(0.5, abs=0.1)
    assert node.call(service="/pause_physics", kind="std_srvs/srv/Empty", values={}) is not None


TOPICS = {
    "/bot/scan": ("sensor_msgs/msg/LaserScan", True),
    "/cloud_driver/out": ("sensor_msgs/msg/PointCloud2", False),
    "/sonar_driver/out": ("sensor_msgs/msg/Range", False),
    "/bot/imu/data": ("sensor_msgs/msg/Imu", False),
    "/gps_driver/out": ("sensor_msgs/msg/NavSatFix", False),
    "/gps_driver/vel": ("geometry_msgs/msg/Vector3Stamped", False),
    "/bumper_states": ("gazebo_msgs/msg/ContactsState", False),
    "/joint_states": ("sensor_msgs/msg/JointState", False),
    "/truth": ("nav_msgs/msg/Odometry", False),
    "/wrench": ("geometry_msgs/msg/WrenchStamped", False),
    "/grasping": ("std_msgs/msg/Bool", False),
    "/tf": ("tf2_msgs/msg/TFMessage", False),
    "/model_states": ("gazebo_msgs/msg/ModelStates", False),
    "/demo/link_states": ("gazebo_msgs/msg/LinkStates", False),
}


@pytest.mark.trial
def test_every_topic_service_and_node(serve):
    node = serve(HERE / "robot2.world")
    for topic, (kind, best_effort) in TOPICS.items():
        assert node.first(topic=topic, kind=kind, best_effort=best_effort) is not None, topic
    plugin = "<plugin name='guest' filename='libgazebo_ros_planar_move.so'/>"
    text = f"<sdf version='1.6'><model name='x'><link name='l'/>{plugin}</model></sdf>"
    spawn = {"service": "/spawn_entity", "kind": "gazebo_msgs/srv/SpawnEntity"}
    assert node.call(**spawn, values={"name": "box", "xml": text})["success"]
    assert not node.call(**spawn, values={"name": "box", "xml": text})["success"]
    models = node.call(service="/get_model_list", kind="gazebo_msgs/srv/GetModelList", values={})["model_names"]
    assert models == ["ground", "wall", "robot", "box"]
    state = {"name": "box", "pose": {"position": {"x": 2.0}}}
    set_state = {"service": "/set_entity_state", "kind": "gazebo_msgs/srv/SetEntityState"}
    assert node.call(**set_state, values={"state": state})["success"]
    found = node.call(service="/demo/get_entity_state", kind="gazebo_msgs/srv/GetEntityState", values={"name": "box"})
    assert found["state"]["pose"]["position"]["x"] == pytest.approx(2.0)
    wait_for(lambda: "/guest" in node.graph()[0])
    assert node.call(service="/delete_entity", kind="gazebo_msgs/srv/DeleteEntity", values={"name": "box"})["success"]
    wait_for(lambda: "/guest" not in node.graph()[0])
    for service in ("/pause_physics", "/unpause_physics", "/reset_world", "/reset_simulation"):
        assert node.call(service=service, kind="std_srvs/srv/Empty", values={}) == {}
    assert node.set_parameter(owner="/gazebo", name="publish_rate", value=5.0) == ["", [5.0]]
    assert node.set_parameter(owner="/gazebo", name="mine", value=["a", "b"]) == ["", [["a", "b"]]]
    refused = "parameter 'none' cannot be set because it was not declared"
    assert node.set_parameter(owner="/bot/laser", name="none", value=1) == [refused, []]
    listed = node.call(service="/bot/laser/list_parameters", kind="rcl_interfaces/srv/ListParameters", values={})
    assert listed["result"]["names"] == ["use_sim_time"]
    nodes, topics, services = node.graph()
    assert {"/gazebo", "/bot/laser", "/bot/drive", "/joints", "/demo/state"} <= set(nodes)
    assert set(TOPICS) <= set(topics)
    assert "/apply_link_wrench" in services


@pytest.mark.trial
def test_entities_are_spawned_as_launch_files_do(serve, environment, tmp_path):
    node = serve(HERE / "robot2.world")
    program = Path(bridged.__file__).parent / "bridge" / "spawn_entity.py"
    words = ["-topic", "/robot_description", "-entity", "any", "-x", "1.5", "-z", "0.5", "-Y", "-1.57"]
    more = ["-robot_namespace", "fleet", "-wait", "robot", "-unpause", "--ros-args", "-r", "__node:=spawner"]
    spawner = subprocess.Popen([PYTHON, program, *words, *more], env=environment, cwd="/", stderr=subprocess.PIPE)
    text = {"topic": "/robot_description", "kind": "std_msgs/msg/String", "latched": True}
    plugin = "<plugin name='p' filename='libgazebo_ros_planar_move.so'/>"
    base = "<link name='base'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"
    driven = f"<robot name='r'>{base}<gazebo>{plugin}</gazebo></robot>"
    assert node.publish(**text, values={"data": driven})
    said = spawner.communicate(timeout=60)[1].decode()
    assert spawner.returncode == 0, said
    state = {"service": "/get_entity_state", "kind": "gazebo_msgs/srv/GetEntityState", "values": {"name": "any"}}
    place = node.call(**state)["state"]["pose"]
    assert (place["position"]["x"], place["orientation"]["z"]) == pytest.approx((1.5, -0.7068), abs=1e-3)
    assert node.first(topic="/fleet/odom", kind="nav_msgs/msg/Odometry") is not None
    again = [PYTHON, program, "-file", HERE / "arm.world", "-entity", "any"]
    done = subprocess.run(again, env=environment, cwd="/", capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 1
    assert "Entity [any] already exists." in done.stderr


@pytest.mark.trial
def test_15000_messages_at_1_khz_arrive_in_order(serve, tmp_path):
    world = tmp_path / "fast.world"
    slow = "<update_rate>50</update_rate>\n        <joint_name>"
    world.write_text((HERE / "robot2.world").read_text().replace(slow, "<update_rate>1000</update_rate><joint_name>"))
    node = serve(world)
    node.listen(topic="/joint_states", kind="sensor_msgs/msg/JointState", depth=20_000)
    count, begin, end = node.count(topic="/joint_states", wanted=15_000, patience=120.0)
    stamps = node.stamps(topic="/joint_states")
    assert count >= 15_000
    gaps = {after - before for before, after in pairwise(stamps)}
    assert gaps == {1_000_000}, f"{count} messages in {end - begin:.1f} s"


@pytest.mark.trial
def test_a_bridge_that_is_killed_is_started_again(serve):
    node = serve(HERE / "robot2.world")
    node.listen(topic="/clock", kind="rosgraph_msgs/msg/Clock", best_effort=True)
    assert node.count(topic="/clock", wanted=5)[0] >= 5
    os.kill(wait_for(lambda: bridge_of(node.server)), 9)
    begin = time.monotonic()
    node.clear(topic="/clock")
    count = node.count(topic="/clock", wanted=20)[0]
    assert count >= 20, f"after {time.monotonic() - begin:.1f} s"
    assert node.server.poll() is None
    assert node.call(service="/pause_physics", kind="std_srvs/srv/Empty", values={}) == {}


@pytest.mark.trial
@pytest.mark.parametrize(
    ("best_effort", "latched", "expected"), [(True, False, True), (False, False, False), (True, True, False)]
)
def test_qualities_of_service_match_as_declared(serve, best_effort, latched, expected):
    node = serve(HERE / "robot2.world")
    quality = {"best_effort": best_effort, "latched": latched, "patience": 20.0 if expected else 4.0}
    found = node.first(topic="/bot/scan", kind="sensor_msgs/msg/LaserScan", **quality)
    assert (found is not None) == expected


@pytest.mark.trial
def test_a_client_of_actions_moves_an_arm(serve, tmp_path):
    (tmp_path / "arm.yaml").write_text(CONTROL.replace("{type: forward", "{off: forward"))
    (tmp_path / "arm.world").write_text(ARM.format(file=tmp_path / "arm.yaml"))
    node = serve(tmp_path / "arm.world")
    assert node.publish(topic="/robot_description", kind="std_msgs/msg/String", values={"data": ROBOT}, latched=True)
    follow = {"action": "/follower/follow_joint_trajectory", "joints": ["elbow"]}
    accepted, status, code, feedback = node.follow(**follow, positions=[1.0], seconds=0.5)
    assert (accepted, status, code) == (True, 4, 0)  # succeeded
    assert feedback > 5
    assert node.follow(**follow, positions=[2.0], seconds=60.0, cancel=True)[:2] == [True, 5]  # cancelled
    assert node.follow(**{**follow, "joints": ["knee"]}, positions=[2.0], seconds=1.0)[0] is False
    state = node.first(topic="/follower/controller_state", kind="control_msgs/msg/JointTrajectoryControllerState")
    assert state["reference"]["positions"][0] == pytest.approx(1.0, abs=0.2)
    found = node.call(service="/follower/query_state", kind="control_msgs/srv/QueryTrajectoryState", values={})
    assert (found["success"], found["name"]) == (True, ["elbow"])
    assert node.first(topic="/joint_states", kind="sensor_msgs/msg/JointState")["name"] == ["elbow"]


@pytest.mark.trial
def test_what_is_too_large_is_left_out(serve, tmp_path):
    (tmp_path / "arm.yaml").write_text(CONTROL.replace("{type: forward", "{off: forward"))
    (tmp_path / "arm.world").write_text(ARM.format(file=tmp_path / "arm.yaml"))
    node = serve(tmp_path / "arm.world")
    text = {"topic": "/robot_description", "kind": "std_msgs/msg/String", "latched": True}
    assert node.publish(**text, values={"data": "x" * 5_000_000}, times=3)
    log = tmp_path / "server.log"
    wait_for(lambda: "bytes are left out" in log.read_text())
    spawn = {"service": "/spawn_entity", "kind": "gazebo_msgs/srv/SpawnEntity"}
    assert not node.call(**spawn, values={"name": "box", "xml": "x" * (1 << 24)})["success"]
    assert node.publish(**text, values={"data": ROBOT})
    assert node.first(topic="/joint_states", kind="sensor_msgs/msg/JointState")["name"] == ["elbow"]
    assert log.read_text().count("/robot_description: messages of") == 1
    assert log.read_text().count("/spawn_entity: a request of") == 1


@pytest.mark.trial
def test_a_diff_drive_controller_drives(serve, tmp_path):
    (tmp_path / "drive.yaml").write_text(DRIVE)
    (tmp_path / "drive.world").write_text(wagon(tmp_path / "drive.yaml"))
    node = serve(tmp_path / "drive.world")
    assert node.publish(topic="/robot_description", kind="std_msgs/msg/String", values={"data": WAGON}, latched=True)
    values = {"twist": {"linear": {"x": 0.4}}}
    assert node.publish(topic="/drive/cmd_vel", kind="geometry_msgs/msg/TwistStamped", values=values, times=100)
    odometry = node.first(topic="/drive/odom", kind="nav_msgs/msg/Odometry")
    assert odometry["pose"]["pose"]["position"]["x"] > 0.3
    assert node.first(topic="/tf", kind="tf2_msgs/msg/TFMessage")["transforms"][0]["child_frame_id"] == "base_link"
    assert node.first(topic="/states/dynamic_joint_states", kind="control_msgs/msg/DynamicJointState") is not None


# Topics of legacy.world: types, and frames without numbers.
DEVICES = {
    "/robot/odom": ("nav_msgs/msg/Odometry", "robot/odom"),
    "/robot/sonar": ("sensor_msgs/msg/Range", "robot/sonar_"),
    "/laser/scan": ("sensor_msgs/msg/LaserScan", "laser"),
    "/gps/fix": ("sensor_msgs/msg/NavSatFix", "gps"),
    "/head/image_raw": ("sensor_msgs/msg/Image", "head_optical"),
    "/head/joint_states": ("sensor_msgs/msg/JointState", "head"),
}


@pytest.mark.trial
def test_a_legacy_world_is_served(serve):
    node = serve(HERE / "legacy.world", "-s", str(os.getpid()), command="gazebo")  # beside other servers
    names = node.call(service="/get_model_list", kind="gazebo_msgs/srv/GetModelList", values={})["model_names"]
    assert {"robot", "laser", "head", "gps", "gripper"} <= set(names)
    assert node.first(topic="/clock", kind="rosgraph_msgs/msg/Clock", best_effort=True) is not None
    found = {topic: node.first(topic=topic, kind=kind) for topic, (kind, _) in DEVICES.items()}
    assert {topic: one["header"]["frame_id"].rstrip("0123456789") for topic, one in found.items()} == {
        topic: frame for topic, (_, frame) in DEVICES.items()
    }
    assert found["/laser/scan"]["angle_max"] == pytest.approx(1.5708, abs=1e-4)
    assert found["/gps/fix"]["latitude"] == pytest.approx(48.753, abs=1e-3)
    assert found["/head/joint_states"]["position"] == pytest.approx([0.0, 0.0, 1.5708], abs=1e-3)
    assert node.publish(topic="/robot/cmd_vel", kind="geometry_msgs/msg/Twist", values={"linear": {"x": 0.3}})
    assert node.publish(topic="/head/pan/command", kind="std_msgs/msg/Float64", values={"data": 0.5})
    assert node.grip(action="/gripper/gripper_cmd", position=0.0) == [True, 4, pytest.approx(0.0, abs=0.05)]
    assert node.grip(action="/gripper/gripper_cmd", position=1.0) == [True, 4, pytest.approx(1.0, abs=0.05)]
    odometry = node.first(topic="/robot/odom", kind="nav_msgs/msg/Odometry")
    assert odometry["twist"]["twist"]["linear"]["x"] == pytest.approx(0.3, abs=0.01)
    head = node.first(topic="/head/joint_states", kind="sensor_msgs/msg/JointState")
    assert head["position"][0] == pytest.approx(0.5, abs=0.02)


@pytest.mark.trial
def test_images_come_at_30_hz(serve, tmp_path):
    world = tmp_path / "eye.world"
    world.write_text(
        "<sdf version='1.6'><world name='default'><model name='m'><static>true</static><link name='l'>"
        "<visual name='v'><pose>3 0 0 0 0 0</pose><geometry><box><size>1 1 1</size></box></geometry></visual>"
        "<sensor name='eye' type='camera'><update_rate>30</update_rate><camera><image><width>640</width>"
        "<height>480</height></image></camera><plugin name='d' filename='libgazebo_ros_camera.so'/></sensor></link>"
        "</model></world></sdf>"
    )
    node = serve(world)
    node.listen(topic="/eye/image_raw", kind="sensor_msgs/msg/Image", depth=100)
    count, begin, end = node.count(topic="/eye/image_raw", wanted=150, patience=90.0)
    assert count >= 150
    stamps = node.stamps(topic="/eye/image_raw")
    # The first one comes when the camera is switched on, between two of its times.
    periods = sorted(round((after - before) / 1e6) for before, after in pairwise(stamps[1:]))
    # A busy computer loses some of a depth of 5, which is that of the original.
    assert periods[0] >= 33
    assert periods[len(periods) // 2] <= 34, f"{count} images in {end - begin:.1f} s"
