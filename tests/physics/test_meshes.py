"""Meshes of grids."""

import numpy as np
import pytest

from libgz.physics import meshes
from libgz.physics.meshes import grid_strip, grid_triangles, triangle_normals, vertex_normals


def strip_triangles(strip):
    """The triangles that a strip draws, those without area left out, each with its lowest corner first."""
    found = []
    for i in range(len(strip) - 2):
        a, b, c = (int(v) for v in strip[i : i + 3])
        if len({a, b, c}) == 3:
            a, b, c = (a, b, c) if i % 2 == 0 else (b, a, c)
            least = min(a, b, c)
            while a != least:
                a, b, c = b, c, a
            found.append((a, b, c))
    return sorted(found)


def test_a_grid_is_covered_once_from_above_by_triangles_and_strip():
    rows, columns = 3, 4
    vertices = np.array([(x, y, 0.0) for y in range(rows) for x in range(columns)])
    triangles = grid_triangles(rows, columns)
    strip = np.array(strip_triangles(grid_strip(rows, columns)))
    for corners in (triangles, strip):
        a, b, c = (vertices[corners[:, i]] for i in range(3))
        areas = np.cross(b - a, c - a)[:, 2] / 2.0
        assert areas == pytest.approx([0.5] * 2 * (rows - 1) * (columns - 1))
    assert triangle_normals(vertices, triangles) == pytest.approx(np.tile((0, 0, 1), (12, 1)))


def test_normals_of_a_sphere_point_outward():
    u, v = np.meshgrid(np.linspace(0.2, 1.2, 30), np.linspace(0, 1, 30))
    vertices = np.stack([np.cos(v) * np.cos(u), np.sin(v) * np.cos(u), np.sin(u)], axis=-1).reshape(-1, 3)
    normals = vertex_normals(vertices, grid_triangles(30, 30)[:, ::-1])
    inside = normals.reshape(30, 30, 3)[1:-1, 1:-1]
    assert np.einsum("ijk,ijk->ij", inside, vertices.reshape(30, 30, 3)[1:-1, 1:-1]).min() > 0.999


def test_normals_of_a_large_mesh_are_those_of_the_whole(monkeypatch):
    """They are computed piece by piece, with the same sums to the last bit."""
    rng = np.random.default_rng(3)
    vertices, triangles = rng.random((300, 3)), rng.integers(0, 300, (1000, 3))
    whole = vertex_normals(vertices, triangles)
    faces = np.repeat(triangle_normals(vertices, triangles), 3, axis=0)
    sums = np.stack([np.bincount(triangles.ravel(), faces[:, i], 300) for i in range(3)], axis=1)
    assert (whole == sums / np.linalg.norm(sums, axis=1, keepdims=True)).all()
    monkeypatch.setattr(meshes, "STRIP", 7)
    assert (vertex_normals(vertices, triangles) == whole).all()
