"""The parts of a mesh, as readers of files and makers of shapes return them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["MeshPart", "NamedImage", "Texture"]

Array = NDArray[np.float64]


class NamedImage(NamedTuple):
    """An image: its name, as it is written in a file, which is the mesh or its material library."""

    name: str
    file: Path


@dataclass(eq=False, repr=False)
class Texture:
    """An image on a part.

    Attributes:
        image: by its name; None if the file names none, and a material may bring one.
        coordinates: of the corners of each triangle, shape (m, 3, 2), (0, 0) is the lower left of the image; None if
            the file has none for this part, or damaged ones.
    """

    image: NamedImage | None
    coordinates: Array | None

    def mirrored(self) -> Texture:
        """The same for triangles whose corners are in the opposite order."""
        return self if self.coordinates is None else replace(self, coordinates=self.coordinates[:, ::-1])


@dataclass(eq=False, repr=False)
class MeshPart:
    """A piece of a mesh: vertices [m], shape (n, 3); triangles, shape (m, 3); its colour, if the file gives one.

    Texture coordinates and normals belong to corners, so that they do not change which vertices triangles share.

    Attributes:
        color: diffuse, with an alpha below 1 where the file makes it transparent.
        normals: of the corners of each triangle, unit vectors, zero where unknown, shape (m, 3, 3); None if the file
            has none for this part, or damaged ones.
    """

    name: str
    vertices: Array
    triangles: NDArray[np.integer]
    color: tuple[float, ...] | None = None
    texture: Texture | None = None
    normals: Array | None = None
