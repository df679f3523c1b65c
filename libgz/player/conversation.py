"""Conversations: what a client and the server say to each other, in each version of Player's protocol.

A conversation answers the client's frames, and sends the data of the devices that it subscribed to, in the mode that
the client chose. It knows nothing of sockets: a `Channel` takes its bytes.
"""

from __future__ import annotations

import logging
import time
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, Protocol

from libgz.base.errors import GazeboError
from libgz.player.device import Device
from libgz.player.drivers import RefusedError
from libgz.player.messages import CODES, Message, messages_of
from libgz.player.records import MalformedError, Values
from libgz.player.simulator import Simulator
from libgz.player.wire import (
    ACK,
    COMMAND,
    DATA,
    ERROR,
    LOCALHOST,
    NACK,
    REQUEST,
    Frame,
    Wire,
    Wire1,
    Wire2,
)

__all__ = ["Channel", "Conversation", "Conversation1", "Conversation2", "Directory"]

log = logging.getLogger("libgz.player")

HEARTBEAT = 1.0  # [s] of real time after which a client that waits is sent an empty round
MOST_QUEUED = 1000  # messages that wait for a request of the client, as in Player 2.1
MOST_QUEUED_BYTES = 4 << 20
MOST_RULES = 64


class Channel(Protocol):
    """Where a conversation's bytes go."""

    def send(self, data: bytes) -> None:
        """Send bytes, now or when the client reads."""

    @property
    def crowded(self) -> bool:
        """Whether so much waits already that data are left out."""

    def defer(self, frame: Frame, device: Device, message: Message, values: Values) -> None:
        """Answer a slow request in another thread; frames of this client wait for that."""

    def close(self, reason: str) -> None:
        """End the connection."""


@dataclass
class Directory:
    """The devices of a server, and what all conversations need.

    Attributes:
        devices: by port, interface and index.
        key: that clients must have sent first; an empty string if none is needed.
    """

    simulator: Simulator
    devices: dict[tuple[int, str, int], Device]
    key: str = ""

    def of_port(self, port: int, interfaces: set[str]) -> list[Device]:
        """The devices of a port whose interface a version has."""
        return [
            device
            for (number, interface, _), device in self.devices.items()
            if number == port and interface in interfaces
        ]

    def port_of(self, robot: str) -> int:
        """The port of a robot's devices; 0 if there is no robot of this name."""
        return next((port for (port, _, _), d in self.devices.items() if robot and d.declared.robot == robot), 0)


@dataclass
class Subscription:
    """A client's subscription to a device.

    Attributes:
        code: of the interface, as the client gave it.
        reads, writes: what it may do.
        sent: number of the sample that was sent last.
    """

    device: Device
    code: int
    reads: bool
    writes: bool
    sent: int = 0


class Conversation(ABC):
    """Base of the versions. `version` is that of the messages."""

    refusal: ClassVar[int]  # the answer to a request for a device that is not there

    def __init__(self, directory: Directory, port: int, channel: Channel, wire: Wire, version: str) -> None:
        self.directory, self.port, self.channel = directory, port, channel
        self.version = version
        self.subscriptions: dict[Device, Subscription] = {}
        self._wire = wire
        self._authenticated = not directory.key

    @property
    def time(self) -> float:
        """Sim time [s]."""
        return self.directory.simulator.time

    def close(self) -> None:
        """End all subscriptions."""
        for device in self.subscriptions:
            device.unsubscribe(self)
        self.subscriptions.clear()

    # What the client sends -------------------------------------------------------------------------------------------

    def take(self, buffer: bytearray) -> bool:
        """Handle the first frame of what was received; whether there was one.

        Raises:
            MalformedError: no frame can follow.
        """
        frame = self._wire.take(buffer)
        if frame is None:
            return False
        if not self._authenticated:
            self._authenticate(frame)
        elif frame.type == REQUEST:
            self._request(frame)
        elif frame.type == COMMAND:
            self._command(frame)
        return True

    def _authenticate(self, frame: Frame) -> None:
        message = messages_of(self.version).by_number.get((frame.interface, "request", frame.number))
        key = ""
        if frame.type == REQUEST and message is not None and message.name == "auth":
            try:
                key = message.layout.decode(_padded(frame.payload, message, self._wire.xdr), xdr=self._wire.xdr)["key"]
            except MalformedError:
                key = ""
        if key != self.directory.key:
            self.channel.close("the client has not sent the key")
            return
        self._authenticated = True
        self.answer(ACK, frame)

    def answer(self, type: int, frame: Frame, message: Message | None = None, values: Values | None = None) -> None:
        """Answer a request, with the values of its reply, if it has any."""
        payload = b""
        if message is not None and values is not None:
            payload = messages_of(self.version).reply(message).layout.encode(values, xdr=self._wire.xdr)
        self.channel.send(self._wire.pack(type, frame, payload, self.time))

    def _device(self, frame: Frame) -> Device | None:
        return self.directory.devices.get((self.port, frame.interface, frame.index))

    def _request(self, frame: Frame) -> None:
        message = self._message(frame, "request")
        device = self._device(frame)
        if frame.interface != "player" and (device is None or not self._may_request(device)):
            self.answer(self.refusal, frame)
            return
        if message is None:
            self.answer(NACK, frame)
            return
        try:
            values = self._values(frame, message)
            if device is None:
                self._own_request(frame, message, values)
            elif message.name in device.declared.driver.slow:
                self.channel.defer(frame, device, message, values)
            else:
                self.answer(ACK, frame, message, device.request(message.name, values))
        except (RefusedError, MalformedError) as error:
            log.debug("refused %s of %s: %s", message.name, message.interface, error)
            self.answer(NACK, frame)

    def _command(self, frame: Frame) -> None:
        device, message = self._device(frame), self._message(frame, "command")
        subscription = self.subscriptions.get(device) if device is not None else None
        if device is None or subscription is None or not subscription.writes:
            log.debug("a command for %s:%d, which the client may not write", frame.interface or frame.code, frame.index)
            return
        if message is None:
            device.report(f"commands with number {frame.number} do nothing in the simulation")
            return
        try:
            device.command(message.name, self._values(frame, message))
        except (RefusedError, MalformedError) as error:
            device.report(f"ignored a command: {error}")

    def _message(self, frame: Frame, kind: str) -> Message | None:
        number = frame.number
        return messages_of(self.version).by_number.get((frame.interface, kind, number))  # type: ignore[arg-type]

    def _values(self, frame: Frame, message: Message) -> Values:
        """The values of a request or command; a request that asks for something may come without any."""
        payload = frame.payload
        if message.kind == "request" and message.name not in _SETTING:
            payload = _padded(payload, message, self._wire.xdr)
        return message.layout.decode(payload, xdr=self._wire.xdr)

    @abstractmethod
    def _may_request(self, device: Device) -> bool:
        """Whether the client may send requests to a device."""

    @abstractmethod
    def _own_request(self, frame: Frame, message: Message, values: Values) -> None:
        """Answer a request to the server itself."""

    def _open(self, frame: Frame, device: Device, code: int, reads: bool, writes: bool) -> bool:
        """Subscribe to a device; whether it can be."""
        del frame
        known = self.subscriptions.get(device)
        if known is not None:
            known.reads, known.writes = reads, writes
            return True
        try:
            device.subscribe(self)
        except GazeboError as error:
            device.report(str(error))
            return False
        self.subscriptions[device] = Subscription(device, code, reads, writes)
        return True

    def _close(self, device: Device) -> None:
        if self.subscriptions.pop(device, None) is not None:
            device.unsubscribe(self)

    # What the server sends -------------------------------------------------------------------------------------------

    @abstractmethod
    def deliver(self) -> None:
        """Send data that are due."""

    def _look(self) -> None:
        """Take the newest data of all devices that are subscribed to."""
        for device in self.subscriptions:
            device.poll()

    def _packed(self, subscription: Subscription) -> bytes:
        """The latest data of a device, which all clients of a version share."""
        device, name = subscription.device, (self.version, subscription.code)
        found = device.frames.get(name)
        if found is None:
            declared, message = device.declared, self._data_message(device)
            payload = message.layout.encode(device.values, xdr=self._wire.xdr)
            taken = max(device.time, 0.0)
            found = self._wire.pack_data(subscription.code, declared.index, message.number, payload, taken)
            device.frames[name] = found
        return found

    def _data_message(self, device: Device) -> Message:
        driver = device.declared.driver
        return messages_of(self.version).by_name[driver.kind, "data", driver.data]

    def _sources(self) -> list[Subscription]:
        """Subscriptions that have data to send."""
        return [s for s in self.subscriptions.values() if s.reads and s.device.number and s.device.declared.driver.data]


# Requests whose values are needed; others ask for something, and may come without a payload.
_SETTING = {
    "brakes",
    "control_mode",
    "frequency",
    "mode",
    "motors",
    "power",
    "replace_rule",
    "set_config",
    "set_odometry",
    "set_pose",
    "set_pose2d",
    "set_pose3d",
    "set_root_pose",
    "speed",
    "subscribe",
}


def _padded(payload: bytes, message: Message, xdr: bool) -> bytes:
    """A payload, with zeros for what the client left out."""
    size = message.layout.size(xdr=xdr)
    return payload.ljust(len(message.layout.encode({}, xdr=xdr)) if size is None else size, b"\0")


# 1.6 -----------------------------------------------------------------------------------------------------------------


class Conversation1(Conversation):
    """The conversation of 1.6.

    Data come in rounds, each of which ends with an empty message of type SYNCH. With a frequency, a round is due by sim
    time, as in Player's own connection to Gazebo.
    """

    refusal = ERROR
    PUSH_ALL, PULL_ALL, PUSH_NEW, PULL_NEW, PUSH_ASYNC = range(5)
    MODES: ClassVar[dict[int, tuple[bool, bool]]] = {
        ord("a"): (True, True),
        ord("r"): (True, False),
        ord("w"): (False, True),
    }
    CLOSED, REFUSED = ord("c"), ord("e")

    def __init__(self, directory: Directory, port: int, channel: Channel) -> None:
        self._framing = Wire1()
        super().__init__(directory, port, channel, self._framing, "1.6")
        self._mode = self.PUSH_NEW
        self._frequency = 10  # [Hz]
        self._asked = False
        self._last = 0.0  # sim time of the last round [s]
        self._last_real = 0.0

    def _may_request(self, device: Device) -> bool:
        return device in self.subscriptions

    def _own_request(self, frame: Frame, message: Message, values: Values) -> None:
        interfaces = messages_of(self.version).interfaces()
        name = message.name
        if name == "devlist":
            devices = [
                {"interface": CODES[d.declared.driver.kind], "index": d.declared.index, "port": d.declared.port}
                for d in self.directory.of_port(self.port, interfaces)
            ]
            self.answer(ACK, frame, message, {"devices": devices})
        elif name == "driverinfo":
            found = self._named(values["interface"], values["index"])
            self.answer(ACK, frame, message, {**values, "driver": found.declared.label if found else "unknown"})
        elif name == "subscribe":
            self._subscribe(frame, message, values)
        elif name == "nameservice":
            self.answer(ACK, frame, message, {**values, "port": self.directory.port_of(values["name"])})
        elif name == "mode" and self.PUSH_ALL <= values["mode"] <= self.PUSH_ASYNC:
            self._mode, self._asked = values["mode"], False
            self.answer(ACK, frame)
        elif name == "frequency":
            self._frequency = values["frequency"]
            self.answer(ACK, frame)
        elif name == "data" and self._mode in (self.PULL_ALL, self.PULL_NEW):
            self.answer(ACK, frame)
            self._look()
            self._asked = True
            self.deliver()
        else:
            self.answer(NACK, frame)

    def _named(self, code: int, index: int) -> Device | None:
        interfaces = messages_of(self.version).interfaces()
        for device in self.directory.of_port(self.port, interfaces):
            kind = device.declared.driver.kind
            if device.declared.index == index and (code == CODES[kind] or (code, kind) == (48, "position2d")):
                return device
        return None

    def _subscribe(self, frame: Frame, message: Message, values: Values) -> None:
        device, access = self._named(values["interface"], values["index"]), values["access"]
        granted = self.REFUSED
        if device is not None and access == self.CLOSED:
            self._close(device)
            granted = access
        elif device is not None and access in self.MODES:
            granted = access if self._open(frame, device, values["interface"], *self.MODES[access]) else granted
        label = device.declared.label if device is not None else ""
        self.answer(ACK, frame, message, {**values, "access": granted, "driver": label})

    def deliver(self) -> None:
        """See `Conversation.deliver`."""
        if self.channel.crowded or not self._authenticated:
            return
        everything = self._mode in (self.PUSH_ALL, self.PULL_ALL)
        ready = [s for s in self._sources() if everything or s.sent != s.device.number]
        now = time.monotonic()
        if not self._due(now, bool(ready)):
            return
        for subscription in ready:
            subscription.sent = subscription.device.number
            self.channel.send(self._packed(subscription))
        self.channel.send(self._framing.synch(self.time))
        self._asked, self._last_real = False, now

    def _due(self, now: float, ready: bool) -> bool:
        """Whether a round is due."""
        if self._mode in (self.PULL_ALL, self.PULL_NEW):
            return self._asked
        silent = now - self._last_real >= HEARTBEAT
        if self._mode == self.PUSH_ASYNC:
            return ready or silent
        sim_time = self.time
        passed = sim_time - self._last
        period = 1.0 / self._frequency if self._frequency else float("inf")
        if 0.0 <= passed < period - 1e-6:
            return silent
        self._last = self._last + period if period <= passed < 2.0 * period else sim_time  # without drift
        return True


# 2.0 and later -------------------------------------------------------------------------------------------------------


class _Waiting(NamedTuple):
    device: Device
    data: bytes


@dataclass(frozen=True)
class _Rule:
    """What happens to a message when another of its kind waits already; -1 stands for all."""

    interface: int
    index: int
    type: int
    subtype: int
    rule: int

    def applies(self, interface: int, index: int, type: int, subtype: int) -> bool:
        pairs = (self.interface, interface), (self.index, index), (self.type, type), (self.subtype, subtype)
        return all(wanted in (-1, number) for wanted, number in pairs)


@dataclass
class _Queue:
    """Data that wait until the client asks for them."""

    messages: deque[_Waiting] = field(default_factory=deque)
    size: int = 0
    lost: int = 0

    def put(self, message: _Waiting, replace: bool) -> None:
        if replace:
            for other in [other for other in self.messages if other.device is message.device]:
                self.messages.remove(other)
                self.size -= len(other.data)
        self.messages.append(message)
        self.size += len(message.data)
        while len(self.messages) > MOST_QUEUED or (self.size > MOST_QUEUED_BYTES and len(self.messages) > 1):
            self.size -= len(self.messages.popleft().data)
            self.lost += 1

    def clear(self) -> None:
        self.messages.clear()
        self.size = self.lost = 0


class Conversation2(Conversation):
    """The conversation of 2.0, 2.1 and 3.

    The header does not say which version it is. Client libraries of 2.1 and 3 choose a mode first, or ask for the
    devices; that of 2.0 may subscribe first, and does not set the number of the message, which is any then. And a
    message that has the length of another version shows that it is that one.

    Args:
        version: 2.0 or later; an empty string: 2.0 or 2.1, as the client shows.
    """

    refusal = NACK
    PUSH, PULL = 1, 2
    OPENED, CLOSED, REFUSED = 1, 2, 3
    REPLACE, IGNORE = 1, 2

    def __init__(self, directory: Directory, port: int, channel: Channel, version: str = "") -> None:
        self._framing = Wire2(port)
        super().__init__(directory, port, channel, self._framing, version or "2.0")
        self._fixed, self._first = bool(version), True
        self._pull, self._asked = False, False
        self._rules: list[_Rule] = []
        self._queue = _Queue()

    def take(self, buffer: bytearray) -> bool:
        """See `Conversation.take`."""
        if self._first and not self._fixed and len(buffer) >= 40:
            named = int.from_bytes(buffer[8:12]), buffer[19], buffer[23]
            if named != (CODES["player"], REQUEST, 7):  # the key comes before
                self._first = False
                later = named in [(CODES["player"], REQUEST, number) for number in (1, 5)] and not any(buffer[32:36])
                self.version = "2.1" if later else "2.0"
        return super().take(buffer)

    def _may_request(self, device: Device) -> bool:
        return True

    def _message(self, frame: Frame, kind: str) -> Message | None:
        message = super()._message(frame, kind)
        if self._fixed or self._fits(message, frame):
            return message
        other = "2.0" if self.version == "2.1" else "2.1"
        theirs = messages_of(other).by_number.get((frame.interface, kind, frame.number))  # type: ignore[arg-type]
        if not self._fits(theirs, frame):
            return message
        log.debug("the client speaks %s", other)
        self.version, self._fixed = other, True
        known = messages_of(other).interfaces()
        for device in [device for device in self.subscriptions if device.declared.driver.kind not in known]:
            self._close(device)
        return theirs

    def _fits(self, message: Message | None, frame: Frame) -> bool:
        size = None if message is None else message.layout.size(xdr=True)
        return message is not None and (size is None or size == len(frame.payload) or not frame.payload)

    def _own_request(self, frame: Frame, message: Message, values: Values) -> None:
        name = message.name
        if name == "devlist":
            devices = [
                self._address(d) for d in self.directory.of_port(self.port, messages_of(self.version).interfaces())
            ]
            self.answer(ACK, frame, message, {"devices": devices})
        elif name == "driverinfo":
            found = self._named(values)
            if found is None:
                raise RefusedError("there is no such device")
            self.answer(ACK, frame, message, {**self._address(found), "driver": found.declared.label})
        elif name == "subscribe":
            self._subscribe(frame, message, values)
        elif name == "nameservice":
            self.answer(ACK, frame, message, {**values, "port": self.directory.port_of(values["name"])})
        elif name == "mode" and values["mode"] in (self.PUSH, self.PULL):
            self._pull = values["mode"] == self.PULL
            self._queue.clear()
            self.answer(ACK, frame)
        elif name == "replace_rule":
            self._rules = [*self._rules, _Rule(*(values[part] for part in _RULE))][-MOST_RULES:]
            self.answer(ACK, frame)
        elif name == "data":
            self.answer(ACK, frame)
            self._look()
            self._asked = True
            self.deliver()
        else:
            self.answer(NACK, frame)

    def _address(self, device: Device) -> dict[str, int]:
        interface, index = CODES[device.declared.driver.kind], device.declared.index
        return {"host": LOCALHOST, "robot": self.port, "interface": interface, "index": index}

    def _named(self, values: Values) -> Device | None:
        for device in self.directory.of_port(self.port, messages_of(self.version).interfaces()):
            if (CODES[device.declared.driver.kind], device.declared.index) == (values["interface"], values["index"]):
                return device
        return None

    def _subscribe(self, frame: Frame, message: Message, values: Values) -> None:
        device, access = self._named(values), values["access"]
        if device is None:
            raise RefusedError("there is no such device")
        granted = self.REFUSED
        if access == self.CLOSED:
            self._close(device)
            granted = access
        elif access == self.OPENED and self._open(frame, device, values["interface"], True, True):
            granted = access
        reply = {**self._address(device), "access": granted, "driver": device.declared.label}
        self.answer(ACK, frame, message, reply)
        if self._pull:
            self.deliver()

    def deliver(self) -> None:
        """See `Conversation.deliver`."""
        if not self._authenticated:
            return
        crowded = self.channel.crowded
        for subscription in self._sources():
            if subscription.sent == subscription.device.number or (crowded and not self._pull):
                continue
            subscription.sent = subscription.device.number
            if self._pull:
                self._put(subscription)
            else:
                self.channel.send(self._packed(subscription))
        if self._pull and self._asked and not crowded and (self._queue.messages or self.version == "2.0"):
            self._send_round()

    def _put(self, subscription: Subscription) -> None:
        device = subscription.device
        kind = subscription.code, device.declared.index, DATA, self._data_message(device).number
        rule = next((rule.rule for rule in reversed(self._rules) if rule.applies(*kind)), 0)
        if rule != self.IGNORE:
            self._queue.put(_Waiting(device, self._packed(subscription)), rule == self.REPLACE)

    def _send_round(self) -> None:
        for waiting in self._queue.messages:
            self.channel.send(waiting.data)
        if self.version == "2.0":
            self.channel.send(self._framing.synch(0, b"", self.time))
        elif self._queue.lost:
            self.channel.send(self._framing.synch(2, self._queue.lost.to_bytes(4), self.time))
        else:
            self.channel.send(self._framing.synch(1, b"", self.time))
        self._queue.clear()
        self._asked = False


_RULE = ("interface", "index", "type", "subtype", "rule")
