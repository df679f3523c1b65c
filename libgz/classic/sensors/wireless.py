"""Wireless transmitters and receivers: who is heard where, and how strongly."""

from __future__ import annotations

import math
import zlib
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzVector
from libgz.classic import msgs
from libgz.classic.sensors.noise import GaussianNoiseModel, Noise
from libgz.classic.sensors.read import number, substituted
from libgz.classic.sensors.sensor import LinkSensor, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["WirelessReceiver", "WirelessTransceiver", "WirelessTransmitter"]

SPEED_OF_LIGHT = 299792458.0  # [m/s]
FREE, BLOCKED = 6.0, 12.0  # the exponents of the loss with distance, in sight and behind an obstacle
FADING = 6.0  # [dB] standard deviation of the loss that varies
GRID = 10  # [m] radius of the grid of signal strengths that viewers show, with a point each metre
FREQUENCY = 2442.0  # [MHz], in place of 0
APART = 1e-5  # [m] between two ends that coincide, so that there is a ray between them


class WirelessTransceiver(LinkSensor):
    """What transmitters and receivers have in common: an antenna."""

    topic_suffix: ClassVar[str | None] = "transceiver"

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._antenna = sdf.child("transceiver")
        self._gain = number(self._antenna, "gain", 0.0, unit="dBi")
        self._power = number(self._antenna, "power", unit="dBm")

    def Gain(self) -> float:
        """The gain of the antenna [dBi]."""
        return self._gain

    def Power(self) -> float:
        """The power of transmission [dBm]."""
        return self._power

    def _frequency(self, key: str) -> float:
        """A frequency of its file [MHz]."""
        value = number(self._antenna, key, 0.0, unit="MHz")
        if not value:
            substituted(self._antenna, key, f"is 0 MHz; it must be above 0: {FREQUENCY:g} is used")
        return value or FREQUENCY


class WirelessTransmitter(WirelessTransceiver):
    """An access point, or a beacon; receivers find it."""

    STATE = ("_grid",)

    message_type: ClassVar[Any] = msgs.PropagationGrid

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._essid = self._antenna.Get(str, "essid")
        self._carrier = self._frequency("frequency")  # [MHz]
        stream = zlib.crc32(self.ScopedName().encode())
        self._fading = GaussianNoiseModel(
            0.0, FADING, seed=np.random.SeedSequence(self.world.core.seed, spawn_key=(stream, 0))
        )
        self._grid: list[tuple[float, float, float]] = []

    @property
    def all_noises(self) -> list[Noise]:
        """The loss that varies is random, too."""
        return [*super().all_noises, self._fading]

    def reset(self) -> None:
        """Start again, with the same random numbers."""
        self._fading.restart()
        super().reset()

    def ESSID(self) -> str:
        """The name of its network."""
        return self._essid

    def Freq(self) -> float:
        """The frequency [MHz]."""
        return self._carrier

    def ModelStdDev(self) -> float:
        """Standard deviation of the loss that varies [dB]."""
        return FADING

    def SignalStrength(self, receiver: GzPose, rxGain: float) -> float:
        """The power that an antenna of a gain [dBi] receives at a pose [dBm]; each call has a random loss of its own.

        By the model of Gazebo: with distance d, at least 1 m, wavelength w and a normally distributed x,
        power + gains - |x| + 20 log(w) - 20 log(4 pi) - 10 n log(d); n is 6, or 12 if a collision is between both ends.
        """
        here, there = self.world_pose().pos, receiver.pos
        distance = math.dist(here, there)
        exponent = BLOCKED if self._obstacle(here, there, distance) else FREE
        loss = abs(self._fading.Apply(0.0)) + 10.0 * exponent * math.log10(max(1.0, distance))
        wave = SPEED_OF_LIGHT / (self._carrier * 1e6)
        spread = 20.0 * math.log10(wave / (4.0 * math.pi))
        return self._power + self._gain + rxGain + spread - loss

    def _obstacle(self, here: GzVector, there: GzVector, distance: float) -> bool:
        """Whether there is a collision between two points, those of both antennas' own models included."""
        way = [(b - a) / distance for a, b in zip(here, there, strict=True)] if distance else [0.0, 0.0, 1.0]
        frame, rays = np.array((*here, 1.0, 0.0, 0.0, 0.0)), np.array([[0.0, 0.0, 0.0, *way, max(distance, APART)]])
        ranges, rows = np.zeros(1), np.zeros(1, dtype=np.int64)
        self.world.core.engine.scan(frame, rays, 0, ranges, rows)
        return int(rows[0]) >= 0

    def measure(self, elapsed: float) -> None:
        """With `<visualize>`, find the signal around it, along its own axes x and y."""
        self._grid = []
        if not self.Visualize():
            return
        pose, points = self.world_pose(), range(-GRID, GRID + 1)
        for x, y in ((x, y) for x in points for y in points if math.hypot(x, y) <= GRID):
            at = GzCoordPoseAdd(GzPose(GzVector(float(x), float(y), 0.0)), pose)
            self._grid.append((float(x), float(y), self.SignalStrength(at, self._gain)))

    def deliver(self) -> None:
        """Publish the grid, if there is one."""
        if self._grid:
            super().deliver()

    def message(self) -> Any:
        """The signal around it as a msgs.PropagationGrid."""
        message = self.message_type()
        for x, y, level in self._grid:
            message.particle.add(x=x, y=y, signal_level=level)
        return message


class WirelessReceiver(WirelessTransceiver):
    """Lists the transmitters of the world that it hears."""

    STATE = ("_heard",)

    message_type: ClassVar[Any] = msgs.WirelessNodes

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._least, self._most = self._frequency("min_frequency"), self._frequency("max_frequency")
        self._sensitivity = number(self._antenna, "sensitivity", most=0.0, unit="dBm")
        self._heard: list[tuple[str, float, float]] = []

    def MinFreqFiltered(self) -> float:
        """The lowest frequency that it hears [MHz]."""
        return self._least

    def MaxFreqFiltered(self) -> float:
        """The highest frequency that it hears [MHz]."""
        return self._most

    def Sensitivity(self) -> float:
        """The weakest signal that it hears [dBm]."""
        return self._sensitivity

    def measure(self, elapsed: float) -> None:
        """Find the transmitters that are heard."""
        pose = self.world_pose()
        self._heard = []
        for one in self.sensors.sensors.values():
            if isinstance(one, WirelessTransmitter) and self._least <= one.Freq() <= self._most:
                level = one.SignalStrength(pose, self._gain)
                if level >= self._sensitivity:
                    self._heard.append((one.ESSID(), one.Freq(), level))

    def deliver(self) -> None:
        """Publish what is heard; nothing, if there is none."""
        if self._heard:
            super().deliver()

    def message(self) -> Any:
        """What it hears, as a msgs.WirelessNodes."""
        message = self.message_type()
        for essid, frequency, level in self._heard:
            message.node.add(essid=essid, frequency=frequency, signal_level=level)
        return message
