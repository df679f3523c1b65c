"""The table of the trials: one row for each, printed past pytest's capture and kept in a file if TRIALS names one."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["Row", "seed", "trial"]

ROOT = Path(__file__).parents[2]
WIDTHS = (44, 10, 40, 9, 10, 10)
HEADINGS = ("trial", "count", "result", "seconds", "seed", "commit")


class Row:
    """One trial; set `count` and `result` while it runs."""

    def __init__(self, name: str, seed: int) -> None:
        self.name, self.seed = name, seed
        self.count = 0
        self.result = ""


def seed() -> int:
    """TRIAL_SEED of the environment, which repeats a failure, or a new one."""
    return int(os.environ.get("TRIAL_SEED") or random.SystemRandom().randrange(10**9))


def commit() -> str:
    """The commit of the sources; with + where they have changed since."""
    command = ["git", "-C", str(ROOT), "describe", "--always", "--abbrev=8", "--exclude=*", "--dirty=+"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return "-"
    return done.stdout.strip() or "-"


def print_row(cells: tuple[str, ...]) -> None:
    """One line of the table."""
    line = "  ".join(cell.ljust(width) for cell, width in zip(cells, WIDTHS, strict=True)).rstrip()
    stream = sys.__stdout__ or sys.stdout
    stream.write(f"\n{line}\n")
    stream.flush()
    if os.environ.get("TRIALS"):
        with Path(os.environ["TRIALS"]).open("a") as file:
            file.write(line + "\n")


@contextmanager
def trial(name: str) -> Iterator[Row]:
    """A trial: its row is printed at the end, with the reason if it failed."""
    row, begin = Row(name, seed()), time.monotonic()
    try:
        yield row
    except BaseException as error:
        reason = str(error).splitlines()
        row.result = f"FAILED: {reason[0] if reason else type(error).__name__}"
        raise
    finally:
        seconds = f"{time.monotonic() - begin:.1f}"
        print_row((row.name, str(row.count), row.result or "passed", seconds, str(row.seed), commit()))
