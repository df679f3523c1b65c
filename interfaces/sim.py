"""sim: the times of a simulation, and the commands pause, reset and save. Its id is always `default`."""

from __future__ import annotations

import functools
from typing import Any

from libgz.transport.interface import Interface
from libgz.transport.layout import BOTH, CLIENT, SERVER, Data, double, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "Sim",
    "SimData",
    "gz_sim_alloc",
    "gz_sim_close",
    "gz_sim_create",
    "gz_sim_destroy",
    "gz_sim_free",
    "gz_sim_lock",
    "gz_sim_open",
    "gz_sim_unlock",
]


@layout
class SimData(Data):
    """gz_sim_data_t."""

    sim_time: float = double(SERVER, "s", "sim time, pauses excluded")
    pause_time: float = double(SERVER, "s", "time spent paused: one step time for each paused step")
    real_time: float = double(SERVER, "s", "wall-clock time since the server started")
    pause: int = int32(BOTH, "", "1: paused; the server writes the worldfile's value at the start, then only reads")
    reset: int = int32(CLIENT, "", "1: reset all models to their initial poses; the server clears it")
    save: int = int32(CLIENT, "", "1: write the poses of top-level models to the worldfile; the server clears it")


class Sim(Interface[SimData]):
    """The simulation's times and commands."""

    type = "sim"
    data_class = SimData
    has_post = False

    @property
    def sim_time(self) -> float:
        """Sim time [s], pauses excluded."""
        return self.data.sim_time

    @property
    def pause_time(self) -> float:
        """Time spent paused [s]: one step time for each paused step."""
        return self.data.pause_time

    @property
    def real_time(self) -> float:
        """Wall-clock time since the server started [s]."""
        return self.data.real_time

    @property
    def paused(self) -> bool:
        """Whether the simulation is paused; can be set."""
        return bool(self.data.pause)

    @paused.setter
    def paused(self, value: bool) -> None:
        with self.locked() as data:
            data.pause = int(value)

    @property
    def gap(self) -> tuple[int, int]:
        """The bytes of real time, which is no state of a world."""
        return _place_of_real_time(self.layout)

    def reset(self) -> None:
        """Request that the server resets all models to their initial poses."""
        with self.locked() as data:
            data.reset = 1

    def save(self) -> None:
        """Request that the server writes the poses of all top-level models to the worldfile."""
        with self.locked() as data:
            data.save = 1


@functools.cache
def _place_of_real_time(layout: Any) -> tuple[int, int]:
    """Where the field real_time of a struct begins and ends [byte]."""
    field = layout.real_time  # ctypes' descriptor
    return field.offset, field.offset + field.size


_functions = LegacyFunctions(Sim)
gz_sim_alloc = _functions.alloc
gz_sim_free = _functions.free
gz_sim_create = _functions.create
gz_sim_destroy = _functions.destroy
gz_sim_open = _functions.open
gz_sim_close = _functions.close
gz_sim_lock = _functions.lock
gz_sim_unlock = _functions.unlock
