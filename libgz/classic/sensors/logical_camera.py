"""LogicalCameraSensor: which models are in sight, without an image."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzCoordPoseSub, rotate
from libgz.classic import msgs
from libgz.classic.math import Angle, Pose3d
from libgz.classic.sensors.read import clip, number
from libgz.classic.sensors.sensor import LinkSensor, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.math import AxisAlignedBox
    from libgz.classic.physics import Link, Model
    from libgz.sdf.element import Element

__all__ = ["LogicalCameraSensor"]


class LogicalCameraSensor(LinkSensor):
    """Names the models whose bounding box reaches into its field of view, with their poses; it looks along +x.

    A model without collisions counts as a point. Its own model is left out, and models do not hide each other. Nested
    models are named by themselves, too, as ``outer::inner``.
    """

    STATE = (
        "_camera_pose",
        "_seen",
    )

    topic_suffix: ClassVar[str | None] = "models"
    message_type: ClassVar[Any] = msgs.LogicalCameraImage

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        camera = sdf.child("logical_camera")
        self._near, self._far = clip(camera, "near", "far")
        self._hfov = number(camera, "horizontal_fov", 1e-6, math.pi - 1e-6, "rad")
        self._aspect = number(camera, "aspect_ratio", 1e-6)
        self._camera_pose = Pose3d()
        self._seen: list[tuple[str, Pose3d]] = []

    def measure(self, elapsed: float) -> None:
        """Find the models in sight."""
        self._camera_pose = pose = Pose3d(self.world_pose())
        planes = self._planes(pose)
        self._seen = []
        self._find(self.world.Models(), pose, planes)

    def _find(self, models: list[Model], pose: Pose3d, planes: NDArray[np.float64]) -> None:
        """Add those of some models, and of the models nested in them, that are in sight."""
        own = self.link.model_around()
        for model in models:
            if model is not own and _reaches_in(_corners(model.BoundingBox(), model.pose().pos), planes):
                self._seen.append((model.GetScopedName(), Pose3d(GzCoordPoseSub(model.pose(), pose))))
            self._find(model.NestedModels(), pose, planes)

    def _planes(self, pose: Pose3d) -> NDArray[np.float64]:
        """The six sides as (inward normal, distance), shape (6, 4), global."""
        across, up = self._hfov / 2.0, math.atan(math.tan(self._hfov / 2.0) / self._aspect)
        local = [
            (1.0, 0.0, 0.0, -self._near),
            (-1.0, 0.0, 0.0, self._far),
            *((math.sin(across), side * math.cos(across), 0.0, 0.0) for side in (1.0, -1.0)),
            *((math.sin(up), 0.0, side * math.cos(up), 0.0) for side in (1.0, -1.0)),
        ]
        planes = []
        for x, y, z, distance in local:
            normal = rotate(pose.rot, (x, y, z))
            planes.append((*normal, distance - sum(n * p for n, p in zip(normal, pose.pos, strict=True))))
        return np.array(planes)

    def message(self) -> Any:
        """The models in sight: a msgs.LogicalCameraImage."""
        msg = msgs.LogicalCameraImage()
        msgs.Set(msg.pose, self._camera_pose)
        model_type = msgs.message_type("LogicalCameraImage.Model")
        for name, pose in self._seen:
            model = model_type(name=name)
            msgs.Set(model.pose, pose)
            msg.model.append(model)
        return msg

    Image = message

    def FillMsg(self, msg: Any) -> None:
        """Describe the sensor and its field of view in a msgs.Sensor."""
        super().FillMsg(msg)
        about = msg.logical_camera
        about.near_clip, about.far_clip = self.Near(), self.Far()
        about.horizontal_fov, about.aspect_ratio = float(self.HorizontalFOV()), self.AspectRatio()

    def Near(self) -> float:
        """Nearest that is in sight [m]."""
        return self._near

    def Far(self) -> float:
        """Farthest that is in sight [m]."""
        return self._far

    def HorizontalFOV(self) -> Angle:
        """Horizontal field of view [rad]."""
        return Angle(self._hfov)

    def AspectRatio(self) -> float:
        """Width over height."""
        return self._aspect


def _corners(box: AxisAlignedBox, place: Any) -> NDArray[np.float64]:
    """The corners of a box, or a point where there is no box, shape (n, 3)."""
    low, high = np.array(box.Min()), np.array(box.Max())
    if not np.all(low <= high):
        return np.array([tuple(place)])
    return np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)])


def _reaches_in(corners: NDArray[np.float64], planes: NDArray[np.float64]) -> bool:
    """Whether no side has all corners outside."""
    finite = np.clip(corners, -1e9, 1e9)  # ground planes are infinite
    outside = finite @ planes[:, :3].T + planes[:, 3] < 0.0
    return not bool(np.any(np.all(outside, axis=0)))
