"""A node of ROS 2 for the trial: it runs in the Python that TEST_ROS2 names, and answers lines of JSON on its input."""

import importlib
import json
import sys
import time

import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from trajectory_msgs.msg import JointTrajectoryPoint

PATIENCE = 30.0  # [s]


def find(name):
    package, sort, base = name.split("/")
    return getattr(importlib.import_module(f"{package}.{sort}"), base)


def plain(value):
    """A message as what JSON can carry: its fields, and the lengths of long lists."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, (bytes, str, bool, int, float)) or value is None:
        return value.decode("latin-1") if isinstance(value, bytes) else value
    values = list(value)
    return [plain(one) for one in values] if len(values) < 100 else {"count": len(values)}


def fill(message, values):
    for name, value in values.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            setattr(message, name, value)
    return message


class Tester:
    def __init__(self):
        self.node = rclpy.create_node("tester")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.heard, self.subscriptions = {}, {}

    def spin(self, condition, patience=PATIENCE):
        end = time.monotonic() + patience
        while not condition() and time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)
        return bool(condition())

    def listen(self, topic, kind, depth=10, best_effort=False, latched=False):
        quality = QoSProfile(depth=depth)
        quality.reliability = ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE
        quality.durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        self.heard[topic] = []
        heard = self.heard[topic]
        self.subscriptions[topic] = self.node.create_subscription(
            find(kind), topic, lambda message: heard.append((time.monotonic(), message)), quality
        )

    def first(self, topic, kind, patience=PATIENCE, **quality):
        """The first message of a topic, and then no more."""
        self.listen(topic, kind, **quality)
        self.spin(lambda: self.heard[topic], patience)
        self.node.destroy_subscription(self.subscriptions.pop(topic))
        return plain(self.heard[topic][0][1]) if self.heard[topic] else None

    def count(self, topic, wanted=None, patience=PATIENCE):
        """(how many messages came, the first and last of their times by the clock of the computer)."""
        self.spin(lambda: wanted is not None and len(self.heard[topic]) >= wanted, patience)
        times = [at for at, _ in self.heard[topic]]
        return [len(times), times[0] if times else 0.0, times[-1] if times else 0.0]

    def stamps(self, topic):
        """The times in the headers of messages [ns]."""
        stamps = (one.header.stamp for _, one in self.heard[topic])
        return [one.sec * 1_000_000_000 + one.nanosec for one in stamps]

    def clear(self, topic):
        self.heard[topic].clear()

    def publish(self, topic, kind, values, times=20, latched=False):
        quality = QoSProfile(depth=10)
        quality.durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        publisher = self.node.create_publisher(find(kind), topic, quality)
        found = self.spin(lambda: publisher.get_subscription_count() > 0)
        for _ in range(times if found else 0):
            publisher.publish(fill(find(kind)(), values))
            self.spin(lambda: False, 0.02)
        return found

    def call(self, service, kind, values):
        client = self.node.create_client(find(kind), service)
        if not client.wait_for_service(timeout_sec=PATIENCE):
            return None
        future = client.call_async(fill(find(kind).Request(), values))
        self.spin(future.done)
        return plain(future.result()) if future.done() else None

    def set_parameter(self, owner, name, value):
        """Set a parameter of a node: why it refuses, or nothing; and the value that it has then."""
        client = AsyncParameterClient(self.node, owner)
        if not client.wait_for_services(timeout_sec=PATIENCE):
            return None
        asked = client.set_parameters([Parameter(name, value=value)])
        self.spin(asked.done)
        got = client.get_parameters([name])
        self.spin(got.done)
        found = [parameter_value_to_python(one) for one in got.result().values]
        return [asked.result().results[0].reason, found]

    def follow(self, action, joints, positions, seconds, cancel=False):
        """Send a trajectory of one point to an action: whether it was accepted, its status, code, and feedback."""
        kind = find("control_msgs/action/FollowJointTrajectory")
        client = ActionClient(self.node, kind, action)
        if not self.spin(client.server_is_ready):
            return None
        goal = kind.Goal()
        goal.trajectory.joint_names = joints
        point = JointTrajectoryPoint(positions=positions)
        point.time_from_start.sec, point.time_from_start.nanosec = int(seconds), round(seconds % 1 * 1e9)
        goal.trajectory.points = [point]
        feedback = []
        sent = client.send_goal_async(goal, feedback_callback=feedback.append)
        self.spin(sent.done)
        handle = sent.result()
        if not handle.accepted:
            return [False, 0, 0, 0]
        if cancel:
            asked = handle.cancel_goal_async()
            self.spin(asked.done)
        result = handle.get_result_async()
        self.spin(result.done)
        found = result.result()
        return [True, found.status, found.result.error_code, len(feedback)]

    def grip(self, action, position):
        """Send a goal to the action of a gripper: whether it was accepted, its status, and the position it came to."""
        kind = find("control_msgs/action/GripperCommand")
        client = ActionClient(self.node, kind, action)
        if not self.spin(client.server_is_ready):
            return None
        goal = kind.Goal()
        goal.command.position = position
        sent = client.send_goal_async(goal)
        self.spin(sent.done)
        if not sent.result().accepted:
            return [False, 0, 0.0]
        result = sent.result().get_result_async()
        self.spin(result.done)
        found = result.result()
        return [True, found.status, found.result.position]

    def graph(self):
        """Nodes, topics and services."""
        self.spin(lambda: False, 1.0)
        node = self.node
        names = [f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces()]
        return [names, dict(node.get_topic_names_and_types()), dict(node.get_service_names_and_types())]


if __name__ == "__main__":
    rclpy.init()
    tester = Tester()
    for line in sys.stdin:
        method, values = json.loads(line)
        answer = getattr(tester, method)(**values)
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()
