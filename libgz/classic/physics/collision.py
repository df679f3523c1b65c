"""Collision: a colliding shape of a link, and its surface parameters."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPoseSub, GzPose, GzVector, VectorLike, rotate
from libgz.classic.math import AxisAlignedBox, Vector3d
from libgz.classic.names import takes_names
from libgz.classic.physics.base import Base, Entity
from libgz.classic.physics.shape import Shape, shape_of
from libgz.ode.types import Surface
from libgz.physics.check import finite_tuple, not_negative
from libgz.physics.geom import Geom
from libgz.physics.geoms import CylinderGeom

if TYPE_CHECKING:
    from libgz.classic.physics.world import Link, Model

__all__ = ["Collision", "FrictionPyramid", "SurfaceParams"]

# Collide modes, and whether a collision has contacts in them; rays hit it in all modes.
MODES = {"all": True, "none": False, "sensors": False, "ghost": False, "fixed": True}


class FrictionPyramid:
    """Coefficients of Coulomb friction along two directions, and of torsional friction."""

    def __init__(self, geom: Geom) -> None:
        self._geom = geom

    def _get(self, column: Surface) -> float:
        return self._geom.surface(column)

    def _set(self, column: Surface, value: float) -> None:
        self._geom.set_surface(column, value if value >= 0.0 else math.inf)

    def MuPrimary(self) -> float:
        """The coefficient along the first direction."""
        return self._get(Surface.MU)

    def SetMuPrimary(self, mu: float) -> None:
        """Set the coefficient along the first direction; negative: infinite."""
        self._set(Surface.MU, mu)

    def MuSecondary(self) -> float:
        """The coefficient along the second direction."""
        return self._get(Surface.MU2)

    def SetMuSecondary(self, mu: float) -> None:
        """Set the coefficient along the second direction; negative: infinite."""
        self._set(Surface.MU2, mu)

    def MuTorsion(self) -> float:
        """The coefficient of torsional friction."""
        return self._get(Surface.TORSION)

    def SetMuTorsion(self, mu: float) -> None:
        """Set the coefficient of torsional friction; negative: infinite."""
        self._set(Surface.TORSION, mu)

    def PatchRadius(self) -> float:
        """The radius of the contact patch [m], for torsional friction."""
        return self._get(Surface.PATCH_RADIUS)

    def SetPatchRadius(self, radius: float) -> None:
        """Set the radius of the contact patch [m], for torsional friction."""
        self._geom.set_surface(Surface.PATCH_RADIUS, not_negative(radius, "patch radius [m]"))

    def SurfaceRadius(self) -> float:
        """The radius of the surface's curvature [m], for torsional friction; 0 is flat."""
        return self._get(Surface.RADIUS)

    def SetSurfaceRadius(self, radius: float) -> None:
        """Set the radius of the surface's curvature [m], for torsional friction; 0 is flat."""
        self._geom.set_surface(Surface.RADIUS, not_negative(radius, "surface radius [m]"))

    def UsePatchRadius(self) -> bool:
        """Whether torsional friction goes by the patch radius, not by the surface radius and the depth."""
        return bool(self._get(Surface.BY_PATCH))

    def SetUsePatchRadius(self, use: bool) -> None:
        """Set whether torsional friction goes by the patch radius, not by the surface radius and the depth."""
        self._geom.set_surface(Surface.BY_PATCH, float(bool(use)))

    @property
    def direction1(self) -> Vector3d:
        """The first friction direction, in the collision's frame; zero: none."""
        return Vector3d(*(self._geom.surface(Surface.FDIR1 + i) for i in range(3)))

    @direction1.setter
    def direction1(self, direction: VectorLike) -> None:
        for i, value in enumerate(finite_tuple(direction, 3, "direction1")):
            self._geom.set_surface(Surface.FDIR1 + i, value)

    GetMuPrimary, GetMuSecondary, GetMuTorsion = MuPrimary, MuSecondary, MuTorsion


class SurfaceParams:
    """Contact parameters of a collision; the engine's values are read and written directly.

    They are attributes: kp, kd, slip1, slip2, bounce, bounceThreshold, maxVel, minDepth, collideBitmask,
    collideWithoutContact (contacts are reported, and have no force) and collideWithoutContactBitmask.
    """

    # ODESurfaceParams' names -> columns of the engine's surface table.
    _COLUMNS: ClassVar[dict[str, Surface]] = {
        "kp": Surface.KP,
        "kd": Surface.KD,
        "slip1": Surface.SLIP1,
        "slip2": Surface.SLIP2,
        "bounce": Surface.BOUNCE,
        "bounceThreshold": Surface.BOUNCE_VEL,
        "maxVel": Surface.MAX_VEL,
        "minDepth": Surface.MIN_DEPTH,
        "collideBitmask": Surface.BITS,
        "collideWithoutContact": Surface.GHOST,
        "collideWithoutContactBitmask": Surface.GHOST_BITS,
    }
    _TYPES: ClassVar[dict[str, type]] = {
        "collideBitmask": int,
        "collideWithoutContact": bool,
        "collideWithoutContactBitmask": int,
    }

    def __init__(self, geom: Geom) -> None:
        object.__setattr__(self, "_geom", geom)
        object.__setattr__(self, "_friction", FrictionPyramid(geom))

    def __getattr__(self, name: str) -> Any:
        if name not in self._COLUMNS:
            raise AttributeError(f"a surface has no {name!r}; it has {', '.join(self._COLUMNS)}")
        return self._TYPES.get(name, float)(self._geom.surface(self._COLUMNS[name]))

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._COLUMNS]

    def __setattr__(self, name: str, value: float) -> None:
        if name not in self._COLUMNS:
            raise AttributeError(f"a surface has no {name!r}; it has {', '.join(self._COLUMNS)}")
        if not value >= 0.0:
            raise ParameterError(f"{name} is {value!r}; it must not be negative")
        self._geom.set_surface(self._COLUMNS[name], float(value))

    def FrictionPyramid(self) -> FrictionPyramid:
        """The friction coefficients."""
        return self._friction  # type: ignore[no-any-return]

    GetFrictionPyramid = FrictionPyramid


@takes_names
class Collision(Entity):
    """A view on a Geom."""

    STATE = ("_bits",)

    entity_type = Base.ENTITY | Base.COLLISION

    def __init__(self, link: Link, geom: Geom) -> None:
        name = link.model.geom_name(geom)
        super().__init__(link.GetWorld(), name, link)
        self.link, self.geom = link, geom
        self._sdf = link.model.geom_sdf(geom)
        self._bits = geom.surface(Surface.BITS)
        self._shape, self._surface = shape_of(geom, self._sdf), SurfaceParams(geom)  # plugins keep weak pointers

    def pose(self) -> GzPose:
        """Global pose [m]."""
        return self.geom.GetPose()

    def move(self, pose: GzPose) -> None:
        """Set the global pose [m]; from then on it moves with its link."""
        self.geom.SetRelativePose(GzCoordPoseSub(pose, self.geom.body.GetPose()), updateCoM=False)

    def IsStatic(self) -> bool:
        """Whether its model is static."""
        return self.link.IsStatic()

    # Velocities and accelerations are those of the link, as in Gazebo, not of the collision's own origin and frame.

    def WorldLinearVel(self, offset: VectorLike | None = None) -> Vector3d:
        """Linear velocity of its link's origin [m/s], in the world frame."""
        return self.link.WorldLinearVel()

    def RelativeLinearVel(self) -> Vector3d:
        """Linear velocity of its link's origin [m/s], in the link frame."""
        return self.link.RelativeLinearVel()

    def RelativeAngularVel(self) -> Vector3d:
        """Angular velocity of its link [rad/s], in the link frame."""
        return self.link.RelativeAngularVel()

    def RelativeLinearAccel(self) -> Vector3d:
        """Linear acceleration of its link in the last step [m/s^2], in the link frame."""
        return self.link.RelativeLinearAccel()

    def RelativeAngularAccel(self) -> Vector3d:
        """Angular acceleration of its link in the last step [rad/s^2], in the link frame."""
        return self.link.RelativeAngularAccel()

    GetRelativeLinearVel, GetRelativeAngularVel = RelativeLinearVel, RelativeAngularVel
    GetRelativeLinearAccel, GetRelativeAngularAccel = RelativeLinearAccel, RelativeAngularAccel

    def WorldAngularVel(self) -> Vector3d:
        """Angular velocity [rad/s], in the world frame."""
        return self.link.WorldAngularVel()

    def WorldLinearAccel(self) -> Vector3d:
        """Linear acceleration of its link's centre of mass in the last step [m/s^2], in the world frame."""
        return self.link.WorldLinearAccel()

    def WorldAngularAccel(self) -> Vector3d:
        """Angular acceleration in the last step [rad/s^2], in the world frame."""
        return self.link.WorldAngularAccel()

    def GetLink(self) -> Link:
        """The link."""
        return self.link

    def GetModel(self) -> Model:
        """The model."""
        return self.link.model

    def GetShape(self) -> Shape:
        """Its shape."""
        return self._shape

    def GetShapeType(self) -> int:
        """The bit mask of its shape's types; see Shape.HasType."""
        return self.GetShape().GetType()

    def GetSurface(self) -> SurfaceParams:
        """The contact parameters."""
        return self._surface

    def BoundingBox(self) -> AxisAlignedBox:
        """Its axis-aligned bounding box [m], in the world frame; around the box of a cylinder, as in Gazebo."""
        if isinstance(self.geom, CylinderGeom):
            return self._box_of_cylinder(self.geom)
        low, high = self.geom.bounds()
        return AxisAlignedBox(Vector3d(*low), Vector3d(*high))

    @staticmethod
    def _box_of_cylinder(geom: CylinderGeom) -> AxisAlignedBox:
        pose = geom.GetPose()
        sides = (geom.radius, geom.radius, 0.5 * geom.length)
        columns = [rotate(pose.rot, GzVector(*(s if i == j else 0.0 for j in range(3)))) for i, s in enumerate(sides)]
        half = Vector3d(*(sum(abs(column[i]) for column in columns) for i in range(3)))
        return AxisAlignedBox(Vector3d(*pose.pos) - half, Vector3d(*pose.pos) + half)

    def SetCategoryBits(self, bits: int) -> None:
        """Set the category bits."""
        self.geom.SetCategoryBits(bits)

    def SetCollideBits(self, bits: int) -> None:
        """Set the bits of the categories it collides with."""
        self.geom.SetCollideBits(bits)

    def SetCollideMode(self, mode: str) -> None:
        """Set the mode: ``all``, ``fixed``: contacts by its bitmask; ``none``, ``sensors``, ``ghost``: no contacts.

        Raises:
            ParameterError: there is no such mode.
        """
        if mode not in MODES:
            raise ParameterError(f"collide mode {mode!r} is not known; allowed are {', '.join(MODES)}")
        now = self.geom.surface(Surface.BITS)
        self._bits = now or self._bits  # 0 while the mode allows no contacts
        self._world.server.activity.edited[self] = None
        self.geom.set_surface(Surface.BITS, self._bits if MODES[mode] else 0.0)

    def forget_edits(self) -> None:
        """Be as if no mode had been set: a state is loaded that has none. The engine has the bitmask."""

    def SetMaxContacts(self, maxContacts: int) -> None:
        """Set the maximum number of contact points with another collision."""
        self.geom.set_surface(Surface.MAX_CONTACTS, float(maxContacts))

    def GetMaxContacts(self) -> int:
        """The maximum number of contact points with another collision."""
        return int(self.geom.surface(Surface.MAX_CONTACTS))

    def SetLaserRetro(self, retro: float) -> None:
        """Set the laser retro value: the intensity of returned laser rays."""
        self.geom.SetRetro(retro)

    def GetLaserRetro(self) -> float:
        """The laser retro value: the intensity of returned laser rays."""
        return self.geom.GetRetro()

    def SetScale(self, scale: VectorLike) -> None:
        """Scale it to this multiple of its first size."""
        self.GetShape().SetScale(scale)
