"""SkidSteerDrivePlugin: drives a model with four wheels, commanded on a topic."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.law import law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._drive import DrivePlugin
from libgz.classic.plugins._names import find_joint
from libgz.classic.plugins._wheels import Wheel, radius_of, separation

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class SkidSteerDrivePlugin(DrivePlugin):
    """Drives a model whose four wheels do not steer.

    The joints are called right_front, right_rear, left_front and left_rear. ~/<model>/vel_cmd takes a Pose: x of the
    position is the speed [m/s], yaw of the orientation the turn rate [rad/s], left positive. As in Gazebo, the sides
    run with speed -+ yaw * separation: twice the ideal value, because skidding wheels turn the body less. Separation
    and radius are those of the front wheels. A command is valid until the next one.

    Elements:
        max_force: maximum torque of each wheel's motor [N m]; without it the velocity of the wheels is set directly.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the wheels, and subscribe."""
        torque = sdf.Get(float, "max_force", 0.0)[0]
        joints = {name: find_joint(model, name) for name in ("right_front", "right_rear", "left_front", "left_rear")}
        self.separation = separation(joints["right_front"], joints["left_front"])
        radius = radius_of(joints["right_front"].GetChild())
        wheels = {name: Wheel(joint, torque, radius) for name, joint in joints.items()}
        self.right = wheels["right_front"], wheels["right_rear"]
        self.left = wheels["left_front"], wheels["left_rear"]
        self.listen(model)

    @law
    def OnUpdate(self) -> None:
        """Run the wheels."""
        for wheel in self.right:
            wheel.run(self.speed + self.turn * self.separation)
        for wheel in self.left:
            wheel.run(self.speed - self.turn * self.separation)


GZ_REGISTER_MODEL_PLUGIN(SkidSteerDrivePlugin)
