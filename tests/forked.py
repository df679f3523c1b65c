"""Many trials of a function in processes that are forked from this one, each with a limit of memory and time."""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

__all__ = ["Failure", "note", "run_trials"]

MEMORY = 3 << 30  # bytes of address space, beyond what the process has when it is forked
SECONDS = 20.0  # of processor time for one trial
BATCH = 200  # trials of one process
_results = -1  # in a worker: the file of its results
Trial = Callable[[int], str]  # takes a number; returns a failure's description, or an empty string


@dataclass(frozen=True)
class Failure:
    """A trial that failed."""

    number: int
    what: str
    during: str = ""  # the last note, if the process ended
    first: int | None = None  # the first trial of its process, if it failed after others only


def note(text: str) -> None:
    """Say in a trial what it does next, in case that ends the process."""
    if _results >= 0:
        os.write(_results, (json.dumps(text) + "\n").encode())


def run_trials(trial: Trial, numbers: range, processes: int) -> Iterator[Failure]:
    """Run trials, several processes at a time; their failures.

    A trial that fails is repeated in a process of its own. If it passes there, it counts all the same: something that
    an earlier trial left in the process is wrong, or the machine was short of memory or time.
    """
    waiting = [range(start, min(start + BATCH, numbers.stop)) for start in range(numbers.start, numbers.stop, BATCH)]
    running: dict[int, tuple[int, range]] = {}  # pid -> file of results, trials
    while waiting or running:
        while waiting and len(running) < processes:
            batch = waiting.pop()
            pid, file = _start(trial, batch)
            running[pid] = file, batch
        pid, status = os.wait()
        if pid not in running:
            continue
        file, batch = running.pop(pid)
        done, failed, last = _read(file)
        for number, what in failed.items():
            yield from _alone(trial, number) or [Failure(number, f"after others: {what}", last, batch.start)]
        if done < len(batch):  # it died in the one after those
            number, ended = batch[done], _ended(batch[done], status, last)
            yield from _alone(trial, number) or [replace(ended, what=f"after others: {ended.what}", first=batch.start)]
            if len(batch) > done + 1:
                waiting.append(batch[done + 1 :])


def _alone(trial: Trial, number: int) -> list[Failure]:
    pid, file = _start(trial, range(number, number + 1))
    _, status = os.waitpid(pid, 0)
    done, failed, last = _read(file)
    return [Failure(number, what) for what in failed.values()] if done else [_ended(number, status, last)]


def _ended(number: int, status: int, last: str) -> Failure:
    code = os.waitstatus_to_exitcode(status)
    name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    what = f"longer than {SECONDS:g} s" if code == -signal.SIGPROF else name
    return Failure(number, f"the process ended: {what}", last)


def _start(trial: Trial, batch: range) -> tuple[int, int]:
    file, name = tempfile.mkstemp(prefix="trials")
    os.unlink(name)  # noqa: PTH108
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        return pid, file
    code = 1
    try:
        _work(trial, batch, file)
        code = 0
    finally:
        os._exit(code)


def _work(trial: Trial, batch: range, file: int) -> None:
    size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()  # noqa: SIM115, PTH123
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, size + MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    warnings.simplefilter("ignore")
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    global _results
    _results = file
    for number in batch:
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        try:
            what = trial(number)
        except BaseException:  # noqa: BLE001 - what the trial is about
            what = "".join(traceback.format_exc().splitlines(keepends=True)[-4:])
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        os.write(file, (json.dumps([number, what] if what else None) + "\n").encode())


def _read(file: int) -> tuple[int, dict[int, str], str]:
    """(trials done, failures, last note) of a process that ended."""
    with os.fdopen(file, "rb") as results:
        results.seek(0)
        lines = [json.loads(line) for line in results]
    done = [line for line in lines if not isinstance(line, str)]
    last = next((line for line in reversed(lines) if isinstance(line, str)), "")
    return len(done), dict(filter(None, done)), last
