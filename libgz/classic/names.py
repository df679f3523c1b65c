"""`takes_names`: classes whose methods say which name they want when they are given an object instead.

C++ refuses `GetLink(link)` when it is compiled; here it would find nothing, or end in an AttributeError far below.
"""

from __future__ import annotations

import functools
import inspect
import re
import sys
from types import FunctionType
from typing import Any, TypeVar

from libgz.base.errors import ParameterError

__all__ = ["takes_names"]

T = TypeVar("T")

_SIMPLE = re.compile(r"[\w. |]+")  # no mapping or sequence: its items are checked where they are used
_FILE = re.compile(r"file|path", re.IGNORECASE)  # these may be paths


def takes_names(owner: T) -> T:
    """Decorate a class or a function: a parameter annotated `str` accepts nothing else, nor does `int | str`.

    Methods with capitals, those of classic's API, are checked. They raise ParameterError.
    """
    if not isinstance(owner, type):
        wrapped: Any = _checked(owner, getattr(owner, "__name__", ""))
        return wrapped  # type: ignore[no-any-return]
    made: dict[FunctionType, Any] = {}  # old names of a method stay that method
    for name, method in list(vars(owner).items()):
        if isinstance(method, FunctionType) and not name.startswith("_") and not name.islower():
            if method not in made:
                made[method] = _checked(method, f"{owner.__name__}.{method.__name__}")
            setattr(owner, name, made[method])
    return owner


def _checked(function: Any, title: str) -> Any:
    """The function with a check of its names; itself if it takes none."""
    notes = getattr(function, "__annotations__", {})
    if not any("str" in str(note) for name, note in notes.items() if name != "return"):
        return function  # most of them
    code = inspect.unwrap(function).__code__
    positional, named = code.co_argcount, code.co_argcount + code.co_kwonlyargcount
    places = {name: place for place, name in enumerate(code.co_varnames[:positional])}
    if code.co_flags & inspect.CO_VARARGS:
        places[code.co_varnames[named]] = positional  # of which the first is checked
    wanted: list[tuple[int, str, tuple[str, ...]]] = []
    for name in (*places, *code.co_varnames[positional:named]):
        note = str(notes.get(name, ""))
        kinds = tuple(note.split(" | "))
        if "str" in kinds and _SIMPLE.fullmatch(note) and not _FILE.search(name):
            wanted.append((places.get(name, sys.maxsize), name, kinds))
    if not wanted:
        return function

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        for place, name, kinds in wanted:
            if place < len(args):
                value = args[place]
            elif name in kwargs:
                value = kwargs[name]
            else:
                continue
            if value.__class__ is not str and not _is_one_of(value, kinds):
                raise ParameterError(_message(title, name, kinds, value))
        return function(*args, **kwargs)

    return call


def _is_one_of(value: object, kinds: tuple[str, ...]) -> bool:
    if value is None:
        return "None" in kinds
    if "int" in kinds and hasattr(value, "__index__"):  # numpy's, too
        return True
    return any(kind.__name__ in kinds for kind in type(value).__mro__)


def _message(title: str, name: str, kinds: tuple[str, ...], value: object) -> str:
    ordered = sorted(kinds, key=lambda kind: kind != "str")
    allowed = " or ".join("a string" if kind == "str" else _a(kind) for kind in ordered)
    own = next((get for get in ("GetName", "Name") if callable(getattr(value, get, None))), None)
    hint = f"; its name is {getattr(value, own)()!r}" if own else ""
    return f"{title}: {name} must be {allowed}, not {_a('None' if value is None else type(value).__name__)}{hint}"


def _a(kind: str) -> str:
    return kind if kind == "None" else f"{'an' if kind[0] in 'aeioAEIO' else 'a'} {kind}"
