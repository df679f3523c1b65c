"""Python: the command lines that run modules of libgz in processes of their own."""

from __future__ import annotations

import sys

__all__ = ["own_python", "run_module"]


def run_module(module: str, *words: str) -> list[str]:
    """The command that runs a module in another process, without the current directory on its import path.

    ``python -m`` would put that first: a folder with a file ``json.py`` in it would run the file.
    """
    return [sys.executable, "-P", "-m", module, *words]


def own_python() -> str:
    """The Python that runs libgz, to make an environment with; modules of libgz are run by `run_module`."""
    return sys.executable
