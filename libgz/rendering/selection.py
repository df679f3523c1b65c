"""Selection: which items a view shows, where, and in what detail; natively (frame.c), or by equal arithmetic here."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from ctypes import c_double, c_int64, c_void_p
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import LibraryError
from libgz.base.geometry import rotate
from libgz.physics.geom import Geom
from libgz.physics.geoms import CylinderGeom
from libgz.rendering.geom_meshes import round_radius
from libgz.rendering.native import address, find_native
from libgz.rendering.shot import Content, Item, View, pose_matrices

__all__ = ["FINE", "LARGE", "LEVELS", "SMALL", "TINY", "LocalLight", "Rounds", "Selection", "Selector"]

# Levels of detail: segments of a full turn. Bodies have one of three by their size in the image, round bodies of
# classic worlds the one with which depth is right.
LEVELS = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 2048, 4096)
TINY, SMALL, LARGE, FINE = 0, 1, 4, 11  # places in LEVELS; above the last one, lists are large
TINY_RADIUS, SMALL_RADIUS = 6.0, 30.0  # [px] up to which a body is tiny, and small
DEPTH_ERROR = 1e-3  # of round geoms of classic worlds, as a share of the distance
MOST_FACETS = 1024**2  # of an item's spheres, capsules and wheels, on levels above FINE

Floats = NDArray[np.float64]
Places = NDArray[np.int64]


class LocalLight(NamedTuple):
    """A light with a range: OpenGL's number, its place in the eye frame [m], and the range [m]."""

    number: int
    place: tuple[float, float, float]
    range: float


class Rounds:
    """The round geoms of a content, see `round_radius`.

    Attributes:
        items: the place of each one's item in the content, in ascending order.
        centres, halves: its centre, and half of its axis, in the frame of its body [m], shape (n, 3).
        radii: [m].
        slacks: 2 for cylinders, which are off by half as much as what is round in two directions; 1 for all others.
        finest: the place in `LEVELS` of the finest level of its item. Facets of cylinders grow with the segments,
            of all others with their square, up to `MOST_FACETS` in an item.
    """

    def __init__(self, content: Content) -> None:
        found = [(i, geom) for i, item in enumerate(content.items) for geom in item.geoms if round_radius(geom)]
        self.items = np.array([i for i, _ in found], dtype=np.int64)
        self.radii = np.array([round_radius(geom) for _, geom in found], dtype=np.float64)
        self.slacks = np.array([2.0 if _is_cylinder(geom) else 1.0 for _, geom in found], dtype=np.float64)
        self.centres, self.halves = np.zeros((len(found), 3)), np.zeros((len(found), 3))
        for k, (_, geom) in enumerate(found):
            place = geom.GetRelativePose()
            length = getattr(geom, "length", 0.0) * abs(geom.appearance.scale.z)
            self.centres[k], self.halves[k] = (*place.pos,), rotate(place.rot, (0.0, 0.0, 0.5 * length))
        last = [_finest(item) for item in content.items]
        self.finest = np.array([last[i] for i, _ in found], dtype=np.int64)


def _is_cylinder(geom: Geom) -> bool:
    return type(geom) is CylinderGeom


def _finest(item: Item) -> int:
    squares = sum(1 for geom in item.geoms if round_radius(geom) and not _is_cylinder(geom))
    fitting = [level for level in range(FINE, len(LEVELS)) if squares * LEVELS[level] ** 2 <= MOST_FACETS]
    return max(fitting, default=FINE)


class Selection(NamedTuple):
    """What a view shows.

    Attributes:
        matrices: of all items, into the eye frame, by columns, shape (n, 16).
        places: of the items that the view shows, ascending.
        levels: the places of their levels of detail in `LEVELS`.
        dark: a bit for each local light out of whose range they are.
    """

    matrices: Floats
    places: Places
    levels: Places
    dark: Places


class SelectionRecord(ctypes.Structure):
    """`selection` of frame.c."""

    _fields_ = (
        ("eye", c_double * 16),
        ("near", c_double),
        ("far", c_double),
        ("across", c_double),
        ("up", c_double),
        ("across_slant", c_double),
        ("up_slant", c_double),
        ("focal", c_double),
        ("states", c_void_p),
        ("radii", c_void_p),
        ("count", c_int64),
        ("round_items", c_void_p),
        ("round_centres", c_void_p),
        ("round_halves", c_void_p),
        ("round_radii", c_void_p),
        ("round_slacks", c_void_p),
        ("round_finest", c_void_p),
        ("round_count", c_int64),
        ("segments", c_void_p),
        ("level_small", c_int64),
        ("level_large", c_int64),
        ("tiny", c_double),
        ("small", c_double),
        ("depth_error", c_double),
        ("lights", c_void_p),
        ("light_count", c_int64),
        ("matrices", c_void_p),
        ("places", c_void_p),
        ("levels", c_void_p),
        ("dark", c_void_p),
    )


class Selector:
    """Selects among the items of one content.

    Args:
        radii: of the balls around the origins of the items' bodies that contain them [m].
        rounds: the round geoms of the items.
        native: frame.c; None for the form in Python.

    Raises:
        LibraryError: frame.c was built from another version.
    """

    def __init__(self, radii: Floats, rounds: Rounds, native: ctypes.CDLL | None) -> None:
        self.radii, self.rounds = np.ascontiguousarray(radii, dtype=np.float64), rounds
        self._segments = np.array(LEVELS, dtype=np.float64)
        self._select: Any = None
        if native is not None:
            native.gz_selection_size.restype = ctypes.c_size_t
            if native.gz_selection_size() != ctypes.sizeof(SelectionRecord):
                raise LibraryError("_frame.so was built from another version of frame.c; install libgz again")
            native.gz_select.restype = c_int64
            self._select, self._record = native.gz_select, self._new_record()
            start: Any = self._record
            self._eye = np.frombuffer(start, count=16).reshape(4, 4)

    def _new_record(self) -> SelectionRecord:
        rounds = self.rounds
        return SelectionRecord(
            radii=self.radii.ctypes.data,
            count=len(self.radii),
            round_items=rounds.items.ctypes.data,
            round_centres=rounds.centres.ctypes.data,
            round_halves=rounds.halves.ctypes.data,
            round_radii=rounds.radii.ctypes.data,
            round_slacks=rounds.slacks.ctypes.data,
            round_finest=rounds.finest.ctypes.data,
            round_count=len(rounds.items),
            segments=self._segments.ctypes.data,
            level_small=SMALL,
            level_large=LARGE,
            tiny=TINY_RADIUS,
            small=SMALL_RADIUS,
            depth_error=DEPTH_ERROR,
        )

    def select(self, view: View, eye: Floats, states: Floats, lights: Sequence[LocalLight]) -> Selection:
        """What a view shows.

        Args:
            view: the camera.
            eye: from the world into the eye frame, shape (4, 4).
            states: of all items: position [m] and quaternion (u, x, y, z), shape (n, 7).
            lights: at most 63.
        """
        if self._select is None:
            return self._select_here(view, eye, states, lights)
        record = self._record
        self._eye[:] = eye
        across, up = view.tangents
        record.near, record.far, record.focal = view.near, view.far, view.focal
        record.across, record.across_slant = across, math.hypot(1.0, across)
        record.up, record.up_slant = up, math.hypot(1.0, up)
        record.states = address(states) if len(states) else None
        record.light_count = len(lights)
        if lights:
            flat = (c_double * (4 * len(lights)))(*(number for k in lights for number in (*k.place, k.range)))
            record.lights = ctypes.addressof(flat)
        matrices, (places, levels, dark) = np.empty((len(states), 16)), np.empty((3, len(states)), dtype=np.int64)
        if len(states):
            record.matrices, record.places = address(matrices), address(places)
            record.levels, record.dark = address(levels), address(dark)
        count = self._select(ctypes.byref(record))
        return Selection(matrices, places[:count], levels[:count], dark[:count])

    def _select_here(self, view: View, eye: Floats, states: Floats, lights: Sequence[LocalLight]) -> Selection:
        matrices, radii = place(eye, states), self.radii
        x, y, z = matrices[:, :3, 3].T
        across, up = view.tangents
        seen = (radii - z >= view.near) & (-z - radii <= view.far)
        seen &= np.abs(x) + across * z <= radii * math.hypot(1.0, across)
        seen &= np.abs(y) + up * z <= radii * math.hypot(1.0, up)
        places = np.flatnonzero(seen)
        pixels = radii[places] * view.focal / np.maximum(-z[places], view.near)
        levels = np.where(pixels <= TINY_RADIUS, TINY, np.where(pixels <= SMALL_RADIUS, SMALL, LARGE))
        if len(self.rounds.items):
            finer = np.full(len(radii), -1)
            needed = needed_segments(view, matrices, self.rounds)
            finest = np.minimum(np.searchsorted(self._segments, needed), self.rounds.finest)
            np.maximum.at(finer, self.rounds.items, finest)
            levels = np.where(finer[places] >= 0, finer[places], levels)
        dark = np.zeros(len(places), dtype=np.int64)
        for k, light in enumerate(lights):
            dx, dy, dz = (light.place[axis] - matrices[places, axis, 3] for axis in range(3))
            reach = light.range + radii[places]
            dark |= (dx * dx + dy * dy + dz * dz > reach * reach).astype(np.int64) << k
        columns = np.ascontiguousarray(matrices.transpose(0, 2, 1)).reshape(-1, 16)
        return Selection(columns, places, levels.astype(np.int64), dark)


def place(eye: Floats, states: Floats) -> Floats:
    """The matrices of items into the eye frame, shape (n, 4, 4), from `eye`, shape (4, 4), and states, shape (n, 7)."""
    poses = pose_matrices(states)
    result = np.zeros_like(poses)
    for row in range(3):
        by = eye[row].tolist()
        result[:, row] = by[0] * poses[:, 0] + by[1] * poses[:, 1] + by[2] * poses[:, 2]
        result[:, row, 3] += by[3]
    result[:, 3, 3] = 1.0
    return result


def needed_segments(view: View, matrices: Floats, rounds: Rounds) -> Floats:
    """Segments with which depth of round geoms is right up to `DEPTH_ERROR`.

    With n segments, a mesh that is fitted to a radius r is off by up to e = r pi^2 / (2 n^2). Depth is off by e at the
    nearest point, and, half a pixel from the limb, by e times the square root of the radius in pixels; of shapes that
    are near, by what `_steepest` has.
    """
    back, radii = matrices[rounds.items, 2], rounds.radii
    centres, halves = rounds.centres, rounds.halves
    depth = -(back[:, 0] * centres[:, 0] + back[:, 1] * centres[:, 1] + back[:, 2] * centres[:, 2]) - back[:, 3]
    reach = radii + np.abs(back[:, 0] * halves[:, 0] + back[:, 1] * halves[:, 1] + back[:, 2] * halves[:, 2])
    gaps = np.maximum(depth - reach, view.near)
    distances = gaps + radii
    limbs = distances / np.sqrt(radii * view.focal / distances)
    limits = np.minimum(np.minimum(gaps, limbs), rounds.slacks * _steepest(view, matrices, rounds))
    allowed = DEPTH_ERROR * limits / radii
    return np.where(depth + reach < view.near, 0.0, math.pi / np.sqrt(2.0 * np.maximum(allowed, 1e-9)))


def _steepest(view: View, matrices: Floats, rounds: Rounds) -> Floats:
    """The least t c [m] of rays that meet a near round geom: t is the range, c the cosine of the angle to the normal.

    Depth is off by the share e / (t c), where the mesh is off by e. In a plane through a circle's middle at D, with
    tangents of length L = sqrt(D^2 - r^2), t c = c L^2 / (sqrt(L^2 + r^2 c^2) + r c). It falls towards the limb, so the
    ray that is farthest from the middle decides. One pixel, seen at an angle a from the line of sight with a focal
    length of f pixels, is cos(a)^2 / f [rad] wide, and a ray one pixel from the limb has c^2 = 2 L cos(a)^2 / (r f).
    Where the corners of the image are nearer to a sphere's middle than its limb, they decide. There is no limit, so
    infinity, if all that faces the camera is nearer than the near plane.

    Seen from beyond the end of its axis, a side is seen at a flat angle. t c is that of the projection along the axis,
    where D is the distance to the axis' line, and a pixel as wide as before; the part of a side that is less than a
    pixel wide is left out.
    """
    poses = matrices[rounds.items]
    centres, halves, radii = rounds.centres, rounds.halves, rounds.radii
    middle, half = np.empty_like(centres), np.empty_like(centres)
    for row in range(3):
        by = poses[:, row]
        middle[:, row] = by[:, 0] * centres[:, 0] + by[:, 1] * centres[:, 1] + by[:, 2] * centres[:, 2] + by[:, 3]
        half[:, row] = by[:, 0] * halves[:, 0] + by[:, 1] * halves[:, 1] + by[:, 2] * halves[:, 2]
    # The points of the axis, and of its line, that are nearest to the camera.
    square, along = _dot(half, half), _dot(middle, half)
    line = np.where(square > 0.0, -along / np.where(square > 0.0, square, 1.0), 0.0)
    share = np.clip(line, -1.0, 1.0)
    point, foot = middle + share[:, None] * half, middle + line[:, None] * half
    width, up = view.tangents
    corner = 1.0 / math.sqrt(1.0 + width * width + up * up)
    away = _dot(point, point)
    tangent = away - radii * radii
    seen = tangent > view.near * view.near
    away, tangent = np.where(seen, away, 1.0), np.where(seen, tangent, 1.0)
    distance, length = np.sqrt(away), np.sqrt(tangent)
    cosine = -point[:, 2] / distance
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    angle = np.maximum(cosine * length / distance - sine * radii / distance, corner)
    pixel = 2.0 * angle * angle / (radii * view.focal)
    facing = np.minimum(pixel * length, 1.0)
    farthest = cosine * corner - sine * math.sqrt(1.0 - corner * corner)
    cut = (square == 0.0) & (farthest > length / distance)
    inside = 1.0 - away / (radii * radii) * (1.0 - farthest * farthest)
    facing = np.where(cut & (inside > facing), inside, facing)
    result = _least(facing, radii, tangent)
    across = np.sqrt(_dot(foot, foot))
    beyond = (line != share) & (across > radii)
    across = np.maximum(across, radii + np.sqrt((line - share) * (line - share) * square) / view.focal)
    flat = np.where(beyond, across * across - radii * radii, 1.0)
    wide = np.minimum(pixel * np.sqrt(flat) * distance / across, 1.0)
    result = np.where(beyond, np.minimum(_least(wide, radii, flat), result), result)
    return np.where(seen, result, math.inf)


def _least(facing: Floats, radii: Floats, tangents: Floats) -> Floats:
    """t c of a ray, see `_steepest`, from c^2 and L^2."""
    side = radii * np.sqrt(facing)
    return np.sqrt(facing) * tangents / (np.sqrt(tangents + side * side) + side)


def _dot(one: Floats, other: Floats) -> Floats:
    return one[:, 0] * other[:, 0] + one[:, 1] * other[:, 1] + one[:, 2] * other[:, 2]


def new_selector(radii: Floats, content: Content) -> Selector:
    """A selector in the native form, where that was built."""
    return Selector(radii, Rounds(content), find_native())
