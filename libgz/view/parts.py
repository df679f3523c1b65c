"""Parts: sliders and buttons for what robots carry: pan-tilt heads, grippers, actuator arrays, joint interfaces."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["STEERED", "Part", "interface_parts"]

STEERED = ("ptz", "gripper", "actarray", "joint")  # types of interfaces that have parts
TWO_AXES = (5, 6)  # ODE's numbers of universal and hinge-2 joints
PTZ = {"pan": (-math.pi / 2.0, math.pi / 2.0), "tilt": (-1.0, 1.0), "zoom": (0.1, 2.0)}  # [rad]
GRIPPER = {"open": 1, "close": 2, "stop": 3, "lift up": 4, "lift down": 5, "lift stop": 6}
TURN = math.pi  # [rad] how far without limits
MOST_JOINTS = 24


@dataclass(frozen=True)
class Part:
    """A slider or a button for a part of a robot.

    Attributes:
        label: for the user.
        action: called with the value.
        value, limits: of a slider [rad]; None: a button.
    """

    label: str
    action: Callable[[float], object]
    value: float = 0.0
    limits: tuple[float, float] | None = None

    def as_data(self, key: str) -> dict[str, Any]:
        """What a page shows; `key` is the name by which it moves the part."""
        if self.limits is None:
            return {"key": key, "kind": "button", "label": self.label}
        low, high = self.limits
        value = min(max(self.value, low), high) if math.isfinite(self.value) else low
        slider = {"key": key, "kind": "slider", "label": self.label, "unit": "rad"}
        return {**slider, "value": value, "low": low, "high": high}


def interface_parts(interface: Any) -> list[Part]:
    """The controls of an interface of one of the types STEERED."""

    def aim(name: str, value: float) -> None:
        interface.command(**{name: value})

    def grip(code: int, _: float) -> None:
        interface.command(code)

    def move(place: int, value: float) -> None:
        with interface.locked() as data:
            data.cmd_pos[place], data.joint_mode[place] = value, 0
            data.new_cmd += 1

    def turn(place: int, field: str, value: float) -> None:
        with interface.locked() as data:
            setattr(data.joints[place], field, value)

    owner, partial = interface.id, functools.partial
    if interface.type == "ptz":
        return [
            Part(f"{owner} {name}", partial(aim, name), float(getattr(interface, name)), limits)
            for name, limits in PTZ.items()
        ]
    if interface.type == "gripper":
        return [Part(f"{owner}: {label}", partial(grip, code)) for label, code in GRIPPER.items()]
    if interface.type == "joint":
        found = []
        for i, joint in enumerate(interface.joints):
            for axis in ("", "2") if joint["type"] in TWO_AXES else ("",):
                label, action = f"{owner} joint {i}{axis and ' axis 2'}", partial(turn, i, f"cmd_angle{axis}")
                found.append(Part(label, action, float(joint[f"angle{axis}"]), (-TURN, TURN)))
        return found[:MOST_JOINTS]
    return [
        Part(f"{owner} joint {i}", partial(move, i), float(actuator["position"]), (-TURN, TURN))
        for i, actuator in enumerate(interface.actuators)
    ]
