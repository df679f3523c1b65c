"""Worker: a process of its own that does runs, each in a fork of it: no run can harm another, or last for ever.

`python -m libgz.sweep.worker` reads orders from its standard input and writes replies to its standard output, pickled.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import logging
import os
import pickle
import platform
import select
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections import OrderedDict
from collections.abc import Sequence
from typing import IO, Any, NoReturn

from libgz._version import __version__
from libgz.base.errors import GazeboError
from libgz.base.python import start_module
from libgz.sweep.parent import end_with_parent
from libgz.sweep.study import Study

__all__ = ["Worker", "WorkerLostError", "close_workers", "execute"]

LENGTH = struct.Struct("<Q")
POLL = 0.05  # [s] between two looks at a run's memory
KEPT = 8  # states at `study.start`
MEGABYTE = 1 << 20


class WorkerLostError(GazeboError):
    """The process of a worker ended, such as by a signal."""


def _send(stream: IO[bytes], thing: object) -> None:
    data = pickle.dumps(thing)
    stream.write(LENGTH.pack(len(data)) + data)
    stream.flush()


def _receive(stream: IO[bytes]) -> Any:
    """The next object; None at the end of the stream."""
    head = _read(stream, LENGTH.size)
    data = _read(stream, LENGTH.unpack(head)[0]) if head else b""
    return pickle.loads(data) if data else None


def _read(stream: IO[bytes], count: int) -> bytes:
    """So many bytes; none if the stream ends before."""
    data = b""
    while len(data) < count:
        piece = stream.read(count - len(data))
        if not piece:
            return b""
        data += piece
    return data


class Worker:
    """The side that gives orders. It starts the process when it is first used, and again if that was lost."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._known = ""  # digest of the study that the process has
        self.ended = False  # whether it is not to be used any more

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self.close()
            threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "LP_NUM_THREADS": "0"}
            changes = {name: os.environ.get(name, value) for name, value in threads.items()}
            self._process = start_module(
                "libgz.sweep.worker", changes=changes, stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )
        return self._process

    def ask(self, order: str, study: Study, digest: str, number: int = 0) -> Any:
        """Send an order and wait for its reply.

        Raises:
            WorkerLostError: the process ended meanwhile.
        """
        if self.ended:
            raise WorkerLostError("the worker was ended")
        process = self._started()
        new = None if self._known == digest else study
        try:
            if process.stdin is None or process.stdout is None:
                raise WorkerLostError("the worker has no pipes")
            _send(process.stdin, (order, new, number))
            reply = _receive(process.stdout)
        except (OSError, EOFError, pickle.UnpicklingError):
            reply = None
        if reply is None:
            self.close()
            raise WorkerLostError(f"the worker's process {process.pid} ended")
        self._known = digest
        return reply

    def close(self) -> None:
        """End the process, and the run that it does. Can be called twice."""
        process, self._process, self._known = self._process, None, ""
        if process is None:
            return
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                try:
                    stream.close()
                except OSError:
                    continue
        process.kill()
        process.wait()


_of_thread = threading.local()
_workers: list[Worker] = []  # of all threads of this process


def close_workers() -> None:
    """End the workers of this process, and the runs that they do."""
    while _workers:
        worker = _workers.pop()
        worker.ended = True
        worker.close()


def execute(study: Study, digest: str, number: int) -> dict[str, Any]:
    """Do a run of a study, again if it failed; its row. What executors are given.

    Args:
        study: the study.
        digest: of it.
        number: of the run.
    """
    worker: Worker | None = getattr(_of_thread, "worker", None)
    if worker is None:
        worker = _of_thread.worker = Worker()
        _workers.append(worker)
    row: dict[str, Any] = {}
    for attempt in range(1, study.retries + 2):
        start = time.monotonic()
        try:
            row = worker.ask("run", study, digest, number)
        except WorkerLostError as error:
            row = {"state": "lost", "message": str(error)}
        row["attempts"], row["wall_time"] = attempt, round(time.monotonic() - start, 4)
        if row["state"] == "ok" or worker.ended:
            break
    return {
        "run": number,
        **row,
        "host": socket.gethostname(),
        "libgz": __version__,
        "python": platform.python_version(),
    }


# The process ----------------------------------------------------------------------------------------------------------


def serve(orders: IO[bytes], replies: IO[bytes]) -> None:
    """Follow orders until their stream ends."""
    from libgz.sweep import run  # loads all that runs need, once, before the forks

    study: Study | None = None
    states: OrderedDict[str, bytes] = OrderedDict()
    gc.collect()
    gc.freeze()
    while (order := _receive(orders)) is not None:
        what, new, number = order
        if new is not None:
            study, states = new, OrderedDict()
        if study is None:
            return
        one = study.run(number)
        key = repr((sorted(one.changes.items(), key=str), one.seed))
        reply = _in_fork(run, what, study, number, states.get(key) if study.start > 0.0 else None, orders)
        if reply is None:
            return
        _load(reply.pop("modules", ()))
        if "kept" in reply:
            states[key] = reply.pop("kept")
            while len(states) > KEPT:
                states.popitem(last=False)
        _send(replies, reply)


def _load(modules: Sequence[str]) -> None:
    """Load the modules that a run has needed, so that the next forks have them."""
    new = [name for name in modules if name not in sys.modules]
    for name in new:
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    if new:
        gc.collect()
        gc.freeze()


def _in_fork(
    run: Any, what: str, study: Study, number: int, state: bytes | None, orders: IO[bytes]
) -> dict[str, Any] | None:
    """Do an order in a child process, within its limits; its reply, or None if nobody waits for it any more."""
    reading, writing = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(reading)
        _work(run, what, study, number, state, writing)
    os.close(writing)
    try:
        return _watched(pid, reading, study, orders)
    finally:
        os.close(reading)
        _end(pid)


def _watched(pid: int, reading: int, study: Study, orders: IO[bytes]) -> dict[str, Any] | None:
    start, data = time.monotonic(), b""
    limited = study.limits.memory < float("inf")
    while True:
        left = study.limits.time - (time.monotonic() - start)
        if left <= 0.0:
            return {"state": "timeout", "message": f"it took more than {study.limits.time:g} s"}
        waits: list[Any] = [reading, orders]
        ready, _, _ = select.select(waits, [], [], min(left, POLL) if limited else min(left, 3600.0))
        if orders in ready:  # the other side has closed it: it sends nothing before the reply
            return None
        if reading in ready:
            piece = os.read(reading, 1 << 16)
            data += piece
            if not piece:
                return _reply(pid, data)
        elif limited and _memory(pid) > study.limits.memory * MEGABYTE:
            return {"state": "memory", "message": f"it took more than {study.limits.memory:g} MB"}


def _reply(pid: int, data: bytes) -> dict[str, Any]:
    try:
        reply: dict[str, Any] = pickle.loads(data)
        return reply
    except (EOFError, pickle.UnpicklingError, IndexError):
        _, status = os.waitpid(pid, 0)
        ended = (
            f"signal {os.WTERMSIG(status)}"
            if os.WIFSIGNALED(status)
            else f"exit code {os.waitstatus_to_exitcode(status)}"
        )
        return {"state": "crashed", "message": f"its process ended with {ended}"}


def _memory(pid: int) -> int:
    """Memory of a process and its children [byte]."""
    try:
        with open(f"/proc/{pid}/statm") as numbers:  # noqa: PTH123
            _, resident, shared, *_ = map(int, numbers.read().split())
        with open(f"/proc/{pid}/task/{pid}/children") as names:  # noqa: PTH123
            children = names.read().split()
    except (OSError, ValueError):
        return 0
    return (resident - shared) * os.sysconf("SC_PAGE_SIZE") + sum(_memory(int(child)) for child in children)


def _end(pid: int) -> None:
    """End a run's process, and the programs that it started."""
    for end in (
        lambda: os.killpg(pid, signal.SIGKILL),
        lambda: os.kill(pid, signal.SIGKILL),
        lambda: os.waitpid(pid, 0),
    ):
        try:
            end()
        except (ProcessLookupError, ChildProcessError):
            continue


def _work(run: Any, what: str, study: Study, number: int, state: bytes | None, writing: int) -> NoReturn:
    """In the child: do the order, write the reply, end."""
    os.setpgid(0, 0)
    end_with_parent()
    kept: list[bytes] = []
    try:
        if what == "check":
            run.check(study)
            reply: dict[str, Any] = {"state": "ok", "message": ""}
        else:
            measured = run.simulate(study, study.run(number), state, kept.append)
            reply = {"state": "ok", "message": "", **measured}
    except BaseException as error:  # noqa: BLE001 - whatever a user's code raises is the result
        text = str(error) if isinstance(error, GazeboError) else f"{type(error).__name__}: {error}"
        reply = {"state": "failed", "message": " | ".join(text.split("\n"))[:1000]}
    if kept:
        reply["kept"] = kept[0]
    reply["modules"] = [name for name in sys.modules if name.startswith(("libgz.", "numpy.", "OpenGL."))]
    data = memoryview(pickle.dumps(reply))
    while data:
        data = data[os.write(writing, data) :]
    os._exit(0)


def main() -> None:
    """The process: its standard streams are for orders and replies only; what runs print goes to stderr."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the other side decides
    logging.getLogger("libgz").setLevel(logging.CRITICAL)
    orders = os.fdopen(os.dup(0), "rb", buffering=0)
    replies = os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    serve(orders, replies)


if __name__ == "__main__":
    main()
