"""Parameters: values for the nodes of ROS 2, from files and command lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from libgz.base.errors import GazeboError, NotFoundError, ParameterError
from libgz.base.files import open_file

__all__ = ["Parameters", "tables"]

OWN = "ros__parameters"  # what is below it in a file are values, what is above it names of nodes
LARGEST_FILE = 1 << 20  # bytes
MOST_LEVELS = 32  # of a name with points


class Parameters:
    """Values for nodes; later ones replace earlier ones.

    Names of nodes are full ones, such as ``/robot/gazebo``, or have wildcards: ``*`` for one part of a name, ``**`` for
    any number of parts. A name without a namespace is that of a node in any one.
    """

    def __init__(self) -> None:
        self._rows: list[tuple[list[str], dict[str, Any]]] = []

    def read(self, path: Path) -> None:
        """Take the parameters of a YAML file.

        Raises:
            NotFoundError: there is no such file.
            ParameterError: it is no such file, or too large, or nested too deeply.
        """
        try:
            with open_file(path) as file:
                data = file.read(LARGEST_FILE + 1)
        except OSError as error:
            raise NotFoundError(f"{path}: {error.strerror}") from None
        if len(data) > LARGEST_FILE:
            raise ParameterError(f"{path} has more than {LARGEST_FILE} bytes")
        try:
            found = _value(data)
            if not isinstance(found, Mapping):
                raise ParameterError("it has no parameters")
            self._take([], found)
        except GazeboError as error:
            raise ParameterError(f"{path}: {error}") from None

    def _take(self, names: list[str], found: Mapping[Any, Any]) -> None:
        for name, value in found.items():
            if name == OWN:
                values: dict[str, Any] = {}
                _put(values, value)
                self._rows.append((names, values))
            elif isinstance(value, Mapping):
                self._take([*names, *(part for part in str(name).split("/") if part)], value)

    def set(self, node: str, name: str, text: str) -> None:
        """Set one value, given as YAML has it; an empty name of a node is that of all."""
        try:
            value = _value(text.encode(errors="surrogateescape"))
        except GazeboError:
            value = text
        values: dict[str, Any] = {}
        _put(values, {name: text if value is None else value})
        self._rows.append(([part for part in node.split("/") if part] or ["**"], values))

    def of(self, node: str) -> dict[str, Any]:
        """The values for a node, by its full name; those whose names have points are in tables."""
        own = [part for part in node.split("/") if part]
        found: dict[str, Any] = {}
        for names, values in self._rows:
            if _matches(names, own if len(names) > 1 else own[-1:]):
                _put(found, values)
        return found


def tables(*given: Mapping[str, Any]) -> dict[str, Any]:
    """Values in tables, by the points of their names; later ones replace earlier ones."""
    found: dict[str, Any] = {}
    for values in given:
        _put(found, values)
    return found


def _matches(names: Sequence[str], own: Sequence[str]) -> bool:
    """Whether parts with wildcards match the parts of a name."""
    reached = {0}  # how many parts of the name may be matched so far
    for name in names:
        if name == "**":
            reached = set(range(min(reached, default=len(own) + 1), len(own) + 1))
        else:
            reached = {at + 1 for at in reached if at < len(own) and name in ("*", own[at])}
    return len(own) in reached


def _put(found: dict[str, Any], values: Any) -> None:
    """Put values into tables; a name with points, such as ``linear.x``, is a way through tables."""
    for name, value in values.items() if isinstance(values, Mapping) else ():
        *way, last = str(name).split(".")
        if len(way) > MOST_LEVELS:
            raise ParameterError(f"the name of a parameter has {len(way)} points; at most {MOST_LEVELS} are taken")
        place = found
        for part in way:
            place = _table(place, part)
        if isinstance(value, Mapping):
            _put(_table(place, last), value)
        else:
            place[last] = value


def _table(place: dict[str, Any], name: str) -> dict[str, Any]:
    if not isinstance(place.get(name), dict):
        place[name] = {}
    found: dict[str, Any] = place[name]
    return found


def _value(data: bytes) -> Any:
    """The value of a text of YAML.

    Raises:
        GazeboError: it is none, or too large.
    """
    from libgz.sdf.xacro.documents import parsed_yaml, value_of_yaml  # only then is PyYAML loaded
    from libgz.sdf.xacro.limits import Budget

    budget = Budget()
    found = value_of_yaml(parsed_yaml(data, budget), budget, float)
    budget.measure(found)
    return found
