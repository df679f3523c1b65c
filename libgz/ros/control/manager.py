"""ControllerManager: loads, starts, stops and lists the controllers of a robot, by its services."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

from libgz.base.errors import GazeboError, nearest
from libgz.ros.control.controllers import (
    Commands,
    Controller,
    Gripper,
    GroupCommands,
    GroupPositionCommands,
    JointStates,
    JointTrajectories,
    PositionCommands,
    VelocityCommands,
)
from libgz.ros.control.drive import DiffDrive
from libgz.ros.control.hardware import EFFORT, POSITION, SHORT_NAMES, VELOCITY, RobotHardware
from libgz.ros.session import NodeSession, Session
from libgz.ros.types import message_type, service_type

__all__ = ["ControllerManager"]

log = logging.getLogger("libgz.ros")

MOST_CONTROLLERS = 100
STRICT = 2
SERVICES = {
    "list_controller_types": "ListControllerTypes",
    "list_controllers": "ListControllers",
    "load_controller": "LoadController",
    "reload_controller_libraries": "ReloadControllerLibraries",
    "switch_controller": "SwitchController",
    "unload_controller": "UnloadController",
}

# Types of controllers -> class, interface of its joints.
CONTROLLERS: dict[str, tuple[type[Controller], str]] = {
    "joint_state_controller/JointStateController": (JointStates, ""),
    "diff_drive_controller/DiffDriveController": (DiffDrive, VELOCITY),
    "effort_controllers/JointEffortController": (Commands, EFFORT),
    "effort_controllers/JointGroupEffortController": (GroupCommands, EFFORT),
    "effort_controllers/JointGroupPositionController": (GroupPositionCommands, EFFORT),
    "effort_controllers/JointPositionController": (PositionCommands, EFFORT),
    "effort_controllers/JointVelocityController": (VelocityCommands, EFFORT),
    "position_controllers/JointGroupPositionController": (GroupCommands, POSITION),
    "position_controllers/JointPositionController": (Commands, POSITION),
    "velocity_controllers/JointGroupVelocityController": (GroupCommands, VELOCITY),
    "velocity_controllers/JointPositionController": (PositionCommands, VELOCITY),
    "velocity_controllers/JointVelocityController": (Commands, VELOCITY),
    **{f"{name}_controllers/JointTrajectoryController": (JointTrajectories, one) for name, one in SHORT_NAMES.items()},
    **{f"{name}_controllers/GripperActionController": (Gripper, one) for name, one in SHORT_NAMES.items()},
}


class ControllerManager:
    """The controllers of one robot.

    Args:
        hardware: the robot's joints.
        session: for parameters, topics and services.
        space: the robot's namespace.
        now: gives the sim time [s].

    Attributes:
        services: their names -> their types.
        controllers: names -> those that were loaded.
    """

    services: ClassVar[Mapping[str, str]] = SERVICES

    def __init__(self, hardware: RobotHardware, session: Session, space: str, now: Callable[[], float]) -> None:
        self._hardware, self._session, self._space, self._now = hardware, session, space, now
        self.controllers: dict[str, Controller] = {}
        self._kinds: dict[str, str] = {}
        self._services = [
            self.own_session.serve(
                f"{space}/controller_manager/{name}", f"controller_manager_msgs/{kind}", self._handler(name)
            )
            for name, kind in self.services.items()
        ]

    @property
    def own_session(self) -> Session | NodeSession:
        """What its services belong to."""
        return self._session

    def _handler(self, name: str) -> Callable[[Any], Any]:
        method = getattr(self, f"_{name}")
        response = service_type(f"controller_manager_msgs/{self.services[name]}", self._session.version).response

        def handle(request: Any) -> Any:
            return response(**method(request))

        return handle

    def update(self, elapsed: float) -> None:
        """Update the running controllers."""
        for controller in self.controllers.values():
            if controller.state == "running":
                controller.update(elapsed)

    def reset(self) -> None:
        """Start the running controllers again: the robot has moved."""
        for controller in self.controllers.values():
            if controller.state == "running":
                controller.starting()

    # Services ----------------------------------------------------------------------------------------------------

    def _list_controller_types(self, _request: Any) -> dict[str, Any]:
        return {"types": list(CONTROLLERS), "base_classes": ["controller_interface::ControllerBase"] * len(CONTROLLERS)}

    def _list_controllers(self, _request: Any) -> dict[str, Any]:
        state, claim = (
            message_type(f"controller_manager_msgs/{name}")
            for name in ("ControllerState", "HardwareInterfaceResources")
        )
        found = []
        for name, one in self.controllers.items():
            interface = one.interface or "hardware_interface/JointStateInterface"
            claims = [claim(hardware_interface=_cpp(interface), resources=[joint.name for joint in one.joints])]
            found.append(state(name=name, state=one.state, type=self._kinds[name], claimed_resources=claims))
        return {"controller": found}

    def _load_controller(self, request: Any) -> dict[str, Any]:
        name = request.name.strip("/")
        try:
            return {"ok": self._load(name)}
        except GazeboError as error:
            log.error("Could not load controller '%s': %s", name, error)
            return {"ok": False}

    def _load(self, name: str) -> bool:
        full = self._session.resolve(name, self._space)
        values = self._session.parameter(full)
        kind = values.get("type") if isinstance(values, Mapping) else None
        if name in self.controllers:
            log.error("A controller named '%s' was already loaded inside the controller manager", name)
        elif not isinstance(kind, str):
            log.error("Could not load controller '%s': parameter %s/type is not set", name, full)
        elif kind not in CONTROLLERS:
            log.error("Could not load controller '%s': there is no type '%s'%s", name, kind, nearest(kind, CONTROLLERS))
        elif len(self.controllers) >= MOST_CONTROLLERS:
            log.error("Could not load controller '%s': there are %d", name, MOST_CONTROLLERS)
        else:
            made, interface = CONTROLLERS[kind]
            self.controllers[name] = made(full, values, self._hardware, self._session, self._now, interface)
            self._kinds[name] = kind
            return True
        return False

    def _unload_controller(self, request: Any) -> dict[str, Any]:
        name = request.name.strip("/")
        controller = self.controllers.get(name)
        if controller is None or controller.state == "running":
            why = "it runs" if controller is not None else "no controller with this name exists"
            log.error("Could not unload controller with name '%s': %s", name, why)
            return {"ok": False}
        controller.end()
        del self.controllers[name], self._kinds[name]
        return {"ok": True}

    def _reload_controller_libraries(self, request: Any) -> dict[str, Any]:
        if self.controllers and not request.force_kill:
            log.error(
                "Cannot reload controller libraries because there are still %d controllers", len(self.controllers)
            )
            return {"ok": False}
        self._stop([name for name, one in self.controllers.items() if one.state == "running"])
        for controller in self.controllers.values():
            controller.end()
        self.controllers.clear()
        return {"ok": True}

    def _switch_controller(self, request: Any) -> dict[str, Any]:
        strict = request.strictness == STRICT
        stop = self._known(request.stop_controllers, "running")
        start = self._known(request.start_controllers, "initialized", "stopped")
        if strict and (len(stop) < len(request.stop_controllers) or len(start) < len(request.start_controllers)):
            return {"ok": False}
        running = [one for name, one in self.controllers.items() if one.state == "running" and name not in stop]
        claimed = {joint.name: one.name for one in running for joint in one.joints}
        for name in start:
            for joint in self.controllers[name].joints:
                if joint.name in claimed:
                    log.error("Resource conflict on [%s]: %s, %s", joint.name, claimed[joint.name], name)
                    return {"ok": False}
                claimed[joint.name] = name
        self._stop(stop)
        for name in start:
            self.controllers[name].state = "running"
            self.started(self.controllers[name])
            self.controllers[name].starting()
        return {"ok": True}

    def started(self, controller: Controller) -> None:
        """A controller begins to run."""

    def _known(self, names: Sequence[str], *states: str) -> list[str]:
        """The controllers of some names that are in one of some states; others are logged."""
        found = []
        for name in (one.strip("/") for one in names):
            controller = self.controllers.get(name)
            if controller is None:
                log.error("Could not start or stop controller with name '%s' because no such controller exists", name)
            elif controller.state not in states:
                log.warning("Controller '%s' is %s; it is left so", name, controller.state)
            else:
                found.append(name)
        return found

    def _stop(self, names: Sequence[str]) -> None:
        for name in names:
            self.controllers[name].stopping()
            self.controllers[name].state = "stopped"


def _cpp(interface: str) -> str:
    return interface.replace("/", "::")
