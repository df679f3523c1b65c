"""FollowerPlugin: a robot with two wheels follows what its depth camera sees nearest."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.base.errors import NotFoundError
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint
from libgz.classic.plugins._wheels import Wheel, separation
from libgz.classic.sensors import SensorManager

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

RANGE = 0.5, 5.0  # [m]: it stops at the first one, and does not see beyond the second one
SPEED = 0.5  # forward [m/s], at most
TURN = 1.0  # [rad/s], at most


class FollowerPlugin(ModelPlugin):
    """Drives towards the nearest point in the middle row of the model's depth camera, and turns to it.

    The speed is 0.5 m/s for a point 5 m away and decreases to zero at 0.5 m; the turn rate is 1 rad/s for a point at
    the edge of the image. Nothing within 5 m: the wheels stop.

    Elements:
        left_joint, right_joint: names of the wheels' joints; without them, the first two joints whose names have
            `left` and `right`.
    """

    STATE = ("command",)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the wheels and the camera.

        Raises:
            NotFoundError: there are no wheels, or no depth camera.
        """
        left, right = (self._joint(model, sdf, side) for side in ("left", "right"))
        self.separation = separation(left, right)
        self.left = Wheel(left)
        self.right = Wheel(right, radius=self.left.radius)
        name = f"{model.GetScopedName()}::"
        sensors: list[Any] = [
            s for s in SensorManager.Instance().GetSensors() if s.Type() == "depth" and name in s.ScopedName()
        ]
        if not sensors:
            raise NotFoundError(f"{sdf.where}: depth sensor not found! Model {model.GetName()!r} has none")
        self.Reset()
        self.camera = sensors[0].DepthCamera()
        sensors[0].SetActive(True)
        self.connections = [
            self.camera.ConnectNewDepthFrame(self.OnNewDepthFrame),
            Events.ConnectWorldUpdateBegin(self.OnUpdate),
        ]

    @staticmethod
    def _joint(model: Model, sdf: Element, side: str) -> Joint:
        if sdf.HasElement(f"{side}_joint"):
            return named_joint(model, sdf, f"{side}_joint")
        found = next((joint for joint in model.all_joints() if side in joint.GetName()), None)
        if found is None:
            raise NotFoundError(
                f"{sdf.where}: left or right joint not found! Model {model.GetName()!r} has no joint with {side!r} in "
                f"its name, and the plugin no <{side}_joint>"
            )
        return found

    def Reset(self) -> None:
        """Stop."""
        self.command = (0.0, 0.0)  # speed [m/s], turn rate [rad/s] to the left

    def OnNewDepthFrame(self, data: Any, width: int, height: int, depth: int, image_format: str) -> None:
        """Choose speed and turn rate by the nearest point."""
        row = np.asarray(data).reshape(height, width)[height // 2]
        column = int(np.argmin(row))
        distance, (near, far) = float(row[column]), RANGE
        if not 0.0 < distance < far:
            self.command = (0.0, 0.0)
            return
        self.command = (
            SPEED * max(0.0, (distance - near) / (far - near)),
            TURN * (1.0 - (column + 0.5) / (0.5 * width)),
        )

    def OnUpdate(self) -> None:
        """Run the wheels."""
        speed, turn = self.command
        self.left.run(speed - turn * self.separation / 2.0)
        self.right.run(speed + turn * self.separation / 2.0)


GZ_REGISTER_MODEL_PLUGIN(FollowerPlugin)
