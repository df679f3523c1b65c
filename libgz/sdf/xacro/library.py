"""What expressions have beyond Python's: `xacro.load_yaml`, `xacro.arg`, messages and others."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from libgz.sdf.xacro.expressions import Evaluator
from libgz.sdf.xacro.files import Files
from libgz.sdf.xacro.functions import BUILTINS, Function, Namespace
from libgz.sdf.xacro.limits import LARGEST_YAML, ExpansionError
from libgz.sdf.xacro.operations import text_of
from libgz.sdf.xacro.scopes import Scope
from libgz.sdf.xacro.substitutions import Substitutions

__all__ = ["Library"]

log = logging.getLogger("libgz")


class Expansion(Protocol):
    """What the functions need of the expansion that they are called in."""

    evaluator: Evaluator
    files: Files
    folders: list[Path | None]
    substitutions: Substitutions

    def warn(self, message: str) -> None:
        """Warn at the element that is being expanded."""


class Library:
    """The functions of xacro for one expansion; `names` are all that its expressions begin with."""

    def __init__(self, expansion: Expansion) -> None:
        self.expansion = expansion
        self.budget = expansion.evaluator.budget
        self._trees: dict[Path, Any] = {}
        own: dict[str, Callable[..., Any]] = {
            "abs_filename": lambda _, name: str(self._path(name)),
            "arg": lambda _, name: expansion.substitutions.argument(name),
            "dotify": lambda _, value: value,  # all dictionaries have their items as attributes
            "error": self._warn,
            "fatal": self._fail,
            "load_yaml": lambda _, name: self._load_yaml(name),
            "message": self._log,
            "print_location": lambda *_, **__: "",  # all messages have their places
            "tokenize": self._tokenize,
            "warning": self._warn,
        }
        functions = {name: Function(name, run) for name, run in own.items()}
        plain = {name: functions[name] for name in ("abs_filename", "dotify", "load_yaml")}
        self.names = {**BUILTINS, **plain, "xacro": Namespace("xacro", functions)}

    def _path(self, name: Any) -> Path:
        return self.expansion.files.path(text_of(self.budget, name), self.expansion.folders[-1])

    def _load_yaml(self, name: Any) -> Any:
        from libgz.sdf.xacro.documents import parsed_yaml, value_of_yaml  # only then is PyYAML loaded

        path = self._path(name)
        try:
            if path not in self._trees:
                data = self.expansion.files.read(path, LARGEST_YAML)
                self._trees[path] = parsed_yaml(data, self.budget)
            return value_of_yaml(self._trees[path], self.budget, self._number)
        except ExpansionError as error:
            text = str(error)
            raise type(error)(text if str(path) in text else f"{path}: {text}") from None

    def _number(self, expression: str) -> Any:
        return self.expansion.evaluator.evaluate(expression, Scope(self.names, lambda text, _: text))

    def _message(self, values: tuple[Any, ...]) -> str:
        return " ".join(text_of(self.budget, value) for value in values)[:1000]

    def _warn(self, _: Any, *values: Any, **__: Any) -> str:
        self.expansion.warn(self._message(values))
        return ""

    def _log(self, _: Any, *values: Any, **__: Any) -> str:
        log.info("%s", self._message(values))
        return ""

    def _fail(self, _: Any, *values: Any) -> str:
        raise ExpansionError(self._message(values))

    def _tokenize(self, _: Any, text: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
        self.budget.length(len(text))
        # Separators are the inside of [...] in a regular expression, which they must not leave.
        try:
            if "]" in sep or len(sep) >= 100:
                raise re.error("no inside of brackets")
            with warnings.catch_warnings():
                warnings.simplefilter("error", FutureWarning)  # of what a later Python reads as sets in sets
                separator = re.compile(f"[{sep}]")
        except (re.error, FutureWarning):
            separator = re.compile(f"[{re.escape(sep[:100])}]" if sep else r"(?!)")
        parts = separator.split(text)
        self.budget.items(len(parts))
        return [part for part in parts if part] if skip_empty else parts
