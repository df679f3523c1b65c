"""WideAngleCameraSensor: a camera whose lens has a wide angle, such as a fisheye."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPositionSub, VectorLike
from libgz.classic.math import Vector2i, Vector3d
from libgz.classic.rendering.camera import Camera
from libgz.classic.sensors.camera import CameraSensor
from libgz.classic.sensors.camera_sdf import NARROWEST
from libgz.classic.sensors.read import count, first, number, substituted
from libgz.rendering.camera import Camera as CoreCamera
from libgz.rendering.wide_camera import PROJECTIONS, Projection, WideCamera

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.sensor import SensorOwner
    from libgz.sdf.element import Element

__all__ = ["WideAngleCameraSensor"]

MOST_TEXTURE = 4096  # [px]


class WideAngleCamera(Camera):
    """A camera whose lens has a wide angle: a view on a `WideCamera`. Arguments as for `Camera`."""

    core_type: ClassVar[type[CoreCamera]] = WideCamera
    core: WideCamera

    def Project(self, pt: VectorLike) -> Vector2i:
        """The pixel of a global point [m], from the upper left; (-1, -1) for one that is not shown."""
        place = self.core.project(*GzCoordPositionSub(pt, self.core.pose.pos, self.core.pose.rot))
        return Vector2i(-1, -1) if place is None else Vector2i(*map(math.floor, place))

    def CameraToViewportRay(self, screenx: float, screeny: float) -> tuple[Vector3d, Vector3d]:
        """(start [m], global unit vector) of the line of sight through a pixel; NaN where the image shows nothing."""
        (way,) = self.core.directions(np.array([float(screenx)]), np.array([float(screeny)]))
        return self.WorldPosition(), self._axis(*map(float, way))

    GetCameraToViewportRay = CameraToViewportRay


class WideAngleCameraSensor(CameraSensor):
    """Takes images along +x of its pose, through the lens that `<lens>` describes: r = c1 f fun(angle / c2 + c3)."""

    camera_type: ClassVar[type[Camera]] = WideAngleCamera
    widest: ClassVar[float] = 2.0 * math.pi

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._lens = _Lens(sdf.child("camera"), self._plan.hfov)

    def Init(self) -> None:
        """Open the camera, and give it the lens."""
        super().Init()
        core: Any = self.Camera().core
        core.projection, core.scale_to_hfov = self._lens.projection, self._lens.scale_to_hfov
        core.cutoff, core.texture_size = self._lens.cutoff, self._lens.texture_size


class _Lens:
    """The checked values of a `<lens>`; without one, that of SDF's defaults."""

    def __init__(self, camera: Element, hfov: float) -> None:
        self.projection, self.scale_to_hfov = PROJECTIONS["stereographic"], True
        self.cutoff, self.texture_size = math.pi / 2.0, 256
        lens = first(camera, "lens")
        if lens is None:
            return
        self.scale_to_hfov = lens.Get(bool, "scale_to_hfov")
        self.cutoff = number(lens, "cutoff_angle", NARROWEST, math.pi, "rad")
        self.texture_size = count(lens, "env_texture_size", most=MOST_TEXTURE)
        try:
            found = _projection(lens)
            if self.scale_to_hfov:
                found.scaled(hfov)
            self.projection = found
        except ParameterError as error:
            substituted(lens, "type", f"{error}: stereographic is used")


def _projection(lens: Element) -> Projection:
    kind = lens.Get(str, "type").strip()
    if kind != "custom":
        if kind not in PROJECTIONS:
            raise ParameterError(f"there is no lens {kind!r}; allowed are {', '.join(PROJECTIONS)} and custom")
        return PROJECTIONS[kind]
    custom = first(lens, "custom_function")
    if custom is None:
        raise ParameterError("a custom lens needs a <custom_function>")
    c1, c2, c3, f = (custom.Get(float, key) for key in ("c1", "c2", "c3", "f"))
    return Projection(c1, c2, c3, f, custom.Get(str, "fun").strip())
