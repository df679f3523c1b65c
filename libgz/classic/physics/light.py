"""Light: a light of a world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.geometry import GzColor, GzPose, GzVector, VectorLike
from libgz.classic.math import AxisAlignedBox, Color, Pose3d, Vector3d
from libgz.classic.physics.base import Base, Entity

if TYPE_CHECKING:
    from libgz.classic.physics.world import World
    from libgz.sdfworld.light import SdfLight

__all__ = ["Light"]


class Light(Entity):
    """A view on a light."""

    entity_type = Base.ENTITY | Base.LIGHT

    def __init__(self, world: World, core: SdfLight) -> None:
        super().__init__(world, core.GetId(), None, core.sdf)
        self.core = core

    def pose(self) -> GzPose:
        """Global pose [m]."""
        return self.core.GetPose()

    def move(self, pose: GzPose) -> None:
        """Set the global pose [m]."""
        self.core.GetBody().SetPose(pose)

    def InitialRelativePose(self) -> Pose3d:
        """The pose that a reset restores [m]: that of the file, unless SetInitialRelativePose set another."""
        return Pose3d(self.core.initPose)

    def SetInitialRelativePose(self, pose: GzPose) -> None:
        """Set the pose that a reset restores [m]."""
        self.core.initPose = GzPose(GzVector(*pose.pos), pose.rot)

    def IsStatic(self) -> bool:
        """Always: nothing moves it but SetWorldPose."""
        return True

    def LightType(self) -> str:
        """point, spot or directional."""
        return self.core.light.kind

    def DiffuseColor(self) -> Color:
        """The diffuse colour."""
        return Color(*self.core.light.GetDiffuseColor())

    def SetDiffuseColor(self, color: GzColor) -> None:
        """Set the diffuse colour."""
        self.core.light.SetDiffuseColor(GzColor(*color))

    def SpecularColor(self) -> Color:
        """The specular colour."""
        return Color(*self.core.light.GetSpecularColor())

    def SetSpecularColor(self, color: GzColor) -> None:
        """Set the specular colour."""
        self.core.light.SetSpecularColor(GzColor(*color))

    def Direction(self) -> Vector3d:
        """The direction of a directional or spot light."""
        return Vector3d(*self.core.light.direction)

    def SetDirection(self, direction: VectorLike) -> None:
        """Set the direction of a directional or spot light."""
        self.core.light.SetDirection(direction)

    def Range(self) -> float:
        """The range [m]."""
        return self.core.light.range

    def SetRange(self, distance: float) -> None:
        """Set the range [m]."""
        self.core.light.SetRange(distance)

    def CastShadows(self) -> bool:
        """Whether bodies cast shadows in its light."""
        return self.core.cast_shadows

    def SetCastShadows(self, cast: bool) -> None:
        """Set whether bodies cast shadows in its light."""
        self.core.light.cast_shadows = bool(cast)

    def Attenuation(self) -> tuple[float, ...]:
        """The constant, linear [1/m] and quadratic [1/m^2] attenuation."""
        return tuple(self.core.light.attenuation)

    def SetAttenuation(self, constant: float, linear: float, quadratic: float) -> None:
        """Set the constant, linear [1/m] and quadratic [1/m^2] attenuation."""
        self.core.light.SetAttenuation((constant, linear, quadratic))

    def BoundingBox(self) -> AxisAlignedBox:
        """An empty box: lights have no extent."""
        return AxisAlignedBox()
