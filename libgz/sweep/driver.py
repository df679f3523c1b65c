"""The sweep: gives runs to an executor of `concurrent.futures`, and records their rows."""

from __future__ import annotations

import contextlib
import logging
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any, Protocol

from libgz.base.errors import GazeboError, LibraryError, ParameterError
from libgz.base.extras import install
from libgz.sweep.results import Results
from libgz.sweep.study import Study
from libgz.sweep.worker import Worker, close_workers, execute

__all__ = ["Pool", "Progress", "SchedulerLostError", "check", "cluster", "processes", "sweep"]

log = logging.getLogger("libgz.sweep")

AHEAD = 3  # runs given out per worker, so that none waits for the next one
LOOK = 1.0  # [s] between two looks at the connection, and two reports
HANDSHAKE = 20.0  # [s] to reach a scheduler
SCHEMES = ("tls", "tcp", "wss", "ws")  # of one in another process
WITH_TLS = ("tls", "wss")


class SchedulerLostError(GazeboError):
    """The connection to the scheduler of a cluster was lost; what is recorded stays, and the sweep can be continued."""


class Pool(Protocol):
    """Where runs are done."""

    executor: Executor

    def size(self) -> int:
        """How many runs are done at a time."""

    def alive(self) -> bool:
        """Whether runs that were given out can still come back."""


@dataclass
class Progress:
    """How far a sweep is."""

    total: int
    done: int
    failed: int
    before: int  # recorded when this began
    start: float  # time.monotonic [s]

    def left(self) -> float | None:
        """Time that the rest will take [s]; None while it is not known."""
        new = self.done - self.before
        return (time.monotonic() - self.start) / new * (self.total - self.done) if new else None


def check(study: Study, digest: str) -> None:
    """Try to load the study's world, and find all that it names, in a process of its own.

    Raises:
        GazeboError: something is wrong.
    """
    worker = Worker()
    try:
        reply = worker.ask("check", study, digest)
    finally:
        worker.close()
    if reply["state"] != "ok":
        raise GazeboError(reply["message"])


def sweep(study: Study, digest: str, results: Results, pool: Pool, report: Callable[[Progress], object]) -> Progress:
    """Do all runs that are not recorded.

    Args:
        study: the study.
        digest: of it.
        results: where rows go.
        pool: where runs are done.
        report: is called now and then.

    Raises:
        SchedulerLostError: the cluster cannot be reached any more.
    """
    total = len(study)
    missing = (number for number in range(total) if number not in results.recorded)
    progress = Progress(total, len(results.recorded), results.failed, len(results.recorded), time.monotonic())
    pending: dict[Future[dict[str, Any]], tuple[int, int]] = {}  # -> run, times that it was lost
    report(progress)

    def give_out(number: int, lost: int = 0) -> None:
        pending[pool.executor.submit(execute, study, digest, number)] = number, lost

    try:
        while True:
            while len(pending) < AHEAD * max(1, pool.size()) and (number := next(missing, None)) is not None:
                give_out(number)
            if not pending:
                return progress
            done, _ = wait(pending, LOOK, FIRST_COMPLETED)
            if not done and not pool.alive():
                raise SchedulerLostError("the connection to the scheduler was lost")
            for future in done:
                number, lost = pending.pop(future)
                row = _row_of(future, number, lost, study.retries, pool)
                if row is None:
                    give_out(number, lost + 1)
                    continue
                results.add({**_inputs(study, number), **row})
            progress.done, progress.failed = len(results.recorded), results.failed
            report(progress)
    finally:
        for future in pending:
            future.cancel()


def _row_of(future: Future[dict[str, Any]], number: int, lost: int, retries: int, pool: Pool) -> dict[str, Any] | None:
    """The row of a run that has come back; None if its worker died, and it must be rescheduled."""
    try:
        return future.result()
    except (Exception, CancelledError) as error:  # whatever the cluster raises for a worker that was lost
        if not pool.alive():
            raise SchedulerLostError(f"the connection to the scheduler was lost ({type(error).__name__})") from error
        log.info("run %d was lost: %s: %s", number, type(error).__name__, error)
        if lost < retries:
            return None
        return {"run": number, "state": "lost", "message": f"{type(error).__name__}: {error}", "attempts": lost + 1}


def _inputs(study: Study, number: int) -> dict[str, Any]:
    run = study.run(number)
    return {**run.parameters, "controller": run.controller.name, "seed": run.seed}


# Pools ----------------------------------------------------------------------------------------------------------------


class _Processes:
    """Processes of this machine: each thread of the executor has a worker, which is a process."""

    def __init__(self, count: int) -> None:
        self._count = count
        self.executor: Executor = ThreadPoolExecutor(count, "sweep")

    def size(self) -> int:
        return self._count

    def alive(self) -> bool:
        return True


@contextlib.contextmanager
def processes(count: int | None = None) -> Iterator[Pool]:
    """A pool of processes of this machine, as many as it has processors if no number is given."""
    pool = _Processes(count or os.cpu_count() or 1)
    try:
        yield pool
    finally:
        pool.executor.shutdown(wait=False, cancel_futures=True)
        close_workers()
        pool.executor.shutdown(wait=True)


class _Cluster:
    def __init__(self, client: Any) -> None:
        self._client = client
        self.executor: Executor = client.get_executor(pure=False)

    def size(self) -> int:
        try:
            return max(1, int(sum(self._client.nthreads().values())))
        except (OSError, TimeoutError, ValueError):
            return 1

    def alive(self) -> bool:
        return bool(self._client.status == "running")


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise LibraryError(f"a cluster needs the extra `cluster`: {install('cluster')} ({error})") from None
    return distributed


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Pool]:
    """The workers of a scheduler of dask.distributed, such as ``tls://host:8786``.

    Whoever can connect to a scheduler without TLS can run code there, on its workers, and in this process: that is
    logged. For ``tls://``, certificates are those of dask's own configuration.

    Raises:
        LibraryError: dask.distributed is not installed.
        ParameterError: the address has another scheme.
        GazeboError: the scheduler cannot be reached, or there are no certificates for TLS.
    """
    distributed = _distributed()
    scheme = address.partition("://")[0] if "://" in address else "tcp"
    if scheme not in SCHEMES:
        raise ParameterError(
            f"the scheduler {address!r} begins with none of {', '.join(f'{one}://' for one in SCHEMES)}"
        )
    try:
        if scheme in WITH_TLS:
            if distributed.Security().get_connection_args("client")["ssl_context"] is None:
                raise GazeboError(
                    f"{address} needs certificates; dask's configuration names none (distributed.comm.tls)"
                )
        else:
            log.warning(
                "%s has no TLS: whoever can connect to it can run code on the scheduler, its workers and here; "
                "trust it only in a network that is yours, or use tls://",
                address,
            )
        client = distributed.Client(address, timeout=HANDSHAKE, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise GazeboError(f"cannot reach the scheduler {address!r}: {error}") from None
    try:
        yield _Cluster(client)
    finally:
        with contextlib.suppress(OSError, TimeoutError):
            client.close(timeout=5)
