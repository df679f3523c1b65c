"""Crew: native threads that do the rows of many worlds beside each other, while Python prepares the next."""

from __future__ import annotations

import ctypes
import operator
import os
import threading
import weakref
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, wait
from contextlib import contextmanager
from ctypes import c_void_p
from functools import partial
from typing import Any, TypeVar

from libgz.base.errors import USER_ERRORS, GazeboError, LibraryError, ParameterError, pass_interrupt
from libgz.base.records import JobRecord
from libgz.ode.lib import ode
from libgz.ode.step import library_path

__all__ = ["Crew", "Task"]

MOST_THREADS = 256

T = TypeVar("T")
# Resumed when the job of native code is done that it yields, or what it awaits.
Task = Generator["JobRecord | Future[Any]", None, T]


class Crew:
    """Threads that do jobs of native code.

    The thread that calls `run` does jobs, too, so that a crew of one has no other. They start when they are needed. A
    child process that was forked has none of its parent's, and starts its own.

    Args:
        threads: how many there are, with the calling one; None for one a core.
        most: of them that have something to do.

    Attributes:
        threads: how many there are, with the calling one.

    Raises:
        ParameterError: the number of threads is not 1 to 256.
    """

    def __init__(self, threads: int | None, most: int) -> None:
        wanted = min(len(os.sched_getaffinity(0)), MOST_THREADS) if threads is None else operator.index(threads)
        if not 1 <= wanted <= MOST_THREADS:
            raise ParameterError(f"threads is {wanted}; allowed are 1 to {MOST_THREADS}, and None for one a core")
        self.threads = max(1, min(wanted, most))
        self._native: _Threads | None = None
        self._locks: dict[int, threading.Lock] = {}  # by process: a child may be forked while a thread holds one
        self._runner = 0  # the thread that holds it

    @contextmanager
    def _alone(self, wait: bool) -> Iterator[None]:
        """Be the only one that uses the threads: they give each job back to whoever asks next."""
        lock = self._locks.setdefault(os.getpid(), threading.Lock())
        if self._runner == threading.get_ident():
            raise GazeboError("the threads step already; what a step calls cannot step or close all worlds")
        if not lock.acquire(blocking=wait):
            raise GazeboError("the threads step already, for another thread of the program; step in one at a time")
        try:
            self._runner = threading.get_ident()
            yield
        finally:
            self._runner = 0
            lock.release()

    def run(self, tasks: Sequence[Task[T]], order: Sequence[int] | None = None) -> list[T | BaseException]:
        """Run tasks beside each other: jobs in all threads, and what they do themselves in this one.

        Args:
            tasks: what is to be run.
            order: the numbers of the tasks as they begin; None for one after the other.

        Returns:
            What each returned, or the exception that it raised.

        Raises:
            GazeboError: they run tasks already.
            LibraryError: there is no memory for the threads.
        """
        with self._alone(wait=False):
            return self._run(tasks, range(len(tasks)) if order is None else order)

    def _run(self, tasks: Sequence[Task[T]], order: Sequence[int]) -> list[T | BaseException]:
        native = self._native
        if native is None or native.process != os.getpid():
            native = self._native = _Threads(self.threads)
        outcomes: list[Any] = [None] * len(tasks)
        under_way: dict[int, int] = {}  # the number of the task by the address of its job
        awaiting: deque[tuple[int, Future[Any]]] = deque()  # the numbers of others, and what they wait for
        add, following, address_of = native.add, native.next, ctypes.addressof

        def advance(number: int) -> None:
            try:
                job = next(tasks[number])
            except StopIteration as end:
                outcomes[number] = end.value
            except USER_ERRORS as error:
                pass_interrupt(error)
                outcomes[number] = error
            else:
                if isinstance(job, Future):
                    awaiting.append((number, job))
                    return
                address = address_of(job)
                under_way[address] = number
                add(address)

        try:
            for number in order:
                advance(number)
            while under_way or awaiting:
                if awaiting and (not under_way or awaiting[0][1].done()):
                    number, awaited = awaiting.popleft()
                    wait([awaited])
                    advance(number)
                elif job := following():
                    advance(under_way.pop(job))
        finally:  # after Ctrl-C, which may come while a job is given back, threads still step
            while following():
                pass
            for task in tasks:
                task.close()
        return outcomes

    def close(self) -> None:
        """End the threads, after their tasks; `run` starts new ones. Can be called twice.

        Raises:
            GazeboError: a task itself does it.
        """
        with self._alone(wait=True):
            if self._native is not None:
                self._native.close()
                self._native = None


class _Threads:
    """The threads of one process; see crew.c.

    Attributes:
        add: have a job done, by its address; who adds it keeps it until `next` has returned it.
        next: the address of a job that is done, of those that were added and not returned; None without any.
    """

    def __init__(self, count: int) -> None:
        path, self.process = str(library_path()), os.getpid()
        library, short = ctypes.CDLL(path), ctypes.PyDLL(path)  # which keeps the interpreter lock
        library.gz_crew_new.restype = library.gz_crew_next.restype = c_void_p
        found = library.gz_crew_new()
        if not found:
            raise LibraryError("there is no memory for threads that step worlds")
        address = c_void_p(found)
        short.gz_crew_add.argtypes = (c_void_p, c_void_p)
        self.add: Callable[[int], object] = partial(short.gz_crew_add, address)
        self.next: Callable[[], int | None] = partial(library.gz_crew_next, address)
        workers = [
            threading.Thread(target=_work, args=(library, address), name=f"libgz crew {number}", daemon=True)
            for number in range(1, count)
        ]
        for worker in workers:
            worker.start()
        self.close = weakref.finalize(self, _end, library, address, workers, self.process)
        self.close.atexit = False  # the threads end with the process


def _work(library: ctypes.CDLL, address: c_void_p) -> None:
    ode().ensure_thread()
    library.gz_crew_work(address)


def _end(library: ctypes.CDLL, address: c_void_p, workers: list[threading.Thread], process: int) -> None:
    if os.getpid() != process:
        return  # a thread that this process does not have may hold its lock
    library.gz_crew_end(address)
    for worker in workers:
        worker.join()
    library.gz_crew_free(address)
