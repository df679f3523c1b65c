"""Log slider: shows where a log that is played is, and takes users there."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping
from typing import Any

import viser

__all__ = ["LogSlider"]

HOLD = 0.5  # [s] the slider is the user's after each of his moves


class LogSlider:
    """The slider of a log's time.

    A status that was asked for before a user's move would put the slider back, and viser would then take the user's
    next move to that place for no move. So moves are numbered, and a status is shown only if it has seen all of them.

    Args:
        page: the page's server.
        do: called with a function for each move, to be called between two frames.
        seek: called with the time that a user wants [s].
    """

    def __init__(
        self,
        page: viser.ViserServer,
        do: Callable[[Callable[[], object]], None],
        seek: Callable[[float], object],
    ) -> None:
        self._page, self._seek = page, seek
        self._moves = 0  # of users; counted and compared in the page's thread only
        self._seen = 0  # the last move after which something was shown
        self._until = 0.0  # the time until which the slider is the user's
        self.moves = 0
        """The number of the last move that was passed on."""
        self._handle = page.gui.add_slider("Log [s]", min=0.0, max=1.0, step=0.01, initial_value=0.0)

        async def changed(event: Any) -> None:
            if event.client_id is not None:
                self._moves += 1
                self._until = time.monotonic() + HOLD
                number, value = self._moves, event.target.value
                do(lambda: self._pass_on(number, value))

        self._handle.on_update(changed)

    def _pass_on(self, number: int, moment: float) -> None:
        self.moves = number
        self._seek(moment)

    def show(self, status: Mapping[str, Any], moves: int) -> None:
        """Show where the log is.

        Args:
            status: the log's `begin`, `end` and `time` [s].
            moves: the value of `moves` when the status was asked for; an older one than the last move is not shown.
        """
        with contextlib.suppress(RuntimeError):  # the page has ended
            self._page.get_event_loop().call_soon_threadsafe(self._show, status, moves)

    def _show(self, status: Mapping[str, Any], moves: int) -> None:
        if moves != self._moves or time.monotonic() < self._until:
            return
        slider: Any = self._handle
        begin, end = float(status["begin"]), max(float(status["end"]), float(status["begin"]) + 0.01)
        if (slider.min, slider.max) != (begin, end):
            slider.min, slider.max = begin, end
        here = round(min(max(float(status["time"]), begin), end), 2)
        if self._seen != moves:
            # A value that was on its way to the page while the user moved the slider put it back there, but not here.
            # So the present one is sent even if it is known here; viser sends changes only.
            self._seen = moves
            slider.value = end if here == begin else begin
        slider.value = here
