"""SampleInterface: the base of interfaces whose data carry the sim time of their sample."""

from __future__ import annotations

from typing import TypeVar

from libgz.transport.interface import Interface
from libgz.transport.layout import Data

__all__ = ["SampleData", "SampleInterface"]

S = TypeVar("S", bound="SampleData")


class SampleData(Data):
    """Base of the structs whose first field after the head is `time`; each declares it itself."""

    __slots__ = ()

    time: float


class SampleInterface(Interface[S]):
    """An interface whose server writes samples, each with the sim time at which it was taken."""

    @property
    def time(self) -> float:
        """Sim time of the latest sample [s]."""
        return self.data.time
