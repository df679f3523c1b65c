"""OwnNode: a node of ROS 2 that the server is, beside others: its names, remappings, parameters and qualities."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from libgz.ros.bridged import NodeSettings

if TYPE_CHECKING:
    from libgz.ros.names import NodeNames
    from libgz.sdf.element import Element

__all__ = ["OwnNode", "remappings"]

log = logging.getLogger("libgz.ros")

INVALID = re.compile(r"\W", re.ASCII)
POLICIES = {
    "reliability": ("reliable", "best_effort"),
    "durability": ("volatile", "transient_local"),
    "history": ("keep_last", "keep_all"),
    "liveliness": ("automatic", "manual_by_topic"),
}
TIMES = ("deadline", "lifespan", "liveliness_lease_duration")  # [ms] in the file
MOST_DEPTH = 100_000


class OwnNode:
    """A node of ROS 2. What the server's command line says about all nodes holds for it, too.

    Args:
        names: of the server.
        space: the namespace, absolute.
        name: its name.
        rules: (name, its new name) of topics and services; they come before those of the command line.
        given: values of parameters, instead of those of the command line.
        qualities: (topic, publisher or subscription, policies).

    Attributes:
        full_name: with the namespace.
        given: values of parameters by their names; those whose names have points are in tables.
        settings: for the bridge.
    """

    def __init__(
        self,
        names: NodeNames,
        space: str,
        name: str,
        rules: Iterable[tuple[str, str]] = (),
        given: Mapping[str, Any] | None = None,
        qualities: Iterable[tuple[str, str, Mapping[str, Any]]] = (),
    ) -> None:
        name = INVALID.sub("_", name) or "plugin"
        self._space, self._name = _path(space), f"n{name}" if name[0].isdigit() else name
        self.full_name = _path(f"{self._space}/{self._name}")
        shared = [(before, after) for node, before, after in names.rules if node in ("", self._name)]
        ordered = reversed([*rules, *(one for one in shared if not one[0].startswith("__"))])
        self._rules = {self.full(before): self.full(after) for before, after in ordered}  # the first of some counts
        self.given = {**(names.values.of(self.full_name) if names.values is not None else {}), **(given or {})}
        qos = {(self.full(topic), side): policies for topic, side, policies in qualities}
        self.settings = NodeSettings(self._space, self._name, qos)

    @classmethod
    def of_plugin(cls, names: NodeNames, sdf: Element, space: str) -> OwnNode:
        """The node of a plugin, from its element.

        Args:
            names: of the server.
            sdf: of the plugin.
            space: the namespace, absolute, unless the element says otherwise; empty: as the command line says.
        """
        name, rules = sdf.Get(str, "name"), []
        shared = {before: after for node, before, after in reversed(names.rules) if node == name}
        space = space or shared.get("__ns") or names.namespace
        name = shared.get("__node") or shared.get("__name") or name
        for before, after in remappings(sdf):
            if before == "__ns":
                space = after
            elif before in ("__node", "__name"):
                name = after
            else:
                rules.append((before, after))
        return cls(names, space, name, rules, dict(_parameters(sdf)), _qualities(sdf))

    def full(self, name: str, within: str = "") -> str:
        """The full name of a topic or service, before remapping."""
        if name.startswith("~"):
            return _path(f"{self.full_name}/{name[1:]}")
        return _path(name if name.startswith("/") else f"{self._space}/{within}/{name}")

    def resolve(self, name: str, within: str = "") -> str:
        """The full name of a topic or service, remapped."""
        plain = self.full(name, within)
        return self._rules.get(plain, plain)


def _path(name: str) -> str:
    parts = (INVALID.sub("_", part) for part in name.split("/") if part)
    return "/" + "/".join(parts)


def remappings(sdf: Element) -> Iterator[tuple[str, str]]:
    """(name, its new name) of the `<remapping>` and `<argument>` elements of `<ros>`."""
    for ros in sdf.named("ros"):
        for one in (*ros.named("remapping"), *ros.named("argument")):
            before, colon, after = one.Get(str).strip().partition(":=")
            if colon:
                yield before.strip(), after.strip()


def _parameters(sdf: Element) -> Iterator[tuple[str, Any]]:
    """(name, value) of the `<parameter>` elements of `<ros>`."""
    kinds: dict[str, type] = {"int": int, "double": float, "float": float, "bool": bool, "string": str}
    for one in (one for ros in sdf.named("ros") for one in ros.named("parameter")):
        name, kind = (one.Get(str, key) if one.HasAttribute(key) else "" for key in ("name", "type"))
        if name and kind in kinds:
            yield name, one.Get(kinds[kind])
        else:
            log.warning("%s: <parameter> needs a name and a type, one of %s", one.where, ", ".join(kinds))


def _qualities(sdf: Element) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """(topic, publisher or subscription, policies) of the `<qos>` elements of `<ros>`."""
    for topic in (one for ros in sdf.named("ros") for qos in ros.named("qos") for one in qos.named("topic")):
        for side in ("publisher", "subscription"):
            for given in topic.named(side):
                yield topic.Get(str, "name"), side, dict(_policies(given))


def _policies(given: Element) -> Iterator[tuple[str, Any]]:
    for name, allowed in POLICIES.items():
        for one in given.named(name):
            text = one.Get(str).strip().lower()
            if text in allowed:
                yield name, text
            elif text != "system":
                log.warning("%s: <%s> is %r; it must be one of %s", one.where, name, text, ", ".join(allowed))
    for one in given.named("history"):
        if one.HasAttribute("depth"):
            yield from _number("depth", one.Get(str, "depth"), one, 1)
    for name in TIMES:
        for one in given.named(name):
            yield from _number(name, one.Get(str), one, 1000)


def _number(name: str, text: str, one: Element, unit: int) -> Iterator[tuple[str, Any]]:
    try:
        value = int(text)
    except ValueError:
        value = -1
    if 0 <= value <= MOST_DEPTH * unit:
        yield name, value if unit == 1 else value / unit
    else:
        log.warning("%s: <%s> is %r; it must be a whole number", one.where, name, text)
