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
from libgz.base.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuatern, GzQuaternToEuler, GzVector
from libgz.classic.msgs.message import Message
from libgz.interfaces.catalog import INTERFACES, new_interface
from libgz.recording.own_messages import read_json, read_tables, understood
from libgz.transport.interface import Interface
from libgz.transport.observer import Observer
from libgz.transport.server import LocalServer

if TYPE_CHECKING:  # needs the extra `log`
    from libgz.recording.reader import LogMessage, LogReader

__all__ = ["InterfaceValues", "Series", "StateValues", "TopicValues", "Values", "is_target", "observe", "read_logs"]

Row = dict[str, tuple[str, float]]  # label -> unit and number
Places = dict[str, tuple[int, list[float]]]  # name -> row in the table of bodies, and a pose in that body's frame

# Fields of a body's state: their unit.
STATE = {"pos": "m", "rot": "rad", "vel": "m/s", "omega": "rad/s"}
SCENE, TABLES = "/gz/scene", "/gz/tables"  # topics of logs
_NO_PLACES: Places = {}
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

    Args:
        budget: that holds them; None for one of its own.

    Attributes:
        times: [s].
        lines: label -> numbers, as many as times; None where there was none.
        units: by label.
    """

    def __init__(self, budget: Budget | None = None) -> None:
        self.times: list[float] = []
        self.lines: dict[str, list[float | None]] = {}
        self.units: dict[str, str] = {}
        self._budget = budget if budget is not None else Budget()

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


def _places(scene: dict[str, Any]) -> Places:
    """What of a scene has a state."""
    rows = {body["id"]: body["row"] for entity in scene["entities"] for body in entity["bodies"]}
    found = {}
    for entity in scene["entities"]:
        if entity["body"]:
            found[entity["id"]] = rows[entity["body"]], entity["pose"]
        for body in entity["bodies"]:
            found[f"{entity['id']}::{body['name']}"] = body["row"], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    return found


class StateValues:
    """Pose and velocities of a model, a light or a body."""

    def __init__(self, name: str) -> None:
        self.name, self.label = name, f"state.{name}"
        self._row, self._offset = -1, GzPose()
        self._numbers: list[float] = []

    def place(self, places: Places) -> None:
        """Find it in a scene.

        Raises:
            NotFoundError: it is not there.
        """
        if self.name not in places:
            raise NotFoundError(f"there is no body {self.name!r}{nearest(self.name, places)}")
        self._row, pose = places[self.name]
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


class _Listener(Protocol):
    """What reads a target's messages in a log."""

    def load(self, message: LogMessage) -> None:
        """Show what a message says."""

    def row(self, fields: list[str]) -> Row:
        """The numbers of fields now."""


class _LoggedState:
    """The state of a body in a log, where it can begin and end."""

    def __init__(self, name: str) -> None:
        self.values = StateValues(name)
        self._there, self._missed_in = False, _NO_PLACES

    def show(self, places: Places) -> None:
        """A scene that holds from now on."""
        self._there = self.values.name in places
        if self._there:
            self.values.place(places)
        elif self._missed_in is _NO_PLACES:
            self._missed_in = places

    def load(self, bodies: Any) -> bool:
        """New states, rows of the table of bodies; whether it has one."""
        if self._there:
            self.values.load_rows(bodies)
            self._missed_in = _NO_PLACES
        return self._there

    def end(self) -> None:
        """No more comes.

        Raises:
            NotFoundError: it was nowhere.
        """
        if self._missed_in is not _NO_PLACES and not self._there:
            self.values.place(self._missed_in)


def read_logs(log: LogReader, wanted: Sequence[tuple[str, list[str]]]) -> Iterator[Series]:
    """All numbers of targets, each with its fields, in a log, in their order.

    The log is read once for as many of them as a reader may hold, and up to the first that fails.

    Raises:
        NotFoundError: the log has no such target.
        ParameterError: there is no such field, or the log is damaged.
    """
    begin, size = 0, len(wanted)
    while begin < len(wanted):
        part = wanted[begin : begin + size]
        try:
            with understood(part[0][0]):
                found = _read(log, part)
        except GazeboError:
            if len(part) == 1:
                raise
            size = len(part) // 2
            continue
        yield from found
        begin += len(part)


def _read(log: LogReader, wanted: Sequence[tuple[str, list[str]]]) -> list[Series]:
    """The numbers of targets, by one reading of the log; whatever is wrong with one of them is raised."""
    budget = Budget()
    found = [Series(budget) for _ in wanted]
    states: list[tuple[_LoggedState, list[str], Series]] = []
    others: dict[str, list[tuple[_Listener, list[str], Series]]] = {}
    for (target, fields), series in zip(wanted, found, strict=True):
        if target.startswith("state."):
            states.append((_LoggedState(target.removeprefix("state.")), fields, series))
        else:
            topic, values = _listener(log, target, budget)
            others.setdefault(topic, []).append((values, fields, series))
    for message in log.messages(topics={*others, *((SCENE, TABLES) if states else ())}):
        topic, time = message.channel.topic, message.sim_time * 1e-9
        if states and topic == SCENE:
            places = _places(read_json(message.data))
            for state, _, _ in states:
                state.show(places)
        elif states and topic == TABLES:
            bodies = read_tables(message.data).body_rows
            for state, fields, series in states:
                if state.load(bodies):
                    series.add(time, state.values.row(fields))
        for values, fields, series in others.get(topic, ()):
            values.load(message)
            series.add(time, values.row(fields))
    for state, _, _ in states:
        state.end()
    return found


def _listener(log: LogReader, target: str, budget: Budget) -> tuple[str, _Listener]:
    """The topic of a target in a log that is no state, and what reads it.

    Raises:
        BudgetError: it needs more than a reader may hold.
        NotFoundError: the log has no such target.
        ParameterError: the log is damaged.
    """
    if not target or target[0] in "~/":
        name = f"/gazebo/{log.about.get('world', 'default')}{target[1:]}" if target[0] == "~" else target
        from libgz.recording.topics import type_of_topic  # legacy worlds have no topics

        about = log.topic(name).about
        return name, TopicValues(target, type_of_topic(about.get("type", ""), about.get("declaration", "")))
    kind, dot, name = target.partition(".")
    if kind not in INTERFACES:
        raise NotFoundError(f"there is no interface type {kind!r}{nearest(kind, INTERFACES)}")
    interface = new_interface(kind)
    channel = log.topic(f"/{kind}/{name if dot else 'default'}")
    budget.take(interface.size)
    interface.create(LocalServer(int(channel.about.get("version", 0x060))), name if dot else "default")
    if interface.size != int(channel.about.get("size", interface.size)):
        interface.destroy()
        interface = new_interface(kind)
        setattr(interface, "later", True)  # noqa: B010 - a gripper with the struct of November 2006
        interface.create(LocalServer(), name)
    return channel.topic, InterfaceValues(interface)


def observe(observer: Observer, values: StateValues) -> float:
    """Read a body's state from a running server; its sim time [s].

    Raises:
        NotFoundError: it is not there.
    """
    values.place(_places(observer.scene))
    state = observer.state()
    values.load_rows(state.bodies)
    return state.sim_time
