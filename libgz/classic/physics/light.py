"""Light: a lamp of a world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.math import AxisAlignedBox, Color, Vector3d
from libgz.classic.physics.base import Base, Entity
from libgz.geometry import GzColor, GzPose, GzVector, VectorLike

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
        """Put it to a global pose [m]."""
        self.core.GetBody().SetPose(pose)

    def LightType(self) -> str:
        """point, spot or directional."""
        return self.core.light.kind

    def DiffuseColor(self) -> Color:
        """The colour of its light."""
        return Color(*self.core.light.GetDiffuseColor())

    def SetDiffuseColor(self, color: GzColor) -> None:
        """Set the colour of its light."""
        self.core.light.SetDiffuseColor(GzColor(*color))

    def SpecularColor(self) -> Color:
        """The colour of its highlights."""
        return Color(*self.core.light.GetSpecularColor())

    def SetSpecularColor(self, color: GzColor) -> None:
        """Set the colour of its highlights."""
        self.core.light.SetSpecularColor(GzColor(*color))

    def Direction(self) -> Vector3d:
        """Where a directional or spot light shines."""
        return Vector3d(*self.core.light.direction)

    def SetDirection(self, direction: VectorLike) -> None:
        """Set where a directional or spot light shines."""
        self.core.light.direction = GzVector(*direction)

    def Range(self) -> float:
        """How far it reaches [m]."""
        return self.core.light.range

    def SetRange(self, distance: float) -> None:
        """Set how far it reaches [m]."""
        self.core.light.range = float(distance)

    def CastShadows(self) -> bool:
        """Whether it is meant to cast shadows."""
        return self.core.cast_shadows

    def Attenuation(self) -> tuple[float, ...]:
        """Constant, linear [1/m] and quadratic [1/m^2] fading."""
        return tuple(self.core.light.attenuation)

    def SetAttenuation(self, constant: float, linear: float, quadratic: float) -> None:
        """Set constant, linear [1/m] and quadratic [1/m^2] fading."""
        self.core.light.SetAttenuation((constant, linear, quadratic))

    def BoundingBox(self) -> AxisAlignedBox:
        """A light has no extent."""
        return AxisAlignedBox()
