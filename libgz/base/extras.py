"""Extras: the packages that features need besides those of libgz, and the command that installs them."""

from __future__ import annotations

import re

__all__ = ["install"]


def install(extra: str) -> str:
    """The command that installs an extra's packages: ``pip install 'aiohttp<4,>=3.9'`` for ``view``.

    It names the packages and not the extra: that is right for a checkout, a wheel and an index.
    """
    import importlib.metadata  # for errors alone
    import shlex

    try:
        lines = importlib.metadata.requires("libgz") or []
    except importlib.metadata.PackageNotFoundError:
        lines = []
    marked = re.compile(rf"(?P<package>[^;]*);.*extra == ['\"]{re.escape(extra)}['\"]")
    packages = [found["package"].strip() for line in lines if (found := marked.match(line))]
    return f"pip install {shlex.join(packages)}" if packages else f"install libgz with its extra {extra!r}"
