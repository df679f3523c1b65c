"""Device: one device of a server, with the interface it reads and writes."""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Iterator
from typing import Any

from libgz.base.errors import GazeboError, InterfaceError
from libgz.player.configuration import Device as Declared
from libgz.player.drivers import RefusedError, check_finite
from libgz.player.records import Values
from libgz.player.simulator import Simulator
from libgz.transport.interface import Interface

__all__ = ["Device"]

log = logging.getLogger("libgz.player")

LOCK_TIMEOUT = 0.01  # [s] to wait for a lock
BLOCKED = 0.25  # [s] without waiting, after a lock was not available


class Device:
    """A device, its latest data, and who subscribed to it.

    Attributes:
        declared: what the configuration file says of it.
        interface: of libgz, open while there are subscribers and a server.
        memory: what its driver keeps.
        subscribers: the conversations that read or write it.
        number: of the latest sample; 0 before the first one.
        time: sim time of the latest sample [s].
        values: of it.
        frames: its bytes, by version and code of the interface.
    """

    def __init__(self, declared: Declared, simulator: Simulator) -> None:
        self.declared = declared
        self.interface: Interface[Any] | None = None
        self.memory: dict[str, Any] = {}
        self.subscribers: set[object] = set()
        self.number = 0
        self.time = -1.0
        self.values: Values = {}
        self.frames: dict[tuple[str, int], bytes] = {}
        self._simulator = simulator
        self._session = 0
        self._waiting: dict[str, Values] = {}  # commands that a lock holds up
        self._blocked = 0.0
        self._reported: set[str] = set()

    def __repr__(self) -> str:
        declared, driver = self.declared, self.declared.driver
        return f"<Device {declared.port}:{driver.kind}:{declared.index} of {driver.source}.{declared.id}>"

    def report(self, what: str) -> None:
        """Log a problem with this device, each once."""
        if what not in self._reported and len(self._reported) < 100:
            self._reported.add(what)
            log.warning("%s:%d: %s", self.declared.driver.kind, self.declared.index, what)

    # Subscriptions ---------------------------------------------------------------------------------------------------

    def subscribe(self, conversation: object) -> None:
        """Add a subscriber, and open the interface.

        Raises:
            InterfaceError: there is no server, or it does not serve the interface.
        """
        self._open()
        self.subscribers.add(conversation)
        self.poll()

    def unsubscribe(self, conversation: object) -> None:
        """Remove a subscriber; a robot that the last one leaves stops."""
        if conversation not in self.subscribers:
            return
        self.subscribers.discard(conversation)
        if not self.subscribers and self.declared.driver.source == "position":
            still = dict.fromkeys(("vx", "vy", "vz", "va", "vroll", "vpitch", "vyaw"), 0.0)
            with contextlib.suppress(GazeboError):
                self.command("velocity", still)

    def _open(self) -> None:
        if not self.declared.driver.source:
            return
        if self.interface is not None and self._session == self._simulator.session:
            return
        self.interface = self._simulator.open(self.declared.driver.source, self.declared.id)
        self._session, self.time = self._simulator.session, -1.0

    # Data ------------------------------------------------------------------------------------------------------------

    def poll(self) -> bool:
        """Take a sample, if there is a new one, and do what a lock held up; whether there is a new sample."""
        if not self.declared.driver.source or not self._simulator.connected:
            return False
        try:
            self._open()
            if self._waiting:
                self._catch_up()
            return self.declared.driver.read is not None and self._sample()
        except RefusedError:
            return False  # the lock is held
        except InterfaceError as error:
            self.interface = None
            self.report(str(error))
            return False

    def _sample(self) -> bool:
        read, interface = self.declared.driver.read, self.interface
        if read is None or interface is None or interface.data.time == self.time:
            return False
        with self._locked() as data:
            values, taken = read(self), float(data.time)
        self.time = taken
        if values is None:
            return False
        self.values, self.number = values, self.number + 1
        self.frames.clear()
        return True

    # Commands and requests -------------------------------------------------------------------------------------------

    def command(self, name: str, values: Values) -> None:
        """Do what a client commands, now, or as soon as the lock of the interface is available.

        Raises:
            RefusedError: the driver has no such command, or it has numbers that are not finite.
        """
        function = self.declared.driver.commands.get(name)
        if function is None:
            raise RefusedError(f"there is no command {name!r} in the simulation")
        check_finite(values)
        try:
            with self._locked():
                function(self, values)
            self._waiting.pop(name, None)
        except _HeldError:
            self._waiting[name] = values

    def _catch_up(self) -> None:
        waiting, self._waiting = self._waiting, {}
        for name, values in waiting.items():
            self.command(name, values)

    def request(self, name: str, values: Values) -> Values | None:
        """Do what a client requests; what to reply, None for nothing.

        Raises:
            RefusedError: the driver has no such request, or cannot fulfil it now.
        """
        function = self.declared.driver.requests.get(name)
        if function is None:
            raise RefusedError(f"there is no request {name!r} in the simulation")
        check_finite(values)
        if not self.declared.driver.source:
            return function(self, values)
        with self._locked():
            return function(self, values)

    @contextlib.contextmanager
    def _locked(self) -> Iterator[Any]:
        """The struct, under the lock.

        Raises:
            RefusedError: there is no interface.
            _HeldError: the lock is not available.
        """
        interface = self.interface
        if interface is None or self._session != self._simulator.session or not self._simulator.connected:
            raise RefusedError(f"server {self._simulator.server_id} does not appear to be running")
        now = time.monotonic()
        if not interface.lock(0.0 if now < self._blocked else LOCK_TIMEOUT):
            self._blocked = now + BLOCKED
            raise _HeldError(f"a client holds the lock of {interface.type}.{interface.id}")
        try:
            yield interface.data
        finally:
            interface.unlock()


class _HeldError(RefusedError):
    """A lock is not available."""
