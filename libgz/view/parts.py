"""Parts: sliders and buttons for what robots carry, and for joints and lights of models."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from libgz.transport.observer import ObservedState

__all__ = ["STEERED", "Part", "interface_parts", "joint_parts", "light_parts"]

STEERED = ("ptz", "gripper", "actarray", "joint")  # types of interfaces that have parts
TWO_AXES = (5, 6)  # ODE's numbers of universal and hinge-2 joints
PTZ = {"pan": (-math.pi / 2.0, math.pi / 2.0), "tilt": (-1.0, 1.0), "zoom": (0.1, 2.0)}  # [rad]
GRIPPER = {"open": 1, "close": 2, "stop": 3, "lift up": 4, "lift down": 5, "lift stop": 6}
TURN = math.pi  # [rad] how far without limits
TURNS, SLIDES = ("rad", TURN), ("m", 1.0)  # unit, and how far without limits
MOVED = {"revolute": TURNS, "universal": TURNS, "revolute2": TURNS, "prismatic": SLIDES}  # kinds of joints
FREE = 100.0  # [rad] or [m] limits beyond are none
MOST_JOINTS = 24

Ask = Callable[..., object]


@dataclass(frozen=True)
class Part:
    """A control for a part of a robot or model.

    Attributes:
        kind: slider, color or button.
        label: for the user.
        action: called with the value.
        value, limits: of a slider.
        color: 0 to 255.
    """

    kind: str
    label: str
    action: Callable[[Any], object]
    value: float = 0.0
    limits: tuple[float, float] = (0.0, 1.0)
    color: tuple[int, int, int] = (255, 255, 255)


def interface_parts(interface: Any) -> list[Part]:
    """The controls of an interface of one of the types STEERED."""

    def aim(name: str, value: float) -> None:
        interface.command(**{name: float(value)})

    def grip(code: int, _: object) -> None:
        interface.command(code)

    def move(place: int, value: float) -> None:
        with interface.locked() as data:
            data.cmd_pos[place], data.joint_mode[place] = float(value), 0
            data.new_cmd += 1

    def turn(place: int, field: str, value: float) -> None:
        with interface.locked() as data:
            setattr(data.joints[place], field, float(value))

    owner, partial = interface.id, functools.partial
    if interface.type == "ptz":
        return [
            Part("slider", f"{owner} {name} [rad]", partial(aim, name), float(getattr(interface, name)), limits)
            for name, limits in PTZ.items()
        ]
    if interface.type == "gripper":
        return [Part("button", f"{owner}: {label}", partial(grip, code)) for label, code in GRIPPER.items()]
    if interface.type == "joint":
        found = []
        for i, joint in enumerate(interface.joints):
            for axis in ("", "2") if joint["type"] in TWO_AXES else ("",):
                label, action = f"{owner} joint {i}{axis and ' axis 2'}", partial(turn, i, f"cmd_angle{axis}")
                found.append(Part("slider", label, action, float(joint[f"angle{axis}"]), (-TURN, TURN)))
        return found[:MOST_JOINTS]
    return [
        Part("slider", f"{owner} joint {i}", partial(move, i), float(actuator["position"]), (-TURN, TURN))
        for i, actuator in enumerate(interface.actuators)
    ]


def light_parts(entity: dict[str, Any], ask: Ask) -> list[Part]:
    """Brightness and colour of an entity's lights."""
    lights = [shape for body in entity["bodies"] for shape in body["shapes"] if shape["kind"] == "light"]
    if not lights:
        return []
    diffuse = [float(part) for part in lights[0]["material"]["diffuse"][:3]]
    most = max(*diffuse, 1e-6)
    tint = [min(max(part / most, 0.0), 1.0) for part in diffuse]
    wanted: dict[str, Any] = {"strength": min(most, 1.0), "tint": tint}

    def shine(strength: float) -> None:
        wanted["strength"] = float(strength)
        send()

    def paint(color: tuple[int, int, int]) -> None:
        wanted["tint"] = [part / 255.0 for part in color]
        send()

    def send() -> None:
        ask("light", name=entity["id"], color=[wanted["strength"] * part for part in wanted["tint"]])

    red, green, blue = (round(255 * part) for part in tint)
    return [
        Part("slider", "Brightness", shine, min(most, 1.0)),
        Part("color", "Colour", paint, color=(red, green, blue)),
    ]


def joint_parts(entity: dict[str, Any], state: ObservedState, ask: Ask) -> list[Part]:
    """A slider for each axis of a model's joints, and a button that releases them."""
    parts: list[Part] = []

    def move(joint: str, axis: int, value: float) -> None:
        ask("joint", name=entity["id"], joint=joint, axis=axis, position=float(value))

    for joint in entity["joints"]:
        if joint["kind"] not in MOVED:
            continue
        unit, reach = MOVED[joint["kind"]]
        several = len(joint["limits"]) > 1
        for axis, limits in enumerate(joint["limits"][:2]):
            low, high = (side if side is not None and abs(side) < FREE else None for side in limits)
            span = -reach if low is None else float(low), reach if high is None else float(high)
            here = float(state.joints[joint["row"], axis]) if 0 <= joint["row"] < len(state.joints) else 0.0
            if span[0] < span[1] and len(parts) < MOST_JOINTS:
                label = f"{joint['name']}{f' {axis + 1}' if several else ''} [{unit}]"
                parts.append(Part("slider", label, functools.partial(move, joint["name"], axis), here, span))
    if parts:
        parts.append(Part("button", "Release the joints", lambda _: ask("release", name=entity["id"])))
    return parts
