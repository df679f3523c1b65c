"""Light: a light as it is rendered."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError, nearest
from libgz.base.geometry import GzColor, GzPose, GzVector, QuaternLike, VectorLike, place_of
from libgz.classic.math import Color, Pose3d, Quaterniond, Vector3d
from libgz.classic.names import takes_names
from libgz.physics.geoms import LightGeom
from libgz.sdfworld.visual import KINDS

if TYPE_CHECKING:
    from libgz.sdfworld.light import SdfLight

__all__ = ["Light"]


@takes_names
class Light:
    """A view on a `LightGeom` of a light in the world."""

    def __init__(self, core: SdfLight) -> None:
        self.core = core
        self.geom: LightGeom = core.light

    def __repr__(self) -> str:
        return f"<Light {self.Name()!r}{place_of(self)}>"

    def Name(self) -> str:
        """Its name."""
        return self.core.GetId()

    GetName = Name

    def GetId(self) -> int:
        """Its number in the world."""
        return self.core.GetIntId()

    def Type(self) -> str:
        """point, directional or spot."""
        return self.geom.kind

    GetType = LightType = Type

    def SetLightType(self, type: str) -> None:
        """Make it a point, directional or spot light.

        Raises:
            ParameterError: it is none of these.
        """
        if type not in KINDS:
            raise ParameterError(f"light {self.Name()!r}: there is no type {type!r}{nearest(type, KINDS)}")
        self.geom.kind = type

    def DiffuseColor(self) -> Color:
        """The colour of its light."""
        return Color(*self.geom.GetDiffuseColor())

    GetDiffuseColor = DiffuseColor

    def SetDiffuseColor(self, color: GzColor) -> None:
        """Set the colour of its light."""
        self.geom.SetDiffuseColor(color)

    def SpecularColor(self) -> Color:
        """The colour of its highlights."""
        return Color(*self.geom.GetSpecularColor())

    GetSpecularColor = SpecularColor

    def SetSpecularColor(self, color: GzColor) -> None:
        """Set the colour of its highlights."""
        self.geom.SetSpecularColor(color)

    def Direction(self) -> Vector3d:
        """The direction of its light, in its own frame."""
        return Vector3d(*self.geom.direction)

    GetDirection = Direction

    def SetDirection(self, dir: VectorLike) -> None:
        """Set the direction of its light, in its own frame."""
        self.geom.direction = GzVector(*dir)

    def SetAttenuation(self, constant: float, linear: float, quadratic: float) -> None:
        """Set the constant, linear [1/m] and quadratic [1/m^2] attenuation with distance."""
        self.geom.SetAttenuation((constant, linear, quadratic))

    def Range(self) -> float:
        """The distance up to which it has an effect [m]."""
        return self.geom.range

    def SetRange(self, range: float) -> None:
        """Set the distance up to which it has an effect [m]."""
        self.geom.range = float(range)

    def SetSpotInnerAngle(self, angle: float) -> None:
        """Set the angle of the fully lit cone [rad]."""
        self.geom.spot = (float(angle), *self.geom.spot[1:])

    def SetSpotOuterAngle(self, angle: float) -> None:
        """Set the angle of the whole lit cone [rad]."""
        self.geom.spot = (self.geom.spot[0], float(angle), self.geom.spot[2])

    def SetSpotFalloff(self, value: float) -> None:
        """Set the exponent of the falloff between both angles."""
        self.geom.spot = (*self.geom.spot[:2], float(value))

    def WorldPose(self) -> Pose3d:
        """Global pose [m]."""
        return Pose3d(self.core.GetPose())

    def Position(self) -> Vector3d:
        """Global position [m]."""
        return self.WorldPose().Pos()

    GetPosition = Position

    def SetPosition(self, p: VectorLike) -> None:
        """Move it [m]."""
        self.core.GetBody().SetPose(GzPose(GzVector(*p), self.core.GetPose().rot))

    def Rotation(self) -> Quaterniond:
        """Global rotation."""
        return self.WorldPose().Rot()

    GetRotation = Rotation

    def SetRotation(self, q: QuaternLike) -> None:
        """Turn it."""
        self.core.GetBody().SetPose(Pose3d(self.core.GetPose().pos, q))

    def Visible(self) -> bool:
        """Whether it is switched on."""
        return self.geom.appearance.visible

    def CastShadows(self) -> bool:
        """Whether bodies cast shadows in its light."""
        return self.geom.cast_shadows

    GetCastShadows = CastShadows

    def SetCastShadows(self, cast: bool) -> None:
        """Set whether bodies cast shadows in its light."""
        self.geom.cast_shadows = bool(cast)

    def SetVisible(self, visible: bool) -> None:
        """Switch it on or off."""
        self.geom.appearance.visible = bool(visible)
        self.geom.appearance.version += 1

    ToggleVisual = SetVisible
