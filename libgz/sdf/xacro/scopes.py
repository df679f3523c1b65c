"""Scopes of properties: those of a document, of a macro's call, and of a file that is included with `ns`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from libgz.sdf.xacro.limits import ExpansionError

__all__ = ["Scope", "literal", "truth"]


def truth(value: Any, condition: str) -> bool:
    """The value of a condition: of a text `true`, `false` or an integer.

    Raises:
        ExpansionError: it is another text.
    """
    if not isinstance(value, str):
        return bool(value)
    if value in ("true", "True", "false", "False"):
        return value in ("true", "True")
    try:
        return bool(int(value))
    except ValueError:
        raise ExpansionError(
            f"the condition {condition[:80]!r} is {value[:80]!r}; it must be true, false or an integer"
        ) from None


def literal(value: Any) -> Any:
    """A text as the number or truth value that it stands for; without its single quotes, if it has some."""
    if not isinstance(value, str):
        return value
    if len(value) >= 2 and value[0] == value[-1] == "'":
        return value[1:-1]
    if "_" in value:  # Python's numbers may have underscores; those of xacro do not
        return value
    for read in (int, float):
        try:
            return read(value)
        except ValueError:
            pass
    try:
        return truth(value, "")
    except ExpansionError:
        return value


class Scope:
    """Properties by name, over those of the scopes around it and the builtins.

    Args:
        around: the enclosing scope; the builtins, for that of a document.
        evaluate: gives the value of a property's text, in the scope that has the property.
        is_namespace: whether it is that of a file that is included with `ns`.
    """

    def __init__(
        self, around: Scope | Mapping[str, Any], evaluate: Callable[[str, Scope], Any], *, is_namespace: bool = False
    ) -> None:
        self.around, self.is_namespace = around, is_namespace
        self._evaluate = evaluate
        self._values: dict[str, Any] = {}
        self._lazy: dict[str, bool] = {}  # properties that are not evaluated yet -> whether they are just now

    def __repr__(self) -> str:
        return "<namespace>" if self.is_namespace else "<scope>"

    def __getitem__(self, name: str) -> Any:
        for scope in self._chain():
            if name in scope._values:
                return scope._resolved(name)
        return self._builtins()[name]

    def __contains__(self, name: object) -> bool:
        return any(name in scope._values for scope in self._chain()) or name in self._builtins()

    def inner(self, *, is_namespace: bool = False) -> Scope:
        """A scope inside this one."""
        return Scope(self, self._evaluate, is_namespace=is_namespace)

    def set(self, name: str, value: Any, *, lazy: bool = False) -> None:
        """Define a property; a lazy text is evaluated when it is first used."""
        value = literal(value)
        self._values[name] = value
        self._lazy.pop(name, None)
        if lazy and isinstance(value, str):
            self._lazy[name] = False

    def remove(self, name: str) -> None:
        """Remove a property here and in all scopes around."""
        for scope in self._chain():
            scope._values.pop(name, None)
            scope._lazy.pop(name, None)

    def is_builtin(self, name: str) -> bool:
        """Whether a name is one of the builtins."""
        return name in self._builtins()

    def top(self) -> Scope:
        """The scope of the document."""
        return list(self._chain())[-1]

    def caller(self) -> Scope | None:
        """The scope for which a macro or included file sets `scope="parent"`; None for the document's own."""
        around = self.around
        if not self.is_namespace:
            while isinstance(around, Scope) and around.is_namespace:
                around = around.around
        return around if isinstance(around, Scope) else None

    def _chain(self) -> Iterator[Scope]:
        scope: Scope | Mapping[str, Any] = self
        while isinstance(scope, Scope):
            yield scope
            scope = scope.around

    def _builtins(self) -> Mapping[str, Any]:
        around = self.top().around
        return around if isinstance(around, Mapping) else {}

    def _resolved(self, name: str) -> Any:
        if name in self._lazy:
            if self._lazy[name]:
                chain = " -> ".join([*(known for known, busy in self._lazy.items() if busy), name])
                raise ExpansionError(f"circular definition of properties: {chain}; lazy_eval='false' may help")
            self._lazy[name] = True
            try:
                value = literal(self._evaluate(self._values[name], self))
            except BaseException:
                self._lazy[name] = False
                raise
            self._values[name] = value
            self._lazy.pop(name, None)
        return self._values[name]
