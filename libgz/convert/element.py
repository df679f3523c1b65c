"""Writing SDF: elements with text, numbers, poses and colours in its form."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from lxml import etree

from libgz.base.geometry import GzColor, GzHomoFromQuatern, GzPose, GzQuaternNormal

__all__ = ["Notes", "add", "color", "name_of", "number", "pose"]


@dataclass
class Notes:
    """Notes on what has no counterpart in SDF, once each, in order."""

    lines: dict[str, None] = field(default_factory=dict)

    def add(self, owner: str, text: str) -> None:
        """Add a note about a model, identified by tag and id, or about the world."""
        self.lines.setdefault(f"{owner}: {text}")


def add(parent: etree._Element, tag: str, text: object = None, **attributes: str) -> etree._Element:
    """Add a child element; numbers and tuples of numbers are formatted for SDF."""
    child = etree.SubElement(parent, tag, attributes)
    if isinstance(text, bool):
        child.text = "true" if text else "false"
    elif isinstance(text, int | float):
        child.text = number(text)
    elif isinstance(text, str):
        child.text = text
    elif isinstance(text, Iterable):
        child.text = " ".join(map(number, text))
    return child


def number(value: float) -> str:
    """A number with 15 significant digits, and no minus before zero."""
    return f"{value + 0.0:.15g}"


def pose(place: GzPose) -> list[float]:
    """x, y, z [m], roll, pitch, yaw [rad]: the rotation is Rz(yaw) Ry(pitch) Rx(roll).

    At a pitch of 90 degrees roll and yaw turn about one axis; all of it is yaw then.
    """
    r = GzHomoFromQuatern(GzQuaternNormal(place.rot)).m
    level = math.hypot(r[0][0], r[1][0])
    pitch = math.atan2(-r[2][0], level)
    if level > 1e-7:
        roll, yaw = math.atan2(r[2][1], r[2][2]), math.atan2(r[1][0], r[0][0])
    else:
        roll, yaw = 0.0, math.atan2(-r[0][1], r[1][1])
    return [round(value, 12) for value in (*place.pos, roll, pitch, yaw)]


def color(value: GzColor) -> list[float]:
    """Red, green, blue, alpha, each 0 to 1."""
    return [min(max(part, 0.0), 1.0) for part in value]


def name_of(wanted: str, taken: set[str]) -> str:
    """A unique name that SDF allows: no `::`, not `world`, no `__` at the ends."""
    name = wanted.strip().replace("::", "_").strip("_") or "unnamed"
    if name == "world":
        name = "world_"
    unique, number = name, 2
    while unique in taken:
        unique, number = f"{name}_{number}", number + 1
    taken.add(unique)
    return unique
