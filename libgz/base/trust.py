"""Trust: whether code that files name may run, in this process and those that it starts."""

from __future__ import annotations

import os

from libgz.base.errors import PluginError

__all__ = ["UNTRUSTED", "UntrustedError", "check_trusted", "distrust", "trusted"]

UNTRUSTED = "LIBGZ_UNTRUSTED"  # the environment variable that forbids it: child processes inherit it


class UntrustedError(PluginError):
    """A file names code that may not run, or has macros that may not be expanded."""


def trusted() -> bool:
    """Whether plugins may be loaded and macros expanded."""
    return not os.environ.get(UNTRUSTED)


def distrust() -> None:
    """Let this process, and those that it starts from now on, load no plugins and expand no macros."""
    os.environ[UNTRUSTED] = "1"


def check_trusted(what: str) -> None:
    """Refuse something that is allowed only for trusted files; `what` begins the message, such as ``plugin 'a.so'``.

    Raises:
        UntrustedError: files are not trusted.
    """
    if not trusted():
        raise UntrustedError(f"{what} is left out: files are untrusted (--untrusted, or the variable {UNTRUSTED})")
