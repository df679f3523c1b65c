"""ros2_control beside its controllers: nodes, remappings, parameters, gains, joints that follow or stand."""

import pytest
from ros2_robots import ARM, CONTROL, ROBOT
from ros_peers import wait_for

from libgz.classic.server import attach
from libgz.ros.types import message_type

PLUGIN = "<plugin name='control' filename='libgazebo_ros2_control.so'>"
HEAVY = (
    ARM.replace("<gravity>0 0 0</gravity>", "")
    .replace("0 0 1</xyz>", "0 1 0</xyz>")
    .replace("<mass>1</mass>", "<pose>1 0 0 0 0 0</pose><mass>1</mass>")
)


@pytest.fixture
def arm(start_ros2, graph, tmp_path):
    """Starts an arm; the server."""

    def arm(world=ARM, robot=ROBOT, control=CONTROL, described=True, inside=""):
        (tmp_path / "arm.yaml").write_text(control)
        text = world.replace(PLUGIN, PLUGIN + inside).format(file=tmp_path / "arm.yaml")
        server = start_ros2(text)
        server.joint = attach(server.core).world.ModelByName("arm").GetJoint("elbow")
        wait_for(lambda: "/robot_description" in graph.taken, server.core.Step)
        if described:
            server.send("/robot_description", "std_msgs/String", data=robot)
            wait_for(lambda: "/controller_manager/load_controller" in graph.declared, server.core.Step)
        return server

    return arm


def do(server, service, kind, **values):
    return server.call(f"/controller_manager/{service}", f"controller_manager_msgs/{kind}", **values)


def begin(server, *names):
    for name in names:
        assert do(server, "load_controller", "LoadController", name=name).ok
        assert do(server, "configure_controller", "ConfigureController", name=name).ok
    return do(server, "switch_controller", "SwitchController", activate_controllers=list(names), strictness=2).ok


def test_managers_and_controllers_are_nodes_with_the_remappings_of_the_plugin(arm, graph):
    rules = "<ros><remapping>~/commands:=wanted</remapping><remapping>/joint_states:=/all</remapping></ros>"
    server = arm(inside=rules)
    assert begin(server, "mover", "states")
    assert graph.declared["/controller_manager/load_controller"]["node"] == ["/", "controller_manager"]
    assert wait_for(lambda: graph.taken.get("/wanted"), server.core.Step)["node"] == ["/", "mover"]
    assert graph.declared["/all"]["node"] == ["/", "states"]
    assert "/mover/list_parameters" in graph.declared


def set_parameter(server, node, name, **value):
    value = message_type("rcl_interfaces/ParameterValue", 2)(**value)
    one = message_type("rcl_interfaces/Parameter", 2)(name=name, value=value)
    (result,) = server.call(f"{node}/set_parameters", "rcl_interfaces/SetParameters", parameters=[one]).results
    assert result.successful


def test_types_and_parameters_of_controllers_are_set_by_their_nodes_parameters(arm, graph):
    server = arm()
    kind = "forward_command_controller/ForwardCommandController"
    with pytest.raises(AssertionError):  # nothing could be loaded any more
        set_parameter(server, "/controller_manager", "x" + ".y" * 100, type=1)
    set_parameter(server, "/controller_manager", "new.type", type=4, string_value=kind)
    assert do(server, "load_controller", "LoadController", name="new").ok
    assert not do(server, "configure_controller", "ConfigureController", name="new").ok
    set_parameter(server, "/new", "joints", type=9, string_array_value=["elbow"])
    set_parameter(server, "/new", "interface_name", type=4, string_value="velocity")
    assert do(server, "configure_controller", "ConfigureController", name="new").ok
    assert do(server, "unload_controller", "UnloadController", name="new").ok
    wait_for(lambda: "/new/list_parameters" not in graph.declared, server.core.Step)


def test_trajectories_without_interfaces_are_positions(arm, caplog):
    server = arm(control=CONTROL.replace("command_interfaces: [position], ", ""))
    assert begin(server, "follower")
    listed = do(server, "list_controllers", "ListControllers").controller
    assert [one.claimed_interfaces for one in listed] == [["elbow/position"]]
    assert "'command_interfaces' parameter is empty" in caplog.text


def test_hardware_components_are_listed_and_libraries_reloaded(arm):
    server = arm()
    (found,) = do(server, "list_hardware_components", "ListHardwareComponents").component
    assert (found.name, found.state.label) == ("sim", "active")
    assert [one.name for one in found.command_interfaces] == ["elbow/position", "elbow/velocity"]
    assert begin(server, "mover")
    assert do(server, "reload_controller_libraries", "ReloadControllerLibraries", force_kill=True).ok
    assert do(server, "list_controllers", "ListControllers").controller == []


@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize("described", [True, False])
def test_joints_that_nothing_commands_stand(arm, held, described):
    server = arm(HEAVY, described=described, inside=f"<hold_joints>{str(held).lower()}</hold_joints>")
    before = server.joint.Position(0)
    server.core.step(500)
    assert abs(server.joint.Position(0) - before) < 0.02 if held else abs(server.joint.Position(0) - before) > 0.2


GAINS = ROBOT.replace("<command_interface name='position'/>", "{inside}<command_interface name='position_pid'/>")
INSIDE = "".join(f"<param name='pos_{key}'>{value}</param>" for key, value in {"kp": 50, "ki": 0, "kd": 10}.items())
BY_FILE = "\ncontrol: {ros__parameters: {pid_gains: {position_pid: {elbow: {kp: 50.0, ki: 0.0, kd: 10.0}}}}}\n"


@pytest.mark.parametrize(("inside", "more"), [(INSIDE, ""), ("", BY_FILE)])
def test_positions_are_held_by_gains(arm, inside, more):
    control = CONTROL.replace("interface_name: velocity", "interface_name: position") + more
    server = arm(robot=GAINS.format(inside=inside), control=control)
    assert begin(server, "mover")
    server.send("/mover/commands", "std_msgs/Float64MultiArray", data=[0.5])
    wait_for(lambda: server.joint.Position(0) > 0.05, server.core.Step)
    assert server.joint.Position(0) < 0.2  # not at once
    server.core.step(3000)
    assert server.joint.Position(0) == pytest.approx(0.5, abs=0.01)


def test_joints_follow_others_and_missing_ones_are_skipped(arm, caplog):
    second = """<link name='other'><inertial><mass>1</mass></inertial></link><joint name='finger' type='revolute'>
      <parent>base</parent><child>other</child><axis><xyz>0 0 1</xyz></axis></joint>"""
    more = """<joint name='finger'><param name='mimic'>elbow</param><param name='multiplier'>-0.5</param></joint>
      <joint name='nowhere'><command_interface name='position'/></joint></ros2_control>"""
    robot = ROBOT.replace("</ros2_control>", more)
    control = CONTROL.replace("interface_name: velocity", "interface_name: position")
    server = arm(ARM.replace("<joint name='elbow'", f"{second}<joint name='elbow'"), robot, control)
    assert begin(server, "mover")
    server.send("/mover/commands", "std_msgs/Float64MultiArray", data=[0.5])
    wait_for(lambda: server.joint.Position(0) > 0.49, server.core.Step)
    finger = attach(server.core).world.ModelByName("arm").GetJoint("finger")
    assert finger.Position(0) == pytest.approx(-0.25, abs=0.01)
    assert "Skipping joint in the URDF named 'nowhere'" in caplog.text


def test_of_those_that_command_the_same_joints_the_first_starts_by_itself(start_ros2, graph, tmp_path):
    graph.refused.add("controller_manager_msgs")
    (tmp_path / "arm.yaml").write_text(CONTROL)
    server = start_ros2(ARM.format(file=tmp_path / "arm.yaml"))
    wait_for(lambda: "/robot_description" in graph.taken, server.core.Step)
    server.send("/robot_description", "std_msgs/String", data=ROBOT)
    assert server.topic("/joint_states").name == ["elbow"]
    server.send("/mover/commands", "std_msgs/Float64MultiArray", data=[0.5])
    joint = attach(server.core).world.ModelByName("arm").GetJoint("elbow")
    wait_for(lambda: joint.GetVelocity(0) > 0.4, server.core.Step)


@pytest.mark.parametrize(
    ("robot", "why"),
    [
        (GAINS.format(inside="<param name='pos_kp'>much</param>"), "kp of position_pid of joint 'elbow' is 'much'"),
        (ROBOT.replace("</joint></ros2", "<param name='mimic'>thumb</param></joint></ros2"), "mimics 'thumb'"),
    ],
)
def test_wrong_descriptions_are_refused(arm, caplog, robot, why):
    server = arm(described=False)
    server.send("/robot_description", "std_msgs/String", data=robot)
    wait_for(lambda: why in caplog.text, server.core.Step)
