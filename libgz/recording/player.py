"""Player: serves what a log holds, as the recorded server did: interfaces, states, scene and topics.

Clients of any kind read the same bytes, observers see the same states. What clients write is without effect, except the
buttons of `sim`: pause stops and continues, reset goes back to the start.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from libgz.base.budget import Budget
from libgz.base.closing import Closing
from libgz.base.errors import GazeboError, ParameterError, ServerError
from libgz.interfaces.catalog import INTERFACES, new_interface
from libgz.interfaces.gripper import Gripper
from libgz.interfaces.sim import Sim
from libgz.recording.own_messages import States, read_file, read_json, read_tables, understood
from libgz.recording.reader import LogChannel, LogMessage, LogReader
from libgz.recording.readings import Readings
from libgz.transport.control import Control
from libgz.transport.interface import Interface
from libgz.transport.layout import ABIS, LIBGAZEBO_VERSION, NATIVE
from libgz.transport.paths import is_data_file
from libgz.transport.server import Server
from libgz.transport.tables import BODY_COLUMNS, JOINT_COLUMNS, SharedTables

__all__ = ["Player"]

log = logging.getLogger("libgz.recording")

# Requests that are answered.
ABILITIES = ("pause", "resume", "reset", "seek", "rewind", "speed", "step", "status", "readings")
PLAYED = ("interface", "topic", "own")
IDLE_PERIOD = 0.02  # [s] between two publications while it is paused
LONGEST_SLEEP = 0.05  # [s]


class Topics(Protocol):
    """Publishes the messages of topics."""

    def publish(self, channel: LogChannel, content: bytes) -> None:
        """Publish a message."""

    def update(self) -> None:
        """Deliver what was published."""

    def requests(self) -> list[tuple[str, str]]:
        """Requests that came by a topic, and their arguments."""

    def close(self) -> None:
        """End the publications."""


class Player(Closing):
    """Plays a log under a server id.

    Args:
        path: of the log.
        server_id: where it is served.
        force: take over a server id whose owner may still be alive.
        speed: seconds of the log for each second of real time; 0 for as fast as possible.
        topics: for the topics of a classic world; None leaves them out.

    Attributes:
        reader: the log.
        readings: of the cameras and lasers of a classic world, at that time.
        time: where it is in the log [s].
        speed, paused: can be set at any time.
        at_end: whether the last message was played.

    Raises:
        ParameterError: the file is no log of libgz, or the server id is invalid.
        ServerError: the server id is in use.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        server_id: int = 0,
        force: bool = False,
        speed: float = 1.0,
        topics: Topics | None = None,
    ) -> None:
        self.reader = LogReader(path)
        if not self.reader.about.get("format"):
            self.reader.close()
            raise ParameterError(
                f"{str(path)!r} was not recorded by libgz, so it cannot be played: `--mcap` records logs"
            )
        try:
            version = int(self.reader.about.get("wire_version", LIBGAZEBO_VERSION))
        except ValueError:
            version = LIBGAZEBO_VERSION
        abi = self.reader.about.get("abi", NATIVE)
        self.speed, self.paused, self.at_end = speed, False, False
        self.time = self.reader.begin
        self.readings = Readings(self.reader.about.get("world", "default"))
        self._topics = topics
        self._interfaces: dict[tuple[str, str], Interface[Any]] = {}
        self._sim_pause = 0
        self._messages: Iterator[LogMessage] = iter(())
        self._next: LogMessage | None = None
        self._states: States | None = None
        self._rows = (-1, -1)
        self._revision = 0
        self._files: dict[str, bytes] = {}
        self._folder: tempfile.TemporaryDirectory[str] | None = None  # of textures that this machine lacks
        self._unpacked: dict[str, str] = {}
        self._anchor = (0.0, 0.0, 0.0)  # real time [s], time of the log [s] and speed there
        self._control: Control | None = None
        try:
            self.server = Server(server_id, force, version, abi if abi in ABIS else NATIVE)
            self.server.start()
        except GazeboError:
            self.reader.close()
            raise
        try:
            with contextlib.suppress(ServerError):
                self._control = Control(self.server.path)
            self._load_files()
            self.seek(self.reader.begin)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """End the server. Can be called twice."""
        if self._control is not None:
            self._control.close()
        for interface in list(self._interfaces.values()):
            interface.destroy()
        self._interfaces.clear()
        self.server.stop()
        if self._topics is not None:
            self._topics.close()
        self.reader.close()
        if self._folder is not None:
            self._folder.cleanup()

    # Time ------------------------------------------------------------------------------------------------------------

    @property
    def status(self) -> dict[str, Any]:
        """Where it is: times of the log [s], speed, and whether it is paused or at the end."""
        return {
            "path": str(self.reader.path),
            "time": self.time,
            "begin": self.reader.begin,
            "end": self.reader.end,
            "speed": self.speed,
            "paused": self.paused,
            "at_end": self.at_end,
        }

    def seek(self, time: float) -> None:
        """Show the world as it was at a time of the log [s]; beyond its ends, at its first or last moment."""
        time = min(max(time, self.reader.begin), self.reader.end)
        latest = self.reader.last(time, PLAYED)
        own = {message.channel.topic: message for message in latest.values() if message.channel.kind == "own"}
        served = self._served(own["/gz/interfaces"].data) if "/gz/interfaces" in own else set()
        self._keep_only(served)
        self.readings.clear()
        if "/gz/scene" in own:
            self._show_scene(own["/gz/scene"].data)
        for message in sorted(latest.values(), key=lambda one: one.time):
            if message.channel.kind != "interface" or self._key(message.channel) in served:
                self._apply(message)
        self.time = time
        self._publish()
        self._messages = self.reader.messages(PLAYED, after=time)
        self._next = next(self._messages, None)
        self.at_end = self._next is None
        self._restart()

    def _restart(self) -> None:
        self._anchor = (time.monotonic(), self.time, self.speed)

    def step(self) -> bool:
        """Play the messages of the next moment; whether there were any."""
        message = self._next
        if message is None:
            self.at_end = True
            return False
        now = message.time
        while message is not None and message.time == now:
            self._apply(message, live=True)
            message = next(self._messages, None)
        self._next = message
        self.time = now * 1e-9
        self.at_end = message is None
        self._publish()
        return True

    def run(self, until: float | None = None, hold: bool = False, loop: bool = False) -> None:
        """Play until the end; the arguments are those of `moments`."""
        for _ in self.moments(until, hold, loop):
            pass

    def moments(self, until: float | None = None, hold: bool = False, loop: bool = False) -> Iterator[None]:
        """Play until the end, or a time of the log [s]; yields often, between two moments.

        Args:
            until: None for the whole log.
            hold: whether to stay there, paused; if it is continued there, it begins again.
            loop: whether to begin again.
        """
        start, held = self.time, False
        self._restart()
        while True:
            ends = self.at_end or (until is not None and self.time >= until)
            held = held and ends
            if ends and not self.paused:
                if loop or held:
                    self.seek(start)
                elif hold:
                    self.paused = held = True
                else:
                    return
            self.advance()
            yield

    def advance(self) -> None:
        """Obey requests, then play the next moment once it is due, or wait a little for it."""
        self._obey()
        if self.paused or self._next is None:
            self._publish()
            time.sleep(IDLE_PERIOD)
            self._restart()
            return
        if self._anchor[2] != self.speed:
            self._restart()
        due = self._next.time * 1e-9
        real, begin, _ = self._anchor
        ahead = (due - begin) / self.speed - (time.monotonic() - real) if self.speed else 0.0
        if ahead > LONGEST_SLEEP:
            time.sleep(LONGEST_SLEEP)
            return
        if ahead > 0.0:
            time.sleep(ahead)
        elif ahead < -1.0:
            self._restart()  # it cannot keep up: it does not try to
        self.step()

    # Requests --------------------------------------------------------------------------------------------------------

    def _obey(self) -> None:
        sim = self._interfaces.get(("sim", "default"))
        if isinstance(sim, Sim):
            data = sim.data
            if data.pause in (0, 1) and data.pause != self._sim_pause:
                self._sim_pause = data.pause
                self.paused = bool(data.pause)
            if data.reset:
                data.reset = 0
                self.seek(self.reader.begin)
        for verb, argument in self._topics.requests() if self._topics is not None else ():
            self._act(verb, argument)
        while self._control is not None and self._control.waiting:
            request = self._control.waiting.popleft()
            try:
                if request.verb == "abilities":
                    request.answer(json.dumps(ABILITIES).encode())
                    continue
                if request.verb == "readings":
                    request.answer(json.dumps(self.readings.answer(_names(request.content))).encode())
                    continue
                self._act(request.verb, request.argument)
                request.answer(json.dumps(self.status).encode())
            except GazeboError as error:
                request.answer(error=str(error))

    def _act(self, verb: str, argument: str) -> None:
        """Obey a request of another process.

        Raises:
            ParameterError: it is not understood.
        """
        try:
            number = float(argument) if verb in ("seek", "speed", "rewind", "step") else 0.0
            if not abs(number) < float("inf"):
                raise ValueError
        except ValueError:
            raise ParameterError(f"{verb} takes a number, not {argument!r}") from None
        if verb == "seek":
            self.seek(number)
        elif verb == "rewind":
            self.seek(self.time - number)
        elif verb == "speed" and number >= 0.0:
            self.speed = number
        elif verb == "step":
            self.paused = True
            for _ in range(max(0, int(number))):
                self.step()
        elif verb in ("pause", "resume"):
            self.paused = verb == "pause" and argument != "off"
        elif verb == "reset":
            self.seek(self.reader.begin)
        elif verb != "status":
            raise ParameterError(
                f"a log that is played knows no request {verb} {argument}; there are {', '.join(ABILITIES)}"
            )

    # What is shown ---------------------------------------------------------------------------------------------------

    @staticmethod
    def _key(channel: LogChannel) -> tuple[str, str]:
        return channel.about.get("type", ""), channel.about.get("id", "")

    def _served(self, content: bytes) -> set[tuple[str, str]]:
        """Types and ids of the interfaces in a message of /gz/interfaces."""
        with understood("a message of /gz/interfaces"):
            return {(kind, name) for kind, name in read_json(content)}

    def _keep_only(self, served: set[tuple[str, str]]) -> None:
        """Destroy the interfaces that are not served any more."""
        for key in [key for key in self._interfaces if key not in served]:
            self._interfaces.pop(key).destroy()

    def _apply(self, message: LogMessage, live: bool = False) -> None:
        """Show what a message says; `live` if it comes in its turn, not by seeking."""
        channel = message.channel
        if channel.kind == "interface":
            self._write(channel, message.data)
        elif channel.topic == "/gz/tables":
            self._states = read_tables(message.data)
        elif channel.topic == "/gz/scene" and live:
            self._show_scene(message.data)
        elif channel.topic == "/gz/interfaces" and live:
            self._keep_only(self._served(message.data))
        elif channel.kind == "topic":
            self.readings.take(channel, message.data)
            if self._topics is not None:
                self._topics.publish(channel, message.data)

    def _write(self, channel: LogChannel, content: bytes) -> None:
        """Write the bytes of an interface; a new one is created."""
        key = self._key(channel)
        interface = self._interfaces.get(key)
        if interface is not None and interface.size != len(content):
            self._interfaces.pop(key).destroy()
            interface = None
        if interface is None:
            if key[0] not in INTERFACES:
                return  # of a later libgz
            interface = new_interface(key[0])
            if isinstance(interface, Gripper):
                interface.later = interface.layout_for(0, len(content)) is not interface.data_class
            interface.create(self.server, key[1])
            if interface.size != len(content):
                interface.destroy()
                raise ParameterError(f"the log is damaged: {channel.topic} has a message of {len(content)} bytes")
            self._interfaces[key] = interface
        Interface.set_bytes(interface, content)
        if isinstance(interface, Sim):
            self._sim_pause = interface.data.pause

    def _publish(self) -> None:
        """Publish states, and wake clients."""
        sim = self._interfaces.get(("sim", "default"))
        if isinstance(sim, Sim) and self.paused and sim.data.pause != 1:
            sim.data.pause = self._sim_pause = 1
        shared, states = self.server.shared, self._states
        if isinstance(shared, SharedTables) and states is not None and self._revision:
            rows = len(states.bodies) // (8 * BODY_COLUMNS), len(states.joints) // (8 * JOINT_COLUMNS)
            new = rows != self._rows
            if new:
                self._rows = rows
                shared.resize(*rows)
            paused = int(self.paused or bool(states.numbers["paused"]))
            numbers = {**states.numbers, "paused": paused, "revision": self._revision}
            shared.restore_length()
            shared.publish(numbers, states.bodies, states.joints)
            if new:
                shared.show()
        if self._topics is not None:
            self._topics.update()
        self.server.post()

    # Scene -----------------------------------------------------------------------------------------------------------

    def _load_files(self) -> None:
        budget = Budget()
        for message in self.reader.messages(("own",), ("/gz/files",)):
            budget.take(len(message.data))
            name, content = read_file(message.data)
            self._files[name] = content

    def _show_scene(self, content: bytes) -> None:
        """Write a scene with a new number, and the files it names."""
        shared = self.server.shared
        if not isinstance(shared, SharedTables):
            return
        with understood("a scene"):
            scene = read_json(content)
            self._revision += 1
            scene["revision"] = self._revision
            used: set[str] = set()
            self._place_files(scene, used, shared)
            self.readings.show(scene)
            text = json.dumps(scene)
        shared.write_scene(text.encode(), used)

    def _place_files(self, part: Any, used: set[str], shared: SharedTables) -> None:
        """Write the data that a scene names, and replace paths of textures and skins that this machine lacks."""
        if isinstance(part, list):
            for inner in part:
                self._place_files(inner, used, shared)
        elif isinstance(part, dict):
            for key, value in part.items():
                if key in ("file", "texture") and isinstance(value, str):
                    part[key] = self._placed(value, used, shared)
                else:
                    self._place_files(value, used, shared)

    def _placed(self, name: str, used: set[str], shared: SharedTables) -> str:
        """Where a file is now."""
        if is_data_file(name):
            if name in self._files:
                shared.keep_content(name, self._files[name])
                used.add(name)
            return name
        if name not in self._files or Path(name).exists():
            return name
        if name not in self._unpacked:
            # In a folder of its own, so that what names its neighbours finds them.
            self._folder = self._folder or tempfile.TemporaryDirectory(prefix="gz-log-")
            target = Path(self._folder.name, f"{abs(hash(os.path.dirname(name))):x}", Path(name).name)  # noqa: PTH120
            target.parent.mkdir(exist_ok=True)
            target.write_bytes(self._files[name])
            self._unpacked[name] = str(target)
        return self._unpacked[name]


def _names(content: bytes) -> list[str]:
    """The names in a request for readings; none if it is not understood."""
    try:
        names = json.loads(content)["names"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return []
    return [name for name in names if isinstance(name, str)] if isinstance(names, list) else []
