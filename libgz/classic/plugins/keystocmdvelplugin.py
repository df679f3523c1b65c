"""KeysToCmdVelPlugin: makes commands for wheels from keys."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.common import gzwarn
from libgz.classic.math import Pose3d, clamp
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
    """Takes keys from ~/keyboard/keypress and publishes a Pose with speed and turn rate, for libDiffDrivePlugin.

    Each press changes the command by a step. As in Gazebo, the key for left makes the yaw smaller.

    Elements:
        cmd_vel_topic: where the commands go (~/cmd_vel); `~/<model>/vel_cmd` for libDiffDrivePlugin.
        max_linear_vel, min_linear_vel: [m/s] (1, and minus the former).
        max_angular_vel: [rad/s] (1).
        linear_increment, angular_increment: of a press [m/s] (0.5), [rad/s] (0.5).
        key_controls: numbers of keys, as `stop`, `accelerate`, `decelerate`, `left`, `right` elements, several of each;
            without it arrows, Space and Enter.
    """

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the keys, and listen."""
        topic = self.LoadParam(sdf, "cmd_vel_topic", "~/cmd_vel")
        self.fastest = self.LoadParam(sdf, "max_linear_vel", 1.0)
        self.slowest = self.LoadParam(sdf, "min_linear_vel", -self.fastest)
        self.quickest = self.LoadParam(sdf, "max_angular_vel", 1.0)
        self.step = self.LoadParam(sdf, "linear_increment", 0.5)
        self.turn_step = self.LoadParam(sdf, "angular_increment", 0.5)
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
        self.publisher = self.node.Advertise(msgs.Pose, topic)
        self.subscriber = self.node.Subscribe("~/keyboard/keypress", self.OnKeyPress)

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
            self.speed = clamp(self.speed + faster * self.step, self.slowest, self.fastest)
            self.turn = clamp(self.turn + right * self.turn_step, -self.quickest, self.quickest)
        command = msgs.Pose()
        msgs.Set(command, Pose3d(self.speed, 0.0, 0.0, 0.0, 0.0, self.turn))
        self.publisher.Publish(command)

    def Reset(self) -> None:
        """Stand still; whoever drives is reset as well."""
        self.speed = self.turn = 0.0


GZ_REGISTER_MODEL_PLUGIN(KeysToCmdVelPlugin)
