"""SdfState: a `<state>` element, of a saved world or a log; from XML and to text."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from lxml import etree

from libgz.base.errors import ParameterError
from libgz.base.files import xml_attribute, xml_text
from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector

__all__ = ["SdfState"]

_SECOND = 10**9  # [ns]


@dataclass
class SdfState:
    """The poses and velocities of a world at one time; in a log, only those that changed since the previous state.

    Attributes:
        sim_time, real_time, wall_time: [s].
        iterations: of the world.
        model_poses: of models, global [m, rad], by scoped name ``model::nested``. Logs of libgz have none.
        poses: of links and lights, global [m, rad], by scoped name ``model::link``.
        velocities: of links, linear and angular [m/s, rad/s], by scoped name.
        insertions: SDF texts of models and lights that were added.
        deletions: names of models and lights that were removed.
        world: the world's name.
    """

    sim_time: float
    real_time: float = 0.0
    wall_time: float = 0.0
    iterations: int = 0
    model_poses: dict[str, GzPose] = field(default_factory=dict)
    poses: dict[str, GzPose] = field(default_factory=dict)
    velocities: dict[str, tuple[GzVector, GzVector]] = field(default_factory=dict)
    insertions: list[str] = field(default_factory=list)
    deletions: list[str] = field(default_factory=list)
    world: str = "default"

    @classmethod
    def parse(cls, element: etree._Element) -> SdfState:
        """Read a `<state>`.

        Raises:
            ParameterError: it has an invalid number.
        """
        state = cls(
            _seconds(element, "sim_time"),
            _seconds(element, "real_time"),
            _seconds(element, "wall_time"),
            _iterations(element),
            world=element.get("world_name", "default"),
        )
        for model in element.iterchildren("model"):
            state._read_model(model, "")
        for light in element.iterchildren("light"):
            pose = light.findtext("pose")
            if pose is not None:
                state.poses[light.get("name", "")] = _pose(pose)
        for part in element.iterchildren("insertions"):
            state.insertions += [etree.tostring(child, encoding="unicode") for child in part]
        for part in element.iterchildren("deletions"):
            state.deletions += [(name.text or "").strip() for name in part.iterchildren("name")]
        return state

    def _read_model(self, model: etree._Element, scope: str) -> None:
        name = scope + model.get("name", "")
        pose = model.findtext("pose")
        if pose is not None:
            self.model_poses[name] = _pose(pose)
        for link in model.iterchildren("link"):
            scoped = f"{name}::{link.get('name', '')}"
            pose = link.findtext("pose")
            if pose is not None:
                self.poses[scoped] = _pose(pose)
            velocity = link.findtext("velocity")
            if velocity is not None:
                numbers = _six_numbers(velocity, "velocity", "[m/s], then [rad/s]")
                self.velocities[scoped] = GzVector(*numbers[:3]), GzVector(*numbers[3:])
        for inner in model.iterchildren("model"):
            self._read_model(inner, f"{name}::")

    def text(self, version: str) -> str:
        """Return an SDF document with the `<state>`."""
        words = [
            f"<sdf version='{version}'>\n<state world_name=\"{xml_attribute(self.world)}\">\n",
            f"<sim_time>{_time_text(self.sim_time)}</sim_time>\n<real_time>{_time_text(self.real_time)}</real_time>\n",
            f"<wall_time>{_time_text(self.wall_time)}</wall_time>\n<iterations>{self.iterations}</iterations>\n",
        ]
        if self.insertions:
            words += ["<insertions>\n", *self.insertions, "</insertions>\n"]
        if self.deletions:
            names = (f"<name>{xml_text(name)}</name>" for name in self.deletions)
            words += ["<deletions>", *names, "</deletions>\n"]
        by_model: dict[str, list[str]] = {}
        lights = []
        for name, pose in self.poses.items():
            model, scoped, link = name.rpartition("::")
            if scoped:
                by_model.setdefault(model, []).append(link)
            else:
                lights.append(f'<light name="{xml_attribute(name)}"><pose>{_pose_text(pose)}</pose></light>\n')
        for model, links in by_model.items():
            scopes = model.split("::")
            words += [f'<model name="{xml_attribute(scope)}">\n' for scope in scopes]
            words += [self._link_text(model, link) for link in links]
            words += ["</model>\n"] * len(scopes)
        return "".join([*words, *lights, "</state>\n</sdf>\n"])

    def _link_text(self, model: str, link: str) -> str:
        name = f"{model}::{link}"
        text = f'<link name="{xml_attribute(link)}"><pose>{_pose_text(self.poses[name])}</pose>'
        if name in self.velocities:
            linear, angular = self.velocities[name]
            text += f"<velocity>{' '.join(map(repr, map(float, (*linear, *angular))))}</velocity>"
        return text + "</link>\n"


def _seconds(element: etree._Element, tag: str) -> float:
    """Return a time [s], given as seconds and nanoseconds, or as seconds alone; 0 if there is none."""
    text = element.findtext(tag, "")
    words = text.split() or ["0"]
    try:
        if len(words) == 1 and math.isfinite(seconds := float(words[0])):
            return seconds
        whole, nanoseconds = words
        return (int(whole) * _SECOND + int(nanoseconds)) / _SECOND
    except ValueError:
        raise ParameterError(f"<{tag}>: {text.strip()!r} is not allowed; it must be seconds and nanoseconds") from None


def _iterations(element: etree._Element) -> int:
    text = element.findtext("iterations") or "0"
    try:
        return int(text)
    except ValueError:
        raise ParameterError(f"<iterations>: {text.strip()!r} is not allowed; it must be an integer") from None


def _time_text(seconds: float) -> str:
    whole = math.floor(seconds)
    total = whole * _SECOND + round((seconds - whole) * 1e9)
    return f"{total // _SECOND} {total % _SECOND}"


def _six_numbers(text: str, tag: str, meaning: str) -> list[float]:
    try:
        found = [float(word) for word in text.split()]
    except ValueError:
        found = []
    if len(found) != 6 or not all(map(math.isfinite, found)):
        raise ParameterError(f"<{tag}>: {text.strip()!r} is not allowed; it must be 6 numbers: {meaning}")
    return found


def _pose(text: str) -> GzPose:
    x, y, z, roll, pitch, yaw = _six_numbers(text, "pose", "x y z [m] roll pitch yaw [rad]")
    return GzPose(GzVector(x, y, z), GzQuaternFromEuler(roll, pitch, yaw))


def _pose_text(pose: GzPose) -> str:
    return " ".join(map(repr, map(float, (*pose.pos, *GzQuaternToEuler(pose.rot)))))
