"""WorldState: poses and velocities of a world at one time; and the world as an SDF document."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from libgz.classic.common import Time
from libgz.errors import WorldFileError
from libgz.geometry import GzCoordPoseSub, GzPose, GzVector
from libgz.sdf.element import Element
from libgz.sdf.upgrade import NEWEST, upgraded

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["WorldState", "save_world", "world_text"]


class WorldState:
    """Poses [m] and velocities [m/s], [rad/s] of all links of a world at one time, by scoped name."""

    def __init__(self, world: World) -> None:
        self.name = world.Name()
        self._time = world.SimTime()
        self._links: dict[str, tuple[GzPose, GzVector, GzVector]] = {}
        for model in world.all_models():
            for link in model.GetLinks():
                body = link.body
                self._links[link.GetScopedName()] = body.GetPose(), body.GetLinearVel(), body.GetAngularRate()

    def GetSimTime(self) -> Time:
        """The sim time."""
        return self._time

    SimTime = GetSimTime

    def GetModelStateCount(self) -> int:
        """The number of models."""
        return len({name.partition("::")[0] for name in self._links})

    def LinkPose(self, name: str) -> GzPose:
        """Global pose of a link by scoped name [m]."""
        return self._links[name][0]

    def apply(self, world: World) -> None:
        """Set the poses and velocities of a world's links; links that are not in the state do not change."""
        for model in world.all_models():
            for link in model.GetLinks():
                known = self._links.get(link.GetScopedName())
                if known is not None:
                    link.body.SetPose(known[0])
                    link.body.SetLinearVel(known[1])
                    link.body.SetAngularVel(known[2])


MADE = ("model", "actor", "light", "population", "state")  # of what entities are made; they are written as they are now


def world_text(world: World, folder: Path | None = None) -> str:
    """A world as an SDF document with the present poses.

    Args:
        world: the world.
        folder: the folder of the document; paths of files in it stay relative.

    Raises:
        WorldFileError: the world was not made from SDF.
    """
    sdf = world.SDF()
    if sdf is None:
        raise WorldFileError(f"world {world.Name()!r} was not made from SDF")
    copy = upgraded(sdf, folder)
    for element in [child for child in copy.children if child.name in MADE]:
        copy.RemoveChild(element)
    for part in (*world.Models(), *world.Lights()):
        own = part.GetSDF()
        if own is not None:
            copy.InsertElement(_placed(upgraded(own, folder), part.pose()))
    for model in world.Models():
        placed = next((e for e in copy.named("model") if e.Get(str, "name") == model.GetName()), Element("model"))
        for link in model.GetLinks():
            for inner in placed.named("link"):
                if inner.Get(str, "name") == link.GetName():
                    _placed(inner, GzCoordPoseSub(link.pose(), model.pose()))
    return f'<?xml version="1.0"?>\n<sdf version="{NEWEST}">\n{copy.ToString("  ")}</sdf>\n'


def save_world(world: World, path: Path) -> None:
    """Write a world as SDF with the present poses.

    Raises:
        WorldFileError: the file cannot be written, or the world was not made from SDF.
    """
    try:
        path.write_text(world_text(world, path.parent))
    except OSError as error:
        raise WorldFileError(f"{path}: cannot be written: {error.strerror}") from None


def _placed(element: Element, pose: GzPose) -> Element:
    (next(element.named("pose"), None) or element.AddElement("pose")).Set(pose)
    return element
