"""What the plugins of ros_control and ros2_control have in common: they let a controller manager act in each step."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.event import Events
from libgz.classic.plugin import ModelPlugin
from libgz.ros.plugin import RosPlugin, Ticks

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.ros.control.hardware import RobotHardware
    from libgz.ros.control.manager import ControllerManager
    from libgz.sdf.element import Element

__all__ = ["RobotControl"]


class RobotControl(RosPlugin, ModelPlugin):
    """Reads the joints, updates the controllers and applies what they command.

    Attributes:
        manager, hardware: None as long as there is no robot description.
        ticks: of the controllers.
        last, written: when they were updated, and their commands applied [s].
    """

    manager: ControllerManager | None
    hardware: RobotHardware | None

    def begin(self, model: Model, sdf: Element) -> None:
        """Read the parameters."""
        self.open(sdf, model.GetName())
        self.model, self.world = model, model.GetWorld()
        self.manager = self.hardware = None
        self.last = self.written = self.world.core.GetSimTime()

    def run(self, rate: float) -> None:
        """Let controllers act at a rate [Hz], or each iteration if it is 0."""
        self.ticks = Ticks(rate)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def look(self, now: float) -> None:
        """Look for the robot description, at sim time `now` [s]."""

    def Reset(self) -> None:
        """Start the running controllers again."""
        self.last = self.written = self.world.core.GetSimTime()
        if self.manager is not None and self.hardware is not None:
            self.hardware.read()
            self.manager.reset()

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Update the controllers, and apply what they command."""
        now = self.world.core.GetSimTime()
        if self.manager is None or self.hardware is None:
            self.look(now)
            return
        if self.ticks.due(now) and now > self.last:
            self.hardware.read()
            self.manager.update(now - self.last)
            self.last = now
        self.hardware.write(now - self.written)
        self.written = now
