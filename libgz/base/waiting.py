"""Waiting in parts: Python handles a signal that comes just before a wait only at its end."""

from __future__ import annotations

import threading

__all__ = ["PERIOD", "wait_for"]

PERIOD = 0.1  # [s] of a part at most


def wait_for(event: threading.Event) -> None:
    """Wait until an event is set."""
    while not event.wait(PERIOD):
        pass
