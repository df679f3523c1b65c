"""Watchdog: ends a process whose step does not return, and reports steps that take long."""

from __future__ import annotations

import contextlib
import logging
import os
import select
import signal
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Any

from libgz.base.errors import Interrupted
from libgz.physics.lock import LONG
from libgz.simulation.running_code import describe_thread, describe_users
from libgz.transport.ending import Relay

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = ["Watchdog"]

log = logging.getLogger("libgz.simulation")

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PERIOD = 0.5  # [s] between two looks at the step
PATIENCE = 1.0  # [s] after the first signal, until the user is reminded of the second
GRACE = 0.3  # [s] that a run which is ending has after the second signal
REMOVAL = 10.0  # [s] at most for the removal of files, which waits for nothing: the machine may be busy
_CLOSE = b"\0"  # no signal has this number


class Watchdog:
    """Handles signals of a command that runs a world, in a thread of its own, from `__enter__` to `__exit__`.

    The first signal asks the run to end after the present step; in a `with` block of `loading` it raises. Python runs
    signal handlers between two bytecodes of the main thread, so not while a native function runs: the second signal is
    handled by the watchdog's thread, which removes the server's files and semaphores and ends the process, with exit
    code 128 plus the signal's number.

    A step that takes more than 5 s is reported once, with what runs in it. Steps cost nothing: the thread looks at the
    world twice a second. Code that keeps the interpreter lock, as some native functions do, stops the watchdog, too;
    then native code handles the second signal (`libgz.transport.ending`). It also reports such code after 5 s.

    Python ends after all threads that are no daemons; those of plugins for which it waits 5 s are reported.

    A SIGHUP that is ignored, as under `nohup`, stays ignored.

    Args:
        stop: called with the number of each signal, in the main thread.
        world: the world that the process serves; None if there is none yet.

    Attributes:
        world: the world.
    """

    def __init__(self, stop: Callable[[int], object], world: World | None = None) -> None:
        self.world = world
        self._stop = stop
        self._handled = 0  # the last signal
        self._loading = False
        self._incomplete = False  # a signal ended the load of the world
        self._signals: list[int] = []
        self._first = 0.0  # when the first signal came
        self._step: object = None
        self._since = 0.0
        self._reported = False
        self._described: set[str] = set()
        self._ended = threading.Event()
        self._reader = self._writer = -1
        self._replaced: dict[int, Any] = {}
        self._replaced_wakeup = -1

    def __enter__(self) -> Watchdog:
        self._before = set(threading.enumerate())
        self._reader, self._writer = os.pipe()
        os.set_blocking(self._writer, False)
        self._replaced_wakeup = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        handled = [n for n in SIGNALS if n != signal.SIGHUP or signal.getsignal(n) is not signal.SIG_IGN]
        self._replaced = {number: signal.signal(number, self._handle) for number in handled}
        _active.add(self)
        self._relay = Relay(self._reader)
        self._thread = threading.Thread(target=self._run, args=(self._relay,), name="watchdog", daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        started = [thread for thread in set(threading.enumerate()) - self._before if not thread.daemon]
        if started:
            threading.Thread(target=_report_threads, args=(started,), name="end", daemon=True).start()
        for number, handler in self._replaced.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._replaced_wakeup)
        _active.discard(self)
        self._ended.set()
        with contextlib.suppress(OSError):
            os.write(self._writer, _CLOSE)
        self._thread.join(1.0)
        if not self._thread.is_alive():
            self._relay.close()
            os.close(self._reader)
            os.close(self._writer)

    def _handle(self, number: int, _frame: FrameType | None) -> None:
        self._handled = number
        self._stop(number)
        if self._loading:
            raise Interrupted(number)

    @contextlib.contextmanager
    def loading(self) -> Iterator[None]:
        """For a `with` block that loads a world, which is not asked whether to stop: a signal ends it.

        Raises:
            Interrupted: there was a signal, in the block or before it.
        """
        self._loading = True
        try:
            self._raise_handled()
            yield
            self._raise_handled()  # where Python ignored what the handler raised, as in a `__del__`
        except Interrupted:
            self._incomplete = True
            raise
        finally:
            self._loading = False

    def close(self) -> None:
        """Close the world. What a signal left incomplete while it was loaded may not be closable, and is left."""
        if self.world is None:
            return
        try:
            self.world.close()
        except Exception:
            if not self._incomplete:
                raise

    def _raise_handled(self) -> None:
        if self._handled:
            raise Interrupted(self._handled)

    def leave(self) -> None:
        """In a forked child: do not pass its signals to the parent's watchdog."""
        signal.set_wakeup_fd(-1)

    # The thread ------------------------------------------------------------------------------------------------------

    def _run(self, relay: Relay) -> None:
        poll = select.poll()
        poll.register(relay.reader, select.POLLIN)
        while not self._ended.is_set():
            received = os.read(relay.reader, 64) if poll.poll(PERIOD * 1000.0) else b""
            relay.beat()
            for number in received:
                if number in SIGNALS:
                    self._signals.append(number)
                    self._first = self._first or time.monotonic()
            if len(self._signals) > 1 and not self._ended.wait(GRACE):
                self._end_process(self._signals[1])
            self._remind()
            self._look()

    def _end_process(self, number: int) -> None:
        """Remove what other processes see of a server, and end without waiting for any other thread."""
        removed = threading.Event()
        # In a thread, for messages may wait for a stream that nobody reads.
        last = threading.Thread(target=self._clean_up, args=(signal.Signals(number).name, removed), daemon=True)
        last.start()
        removed.wait(REMOVAL)
        last.join(GRACE)
        os._exit(128 + number)

    def _clean_up(self, name: str, removed: threading.Event) -> None:
        if self.world is not None:
            with contextlib.suppress(Exception):  # the process must end
                self.world.gz_server.vanish()
        removed.set()
        log.error("ended at once: second signal, %s", name)

    def _remind(self) -> None:
        if len(self._signals) == 1 and time.monotonic() >= self._first + PATIENCE:
            self._first = float("inf")
            log.warning("still waiting for %s to end; a second signal ends the process at once", self._present())

    def _present(self) -> str:
        """What a run that is to end still does."""
        if self._step is not None:
            return f"the present step, {self._running()},"
        return describe_users(threading.main_thread().ident or 0) or "the run"

    def _look(self) -> None:
        """Report the present step if it takes long, once."""
        step, now = None if self.world is None else self.world.present_step, time.monotonic()
        if step is None or step != self._step:
            self._step, self._since, self._reported = step, now, False
        elif not self._reported and now - self._since >= LONG:
            self._reported = True
            running = self._running()
            if running not in self._described:
                self._described.add(running)
                log.warning("step %d takes more than %g s; running is %s", step[0], LONG, running)

    def _running(self) -> str:
        return describe_thread(self.world.lock.holder) if self.world is not None else ""


def _report_threads(threads: list[threading.Thread]) -> None:
    """Report threads that Python waits for, some seconds after the main thread has ended."""
    time.sleep(LONG)
    for thread in () if threading.main_thread().is_alive() else threads:
        if thread.is_alive():
            running = describe_thread(thread.ident or 0)
            log.warning("still waiting for thread %r to end: %s; a signal ends the process", thread.name, running)


_active: set[Watchdog] = set()


def _leave_all() -> None:
    for watchdog in _active:
        watchdog.leave()


os.register_at_fork(after_in_child=_leave_all)
