"""Reconfigure: values that dynamic_reconfigure's tools, such as dynparam and rqt, show and change; of ROS 1."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from libgz.base.errors import GazeboError, ParameterError
from libgz.ros.session import Session
from libgz.ros.types import Message, message_type

__all__ = ["Knob", "Reconfigure"]

# Types of values -> their name in descriptions, the field of a Config, the type of its elements.
KINDS: dict[type, tuple[str, str, str]] = {
    bool: ("bool", "bools", "BoolParameter"),
    int: ("int", "ints", "IntParameter"),
    float: ("double", "doubles", "DoubleParameter"),
}
GROUP = "Default"  # the one that has all values


class Knob(NamedTuple):
    """A value that can be changed.

    Attributes:
        name: its name.
        default: a bool, int or float.
        low, high: the limits, to which it is set if it is beyond.
        meaning: shown by the tools.
        level: bits of what a change affects.
    """

    name: str
    default: Any
    low: Any
    high: Any
    meaning: str
    level: int = 0

    def limited(self, value: Any) -> Any:
        """A value of the right type within the limits.

        Raises:
            ParameterError: it is none.
        """
        kind = type(self.default)
        if kind is bool:
            return bool(value)
        if not (isinstance(value, int | float) and -math.inf < value < math.inf):  # also an int that no float can hold
            raise ParameterError(f"{self.name} is {value!r:.100}; it must be a number")
        return kind(min(max(value, self.low), self.high))


class Reconfigure:
    """A server of dynamic_reconfigure: two latched topics and a service in a namespace, and the parameters in it.

    Args:
        session: of ROS 1.
        space: the namespace.
        knobs: the values.
        changed: called between steps with the values that a request asks for; they are refused if it raises a
            GazeboError.
        present: the values at the start; None: those of the parameter server, or the defaults.

    Attributes:
        values: by their names.
    """

    def __init__(
        self,
        session: Session,
        space: str,
        knobs: Sequence[Knob],
        changed: Callable[[Mapping[str, Any]], object],
        present: Mapping[str, Any] | None = None,
    ) -> None:
        self._session, self._space, self._knobs, self._changed = session, session.resolve(space), knobs, changed
        kind = "dynamic_reconfigure/"
        self._service = session.serve("set_parameters", f"{kind}Reconfigure", self._on_request, self._space)
        self._about = session.publish("parameter_descriptions", f"{kind}ConfigDescription", 1, True, self._space)
        self._updates = session.publish("parameter_updates", f"{kind}Config", 1, True, self._space)
        self._about.publish(self._description())
        self.values = {knob.name: self._start(knob, present) for knob in knobs}
        self._publish_values()

    def end(self) -> None:
        """Serve and publish no longer."""
        self._service.end()
        self._about.end()
        self._updates.end()

    def _start(self, knob: Knob, present: Mapping[str, Any] | None) -> Any:
        full = f"{self._space}/{knob.name}"
        value = self._session.parameter(full, knob.default) if present is None else present[knob.name]
        try:
            return knob.limited(value)
        except ParameterError as error:
            self._session.log_refusal(full, error, "parameter")
            return knob.default

    def _on_request(self, request: Any) -> Message:
        values, known = dict(self.values), {knob.name: knob for knob in self._knobs}
        for kind, (_, field, _) in KINDS.items():
            for one in getattr(request.config, field):
                knob = known.get(one.name)
                if knob is None or type(knob.default) is not kind:
                    self._refuse(f"there is no {kind.__name__} {one.name!r:.100}; there are {', '.join(known)}")
                    continue
                try:
                    values[one.name] = knob.limited(one.value)
                except ParameterError as error:
                    self._refuse(error)
        try:
            self._changed(values)
        except GazeboError as error:
            self._refuse(error)
        else:
            self.values = values
            self._publish_values()
        answer: Any = self._service.kind.response(config=self._config(self.values))
        return answer  # type: ignore[no-any-return]

    def _refuse(self, why: object) -> None:
        self._session.log_refusal(self._service.name, why, "service")

    def _publish_values(self) -> None:
        """Publish the values, and set the parameters."""
        for name, value in self.values.items():
            self._session.set_parameter(f"{self._space}/{name}", value)
        self._updates.publish(self._config(self.values))

    def _config(self, values: Mapping[str, Any]) -> Message:
        found: Any = message_type("dynamic_reconfigure/Config")()
        for name, value in values.items():
            _, field, kind = KINDS[type(value)]
            getattr(found, field).append(message_type(f"dynamic_reconfigure/{kind}")(name=name, value=value))
        found.groups = [message_type("dynamic_reconfigure/GroupState")(name=GROUP, state=True)]
        return found  # type: ignore[no-any-return]

    def _description(self) -> Message:
        one = message_type("dynamic_reconfigure/ParamDescription")
        group: Any = message_type("dynamic_reconfigure/Group")(name=GROUP)
        group.parameters = [
            one(name=knob.name, type=KINDS[type(knob.default)][0], level=knob.level, description=knob.meaning)
            for knob in self._knobs
        ]
        found: Any = message_type("dynamic_reconfigure/ConfigDescription")(groups=[group])
        found.max = self._config({knob.name: knob.high for knob in self._knobs})
        found.min = self._config({knob.name: knob.low for knob in self._knobs})
        found.dflt = self._config({knob.name: knob.default for knob in self._knobs})
        return found  # type: ignore[no-any-return]
