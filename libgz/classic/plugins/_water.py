"""Water with a surface: waves, and the part of a shape that is below them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.classic.math import Vector2d, Vector3d

if TYPE_CHECKING:
    from collections.abc import Sequence

    from libgz.classic.math import Pose3d
    from libgz.sdf.element import Element

__all__ = ["Hull", "Wave", "height", "hull_of", "waves_of"]

MOST_WAVES = 100
LARGEST_CHANGE = 100.0  # the logarithm of the last amplitude of a group over the first
CELLS = 8  # of a hull in each direction
GRAVITY = 9.8  # [m/s^2] of the dispersion of waves


class Wave(NamedTuple):
    """A plane wave of deep water: amplitude * cos(k (direction . place) - omega t + phase), k = omega^2 / g.

    Attributes:
        amplitude: [m].
        omega: angular frequency [rad/s].
        direction: in which it runs, of length 1.
        phase: [rad].
    """

    amplitude: float
    omega: float
    direction: tuple[float, float]
    phase: float


def waves_of(*elements: Element) -> list[Wave]:
    """The waves of all `<wave>` in some elements.

    Each may stand for `<number>` waves: number i of n, counted from the middle, has `<scale>`^i times the amplitude,
    1 / sqrt(scale^i) times the frequency, and a direction that is turned by i `<angle>`.

    Raises:
        ParameterError: a period is not positive, a direction has no length, or there are more than 100 waves.
    """
    found: list[Wave] = []
    for element in (wave for sdf in elements for wave in sdf.named("wave")):
        found += _group(element)
        if len(found) > MOST_WAVES:
            raise ParameterError(f"{element.where}: there are more than {MOST_WAVES} waves")
    return found


def _group(element: Element) -> list[Wave]:
    amplitude, period = element.Get(float, "amplitude", 0.0)[0], element.Get(float, "period", 5.0)[0]
    direction = element.Get(Vector2d, "direction", Vector2d(1.0, 0.0))[0]
    scale, angle = element.Get(float, "scale", 1.0)[0], element.Get(float, "angle", 0.0)[0]
    count, phase = element.Get(int, "number", 1)[0], element.Get(float, "phase", 0.0)[0]
    length = math.hypot(*direction)
    finite = all(map(math.isfinite, (amplitude, period, scale, angle, phase, length)))
    allowed = finite and period > 0.0 and scale > 0.0 and length > 0.0 and 0 <= count <= MOST_WAVES
    if not (allowed and abs(math.log(scale)) * count < LARGEST_CHANGE):
        raise ParameterError(
            f"{element.where}: <wave> needs a <period> and a <scale> above 0, a <direction> that is not zero, a "
            f"<number> from 0 to {MOST_WAVES}, and a <scale> that leads to usable amplitudes"
        )
    heading = math.atan2(direction[1], direction[0])
    waves = []
    for i in range(count):
        share = scale ** (i - (count - 1) / 2)
        way = heading + angle * (i - (count - 1) / 2)
        omega = 2.0 * math.pi / period / math.sqrt(share)
        waves.append(Wave(amplitude * share, omega, (math.cos(way), math.sin(way)), phase))
    return waves


def height(waves: Sequence[Wave], x: Any, y: Any, time: float) -> Any:
    """The height of the surface above its mean at places [m]."""
    total = np.zeros(np.shape(x))
    for wave in waves:
        along = wave.direction[0] * x + wave.direction[1] * y
        total = total + wave.amplitude * np.cos(wave.omega**2 / GRAVITY * along - wave.omega * time + wave.phase)
    return total


class Hull:
    """A shape as small boxes, for the part that is below water.

    Attributes:
        points: centres of the boxes in the shape's frame [m], shape (n, 3).
        volumes: of each [m^3], shape (n,).
        sides: of each [m].
    """

    def __init__(self, points: NDArray[np.float64], volume: float, sides: Sequence[float]) -> None:
        self.points, self.sides = points, np.array(sides)
        self.volumes = np.full(len(points), volume / len(points))
        self.volume = volume

    def submerged(self, pose: Pose3d, level: float, waves: Sequence[Wave], time: float) -> tuple[float, Vector3d]:
        """The volume below the surface [m^3], and its centre in the world's frame [m]; the shape's pose is given."""
        axes = np.array([list(pose.Rot().RotateVector(Vector3d(*axis))) for axis in np.eye(3)])
        places = self.points @ axes + np.array(list(pose.Pos()))
        tall = float(np.abs(axes[:, 2]) @ self.sides)  # of a small box along the vertical
        surface = level + height(waves, places[:, 0], places[:, 1], time)
        shares = np.clip((surface - places[:, 2]) / tall + 0.5, 0.0, 1.0)
        wet = self.volumes * shares
        total = float(wet.sum())
        if not total > 0.0:
            return 0.0, Vector3d()
        places[:, 2] += np.minimum(0.0, (shares - 1.0) * tall / 2.0)  # the centre of its part below
        return total, Vector3d(*(wet @ places / total))


def hull_of(geometry: Element) -> Hull:
    """The hull of a `<geometry>`: a box, cylinder or sphere.

    Raises:
        ParameterError: it is none of these, or a size is not positive.
    """
    for name, read in (("box", _box), ("cylinder", _cylinder), ("sphere", _sphere)):
        shape = next(geometry.named(name), None)
        if shape is not None:
            sides, volume, inside = read(shape)
            if not (min(sides) > 0.0 and math.isfinite(volume)):
                raise ParameterError(f"{shape.where}: the sizes of <{name}> must be positive")
            steps = (np.arange(CELLS) + 0.5) / CELLS - 0.5
            grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
            return Hull(grid[inside(grid)] * np.array(sides), volume, [side / CELLS for side in sides])
    raise ParameterError(f"{geometry.where}: <geometry> has no <box>, <cylinder> or <sphere>")


def _box(shape: Element) -> Any:
    sides = list(shape.Get(Vector3d, "size"))
    return sides, math.prod(sides), lambda grid: np.full(len(grid), True)


def _cylinder(shape: Element) -> Any:
    radius, length = shape.Get(float, "radius"), shape.Get(float, "length")
    return (
        [2.0 * radius, 2.0 * radius, length],
        math.pi * radius**2 * length,
        lambda grid: np.hypot(grid[:, 0], grid[:, 1]) <= 0.5,
    )


def _sphere(shape: Element) -> Any:
    radius = shape.Get(float, "radius")
    return [2.0 * radius] * 3, 4.0 / 3.0 * math.pi * radius**3, lambda grid: (grid**2).sum(axis=1) <= 0.25
