"""How models create their interfaces, and what they remember of clients' commands."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Sequence
from typing import Any

from libgz.base.law import Number
from libgz.base.records import numbers
from libgz.legacy.model import Model
from libgz.simulation.exchange import Exchange
from libgz.transport.interface import Interface

__all__ = ["Seen", "serve"]


class Seen:
    """The numbers that a client wrote, valid or not, when a command followed from them; also for native updates.

    They are settled until the command is set otherwise.
    """

    settled = Number()  # whether the command follows from the numbers: 1 or 0

    def __init__(self, count: int) -> None:
        self.numbers = numbers(count)()

    def note(self, wishes: Sequence[float], settled: bool = True) -> None:
        """Keep what a client wrote."""
        self.numbers[: len(wishes)] = wishes
        self.settled = settled

    def expect(self, exchange: Exchange, fields: Iterable[tuple[str, int]]) -> None:
        """Make it a condition of an exchange that the client wrote nothing else in these fields: name and index."""
        exchange.need(self, "settled")
        for number, (name, index) in enumerate(fields):
            exchange.expect(name, index, ctypes.c_double.from_buffer(self.numbers, 8 * number))


def serve(model: Model, interface: Interface[Any]) -> None:
    """Create an interface under the model's id on the server of its world.

    Raises:
        InterfaceError: the id is invalid, or the interface's file cannot be created.
    """
    interface.create(model.world.gz_server, model.GetId(), model.GetName(), model.GetIntId(), model.GetParentIntId())
