"""Meshes that a user drops into a page: each becomes a model in `~/.gazebo/models`, as others in the catalogue."""

from __future__ import annotations

import base64
import binascii
import re
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError
from libgz.base.files import exists, expand, xml_text
from libgz.physics.check import LARGEST as FARTHEST
from libgz.physics.mesh_files import read_mesh

__all__ = ["FORMATS", "MeshModel", "keep_mesh"]

FORMATS = (".dae", ".glb", ".obj", ".stl")
LARGEST = 24 << 20  # [byte] of a file
MOST = 200  # meshes that are kept in a folder
LARGE = 50.0  # [m] from which on a mesh is taken to be in millimetres
DENSITY = 100.0  # [kg/m3] of the box around it
LIGHTEST, HEAVIEST = 0.1, 1e4  # [kg]
THINNEST = 1e-3  # [m] of the box
PREFIX = "mesh_"  # of the folders, by which users find them


@dataclass(frozen=True)
class MeshModel:
    """A model that looks like a mesh.

    Attributes:
        name: of the model and of its folder.
        file: the mesh.
        low, high: corners of the box around it, in its own units, shape (3,).
    """

    name: str
    file: Path
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def scale(self) -> float:
        """By which its units become metres."""
        return 1e-3 if float((self.high - self.low).max()) > LARGE else 1.0

    @property
    def size(self) -> NDArray[np.float64]:
        """Of the box around it [m], shape (3,)."""
        return np.maximum(self.scale * (self.high - self.low), THINNEST)

    @property
    def mass(self) -> float:
        """That of a light filling of the box [kg]."""
        return float(np.clip(DENSITY * np.prod(self.size), LIGHTEST, HEAVIEST))

    @property
    def offset(self) -> NDArray[np.float64]:
        """Where its origin is, so that it stands on the ground, in the middle [m], shape (3,)."""
        middle = 0.5 * (self.low + self.high)
        return -self.scale * np.array([middle[0], middle[1], self.low[2]])

    def remove(self) -> None:
        """Delete its folder, with the mesh."""
        shutil.rmtree(self.file.parent.parent, ignore_errors=True)

    def sdf(self) -> str:
        """As SDF: the mesh is what is seen and what collides; the box is its inertia."""
        x, y, z = self.size**2 * self.mass / 12.0
        uri = xml_text(f"model://{self.name}/meshes/{self.file.name}")
        shape = f"<geometry><mesh><uri>{uri}</uri><scale>{_words([self.scale] * 3)}</scale></mesh></geometry>"
        pose = f"<pose>{_words(self.offset)} 0 0 0</pose>"
        inertia = "".join(
            f"<i{axis}>{value:.6g}</i{axis}>" for axis, value in (("xx", y + z), ("yy", x + z), ("zz", x + y))
        )
        middle = _words([0.0, 0.0, self.size[2] / 2.0])
        return (
            f"<sdf version='1.6'>\n<model name='{self.name}'>\n<link name='link'>\n"
            f"<inertial><pose>{middle} 0 0 0</pose><mass>{self.mass:.6g}</mass>"
            f"<inertia>{inertia}</inertia></inertial>\n"
            f"<collision name='collision'>{pose}{shape}</collision>\n<visual name='visual'>{pose}{shape}</visual>\n"
            "</link>\n</model>\n</sdf>\n"
        )

    def legacy(self, id: str) -> str:
        """As a worldfile's element: a solid box with the mesh as its skin.

        Args:
            id: of the model, which is free.
        """
        x, y, z = self.offset - [0.0, 0.0, self.size[2] / 2.0]
        return (
            f"<model:SimpleSolid>\n  <id>{id}</id>\n  <shape>box</shape>\n  <size>{_words(self.size)}</size>\n"
            f"  <mass>{self.mass:.6g}</mass>\n  <skinFile>{xml_text(str(self.file))}</skinFile>\n"
            f"  <skinXyz>{_words([x, y, z])}</skinXyz>\n  <skinScale>{_words([self.scale] * 3)}</skinScale>\n"
            "</model:SimpleSolid>"
        )


def keep_mesh(name: str, data: Any) -> MeshModel:
    """A model of a mesh file, in a new folder of `~/.gazebo/models`.

    Args:
        name: of the file; its ending says its format.
        data: the file in base64.

    Raises:
        GazeboError: it is no mesh, is too large, or cannot be kept.
    """
    suffix = Path(name).suffix.lower()
    if suffix not in FORMATS:
        raise ParameterError(f"{name[:100]!r} is no mesh; allowed are {', '.join(FORMATS)}")
    try:
        body = base64.b64decode(data, validate=True) if isinstance(data, str) and len(data) < 2 * LARGEST else b""
    except (binascii.Error, ValueError):
        body = b""
    if not 0 < len(body) <= LARGEST:
        raise ParameterError(f"{name[:100]!r} is empty, or larger than {LARGEST >> 20} MiB")
    stem = PREFIX + (re.sub(r"[^a-z0-9]+", "_", Path(name).stem.lower()).strip("_")[:40] or "model")
    root = expand("~/.gazebo/models")
    temporary: str | None = None
    try:
        root.mkdir(parents=True, exist_ok=True)
        if len(list(root.glob(f"{PREFIX}*"))) >= MOST:
            raise GazeboError(f"{root} holds {MOST} dropped meshes already; remove some of the folders {PREFIX}*")
        temporary = tempfile.mkdtemp(prefix=".", dir=root)
        file = Path(temporary, "meshes", f"mesh{suffix}")
        file.parent.mkdir()
        file.write_bytes(body)
        try:
            corners = np.concatenate([part.vertices for part in read_mesh(file)])
        except GazeboError as error:  # users know the file by its own name
            raise GazeboError(str(error).replace(str(file), name[:100])) from None
        reach = float(np.abs(corners).max())
        if reach > FARTHEST:
            raise GazeboError(f"mesh {name[:100]}: a vertex lies at {reach:g}; allowed is {FARTHEST:g} at most")
        title = next(one for one in _names(stem) if not exists(root / one))
        model = MeshModel(title, root / title / "meshes" / file.name, corners.min(axis=0), corners.max(axis=0))
        config = f"<model><name>{title}</name><sdf version='1.6'>model.sdf</sdf></model>\n"
        Path(temporary, "model.config").write_text(config, encoding="utf-8")
        Path(temporary, "model.sdf").write_text(model.sdf(), encoding="utf-8")
        Path(temporary).rename(root / title)
    except OSError as error:
        raise GazeboError(f"the mesh cannot be kept in {root}: {error.strerror}") from None
    finally:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)
    return model


def _names(stem: str) -> Iterator[str]:
    yield stem
    yield from (f"{stem}_{number}" for number in range(2, MOST + 2))


def _words(values: Any) -> str:
    return " ".join(f"{float(value):.6g}" for value in values)
