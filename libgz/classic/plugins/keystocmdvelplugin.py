"""KeysToCmdVelPlugin: drives wheels by keys."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.common import gzwarn
from libgz.classic.math import Pose3d, Vector3d, clamp
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

# Space and Enter; arrows, by their numbers in two systems.
KEYS = {
    "stop": {13, 32},
    "accelerate": {38, 16777235},
    "decelerate": {40, 16777237},
    "left": {37, 16777234},
    "right": {39, 16777236},
}


class KeysToCmdVelPlugin(ModelPlugin):
    """Subscribes to ~/keyboard/keypress and publishes speed and turn rate: a Pose for libDiffDrivePlugin, or a Twist.

    Each press changes the command by a step. As in Gazebo, the key for left makes the yaw smaller.

    Elements:
        cmd_vel_topic: topic of the commands (~/cmd_vel); `~/<model>/vel_cmd` for libDiffDrivePlugin.
        publish_as_twist: whether the commands are of type Twist (false).
        max_linear_vel, min_linear_vel: [m/s] (1, and -max_linear_vel).
        max_angular_vel: [rad/s] (1).
        linear_increment, angular_increment: change per key press [m/s] (0.5), [rad/s] (0.5).
        key_controls: numbers of keys, as `stop`, `accelerate`, `decelerate`, `left`, `right` elements, several of each;
            without it arrows, Space and Enter.
    """

    STATE = ("speed", "turn")

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the elements, and subscribe to keys."""
        topic = self.LoadParam(sdf, "cmd_vel_topic", "~/cmd_vel")
        self.max_speed = self.LoadParam(sdf, "max_linear_vel", 1.0)
        self.min_speed = self.LoadParam(sdf, "min_linear_vel", -self.max_speed)
        self.max_turn = self.LoadParam(sdf, "max_angular_vel", 1.0)
        self.increment = self.LoadParam(sdf, "linear_increment", 0.5)
        self.turn_increment = self.LoadParam(sdf, "angular_increment", 0.5)
        self.keys = KEYS
        controls = next(sdf.named("key_controls"), None)
        if controls is not None and controls.children:
            self.keys = {name: {element.Get(int) for element in controls.named(name)} for name in KEYS}
            for name, numbers in self.keys.items():
                if not numbers:
                    gzwarn(f"{controls.where}: Key {name} has no assigned keycode.")
        self.Reset()
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.message = msgs.Twist if self.LoadParam(sdf, "publish_as_twist", False) else msgs.Pose
        self.publisher = self.node.Advertise(self.message, topic)
        self.subscriber = self.node.Subscribe("~/keyboard/keypress", self.OnKeyPress, kind="Any")

    def OnKeyPress(self, message: Any) -> None:
        """A key was pressed."""
        pressed = {name for name, numbers in self.keys.items() if message.int_value in numbers}
        if not pressed:
            return
        if "stop" in pressed:
            self.speed = self.turn = 0.0
        else:
            faster = ("accelerate" in pressed) - ("decelerate" in pressed)
            right = ("right" in pressed) - ("left" in pressed)
            self.speed = clamp(self.speed + faster * self.increment, self.min_speed, self.max_speed)
            self.turn = clamp(self.turn + right * self.turn_increment, -self.max_turn, self.max_turn)
        self.publisher.Publish(self._command())

    def _command(self) -> Any:
        command = self.message()
        if self.message is msgs.Pose:
            msgs.Set(command, Pose3d(self.speed, 0.0, 0.0, 0.0, 0.0, self.turn))
        else:
            msgs.Set(command.linear, Vector3d(self.speed, 0.0, 0.0))
            msgs.Set(command.angular, Vector3d(0.0, 0.0, self.turn))
        return command

    def Reset(self) -> None:
        """Set the command to zero; it is not published, as the drive plugin is reset, too."""
        self.speed = self.turn = 0.0


GZ_REGISTER_MODEL_PLUGIN(KeysToCmdVelPlugin)
