"""The option --untrusted of all commands that read files: for files of strangers.

No code that a file names runs, and no macros are expanded (`libgz.base.trust`); memory and processor time are limited.
The kernel limits memory. A forked guard looks at the processor time twice a second; at the limit it sends SIGTERM, so
that servers remove their files, and 5 s later SIGKILL. It explains the end of a process that cannot do so itself,
because native code does not return or has crashed.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import resource
import select
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

from libgz.base.errors import GazeboError, ParameterError
from libgz.base.trust import distrust

__all__ = ["MEMORY", "TIME", "add_untrusted_option", "confined"]

MEMORY, TIME = "LIBGZ_UNTRUSTED_MEMORY", "LIBGZ_UNTRUSTED_TIME"  # environment variables with other limits
DEFAULTS = {MEMORY: 4096, TIME: 600}  # [MiB], [s]
NO_THREAD = "can't start new thread"  # Python's message where there is no memory for its stack
HELP = (
    "for files of strangers: load no plugins, expand no macros, and take at most "
    f"{DEFAULTS[MEMORY]} MiB of memory and {DEFAULTS[TIME]} s of processor time ({MEMORY}, {TIME})"
)
PERIOD = 500  # [ms] between two looks at the processor time
GRACE = 5.0  # [s] of processor or real time between SIGTERM and SIGKILL
TICKS = os.sysconf("SC_CLK_TCK")


def add_untrusted_option(parser: argparse.ArgumentParser) -> None:
    """Add --untrusted."""
    parser.add_argument("--untrusted", action="store_true", help=HELP)


@contextlib.contextmanager
def confined(prog: str, options: argparse.Namespace) -> Iterator[None]:
    """For a `with` block with the work of a command: if its options say --untrusted, code and resources are limited.

    The process is limited from then on, also after the block.

    Raises:
        ParameterError: an environment variable with a limit is invalid.
        GazeboError: the block takes more memory than it may.
    """
    if not getattr(options, "untrusted", False):
        yield
        return
    memory, limit = _limit(MEMORY), _limit(TIME)
    distrust()
    if memory:
        _limit_resource(resource.RLIMIT_DATA, memory << 20)
    if limit:  # the kernel's limit serves child processes, and this one should its guard be killed
        _limit_resource(resource.RLIMIT_CPU, limit + 2 * int(GRACE))
    note = _start_guard(prog, memory, limit)
    try:
        yield
    except BaseException as error:
        if isinstance(error, MemoryError) or str(error) == NO_THREAD:
            raise GazeboError(_used_up(f"memory of {memory} MiB", MEMORY)) from None
        if not _is_late(limit):
            raise
    finally:
        with contextlib.suppress(OSError):
            os.write(note, b"1")
    if _is_late(limit):  # the guard's SIGTERM has ended the work
        raise GazeboError(_used_up(f"processor time of {limit} s", TIME))


def _is_late(limit: int) -> bool:
    return limit > 0 and time.process_time() >= limit


def _used_up(what: str, variable: str) -> str:
    return f"the {what} that files of strangers may take is used up; the environment variable {variable} allows more"


def _limit(variable: str) -> int:
    """A limit: the default, or what the environment variable says; 0 for none.

    Raises:
        ParameterError: the variable is no number.
    """
    text = os.environ.get(variable, "") or str(DEFAULTS[variable])
    if not text.isdecimal() or len(text) > 9:
        unit = "MiB" if variable == MEMORY else "s"
        raise ParameterError(
            f"the environment variable {variable} is {text!r}; a number of {unit} is allowed, 0 for no limit"
        )
    return int(text)


def _limit_resource(kind: int, limit: int) -> None:
    """Lower both limits of the process, which then cannot be raised again."""
    _, hardest = resource.getrlimit(kind)
    limit = limit if hardest == resource.RLIM_INFINITY else min(limit, hardest)
    resource.setrlimit(kind, (limit, limit))


def _start_guard(prog: str, memory: int, limit: int) -> int:
    """Fork the guard of this process; returns where to write that the work has ended as it should."""
    reading, writing = os.pipe()
    parent = os.getpid()
    if os.fork() == 0:
        os.close(writing)
        _guard(prog, parent, reading, memory, limit)
    os.close(reading)
    return writing


def _guard(prog: str, parent: int, note: int, memory: int, limit: int) -> NoReturn:
    """Wait for the end of the parent process; end it at its limit of time, and explain an end that it did not note."""
    os.setsid()  # signals of the terminal are not for the guard
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    with contextlib.suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_RDWR), 1)  # who reads the output waits for its end
    late = 0.0  # when SIGTERM was sent
    waiting = select.poll()
    waiting.register(note, select.POLLIN)
    # Other children of the parent may hold the pipe's end open, so the parent itself counts, too.
    while not waiting.poll(PERIOD) and os.getppid() == parent:
        if late and time.monotonic() > late + GRACE:
            os.kill(parent, signal.SIGKILL)
        elif not late and limit and _processor_time(parent) >= limit:
            late = time.monotonic()
            os.kill(parent, signal.SIGTERM)
    noted = bool(waiting.poll(0)) and os.read(note, 1)
    if late and not noted:
        _print(f"{prog}: {_used_up(f'processor time of {limit} s', TIME)}")
    elif not noted:
        _print(
            f"{prog}: the process has crashed or was killed; files of strangers may take {memory} MiB of memory, which "
            f"the environment variable {MEMORY} changes"
        )
    os._exit(0)


def _processor_time(process: int) -> float:
    """The processor time that a process has taken [s]; 0 for one that has ended."""
    try:
        words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(words[11]) + int(words[12])) / TICKS


def _print(text: str) -> None:
    with contextlib.suppress(OSError):
        os.write(2, f"{text}\n".encode())
