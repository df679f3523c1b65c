"""Elements that SDF knows and libgz does not simulate: one warning for each kind of them."""

from __future__ import annotations

from collections.abc import Iterator

from libgz.base.errors import Diagnostics
from libgz.sdf.element import Element

__all__ = ["ABSENT_SENSORS", "warn_of_unsimulated"]

# Types of sensors that Gazebo has.
ABSENT_SENSORS = ("rfid", "rfidtag")
PARTS = {
    "audio": "sound is not simulated",
    "audio_sink": "sound is not simulated",
    "audio_source": "sound is not simulated",
    "projector": "projectors are not simulated: nothing is projected",
    "particle_emitter": "particles are not simulated",
    "pbr": "its roughness, normals and reflections are shown in pages only; images have colours and the albedo map",
}


def warn_of_unsimulated(root: Element, diagnostics: Diagnostics) -> None:
    """Warn of all kinds, each at its first place, with the number of further ones."""
    places: dict[str, list[Element]] = {}
    for element, message in _found(root):
        places.setdefault(message, []).append(element)
    for message, elements in places.items():
        more = f" ({len(elements) - 1} more in this world)" if len(elements) > 1 else ""
        diagnostics.warn(elements[0], message + more)


def _found(element: Element) -> Iterator[tuple[Element, str]]:
    for child in element.children:
        if child.name == "plugin":
            continue
        kind = child.Get(str, "type") if child.name == "sensor" else ""
        if kind in ABSENT_SENSORS:
            yield child, f"type {kind!r} is not simulated; the sensor is left out"
        elif child.name in PARTS:
            yield child, PARTS[child.name]
        elif child.name == "joint" and (soft := _softness(child)) is not None:
            yield soft, "softens the joint's motor and stops only, not what holds its links together as in Gazebo"
            yield from _found(child)
        else:
            yield from _found(child)


def _softness(joint: Element) -> Element | None:
    """The `<cfm>` of a joint as a whole, if it is not 0, and softens the joint in Gazebo."""
    if joint.Get(str, "type") in ("ball", "fixed"):
        return None
    for physics in joint.named("physics"):
        for ode in physics.named("ode"):
            for cfm in ode.named("cfm"):
                if cfm.Get(float):
                    return cfm
    return None
