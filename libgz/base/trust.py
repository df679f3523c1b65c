"""Trust: whether code that files name may run, in this process and those that it starts."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from contextvars import ContextVar

from libgz.base.errors import PluginError

__all__ = ["UNTRUSTED", "UntrustedError", "check_trusted", "distrust", "trusted", "without_trust"]

UNTRUSTED = "LIBGZ_UNTRUSTED"  # the environment variable that forbids it: child processes inherit it
_refused: ContextVar[list[UntrustedError] | None] = ContextVar("refused", default=None)  # in a block without trust


class UntrustedError(PluginError):
    """A file names code that may not run, or has macros that may not be expanded."""


def trusted() -> bool:
    """Whether plugins may be loaded and macros expanded."""
    return _refused.get() is None and not os.environ.get(UNTRUSTED)


def distrust() -> None:
    """Let this process, and those that it starts from now on, load no plugins and expand no macros."""
    os.environ[UNTRUSTED] = "1"


def check_trusted(what: str) -> None:
    """Refuse something that is allowed only for trusted files; `what` begins the message, such as ``plugin 'a.so'``.

    Raises:
        UntrustedError: files are not trusted.
    """
    if not trusted():
        error = UntrustedError(f"{what} is left out: files are untrusted (--untrusted, or the variable {UNTRUSTED})")
        if (refused := _refused.get()) is not None:
            refused.append(error)
        raise error


@contextlib.contextmanager
def without_trust() -> Iterator[None]:
    """For a `with` block that loads no plugins and expands no macros in this thread, whatever the process trusts.

    Raises:
        UntrustedError: something was to be loaded or expanded, and the block has ended without it.
    """
    refused: list[UntrustedError] = []
    before = _refused.set(refused)
    try:
        yield
    finally:
        _refused.reset(before)
    if refused:
        raise refused[0]
