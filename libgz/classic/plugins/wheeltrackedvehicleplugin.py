"""WheelTrackedVehiclePlugin: a vehicle whose tracks are rows of driven wheels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._names import find_joint
from libgz.classic.plugins._tracks import TrackedVehiclePlugin
from libgz.classic.plugins._wheels import Wheel, radius_of

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

TORQUE = 1e6  # [N m] of the motors


class WheelTrackedVehiclePlugin(TrackedVehiclePlugin):
    """Drives a vehicle with two rows of wheels, all wheels of a row at one speed; TrackedVehiclePlugin is its base.

    The wheels have motors of any torque. The world's friction model stays as it is; in Gazebo it becomes cone_model,
    without which such a vehicle turns badly there.

    Elements:
        left_joint, right_joint: joints of the wheels, two or more on each side.
        default_wheel_radius: of a wheel without a cylinder or sphere [m] (0.5).
        those of TrackedVehiclePlugin.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the wheels, and subscribe.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: a side has fewer than two wheels, or a joint is no hinge.
        """
        self.listen(model, sdf)
        default = self.LoadParam(sdf, "default_wheel_radius", 0.5)
        self.rows: list[list[Wheel]] = []
        for side in ("left", "right"):
            names = [element.Get(str).strip() for element in sdf.named(f"{side}_joint")]
            if len(names) < 2:
                raise ParameterError(f"{sdf.where}: At least two <{side}_joint> tags have to be specified.")
            self.rows.append([self._wheel(model, sdf, name, default) for name in names])

    def _wheel(self, model: Model, sdf: Element, name: str, default: float) -> Wheel:
        joint = find_joint(model, name)
        if joint.core.kind != "revolute":
            raise ParameterError(f"{sdf.where}: Joint {name!r} is not a hinge (revolute) joint.")
        link = joint.GetChild()
        if link is None:
            raise ParameterError(f"{sdf.where}: Joint {name!r} has no child link that could act as the wheel.")
        self.set_friction(link)
        return Wheel(joint, TORQUE, radius_of(link) or default)

    def OnUpdate(self) -> None:
        """Run the wheels."""
        for row, speed in zip(self.rows, self.speeds, strict=True):
            for wheel in row:
                wheel.run(speed)


GZ_REGISTER_MODEL_PLUGIN(WheelTrackedVehiclePlugin)
