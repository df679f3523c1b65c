"""What of the public API of Gazebo classic, the table in `libgz.classic.api`, libgz has."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from libgz.classic.api import ApiName, classic_api

__all__ = ["ApiName", "bases_of", "classic_api", "has", "public_names"]

MODULES = ("physics", "sensors", "rendering", "common", "event", "transport", "math", "gui")


def _module(holder: str) -> Any:
    name = holder.rpartition(".")[0]
    return importlib.import_module(f"libgz.classic.{name}" if name else "libgz.classic")


def _class_of(holder: str) -> Any:
    """The class of a holder, its module for functions and constants; None if there is none."""
    name = holder.rpartition(".")[2]
    return _module(holder) if name.startswith("(") else getattr(_module(holder), name, None)


def has(holder: str, name: str) -> bool:
    """Whether libgz has a name of the table."""
    kind = _class_of(holder)
    if kind is None:
        return False
    return name in _fields(kind) or hasattr(kind, name)


def _fields(kind: Any) -> set[str]:
    """Attributes of objects of a class that the class itself has not."""
    found = {field.name for field in fields(kind)} if is_dataclass(kind) else set()
    return found | set(getattr(kind, "_COLUMNS", ()))


def bases_of(holder: str) -> list[str]:
    """The holders whose names a class has, too: those of its base classes."""
    kind, module = _class_of(holder), holder.rpartition(".")[0]
    return [f"{module}.{base.__name__}" for base in getattr(kind, "__mro__", ())[1:]]


def public_names() -> dict[str, list[str]]:
    """Holder -> the names in CapWords that a public class of libgz.classic defines itself."""
    found: dict[str, list[str]] = {}
    for module in MODULES:
        package = importlib.import_module(f"libgz.classic.{module}")
        for word in package.__all__:
            kind = getattr(package, word)
            if inspect.isclass(kind) and kind.__module__.startswith("libgz.classic") and kind.__name__ == word:
                found[f"{module}.{word}"] = sorted(set(_own_names(kind)))
    return found


def _own_names(kind: type) -> Iterator[str]:
    """Names of methods of a class, and of its bases that are no public classes."""
    package = importlib.import_module(".".join(kind.__module__.split(".")[:3]))
    for base in kind.__mro__:
        inside = base.__module__.startswith("libgz.classic")
        if base is kind or (inside and base.__name__ not in getattr(package, "__all__", ())):
            yield from (name for name, thing in vars(base).items() if name[0].isupper() and _is_method(thing))


def _is_method(thing: object) -> bool:
    return isinstance(thing, classmethod | staticmethod | property) or (callable(thing) and not inspect.isclass(thing))
