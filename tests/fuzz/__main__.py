"""Coverage-guided fuzzing of all readers of files: `make fuzz [MINUTES=60] [READER=stl] [FILE=...]`.

Inputs that reach new code are kept in .fuzz/READER/corpus, so that a further run begins where the last one ended;
findings in .fuzz/READER/findings. Each run repeats earlier findings first; those that are corrected become inputs.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from readers import KINDS, problem, seeds
from trials.table import commit

from libgz.rendering.choice import prefer

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / ".fuzz"
SECONDS = 20  # for one input
MEGABYTES = 3000  # of memory
LARGEST = 256 * 1024  # bytes of an input; a log of a robot has half of that
MOST_ENDS = 20  # processes that crash, of one reader
WIDTHS = (8, 8, 11, 7, 9, 9, 11, 10)
HEADINGS = ("reader", "minutes", "executions", "code", "features", "findings", "seed", "commit")
_STATUS = re.compile(r"#(\d+)\s+\w+\s+cov: (\d+) ft: (\d+)")


@dataclass
class Run:
    """The fuzzing of one reader."""

    kind: str
    seed: int
    executions: int = 0
    code: int = 0  # edges of the code that were reached
    features: int = 0  # edges, and how often
    stopped: bool = False
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.corpus, self.findings = FOLDER / self.kind / "corpus", FOLDER / self.kind / "findings"
        for folder in (self.corpus, self.findings):
            folder.mkdir(parents=True, exist_ok=True)

    def check_earlier(self) -> None:
        """Repeat the findings of earlier runs; those that are corrected become inputs."""
        for path in sorted(self.findings.iterdir()):
            if not repeat(self.kind, path):
                path.rename(self.corpus / path.name)

    def fuzz(self, seconds: float) -> None:
        """Fuzz for a time; after a crash, a further process continues."""
        for number, data in enumerate(seeds(self.kind)):
            (self.corpus / f"seed-{number}").write_bytes(data)
        end = time.monotonic() + seconds
        for ended in range(MOST_ENDS):
            left = int(end - time.monotonic())
            if left < 1 or self.stopped:
                return
            if self._process(left, ended) == 0:
                return
        self.notes.append(f"{self.kind}: ended after {MOST_ENDS} crashes; correct them, then start again")

    def _process(self, seconds: int, number: int) -> int:
        with tempfile.TemporaryDirectory(prefix="libgz-fuzz-") as folder:
            command = [
                *(sys.executable, "-m", "fuzz.worker", self.kind, str(self.findings), folder, str(self.corpus)),
                *(f"-max_total_time={seconds}", f"-timeout={SECONDS}", f"-rss_limit_mb={MEGABYTES}"),
                *(f"-max_len={LARGEST}", f"-seed={(self.seed + number) % 2**32 or 1}", "-report_slow_units=1000"),
                f"-artifact_prefix={self.findings}/",
            ]
            process = subprocess.Popen(
                command,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
                env=environment(),
            )
            assert process.stderr is not None
            before, last = self.executions, []
            try:
                for line in process.stderr:
                    last = [*last[-9:], line]
                    if found := _STATUS.search(line):
                        self.executions = before + int(found[1])
                        self.code, self.features = max(self.code, int(found[2])), max(self.features, int(found[3]))
                code = process.wait()
            except KeyboardInterrupt:
                self.stopped = True
                process.send_signal(signal.SIGINT)
                process.wait()
                return 0
        if code and not any("Test unit written" in line for line in last):  # the reader was never tried
            raise SystemExit(f"fuzzing {self.kind} ended with {code}:\n{''.join(last)}")
        return code

    def report(self, minutes: float) -> tuple[str, ...]:
        """The cells of the table; findings are printed."""
        found = sorted(self.findings.iterdir())
        for path in found:
            what = repeat(self.kind, path) or "passes alone: something that an earlier input left was wrong"
            name = os.path.relpath(path)
            print(f"{name}: {what.strip().splitlines()[-1]}\n    make fuzz READER={self.kind} FILE={name}", flush=True)
        print(*self.notes, sep="\n", end="\n" if self.notes else "")
        numbers = (f"{minutes:.1f}", self.executions, self.code, self.features, len(found), self.seed)
        return (self.kind, *map(str, numbers), commit())


def environment() -> dict[str, str]:
    """Of processes that find the modules of the tests."""
    return {**os.environ, "PYTHONPATH": str(ROOT / "tests")}


def repeat(kind: str, path: Path) -> str:
    """What is wrong with how a file is read, in a process of its own; an empty string if nothing is."""
    command = [sys.executable, "-X", "faulthandler", "-m", "fuzz", "--reader", kind, "--file", str(path)]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, errors="replace", env=environment(), timeout=2 * SECONDS
        )
    except subprocess.TimeoutExpired:
        return f"longer than {2 * SECONDS} s"
    if done.returncode < 0:
        return f"{done.stderr[-2000:]}\n{signal.Signals(-done.returncode).name}"
    return (done.stdout or done.stderr[-2000:]) if done.returncode else ""


def show(kind: str, path: Path) -> int:
    """Give one file to a reader, and print what is wrong; the exit code."""
    prefer("none")
    with tempfile.TemporaryDirectory(prefix="libgz-fuzz-") as folder:
        data = path.read_bytes()
        os.chdir(folder)
        copy = Path(folder) / f"input.{'world' if kind in ('legacy', 'sdf') else kind}"
        copy.write_bytes(data)
        what = problem(kind, copy)
        os.chdir("/")
    if what:
        print(what)
    return 1 if what else 0


def main() -> int:
    """The command: 0 if nothing was found."""
    parser = argparse.ArgumentParser(prog="make fuzz", description=__doc__)
    parser.add_argument("--minutes", type=float, default=5.0, help="for each reader")
    parser.add_argument("--reader", choices=KINDS, action="append", help="default: all, one after another")
    parser.add_argument("--file", type=Path, help="give this file to the reader, and print what is wrong")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1, 2**32))
    options = parser.parse_args()
    if options.file:
        return show((options.reader or KINDS)[0], options.file)
    found = False
    for kind in options.reader or KINDS:
        begin, run = time.monotonic(), Run(kind, options.seed)
        run.check_earlier()
        run.fuzz(60.0 * options.minutes)
        cells = run.report((time.monotonic() - begin) / 60.0)
        found |= cells[5] != "0"
        rows = [HEADINGS, cells] if kind == (options.reader or KINDS)[0] else [cells]
        for row in rows:
            line = "  ".join(cell.ljust(width) for cell, width in zip(row, WIDTHS, strict=True)).rstrip()
            print(line, flush=True)
            with (FOLDER / "table.txt").open("a") as table:
                table.write(line + "\n")
        if run.stopped:
            break
    return 1 if found else 0


sys.exit(main())
