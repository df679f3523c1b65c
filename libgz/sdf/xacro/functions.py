"""What expressions can call: functions by name, and methods of texts, lists and dictionaries by type.

Each takes the evaluator first, which calls back and counts. Nothing else of Python can be reached.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from libgz.sdf.xacro.limits import MOST_ITEMS, Budget, ExpansionError, LimitError, small
from libgz.sdf.xacro.operations import WIDEST, add, format_text, items_of, key_of, multiply, text_of

__all__ = ["BUILTINS", "Caller", "Function", "Namespace", "method_of"]

LARGEST_FACTORIAL = 1000


class Caller(Protocol):
    """What functions need of the evaluator."""

    budget: Budget

    def call(self, function: Any, *args: Any) -> Any:
        """Call a function of an expression."""


@dataclass(frozen=True, eq=False)
class Function:
    """Something that expressions can call; a type, if it stands for one."""

    name: str
    run: Callable[..., Any]
    kind: type | None = None

    def __repr__(self) -> str:
        return f"<class {self.name!r}>" if self.kind is not None else f"<function {self.name}>"


@dataclass(frozen=True, eq=False)
class Namespace:
    """Names under a common name, such as `math.pi`."""

    name: str
    members: Mapping[str, Any]

    def __repr__(self) -> str:
        return f"<namespace {self.name}>"


# Builtins ------------------------------------------------------------------------------------------------------------


def _dict(on: Caller, /, *args: Any, **named: Any) -> dict[Any, Any]:
    made: dict[Any, Any] = {}
    for given in args:
        _update(on, made, given)
    made.update(named)
    return made


def _sorted(on: Caller, values: Any, *, key: Any = None, reverse: Any = False) -> list[Any]:
    items = items_of(on.budget, values)
    ranks = items if key is None else [on.call(key, item) for item in items]
    on.budget.measure(ranks)
    return [items[i] for i in sorted(range(len(items)), key=ranks.__getitem__, reverse=bool(reverse))]


_NOTHING = object()


def _extreme(choose: Callable[..., Any]) -> Callable[..., Any]:
    def run(on: Caller, *values: Any, key: Any = None, default: Any = _NOTHING) -> Any:
        items = items_of(on.budget, values[0]) if len(values) == 1 else list(values)
        if not items and default is not _NOTHING:
            return default
        ranks = items if key is None else [on.call(key, item) for item in items]
        on.budget.measure(ranks)
        return items[choose(range(len(items)), key=ranks.__getitem__)]

    return run


def _sum(on: Caller, values: Any, start: Any = 0) -> Any:
    for item in items_of(on.budget, values):
        start = add(on.budget, start, item)
    return start


def _product(on: Caller, values: Any, *, start: Any = 1) -> Any:
    for item in items_of(on.budget, values):
        start = multiply(on.budget, start, item)
    return start


def _range(_: Caller, *bounds: Any) -> range:
    made = range(*bounds)
    if abs(small(made.stop)) > 2**62 or len(made) > MOST_ITEMS:
        raise LimitError(f"a range has more than {MOST_ITEMS} numbers")
    return made


def _round(_: Caller, number: Any, digits: Any = None) -> Any:
    if isinstance(digits, int) and abs(digits) > WIDEST:
        raise LimitError(f"round() to {digits} digits")
    return small(round(number, digits))


def _number(kind: Callable[..., Any]) -> Callable[..., Any]:
    def run(on: Caller, *args: Any, **named: Any) -> Any:
        if args and isinstance(args[0], str):
            on.budget.length(len(args[0]))
        return small(kind(*args, **named))

    return run


def _type(on: Caller, value: Any) -> Any:
    return TYPES.get(type(value)) or text_of(on.budget, type(value))


def _kinds(given: Any) -> tuple[type, ...]:
    kinds = tuple(one.kind for one in (given if isinstance(given, tuple) else (given,)) if isinstance(one, Function))
    if not kinds or None in kinds:
        raise ExpansionError("isinstance() needs types, such as float or (list, tuple)")
    return kinds  # type: ignore[return-value]


def _set(kind: type) -> Callable[..., Any]:
    return lambda on, values=(): kind(key_of(on.budget, item) for item in items_of(on.budget, values))


def _of_items(kind: Callable[[Iterable[Any]], Any]) -> Callable[..., Any]:
    return lambda on, values=(): kind(items_of(on.budget, values))


def _map(on: Caller, function: Any, *lists: Any) -> list[Any]:
    rows = [items_of(on.budget, values) for values in lists]
    return [on.call(function, *row) for row in zip(*rows, strict=False)]


def _filter(on: Caller, function: Any, values: Any) -> list[Any]:
    items = items_of(on.budget, values)
    return [item for item in items if (item if function is None else on.call(function, item))]


def _zip(on: Caller, *lists: Any) -> list[Any]:
    return list(zip(*(items_of(on.budget, values) for values in lists), strict=False))


def _enumerate(on: Caller, values: Any, start: Any = 0) -> list[Any]:
    return list(enumerate(items_of(on.budget, values), small(start)))


def _repr(on: Caller, value: Any) -> str:
    on.budget.measure(value)
    return repr(value)


_TYPES: dict[str, tuple[type, Callable[..., Any]]] = {
    "bool": (bool, lambda _, value=False: bool(value)),
    "complex": (complex, _number(complex)),
    "dict": (dict, _dict),
    "float": (float, _number(float)),
    "frozenset": (frozenset, _set(frozenset)),
    "int": (int, _number(int)),
    "list": (list, _of_items(list)),
    "range": (range, _range),
    "set": (set, _set(set)),
    "str": (str, lambda on, value="": text_of(on.budget, value)),
    "tuple": (tuple, _of_items(tuple)),
}
TYPES = {kind: Function(name, run, kind) for name, (kind, run) in _TYPES.items()}
_PYTHON: dict[str, Callable[..., Any]] = {
    "abs": lambda _, value: abs(value),
    "all": lambda on, values: all(items_of(on.budget, values)),
    "any": lambda on, values: any(items_of(on.budget, values)),
    "divmod": lambda _, a, b: divmod(a, b),
    "enumerate": _enumerate,
    "filter": _filter,
    "isinstance": lambda _, value, kinds: isinstance(value, _kinds(kinds)),
    "len": lambda _, value: len(value),
    "map": _map,
    "max": _extreme(max),
    "min": _extreme(min),
    "ord": lambda _, text: ord(text),
    "repr": _repr,
    "reversed": lambda on, values: items_of(on.budget, values)[::-1],
    "round": _round,
    "sorted": _sorted,
    "sum": _sum,
    "type": _type,
    "zip": _zip,
}


# Mathematics ---------------------------------------------------------------------------------------------------------

_OF_NUMBERS = (
    *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "copysign", "cos", "cosh"),
    *("degrees", "erf", "erfc", "exp", "exp2", "expm1", "fabs", "floor", "fmod", "frexp", "gamma", "gcd", "hypot"),
    *("isclose", "isfinite", "isinf", "isnan", "isqrt", "ldexp", "lgamma", "log", "log10", "log1p", "log2", "modf"),
    *("nextafter", "pow", "radians", "remainder", "sin", "sinh", "sqrt", "tan", "tanh", "trunc", "ulp"),
)
_COUNTING = ("comb", "factorial", "perm")


def _of_numbers(function: Callable[..., Any]) -> Callable[..., Any]:
    return lambda _, *args, **named: small(function(*args, **named))


def _counting(function: Callable[..., int]) -> Callable[..., int]:
    def run(_: Caller, *args: Any) -> int:
        if any(isinstance(arg, int) and arg > LARGEST_FACTORIAL for arg in args):
            raise LimitError(f"{function.__name__}() of a number above {LARGEST_FACTORIAL}")
        made: int = small(function(*args))
        return made

    return run


def _lcm(_: Caller, *numbers: Any) -> int:
    made = 1
    for number in numbers:
        made = small(math.lcm(made, number))
    return made


_MATH: dict[str, Callable[..., Any]] = {
    **{name: _of_numbers(getattr(math, name)) for name in _OF_NUMBERS},
    **{name: _counting(getattr(math, name)) for name in _COUNTING},
    "dist": lambda on, p, q: math.dist(items_of(on.budget, p), items_of(on.budget, q)),
    "fsum": lambda on, values: math.fsum(items_of(on.budget, values)),
    "lcm": _lcm,
    "prod": _product,
}
MATH = {
    **{name: Function(name, run) for name, run in _MATH.items()},
    **{name: getattr(math, name) for name in ("e", "inf", "nan", "pi", "tau")},
}

PYTHON = {
    **{function.name: function for function in TYPES.values()},
    **{name: Function(name, run) for name, run in _PYTHON.items()},
    "False": False,
    "True": True,
}
# Those that xacro has without a prefix.
_PLAIN = ("list", "dict", "map", "len", "str", "float", "int", "bool", "min", "max", "round", "sorted", "range")
BUILTINS: dict[str, Any] = {
    **MATH,
    **{name: PYTHON[name] for name in (*_PLAIN, "True", "False")},
    "python": Namespace("python", PYTHON),
    "math": Namespace("math", MATH),
}


# Methods -------------------------------------------------------------------------------------------------------------

_OF_TEXT = (
    *("capitalize", "casefold", "count", "endswith", "find", "index", "isalnum", "isalpha", "isascii", "isdecimal"),
    *("isdigit", "isidentifier", "islower", "isnumeric", "isprintable", "isspace", "istitle", "isupper", "lower"),
    *("lstrip", "partition", "removeprefix", "removesuffix", "rfind", "rindex", "rpartition", "rsplit", "rstrip"),
    *("split", "splitlines", "startswith", "strip", "swapcase", "title", "upper"),
)


def _of_text(function: Callable[..., Any]) -> Callable[..., Any]:
    """A method whose result is not much longer than the text."""

    def run(on: Caller, text: str, *args: Any, **named: Any) -> Any:
        on.budget.search(text, *args, *named.values())
        made = function(text, *args, **named)
        if isinstance(made, list):
            on.budget.items(len(made))
        return made

    return run


def _join(on: Caller, text: str, values: Any) -> str:
    items = items_of(on.budget, values)
    size = sum(len(item) for item in items if isinstance(item, str))
    on.budget.length(size + len(text) * len(items))
    return text.join(items)


def _replace(on: Caller, text: str, old: str, new: str, count: int = -1) -> str:
    on.budget.search(text, old)
    times = text.count(old) if count < 0 else min(text.count(old), count)
    on.budget.length(len(text) + times * max(len(new) - len(old), 0))
    return text.replace(old, new, count)


def _padded(function: Callable[..., str]) -> Callable[..., str]:
    def run(on: Caller, text: str, width: int, *fill: str) -> str:
        on.budget.length(max(len(text), width))
        return function(text, width, *fill)

    return run


def _expandtabs(on: Caller, text: str, tabsize: int = 8) -> str:
    on.budget.length(len(text) + text.count("\t") * max(tabsize, 0))
    return text.expandtabs(tabsize)


def _grow(on: Caller, values: list[Any] | dict[Any, Any] | set[Any], count: int = 1) -> None:
    """Check that a value can have more items."""
    on.budget.spend(count)
    if len(values) + count > MOST_ITEMS:
        raise LimitError(f"a value has more than {MOST_ITEMS} items")


def _append(on: Caller, values: list[Any], item: Any) -> None:
    _grow(on, values)
    values.append(item)


def _insert(on: Caller, values: list[Any], at: int, item: Any) -> None:
    _grow(on, values)
    values.insert(at, item)


def _extend(on: Caller, values: list[Any], more: Any) -> None:
    items = items_of(on.budget, more)
    _grow(on, values, len(items))
    values.extend(items)


def _sort(on: Caller, values: list[Any], *, key: Any = None, reverse: Any = False) -> None:
    values[:] = _sorted(on, values, key=key, reverse=reverse)


def _walked(function: Callable[..., Any]) -> Callable[..., Any]:
    """A method that walks through its values or compares them."""

    def run(on: Caller, *args: Any) -> Any:
        on.budget.measure(*args)
        return function(*args)

    return run


def _of_sets(function: Callable[..., Any]) -> Callable[..., Any]:
    """A method of a set and others, or lists of items."""

    def run(on: Caller, values: Any, *others: Any) -> Any:
        on.budget.measure(values)
        return function(values, *({key_of(on.budget, item) for item in items_of(on.budget, one)} for one in others))

    return run


def _keyed(function: Callable[..., Any]) -> Callable[..., Any]:
    def run(on: Caller, values: Any, key: Any, *rest: Any) -> Any:
        return function(values, key_of(on.budget, key), *rest)

    return run


def _setdefault(on: Caller, values: dict[Any, Any], key: Any, default: Any = None) -> Any:
    _grow(on, values)
    return values.setdefault(key_of(on.budget, key), default)


def _update(on: Caller, values: dict[Any, Any], given: Any = (), **named: Any) -> None:
    pairs = given.items() if isinstance(given, dict) else [items_of(on.budget, p) for p in items_of(on.budget, given)]
    _grow(on, values, len(pairs) + len(named))
    values.update({key_of(on.budget, key): value for key, value in pairs})
    values.update(named)


def _set_add(on: Caller, values: set[Any], item: Any) -> None:
    _grow(on, values)
    values.add(key_of(on.budget, item))


_SEQUENCE = {name: _walked(getattr(tuple, name)) for name in ("count", "index")}
_SETS = {
    name: _of_sets(getattr(frozenset, name))
    for name in (
        *("copy", "difference", "intersection", "isdisjoint", "issubset", "issuperset"),
        *("symmetric_difference", "union"),
    )
}
METHODS: dict[type, dict[str, Callable[..., Any]]] = {
    str: {
        **{name: _of_text(getattr(str, name)) for name in _OF_TEXT},
        "center": _padded(str.center),
        "expandtabs": _expandtabs,
        "format": lambda on, text, /, *args, **named: format_text(on.budget, text, args, named),
        "join": _join,
        "ljust": _padded(str.ljust),
        "replace": _replace,
        "rjust": _padded(str.rjust),
        "zfill": _padded(str.zfill),
    },
    list: {
        **{name: _walked(getattr(list, name)) for name in ("copy", "count", "index", "remove", "reverse")},
        "append": _append,
        "clear": lambda _, values: values.clear(),
        "extend": _extend,
        "insert": _insert,
        "pop": lambda _, values, at=-1: values.pop(at),
        "sort": _sort,
    },
    tuple: _SEQUENCE,
    dict: {
        "clear": lambda _, values: values.clear(),
        "copy": lambda on, values: dict(zip(items_of(on.budget, values), values.values(), strict=True)),
        "get": _keyed(dict.get),
        "items": lambda on, values: list(zip(items_of(on.budget, values), values.values(), strict=True)),
        "keys": lambda on, values: items_of(on.budget, values),
        "pop": _keyed(dict.pop),
        "popitem": lambda _, values: values.popitem(),
        "setdefault": _setdefault,
        "update": _update,
        "values": lambda on, values: list(items_of(on.budget, values) and values.values()),
    },
    set: {
        **{name: _of_sets(getattr(set, name)) for name in _SETS},
        "add": _set_add,
        "discard": _keyed(set.discard),
        "remove": _keyed(set.remove),
    },
    frozenset: _SETS,
    float: {"is_integer": lambda _, number: number.is_integer()},
}


def method_of(value: Any, name: str) -> Function | None:
    """The method of a value that expressions may call; None if there is none of the name."""
    run = METHODS.get(type(value), {}).get(name)
    if run is None:
        return None
    return Function(name, lambda on, /, *args, **named: run(on, value, *args, **named))
