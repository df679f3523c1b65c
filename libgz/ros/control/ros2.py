"""ros2_control: the robot's joints, controllers and controller manager as ROS 2 has them."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from libgz.base.errors import Diagnostics, GazeboError, ParameterError, nearest
from libgz.ros.control.controllers import Controller, Gripper, GroupCommands, JointStates, JointTrajectories
from libgz.ros.control.drive import DiffDrive2
from libgz.ros.control.hardware import EFFORT, POSITION, SHORT_NAMES, VELOCITY, RobotHardware, SimJoint
from libgz.ros.control.manager import ControllerManager
from libgz.ros.control.pid import RosPid
from libgz.ros.node_parameters import NodeParameters
from libgz.ros.own_node import OwnNode
from libgz.ros.parameters import Parameters, tables
from libgz.ros.session import NodeSession, Session, set_stamp
from libgz.ros.types import message_type
from libgz.sdf.xml import parse_document

if TYPE_CHECKING:
    from libgz.classic.physics import Model

__all__ = ["SERVICES", "ControllerManager2", "RobotHardware2"]

log = logging.getLogger("libgz.ros")

SERVICES = {
    "configure_controller": "ConfigureController",
    "list_controller_types": "ListControllerTypes",
    "list_controllers": "ListControllers",
    "list_hardware_components": "ListHardwareComponents",
    "list_hardware_interfaces": "ListHardwareInterfaces",
    "load_controller": "LoadController",
    "reload_controller_libraries": "ReloadControllerLibraries",
    "switch_controller": "SwitchController",
    "unload_controller": "UnloadController",
}
# Interfaces -> prefix of their gains in descriptions; gains, as RosPid has them -> their names.
PREFIXES = {"position": "pos_", "velocity": "vel_"}
GAINS = {"p": "kp", "i": "ki", "d": "kd", "i_clamp_max": "max_integral_error", "i_clamp_min": "min_integral_error"}
STATES = {"initialized": "inactive", "stopped": "inactive", "running": "active"}
MOST_CONTROLLERS = 100
ACTIVE = 3  # of lifecycle_msgs/State
STRONGEST = 1e6  # of a motor without a limit [N m]


class RobotHardware2(RobotHardware):
    """The joints of the `<ros2_control>` elements of a robot description.

    Args:
        model: the model.
        description: the text of its URDF.
        gains: of the interfaces position_pid and velocity_pid, by these, joints and their letters; those in the
            description come first.
        hold: whether joints that nothing commands stand, if something may command them.

    Attributes:
        systems: (name, plugin, joints) of each `<ros2_control>`.

    Raises:
        ParameterError: a number is none, or a joint mimics one that does not exist.
        WorldFileError: the text is no XML.
    """

    def __init__(
        self, model: Model, description: str, gains: Mapping[str, Any] | None = None, hold: bool = True
    ) -> None:
        diagnostics = Diagnostics()
        root = parse_document(description.encode(), "robot_description", diagnostics)
        diagnostics.raise_errors()
        self.description, self._hold = root, hold
        self._described = {one.get("name", ""): one for one in root.findall("joint")}
        self.joints: dict[str, SimJoint] = {}
        self.interfaces: dict[str, list[str]] = {}  # by which each joint may be commanded
        self.systems: list[tuple[str, str, list[str]]] = []
        self._claimed: dict[tuple[str, str], SimJoint] = {}
        self._pids: dict[tuple[str, str], RosPid] = {}
        self._mimics: list[tuple[str, str, float]] = []  # joint, the one that it follows, factor
        for system in root.iterfind("ros2_control"):
            added = [
                element.get("name", "") for element in system.findall("joint") if self._add(model, element, gains or {})
            ]
            plugin = system.findtext("hardware/plugin") or ""
            self.systems.append((system.get("name", ""), plugin.strip(), added))
        for name, leader, _ in self._mimics:
            if leader not in self.joints:
                raise ParameterError(f"joint {name!r} mimics {leader!r}, which <ros2_control> does not have")

    def _add(self, model: Model, element: Any, gains: Mapping[str, Any]) -> bool:
        """Add a joint; whether the model has it."""
        name = element.get("name", "")
        joint = model.GetJoint(name)
        if joint is None:
            log.warning("Skipping joint in the URDF named '%s' which is not in the gazebo model.", name)
            return False
        values = {one.get("name", ""): (one.text or "").strip() for one in element.findall("param")}
        self.interfaces[name] = []
        for given in (one.get("name", "") for one in element.findall("command_interface")):
            plain = given.removesuffix("_pid")
            if plain not in SHORT_NAMES:
                continue
            self.interfaces[name].append(SHORT_NAMES[plain])
            pid = _gains(values, PREFIXES.get(plain), gains, given, name)
            if pid is not None:
                self._pids[name, SHORT_NAMES[plain]] = pid
        begin = element.findtext("state_interface[@name='position']/param[@name='initial_value']")
        if begin is not None:
            joint.SetPosition(0, _finite(begin, "an initial value of <ros2_control>"))
        if "mimic" in values:
            factor = _finite(values.get("multiplier", "1"), f"the multiplier of joint {name!r}")
            self._mimics.append((name, values["mimic"], factor))
        self.joints[name] = SimJoint(joint, "", self._described.get(name), None)
        return True

    def claim(self, name: str, interface: str) -> SimJoint | None:
        """The joint of a name, for a controller that will command it by an interface; None if it does not have that."""
        if interface not in self.interfaces.get(name, ()):
            return None
        return self._by(name, interface)

    def _by(self, name: str, interface: str) -> SimJoint:
        """A joint as it is commanded by an interface."""
        key = name, interface
        if key not in self._claimed:
            present = self.joints[name]
            self._claimed[key] = SimJoint(present.joint, interface, self._described.get(name), self._pids.get(key))
            self.activate(present)  # nothing commands it yet
        return self._claimed[key]

    def activate(self, joint: SimJoint) -> None:
        """Let a joint be commanded by its interface, instead of the last one."""
        self.joints[joint.name] = joint
        most = joint.most_effort if math.isfinite(joint.most_effort) else STRONGEST
        motor = joint.interface == VELOCITY and (joint.name, VELOCITY) not in self._pids
        joint.joint.SetParam("fmax", 0, most if motor else 0.0)
        if joint.interface == POSITION:
            joint.joint.SetVelocity(0, 0.0)  # positions that are set keep the velocity

    def read(self) -> None:
        """Read the states of all joints."""
        for joint in (*self.joints.values(), *self._claimed.values()):
            joint.read()

    def write(self, elapsed: float) -> None:
        """Apply the commands of all joints; those that nothing commands may stand."""
        for name, leader, factor in self._mimics:
            lead = self.joints[leader]
            if lead.interface and self.joints[name].interface != lead.interface:
                self.activate(self._by(name, lead.interface))
            self.joints[name].command = None if lead.command is None else factor * lead.command
        for name, joint in self.joints.items():
            if joint.interface:
                joint.write(elapsed)
            elif self._hold and self.interfaces[name]:
                joint.joint.SetVelocity(0, 0.0)


def _gains(
    values: Mapping[str, str], prefix: str | None, gains: Mapping[str, Any], interface: str, joint: str
) -> RosPid | None:
    """The gains of a joint for an interface, in its description or else among parameters; None: it has none."""
    if prefix is None:
        return None
    found: dict[str, Any] = {key.removeprefix(prefix): text for key, text in values.items() if key.startswith(prefix)}
    given = found.keys() & {"kp", "ki", "kd"}
    if not given:
        part = gains.get(interface)
        part = part.get(joint) if isinstance(part, Mapping) else None
        if not isinstance(part, Mapping) or not {"kp", "ki", "kd"} <= part.keys():
            return None
        found = dict(part)
    where = f"{interface} of joint {joint!r}"
    numbers = {
        ours: _finite(str(found[theirs]), f"{theirs} of {where}") for ours, theirs in GAINS.items() if theirs in found
    }
    most = {"i_clamp_max": math.inf, "i_clamp_min": -math.inf}
    return RosPid({**most, **numbers, "antiwindup": str(found.get("antiwindup")) in ("true", "True")}, where)


def _finite(text: str, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ParameterError(f"{what} is {text!r}; it must be a number")
    return value


class JointStates2(JointStates):
    """Publishes the states of all joints, or of those that a parameter names, at each update."""

    def load(self) -> None:
        """Advertise."""
        self.values = {"publish_rate": 1e6, **self.values}
        known = list(self.hardware.joints)
        names = self.values.get("joints") or known
        unknown = [name for name in names if name not in known] if isinstance(names, list) else [names]
        if unknown:
            raise ParameterError(f"controller {self.name}: there is no joint {unknown[0]!r}")
        self._names: list[str] = names
        if self.values.get("use_local_topics", False):
            self.space = self.name
        super().load()
        kind = "control_msgs/DynamicJointState"
        self._all = self.session.publish(f"{self.space}/dynamic_joint_states", kind, 10)
        self._value = message_type("control_msgs/InterfaceValue", 2)

    @property
    def reported(self) -> list[SimJoint]:
        """The joints whose states are published."""
        return [self.hardware.joints[name] for name in self._names]

    def update(self, elapsed: float) -> None:
        """Publish."""
        super().update(elapsed)
        if self._all.listened:
            message = self._all.kind(joint_names=self._names)
            set_stamp(message.header.stamp, self.now())
            message.interface_values = [
                self._value(interface_names=list(SHORT_NAMES), values=[one.position, one.velocity, one.effort])
                for one in self.reported
            ]
            self._all.publish(message)


class ForwardCommands(GroupCommands):
    """Passes on commands of several joints to the interface that a parameter names."""

    def load(self) -> None:
        """Find the interface and the joints, and subscribe."""
        self.interface = _interface(self, self.values.get("interface_name"))
        super().load()


class JointTrajectories2(JointTrajectories):
    """Follows trajectories by the first interface that a parameter names, or else by positions."""

    def load(self) -> None:
        """Find the joints, subscribe and serve."""
        names = self.values.get("command_interfaces")
        if not names:
            log.warning("controller %s: 'command_interfaces' parameter is empty; it commands positions", self.name)
            names = ["position"]  # as the first releases of Foxy do; later ones refuse it
        self.interface = _interface(self, names[0] if isinstance(names, list) else names)
        super().load()


def _interface(controller: Controller, name: Any) -> str:
    if not isinstance(name, str) or name not in SHORT_NAMES:
        raise ParameterError(
            f"controller {controller.name}: its interface is {name!r}; it must be one of {', '.join(SHORT_NAMES)}"
        )
    return SHORT_NAMES[name]


CONTROLLERS: dict[str, tuple[type[Controller], str]] = {
    "diff_drive_controller/DiffDriveController": (DiffDrive2, VELOCITY),
    "effort_controllers/GripperActionController": (Gripper, EFFORT),
    "effort_controllers/JointGroupEffortController": (GroupCommands, EFFORT),
    "forward_command_controller/ForwardCommandController": (ForwardCommands, ""),
    "joint_state_broadcaster/JointStateBroadcaster": (JointStates2, ""),
    "joint_state_controller/JointStateController": (JointStates2, ""),  # as Foxy has it
    "joint_trajectory_controller/JointTrajectoryController": (JointTrajectories2, ""),
    "position_controllers/GripperActionController": (Gripper, POSITION),
    "position_controllers/JointGroupPositionController": (GroupCommands, POSITION),
    "velocity_controllers/JointGroupVelocityController": (GroupCommands, VELOCITY),
}


class ControllerManager2(ControllerManager):
    """The controllers of one robot, as the tools of ros2_control manage them.

    It is the node controller_manager, and each controller that is loaded is one of its own: others may set parameters
    of both, types of controllers as ``NAME.type``, until a controller is configured. Where the bridge has no
    controller_manager_msgs, nobody could start controllers: all of the parameters are.

    Args:
        hardware: the robot's joints.
        session: for topics and services.
        space: the robot's namespace.
        now: gives the sim time [s].
        parameters: those of controller_manager and of controllers.
        rules: remappings of all these nodes.
    """

    services = SERVICES

    def __init__(
        self,
        hardware: RobotHardware2,
        session: Session,
        space: str,
        now: Callable[[], float],
        parameters: Parameters,
        rules: Sequence[tuple[str, str]] = (),
    ) -> None:
        self._parameters, self._interfaces, self._hardware2 = parameters, hardware.interfaces, hardware
        self._rules = [one for one in rules if not one[0].startswith("__")]
        self._unconfigured: dict[str, str] = {}  # names -> types
        self._nodes: dict[str, tuple[OwnNode, NodeParameters]] = {}  # of controllers, by their names
        self._session, self._space = session, space
        self._own, self._own_parameters = self._new_node("controller_manager")
        self._alone = False
        super().__init__(hardware, session, space, now)

    @property
    def own_session(self) -> NodeSession:
        """What its services belong to."""
        return NodeSession(self._session, self._own)

    def _new_node(self, name: str) -> tuple[OwnNode, NodeParameters]:
        plain = OwnNode(self._session.names, self._space, name)
        node = OwnNode(self._session.names, self._space, name, self._rules, self._parameters.of(plain.full_name))
        parameters = NodeParameters(self._session, node, open=True)
        parameters.take_given()
        return node, parameters

    def _values(self, of: tuple[OwnNode, NodeParameters]) -> dict[str, Any]:
        """The parameters of a node: those that are given, also what no message can hold, and those that were set."""
        node, parameters = of
        return tables(node.given, parameters.values())

    def update(self, elapsed: float) -> None:
        """Update the running controllers."""
        node: Any = self._session.node
        if not self._alone and node.lacks("controller_manager_msgs"):
            self._alone = True
            self._start_all()
        super().update(elapsed)

    def _start_all(self) -> None:
        names = [name for name, one in self._own.given.items() if isinstance(one, Mapping) and "type" in one]
        log.warning("ROS 2 has no controller_manager_msgs: all controllers are started: %s", ", ".join(names))
        for name in names:
            asked = SimpleNamespace(name=name)
            if self._load_controller(asked)["ok"] and self._configure_controller(asked)["ok"]:
                self._switch([name], [], 1)  # one by one: of those that command the same joints, the first

    def _list_controller_types(self, _request: Any) -> dict[str, Any]:
        return {
            "types": list(CONTROLLERS),
            "base_classes": ["controller_interface::ControllerInterface"] * len(CONTROLLERS),
        }

    def _list_controllers(self, _request: Any) -> dict[str, Any]:
        state = message_type("controller_manager_msgs/ControllerState", 2)
        found = [state(name=name, state="unconfigured", type=kind) for name, kind in self._unconfigured.items()]
        for name, one in self.controllers.items():
            short = one.interface.rpartition("/")[2].removesuffix("JointInterface").lower()
            claimed = [f"{joint.name}/{short}" for joint in one.joints] if one.state == "running" else []
            found.append(state(name=name, state=STATES[one.state], type=self._kinds[name], claimed_interfaces=claimed))
        return {"controller": found}

    def _list_hardware_interfaces(self, _request: Any) -> dict[str, Any]:
        kind = message_type("controller_manager_msgs/HardwareInterface", 2)
        short = {long: name for name, long in SHORT_NAMES.items()}
        claimed = {(j.name, j.interface) for c in self.controllers.values() if c.state == "running" for j in c.joints}
        commands = [
            kind(name=f"{name}/{short[one]}", is_available=True, is_claimed=(name, one) in claimed)
            for name, given in self._interfaces.items()
            for one in given
        ]
        states = [kind(name=f"{name}/{one}", is_available=True) for name in self._interfaces for one in SHORT_NAMES]
        return {"command_interfaces": commands, "state_interfaces": states}

    def _list_hardware_components(self, _request: Any) -> dict[str, Any]:
        kind = message_type("controller_manager_msgs/HardwareComponentState", 2)
        found = self._list_hardware_interfaces(None)
        rows = []
        for name, plugin, joints in self._hardware2.systems:
            row = kind(name=name, type="system", class_type=plugin)
            row.state.id, row.state.label = ACTIVE, "active"
            for key, interfaces in found.items():
                setattr(row, key, [one for one in interfaces if one.name.rpartition("/")[0] in joints])
            rows.append(row)
        return {"component": rows}

    def _load_controller(self, request: Any) -> dict[str, Any]:
        name = request.name.strip("/")
        own = self._values((self._own, self._own_parameters)).get(name)
        kind = own.get("type") if isinstance(own, Mapping) else None
        if name in self.controllers or name in self._unconfigured:
            log.error("A controller named '%s' was already loaded inside the controller manager", name)
        elif not isinstance(kind, str) or kind not in CONTROLLERS:
            near = nearest(str(kind), CONTROLLERS)
            log.error("Could not load controller '%s': there is no type '%s'%s", name, kind, near)
        elif len(self.controllers) + len(self._unconfigured) >= MOST_CONTROLLERS:
            log.error("Could not load controller '%s': there are %d", name, MOST_CONTROLLERS)
        else:
            self._unconfigured[name] = kind
            self._nodes[name] = self._new_node(name)
            return {"ok": True}
        return {"ok": False}

    def _configure_controller(self, request: Any) -> dict[str, Any]:
        name = request.name.strip("/")
        kind = self._unconfigured.get(name)
        if kind is None:
            log.error("Could not configure controller '%s': it is not loaded and unconfigured", name)
            return {"ok": False}
        made, interface = CONTROLLERS[kind]
        node, values = self._nodes[name][0], self._values(self._nodes[name])
        session = NodeSession(self._session, node)
        try:
            self.controllers[name] = made(node.full_name, values, self._hardware, session, self._now, interface)
        except GazeboError as error:
            log.error("Could not configure controller '%s': %s", name, error)
            return {"ok": False}
        self._kinds[name] = self._unconfigured.pop(name)
        return {"ok": True}

    def _unload_controller(self, request: Any) -> dict[str, Any]:
        name = request.name.strip("/")
        done = {"ok": True} if self._unconfigured.pop(name, None) is not None else super()._unload_controller(request)
        if done["ok"]:
            self._forget(name)
        return done

    def _reload_controller_libraries(self, request: Any) -> dict[str, Any]:
        done = super()._reload_controller_libraries(request)
        if done["ok"]:
            self._unconfigured.clear()
            for name in list(self._nodes):
                self._forget(name)
        return done

    def _forget(self, name: str) -> None:
        self._nodes.pop(name)[1].end()

    def _switch_controller(self, request: Any) -> dict[str, Any]:
        start = [*request.activate_controllers, *request.start_controllers]
        return self._switch(start, [*request.deactivate_controllers, *request.stop_controllers], request.strictness)

    def _switch(self, start: list[str], stop: list[str], strictness: int) -> dict[str, Any]:
        asked = SimpleNamespace(start_controllers=start, stop_controllers=stop, strictness=strictness)
        return super()._switch_controller(asked)

    def started(self, controller: Controller) -> None:
        """A controller begins to run: its interfaces command its joints."""
        for joint in controller.joints:
            self._hardware2.activate(joint)
