"""The world's own settings: `<param:Global>`, and `<params:GlobalParams>` of Gazebo 0.3 and 0.4."""

from __future__ import annotations

from libgz.base.errors import nearest
from libgz.base.geometry import GzColor, GzVector
from libgz.worldfile.attributes import boolean, color, declaration, integer, number, read, text, vector
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["QUIRKS", "GlobalAttributes", "find_global_nodes", "is_settings", "read_global", "read_quirks"]

# Errors of the old server that a world can enable again, and the effect of each.
QUIRKS = {
    "verticalHfov": "cameras take hfov as the vertical angle",
    "laserNoHitOffset": "a laser beam without a hit reads rangeMax + rangeMin",
    "wholeRetro": "a laser reports intensity 1 from a retro of 1 on, because fractions are cut off",
    "setMassZero": "SetMass(0) leaves a geom the mass of its volume at 1 kg/m^3",
    "originInertia": "a body's inertia is taken about its frame's origin, not about its centre of mass",
    "gripperState": "grippers report states by the old server's private numbers, at the time of the command; "
    "their beams are the old ones",
    "noBounce": "SetBounce has no effect",
    "updateTimes": "some models update a step late, sometimes or always: times are compared without a tolerance",
}

_TAGS: list[tuple[str | None, str]] = [("params", "GlobalParams"), ("param", "Global")]  # oldest first


@declaration
class GlobalAttributes:
    """What `<param:Global>` may hold."""

    speed: float = number(1.0, least=0.0, help="simulated seconds per second of real time; 0: as fast as possible")
    stepTime: float = number(0.02, unit="s", above=0.0, most=1.0, help="length of a simulation step")
    gravity: GzVector = vector((0.0, 0.0, -9.8), unit="m/s^2", help="acceleration of free fall")
    pause: bool = boolean(False, help="whether the simulation starts paused")
    dayTime: float = number(-1.0, unit="s", help="time since midnight at the start; negative: the local clock's")
    utcOffset: float = number(0.0, unit="s", help="UTC at sim time 0")
    utmZone: int = integer(
        0, least=-60, most=60, help="UTM zone of the world's origin; negative in the south; 0: unset"
    )
    utmOffset: GzVector = vector((0.0, 0.0, 0.0), help="UTM easting, northing and altitude of the world's origin")
    skyColor: GzColor = color(0.7, 0.7, 0.9, help="colour of the sky and of the fog")
    fogDensity: float = number(0.25, least=0.0, help="density of the fog; there is fog only if this is given")
    legacyQuirks: str = text("", help="`true`, or names of the old server's errors to enable again in this world")


def find_global_nodes(file: WorldFile) -> list[WorldFileNode]:
    """The elements that hold settings, oldest spelling first."""
    found = (node for node in file.GetRootNode().walk() if is_settings(node))
    return sorted(found, key=lambda node: _TAGS.index((node.prefix, node.name)))


def is_settings(node: WorldFileNode) -> bool:
    """Whether an element holds settings."""
    return (node.prefix, node.name) in _TAGS


def read_global(file: WorldFile) -> tuple[GlobalAttributes, bool]:
    """(settings, whether there is fog): those of the last element that has any, with defaults for the rest."""
    values, fog = GlobalAttributes(), False
    for node in find_global_nodes(file):
        node.GetNSPrefix()
        values = read(GlobalAttributes, node)
        fog = node.GetChild("fogDensity") is not None
    return values, fog


def read_quirks(file: WorldFile, words: str) -> frozenset[str]:
    """The quirks a world enables; an unknown name is an error in the worldfile."""
    names = words.split()
    if [name.lower() for name in names] in (["true"], ["1"]):
        return frozenset(QUIRKS)
    if [name.lower() for name in names] in (["false"], ["0"]):
        return frozenset()
    for name in names:
        if name not in QUIRKS:
            node = find_global_nodes(file)[-1].GetChild("legacyQuirks") or file.GetRootNode()
            node.error(f"{name!r} is not a quirk; allowed are true, {', '.join(QUIRKS)}{nearest(name, QUIRKS)}")
    return frozenset(names) & frozenset(QUIRKS)
