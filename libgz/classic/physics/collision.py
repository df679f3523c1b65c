"""Collision: a shape of a link that touches others, and how it touches them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic.math import AxisAlignedBox, Vector3d
from libgz.classic.physics.base import Base, Entity
from libgz.classic.physics.shape import Shape, shape_of
from libgz.errors import ParameterError
from libgz.geometry import GzCoordPoseSub, GzPose, VectorLike
from libgz.ode.types import Surface
from libgz.physics.geom import Geom

if TYPE_CHECKING:
    from libgz.classic.physics.link import Link
    from libgz.classic.physics.model import Model

__all__ = ["Collision", "FrictionPyramid", "SurfaceParams"]

# Collide modes: the bits it meets others with. A ghost meets nothing but rays.
MODES = {"all": 0xFFFFFFFF, "none": 0, "sensors": 0, "ghost": 0, "fixed": 0xFFFFFFFF}


class FrictionPyramid:
    """Coulomb friction along two directions."""

    def __init__(self, geom: Geom) -> None:
        self._geom = geom

    def _get(self, column: Surface) -> float:
        return self._geom.surface(column)

    def _set(self, column: Surface, value: float) -> None:
        self._geom.set_surface(column, value if value >= 0.0 else math.inf)

    def MuPrimary(self) -> float:
        """Coefficient along the first direction."""
        return self._get(Surface.MU)

    def SetMuPrimary(self, mu: float) -> None:
        """Set it; negative: infinite."""
        self._set(Surface.MU, mu)

    def MuSecondary(self) -> float:
        """Coefficient along the second direction."""
        return self._get(Surface.MU2)

    def SetMuSecondary(self, mu: float) -> None:
        """Set it; negative: infinite."""
        self._set(Surface.MU2, mu)

    def MuTorsion(self) -> float:
        """Coefficient against turning on the spot."""
        return self._get(Surface.TORSION)

    def SetMuTorsion(self, mu: float) -> None:
        """Set it."""
        self._set(Surface.TORSION, mu)

    GetMuPrimary, GetMuSecondary, GetMuTorsion = MuPrimary, MuSecondary, MuTorsion


class SurfaceParams:
    """How a collision touches others; values are read from the engine and written to it at once."""

    # ODESurfaceParams' names -> columns of the engine's surface table.
    _COLUMNS = {
        "kp": Surface.KP,
        "kd": Surface.KD,
        "slip1": Surface.SLIP1,
        "slip2": Surface.SLIP2,
        "bounce": Surface.BOUNCE,
        "bounceThreshold": Surface.BOUNCE_VEL,
        "maxVel": Surface.MAX_VEL,
        "minDepth": Surface.MIN_DEPTH,
        "collideBitmask": Surface.BITS,
    }

    def __init__(self, geom: Geom) -> None:
        object.__setattr__(self, "_geom", geom)

    def __getattr__(self, name: str) -> Any:
        if name not in self._COLUMNS:
            raise AttributeError(f"a surface has no {name!r}; it has {', '.join(self._COLUMNS)}")
        value = self._geom.surface(self._COLUMNS[name])
        return int(value) if name == "collideBitmask" else value

    def __setattr__(self, name: str, value: float) -> None:
        if name not in self._COLUMNS:
            raise AttributeError(f"a surface has no {name!r}; it has {', '.join(self._COLUMNS)}")
        if not value >= 0.0:
            raise ParameterError(f"{name} is {value!r}; it must not be negative")
        self._geom.set_surface(self._COLUMNS[name], float(value))

    def FrictionPyramid(self) -> FrictionPyramid:
        """The friction coefficients."""
        return FrictionPyramid(self._geom)

    GetFrictionPyramid = FrictionPyramid


class Collision(Entity):
    """A view on a Geom."""

    entity_type = Base.ENTITY | Base.COLLISION

    def __init__(self, link: Link, geom: Geom) -> None:
        name = link.model.geom_name(geom)
        super().__init__(link.GetWorld(), name, link)
        self.link, self.geom = link, geom
        self._sdf = link.model.geom_sdf(geom)
        self._bits = geom.surface(Surface.BITS)

    def pose(self) -> GzPose:
        """Global pose [m]."""
        return self.geom.GetPose()

    def move(self, pose: GzPose) -> None:
        """Put it to a global pose [m]; it goes with its link from there on."""
        self.geom.SetRelativePose(GzCoordPoseSub(pose, self.geom.body.GetPose()), updateCoM=False)

    def IsStatic(self) -> bool:
        """Whether its model is static."""
        return self.link.IsStatic()

    def WorldLinearVel(self, offset: VectorLike | None = None) -> Vector3d:
        """Velocity of its centre [m/s]."""
        return self.link.WorldLinearVel(GzCoordPoseSub(self.pose(), self.link.pose()).pos)

    def WorldAngularVel(self) -> Vector3d:
        """Angular velocity [rad/s]."""
        return self.link.WorldAngularVel()

    def GetLink(self) -> Link:
        """The link."""
        return self.link

    def GetModel(self) -> Model:
        """The model."""
        return self.link.model

    def GetShape(self) -> Shape:
        """Its shape."""
        return shape_of(self.geom)

    def GetShapeType(self) -> str:
        """box, sphere, cylinder, plane, mesh or empty."""
        return self.GetShape().kind

    def GetSurface(self) -> SurfaceParams:
        """How it touches others."""
        return SurfaceParams(self.geom)

    def BoundingBox(self) -> AxisAlignedBox:
        """The smallest box along the world's axes around it [m]."""
        low, high = self.geom.bounds()
        return AxisAlignedBox(Vector3d(*low), Vector3d(*high))

    def SetCategoryBits(self, bits: int) -> None:
        """What it is, for collision."""
        self.geom.SetCategoryBits(bits)

    def SetCollideBits(self, bits: int) -> None:
        """What it collides with."""
        self.geom.SetCollideBits(bits)

    def SetCollideMode(self, mode: str) -> None:
        """``all`` or ``fixed``: as its bitmask says; ``none``, ``sensors`` or ``ghost``: it touches nothing.

        Raises:
            ParameterError: there is no such mode.
        """
        if mode not in MODES:
            raise ParameterError(f"collide mode {mode!r} is not known; allowed are {', '.join(MODES)}")
        now = self.geom.surface(Surface.BITS)
        self._bits = now or self._bits  # what it had before it was to touch nothing
        self.geom.set_surface(Surface.BITS, self._bits if MODES[mode] else 0.0)

    def SetMaxContacts(self, maxContacts: int) -> None:
        """Most contact points with another collision."""
        self.geom.set_surface(Surface.MAX_CONTACTS, float(maxContacts))

    def GetMaxContacts(self) -> int:
        """Most contact points with another collision."""
        return int(self.geom.surface(Surface.MAX_CONTACTS))

    def SetLaserRetro(self, retro: float) -> None:
        """How much it reflects of a laser."""
        self.geom.SetRetro(retro)

    def GetLaserRetro(self) -> float:
        """How much it reflects of a laser."""
        return self.geom.GetRetro()

    def SetScale(self, scale: VectorLike) -> None:
        """Make it so many times as large as it was at first."""
        self.GetShape().SetScale(scale)
