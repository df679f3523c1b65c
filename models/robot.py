"""MobileRobot: the base of all robots that a client drives through a position interface."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, ClassVar

from libgz.base.law import law, rarely
from libgz.base.records import numbers
from libgz.interfaces.position import PositionData
from libgz.legacy.model import Model
from libgz.models.device import Device, Devices
from libgz.models.positionserver import PositionServer
from libgz.simulation.plan import Plan, overrides
from libgz.simulation.rate import UpdateRate
from libgz.simulation.state import declares
from libgz.worldfile.attributes import declaration, number, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["MobileRobot", "RobotAttributes"]


@declaration
class RobotAttributes:
    """Attributes of every robot."""

    updateRate: float = number(10.0, unit="Hz", least=0.0, help="updates of the interfaces per second of sim time")


class MobileRobot(Model):
    """A robot with a position interface.

    Each step it measures its motion and controls its motors; at its update rate it takes a command, applies it and
    publishes. A command holds until the next one.
    """

    STATE: ClassVar[tuple[str, ...]] = ("rate", "position", "_kept_devices", "_driven")

    _driven: Any  # the command that the motors were last set to

    behaviour = "motors that drive and hold its wheels; odometry"
    attributes: ClassVar[type[RobotAttributes]] = RobotAttributes
    interfaces: ClassVar[tuple[str, ...]] = ("position",)
    # The fields of the position interface that this robot obeys, in the order of `position.wanted`.
    commands: ClassVar[tuple[tuple[str, int], ...]] = (("cmd_vel_pos", 0), ("cmd_vel_rot", 2))
    limits: ClassVar[
        tuple[float, ...]
    ] = ()  # of each of them [m/s], [rad/s]; empty: as far as the interface takes them

    def build(self) -> None:
        """Build bodies and joints."""
        raise NotImplementedError

    def measure(self, step: float) -> None:
        """Update pose and velocity after a step [s]."""
        raise NotImplementedError

    def publish(self, data: PositionData) -> None:
        """Write pose and velocity to the interface; called at the update rate."""
        raise NotImplementedError

    @law
    def drive(self) -> None:
        """Apply `position.wanted` to the motors; called at the update rate. By default `run`, if it changed."""
        wanted = self.position.wanted
        if rarely(_differ(wanted, self._driven)):
            self._driven[:] = wanted
            self.run(*wanted)

    def run(self, *wanted: Any, **_options: Any) -> None:
        """Drive as a command, in the order of `commands`, requests; called when it changed."""

    @law
    def act(self, step: float) -> None:
        """Run the controllers that need every step [s]."""

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(self.attributes, node)
        self.rate = UpdateRate(self.values.updateRate)
        self.position = PositionServer(self, self.commands)
        self.devices = []
        self._driven = numbers(len(self.commands))(*(math.nan for _ in self.commands))
        self.build()

    @property
    def devices(self) -> list[Any]:
        """Parts with Init, Update(now) and Fini, such as a `Device`; they may come and go while the world runs."""
        return self._devices

    @devices.setter
    def devices(self, devices: Iterable[Any]) -> None:
        self._devices = Devices(devices, self.world.update_rows_changed)

    @property
    def _kept_devices(self) -> list[Any]:
        """The devices that declare a state."""
        return [device for device in self.devices if declares(type(device))]

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.position.Init()
        for device in self.devices:
            device.Init()

    def Fini(self) -> None:  # noqa: D102
        self.position.Fini()
        for device in self.devices:
            device.Fini()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        plan.do(self.measure)
        with plan.due(self.rate):
            self.position.plan(plan, self.publish)
            plan.call(self.drive)
            for device in self.devices:
                self._plan_device(plan, device)
        self.plan_act(plan)

    def plan_act(self, plan: Plan) -> None:
        """Describe what is done in each step, after the devices: `act`."""
        plan.do(self.act)

    def _plan_device(self, plan: Plan, device: Any) -> None:
        if isinstance(device, Device) and not overrides(device, Device, "Update"):
            device.plan_update(plan)
        else:
            plan.do(lambda _: device.Update(self.world.GetSimTime()))


def _differ(some: Iterable[float], others: Iterable[float]) -> Any:
    """Whether a number differs from the one at the same place."""
    differs: Any = False
    for one, other in zip(some, others, strict=True):
        differs |= one != other
    return differs
