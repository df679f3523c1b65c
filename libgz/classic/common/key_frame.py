"""KeyFrame: a time of an animation, and the value at it."""

from __future__ import annotations

from libgz.base.geometry import QuaternLike, VectorLike
from libgz.classic.math.quaternion import Quaterniond
from libgz.classic.math.vector3 import Vector3d

__all__ = ["KeyFrame", "NumericKeyFrame", "PoseKeyFrame"]


class KeyFrame:
    """A time of an animation [s]."""

    __slots__ = ("time",)

    def __init__(self, time: float = 0.0) -> None:
        self.time = float(time)

    def GetTime(self) -> float:
        """The time [s]."""
        return self.time

    Time = GetTime


class NumericKeyFrame(KeyFrame):
    """A time [s] and a number, such as a joint's angle [rad]."""

    __slots__ = ("value",)

    def __init__(self, time: float = 0.0, value: float = 0.0) -> None:
        super().__init__(time)
        self.value = value

    def Value(self, value: float | None = None) -> float:
        """The number; an argument sets it first."""
        if value is not None:
            self.value = value
        return self.value

    def __repr__(self) -> str:
        return f"NumericKeyFrame({self.time!r}, {self.value!r})"

    GetValue = SetValue = Value


class PoseKeyFrame(KeyFrame):
    """A time [s], a position [m] and a rotation."""

    __slots__ = ("rotation", "translation")

    def __init__(
        self, time: float = 0.0, translation: VectorLike = (0.0, 0.0, 0.0), rotation: QuaternLike = (1.0, 0.0, 0.0, 0.0)
    ) -> None:
        super().__init__(time)
        self.translation = Vector3d(translation)
        self.rotation = Quaterniond(rotation)

    def Translation(self, translation: VectorLike | None = None) -> Vector3d:
        """The position [m]; an argument sets it first."""
        if translation is not None:
            self.translation = Vector3d(translation)
        return self.translation

    def Rotation(self, rotation: QuaternLike | None = None) -> Quaterniond:
        """The rotation; an argument sets it first."""
        if rotation is not None:
            self.rotation = Quaterniond(rotation)
        return self.rotation

    def __repr__(self) -> str:
        return f"PoseKeyFrame({self.time!r}, {self.translation!r}, {self.rotation!r})"

    GetTranslation = SetTranslation = Translation
    GetRotation = SetRotation = Rotation
