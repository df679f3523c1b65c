"""Series: numbers over time, of a log or of a running server; shared by `libgz plot` and `libgz export`.

A target is an interface (``position.robot1``), the state of a body (``state.robot1``, ``state.robot1::canonical``), or,
in a log, a topic (``~/box/link/ray/scan``).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from libgz.apps.target import element_values, find_field, unit_of, values_of
from libgz.base.budget import Budget
from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuatern, GzQuaternToEuler, GzVector
from libgz.classic.msgs.message import Message
from libgz.interfaces.catalog import INTERFACES, new_interface
from libgz.recording.own_messages import read_json, read_tables, understood
from libgz.transport.interface import Interface
from libgz.transport.observer import Observer
from libgz.transport.server import LocalServer

if TYPE_CHECKING:  # needs the extra `log`
    from libgz.recording.reader import LogMessage, LogReader

__all__ = ["InterfaceValues", "Series", "StateValues", "TopicValues", "Values", "is_target", "log_values", "read_log"]

Row = dict[str, tuple[str, float]]  # label -> unit and number

# Fields of a body's state: their unit.
STATE = {"pos": "m", "rot": "rad", "vel": "m/s", "omega": "rad/s"}
_INDEX = re.compile(r"(\w+)((?:\[\d+\])*)")


def is_target(word: str) -> bool:
    """Whether a word of the command line names a target, not a field."""
    kind, dot, name = word.partition(".")
    return (
        word.startswith(("~/", "/gazebo/"))
        or word == "sim"
        or bool(dot and name and (kind in INTERFACES or kind == "state"))
    )


class Values(Protocol):
    """A target, at one moment after the other."""

    label: str

    def row(self, fields: list[str]) -> Row:
        """The numbers of fields now; of all of them, where none is named.

        Raises:
            ParameterError: there is no such field, or it is not numeric.
        """


class Series:
    """Numbers over sim time.

    Attributes:
        times: [s].
        lines: label -> numbers, as many as times; None where there was none.
        units: by label.
    """

    def __init__(self) -> None:
        self.times: list[float] = []
        self.lines: dict[str, list[float | None]] = {}
        self.units: dict[str, str] = {}
        self._budget = Budget()

    def add(self, time: float, row: Row) -> None:
        """Add the numbers of a moment [s].

        Raises:
            BudgetError: these are more numbers than a reader may hold.
        """
        self._budget.take(8 * (1 + len(row)))
        for label, (unit, _) in row.items():
            if label not in self.lines:
                self.lines[label] = [None] * len(self.times)
                self.units[label] = unit
        self.times.append(time)
        for label, line in self.lines.items():
            line.append(row[label][1] if label in row else None)


def _labelled(label: str, unit: str, numbers: list[float]) -> Row:
    if len(numbers) == 1:
        return {label: (unit, numbers[0])}
    return {f"{label}[{i}]": (unit, number) for i, number in enumerate(numbers)}


class InterfaceValues:
    """The fields of an interface."""

    def __init__(self, interface: Interface[Any]) -> None:
        self.interface = interface
        self.label = f"{interface.type}.{interface.id}"

    def load(self, message: LogMessage) -> None:
        """Show what a message says."""
        Interface.set_bytes(self.interface, message.data)

    def row(self, fields: list[str]) -> Row:
        """The numbers of fields now."""
        found: Row = {}
        interface = self.interface
        if fields:
            for text in fields:
                place = find_field(interface, text)
                with interface.locked() as data:
                    found |= _labelled(text, unit_of(data, place), list(element_values(data, place)))
            return found
        for name, value in values_of(interface).items():
            found |= _flat(name, value)
        return found


def _flat(label: str, value: Any) -> Row:
    """All numbers in plain data."""
    found: Row = {}
    if isinstance(value, dict):
        for name, part in value.items():
            found |= _flat(f"{label}.{name}" if label else name, part)
    elif isinstance(value, list):
        for i, part in enumerate(value):
            found |= _flat(f"{label}[{i}]", part)
    elif isinstance(value, bool | int | float):
        found[label] = ("", float(value))
    return found


class StateValues:
    """Pose and velocities of a model, a light or a body."""

    def __init__(self, name: str) -> None:
        self.name, self.label = name, f"state.{name}"
        self._row, self._offset = -1, GzPose()
        self._numbers: list[float] = []

    def place(self, scene: dict[str, Any]) -> None:
        """Find it in a scene.

        Raises:
            NotFoundError: it is not there.
        """
        rows = {body["id"]: body["row"] for entity in scene["entities"] for body in entity["bodies"]}
        names: dict[str, tuple[int, list[float]]] = {}
        for entity in scene["entities"]:
            if entity["body"]:
                names[entity["id"]] = rows[entity["body"]], entity["pose"]
            for body in entity["bodies"]:
                names[f"{entity['id']}::{body['name']}"] = body["row"], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        if self.name not in names:
            raise NotFoundError(f"there is no body {self.name!r}{nearest(self.name, names)}")
        self._row, pose = names[self.name]
        self._offset = GzPose(GzVector(*pose[:3]), GzQuatern(*pose[3:]))

    def load_rows(self, bodies: Any) -> None:
        """New states, rows of the table of bodies."""
        self._numbers = bodies[self._row].tolist()

    def row(self, fields: list[str]) -> Row:
        """The numbers of fields now."""
        body = GzPose(GzVector(*self._numbers[:3]), GzQuatern(*self._numbers[3:7]))
        pose = GzCoordPoseAdd(self._offset, body)
        values = {
            "pos": list(pose.pos),
            "rot": list(GzQuaternToEuler(pose.rot)),
            "vel": self._numbers[10:13],
            "omega": self._numbers[13:16],
        }
        found: Row = {}
        for text in fields or STATE:
            match = _INDEX.fullmatch(text)
            name = match[1] if match else text
            index = [int(word) for word in re.findall(r"\d+", match[2])] if match else []
            if name not in values or len(index) > 1 or any(i > 2 for i in index):
                raise ParameterError(f"{self.label} has no field {text!r}; it has {', '.join(STATE)}, of three numbers")
            numbers = values[name] if not index else [values[name][index[0]]]
            found |= _labelled(text, STATE[name], numbers)
        return found


class TopicValues:
    """The fields of a topic's messages."""

    def __init__(self, topic: str, kind: type[Message]) -> None:
        self.label, self._kind = topic, kind
        self._message = kind()

    def load(self, message: LogMessage) -> None:
        """The next message."""
        self._message = self._kind.FromString(message.data)

    def row(self, fields: list[str]) -> Row:
        """The numbers of fields now."""
        if not fields:
            return _flat("", _plain(self._message))
        found: Row = {}
        for text in fields:
            found |= _flat(text, _plain(self._at(text)))
        if not found:
            raise ParameterError(f"{self.label}: {', '.join(fields)} has no numbers")
        return found

    def _at(self, text: str) -> Any:
        value: Any = self._message
        for part in text.split("."):
            match = _INDEX.fullmatch(part)
            known = value.DESCRIPTOR.fields_by_name if isinstance(value, Message) else {}
            if match is None or match[1] not in known:
                raise ParameterError(f"{self.label} has no field {text!r}; there are {', '.join(known) or 'no more'}")
            value = getattr(value, match[1])
            for word in re.findall(r"\d+", match[2]):
                if not _is_list(value) or int(word) >= len(value):
                    raise ParameterError(f"{self.label}: there is no {text!r}")
                value = value[int(word)]
        return value


def _plain(value: Any) -> Any:
    if isinstance(value, Message):
        return {field.name: _plain(part) for field, part in value.ListFields()}
    if _is_list(value):
        return [_plain(part) for part in value]
    return value


def _is_list(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, (str, bytes))


# Logs ---------------------------------------------------------------------------------------------------------------


def log_values(log: LogReader, target: str) -> tuple[Values, Iterator[float]]:
    """A target in a log, and the sim times [s] at which it changed: the target is at each of them in turn.

    Raises:
        NotFoundError: the log has no such target.
        ParameterError: the log is damaged.
    """
    if target.startswith("state."):
        values = StateValues(target.removeprefix("state."))
        return values, _state_times(log, values)
    if not target or target[0] in "~/":
        name = f"/gazebo/{log.about.get('world', 'default')}{target[1:]}" if target[0] == "~" else target
        from libgz.recording.topics import type_of_topic  # legacy worlds have no topics

        about = log.topic(name).about
        topic = TopicValues(target, type_of_topic(about.get("type", ""), about.get("declaration", "")))
        return topic, _times(log, name, topic)
    kind, dot, name = target.partition(".")
    if kind not in INTERFACES:
        raise NotFoundError(f"there is no interface type {kind!r}{nearest(kind, INTERFACES)}")
    interface = new_interface(kind)
    channel = log.topic(f"/{kind}/{name if dot else 'default'}")
    interface.create(LocalServer(int(channel.about.get("version", 0x060))), name if dot else "default")
    if interface.size != int(channel.about.get("size", interface.size)):
        interface.destroy()
        interface = new_interface(kind)
        setattr(interface, "later", True)  # noqa: B010 - a gripper with the struct of November 2006
        interface.create(LocalServer(), name)
    fields = InterfaceValues(interface)
    return fields, _times(log, channel.topic, fields)


def _times(log: LogReader, topic: str, values: InterfaceValues | TopicValues) -> Iterator[float]:
    for message in log.messages(topics=(topic,)):
        values.load(message)
        yield message.sim_time * 1e-9


def _state_times(log: LogReader, values: StateValues) -> Iterator[float]:
    there = False
    missing: NotFoundError | None = None
    for message in log.messages(topics=("/gz/scene", "/gz/tables")):
        if message.channel.topic == "/gz/scene":
            try:
                values.place(read_json(message.data))
                there = True
            except NotFoundError as error:  # it may still come, or have gone
                there, missing = False, missing or error
        elif there:
            values.load_rows(read_tables(message.data).body_rows)
            missing = None
            yield message.sim_time * 1e-9
    if missing is not None and not there:
        raise missing


def read_log(log: LogReader, target: str, fields: list[str]) -> Series:
    """All numbers of a target in a log.

    Raises:
        NotFoundError: the log has no such target.
        ParameterError: there is no such field, or the log is damaged.
    """
    series = Series()
    with understood(target):
        values, times = log_values(log, target)
        for time in times:
            series.add(time, values.row(fields))
    return series


def observe(observer: Observer, values: StateValues) -> float:
    """Read a body's state from a running server; its sim time [s].

    Raises:
        NotFoundError: it is not there.
    """
    values.place(observer.scene)
    state = observer.state()
    values.load_rows(state.bodies)
    return state.sim_time
