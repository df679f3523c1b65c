"""YAML documents as values: scalars, lists and dictionaries, with units such as `!degrees 90`."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import yaml  # type: ignore[import-untyped, unused-ignore]
from yaml.constructor import SafeConstructor  # type: ignore[import-untyped, unused-ignore]

from libgz.sdf.xacro.limits import Budget, ExpansionError, LimitError, small
from libgz.sdf.xacro.operations import key_of

__all__ = ["parsed_yaml", "value_of_yaml"]

UNITS = {
    "!radians": 1.0,
    "!degrees": math.pi / 180.0,
    "!meters": 1.0,
    "!millimeters": 0.001,
    "!foot": 0.3048,
    "!inches": 0.0254,
}
PREFIX = "tag:yaml.org,2002:"
WORK_OF_BYTE = 1  # of YAML, whose reading is slow
LONGEST_NUMBER = 400  # characters
MERGE = f"{PREFIX}merge"


def parsed_yaml(data: bytes, budget: Budget) -> yaml.Node | None:
    """The tree of a document; None if it is empty.

    Raises:
        ExpansionError: it is not valid.
        LimitError: it is too large, or nested too deeply.
    """
    budget.spend(WORK_OF_BYTE * len(data))
    try:
        tree: yaml.Node | None = yaml.compose(data, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark is not None else ""
        raise ExpansionError(f"{where}{getattr(error, 'problem', None) or str(error)[:200]}") from None
    except RecursionError:
        raise LimitError("it is nested too deeply") from None
    except ValueError as error:  # of its encoding
        raise ExpansionError(str(error)[:200]) from None
    return tree


def value_of_yaml(tree: yaml.Node | None, budget: Budget, number: Callable[[str], Any]) -> Any:
    """The value of a document's tree, made anew.

    Args:
        tree: of the document.
        budget: counts its values, those of aliases once.
        number: evaluates the expression of a scalar with a unit.

    Raises:
        ExpansionError: a tag is not known, or a scalar is not what its tag says.
        LimitError: there are too many values, or they are nested too deeply.
    """
    try:
        return None if tree is None else _Values(budget, number).value(tree)
    except RecursionError:
        raise LimitError("it is nested too deeply") from None
    except (TypeError, ValueError) as error:
        raise ExpansionError(str(error)[:200]) from None


class _Values:
    """Makes values of nodes; that of an alias is the same as of its anchor."""

    def __init__(self, budget: Budget, number: Callable[[str], Any]) -> None:
        self.budget, self.number = budget, number
        self.made: dict[yaml.Node, Any] = {}
        self.scalars = SafeConstructor()

    def value(self, node: yaml.Node) -> Any:
        if node in self.made:
            return self.made[node]
        self.budget.spend(1)
        if isinstance(node, yaml.ScalarNode):
            made = self.made[node] = self._scalar(node)
            return made
        if isinstance(node, yaml.SequenceNode) and node.tag == f"{PREFIX}seq":
            items: list[Any] = []
            self.made[node] = items
            items.extend(self.value(item) for item in node.value)
            return items
        if isinstance(node, yaml.MappingNode) and node.tag == f"{PREFIX}map":
            mapping: dict[Any, Any] = {}
            self.made[node] = mapping
            self._fill(mapping, node)
            return mapping
        raise ExpansionError(f"line {node.start_mark.line + 1}: the tag {node.tag!r} is not known")

    def _fill(self, mapping: dict[Any, Any], node: yaml.MappingNode) -> None:
        for key, value in node.value:
            if key.tag == MERGE:
                for one in value.value if isinstance(value, yaml.SequenceNode) else [value]:
                    merged = self.value(one)
                    if not isinstance(merged, dict):
                        raise ExpansionError(f"line {key.start_mark.line + 1}: only dictionaries can be merged")
                    self.budget.items(len(merged) + len(mapping))
                    for known, inside in merged.items():
                        mapping.setdefault(known, inside)
        for key, value in node.value:
            if key.tag != MERGE:
                try:
                    name = key_of(self.budget, self.value(key))
                except TypeError:
                    raise ExpansionError(f"line {key.start_mark.line + 1}: this cannot be a key") from None
                mapping[name] = self.value(value)

    def _scalar(self, node: yaml.ScalarNode) -> Any:
        if node.tag in UNITS:
            return float(self.number(node.value)) * UNITS[node.tag]
        kind = node.tag.removeprefix(PREFIX)
        if kind in ("str", "timestamp", "value"):
            return node.value
        if kind in ("int", "float") and len(node.value) > LONGEST_NUMBER:
            raise LimitError(f"line {node.start_mark.line + 1}: a number has more than {LONGEST_NUMBER} characters")
        construct = {
            "int": self.scalars.construct_yaml_int,
            "float": self.scalars.construct_yaml_float,
            "bool": self.scalars.construct_yaml_bool,
            "null": self.scalars.construct_yaml_null,
        }.get(kind)
        if construct is None:
            raise ExpansionError(f"line {node.start_mark.line + 1}: the tag {node.tag!r} is not known")
        return small(construct(node))
