"""libgz sweep: run a study, or report what it measured."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from pathlib import Path
from typing import Any

from libgz.apps.console import INTERRUPTED, TERMINATED, say, whole_number
from libgz.base.errors import GazeboError, LibraryError, ParameterError
from libgz.base.extras import install
from libgz.sweep import driver
from libgz.sweep.results import FORMATS, open_results, read_results
from libgz.sweep.study import Study

__all__ = ["configure", "run"]

REPORT = "report"
PERIOD = 10.0  # [s] between two lines of progress that is no terminal's


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add = parser.add_argument
    add("study", metavar="STUDY", help=f"a study (TOML), or `{REPORT}` to plot the measures of one")
    add("results_of", nargs="?", metavar="RESULTS", help=f"with `{REPORT}`: the folder of results, or the study")
    add("--results", metavar="DIR", help="where results go (default: the study's name with .results)")
    add("--format", choices=FORMATS, help="of the results (default csv); parquet needs the extra `cluster`")
    add(
        "--jobs",
        "-j",
        "--local",
        metavar="N",
        type=whole_number("number of processes"),
        help="processes of this machine (default: one a processor)",
    )
    add(
        "--scheduler",
        metavar="ADDRESS",
        help="run on the cluster of this dask.distributed scheduler, tls://HOST:PORT; with tcp:// it must be trusted",
    )
    add("--dry-run", action="store_true", help="check the study, and print how many runs it has")
    add("--output", "-o", metavar="DIR", help=f"with `{REPORT}`: where plots go (default: beside the results)")


def run(options: argparse.Namespace) -> int:
    """Run or report; 1 if runs failed."""
    if options.study == REPORT:
        return _report(options)
    if options.results_of is not None:
        raise ParameterError(f"{options.results_of!r} is too much: give one study, or `{REPORT}` and its results")
    if options.jobs is not None and options.scheduler is not None:
        raise ParameterError("give only one of --jobs and --scheduler")
    if options.jobs == 0:
        raise ParameterError("the number of processes must be at least 1")
    study = Study.load(options.study)
    digest = study.digest()
    driver.check(study, digest)
    if options.dry_run:
        say(f"{len(study)} runs of {study.duration:g} s")
        return 0
    return _run(study, digest, options)


def _run(study: Study, digest: str, options: argparse.Namespace) -> int:
    folder = _folder(options.results, options.study)
    results = open_results(folder, study, digest, options.format)
    line = _Line(folder)
    try:
        with contextlib.closing(results), _pool(options) as pool:
            progress = driver.sweep(study, digest, results, pool, line.show)
    except (KeyboardInterrupt, SystemExit) as error:  # Ctrl-C and SIGTERM
        line.end()
        say(
            f"libgz: {len(results.recorded)} of {len(study)} runs are recorded; the same command continues",
            file=sys.stderr,
        )
        return TERMINATED if isinstance(error, SystemExit) else INTERRUPTED
    except driver.SchedulerLostError as error:
        line.end()
        done = f"{len(results.recorded)} of {len(study)} runs are recorded; the same command continues"
        raise GazeboError(f"{error}; {done}") from None
    line.end()
    failed = f", {progress.failed} of them failed" if progress.failed else ""
    say(f"{progress.done} runs in {folder}{failed}")
    return 1 if progress.failed else 0


def _pool(options: argparse.Namespace) -> Any:
    return driver.cluster(options.scheduler) if options.scheduler is not None else driver.processes(options.jobs)


def _folder(given: str | None, study: str) -> Path:
    return Path(given) if given else Path(study).with_suffix(".results")


class _Line:
    """Progress on stderr: one line that changes on a terminal, else a line now and then."""

    def __init__(self, folder: Path) -> None:
        self._terminal, self._next, self._width = sys.stderr.isatty(), time.monotonic() + PERIOD, 0

    def show(self, progress: driver.Progress) -> None:
        """Show the progress, if it is time to."""
        now = time.monotonic()
        if not self._terminal and now < self._next:
            return
        self._next = now + PERIOD
        left, failed = progress.left(), f", {progress.failed} failed" if progress.failed else ""
        text = f"{progress.done} of {progress.total} runs{failed}" + (f", {_duration(left)} left" if left else "")
        if self._terminal:
            sys.stderr.write(f"\r{text.ljust(self._width)}")
            self._width = len(text)
        else:
            sys.stderr.write(f"{text}\n")
        sys.stderr.flush()

    def end(self) -> None:
        """End the line."""
        if self._terminal and self._width:
            sys.stderr.write("\n")
            self._width = 0


def _duration(seconds: float) -> str:
    """``3 h 20 min``, ``5 min``, ``12 s``."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min" if minutes else f"{rest} s"


def _report(options: argparse.Namespace) -> int:
    """Plot each measure; print the plots' files."""
    if options.results_of is None:
        raise ParameterError(f"name the results to report, such as libgz sweep {REPORT} study.results")
    folder = Path(options.results_of)
    folder = folder.with_suffix(".results") if folder.suffix == ".toml" else folder
    about, rows = read_results(folder)
    if len(rows) < about.get("runs", 0):
        say(f"{len(rows)} of {about['runs']} runs are recorded", file=sys.stderr)
    try:
        from libgz.sweep.report import plot_measures
    except ImportError as error:
        raise LibraryError(f"plots need the extra `plot`: {install('plot')} ({error})") from None
    for path in plot_measures(about, rows, Path(options.output) if options.output else folder):
        say(path)
    return 0
