"""Parameters of the nodes of ROS 2: of the server and of plugins; declared, given, listed, read and set."""

import logging
import math

import numpy as np
import pytest
from ros2_robots import wheeled
from ros_bridge import EMPTY, cdr, fields
from ros_peers import wait_for

from libgz.classic.server import attach
from libgz.ros import node_parameters
from libgz.ros.node_parameters import NodeParameters
from libgz.ros.own_node import OwnNode
from libgz.ros.types import message_type

VALUE, PARAMETER = (message_type(f"rcl_interfaces/{name}", 2) for name in ("ParameterValue", "Parameter"))
TYPES = {bool: "bool", int: "integer", float: "double", str: "string"}
SLIP = "slip_compliance_unitless_lateral"


def parameter(name, value):
    (kind,) = (kind for kind, (_, text) in node_parameters.TYPES.items() if text == TYPES[type(value)])
    return PARAMETER(name=name, value=VALUE(**{"type": kind, f"{TYPES[type(value)]}_value": value}))


class Node:
    """Asks for the parameters of a node."""

    def __init__(self, server, name):
        self.server, self.name = server, name

    def ask(self, service, kind, **values):
        return self.server.call(f"{self.name}/{service}", f"rcl_interfaces/{kind}", **values)

    def names(self, *prefixes, depth=0):
        return self.ask("list_parameters", "ListParameters", prefixes=list(prefixes), depth=depth).result.names

    def get(self, *names):
        values = self.ask("get_parameters", "GetParameters", names=list(names)).values
        return [getattr(one, node_parameters.TYPES[one.type][0]) if one.type else None for one in values]

    def set(self, name, value):
        return self.ask("set_parameters", "SetParameters", parameters=[parameter(name, value)]).results[0].reason


def test_the_server_has_those_of_the_original_and_takes_others(start_ros2):
    node = Node(start_ros2(EMPTY, "--ros-args", "-p", "publish_rate:=20.0"), "/gazebo")
    assert node.names() == ["enable_performance_metrics", "publish_rate", "use_sim_time"]
    assert node.get("publish_rate", "use_sim_time", "none") == [20.0, True, None]
    assert node.set("robot.name", "x") == ""
    assert node.get("robot.name") == ["x"]
    assert node.names("robot") == ["robot.name"]
    assert "robot.name" not in node.names(depth=1)
    found = node.ask("list_parameters", "ListParameters", prefixes=["robot"], depth=1).result
    assert (found.names, found.prefixes) == (["robot.name"], ["robot"])
    assert "of type {double}, setting it to {string} is not allowed" in node.set("publish_rate", "fast")
    described = node.ask("describe_parameters", "DescribeParameters", names=["publish_rate"]).descriptors[0]
    assert (described.name, described.type, described.dynamic_typing) == ("publish_rate", 3, False)
    types = node.ask("get_parameter_types", "GetParameterTypes", names=["publish_rate", "robot.name"]).types
    assert list(types) == [3, 4]


def test_performance_metrics_are_switched(start_ros2, graph):
    server = start_ros2(EMPTY, "--ros-args", "-p", "enable_performance_metrics:=false")
    node = Node(server, "/gazebo")
    graph.listen("/performance_metrics")
    server.core.step(500)
    assert node.get("enable_performance_metrics") == [False]
    assert not graph.received["/performance_metrics"]
    assert node.set("enable_performance_metrics", True) == ""
    wait_for(lambda: graph.received["/performance_metrics"], server.core.Step)


def test_all_of_some_are_set_or_none(start_ros2, graph):
    server = start_ros2()
    node = Node(server, "/gazebo")
    server.topic("/clock")
    graph.listen("/parameter_events")
    wait_for(lambda: server.ros.parameter_events.listened, server.core.Step)
    both = [parameter("a", 1), parameter("publish_rate", 7)]
    asked = node.ask("set_parameters_atomically", "SetParametersAtomically", parameters=both).result
    assert not asked.successful
    assert "a" not in node.names()
    both[1] = parameter("publish_rate", 7.0)
    assert node.ask("set_parameters_atomically", "SetParametersAtomically", parameters=both).result.successful
    assert node.get("a", "publish_rate") == [1, 7.0]
    kind = message_type("rcl_interfaces/ParameterEvent", 2)
    (body,) = wait_for(lambda: graph.received["/parameter_events"], server.core.Step)
    event = cdr(kind, fields(kind.name, "msg")[0]).unpack(body)
    assert event.node == "/gazebo"
    assert [[one.name for one in part] for part in (event.new_parameters, event.changed_parameters)] == [
        ["a"],
        ["publish_rate"],
    ]
    assert node.set("use_sim_time", False) == ""
    graph.received["/parameter_events"].clear()
    node.ask("set_parameters", "SetParameters", parameters=[PARAMETER(name="a")])  # without a value
    assert "a" not in node.names()
    (body,) = wait_for(lambda: graph.received["/parameter_events"], server.core.Step)
    assert [one.name for one in cdr(kind, fields(kind.name, "msg")[0]).unpack(body).deleted_parameters] == ["a"]


def moving(inside):
    """A model with a plugin of this content."""
    plugin = f"<plugin name='move' filename='libgazebo_ros_planar_move.so'>{inside}</plugin>"
    return f"<sdf version='1.6'><world name='w'><model name='m'><link name='l'/>{plugin}</model></world></sdf>"


@pytest.mark.parametrize(("inside", "space"), [("", "/fleet"), ("<ros><namespace>/own</namespace></ros>", "/own")])
def test_command_lines_name_the_nodes_of_plugins(start_ros2, inside, space):
    server = start_ros2(moving(inside), "--ros-args", "-r", "move:__ns:=/fleet", "-r", "move:__node:=mover")
    assert Node(server, f"{space}/mover").names() == ["use_sim_time"]


def test_parameters_of_plugins_are_given_by_elements_and_command_lines(start_ros2, caplog):
    world = moving("""<ros><namespace>/bot</namespace><parameter name='use_sim_time' type='bool'>false</parameter>
      <parameter name='bad' type='list'>1</parameter></ros>""")
    caplog.set_level(logging.WARNING)
    node = Node(start_ros2(world), "/bot/move")
    assert node.names() == ["use_sim_time"]
    assert node.get("use_sim_time") == [False]
    assert node.get("nothing", "use_sim_time") == []  # as rclcpp answers
    assert node.set("nothing", 1) == "parameter 'nothing' cannot be set because it was not declared"
    assert "<parameter> needs a name and a type" in caplog.text


@pytest.mark.parametrize("triggered", [False, True])
def test_the_rate_of_a_camera_is_changed(start_ros2, triggered):
    world = f"""<sdf version='1.6'><world name='w'><model name='m'><static>true</static><link name='l'>
      <sensor name='eye' type='camera'><update_rate>30</update_rate><camera><image><width>8</width><height>8</height>
      </image></camera><plugin name='eye_driver' filename='libgazebo_ros_camera.so'>
      <triggered>{str(triggered).lower()}</triggered></plugin></sensor></link></model></world></sdf>"""
    server = start_ros2(world, "--ros-args", "-p", "eye_driver:update_rate:=25.0")
    node = Node(server, "/eye_driver")
    (sensor,) = attach(server.core).sensors.sensors.values()
    assert node.get("update_rate") == [25.0]
    assert sensor.UpdateRate() == pytest.approx(25.0)
    if triggered:
        assert node.set("update_rate", 5.0) == "Cannot set update rate for triggered camera"
    else:
        assert "must be finite" in node.set("update_rate", math.nan)
        assert node.set("update_rate", 5.0) == ""
    assert sensor.UpdateRate() == pytest.approx(25.0 if triggered else 5.0)


def slipping(start_ros2, *words):
    wheels = "".join(
        f"<wheel link_name='{name}_wheel'><slip_compliance_lateral>{value}</slip_compliance_lateral>"
        "<wheel_normal_force>10</wheel_normal_force></wheel>"
        for name, value in (("a", 0.25), ("b", 0.5))
    )
    slip = f"<plugin name='slip' filename='libgazebo_ros_wheel_slip.so'>{wheels}</plugin>"
    model = wheeled("robot", {"a": "0 0.2", "b": "0 -0.2"}, f"<pose>0 0 50 0 0 0</pose>{slip}")
    server = start_ros2(f"<sdf version='1.6'><world name='w'>{model}</world></sdf>", *words)
    return Node(server, "/slip"), server


def test_slips_of_wheels_are_changed(start_ros2):
    node, _ = slipping(start_ros2)
    names = [f"{SLIP}/a_wheel", f"{SLIP}/b_wheel"]
    assert node.get(*names, SLIP) == [0.25, 0.5, None]
    assert node.set(names[0], 0.125) == ""
    assert node.get(*names) == [0.125, 0.5]
    assert node.set(SLIP, -1.0) == "Slip compliance values cannot be negative"
    assert node.set(SLIP, 2.0) == ""
    assert node.get(*names, SLIP) == [2.0, 2.0, 2.0]
    assert node.set(SLIP, math.nan) != ""
    assert node.set(SLIP, math.inf) == ""  # no friction
    assert node.get(*names) == [math.inf, math.inf]


def test_slips_of_wheels_are_given(start_ros2):
    node, _ = slipping(start_ros2, "--ros-args", "-p", f"{SLIP}:=3.0", "-p", f"slip:{SLIP}/b_wheel:=1")
    assert node.get(f"{SLIP}/a_wheel", f"{SLIP}/b_wheel") == [3.0, 1.0]


def test_slips_are_those_of_the_formulas(start_ros2):
    """The angle between where a wheel goes and where it points, and (rim - ahead) / rim."""
    _, server = slipping(start_ros2)
    robot = attach(server.core).world.ModelByName("robot")
    robot.SetLinearVel((0.3, 0.1, 0.0))
    robot.GetJoint("a").SetVelocity(0, 8.0)
    server.topic("/wheel_slip")
    found = server.topic("/wheel_slip")
    link, joint = robot.GetLink("a_wheel"), robot.GetJoint("a")
    rim = 0.1 * joint.GetVelocity(0)
    velocity = robot.WorldPose().Rot().RotateVectorReverse(link.WorldLinearVel())
    ahead, aside = np.sign(rim) * abs(velocity.X()), velocity.Y()
    assert found.longitudinal_slip[0] == pytest.approx((rim - ahead) / rim, abs=0.02)
    assert abs(math.tan(found.lateral_slip[0])) == pytest.approx(abs(aside / ahead), rel=0.05)


def test_what_is_set_is_bounded(start_ros2, monkeypatch):
    monkeypatch.setattr(node_parameters, "MOST_PARAMETERS", 10)
    monkeypatch.setattr(node_parameters, "MOST_SIZE", 5000)
    monkeypatch.setattr(node_parameters, "MOST_ASKED", 10_000)
    node = Node(start_ros2(), "/gazebo")
    assert "at most 10 parameters with 5000 bytes" in node.set("large", "x" * 5000)
    for number in range(7):
        assert node.set(f"p{number}", "x" * 500) == ""
    assert "at most 10 parameters" in node.set("more", 1)
    monkeypatch.setattr(node_parameters, "MOST_ASKED", 5000)
    assert node.get(*["p0"] * 10) == []
    many = PARAMETER(name="p0", value=VALUE(type=1))
    for service, values in {
        "get_parameters": {"names": ["p0"] * 11},
        "list_parameters": {"prefixes": ["p"] * 11},
        "set_parameters": {"parameters": [many] * 11},
    }.items():
        with pytest.raises(AssertionError, match="in one request; at most 10"):
            node.ask(service, service.title().replace("_", ""), **values)
    unknown = PARAMETER(name="p0", value=VALUE(type=77))
    result = node.ask("set_parameters", "SetParameters", parameters=[unknown]).results[0]
    assert result.successful
    assert node.get("p0") == [None]


def test_the_sizes_of_all_parameters_are_not_summed_for_each(start_ros2, monkeypatch):
    node = Node(start_ros2(), "/gazebo")
    many = [parameter(f"p{number}", "x") for number in range(990)]
    node.ask("set_parameters", "SetParameters", parameters=many)
    measured, of_one = [], node_parameters._size
    monkeypatch.setattr(node_parameters, "_size", lambda value: measured.append(value) or of_one(value))
    results = node.ask("set_parameters", "SetParameters", parameters=many).results
    assert all(one.successful for one in results)
    assert len(measured) <= 5 * len(many)


class LookedUp(frozenset):
    """Is not gone through for each name."""

    def __iter__(self):
        raise AssertionError


@pytest.mark.parametrize(
    ("name", "prefixes", "depth", "listed"),
    [
        ("a", [], 0, True), ("a", [], 1, True), ("a.b", [], 1, False), ("a.b", ["a"], 1, True), ("a", ["a"], 1, True),
        ("a.b.c", ["a"], 1, False), ("a.b.c", ["a"], 0, True), ("a.b.c", ["a.b", "x"], 1, True),
        ("ab", ["a"], 0, False),
        ("a.b", ["a."], 0, False), (".a", [""], 0, True), ("a", [""], 0, False), ("a.b.c", ["a", "a.b.c"], 1, True),
    ],
)  # fmt: skip
def test_names_below_prefixes_are_listed(name, prefixes, depth, listed):
    assert node_parameters._listed(name, LookedUp(prefixes), depth) is listed


def test_what_was_deleted_leaves_room(start_ros2, monkeypatch):
    monkeypatch.setattr(node_parameters, "MOST_SIZE", 5000)
    node = Node(start_ros2(), "/gazebo")
    without = PARAMETER(name="large", value=VALUE())
    for _ in range(3):
        assert node.set("large", "x" * 4000) == ""
        assert "at most 1000 parameters with 5000 bytes" in node.set("other", "x" * 4000)
        for _ in range(2):  # the second time there is nothing to delete
            assert node.ask("set_parameters", "SetParameters", parameters=[without]).results[0].successful
    assert node.get("large") == [None]


def test_arrays_do_not_keep_requests_alive(start_ros2):
    server = start_ros2()
    array = PARAMETER(name="a", value=VALUE(type=8, double_array_value=[1.0, 2.0], string_value="x" * 1000))
    node = Node(server, "/gazebo")
    node.ask("set_parameters", "SetParameters", parameters=[array])
    (value,) = node.ask("get_parameters", "GetParameters", names=["a"]).values
    assert (value.string_value, list(value.double_array_value)) == ("", [1.0, 2.0])


def test_a_second_node_of_a_name_has_parameters_of_its_own(start_ros2):
    server = start_ros2()
    node = OwnNode(server.ros.names, "/", "gazebo", given={"a": 2, "b": [1, 2.5], "c": {"d": True}})
    own = NodeParameters(server.ros, node)
    assert [own.declare("a", 1.0), own.declare("c.d", False), own.declare("b", 1)] == [2.0, True, 1]
    assert Node(server, "/gazebo").get("a") == [None]


def test_integers_that_no_parameter_can_have_are_not_taken(start_ros2):
    server = start_ros2()
    given = {"fits": (1 << 63) - 1, "large": 1 << 63, "list": [1, -(1 << 70)]}
    own = NodeParameters(server.ros, OwnNode(server.ros.names, "/", "numbers", given=given))
    own.take_given()
    assert own.values() == {"use_sim_time": True, "fits": (1 << 63) - 1}
    assert Node(server, "/numbers").get("fits") == [(1 << 63) - 1]
