"""MobileRobot: the base of all robots that a client drives through a position interface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, Protocol

from libgz.interfaces.position import PositionData
from libgz.legacy.model import Model
from libgz.models.positionserver import PositionServer
from libgz.simulation.formula import clamp
from libgz.simulation.rate import UpdateRate
from libgz.simulation.state import declares
from libgz.simulation.updates import Exchange, UpdateRows, replaced
from libgz.worldfile.attributes import number, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["Device", "MobileRobot", "RobotAttributes", "clamp"]


@dataclass(frozen=True)
class RobotAttributes:
    """Attributes of every robot."""

    updateRate: float = number(10.0, unit="Hz", least=0.0, help="updates of the interfaces per second of sim time")


class Device(Protocol):
    """A part of a robot with an interface of its own, such as a battery or a sonar ring."""

    def Init(self) -> None:
        """Create the interface."""

    def Update(self, now: float) -> None:
        """Publish, at sim time `now` [s]."""

    def Fini(self) -> None:
        """Destroy the interface."""


class MobileRobot(Model):
    """A robot with a position interface.

    Each step it measures its motion and controls its motors; at its update rate it takes a command, applies it and
    publishes. A command holds until the next one.
    """

    STATE: ClassVar[tuple[str, ...]] = ("rate", "position", "_kept_devices", "_driven")

    ROW_PARTS = Model.ROW_PARTS | {"rate", "position", "devices", "measure", "publish", "drive", "act"}

    _driven: tuple[float, ...] | None  # the command that the motors were last set to

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

    def drive(self) -> None:
        """Apply `position.wanted` to the motors; called at the update rate. By default `run`, if it changed."""
        wanted = self.position.wanted
        if wanted != self._driven:
            self._driven = wanted
            self.run(*wanted)

    def run(self, *wanted: Any, **_options: Any) -> None:
        """Drive as a command, in the order of `commands`, requests; called when it changed."""

    def act(self, step: float) -> None:
        """Run the controllers that need every step [s]."""

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(self.attributes, node)
        self.rate = UpdateRate(self.values.updateRate)
        self.position = PositionServer(self, self.commands)
        self.devices: list[Device] = []
        self._driven = None
        self.build()

    @property
    def _kept_devices(self) -> list[Device]:
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

    def Update(self, step: float) -> None:  # noqa: D102
        if step == 0.0:
            return
        self.measure(step)
        now = self.world.GetSimTime()
        if self.rate.due(now):
            self.position.exchange(now, self.publish)
            self.drive()
            for device in self.devices:
                device.Update(now)
        self.act(step)

    # As rows ------------------------------------------------------------------------------------------------------

    def MasterRowsOfUpdate(self, rows: UpdateRows) -> bool:
        """Describe `Update` as rows. What a subclass replaces is done in Python."""
        if replaced(self, MobileRobot, "Update") or not rows.knows(self.rate):
            return False
        self.MasterRowsOfMeasure(rows)
        with rows.due(self.rate):
            self._add_exchange(rows)
            for device in self.devices:
                add = getattr(device, "MasterRows", None)
                if add is None:
                    rows.python(partial(self._update_device, device))
                else:
                    add(rows)
        self.MasterRowsOfAct(rows)
        return True

    def MasterRowsOfMeasure(self, rows: UpdateRows) -> None:
        """Describe `measure` as rows."""
        rows.python(self.measure)

    def MasterPublished(self, exchange: Exchange) -> bool:
        """Describe `publish` as numbers of an exchange; false where `publish` itself is to be called."""
        return False

    def MasterRowsOfAct(self, rows: UpdateRows) -> None:
        """Describe `act` as rows."""
        if replaced(self, MobileRobot, "act"):
            rows.python(self.act)

    def _add_exchange(self, rows: UpdateRows) -> None:
        own_drive = replaced(self, MobileRobot, "drive")
        position, twin = self.position, self._exchange if own_drive else self._exchange_and_drive
        exchange = None if replaced(position, PositionServer, "exchange") else position.unchanged()
        if exchange is not None and self.MasterPublished(exchange):
            rows.share(twin, exchange)
        else:
            rows.python(twin)
        if own_drive:
            rows.python(lambda _: self.drive())

    def _exchange(self, _step: float) -> None:
        self.position.exchange(self.world.GetSimTime(), self.publish)

    def _exchange_and_drive(self, step: float) -> None:
        self._exchange(step)
        self.drive()

    def _update_device(self, device: Device, _step: float) -> None:
        device.Update(self.world.GetSimTime())
