"""gazebo_ros_control: controllers of positions, velocities and efforts, trajectories and a gripper."""

import math
import signal
import threading
from itertools import pairwise
from pathlib import Path

import pytest
from ros2_robots import wagon
from ros_peers import Service, Talker, open_topic, read_block, wait_for

from libgz.apps.manage_controllers import main as manager
from libgz.apps.spawn_controllers import main as spawner
from libgz.base.errors import ParameterError
from libgz.ros.control.drive import Limiter
from libgz.ros.control.trajectory import Trajectory
from libgz.ros.packing import codec
from libgz.ros.types import Stamp, message_type, service_type

JOINT = "<joint name='{0}' type='{1}'><limit lower='-2' upper='2' effort='{2}' velocity='{3}'/></joint>"
DRIVE = """<transmission name='t_{0}'><type>transmission_interface/SimpleTransmission</type>
<joint name='{0}'><hardwareInterface>hardware_interface/{1}JointInterface</hardwareInterface></joint></transmission>"""
URDF = "<robot name='arm'>{}{}{}{}{}{}</robot>".format(
    *(
        JOINT.format(*row)
        for row in (("shoulder", "revolute", 50, 3), ("elbow", "continuous", 20, 5), ("grip", "prismatic", 5, 1))
    ),
    *(DRIVE.format(*row) for row in (("shoulder", "Effort"), ("elbow", "Position"), ("grip", "Effort"))),
)
PID = {"p": 60.0, "d": 4.0}
PARAMETERS = {
    "/arm/states": {
        "type": "joint_state_controller/JointStateController",
        "publish_rate": 50,
        "extra_joints": [{"name": "wheel", "position": 2.0, "effort": 1.0}, {"name": "elbow"}, {"position": 1}, 7],
    },
    "/arm/shoulder": {"type": "effort_controllers/JointPositionController", "joint": "shoulder", "pid": PID},
    "/arm/push": {"type": "effort_controllers/JointEffortController", "joint": "shoulder"},
    "/arm/elbow": {
        "type": "position_controllers/JointTrajectoryController",
        "joints": ["elbow"],
        "constraints": {"elbow": {"goal": 0.01}, "goal_time": 0.5},
    },
    "/arm/hand": {"type": "effort_controllers/GripperActionController", "joint": "grip", "gains": {"grip": PID}},
    "/arm/wrong": {"type": "effort_controllers/JointPositionController", "joint": "elbow", "pid": PID},
    "/arm/unknown": {"type": "effort_controllers/JointPosition"},
}


class Arm:
    """The arm, and its controller manager."""

    def __init__(self, master, core, name="arm"):
        self.master, self.core = master, core
        self.model = core.facade.ModelByName(name)

    def call(self, name, kind, /, **values):
        """Call a service of the controller manager."""
        service = service_type(f"controller_manager_msgs/{kind}")
        wait_for(lambda: f"/arm/controller_manager/{name}" in self.master.services, self.core.Step)
        client = Service(self.master, f"/arm/controller_manager/{name}", md5sum=service.md5)
        client.send(codec(service.request).pack(service.request(**values)))
        client.socket.settimeout(0.001)

        def first():
            try:
                return client.socket.recv(1)
            except TimeoutError:
                return b""

        assert wait_for(first, self.core.Step) == b"\1"
        client.socket.settimeout(10.0)
        return codec(service.response).unpack(read_block(client.socket))

    def load(self, *names):
        """Load and start controllers; whether that worked."""
        if not all(self.call("load_controller", "LoadController", name=name).ok for name in names):
            return False
        return self.call("switch_controller", "SwitchController", start_controllers=list(names), strictness=2).ok

    def send(self, topic, message, name="/talker"):
        """Publish one message, and step until it is there."""
        wait_for(lambda: topic in self.master.subscribers, self.core.Step)
        talker = Talker(self.master, topic, message.kind.name, message.kind.md5, name)
        talker.send(codec(message.kind).pack(message))
        return talker

    def read(self, topic):
        """A function that reads the next message of a topic."""
        wait_for(lambda: topic in self.master.publishers, self.core.Step)
        sock, _ = open_topic(self.master, topic)
        return lambda kind: codec(message_type(kind)).unpack(read_block(sock))

    def position(self, joint):
        return self.model.GetJoint(joint).Position(0)


@pytest.fixture
def arm(master, start):
    master.parameters |= PARAMETERS | {"/robot_description": URDF}
    core, _ = start((Path(__file__).parent / "arm.world").read_text())
    return Arm(master, core)


def test_controllers_are_loaded_started_switched_and_listed(arm, caplog):
    assert (
        "effort_controllers/JointPositionController" in arm.call("list_controller_types", "ListControllerTypes").types
    )
    assert arm.load("states", "shoulder")
    assert not arm.call("load_controller", "LoadController", name="none").ok
    assert not arm.call("load_controller", "LoadController", name="wrong").ok
    assert "no joint 'elbow' with hardware_interface/EffortJointInterface; there are shoulder, grip" in caplog.text
    assert not arm.call("load_controller", "LoadController", name="unknown").ok
    assert "did you mean 'effort_controllers/JointPositionController'" in caplog.text
    assert not arm.load("push")  # the shoulder is taken
    assert "Resource conflict on [shoulder]" in caplog.text
    switch = {"start_controllers": ["push"], "stop_controllers": ["shoulder"], "strictness": 2}
    assert arm.call("switch_controller", "SwitchController", **switch).ok
    found = {one.name: one for one in arm.call("list_controllers", "ListControllers").controller}
    assert {name: one.state for name, one in found.items()} == {
        "states": "running", "shoulder": "stopped", "push": "running",
    }  # fmt: skip
    assert found["push"].claimed_resources[0].resources == ["shoulder"]
    assert not arm.call("unload_controller", "UnloadController", name="push").ok  # it runs
    assert arm.call("unload_controller", "UnloadController", name="shoulder").ok
    wait_for(lambda: arm.master.subscribers.get("/arm/push/command"))
    wait_for(lambda: not arm.master.subscribers.get("/arm/shoulder/command"))  # it listens no longer


def test_the_spawner_loads_starts_and_at_its_end_unloads_them(arm, monkeypatch):
    monkeypatch.setenv("ROS_NAMESPACE", "/arm")
    monkeypatch.setattr("signal.signal", lambda number, handler: handlers.setdefault(number, handler))
    handlers, codes = {}, []
    thread = threading.Thread(target=lambda: codes.append(spawner(["states", "shoulder", "__name:=s"])))
    thread.start()
    manager = arm.core.facade.server.plugins.of_model(arm.model)[0].plugin.manager
    wait_for(lambda: [one.state for one in manager.controllers.values()] == ["running"] * 2, arm.core.Step)
    handlers[signal.SIGINT]()
    wait_for(lambda: codes, arm.core.Step)
    thread.join()
    assert codes == [0]
    assert not manager.controllers


def test_the_script_of_the_manager_lists_loads_starts_stops_and_unloads(arm, monkeypatch, capsys):
    monkeypatch.setenv("ROS_NAMESPACE", "/arm")

    def manage(*words):
        codes = []
        thread = threading.Thread(target=lambda: codes.append(manager([*words, "__name:=m"])))
        thread.start()
        wait_for(lambda: codes, arm.core.Step)
        thread.join()
        return codes[0], capsys.readouterr().out.splitlines()

    assert manage("lc") == (0, ["No controllers are loaded in mechanism control"])
    assert manage("load", "shoulder") == (0, ["Loaded 'shoulder'"])
    assert manage("start", "shoulder") == (0, ["Started 'shoulder' successfully"])
    states = ["Loaded 'states'", "Started 'states' successfully"]
    assert manage("spawn", "states") == (0, states)
    kinds = {"shoulder": "EffortJointInterface", "states": "JointStateInterface"}
    rows = [f"'{name}' - 'hardware_interface::{kind}' ( running )" for name, kind in kinds.items()]
    assert manage("list") == (0, rows)
    assert manage("unload", "shoulder") == (1, ["Error when unloading 'shoulder'"])  # it runs
    assert manage("kill", "shoulder") == (0, ["Stopped 'shoulder' successfully", "Unloaded 'shoulder' successfully"])
    assert "effort_controllers/JointPositionController" in manage("list-types")[1]
    assert manage("reload-libraries") == (0, ["Successfully reloaded libraries"])
    assert manage("lc")[1] == ["No controllers are loaded in mechanism control"]


def test_commands_move_joints_and_states_are_published(arm):
    assert arm.load("states", "shoulder")
    talker = arm.send("/arm/shoulder/command", message_type("std_msgs/Float64")(data=0.7))
    wait_for(lambda: abs(arm.position("shoulder") - 0.7) < 0.02, arm.core.Step)
    wait_for(lambda: "/arm/joint_states" in arm.master.publishers, arm.core.Step)
    sock, _ = open_topic(arm.master, "/arm/joint_states")
    kind = message_type("sensor_msgs/JointState")
    publisher = arm.core.facade.server.plugins.of_model(arm.model)[0].plugin.manager.controllers["states"]._publication
    wait_for(lambda: publisher.listened, arm.core.Step)
    for _ in range(60):
        arm.core.Step()
    found = codec(kind).unpack(read_block(sock))
    assert found.name == ["shoulder", "elbow", "grip", "wheel"]
    assert (found.position[3], found.velocity[3], found.effort[3]) == (2.0, 0.0, 1.0)
    assert found.position[0] == pytest.approx(arm.position("shoulder"), abs=0.05)
    assert len(found.velocity) == len(found.effort) == 4
    talker.close()


def goal_of(kind, **values):
    return message_type(f"control_msgs/{kind}ActionGoal")(
        goal_id=message_type("actionlib_msgs/GoalID")(id="g1"),
        goal=message_type(f"control_msgs/{kind}Goal")(**values),
    )


def result_of(arm, topic, kind, goal):
    """Send a goal, and step until it is over, at most 5 s of sim time; its result."""
    wait_for(lambda: f"{topic}/result" in arm.master.publishers, arm.core.Step)
    sock, _ = open_topic(arm.master, f"{topic}/result")
    action = (
        arm.core.facade.server.plugins.of_model(arm.model)[0].plugin.manager.controllers[topic.split("/")[2]]._action
    )
    wait_for(lambda: action._results.listened, arm.core.Step)
    before = action.goal
    talker = arm.send(f"{topic}/goal", goal)
    wait_for(lambda: action.goal is not before, arm.core.Step)
    end = arm.core.GetSimTime() + 5.0
    while action.goal.active:
        assert arm.core.GetSimTime() < end, "the goal does not end"
        arm.core.Step()
    body = read_block(sock)
    talker.close()
    return codec(message_type(f"control_msgs/{kind}ActionResult")).unpack(body)


def test_a_trajectory_is_followed_by_its_action(arm):
    assert arm.load("elbow")
    point = message_type("trajectory_msgs/JointTrajectoryPoint")
    trajectory = message_type("trajectory_msgs/JointTrajectory")(
        joint_names=["elbow"],
        points=[
            point(positions=[0.4], velocities=[0.5], time_from_start=Stamp(0, 300_000_000)),
            point(positions=[0.6], velocities=[0.0], time_from_start=Stamp(0, 700_000_000)),
        ],
    )
    kind, topic = "FollowJointTrajectory", "/arm/elbow/follow_joint_trajectory"
    begin = arm.core.GetSimTime()
    result = result_of(arm, topic, kind, goal_of(kind, trajectory=trajectory))
    assert (result.status.status, result.status.goal_id.id, result.result.error_code) == (3, "g1", 0)
    assert arm.position("elbow") == pytest.approx(0.6, abs=0.01)
    assert arm.core.GetSimTime() - begin > 0.7
    trajectory.joint_names = ["shoulder"]
    result = result_of(arm, topic, kind, goal_of(kind, trajectory=trajectory))
    assert (result.status.status, result.result.error_code) == (5, -2)


def test_a_gripper_closes_by_its_action(arm):
    assert arm.load("hand")
    command = message_type("control_msgs/GripperCommand")(position=0.05, max_effort=4.0)
    result = result_of(arm, "/arm/hand/gripper_cmd", "GripperCommand", goal_of("GripperCommand", command=command))
    assert (result.status.status, result.result.reached_goal) == (3, True)
    assert arm.position("grip") == pytest.approx(0.05, abs=0.011)


def test_polynomials_pass_through_their_points():
    point = message_type("trajectory_msgs/JointTrajectoryPoint")

    def trajectory(**values):
        message = message_type("trajectory_msgs/JointTrajectory")(
            joint_names=["a"], points=[point(positions=[2.0], time_from_start=Stamp(2), **values)]
        )
        return Trajectory.of_message(message, ["a"], 1.0, [1.0], [0.5], lambda _i, _b, wanted: wanted)

    for values in ({}, {"velocities": [0.25]}, {"velocities": [0.25], "accelerations": [0.1]}):
        found = trajectory(**values)
        assert found.at(0.0)[0] == [1.0]
        assert found.at(1.0)[0] == pytest.approx([1.0])
        assert found.at(3.0)[0] == [2.0]
        positions, speeds, _ = found.at(3.0 - 1e-9)
        assert positions == pytest.approx([2.0])
        assert speeds == pytest.approx(values.get("velocities", [0.5]))
        step = 1e-6
        before, now = found.at(2.0 - step)[0][0], found.at(2.0 + step)[0][0]
        assert (now - before) / (2.0 * step) == pytest.approx(found.at(2.0)[1][0], abs=1e-5)
    assert math.isclose(trajectory().at(2.0)[0][0], 1.5)


WHEELS = "".join(
    f"<joint name='{side}' type='continuous'><parent link='base'/><child link='{side}'/><origin xyz='0 {y} 0'/></joint>"
    f"<link name='{side}'><collision><geometry><cylinder radius='0.1' length='0.05'/></geometry></collision></link>"
    + DRIVE.format(side, "Velocity")
    for side, y in (("left", 0.2), ("right", -0.2))
)
ROVER = f"<robot name='rover'><link name='base'/>{WHEELS}</robot>"
WHEEL_STATES = "wheel_joint_controller_state"
LIMITS = {"has_acceleration_limits": True, "max_acceleration": 1.0, "has_velocity_limits": True, "max_velocity": 0.5}
BASE = {
    "type": "diff_drive_controller/DiffDriveController",
    "left_wheel": "left",
    "right_wheel": ["right"],
    "linear": {"x": LIMITS},
    "publish_cmd": True,
    "publish_wheel_joint_controller_state": True,
    "allow_multiple_cmd_vel_publishers": False,
    "pose_covariance_diagonal": [0.1] * 6,
    "twist_covariance_diagonal": [0.2] * 6,
}


def test_a_diff_drive_controller_drives_with_the_sizes_of_the_description(master, start, caplog):
    master.parameters |= {"/arm/base": BASE, "/robot_description": ROVER}
    plugin = "<plugin name='control' filename='libgazebo_ros_control.so'><robotNamespace>/arm</robotNamespace>"
    world = wagon("").replace(
        "<plugin name='control' filename='libgazebo_ros2_control.so'><parameters></parameters>", plugin
    )
    core, _ = start(world)
    rover = Arm(master, core, "wagon")
    assert rover.load("base")
    sockets = {topic: rover.read(f"/arm/base/{topic}") for topic in ("odom", "cmd_vel_out", WHEEL_STATES)}
    transforms = rover.read("/tf")
    command = message_type("geometry_msgs/Twist")()
    command.linear.x, command.angular.z = 2.0, 0.5
    talker = rover.send("/arm/base/cmd_vel", command)
    speeds, begin = [], core.GetSimTime()
    while core.GetSimTime() < begin + 1.5:
        talker.send(codec(command.kind).pack(command))
        core.Step()
        speeds.append(sockets["cmd_vel_out"]("geometry_msgs/TwistStamped").twist.linear.x)
    assert all(after - before < 0.1 for before, after in pairwise(speeds))
    assert speeds[-1] == pytest.approx(0.5)
    found, pose = None, rover.model.WorldPose()
    while found is None or found.header.stamp.seconds < core.GetSimTime() - 0.03:
        found = sockets["odom"]("nav_msgs/Odometry")
    assert found.twist.twist.linear.x == pytest.approx(0.5, abs=0.03)
    assert found.twist.twist.angular.z == pytest.approx(0.5, abs=0.05)
    at = found.pose.pose.position
    assert (at.x, at.y) == (pytest.approx(pose.Pos().X(), abs=0.03), pytest.approx(pose.Pos().Y(), abs=0.03))
    assert (found.header.frame_id, found.child_frame_id) == ("odom", "base_link")
    assert (found.pose.covariance[7], found.twist.covariance[7]) == (0.1, 0.2)
    assert transforms("tf2_msgs/TFMessage").transforms[0].child_frame_id == "base_link"
    wheels = sockets[WHEEL_STATES]("control_msgs/JointTrajectoryControllerState")
    while wheels.header.stamp.seconds < begin + 1.4:
        wheels = sockets[WHEEL_STATES]("control_msgs/JointTrajectoryControllerState")
    assert wheels.joint_names == ["left", "right"]
    assert wheels.desired.velocities == pytest.approx([4.0, 6.0])
    assert wheels.actual.velocities == pytest.approx([4.0, 6.0], abs=0.3)
    assert wheels.error.positions == pytest.approx(wheels.desired.positions - wheels.actual.positions)
    talker.close()
    wait_for(lambda: abs(rover.model.WorldLinearVel().X()) < 0.01, core.Step)  # commands are too old
    rivals = [Talker(master, "/arm/base/cmd_vel", command.kind.name, command.kind.md5, name) for name in "ab"]
    rivals[0].send(codec(command.kind).pack(command))
    wait_for(lambda: "topic /arm/base/cmd_vel: 2 nodes publish commands; one may" in caplog.text, core.Step)
    assert abs(rover.model.WorldLinearVel().X()) < 0.01
    for rival in rivals:
        rival.close()


def test_limits_without_a_maximum_stop_a_diff_drive_controller_of_ros_1(caplog):
    limiter = Limiter({"has_velocity_limits": True}, "/base/linear/x", 0.0)
    assert limiter.limit(1.0, 0.1) == 0.0
    assert "controller /base/linear/x: has_velocity_limits without max_velocity; it is taken as 0" in caplog.text
    turned = {"has_acceleration_limits": True, "max_acceleration": 1.0, "min_acceleration": 2.0}
    assert Limiter(turned, "/base/linear/x", 0.0).limit(5.0, 0.1) == pytest.approx(0.1)
    assert "are 2 and 1: no limits; the maximum is taken" in caplog.text
    for values in (
        {"max_velocity": math.nan},
        {"max_velocity": -math.inf},
        {"max_velocity": 1, "min_velocity": math.nan},
    ):
        with pytest.raises(ParameterError, match=r"/base/min_velocity and max_velocity are .*: no limits"):
            Limiter({"has_velocity_limits": True} | values, "/base", 0.0)
