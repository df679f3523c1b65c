"""DiffDrivePlugin: drives a model with two wheels, commanded on a topic."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.law import law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._drive import DrivePlugin
from libgz.classic.plugins._names import named_joint
from libgz.classic.plugins._wheels import Wheel, separation

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class DiffDrivePlugin(DrivePlugin):
    """Drives a model with two wheels.

    ~/<model>/vel_cmd takes a Pose: x of the position is the speed [m/s], yaw of the orientation the turn rate [rad/s].
    As in Gazebo, **a positive yaw turns to the right**: the left wheel runs with speed + yaw * separation / 2. The
    separation is the distance between the joints, the wheels' radius that of the left one. A command is valid
    until the next one; a reset stops the wheels.

    Elements:
        left_joint, right_joint: names of the joints (also leftJoint, rightJoint).
        torque: maximum torque of each wheel's motor [N m]; without it the velocity of the wheels is set directly, as
            in Gazebo from version 5 on.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and subscribe."""
        torque = sdf.Get(float, "torque", 0.0)[0]
        left = named_joint(model, sdf, "left_joint", "leftJoint")
        right = named_joint(model, sdf, "right_joint", "rightJoint")
        self.separation = separation(left, right)
        self.left = Wheel(left, torque)
        self.right = Wheel(right, torque, self.left.radius)
        self.listen(model)

    @law
    def OnUpdate(self) -> None:
        """Run the wheels."""
        half = self.turn * self.separation / 2.0
        self.left.run(self.speed + half)
        self.right.run(self.speed - half)


GZ_REGISTER_MODEL_PLUGIN(DiffDrivePlugin)
