"""Populations: many models of one kind, placed by a rule."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import Diagnostics, GazeboError, ParameterError, nearest
from libgz.base.geometry import GzCoordPositionAdd, GzPose, GzVector, GzVectorSub
from libgz.sdf.element import Element

__all__ = ["MOST_MODELS", "populate"]

if TYPE_CHECKING:
    from numpy.random import Generator as Random  # which takes as long to load as lxml

Array = NDArray[np.float64]

SPACING = 0.1  # [m] between the points that a uniform population shares out, as in Gazebo
SAMPLES = 10_000  # of them in a cylinder
MOST_MODELS = 20_000  # of all populations of a world
MOST_ELEMENTS = 2_000_000  # of these models
MOST_DISTANCES = 200_000_000  # between points and middles of a uniform population
AT_ONCE = 10_000_000  # of these that are held
ROUNDS = 100  # of k-means, at most


def populate(world: Element, random: Random, diagnostics: Diagnostics) -> list[Element]:
    """The models of all `<population>` of a `<world>`: `NAME_clone_0` and so on, each with its pose.

    A population that cannot be made is a warning, and left out, as in Gazebo.
    """
    found: list[Element] = []
    elements = 0
    for element in world.named("population"):
        try:
            added, size = _models(element, random, MOST_MODELS - len(found), MOST_ELEMENTS - elements)
            found, elements = found + added, elements + size
        except GazeboError as error:
            diagnostics.warn(element, f"{error}; the population is left out")
    return found


def _models(element: Element, random: Random, most: int, most_elements: int) -> tuple[list[Element], int]:
    """The models of a population, and how many elements they have."""
    model = _needed(element, "model")
    frame = element.Get(GzPose, "pose")
    clones: list[Element] = []
    places, middle = _places(element, random, most)
    origin = GzVectorSub(frame.pos, GzVector(*middle.tolist()))
    elements = len(places) * _count(model)
    if elements > most_elements:
        raise ParameterError(
            f"its {len(places)} models have {elements} elements; {MOST_ELEMENTS} are allowed in all populations"
        )
    for number, place in enumerate(places):
        clone = model.Clone()
        clone.parent = element.parent
        clone.set_attribute("name", f"{model.Get(str, 'name')}_clone_{number}")
        pose = clone.GetElement("pose")
        position = GzCoordPositionAdd(GzVector(*place.tolist()), origin, frame.rot)
        pose.value.SetFromString(" ".join(repr(float(value)) for value in (*position, 0.0, 0.0, 0.0)))
        clones.append(clone)
    return clones, elements


def _count(element: Element) -> int:
    """How many elements it is, with those in it."""
    number, waiting = 0, [element]
    while waiting:
        number += 1
        waiting += waiting.pop().children
    return number


def _needed(element: Element, name: str) -> Element:
    found = next(element.named(name), None)
    if found is None:
        raise ParameterError(f"Unable to find <{name}> inside the population tag")
    return found


def _places(element: Element, random: Random, most: int) -> tuple[Array, Array]:
    """Where the models, `most` at most, stand in the region [m], shape (n, 3), and where its middle is, shape (3,).

    As in Gazebo, a box or grid is put with its middle on the population's origin, then turned about its first corner.
    """
    distribution = _needed(element, "distribution")
    kind = distribution.Get(str, "type")
    if kind not in KINDS:
        raise ParameterError(f"Unknown distribution type [{kind}]; {', '.join(KINDS)} are known{nearest(kind, KINDS)}")
    if kind == "grid":
        return _grid(distribution, most)
    count = element.Get(int, "model_count")
    if not 0 < count <= most:
        raise (
            ParameterError(f"Trying to populate a non positive number of models [{count}]")
            if count <= 0
            else (ParameterError(f"<model_count> is {count}; {MOST_MODELS} at most are allowed in all populations"))
        )
    if element.HasElement("box"):
        size = np.array(element.child("box").Get(GzVector, "size"))
        if not (np.isfinite(size).all() and size.min() > 0.0):
            raise ParameterError(f"Incorrect box size while populating objects [{' '.join(map(str, size))}]")
        return KINDS[kind](count, size, random), 0.5 * size
    if not element.HasElement("cylinder"):
        raise ParameterError("I have not found a valid region. 'box' or 'cylinder' are the valid region types")
    cylinder = element.child("cylinder")
    radius, length = cylinder.Get(float, "radius"), cylinder.Get(float, "length")
    for value, what in ((radius, "radius"), (length, "length")):
        if not 0.0 < value < math.inf:
            raise ParameterError(f"Incorrect {what} value while populating objects [{value:g}]")
    if kind not in ("random", "uniform"):
        raise ParameterError(f"Unrecognized combination of region [cylinder] and distribution [{kind}]")
    return _in_cylinder(kind, count, radius, length, random), np.zeros(3)


def _grid(distribution: Element, most: int) -> tuple[Array, Array]:
    """Rows along y, columns along x, and the middle of all."""
    rows, columns = distribution.Get(int, "rows"), distribution.Get(int, "cols")
    for value, what in ((rows, "rows"), (columns, "columns")):
        if value <= 0:
            raise ParameterError(f"Incorrect number of {what} while populating objects [{value}]")
    if rows * columns > most:
        raise ParameterError(
            f"{rows} rows and {columns} columns are {rows * columns} models; "
            f"{MOST_MODELS} are allowed in all populations"
        )
    step = distribution.Get(GzVector, "step")
    y, x = np.divmod(np.arange(rows * columns), columns)
    places = np.stack([x * step.x, y * step.y, 0.0 * x], axis=1)
    return places, 0.5 * places[-1]


def _random(count: int, size: Array, random: Random) -> Array:
    return random.uniform(0.0, 1.0, (count, 3)) * size


def _uniform(count: int, size: Array, random: Random) -> Array:
    """The middles of equal shares of points that lie close in the box."""
    x, y = (np.arange(0.0, size[axis], SPACING) for axis in (0, 1))
    if len(x) * len(y) > MOST_MODELS:
        raise ParameterError(f"a box of {size[0]:g} x {size[1]:g} m is too large for a uniform population")
    across, along = (values.ravel() for values in np.meshgrid(x, y))
    return _middles(np.stack([across, along, random.uniform(0.0, size[2], len(across))], axis=1), count, random)


def _line(axis: int) -> Callable[[int, Array, Random], Array]:
    def places(count: int, size: Array, _: Random) -> Array:
        found = np.tile(0.5 * size, (count, 1))
        found[:, axis] = size[axis] * np.arange(count) / count
        return found

    return places


def _in_cylinder(kind: str, count: int, radius: float, length: float, random: Random) -> Array:
    """About the z axis, on and above the frame's origin; as in Gazebo, more of them near the axis."""
    samples = count if kind == "random" else max(SAMPLES, count)
    angle, distance = random.uniform(0.0, 2.0 * math.pi, samples), random.uniform(0.0, radius, samples)
    height = random.uniform(0.0, length, samples)
    points = np.stack([distance * np.cos(angle), distance * np.sin(angle), height], axis=1)
    return points if kind == "random" else _middles(points, count, random)


def _middles(points: Array, count: int, random: Random) -> Array:
    """The middles of so many clusters of points (k-means of Lloyd), which begin at points chosen at random."""
    if count > len(points):
        raise ParameterError(f"only {len(points)} models fit into the region, not {count}")
    if count * len(points) > MOST_DISTANCES:
        raise ParameterError(f"{count} models of {len(points)} points are too many for a uniform population")
    parts = -(-count * len(points) // AT_ONCE)
    middles: Array = points[random.choice(len(points), count, replace=False)]
    before = None
    for _ in range(ROUNDS):
        label = np.concatenate([_nearest(part, middles) for part in np.array_split(points, parts)])
        if before is not None and np.array_equal(label, before):
            break
        before = label
        sizes = np.bincount(label, minlength=count)
        sums = np.stack([np.bincount(label, points[:, axis], count) for axis in range(3)], axis=1)
        middles = np.where(sizes[:, None] > 0, sums / np.maximum(sizes, 1)[:, None], middles)
    return middles


def _nearest(points: Array, middles: Array) -> NDArray[np.int64]:
    """For each point the number of the nearest middle."""
    squares = (points**2).sum(axis=1)[:, None] - 2.0 * points @ middles.T + (middles**2).sum(axis=1)
    return np.asarray(squares.argmin(axis=1))


# How a box is populated. In a cylinder there are random and uniform ones; a grid needs no region.
KINDS: dict[str, Callable[[int, Array, Random], Array]] = {
    "random": _random,
    "uniform": _uniform,
    "grid": _random,
    "linear-x": _line(0),
    "linear-y": _line(1),
    "linear-z": _line(2),
}
