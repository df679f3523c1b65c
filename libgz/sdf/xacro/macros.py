"""Macros: their parameters with defaults, and where they are found by name."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

from lxml import etree

from libgz.sdf.xacro.limits import Budget
from libgz.sdf.xacro.scopes import Scope

__all__ = ["Macro", "MacroTable", "Parameter", "parameters_of"]

# NAME, := or =, ^ or ^|, a default: an expression, a substitution, or words and quoted texts without spaces between.
_WITH_DEFAULT = re.compile(
    r"""\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?(\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|"[^"]*"|[^\s'"])*)(?:\s+|$)"""
)
_PLAIN = re.compile(r"\s*(\S+)\s*")


@dataclass(frozen=True)
class Parameter:
    """A parameter of a macro; `*name` and `**name` are blocks."""

    name: str
    forwards: bool = False  # the default is the property of its name where the macro is called
    default: str | None = None

    @property
    def is_block(self) -> bool:
        """Whether it is an element of the call."""
        return self.name.startswith("*")

    @property
    def is_optional(self) -> bool:
        """Whether it has a default."""
        return self.forwards or self.default is not None


@dataclass(frozen=True, eq=False)
class Macro:
    """A macro: its element, whose children are its body."""

    name: str
    body: etree._Element
    parameters: tuple[Parameter, ...]


def parameters_of(text: str, budget: Budget) -> tuple[Parameter, ...]:
    """The parameters that `params` names.

    Raises:
        LimitError: they are too long: what follows a parameter is searched for the end of its default.
    """
    found: dict[str, Parameter] = {}
    at = 0
    while at < len(text):
        budget.length(len(text) - at)
        match = _WITH_DEFAULT.match(text, at)
        if match is not None:
            parameter = Parameter(match[1], bool(match[2]), match[3] or None)
        else:
            match = _PLAIN.match(text, at)
            if match is None:
                break
            parameter = Parameter(match[1])
        found[parameter.name] = parameter
        at = match.end()
    return tuple(found.values())


@dataclass
class MacroTable:
    """Macros by name, over those of the scopes around, and the tables of files that are included with `ns`."""

    around: MacroTable | None = None
    macros: dict[str, Macro] = field(default_factory=dict)
    namespaces: dict[str, MacroTable] = field(default_factory=dict)

    def find(self, name: str, scope: Scope) -> tuple[Macro, MacroTable, Scope]:
        """The macro of a name, which may begin with namespaces, and the macros and properties around it.

        Raises:
            KeyError: there is none.
        """
        *namespaces, last = name.split(".")
        table: MacroTable = self
        for one in namespaces:
            table = table._lookup("namespaces", one)
            inner = scope[one]
            if not isinstance(inner, Scope):
                raise KeyError(one)
            scope = inner
        return table._lookup("macros", last), table, scope

    def names(self) -> set[str]:
        """Those of the macros here and around."""
        return {*self.macros, *(self.around.names() if self.around is not None else ())}

    def _lookup(self, kind: str, name: str) -> Any:
        table: MacroTable | None = self
        while table is not None:
            found = getattr(table, kind).get(name)
            if found is not None:
                return found
            table = table.around
        raise KeyError(name)
