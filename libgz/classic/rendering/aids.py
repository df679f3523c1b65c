"""Lines that show what images do not: collisions, joints, centres of mass, inertia, frames and boxes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzPose, GzQuaternIdent, GzVector
from libgz.classic.physics.link import Link
from libgz.classic.physics.model import Model
from libgz.classic.rendering.lines import placed
from libgz.physics.geom import Geom
from libgz.rendering.geom_meshes import meshes_of
from libgz.rendering.gl import Constant
from libgz.rendering.overlay import CORNERS, EDGES
from libgz.rendering.shot import Lines, pose_matrix

if TYPE_CHECKING:
    from libgz.classic.physics.world import World
    from libgz.physics.body import Body

__all__ = ["AIDS", "aids_of", "edges_of"]

Ends = NDArray[np.float64]  # [m], shape (2 n, 3)

RED, GREEN, BLUE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
ORANGE, YELLOW, PURPLE, WHITE = (1.0, 0.55, 0.0), (1.0, 1.0, 0.0), (0.6, 0.2, 1.0), (1.0, 1.0, 1.0)
AXIS, JOINT_AXIS, CROSS = 0.15, 0.3, 0.05  # [m] lengths of lines
BOX = (CORNERS - 0.5)[np.array(EDGES).ravel()]  # the edges of a unit box
SEGMENTS = 24  # of round shapes


def edges_of(geom: Geom) -> Ends:
    """The edges of a geom's triangles [m], global."""
    place, found = pose_matrix(geom.GetPose()), [np.zeros((0, 3))]
    for mesh in meshes_of(geom, SEGMENTS):
        if mesh.mode != Constant.TRIANGLES:
            continue
        shape = mesh.scaled(*geom.appearance.scale).moved(place)
        corners = shape.vertices.astype(np.float64)
        indices = np.arange(len(corners)) if shape.indices is None else shape.indices
        triangles = indices.astype(np.int64).reshape(-1, 3)
        pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        found.append(corners[np.unique(np.sort(pairs, axis=1), axis=0).ravel()])
    return np.concatenate(found)


def _box(size: tuple[float, ...], frame: GzPose, color: tuple[float, float, float]) -> Lines:
    return placed(BOX * np.array(size), frame, color)


def _collisions(links: list[Link]) -> Iterator[Lines]:
    for link in links:
        for collision in link.GetCollisions():
            yield Lines(edges_of(collision.geom).astype(np.float32), ORANGE)


def _joints(links: list[Link]) -> Iterator[Lines]:
    for joint in dict.fromkeys(joint for link in links for joint in link.GetParentJoints()):
        frame = joint.WorldPose()
        yield from _axes(frame)
        for index in range(min(joint.DOF(), 2)):
            axis, start = np.array([*joint.GlobalAxis(index)]), np.array([*frame.Pos()])
            yield placed(np.array([start, start + JOINT_AXIS * axis]), GzPose(), YELLOW)


def _axes(frame: GzPose) -> Iterator[Lines]:
    for axis, color in zip(np.eye(3), (RED, GREEN, BLUE), strict=True):
        yield placed(np.array([np.zeros(3), AXIS * axis]), frame, color)


def _centres(links: list[Link]) -> Iterator[Lines]:
    for link in links:
        ends = np.concatenate([[-CROSS * axis, CROSS * axis] for axis in np.eye(3)])
        yield placed(ends, link.WorldCoGPose(), YELLOW)


def _inertias(links: list[Link]) -> Iterator[Lines]:
    """The box of even density that has a link's mass and moments."""
    for link in links:
        matrix = np.array(link.GetInertial().MOI().m)
        moments, turn = np.linalg.eigh(matrix)
        squares = 6.0 / max(link.GetInertial().Mass(), 1e-9) * (moments.sum() - 2.0 * moments)
        yield placed(BOX * np.sqrt(np.maximum(squares, 0.0)) @ turn.T, link.WorldCoGPose(), PURPLE)


def _frames(links: list[Link]) -> Iterator[Lines]:
    for link in links:
        yield from _axes(link.WorldPose())


def _boxes(links: list[Link]) -> Iterator[Lines]:
    for link in links:
        box = link.BoundingBox()
        if link.GetCollisions():
            middle = GzPose(GzVector(*box.Center()), GzQuaternIdent())
            if np.isfinite([*box.Size()]).all():
                yield _box(tuple(box.Size()), middle, WHITE)


# Name -> the lines that it shows of links.
AIDS: dict[str, Callable[[list[Link]], Iterator[Lines]]] = {
    "collision": _collisions,
    "joints": _joints,
    "com": _centres,
    "inertia": _inertias,
    "frame": _frames,
    "box": _boxes,
}


def aids_of(world: World, name: str, body: Body | None, names: list[str]) -> Iterator[Lines]:
    """The lines of some kinds, of the links that a visual shows, by its name or its body."""
    entity = world.EntityByName(name)
    if isinstance(entity, Model):
        links = list(entity.family_links())
    elif isinstance(entity, Link):
        links = [entity]
    else:
        link = world.link_of(body) if body is not None and body.model is not None else None
        links = [link] if link is not None else []
    for kind in names:
        yield from AIDS[kind](links)
