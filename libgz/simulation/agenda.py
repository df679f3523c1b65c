"""Agenda: changes of a world that are deferred while its lists are being iterated over."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from libgz.base.errors import USER_ERRORS, GazeboError, pass_interrupt
from libgz.physics.lock import WorldLock
from libgz.simulation.event import Owner, owner, report_failure
from libgz.simulation.repeated import repeated, running_tally
from libgz.transport.tally import Tally

__all__ = ["Agenda", "Hold"]

log = logging.getLogger("libgz.simulation")

# How often changes may lead to others, such as a model whose plugin adds a model, and to how many.
MOST_GENERATIONS, MOST_LED_TO = 100, 10_000


class Hold:
    """Holds changes back, `with` it."""

    __slots__ = ("_agenda", "_before")

    def __init__(self, agenda: Agenda) -> None:
        self._agenda, self._before = agenda, False

    def __enter__(self) -> None:
        agenda = self._agenda
        agenda.lock.acquire()
        self._before, agenda.holding = agenda.holding, True

    def __exit__(self, *_error: object) -> None:
        agenda = self._agenda
        try:
            agenda.end_hold(self._before)
        finally:
            agenda.lock.release()


class Agenda:
    """Defers what is asked for in a step, or while plugins load or are reset, until that is over.

    Args:
        lock: the world's; a step holds it, and so do all changes.

    Attributes:
        stepping: whether a step is under way.
        holding: whether lists of models or plugins are iterated over outside steps.
        awaited: what deferred actions wait for.
    """

    def __init__(self, lock: WorldLock) -> None:
        self.lock = lock
        self.stepping = self.holding = False
        self.deferred: list[tuple[Owner | None, Tally | None, Callable[[], object]]] = []
        self.awaited: list[Future[Any]] = []

    def after_step(self, action: Callable[[], object], awaited: Future[Any] | None = None) -> None:
        """Call `action` at once; if this thread runs a step or holds changes back, after that.

        While another thread steps, this one waits for the end of the step. A deferred action fails alone: the error is
        reported, with the plugin that asked for it, and the world continues.

        Args:
            action: is called.
            awaited: what it will wait for, so that worlds that step beside each other need not wait there.
        """
        with self.lock:
            if self.stepping or self.holding:
                self.deferred.append((owner.get(), running_tally(), action))
                if awaited is not None:
                    self.awaited.append(awaited)
                return
            with self.hold():
                action()

    def hold(self) -> Hold:
        """Hold changes back until the end; inside another hold or a step, until the end of that."""
        return Hold(self)

    def end_hold(self, before: bool) -> None:
        """Set `holding` to what it was before a hold, and do what was deferred; for a caller that holds the lock."""
        self.holding = before
        if self.deferred and not (before or self.stepping):
            self.act()

    def act(self) -> None:
        """Run the deferred actions, and those that they defer in turn, unless that has no end."""
        self.stepping = False
        self.awaited.clear()
        with self.hold():
            generation, left, led_to = 0, len(self.deferred), 0
            while self.deferred:
                if left <= 0:
                    generation, left = generation + 1, len(self.deferred)
                    led_to += left
                    if generation > MOST_GENERATIONS or led_to > MOST_LED_TO:
                        by, *_ = self.deferred[0]
                        self.deferred.clear()
                        log.error(
                            "%schanges lead to others without an end; what is left of them is not done",
                            f"{by}: " if by is not None else "",
                        )
                        break
                left -= 1
                by, tally, action = self.deferred.pop(0)
                with repeated(tally):
                    try:
                        action()
                    except GazeboError as error:
                        log.error("%s%s", f"{by}: " if by is not None else "", error)
                    except USER_ERRORS as error:
                        pass_interrupt(error)
                        report_failure(by, "a deferred change", error)
