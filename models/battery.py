"""Battery: charge that sinks with time and travel, and the interface that tells it."""

from __future__ import annotations

from libgz.interfaces.power import Power
from libgz.legacy.model import Model

__all__ = ["Battery"]


class Battery:
    """A robot's battery. It stops at zero, and the robot drives on.

    Args:
        model: the robot.
        level: charge at the start [V].
        curve: charge lost with time [V/s] and with squared wheel travel [V/m^2].
    """

    def __init__(self, model: Model, level: float, curve: tuple[float, ...]) -> None:
        self.model = model
        self.level = level  # [V]
        self.curve = curve
        self.interface = Power()

    def Init(self) -> None:
        """Make the interface under the model's id."""
        model = self.model
        self.interface.create(
            model.world.gz_server, model.GetId(), model.GetName(), model.GetIntId(), model.GetParentIntId()
        )
        self.interface.data.levels[0] = self.level

    def drain(self, step: float, left: float, right: float) -> None:
        """Lose the charge of a step [s] in which the wheels of both sides travelled so far [m]."""
        with_time, with_travel = self.curve
        level = self.level - (with_time * step + with_travel * (left * left + right * right))
        self.level = level if level > 0.0 else 0.0

    def Update(self, now: float) -> None:
        """Publish, at sim time `now` [s]."""
        if self.interface.lock():
            self.interface.data.time = now
            self.interface.data.levels[0] = self.level
            self.interface.unlock()

    def Fini(self) -> None:
        """Let the interface go."""
        self.interface.destroy()
