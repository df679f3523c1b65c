"""Python: how modules of libgz are run in processes of their own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

__all__ = ["environment", "own_python", "run_module", "start_module"]


def start_module(
    module: str, *words: str, changes: Mapping[str, str] | None = None, **options: Any
) -> subprocess.Popen[Any]:
    """Run a module in another process, which imports nothing from the current directory.

    Args:
        module: its name.
        words: its arguments.
        changes: variables beside those of this process, or in place of them.
        options: of `subprocess.Popen`.

    Raises:
        OSError: it cannot be started.
    """
    return subprocess.Popen(run_module(module, *words), env={**environment(), **(changes or {})}, **options)


def environment() -> dict[str, str]:
    """That of this process; its PYTHONPATH does not name the current directory, as an empty part of ``:/opt/x`` does.

    Other relative parts, which the user has named, mean what they mean for this process, in whatever directory.
    """
    found = dict(os.environ)
    parts = found.pop("PYTHONPATH", "").split(os.pathsep)
    if named := [str(Path(part).absolute()) for part in parts if part and os.path.normpath(part) != os.curdir]:
        found["PYTHONPATH"] = os.pathsep.join(named)
    return found


def run_module(module: str, *words: str) -> list[str]:
    """The command that runs a module in another process, without the current directory on its import path.

    ``python -m`` would put that first: a folder with a file ``json.py`` in it would run the file.
    """
    return [sys.executable, "-P", "-m", module, *words]


def own_python() -> str:
    """The Python that runs libgz, to make an environment with; modules of libgz are run by `run_module`."""
    return sys.executable
