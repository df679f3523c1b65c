"""Overview: where a camera sees a whole world."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.geometry import GzPose, GzQuaternFromEuler, GzVector
from libgz.physics.engine import Engine
from libgz.physics.geoms import PlaneGeom

__all__ = ["FIELD_OF_VIEW", "overview"]

FIELD_OF_VIEW = math.radians(60.0)  # horizontal
YAW, PITCH = math.radians(35.0), math.radians(30.0)  # of the direction it looks in
LARGE = 5.0  # times the median distance; what lies or reaches farther is not in the way of the rest
NEAREST = 0.5  # [m]


class _World(Protocol):
    @property
    def engine(self) -> Engine:
        """Bodies and geoms."""


def overview(world: _World, aspect: float = 4.0 / 3.0) -> GzPose:
    """A pose from which a camera with `FIELD_OF_VIEW` sees all that moves, and what stands around it.

    Args:
        world: with an engine.
        aspect: width of the image by its height.
    """
    boxes = _boxes(world.engine)
    if not len(boxes):
        boxes = np.array([[-1.0, -1.0, 0.0, 1.0, 1.0, 1.0]], dtype=np.float64)
    low, high = boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)
    centre, radius = (low + high) / 2.0, max(float(np.linalg.norm(high - low)) / 2.0, NEAREST)
    half = min(FIELD_OF_VIEW / 2.0, math.atan(math.tan(FIELD_OF_VIEW / 2.0) / aspect))
    away = radius / math.sin(half)
    ahead = np.array([math.cos(PITCH) * math.cos(YAW), math.cos(PITCH) * math.sin(YAW), -math.sin(PITCH)])
    x, y, z = (float(part) for part in centre - away * ahead)
    return GzPose(GzVector(x, y, z), GzQuaternFromEuler(0.0, PITCH, YAW))


def _boxes(engine: Engine) -> NDArray[np.float64]:
    """Corners of what can be seen, shape (n, 6), without grounds and what is far from all else."""
    moving: list[list[float]] = []
    fixed: list[list[float]] = []
    for geom in engine.geoms.values():
        low, high = geom.bounds()
        box = [*low, *high]
        if isinstance(geom, PlaneGeom) or low == high or not geom.appearance.visible or not np.isfinite(box).all():
            continue
        (fixed if geom.body.dummy else moving).append(box)
    chosen: NDArray[np.float64] = np.array(moving or fixed, dtype=np.float64).reshape(-1, 6)
    if len(chosen) > 2:
        centres = (chosen[:, :3] + chosen[:, 3:]) / 2.0
        distances = np.linalg.norm(centres - np.median(centres, axis=0), axis=1)
        limit = LARGE * max(float(np.median(distances)), 1.0)
        chosen = chosen[distances <= limit]
    return chosen
