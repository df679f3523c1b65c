"""LogState: what a log tells of one moment; to text and back."""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.sax.saxutils import escape, quoteattr

from lxml import etree

from libgz.classic.common import Time
from libgz.errors import WorldFileError
from libgz.geometry import GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector

__all__ = ["LogState"]


@dataclass
class LogState:
    """What has changed up to a moment.

    Attributes:
        sim_time, real_time, wall_time: [s].
        iterations: of the world.
        poses: of links and lights, global [m, rad], by scoped name ``model::link``.
        velocities: of links, linear and angular [m/s, rad/s], by scoped name.
        insertions: SDF texts of models and lights that have come.
        deletions: names of models and lights that have gone.
        world: the world's name.
    """

    sim_time: float
    real_time: float = 0.0
    wall_time: float = 0.0
    iterations: int = 0
    poses: dict[str, GzPose] = field(default_factory=dict)
    velocities: dict[str, tuple[GzVector, GzVector]] = field(default_factory=dict)
    insertions: list[str] = field(default_factory=list)
    deletions: list[str] = field(default_factory=list)
    world: str = "default"

    @classmethod
    def parse(cls, element: etree._Element) -> LogState:
        """From a `<state>`.

        Raises:
            WorldFileError: a number in it is none.
        """
        try:
            state = cls(
                Time.from_sdf(element.findtext("sim_time", "0 0")).Double(),
                Time.from_sdf(element.findtext("real_time", "0 0")).Double(),
                Time.from_sdf(element.findtext("wall_time", "0 0")).Double(),
                int(element.findtext("iterations") or 0),
                world=element.get("world_name", "default"),
            )
            for model in element.iterchildren("model"):
                state._add_model(model, "")
            for light in element.iterchildren("light"):
                state.poses[light.get("name", "")] = _pose(light.findtext("pose"))
        except ValueError as error:
            raise WorldFileError(f"<state> of a log: {error}") from None
        for part in element.iterchildren("insertions"):
            state.insertions += [etree.tostring(child, encoding="unicode") for child in part]
        for part in element.iterchildren("deletions"):
            state.deletions += [(name.text or "").strip() for name in part.iterchildren("name")]
        return state

    def _add_model(self, model: etree._Element, scope: str) -> None:
        name = scope + model.get("name", "")
        for link in model.iterchildren("link"):
            scoped = f"{name}::{link.get('name', '')}"
            self.poses[scoped] = _pose(link.findtext("pose"))
            velocity = link.findtext("velocity")
            if velocity is not None:
                numbers = _numbers(velocity, 6)
                self.velocities[scoped] = GzVector(*numbers[:3]), GzVector(*numbers[3:])
        for inner in model.iterchildren("model"):
            self._add_model(inner, f"{name}::")

    def text(self, version: str) -> str:
        """As an SDF document with a `<state>`."""
        words = [
            f"<sdf version='{version}'>\n<state world_name={quoteattr(self.world)}>\n",
            f"<sim_time>{_time(self.sim_time)}</sim_time>\n<real_time>{_time(self.real_time)}</real_time>\n",
            f"<wall_time>{_time(self.wall_time)}</wall_time>\n<iterations>{self.iterations}</iterations>\n",
        ]
        if self.insertions:
            words += ["<insertions>\n", *self.insertions, "</insertions>\n"]
        if self.deletions:
            names = (f"<name>{escape(name)}</name>" for name in self.deletions)
            words += ["<deletions>", *names, "</deletions>\n"]
        by_model: dict[str, list[str]] = {}
        for name in self.poses:
            model, _, link = name.rpartition("::")
            by_model.setdefault(model, []).append(link)
        for model, links in by_model.items():
            if not model:
                words += [
                    f"<light name={quoteattr(n)}><pose>{_pose_text(self.poses[n])}</pose></light>\n" for n in links
                ]
                continue
            scopes = model.split("::")
            words += [f"<model name={quoteattr(scope)}>\n" for scope in scopes]
            words += [self._link_text(model, link) for link in links]
            words += ["</model>\n"] * len(scopes)
        return "".join([*words, "</state>\n</sdf>\n"])

    def _link_text(self, model: str, link: str) -> str:
        name = f"{model}::{link}"
        text = f"<link name={quoteattr(link)}><pose>{_pose_text(self.poses[name])}</pose>"
        if name in self.velocities:
            linear, angular = self.velocities[name]
            text += f"<velocity>{' '.join(map(repr, map(float, (*linear, *angular))))}</velocity>"
        return text + "</link>\n"


def _time(seconds: float) -> str:
    time = Time(seconds)
    return f"{time.sec} {time.nsec}"


def _numbers(text: str | None, count: int) -> list[float]:
    found = [float(word) for word in (text or "").split()]
    if len(found) != count:
        raise ValueError(f"{text!r} is not {count} numbers")
    return found


def _pose(text: str | None) -> GzPose:
    x, y, z, roll, pitch, yaw = _numbers(text, 6)
    return GzPose(GzVector(x, y, z), GzQuaternFromEuler(roll, pitch, yaw))


def _pose_text(pose: GzPose) -> str:
    return " ".join(map(repr, map(float, (*pose.pos, *GzQuaternToEuler(pose.rot)))))
