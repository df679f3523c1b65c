"""Operators and formatting of expressions. What could grow is measured before it is made."""

from __future__ import annotations

import ast
import operator
import re
import string
from collections.abc import Callable, Mapping, Set
from typing import Any

from libgz.sdf.xacro.limits import MOST_BITS, Budget, ExpansionError, LimitError, small

__all__ = ["BINARY", "COMPARISONS", "UNARY", "add", "format_text", "items_of", "key_of", "multiply", "text_of"]

MOST_SHIFT = MOST_BITS
WIDEST = 1000  # fields and precisions of formats
NUMBERS = (int, float, complex)
SEQUENCES = (str, list, tuple)
CONTAINERS = (str, list, tuple, Mapping, Set, range)

DISTINCT = 2**60  # smaller integers have hashes of their own
_PERCENT = re.compile(r"%(?:\(\w*\))?[#0\- +]*([1-9]\d*)?(?:\.(\d*))?[hlL]?[a-zA-Z%]")
_SPEC = re.compile(r"(?:[^{}]?[<>=^])?[-+ ]?z?#?0?(\d*)[,_]?(?:\.(\d+))?[a-zA-Z%]?")


def text_of(budget: Budget, value: Any) -> str:
    """A value as `str` prints it."""
    if isinstance(value, str):
        return value
    if isinstance(value, CONTAINERS):
        budget.measure(value)
    text = str(value)
    budget.length(len(text))
    return text


def items_of(budget: Budget, value: Any) -> list[Any]:
    """What iterating over a value gives."""
    if not isinstance(value, CONTAINERS):
        raise ExpansionError(f"{type(value).__name__!r} cannot be iterated over")
    budget.items(len(value))
    if isinstance(value, Set):  # Python's order of texts differs from process to process
        budget.measure(value)
        return sorted(value, key=repr)
    return list(value)


def key_of(budget: Budget, value: Any) -> Any:
    """The same value, which can be hashed."""
    if isinstance(value, tuple | frozenset):
        budget.measure(value)
    hash(value)
    if isinstance(value, tuple | frozenset | complex) or (isinstance(value, int) and abs(value) >= DISTINCT):
        budget.key(value)
    return value


def add(budget: Budget, a: Any, b: Any) -> Any:
    """`a + b`."""
    if isinstance(a, str) and isinstance(b, str):
        budget.length(len(a) + len(b))
    elif isinstance(a, SEQUENCES) and isinstance(b, SEQUENCES):
        budget.items(len(a) + len(b))
    return small(a + b)


def multiply(budget: Budget, a: Any, b: Any) -> Any:
    """`a * b`; of a text or list and a number, too."""
    if isinstance(a, int) and isinstance(b, SEQUENCES):
        a, b = b, a
    if isinstance(a, SEQUENCES) and isinstance(b, int):
        size = len(a) * max(b, 0)
        (budget.length if isinstance(a, str) else budget.items)(size)
    return small(a * b)


def _power(_: Budget, a: Any, b: Any) -> Any:
    if isinstance(a, int) and isinstance(b, int) and abs(a) > 1 and a.bit_length() * b > 2 * MOST_BITS:
        raise LimitError(f"{a} ** {b} has more than {MOST_BITS} bits")
    return small(a**b)


def _shift_left(_: Budget, a: Any, b: Any) -> Any:
    if isinstance(b, int) and b > MOST_SHIFT:
        raise LimitError(f"a shift by {b} is too far")
    return small(a << b)


def _remainder(budget: Budget, a: Any, b: Any) -> Any:
    return _percent(budget, a, b) if isinstance(a, str) else small(a % b)


def _percent(budget: Budget, text: str, values: Any) -> str:
    """`text % values`, where widths are numbers of a reasonable size."""
    budget.length(len(text))
    if "%" in _PERCENT.sub("", text):
        raise ExpansionError(f"the format {text[:80]!r} is not supported")
    fields = [(match[1] or "", match[2] or "") for match in _PERCENT.finditer(text)]
    size = sum(_width(width) + _width(precision) for width, precision in fields)
    budget.length(len(text) + size + budget.measure(values) * (len(fields) if isinstance(values, Mapping) else 1))
    made = text % (values if isinstance(values, tuple | Mapping) else (values,))
    budget.length(len(made))
    return made


def format_text(budget: Budget, text: str, values: tuple[Any, ...], named: dict[str, Any]) -> str:
    """`text.format(...)`, whose fields are numbers or names alone."""
    budget.length(len(text))
    made, used, counter = [], 0, 0
    for literal, field, spec, conversion in string.Formatter().parse(text):
        made.append(literal)
        used += len(literal)
        if field is None:
            continue
        spec = spec or ""
        layout = _SPEC.fullmatch(spec)
        if not re.fullmatch(r"\d{0,6}|[^\W\d]\w*", field) or layout is None or conversion not in (None, "s", "r"):
            raise ExpansionError(f"the format {text[:80]!r} is not supported")
        used += _width(layout[1]) + _width(layout[2] or "")
        if not field:
            field, counter = str(counter), counter + 1
        value = values[int(field)] if field.isdigit() else named[field]
        if conversion is not None or isinstance(value, CONTAINERS) or not isinstance(value, NUMBERS):
            budget.measure(value)
            value = repr(value) if conversion == "r" else text_of(budget, value)
        made.append(format(value, spec))
        used += len(made[-1])
        budget.length(used)
    return "".join(made)


def _width(digits: str) -> int:
    if len(digits) > 4 or int(digits or 0) > WIDEST:
        raise LimitError(f"a width or precision is more than {WIDEST}")
    return int(digits or 0)


def _plain(function: Callable[[Any, Any], Any]) -> Callable[[Budget, Any, Any], Any]:
    """An operator of numbers, whose results are of about their size, and of sets."""

    def apply(budget: Budget, a: Any, b: Any) -> Any:
        if not (isinstance(a, NUMBERS) and isinstance(b, NUMBERS)):
            budget.measure(a, b)
        return small(function(a, b))

    return apply


def _contains(budget: Budget, a: Any, b: Any) -> bool:
    if isinstance(b, Mapping | Set):
        return key_of(budget, a) in b
    if isinstance(b, range):
        budget.spend(len(b))
    elif isinstance(b, CONTAINERS):
        budget.measure(a, b)
        if isinstance(b, str):
            budget.search(b, a)
    else:
        raise ExpansionError(f"{type(b).__name__!r} contains nothing")
    return a in b


def _comparison(function: Callable[[Any, Any], Any]) -> Callable[[Budget, Any, Any], bool]:
    def compare(budget: Budget, a: Any, b: Any) -> bool:
        if isinstance(a, CONTAINERS) and isinstance(b, CONTAINERS):
            budget.measure(a, b)
        return bool(function(a, b))

    return compare


BINARY: dict[type[ast.operator], Callable[[Budget, Any, Any], Any]] = {
    ast.Add: add,
    ast.Sub: _plain(operator.sub),
    ast.Mult: multiply,
    ast.Div: _plain(operator.truediv),
    ast.FloorDiv: _plain(operator.floordiv),
    ast.Mod: _remainder,
    ast.Pow: _power,
    ast.LShift: _shift_left,
    ast.RShift: _plain(operator.rshift),
    ast.BitAnd: _plain(operator.and_),
    ast.BitOr: _plain(operator.or_),
    ast.BitXor: _plain(operator.xor),
}
UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
    ast.Invert: operator.invert,
}
COMPARISONS: dict[type[ast.cmpop], Callable[[Budget, Any, Any], bool]] = {
    ast.Eq: _comparison(operator.eq),
    ast.NotEq: _comparison(operator.ne),
    ast.Lt: _comparison(operator.lt),
    ast.LtE: _comparison(operator.le),
    ast.Gt: _comparison(operator.gt),
    ast.GtE: _comparison(operator.ge),
    ast.In: _contains,
    ast.NotIn: lambda budget, a, b: not _contains(budget, a, b),
    ast.Is: lambda _, a, b: a is b,
    ast.IsNot: lambda _, a, b: a is not b,
}
