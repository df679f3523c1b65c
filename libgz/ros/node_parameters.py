"""NodeParameters: the parameters of a node of ROS 2, and the services by which others list, read and set them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from typing import Any, NamedTuple

import numpy as np

from libgz.base.errors import GazeboError, ParameterError
from libgz.ros.own_node import OwnNode
from libgz.ros.parameters import MOST_LEVELS
from libgz.ros.session import Service, Session
from libgz.ros.types import Message, message_type, service_type

__all__ = ["SERVICES", "NodeParameters"]

log = logging.getLogger("libgz.ros")

SERVICES = {
    name: f"rcl_interfaces/{name.title().replace('_', '')}"
    for name in (
        "describe_parameters",
        "get_parameter_types",
        "get_parameters",
        "list_parameters",
        "set_parameters",
        "set_parameters_atomically",
    )
}
MOST_PARAMETERS, MOST_SIZE = 1000, 1 << 20  # of a node, and bytes of all their values
MOST_ASKED = 1 << 20  # bytes of an answer
OVERHEAD = 16  # bytes of a value beside its texts and numbers
SIM_TIME = "use_sim_time"

NOT_SET = 0
# Numbers of types -> field of rcl_interfaces/ParameterValue, and name.
TYPES = {
    1: ("bool_value", "bool"),
    2: ("integer_value", "integer"),
    3: ("double_value", "double"),
    4: ("string_value", "string"),
    5: ("byte_array_value", "byte_array"),
    6: ("bool_array_value", "bool_array"),
    7: ("integer_array_value", "integer_array"),
    8: ("double_array_value", "double_array"),
    9: ("string_array_value", "string_array"),
}
DOUBLE = 3
SCALARS: dict[type, int] = {bool: 1, int: 2, float: 3, str: 4}
LISTS: dict[type, int] = {bool: 6, int: 7, float: 8, str: 9}


class _Declared(NamedTuple):
    """A parameter that its owner declared.

    Attributes:
        kind: number of its type, which stays.
        meaning: for those who ask.
        check: called with a value that others want to set; it may raise a GazeboError, whose text is the reason.
        changed: called with a value that others have set.
    """

    kind: int
    meaning: str
    check: Callable[[Any], object]
    changed: Callable[[Any], object]


class _Values(dict[str, Any]):
    """Values by their names.

    Attributes:
        size: about how many bytes all have, with their names.
    """

    size = 0

    def __setitem__(self, name: str, value: Any) -> None:
        self.size += self.growth(name, value)
        super().__setitem__(name, value)

    def __delitem__(self, name: str) -> None:
        self.size += self.growth(name, None)
        super().__delitem__(name)

    def growth(self, name: str, value: Any) -> int:
        """By how many bytes it grows with a value; None: without one of that name."""
        before = self.get(name)
        return sum(sign * (len(name) + _size(one)) for sign, one in ((1, value), (-1, before)) if one is not None)


class NodeParameters:
    """The parameters of a node; all methods belong to the thread of the world.

    Where a node of the same name has some already, nobody can ask for those of this one.

    Args:
        session: of this process.
        node: the node; the values of its parameters as files and command lines have them are those of `node.given`.
        open: whether others may set parameters that were not declared.
    """

    def __init__(self, session: Session, node: OwnNode, open: bool = False) -> None:
        self._session, self._node, self._open = session, node, open
        self._value = message_type("rcl_interfaces/ParameterValue", 2)
        self._named = message_type("rcl_interfaces/Parameter", 2)
        self._given = dict(_flat(node.given))
        self._declared: dict[str, _Declared] = {}
        self._values = _Values()  # of _value
        self._events = session.parameter_events  # advertised at once, for those who wait for it
        self._services: list[Service] = []
        if not session.served("~/list_parameters", node):
            for name, kind in SERVICES.items():
                self._services.append(session.serve(f"~/{name}", kind, self._handler(name), node=node))
        self.declare(SIM_TIME, True, "messages have sim time in any case", changed=self._on_sim_time)

    def end(self) -> None:
        """Serve no longer."""
        for one in self._services:
            one.end()

    def declare(
        self,
        name: str,
        default: Any,
        meaning: str = "",
        check: Callable[[Any], object] = lambda _value: None,
        changed: Callable[[Any], object] = lambda _value: None,
    ) -> Any:
        """Declare a parameter; its value: the given one if it has the type of the default.

        Args:
            name: its name.
            default: its value, or its type if it is not set at first.
            meaning: for those who ask.
            check: called with a value that others want to set; it may raise a GazeboError, whose text is the reason.
            changed: called with a value that others have set.
        """
        kind = SCALARS[default if isinstance(default, type) else type(default)]
        self._declared[name] = _Declared(kind, meaning, check, changed)
        given = self._given.get(name)
        if kind == DOUBLE and type(given) is int:
            given = float(given)
        found = None if given is None else self._message(given)
        if given is not None and (found is None or found.type != kind):
            text = "ROS 2: parameter %s of %s is %.200r; it must be a %s"
            log.warning(text, name, self._node.full_name, given, TYPES[kind][1])
            found = None
        if found is None:
            found = self._value() if isinstance(default, type) else self._message(default)
        self._values[name] = found
        return self.value(name)

    def take_given(self) -> None:
        """Have all parameters that are given, though nobody declared them."""
        for name, value in self._given.items():
            if (found := self._message(value)) is not None and name not in self._declared:
                self._values[name] = found

    def values(self) -> dict[str, Any]:
        """All that have a value."""
        return {name: self.value(name) for name, found in self._values.items() if found.type != NOT_SET}

    def value(self, name: str) -> Any:
        """The value of a parameter; None if it has none."""
        found = self._values.get(name)
        return None if found is None or found.type == NOT_SET else getattr(found, TYPES[found.type][0])

    def set(self, name: str, value: Any) -> None:
        """Set a parameter that was declared, by its owner."""
        self._values[name] = self._message(value)
        self._announce(changed_parameters=[self._named(name=name, value=self._values[name])])

    def _message(self, value: Any) -> Any:
        """A value as a message; None if no parameter can have it."""
        kinds: set[type] = {type(one) for one in value} if isinstance(value, list) else {type(value)}
        if kinds == {int, float}:
            kinds, value = {float}, [float(one) for one in value]
        if len(kinds) != 1:
            return None
        (one,) = kinds
        kind = (LISTS if isinstance(value, list) else SCALARS).get(one)
        if kind is None:
            return None
        if one is int and not all(abs(number) < 1 << 63 for number in (value if isinstance(value, list) else [value])):
            return None
        return self._value(**{"type": kind, TYPES[kind][0]: value})

    def _on_sim_time(self, value: bool) -> None:
        if not value:
            log.warning("ROS 2: use_sim_time of %s: messages have sim time all the same", self._node.full_name)

    # Services ----------------------------------------------------------------------------------------------------

    def _handler(self, name: str) -> Callable[[Any], Message]:
        method, kind = getattr(self, f"_{name}"), service_type(SERVICES[name], 2)

        def handle(request: Any) -> Message:
            for field in kind.request.fields:
                value = getattr(request, field.name)
                if isinstance(value, list) and len(value) > MOST_PARAMETERS:
                    raise ParameterError(f"{len(value)} {field.name} in one request; at most {MOST_PARAMETERS}")
            answer: Message = kind.response(**method(request))
            return answer

        return handle

    def _list_parameters(self, request: Any) -> dict[str, Any]:
        wanted = frozenset(request.prefixes)
        names = [name for name in sorted(self._values) if _listed(name, wanted, request.depth)]
        prefixes = sorted({name.rpartition(".")[0] for name in names} - {""})
        return {"result": message_type("rcl_interfaces/ListParametersResult", 2)(names=names, prefixes=prefixes)}

    def _known(self, names: Sequence[str]) -> list[str]:
        """Names, none if one of them is no parameter, as rclcpp has it; or if the answer would be too long."""
        if not self._open and not all(name in self._values for name in names):
            return []
        size = sum(_size(self._values[name]) if name in self._values else OVERHEAD for name in names)
        if size > MOST_ASKED:
            what = f"{self._node.full_name}: so many parameters that the answer would be longer than {MOST_ASKED} bytes"
            self._session.log_refusal("parameters", what, "service")
            return []
        return list(names)

    def _get_parameters(self, request: Any) -> dict[str, Any]:
        return {"values": [self._values.get(name) or self._value() for name in self._known(request.names)]}

    def _get_parameter_types(self, request: Any) -> dict[str, Any]:
        return {
            "types": [one.type if (one := self._values.get(name)) else NOT_SET for name in self._known(request.names)]
        }

    def _describe_parameters(self, request: Any) -> dict[str, Any]:
        return {"descriptors": [self._descriptor(name) for name in self._known(request.names)]}

    def _descriptor(self, name: str) -> Message:
        known, value = self._declared.get(name), self._values.get(name)
        kind = known.kind if known else value.type if value else NOT_SET
        found: Any = message_type("rcl_interfaces/ParameterDescriptor", 2)(name=name, type=kind)
        found.description, found.dynamic_typing = (known.meaning, False) if known else ("", True)
        return found  # type: ignore[no-any-return]

    def _set_parameters(self, request: Any) -> dict[str, Any]:
        return {"results": [self._set([one]) for one in request.parameters]}

    def _set_parameters_atomically(self, request: Any) -> dict[str, Any]:
        return {"result": self._set(request.parameters)}

    def _set(self, parameters: Sequence[Any]) -> Message:
        """Set parameters, all of them or none; without a value, those that were not declared are deleted."""
        result: Any = message_type("rcl_interfaces/SetParametersResult", 2)(successful=True)
        wanted, known = {one.name: self._plain(one.value) for one in parameters}, self._values
        try:
            for name, value in wanted.items():
                self._check(name, value)
            gone = {name for name, value in wanted.items() if value.type == NOT_SET and name not in self._declared}
            growth = sum(known.growth(name, None if name in gone else value) for name, value in wanted.items())
            count = len(known) + sum((name not in gone) - (name in known) for name in wanted)
            if count > MOST_PARAMETERS or known.size + growth > MOST_SIZE:
                raise ParameterError(f"a node has at most {MOST_PARAMETERS} parameters with {MOST_SIZE} bytes")
        except GazeboError as error:
            result.successful, result.reason = False, str(error)
            return result  # type: ignore[no-any-return]
        rows: dict[str, list[Any]] = {"new_parameters": [], "changed_parameters": [], "deleted_parameters": []}
        for name, value in wanted.items():
            sort = "deleted" if name in gone else "changed" if name in known else "new"
            rows[f"{sort}_parameters"].append(self._named(name=name, value=value))
            if name not in gone:
                known[name] = value
            elif name in known:
                del known[name]
        for name in wanted:
            if name in self._declared:
                self._declared[name].changed(self.value(name))
        self._announce(**rows)
        return result  # type: ignore[no-any-return]

    def _plain(self, value: Any) -> Any:
        """A value that came, without what is not of its type; arrays keep the bytes of the request alive."""
        if value.type not in TYPES:
            return self._value()
        field = TYPES[value.type][0]
        found = getattr(value, field)
        return self._value(**{"type": value.type, field: found.tolist() if isinstance(found, np.ndarray) else found})

    def _check(self, name: str, value: Any) -> None:
        """Whether others may set a parameter.

        Raises:
            ParameterError: they may not.
        """
        known = self._declared.get(name)
        if known is None:
            if not self._open:
                raise ParameterError(f"parameter '{name}' cannot be set because it was not declared")
            if name.count(".") > MOST_LEVELS:  # as in files
                raise ParameterError(f"the name of a parameter has {name.count('.')} points; at most {MOST_LEVELS}")
            return
        if value.type != known.kind:
            wanted, other = (TYPES.get(kind, ("", "not set"))[1] for kind in (known.kind, value.type))
            raise ParameterError(
                f"Wrong parameter type, parameter {{{name}}} is of type {{{wanted}}}, setting it to {{{other}}} is not "
                "allowed."
            )
        known.check(getattr(value, TYPES[value.type][0]))

    def _announce(self, **rows: list[Any]) -> None:
        """Publish an event, with the parameters of its fields."""
        if self._events.listened:
            self._events.publish(self._events.kind(node=self._node.full_name, **rows))


def _flat(given: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """(name with points, value) of values in tables."""
    for name, value in given.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _listed(name: str, prefixes: Set[str], depth: int) -> bool:
    """Whether a name is below one of some prefixes, at most so many levels; 0: at any level."""
    parts = name.split(".")
    if not prefixes:
        return not depth or len(parts) <= depth
    return any(
        ".".join(parts[:count]) in prefixes and (not depth or len(parts) - count <= depth)
        for count in range(1, len(parts) + 1)
    )


def _size(value: Any) -> int:
    """About how many bytes a value has."""
    found = getattr(value, TYPES[value.type][0]) if value.type in TYPES else 0
    if isinstance(found, str):
        return OVERHEAD + len(found)
    if isinstance(found, list):
        return OVERHEAD + sum(OVERHEAD + len(one) if isinstance(one, str) else 8 for one in found)
    return OVERHEAD
