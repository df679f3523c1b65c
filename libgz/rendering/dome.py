"""The mesh of the sky's dome."""

from __future__ import annotations

import math

import numpy as np

from libgz.rendering.mesh import Mesh

__all__ = ["dome_mesh"]

RINGS, SECTORS = 10, 40


def dome_mesh() -> Mesh:
    """A hemisphere of radius 1, seen from inside: rings from the horizon up, and the top.

    Texture: s is 0, because rendering adds the time of day; t is 1 at the zenith, the image's top row,
    and 0 at the horizon.
    """
    vertices, texcoords = [], []
    for ring in range(RINGS):
        height = ring / RINGS * math.pi / 2.0
        for sector in range(SECTORS):
            around = sector / SECTORS * 2.0 * math.pi
            vertices.append(
                (math.cos(height) * math.cos(around), math.cos(height) * math.sin(around), math.sin(height))
            )
            texcoords.append((0.0, ring / RINGS))
    vertices.append((0.0, 0.0, 1.0))
    texcoords.append((0.0, 1.0))
    top, indices = RINGS * SECTORS, []
    for ring in range(RINGS):
        for sector in range(SECTORS):
            a, b = ring * SECTORS + sector, ring * SECTORS + (sector + 1) % SECTORS
            if ring == RINGS - 1:
                indices += [a, top, b]
            else:
                indices += [a, a + SECTORS, b, b, a + SECTORS, b + SECTORS]
    return Mesh(
        np.array(vertices, dtype=np.float32), None, np.array(texcoords, dtype=np.float32), np.array(indices, np.uint32)
    )
