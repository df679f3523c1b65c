"""gz: the subcommands of Gazebo 11's command of this name; another `gz` on the path goes first."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from libgz.apps.console import as_command
from libgz.apps.libgz import run_words

__all__ = ["main"]

DEFERRED = "LIBGZ_GZ_DEFERRED"  # in the environment of the other gz, which might call this one
OURS = b"libgz.apps.launch"  # in the scripts of all installations of libgz


@as_command("gz")
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, 1 failed, 2 the command line is wrong; those of another `gz` on the path."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    other = _other()
    if other is not None and DEFERRED not in os.environ:
        os.execve(other, ["gz", *words], {**os.environ, DEFERRED: "1"})
    return run_words("gz", words)


def _other() -> Path | None:
    """The first `gz` on the path that is not of libgz: that of Gazebo, classic or later."""
    for folder in os.get_exec_path():
        found = Path(folder) / "gz"
        with contextlib.suppress(OSError):
            if found.is_file() and os.access(found, os.X_OK) and not _is_ours(found):
                return found
    return None


def _is_ours(script: Path) -> bool:
    with script.open("rb") as file:
        return OURS in file.read(4096)


if __name__ == "__main__":
    sys.exit(main())
