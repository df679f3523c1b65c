"""Roads of SDF worlds: flat strips that are rendered and touch nothing, as in Gazebo classic."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzVector
from libgz.physics.body import Body
from libgz.physics.check import LARGEST, finite_tuple
from libgz.physics.geoms import TriMeshGeom
from libgz.sdf.element import Element
from libgz.sdf.materials import NEUTRAL, find_material
from libgz.sdfworld.visual import Note, dress_material, put_on

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = ["make_road", "road_mesh"]

PLAIN = "Gazebo/Road"  # of a road without a material
SHARPEST = 0.25  # least cosine of half a bend: the corner of a sharper one is cut off


def make_road(world: World, element: Element, note: Note) -> None:
    """Add a `<road>` to a world. One that has no length or width is left out, with a warning."""
    points = [finite_tuple(point.Get(GzVector), 3, "road point [m]", LARGEST) for point in element.named("point")]
    width = element.Get(float, "width")
    line = np.array(points, dtype=float).reshape(-1, 3)
    line = line[np.append(True, np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1) > 1e-6)] if len(line) else line
    if len(line) < 2 or not 0.0 < width < LARGEST:
        note(element, f"a road of {len(line)} different points and width {width:g} m is left out")
        return
    vertices, triangles, coordinates = road_mesh(line, width)
    road = TriMeshGeom(Body(world, dummy=True), None, vertices, triangles)
    road.texture_coordinates = coordinates
    put_on(road.appearance, find_material(PLAIN) or NEUTRAL)
    if element.HasElement("material"):
        dress_material(road.appearance, element.child("material"), note)
    road.appearance.change(cast_shadows=False)


def road_mesh(
    line: NDArray[np.float64], width: float
) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float64]]:
    """A strip of a width [m] along a line of points [m], shape (n, 3), mitred where it bends.

    Returns:
        Its vertices [m], two for each point, left and right; triangles, seen from above; texture coordinates: an image
        as wide as the road is repeated along it.
    """
    steps = np.diff(line[:, :2], axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    ahead = steps / lengths[:, None]
    before, after = np.vstack([ahead[:1], ahead]), np.vstack([ahead, ahead[-1:]])
    middle = before + after
    sizes = np.linalg.norm(middle, axis=1, keepdims=True)
    middle = np.where(sizes > 1e-9, middle / np.maximum(sizes, 1e-9), after)
    left = np.stack([-middle[:, 1], middle[:, 0]], axis=1)
    cosine = np.maximum(np.sum(middle * after, axis=1, keepdims=True), SHARPEST)
    side = np.hstack([0.5 * width * left / cosine, np.zeros((len(line), 1))])
    vertices = np.stack([line + side, line - side], axis=1).reshape(-1, 3)
    first = 2 * np.arange(len(line) - 1)[:, None]
    triangles = np.hstack([first, first + 1, first + 3, first, first + 3, first + 2]).reshape(-1, 3).astype(np.uint32)
    along = np.append(0.0, np.cumsum(lengths)) / width
    coordinates = np.stack([np.tile((0.0, 1.0), len(line)), np.repeat(along, 2)], axis=1)
    return vertices, triangles, coordinates
