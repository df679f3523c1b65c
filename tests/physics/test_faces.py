"""Faces of mesh files as triangles: areas, orders and shared sides."""

import numpy as np
import pytest

from libgz.base.geometry import GzQuaternFromEuler, rotate
from libgz.physics import faces
from libgz.physics.faces import MOST_CORNERS, cut_fans, cut_polygons, cut_strips

L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
STAR = [(np.cos(a) * r, np.sin(a) * r) for k, a in enumerate(np.arange(10) * np.pi / 5) for r in [1.0 - 0.6 * (k % 2)]]
COMB = [(0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (5, 1), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (0, 1)]


def area(outline):
    x, y = np.array(outline, dtype=float).T
    return 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def areas(points, triangles):
    """Areas of triangles as vectors along their normals."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def turned(outline, angles, reverse=False):
    flat = np.array([(x, y, 0.0) for x, y in outline])[:: -1 if reverse else 1]
    turn = GzQuaternFromEuler(*angles)
    return np.array([tuple(rotate(turn, row)) for row in flat]), np.array(tuple(rotate(turn, (0, 0, 1))))


@pytest.mark.parametrize("outline", [L_SHAPE, STAR, COMB], ids=["L", "star", "comb"])
@pytest.mark.parametrize("angles", [(0, 0, 0), (0.3, 1.2, -2.0), (np.pi / 2, 0, 0), (0, np.pi / 2, 0.1)])
@pytest.mark.parametrize("reverse", [False, True])
def test_concave_polygons_keep_their_area_and_side(outline, angles, reverse):
    points, normal = turned(outline, angles, reverse)
    triangles = cut_polygons(np.array([len(outline)]), points)
    sizes = areas(points, triangles) @ (-normal if reverse else normal)
    assert len(triangles) == len(outline) - 2
    assert (sizes > -1e-12).all()  # on a side, but for rounding
    assert sizes.sum() == pytest.approx(area(outline))


HOLES = [[(0.2, 0.2), (0.2, 0.8), (0.8, 0.8), (0.8, 0.2)], [(1.2, 0.3), (1.7, 0.3), (1.4, 0.7)]]


@pytest.mark.parametrize("angles", [(0, 0, 0), (0.3, 1.2, -2.0)])
@pytest.mark.parametrize("reverse", [False, True])
def test_polygons_are_cut_around_their_holes(angles, reverse):
    rings = [[(5, 5), (6, 5), (6, 6)], L_SHAPE, *HOLES, [(0, 5), (1, 5), (1, 6)]]
    points, normal = turned([corner for ring in rings for corner in ring], angles)
    parts = np.split(points, np.cumsum([len(ring) for ring in rings])[:-1])
    points = np.concatenate([part[:: -1 if reverse else 1] for part in parts])
    holes = np.array([False, False, True, True, False])
    triangles = cut_polygons(np.array([len(ring) for ring in rings]), points, holes)
    sizes = areas(points, triangles) @ (-normal if reverse else normal)
    assert (sizes > -1e-12).all()
    assert sizes.sum() == pytest.approx(1.0 + area(L_SHAPE) - sum(abs(area(hole)) for hole in HOLES))
    assert triangles[0].tolist() == [0, 1, 2]


def test_holes_that_cannot_be_cut_are_filled():
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 0), (6, 7, 0), (7, 5, 0)], dtype=float)
    found = cut_polygons(np.array([3, 3]), points, np.array([True, False]))  # a hole in nothing
    assert found.tolist() == [[3, 4, 5]]
    assert cut_polygons(np.array([3, 2]), points[:5], np.array([False, True])).tolist() == [[0, 1, 2]]


def test_convex_polygons_are_fans_in_the_order_of_the_file():
    square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    points = np.array([*square, *square[:3], *square, (0, 0, 0), (1, 1, 1)], dtype=float)
    triangles = cut_polygons(np.array([4, 3, 4, 2]), points)
    assert triangles.tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6], [7, 8, 9], [7, 9, 10]]


def test_what_cannot_be_cut_is_a_fan():
    bow = np.array([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1.5, 0)], dtype=float)
    assert len(cut_polygons(np.array([4]), bow)) == 2
    assert len(cut_polygons(np.array([5]), np.zeros((5, 3)))) == 3
    wide = np.random.default_rng(1).normal(size=(MOST_CORNERS + 1, 3))
    assert len(cut_polygons(np.array([len(wide)]), wide)) == len(wide) - 2
    assert np.isfinite(cut_polygons(np.array([4]), np.full((4, 3), np.nan))).all()


def test_more_corners_than_there_are_is_an_error():
    with pytest.raises(ValueError, match="the faces name 4 corners; there are 3"):
        cut_polygons(np.array([4]), np.zeros((3, 3)))
    with pytest.raises(ValueError):
        cut_polygons(np.array([-1, 3]), np.zeros((3, 3)))


def test_strips_and_fans():
    assert cut_strips(np.array([5, 2, 3])).tolist() == [[0, 1, 2], [2, 1, 3], [2, 3, 4], [7, 8, 9]]
    assert cut_fans(np.array([4, 1, 3])).tolist() == [[0, 1, 2], [0, 2, 3], [5, 6, 7]]
    assert cut_strips(np.zeros(0, dtype=int)).shape == cut_fans(np.zeros(0, dtype=int)).shape == (0, 3)


def test_concave_polygons_are_cut_up_to_a_bound_of_all(monkeypatch):
    monkeypatch.setattr(faces, "MOST_CUT", 2 * 25)
    arrow = [(0.0, 0.0, 0.0), (2.0, 2.0, 0.0), (0.0, 4.0, 0.0), (4.0, 2.0, 0.0), (3.0, 1.0, 0.0)]
    triangles = cut_polygons(np.array([5] * 4), np.array(arrow * 4)).reshape(4, -1) - 5 * np.arange(4)[:, None]
    assert triangles[0].tolist() == triangles[1].tolist() != triangles[2].tolist()
    assert triangles[2].tolist() == triangles[3].tolist() == [0, 1, 2, 0, 2, 3, 0, 3, 4]
