"""Points of a scan in rows, in the frame of its sensor."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["directions", "scan_points"]


def directions(sensor: Any) -> NDArray[np.float64]:
    """The directions of all readings of a laser; shape (rows, columns, 3)."""
    across = np.linspace(sensor.AngleMin().Radian(), sensor.AngleMax().Radian(), sensor.RangeCount())
    upward = np.linspace(
        sensor.VerticalAngleMin().Radian(), sensor.VerticalAngleMax().Radian(), sensor.VerticalRangeCount()
    )
    yaw, pitch = np.meshgrid(across, upward)
    return np.stack([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)], axis=-1)


def scan_points(sensor: Any, along: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points of the last scan [m]; shape (rows * columns, 3). Readings that are infinite give no finite point."""
    ranges = np.asarray(sensor.ranges(), np.float64).reshape(along.shape[:2])
    with np.errstate(invalid="ignore"):
        points: NDArray[np.float64] = (ranges[..., None] * along).reshape(-1, 3)
    return points
