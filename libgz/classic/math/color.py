"""Color: red, green, blue and alpha."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Iterable, Iterator
from numbers import Real

from libgz.base.geometry import GzColor
from libgz.classic.math.components import Componentwise
from libgz.classic.math.constant import Constant
from libgz.classic.math.number import text_of
from libgz.classic.math.vector3 import Vector3d
from libgz.sdf.value import parse

__all__ = ["Color"]


class Color(Componentwise, GzColor):
    """Red, green, blue and alpha, usually 0 to 1. It is a `GzColor`. `==` is exact; `Equal` takes a tolerance."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    White = Constant(lambda: Color(1.0, 1.0, 1.0))
    Black = Constant(lambda: Color(0.0, 0.0, 0.0))
    Red = Constant(lambda: Color(1.0, 0.0, 0.0))
    Green = Constant(lambda: Color(0.0, 1.0, 0.0))
    Blue = Constant(lambda: Color(0.0, 0.0, 1.0))
    Yellow = Constant(lambda: Color(1.0, 1.0, 0.0))
    Magenta = Constant(lambda: Color(1.0, 0.0, 1.0))
    Cyan = Constant(lambda: Color(0.0, 1.0, 1.0))

    def __init__(self, r: float | GzColor = 0.0, g: float = 0.0, b: float = 0.0, a: float = 1.0) -> None:
        """From red, green, blue and alpha, unclamped, or from another colour."""
        if isinstance(r, GzColor):
            r, g, b, a = r
        self.r, self.g, self.b, self.a = r, g, b, a

    @classmethod
    def from_sdf(cls, text: str) -> Color:
        """From the text of an SDF element.

        Raises:
            ParameterError: there are neither three numbers nor four.
        """
        return cls(parse(GzColor, text))

    def R(self, value: float | None = None) -> float:
        """Red; an argument sets it first."""
        if value is not None:
            self.r = value
        return self.r

    def G(self, value: float | None = None) -> float:
        """Green; an argument sets it first."""
        if value is not None:
            self.g = value
        return self.g

    def B(self, value: float | None = None) -> float:
        """Blue; an argument sets it first."""
        if value is not None:
            self.b = value
        return self.b

    def A(self, value: float | None = None) -> float:
        """Alpha; an argument sets it first."""
        if value is not None:
            self.a = value
        return self.a

    def Set(self, r: float = 1.0, g: float = 1.0, b: float = 1.0, a: float = 1.0) -> None:
        """Set all components."""
        self.r, self.g, self.b, self.a = r, g, b, a

    def Reset(self) -> None:
        """Set it to opaque black."""
        self.Set(0.0, 0.0, 0.0, 1.0)

    def Clamp(self) -> None:
        """Clamp all components to 0 to 1, as classic did: values above 1 are divided by 255."""
        self.Set(*(max(0.0, c / 255.0 if c > 1.0 else c) if math.isfinite(c) else 0.0 for c in self))

    def HSV(self) -> Vector3d:
        """Hue [degrees], saturation and value (0 to 1)."""
        h, s, v = colorsys.rgb_to_hsv(self.r, self.g, self.b)
        return Vector3d(h * 360.0, s, v)

    def SetFromHSV(self, h: float, s: float, v: float) -> None:
        """Set it from hue [degrees], saturation and value (0 to 1); alpha stays."""
        self.r, self.g, self.b = colorsys.hsv_to_rgb(h % 360.0 / 360.0, s, v)

    def __iter__(self) -> Iterator[float]:
        return iter((self.r, self.g, self.b, self.a))

    def __repr__(self) -> str:
        return f"Color({self.r!r}, {self.g!r}, {self.b!r}, {self.a!r})"

    def __str__(self) -> str:
        return text_of(self.r, self.g, self.b, self.a)

    def __eq__(self, other: object) -> bool:
        return tuple(self) == tuple(other) if isinstance(other, GzColor) else NotImplemented

    def Equal(self, other: GzColor, tolerance: float = 1e-3) -> bool:
        """Whether no component differs by more than `tolerance`."""
        return all(abs(a - b) <= tolerance for a, b in zip(self, other, strict=True))

    def _operand(self, value: object) -> Iterable[float] | None:
        if isinstance(value, Real):
            return (float(value),) * 4
        return value if isinstance(value, GzColor) else None

    def YUV(self) -> Vector3d:
        """Luma and chroma, 0 to 1 (ITU-R BT.601)."""
        y = 0.299 * self.r + 0.587 * self.g + 0.114 * self.b
        return Vector3d(
            y, min(max(0.492 * (self.b - y), -0.5), 0.5) + 0.5, min(max(0.877 * (self.r - y), -0.5), 0.5) + 0.5
        )

    def _packed(self, order: str) -> int:
        values = {name: round(min(max(getattr(self, name), 0.0), 1.0) * 255.0) for name in "rgba"}
        return int.from_bytes(bytes(values[name] for name in order), "big")

    def _unpack(self, order: str, value: int) -> None:
        for name, byte in zip(order, (int(value) & 0xFFFFFFFF).to_bytes(4, "big"), strict=True):
            setattr(self, name, byte / 255.0)

    def AsRGBA(self) -> int:
        """0xRRGGBBAA."""
        return self._packed("rgba")

    def AsBGRA(self) -> int:
        """0xBBGGRRAA."""
        return self._packed("bgra")

    def AsARGB(self) -> int:
        """0xAARRGGBB."""
        return self._packed("argb")

    def AsABGR(self) -> int:
        """0xAABBGGRR."""
        return self._packed("abgr")

    def SetFromRGBA(self, value: int) -> None:
        """Set it from 0xRRGGBBAA."""
        self._unpack("rgba", value)

    def SetFromBGRA(self, value: int) -> None:
        """Set it from 0xBBGGRRAA."""
        self._unpack("bgra", value)

    def SetFromARGB(self, value: int) -> None:
        """Set it from 0xAARRGGBB."""
        self._unpack("argb", value)

    def SetFromABGR(self, value: int) -> None:
        """Set it from 0xAABBGGRR."""
        self._unpack("abgr", value)

    GetAsHSV, GetAsYUV = HSV, YUV
    RGBA, BGRA, ARGB, ABGR = AsRGBA, AsBGRA, AsARGB, AsABGR
    GetAsRGBA, GetAsBGRA, GetAsARGB, GetAsABGR = AsRGBA, AsBGRA, AsARGB, AsABGR
