"""Substitutions: `$(arg NAME)`, `$(find PACKAGE)`, `$(env NAME)` and their like."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from libgz.sdf.xacro.expressions import Evaluator
from libgz.sdf.xacro.files import Files
from libgz.sdf.xacro.functions import PYTHON
from libgz.sdf.xacro.limits import ExpansionError
from libgz.sdf.xacro.operations import text_of

__all__ = ["Substitutions"]

CONSTANTS = {name: getattr(math, name) for name in ("e", "inf", "nan", "pi", "tau")}
FUNCTIONS = {name: PYTHON[name] for name in ("list", "dict", "map", "str", "float", "int")}


class Substitutions:
    """Gives the texts of substitutions.

    Args:
        files: finds packages.
        evaluator: of `$(eval EXPRESSION)`.
        arguments: the values of the document's arguments by name.
        environment: the variables that `env` and `optenv` know.
        folder: gives the folder of the file that is being expanded; None for a text.
    """

    def __init__(
        self,
        files: Files,
        evaluator: Evaluator,
        arguments: dict[str, str],
        environment: Mapping[str, str],
        folder: Callable[[], Path | None],
    ) -> None:
        self.files, self.evaluator, self.folder = files, evaluator, folder
        self.arguments, self.environment = arguments, environment

    def text(self, inside: str) -> str:
        """The text that replaces `$(inside)`.

        Raises:
            ExpansionError: it is not known, or has wrong words.
        """
        if not inside:
            return "$()"
        if inside.startswith("eval "):
            return self._eval(inside.removeprefix("eval "))
        command, *words = inside.split(" ")
        words = [word for word in words if word]
        known: dict[str, tuple[int, int, Callable[..., str]]] = {
            "anon": (1, 1, self._anon),
            "arg": (1, 1, self.argument),
            "cwd": (0, 0, self._cwd),
            "dirname": (0, 0, self._dirname),
            "env": (1, 1, self._env),
            "find": (1, 1, lambda name: str(self.files.package(name))),
            "optenv": (1, len(words), lambda name, *default: self.environment.get(name, " ".join(default))),
        }
        if command not in known:
            raise ExpansionError(f"unknown substitution $({inside[:80]}); {', '.join(known)} and eval are known")
        least, most, run = known[command]
        if not least <= len(words) <= most:
            raise ExpansionError(f"$({inside[:80]}): {command} needs {least} word{'' if least == 1 else 's'}")
        return run(*words)

    def argument(self, name: str) -> str:
        """The value of an argument."""
        if name not in self.arguments:
            raise ExpansionError(f"there is no argument {name!r}; <xacro:arg name='{name}' default='...'/> defines it")
        return self.arguments[name]

    def _anon(self, name: str) -> str:
        return f"{name}_anonymous"

    def _cwd(self) -> str:
        try:
            return str(Path.cwd())
        except OSError as error:
            raise ExpansionError(f"$(cwd): {error.strerror}") from None

    def _dirname(self) -> str:
        folder = self.folder()
        if folder is None:
            raise ExpansionError("$(dirname): the description is a text without a folder")
        return str(folder)

    def _env(self, name: str) -> str:
        if name not in self.environment:
            raise ExpansionError(f"the environment variable {name!r} is not set")
        return self.environment[name]

    def _eval(self, expression: str) -> str:
        if "__" in expression:
            raise ExpansionError("$(eval ...) may not contain double underscores")
        return text_of(self.evaluator.budget, self.evaluator.evaluate(expression, _Arguments(self.arguments)))


class _Arguments:
    """The names of `$(eval ...)`: constants and functions, then arguments as the values that they stand for."""

    def __init__(self, arguments: Mapping[str, str]) -> None:
        self.arguments = arguments
        self.known: dict[str, Any] = {**CONSTANTS, **FUNCTIONS, "true": True, "false": False}

    def __contains__(self, name: object) -> bool:
        return name in self.known or name in self.arguments

    def __getitem__(self, name: str) -> Any:
        return self.known[name] if name in self.known else _converted(self.arguments[name])


def _converted(text: str) -> Any:
    """The number or truth value that an argument stands for, or itself."""
    try:
        return float(text) if "." in text else int(text)
    except ValueError:
        return {"true": True, "false": False}.get(text.lower(), text)
