"""Choice: which OpenGL renders, before anything of OpenGL is loaded."""

from __future__ import annotations

import os

from libgz.base.errors import ParameterError, nearest

__all__ = ["CHOICES", "check_choice", "chosen", "prefer", "preferred"]

CHOICES = ("auto", "osmesa", "egl", "none")

_preferred: str | None = None


def prefer(choice: str | None) -> None:
    """Choose the context of all scenes made from now on, above LIBGZ_GL: one of `CHOICES`; None: no preference.

    Raises:
        ParameterError: it is none of them.
    """
    global _preferred
    _preferred = None if choice is None else check_choice(choice, "the choice of OpenGL")


def preferred() -> str | None:
    """What `prefer` chose; None for no preference."""
    return _preferred


def chosen() -> str:
    """The choice of `prefer`, else the environment's LIBGZ_GL, else ``"auto"``.

    Raises:
        ParameterError: LIBGZ_GL is none of `CHOICES`.
    """
    return _preferred or check_choice(os.environ.get("LIBGZ_GL") or "auto", "LIBGZ_GL")


def check_choice(choice: str, what: str) -> str:
    """The choice, if it is one of `CHOICES`; `what` names it in the message.

    Raises:
        ParameterError: it is none of them.
    """
    if choice not in CHOICES:
        raise ParameterError(f"{what} is {choice!r}; allowed are {', '.join(CHOICES)}{nearest(choice, CHOICES)}")
    return choice
