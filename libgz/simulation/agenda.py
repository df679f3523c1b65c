"""Agenda: changes of a world that wait until nobody walks the lists that they change."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from libgz.errors import GazeboError
from libgz.simulation.event import Owner, owner, report_failure

__all__ = ["Agenda"]

log = logging.getLogger("libgz.simulation")


class Agenda:
    """Base of World: what is asked for in a step, or while plugins load or are reset, is done after it."""

    def __init__(self) -> None:
        self._stepping = False  # whether a step is under way
        self._holding = False  # whether lists of models or plugins are walked outside steps
        self._afterwards: list[tuple[Owner | None, Callable[[], object]]] = []

    def after_step(self, action: Callable[[], object]) -> None:
        """Call `action` at once; if a step is running or changes are held back, after that.

        What is asked for later fails alone: it is reported, with the plugin that asked, and the world goes on.
        """
        if self._stepping or self._holding:
            self._afterwards.append((owner.get(), action))
            return
        with self.hold():
            action()

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Hold changes back until the end; inside another hold or a step, until the end of that."""
        before, self._holding = self._holding, True
        try:
            yield
        finally:
            self._holding = before
            if self._afterwards and not (before or self._stepping):
                self.act()

    def act(self) -> None:
        """Do what has been waiting, and what is asked for meanwhile."""
        self._stepping = False
        with self.hold():
            while self._afterwards:
                by, action = self._afterwards.pop(0)
                try:
                    action()
                except GazeboError as error:
                    log.error("%s%s", f"{by}: " if by is not None else "", error)
                except Exception as error:  # noqa: BLE001 - a plugin may ask for anything
                    report_failure(by, "what was to be done after a step", error)
