"""Shot: what an image is rendered from. Plain data, taken from a world at one moment, that does not change later."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzColor, GzPose
from libgz.physics.geom import Geom

__all__ = ["Content", "Fog", "Item", "Light", "Lines", "RenderOptions", "Shot", "View", "pose_matrices", "pose_matrix"]


@dataclass(eq=False, repr=False)
class RenderOptions:
    """What an image shows, and how."""

    displayBBox: bool = False
    displayAxes: bool = False
    displayCoM: bool = False
    displaySkins: bool = True
    displayRays: bool = False
    displayFrustrums: bool = False
    displayGrid: bool = False
    displayMaterials: bool = True
    displayTextures: bool = True
    polygonFill: bool = True
    shadeSmooth: bool = True
    shadows: bool | None = None  # None: if the world's scene asks for them; True: unless it forbids them


@dataclass(eq=False, repr=False)
class View:
    """A camera: its pose (it looks along +x, z up), optics, and what it shows."""

    pose: GzPose
    width: int  # [px]
    height: int  # [px]
    hfov: float  # horizontal field of view [rad]
    near: float  # [m]
    far: float  # [m]
    options: RenderOptions = field(default_factory=RenderOptions)

    @property
    def focal(self) -> float:
        """Focal length [px], the same in both directions."""
        return self.width / (2.0 * math.tan(self.hfov / 2.0))

    @property
    def tangents(self) -> tuple[float, float]:
        """Tangents of half the fields of view, horizontally and vertically."""
        focal = self.focal
        return self.width / (2.0 * focal), self.height / (2.0 * focal)

    def eye(self) -> NDArray[np.float64]:
        """From the world into GL's eye frame (x right, y up, z backward), shape (4, 4)."""
        ahead, left, up = zip(*_rotation(self.pose), strict=True)
        x, y, z = self.pose.pos
        rows = [tuple(-c for c in left), up, tuple(-c for c in ahead)]
        return np.array([*((a, b, c, -(a * x + b * y + c * z)) for a, b, c in rows), (0.0, 0.0, 0.0, 1.0)])

    def projection(self) -> NDArray[np.float64]:
        """From the eye frame into clip coordinates, shape (4, 4); y downwards, so that rows come out top first."""
        near, far, focal = self.near, self.far, self.focal
        return np.array(
            (
                (2.0 * focal / self.width, 0.0, 0.0, 0.0),
                (0.0, -2.0 * focal / self.height, 0.0, 0.0),
                (0.0, 0.0, -(far + near) / (far - near), -2.0 * far * near / (far - near)),
                (0.0, 0.0, -1.0, 0.0),
            )
        )


class Item(NamedTuple):
    """The geoms of one body that are rendered together."""

    geoms: tuple[Geom, ...]
    model_id: int
    key: tuple[int, ...]  # changes with the appearance of a geom
    transparent: bool = False
    casts: bool = True  # whether it casts a shadow


class Content(NamedTuple):
    """All items of a scene, in the order of their models."""

    items: tuple[Item, ...]


class Light(NamedTuple):
    """A light: position [m], colours, constant, linear, quadratic attenuation; the rest as in `LightGeom`, global."""

    position: tuple[float, float, float]
    ambient: GzColor
    diffuse: GzColor
    specular: GzColor
    attenuation: tuple[float, float, float]
    kind: str = "point"
    direction: tuple[float, float, float] = (0.0, 0.0, -1.0)
    spot: tuple[float, float, float] = (0.0, 0.0, 0.0)
    range: float = math.inf
    shadows: bool = True  # whether it makes bodies cast shadows


class Fog(NamedTuple):
    """Fog: exp, exp2 (with a density [1/m]) or linear (from start to end [m])."""

    kind: str
    color: GzColor
    density: float
    start: float
    end: float


class Lines(NamedTuple):
    """Unlit line segments of one colour: ends [m], global, shape (2 n, 3)."""

    ends: NDArray[np.float32]
    color: tuple[float, float, float]


@dataclass(eq=False, repr=False)
class Shot:
    """A view of a world at one moment."""

    view: View
    content: Content
    states: NDArray[np.float64]  # of the items: position [m] and unit quaternion (u, x, y, z), shape (n, 7)
    planes: tuple[Geom, ...]
    lights: tuple[Light, ...]
    sky: GzColor
    fog: Fog | None
    dome: tuple[Geom, float] | None  # the dome, and the time of day as a share of 24 h
    lines: tuple[Lines, ...] = ()
    ambient: GzColor = field(default_factory=lambda: GzColor(0.2, 0.2, 0.2))  # light from everywhere
    shadows: bool = False  # whether light is computed at each pixel, with shadows


def pose_matrix(pose: GzPose) -> NDArray[np.float64]:
    """A pose as a matrix, shape (4, 4)."""
    rows = zip(_rotation(pose), pose.pos, strict=True)
    return np.array([*((*row, offset) for row, offset in rows), (0.0, 0.0, 0.0, 1.0)])


def _rotation(pose: GzPose) -> tuple[tuple[float, float, float], ...]:
    """The rows of a pose's rotation matrix."""
    u, x, y, z = pose.rot
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - u * z), 2.0 * (x * z + u * y)),
        (2.0 * (x * y + u * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - u * x)),
        (2.0 * (x * z - u * y), 2.0 * (y * z + u * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def pose_matrices(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Poses as matrices, shape (n, 4, 4), from rows x, y, z, u, x, y, z: position and unit quaternion."""
    u, x, y, z = states[:, 3], states[:, 4], states[:, 5], states[:, 6]
    result = np.zeros((len(states), 4, 4))
    result[:, 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    result[:, 0, 1] = 2.0 * (x * y - u * z)
    result[:, 0, 2] = 2.0 * (x * z + u * y)
    result[:, 1, 0] = 2.0 * (x * y + u * z)
    result[:, 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    result[:, 1, 2] = 2.0 * (y * z - u * x)
    result[:, 2, 0] = 2.0 * (x * z - u * y)
    result[:, 2, 1] = 2.0 * (y * z + u * x)
    result[:, 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    result[:, :3, 3] = states[:, :3]
    result[:, 3, 3] = 1.0
    return result
