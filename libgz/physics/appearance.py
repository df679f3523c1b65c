"""How a geom looks, and how sensors see it: plain data that the renderer and the sensors read."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from libgz.geometry import GzColor, GzPose, GzVector

__all__ = ["RENDER_LIGHT", "RENDER_OPAQUE", "RENDER_TRANSPARENT", "Appearance", "Backdrop"]

# GZ_RENDER_*: the passes of a picture, in order.
RENDER_LIGHT, RENDER_OPAQUE, RENDER_TRANSPARENT = range(3)


@dataclass
class Appearance:
    """Colours, texture and skin of a geom; retro and fiducial for laser scanners."""

    ambient: GzColor = field(default_factory=lambda: GzColor(0.2, 0.2, 0.2))
    diffuse: GzColor = field(default_factory=lambda: GzColor(0.8, 0.8, 0.8))
    specular: GzColor = field(default_factory=lambda: GzColor(0.2, 0.2, 0.2))
    emission: GzColor = field(default_factory=GzColor)
    transparency: float = 0.0  # 0 to 1, on top of the alpha of the diffuse colour
    shininess: float = 0.0
    texture_file: Path | None = None
    texture_size: GzVector = field(default_factory=lambda: GzVector(2.0, 2.0, 0.0))  # [m] covered by one image
    skin_file: Path | None = None
    skin_pose: GzPose = field(default_factory=GzPose)  # in the frame of the geom's centre
    skin_scale: GzVector = field(default_factory=lambda: GzVector(1.0, 1.0, 1.0))
    scale: GzVector = field(default_factory=lambda: GzVector(1.0, 1.0, 1.0))  # of all that is drawn, along its own axes
    visible: bool = True  # whether the geom is drawn at all
    skin_null: bool = False  # while skins are shown, draw nothing
    skin_instead: Path | None = None  # the skin for which nothing is drawn; if it cannot be read, the shape is
    laser: float = 1.0
    retro: float = 0.0
    fiducial: int = -1
    pick_id: int = 0
    render_order: int = RENDER_OPAQUE
    version: int = 0  # grows with each change, so that a renderer knows when to rebuild

    def set_color(self, color: GzColor) -> None:
        """The material of one colour: ambient a fifth of it, specular a fifth above it."""
        self.ambient = GzColor(0.2 * color.r, 0.2 * color.g, 0.2 * color.b, color.a)
        self.diffuse = GzColor(*color)
        self.specular = GzColor(1.2 * color.r, 1.2 * color.g, 1.2 * color.b, color.a)
        self.version += 1


@dataclass
class Backdrop:
    """What a world's pictures have beside its geoms; the sky's colour and the fog's density are the world's own."""

    ambient: GzColor = field(default_factory=lambda: GzColor(0.2, 0.2, 0.2))  # light from everywhere
    fog_color: GzColor | None = None  # None: the sky's
    fog_kind: str = "exp2"  # or exp, linear
    fog_start: float = 0.0  # [m], of linear fog
    fog_end: float = 100.0  # [m], of linear fog
    lines: list[Callable[[Any], Iterable[Any]]] = field(default_factory=list)  # View -> more Lines to render
    threaded: bool = False  # whether robots' cameras render in a separate thread while physics continues
