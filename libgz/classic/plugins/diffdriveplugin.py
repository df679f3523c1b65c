"""DiffDrivePlugin: drives a model with two wheels, commanded on a topic."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.law import Number, law
from libgz.classic.event import Events
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
    until the next one; a reset stops the wheels. The wheels get their velocities at the beginning of each iteration, as
    in Gazebo from version 5 on.

    Elements:
        left_joint, right_joint: names of the joints (also leftJoint, rightJoint).
        torque: without effect, as in Gazebo from version 5 on.
    """

    STATE = ("speed", "turn")

    speed = Number()  # commanded, forward [m/s]
    turn = Number()  # commanded yaw rate [rad/s], with the sign of the message

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and subscribe."""
        left = named_joint(model, sdf, "left_joint", "leftJoint")
        right = named_joint(model, sdf, "right_joint", "rightJoint")
        self.separation = separation(left, right)
        self.left = Wheel(left)
        self.right = Wheel(right, radius=self.left.radius)
        self.listen(model)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def command(self, speed: float, turn: float) -> None:
        """Obey a command."""
        self.speed, self.turn = speed, turn

    def Reset(self) -> None:
        """Set the command to zero."""
        self.command(0.0, 0.0)

    @law
    def OnUpdate(self) -> None:
        """Run the wheels."""
        half = self.turn * self.separation / 2.0
        self.left.run(self.speed + half)
        self.right.run(self.speed - half)


GZ_REGISTER_MODEL_PLUGIN(DiffDrivePlugin)
