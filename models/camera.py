"""What all camera models have in common: their attributes, and the word that they draw no pictures yet."""

from __future__ import annotations

import logging
import weakref
from dataclasses import dataclass

from libgz.simulation.model import Model
from libgz.simulation.world import World
from libgz.worldfile.attributes import angle, boolean, integer, length, number, numbers, text
from libgz.worldfile.node import WorldFileNode

__all__ = ["CameraAttributes", "RobotCameraAttributes", "announce_blindness", "check_clips"]

log = logging.getLogger("libgz.models")

_told: weakref.WeakSet[World] = weakref.WeakSet()


@dataclass(frozen=True)
class CameraAttributes:
    """What every camera's element may hold."""

    updateRate: float = number(10.0, unit="Hz", least=0.0, help="pictures per second of sim time")
    imageSize: tuple[float, ...] = numbers(320, 240, unit="px", least=1, help="width and height of the picture")
    hfov: float = angle(60.0, above=0.0, most=179.0, help="horizontal field of view")
    nearClip: float = length(0.5, least=0.01, help="nearest that is drawn")
    farClip: float = length(50.0, above=0.0, help="farthest that is drawn")
    renderMethod: str = text("auto", help="accepted: pictures are always drawn off-screen")
    zBufferDepth: int = integer(16, unit="bit", help="accepted: depth buffers always have 24 bits or more")
    savePath: str = text(".", help="directory for saved pictures")
    saveFrames: bool = boolean(False, help="save every picture")


@dataclass(frozen=True)
class RobotCameraAttributes(CameraAttributes):
    """The same for a camera that others can see."""

    useFrustrum: bool = boolean(True, help="let observers see what the camera sees")


def check_clips(node: WorldFileNode, values: CameraAttributes) -> None:
    """An error of the worldfile if the far clip is not beyond the near one."""
    if values.farClip <= values.nearClip:
        node.error(f"farClip {values.farClip:g} m is not allowed; it must be above nearClip, {values.nearClip:g} m")


def announce_blindness(model: Model) -> None:
    """Say, once a world, that cameras do all but draw."""
    if model.world not in _told:
        _told.add(model.world)
        log.warning(
            "this version of libgz draws no pictures yet: %s %r and all other cameras stay blind",
            model.GetName(),
            model.GetId(),
        )
