"""Skeletons of COLLADA files: bones, skins that they bend, and animations of them.

Bones are rigid: what a file scales is applied to the distances between them and to the skin. Matrices are (4, 4), and
multiply columns.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError
from libgz.base.files import is_file
from libgz.ode.bones import blend_bones, join_bones
from libgz.physics.mesh_files import Collada, reading, step_matrix
from libgz.physics.mesh_parts import Texture

__all__ = ["Figure", "SkeletonAnimation", "SkinPart", "matrix_turns", "read_figure", "turn_matrices"]

Array = NDArray[np.float64]

INFLUENCES = 4  # bones that move one vertex
MOST_KEYS = 100_000  # of an animation


@dataclass(frozen=True, eq=False)
class SkinPart:
    """A piece of a skin: vertices [m] as the skeleton rests, shape (n, 3), and the bones that move each of them.

    Attributes:
        bones, weights: of each vertex, shape (n, 4); weights add up to 1.
        inverse_binds: from the skin into the frame of each bone of the skeleton, shape (k, 4, 4).
        texture: the image that it shows, if the file names one.
    """

    vertices: Array
    triangles: NDArray[np.int64]
    bones: NDArray[np.int64]
    weights: Array
    inverse_binds: Array
    color: tuple[float, ...] | None = None
    texture: Texture | None = None


@dataclass(frozen=True, eq=False)
class SkeletonAnimation:
    """Poses of all bones in the frames of their parents, at common times.

    Attributes:
        times: [s], shape (m,), growing.
        positions: [m], shape (m, k, 3).
        turns: quaternions (u, x, y, z), shape (m, k, 4).
    """

    name: str
    times: Array
    positions: Array
    turns: Array

    @property
    def length(self) -> float:
        """The time of the last key [s]."""
        return float(self.times[-1])

    def at(self, time: float, loop: bool = True) -> tuple[Array, Array]:
        """(positions, turns) at a time [s], which begins again at the end; shapes (k, 3) and (k, 4)."""
        length = self.length
        if time > length:
            time = time % length if loop and length > 0.0 else length
        if len(self.times) == 1:
            return self.positions[0], self.turns[0]
        after = min(max(int(self.times.searchsorted(time)), 1), len(self.times) - 1)
        start, end = self.times[after - 1 : after + 1].tolist()
        share = min(max((time - start) / (end - start), 0.0), 1.0)
        before = self.positions[after - 1], self.turns[after - 1]
        return blend_bones(before, (self.positions[after], self.turns[after]), share)

    def at_x(self, x: float) -> tuple[Array, Array]:
        """The same where the root has come as far along x [m]; it begins again at the end.

        An animation whose root does not move along x stays at its begin.
        """
        way = self.positions[:, 0, 0]
        first, last = float(way[0]), float(way[-1])
        if last <= max(first, 0.0):
            return self.at(float(self.times[0]))
        x = max(x, first)
        if x > last:
            x = x % last
        after = int(np.argmax(way >= x)) if (way >= x).any() else len(way) - 1
        if after == 0 or way[after] == way[after - 1]:
            return self.at(float(self.times[after]))
        share = (x - way[after - 1]) / (way[after] - way[after - 1])
        return self.at(float(self.times[after - 1] + share * (self.times[after] - self.times[after - 1])))

    def scaled(self, scale: float) -> SkeletonAnimation:
        """The same for bones of another size."""
        return replace(self, positions=self.positions * scale)


@dataclass(frozen=True, eq=False)
class Figure:
    """A skeleton with its skin and animations.

    Attributes:
        names: of the bones; the first is the root, and parents come before their children.
        parents: the place of each bone's parent; -1 for the root.
        positions, turns: how the bones rest in the frames of their parents, shapes (k, 3) and (k, 4).
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    positions: Array
    turns: Array
    skin: tuple[SkinPart, ...]
    animations: tuple[SkeletonAnimation, ...]

    def scaled(self, scale: float) -> Figure:
        """The same of another size."""
        skin = []
        for part in self.skin:
            inverse_binds = part.inverse_binds.copy()
            inverse_binds[:, :3, 3] *= scale
            skin.append(replace(part, vertices=part.vertices * scale, inverse_binds=inverse_binds))
        animations = tuple(animation.scaled(scale) for animation in self.animations)
        return replace(self, positions=self.positions * scale, skin=tuple(skin), animations=animations)

    def world(self, place: Array, rotation: Array, positions: Array, turns: Array) -> tuple[Array, Array]:
        """Global (positions, turns) of all bones, from the root's and what `SkeletonAnimation.at` returns."""
        return join_bones(self._parents, positions, turns, place, rotation)

    @functools.cached_property
    def _parents(self) -> NDArray[np.int64]:
        return np.array(self.parents, dtype=np.int64)

    def fits(self, other: Figure) -> bool:
        """Whether animations of another skeleton fit this one: as many bones, with as many children each."""
        counts = [[figure.parents.count(bone) for bone in range(len(figure.parents))] for figure in (self, other)]
        return counts[0] == counts[1]


def turn_matrices(turns: Array) -> Array:
    """Quaternions (u, x, y, z) as matrices without a translation, shape (n, 4, 4)."""
    turns = np.asarray(turns, dtype=np.float64)
    u, x, y, z = (turns[..., i] for i in range(4))
    result = np.zeros((*u.shape, 4, 4))
    result[..., 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    result[..., 0, 1] = 2.0 * (x * y - u * z)
    result[..., 0, 2] = 2.0 * (x * z + u * y)
    result[..., 1, 0] = 2.0 * (x * y + u * z)
    result[..., 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    result[..., 1, 2] = 2.0 * (y * z - u * x)
    result[..., 2, 0] = 2.0 * (x * z - u * y)
    result[..., 2, 1] = 2.0 * (y * z + u * x)
    result[..., 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    result[..., 3, 3] = 1.0
    return result


def matrix_turns(matrices: Array) -> Array:
    """The rotations of matrices as quaternions (u, x, y, z), shape (n, 4); lengths of axes do not matter.

    Of the four ways to compute one (Shepperd, 1978) the one that divides by the largest number is taken.
    """
    turn = np.array(matrices[..., :3, :3], dtype=np.float64)
    turn /= np.maximum(np.linalg.norm(turn, axis=-2, keepdims=True), 1e-300)
    turn[np.linalg.det(turn) < 0.0] *= -1.0  # mirrored
    xx, yy, zz = turn[..., 0, 0], turn[..., 1, 1], turn[..., 2, 2]
    a, b, c = (turn[..., i, j] for i, j in ((2, 1), (0, 2), (1, 0)))
    d, e, f = (turn[..., i, j] for i, j in ((1, 2), (2, 0), (0, 1)))
    ways = np.empty((*turn.shape[:-2], 4, 4))
    rows = (
        (1.0 + xx + yy + zz, a - d, b - e, c - f),
        (a - d, 1.0 + xx - yy - zz, f + c, b + e),
        (b - e, f + c, 1.0 - xx + yy - zz, a + d),
        (c - f, b + e, a + d, 1.0 - xx - yy + zz),
    )
    for i, row in enumerate(rows):
        for j, value in enumerate(row):
            ways[..., i, j] = value
    best = np.argmax(np.linalg.norm(ways, axis=-1), axis=-1).ravel()
    found: Array = ways.reshape(-1, 4, 4)[np.arange(len(best)), best].reshape(ways.shape[:-1])
    found /= np.linalg.norm(found, axis=-1, keepdims=True)
    found[found[..., 0] < 0.0] *= -1.0
    return found


# COLLADA -------------------------------------------------------------------------------------------------------------


def read_figure(path: Path) -> Figure:
    """The skeleton of a COLLADA file, with its skin and animations.

    Raises:
        GazeboError: it cannot be read, or has no skeleton.
    """
    return _read(path.resolve(), path.stat().st_mtime_ns if is_file(path) else 0)


@functools.lru_cache(maxsize=16)
def _read(path: Path, _changed: int) -> Figure:
    with reading(path):
        figure = _Reader(Collada(path)).figure()
    if figure is None:
        raise GazeboError(f"{path} has no skeleton: no <skin> with joints, and no nodes of type JOINT")
    arrays = [figure.positions, figure.turns, *(part.vertices for part in figure.skin)]
    arrays += [part.inverse_binds for part in figure.skin]
    arrays += [array for animation in figure.animations for array in (animation.positions, animation.turns)]
    if not all(np.isfinite(array).all() for array in arrays):
        raise GazeboError(f"mesh {path} cannot be read: a number of its skeleton is not finite")
    return figure


class _Reader:
    """Takes a skeleton out of a document."""

    def __init__(self, document: Collada) -> None:
        self.document = document
        self.parents: dict[Any, Any] = {child: parent for parent in document.root.iter() for child in parent}
        self.nodes: list[Any] = []  # of the bones
        self.scales: list[float] = []  # of the bones' frames, with the unit of length
        self.above = np.eye(4)  # the frame around the root, without scale

    def figure(self) -> Figure | None:
        root = self._root()
        if root is None:
            return None
        above = np.diag([self.document.unit] * 3 + [1.0])
        for node in reversed(list(self._ancestors(root))):
            above = above @ self.document.transform(node)
        scale = _scale(above)
        self.above = above.copy()
        self.above[:3, :3] /= scale
        parents: list[int] = []
        waiting = [(root, -1, scale)]
        while waiting:
            node, parent, scale = waiting.pop(0)
            parents.append(parent)
            self.nodes.append(node)
            self.scales.append(scale * _scale(self.document.transform(node)))
            place = len(self.nodes) - 1
            waiting += [(child, place, self.scales[place]) for child in self.document.all(node, "node")]
            if len(self.nodes) > MOST_KEYS:
                raise ValueError("its skeleton has too many nodes")
        rest = np.stack([self.document.transform(node) for node in self.nodes])
        positions, turns = self._rigid(rest[None], np.array(parents))
        names = tuple(node.get("sid") or node.get("name") or node.get("id") or "" for node in self.nodes)
        names = tuple(node.get("name") or name for node, name in zip(self.nodes, names, strict=True))
        animation = self._animation(rest, np.array(parents))
        return Figure(
            names,
            tuple(parents),
            positions[0],
            turns[0],
            tuple(self._skin()),
            () if animation is None else (animation,),
        )

    def _ancestors(self, node: Any) -> Iterator[Any]:
        node = self.parents.get(node)
        while node is not None and self.document.tag(node) == "node":
            yield node
            node = self.parents.get(node)

    def _root(self) -> Any:
        """The topmost joint: that of the skeleton that a skin names, else the first of the scene."""
        document = self.document
        found = None
        for instance in document.deep(document.root, "instance_controller"):
            for skeleton in document.all(instance, "skeleton"):
                found = document.target((skeleton.text or "").strip())
                break
            if found is not None:
                break
        if found is None:
            nodes = (node for scene in document.deep(document.root, "visual_scene") for node in scene.iter())
            found = next((n for n in nodes if document.tag(n) == "node" and n.get("type") == "JOINT"), None)
        if found is None:
            return None
        if found.get("type") != "JOINT":  # the armature around the joints
            found = next((n for n in document.deep(found, "node") if n.get("type") == "JOINT"), found)
        above = [node for node in self._ancestors(found) if node.get("type") == "JOINT"]
        return above[-1] if above else found

    def _rigid(self, local: Array, parents: NDArray[np.int64]) -> tuple[Array, Array]:
        """(positions, turns) of local matrices, shape (m, k, 4, 4), without their scales."""
        around = np.array([self.scales[parent] if parent >= 0 else _scale_of_root(self) for parent in parents])
        positions = local[..., :3, 3] * around[:, None]
        local = local.copy()
        local[..., :3, 3] = positions
        local[:, 0] = self.above @ local[:, 0]
        return local[..., :3, 3], matrix_turns(local)

    # Animation -------------------------------------------------------------------------------------------------------

    def _animation(self, rest: Array, parents: NDArray[np.int64]) -> SkeletonAnimation | None:
        channels = dict(self._channels())
        if not channels:
            return None
        times = np.unique(np.concatenate([keys for targets in channels.values() for _, keys, _ in targets]))
        if len(times) > MOST_KEYS or len(times) * len(self.nodes) > 50 * MOST_KEYS:
            raise ValueError(f"its animation has {len(times)} keys for {len(self.nodes)} bones")
        local = np.repeat(rest[None], len(times), axis=0)
        for place, targets in channels.items():
            local[:, place] = self._moved(self.nodes[place], targets, times)
        positions, turns = self._rigid(local, parents)
        return SkeletonAnimation("animation1", times, positions, turns)

    def _channels(self) -> Iterator[tuple[int, list[tuple[str, Array, Array]]]]:
        """(bone, [(target within its node, times [s], values)]) of all bones that move."""
        document = self.document
        found: dict[int, list[tuple[str, Array, Array]]] = {}
        places = {node.get("id"): place for place, node in enumerate(self.nodes) if node.get("id")}
        for channel in document.deep(document.root, "channel"):
            node, _, target = (channel.get("target") or "").partition("/")
            if node not in places:
                continue
            sampler = document.target(channel.get("source"))
            sources = {i.get("semantic"): document.target(i.get("source")) for i in document.all(sampler, "input")}
            if not {"INPUT", "OUTPUT"} <= sources.keys():
                continue
            times, values = _floats(document, sources["INPUT"]), _floats(document, sources["OUTPUT"])
            if len(times) and len(values) % len(times) == 0:
                found.setdefault(places[node], []).append((target, times, values.reshape(len(times), -1)))
        yield from found.items()

    def _moved(self, node: Any, targets: list[tuple[str, Array, Array]], times: Array) -> Array:
        """The local matrices of a node at all times, shape (m, 4, 4)."""
        steps = self.document.steps(node)
        result = np.repeat(np.eye(4)[None], len(times), axis=0)
        for sid, kind, numbers in steps:
            values = np.repeat(numbers[None].astype(np.float64), len(times), axis=0)
            for target, keys, moved in targets:
                name, _, member = target.partition(".")
                name, _, index = name.partition("(")
                if name != sid:
                    continue
                if kind == "matrix" and moved.shape[1] == 16:
                    values = _between(keys, moved.reshape(-1, 4, 4), times).reshape(-1, 16)
                elif member or index:
                    column = _column(kind, member, index)
                    if column is not None:
                        values[:, column] = np.interp(times, keys, moved[:, 0])
                elif moved.shape[1] == values.shape[1]:
                    for column in range(values.shape[1]):
                        values[:, column] = np.interp(times, keys, moved[:, column])
            result = result @ np.stack([step_matrix(kind, row) for row in values])
        return result

    # Skin ------------------------------------------------------------------------------------------------------------

    def _skin(self) -> Iterator[SkinPart]:
        document = self.document
        for instance in document.deep(document.root, "instance_controller"):
            bound = {m.get("symbol"): m for m in document.deep(instance, "instance_material")}
            for skin in document.all(document.target(instance.get("url")), "skin"):
                yield from self._skin_parts(skin, bound)

    def _skin_parts(self, skin: Any, bound: dict[str, Any]) -> Iterator[SkinPart]:
        document = self.document
        joints = document.first(document.all(skin, "joints"), "<joints>")
        sources = {i.get("semantic"): document.target(i.get("source")) for i in document.all(joints, "input")}
        if not {"JOINT", "INV_BIND_MATRIX"} <= sources.keys():
            raise ValueError("<joints> needs inputs JOINT and INV_BIND_MATRIX")
        places = [self._place(name) for name in _names(document, sources["JOINT"])]
        inverse = _floats(document, sources["INV_BIND_MATRIX"]).reshape(-1, 4, 4)
        if len(inverse) < len(places):
            raise ValueError(f"there are {len(inverse)} bind matrices for {len(places)} joints")
        unit = document.unit
        binds = np.repeat(np.eye(4)[None], len(self.nodes), axis=0)
        for place, matrix in zip(places, inverse, strict=False):
            into = matrix.copy()  # from the file's units into the bone's frame, which has a scale of its own
            into[:3] *= self.scales[place]
            into[:3, :3] /= unit
            binds[place] = into
        shape = np.diag([unit] * 3 + [1.0]) @ document.bind_shape(skin)
        weights, bones = self._weights(skin, np.array(places, dtype=np.int64))
        for mesh in document.all(document.target(skin.get("source")), "mesh"):
            for group in document.groups(mesh):
                points, triangles, cut = document.primitive(group)
                if not len(triangles):
                    continue
                if triangles.max() >= len(weights):
                    raise ValueError("a triangle names a vertex that has no weights")
                material = bound.get(group.get("material"))
                kept, index = np.unique(triangles, return_inverse=True)
                yield SkinPart(
                    points[kept] @ shape[:3, :3].T + shape[:3, 3],
                    np.array(index, dtype=np.int64).reshape(-1, 3),
                    bones[kept],
                    weights[kept],
                    binds,
                    document.look(material).color,
                    document.texture(material, group, cut),
                )

    def _place(self, name: str) -> int:
        for key in ("sid", "id", "name"):
            for place, node in enumerate(self.nodes):
                if node.get(key) == name:
                    return place
        raise ValueError(f"a skin names joint {name!r}, which its skeleton does not have")

    def _weights(self, skin: Any, places: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
        """(weights, bones) of all vertices, shape (n, 4): of the bones that move a vertex most."""
        document = self.document
        holder = document.first(document.all(skin, "vertex_weights"), "<vertex_weights>")
        inputs = document.all(holder, "input")
        joint = document.first((i for i in inputs if i.get("semantic") == "JOINT"), "an <input> of joints")
        weight = document.first((i for i in inputs if i.get("semantic") == "WEIGHT"), "an <input> of weights")
        values = _floats(document, document.target(weight.get("source")))
        counts = _whole(document.first(document.all(holder, "vcount"), "<vcount>"))
        pairs = _whole(document.first(document.all(holder, "v"), "<v>"))
        stride = 1 + max(int(i.get("offset", "0")) for i in inputs)
        if counts.min(initial=0) < 0 or counts.sum() * stride != len(pairs):
            raise ValueError("<vcount> and <v> of a skin do not fit")
        vertex = np.repeat(np.arange(len(counts)), counts)
        which, shares = pairs[int(joint.get("offset", "0")) :: stride], pairs[int(weight.get("offset", "0")) :: stride]
        if len(which) and (which.max() >= len(places) or shares.max() >= len(values) or shares.min() < 0):
            raise ValueError("a weight of a skin names a joint or a number that does not exist")
        strength = values[shares]
        order = np.lexsort((-strength, vertex))
        rank = np.arange(len(order)) - np.repeat(np.cumsum(counts) - counts, counts)
        kept = order[rank < INFLUENCES]
        rank = rank[rank < INFLUENCES]
        weights, bones = np.zeros((len(counts), INFLUENCES)), np.zeros((len(counts), INFLUENCES), dtype=np.int64)
        weights[vertex[kept], rank] = strength[kept]
        bones[vertex[kept], rank] = np.where(which[kept] >= 0, places[which[kept]], 0)
        sums = weights.sum(axis=1, keepdims=True)
        weights[sums[:, 0] <= 0.0, 0] = 1.0
        return weights / np.where(sums > 0.0, sums, 1.0), bones


def _scale(matrix: Array) -> float:
    """How much a matrix lengthens, on average of its axes."""
    return float(np.cbrt(abs(np.linalg.det(matrix[:3, :3])))) or 1.0


def _scale_of_root(reader: _Reader) -> float:
    """The scale of the frame around the root."""
    return reader.scales[0] / _scale(reader.document.transform(reader.nodes[0]))


def _floats(document: Collada, source: Any) -> Array:
    array = document.first(document.deep(source, "float_array"), "<float_array>")
    return np.array((array.text or "").split(), dtype=np.float64)


def _names(document: Collada, source: Any) -> list[str]:
    for kind in ("Name_array", "IDREF_array"):
        for array in document.deep(source, kind):
            return (array.text or "").split()
    raise ValueError("<Name_array> is missing")


def _whole(element: Any) -> NDArray[np.int64]:
    return np.array((element.text or "").split(), dtype=np.int64)


def _between(keys: Array, matrices: Array, times: Array) -> Array:
    """Matrices at other times: positions and axes' lengths linearly, rotations along the shorter way."""
    if len(keys) == len(times) and np.array_equal(keys, times):
        return matrices
    turns, lengths = matrix_turns(matrices), np.linalg.norm(matrices[:, :3, :3], axis=1)
    after = np.clip(np.searchsorted(keys, times), 1, max(len(keys) - 1, 1))
    if len(keys) == 1:
        return np.repeat(matrices, len(times), axis=0)
    share = np.clip((times - keys[after - 1]) / (keys[after] - keys[after - 1]), 0.0, 1.0)[:, None]
    places = matrices[:, :3, 3]
    rows = [
        blend_bones((places[a - 1 : a], turns[a - 1 : a]), (places[a : a + 1], turns[a : a + 1]), float(s))
        for a, s in zip(after, share[:, 0], strict=True)
    ]
    result = turn_matrices(np.concatenate([turn for _, turn in rows]))
    result[:, :3, :3] *= ((1.0 - share) * lengths[after - 1] + share * lengths[after])[:, None, :]
    result[:, :3, 3] = np.concatenate([place for place, _ in rows])
    return result


def _column(kind: str, member: str, index: str) -> int | None:
    """Which number of a transformation a target such as `rotateX.ANGLE`, `translate.Y` or `matrix(0)(3)` means."""
    if member:
        known = {"X": 0, "Y": 1, "Z": 2, "ANGLE": 3}
        return known.get(member.upper())
    numbers = [int(part) for part in index.replace(")", "").split("(")]
    return 4 * numbers[0] + numbers[1] if kind == "matrix" and len(numbers) == 2 else numbers[0]
