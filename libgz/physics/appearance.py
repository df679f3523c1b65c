"""How a geom looks, and how sensors see it: plain data that the renderer and the sensors read."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import islice
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

from libgz.base.errors import StateError
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector

__all__ = ["RENDER_LIGHT", "RENDER_OPAQUE", "RENDER_TRANSPARENT", "SAME", "Appearance", "Backdrop", "Surface"]

# GZ_RENDER_*: the passes of a frame, in order.
RENDER_LIGHT, RENDER_OPAQUE, RENDER_TRANSPARENT = range(3)
SAME = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)  # the matrix of textures that are neither scaled, turned nor moved


class Surface(NamedTuple):
    """How a surface reflects, by SDF's `<pbr>`: shares from 0 to 1, and images. Only pages show it."""

    metalness: float
    roughness: float
    normal_map: Path | None = None
    metalness_map: Path | None = None
    roughness_map: Path | None = None
    emissive_map: Path | None = None


@dataclass(eq=False, repr=False)
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
    texture_matrix: tuple[float, ...] = SAME  # of texture coordinates: u' = a u + b v + c, v' = d u + e v + f
    alpha_rejection: float = 0.0  # what of the image has no more alpha than that is not rendered, 0 to 1
    skin_file: Path | None = None
    skin_pose: GzPose = field(default_factory=GzPose)  # in the frame of the geom's centre
    skin_scale: GzVector = field(default_factory=lambda: GzVector(1.0, 1.0, 1.0))
    scale: GzVector = field(default_factory=lambda: GzVector(1.0, 1.0, 1.0))  # of the rendered shape, along its axes
    visible: bool = True  # whether the geom is rendered at all
    skin_null: bool = False  # while skins are shown, the geom is not rendered
    skin_instead: Path | None = None  # the skin that replaces the shape; if it cannot be read, the shape is rendered
    cast_shadows: bool = True  # where images have shadows; what is transparent casts none
    laser: float = 1.0
    retro: float = 0.0
    fiducial: int = -1
    surface: Surface | None = None  # from the world file; it never changes
    pick_id: int = 0
    render_order: int = RENDER_OPAQUE
    version: int = 0  # grows with each change; a renderer then rebuilds the geom

    def set_color(self, color: GzColor) -> None:
        """The material of one colour: ambient a fifth of it, specular a fifth above it."""
        self.change(
            ambient=GzColor(0.2 * color.r, 0.2 * color.g, 0.2 * color.b, color.a),
            diffuse=GzColor(*color),
            specular=GzColor(1.2 * color.r, 1.2 * color.g, 1.2 * color.b, color.a),
        )

    def change(self, **values: object) -> None:
        """Set attributes, and let renderers rebuild the geom."""
        for name, value in values.items():
            setattr(self, name, value)
        self.version += 1

    def saved(self) -> list[Any]:
        """All of it but the version, for a state: numbers as bytes, paths as texts, and the rest."""
        files = [None if file is None else str(file) for file in _files_of(self)]
        return [_NUMBERS.pack(*_numbers_of(self)), files, [*_rest_of(self)]]

    def restore(self, packed: bytes, files: list[Any], rest: list[Any]) -> None:
        """Take what `saved` returned, which may be damaged: then nothing changes.

        Raises:
            StateError: it is not what a look has.
        """
        kinds = [*map(type, rest)], [*map(type, _rest_of(self))]
        if (
            kinds[0] != kinds[1]
            or len(files) != len(_FILES)
            or any(not isinstance(f, (str, type(None))) for f in files)
        ):
            raise StateError("the state is damaged: a geom has other looks")
        numbers, present = iter(_NUMBERS.unpack(packed)), iter(_numbers_of(self))
        for name, (make, parts) in _PARTS.items():
            values, former = ([*islice(source, len(parts) or 1)] for source in (numbers, present))
            if [*map(float.hex, values)] != [float(number).hex() for number in former]:  # to the sign of a zero
                setattr(self, name, make(*values))
        for name, file in zip(_FILES, files, strict=True):
            setattr(self, name, None if file is None else Path(file))
        for name, number in zip(_REST, rest, strict=True):
            setattr(self, name, number)


def _pose(*numbers: float) -> GzPose:
    return GzPose(GzVector(*numbers[:3]), GzQuatern(*numbers[3:]))


# What makes an attribute of numbers, and their names in it.
_PARTS: dict[str, tuple[Callable[..., Any], tuple[str, ...]]] = {
    **dict.fromkeys(("ambient", "diffuse", "specular", "emission"), (GzColor, ("r", "g", "b", "a"))),
    **dict.fromkeys(("texture_size", "skin_scale", "scale"), (GzVector, ("x", "y", "z"))),
    "skin_pose": (_pose, (*(f"pos.{axis}" for axis in "xyz"), *(f"rot.{axis}" for axis in "uxyz"))),
    **dict.fromkeys(("transparency", "shininess", "laser", "retro"), (float, ())),
}
_numbers_of = attrgetter(
    *(f"{name}.{part}" if part else name for name, (_, parts) in _PARTS.items() for part in parts or ("",))
)
_NUMBERS = struct.Struct(f"{sum(len(parts) or 1 for _, parts in _PARTS.values())}d")
_FILES = ("texture_file", "skin_file", "skin_instead")
_files_of = attrgetter(*_FILES)
_REST = ("visible", "skin_null", "cast_shadows", "fiducial", "pick_id", "render_order")
_rest_of = attrgetter(*_REST)


@dataclass(eq=False, repr=False)
class Backdrop:
    """What frames show beside the geoms; the sky's colour and the fog's density are those of the world."""

    ambient: GzColor = field(default_factory=lambda: GzColor(0.2, 0.2, 0.2))  # light from everywhere
    fog_color: GzColor | None = None  # None: the sky's
    fog_kind: str = "exp2"  # or exp, linear
    fog_start: float = 0.0  # [m], of linear fog
    fog_end: float = 100.0  # [m], of linear fog
    shadows: bool | None = None  # whether images have shadows; None: only those of cameras that ask for them
    lines: list[Callable[[Any], Iterable[Any]]] = field(default_factory=list)  # View -> more Lines to render
    threaded: bool = False  # whether robots' cameras render in a separate thread while physics continues
