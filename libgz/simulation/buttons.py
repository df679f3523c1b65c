"""Buttons: pause, reset and save, which clients press in a world's interface `sim`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.law import Number
from libgz.interfaces.sim import Sim
from libgz.simulation.exchange import Exchange
from libgz.transport.guard import Guard

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = ["Buttons"]

NAMES = ("pause", "reset", "save")


class Buttons:
    """What clients ask of a whole world, and whether it is paused.

    Args:
        world: whose they are.
    """

    _going = Number(1.0)  # 0: paused; for native code

    def __init__(self, world: World) -> None:
        self._world = world
        self._guard = Guard("sim.default")

    @property
    def _sim(self) -> Sim:
        return self._world.sim

    @property
    def paused(self) -> bool:
        """Whether the last step found the world paused."""
        return not self._going

    @paused.setter
    def paused(self, value: bool) -> None:
        self._going = float(not value)

    @property
    def pause(self) -> bool:
        """Whether the next step will find the world paused."""
        pressed = self._sim.data.pause
        return bool(pressed) if pressed in (0, 1) else self.paused

    def press_pause(self, value: bool) -> bool:
        """Pause the world or let it run, unless a client keeps the lock; whether that was a change."""
        sim = self._sim
        if not sim.lock():
            return False
        changed = bool(sim.data.pause) != value
        self.paused, sim.data.pause = value, int(value)
        sim.keep_commands()
        sim.unlock()
        return changed

    def read(self) -> bool:
        """Act on reset and save; whether the world is paused."""
        sim = self._sim
        if not sim.lock():
            return self.paused
        data, reset, save = sim.data, False, False
        switch = self._guard.switch
        pause, paused = data.pause, self.paused
        if pause != paused:
            paused = self.paused = switch("pause", pause, paused)
        if pause != paused:  # then the buttons beside it mean nothing, either
            data.pause, data.reset, data.save = int(paused), 0, 0
        elif data.reset or data.save:
            reset, save = switch("reset", data.reset, False), switch("save", data.save, False)
            data.reset = data.save = 0
        sim.unlock()
        world = self._world
        if reset:
            world.after_step(lambda: world.era.press_reset(world))
        if save:
            world.Save()
        return self.paused

    def exchange(self) -> Exchange:
        """Native code's part of `read`: it runs as long as nobody presses a button."""
        exchange = Exchange(self._sim)
        if self._sim.link.memory:
            exchange.need(self, "_going")  # a paused world stays so while a client keeps the lock
            for i, name in enumerate(NAMES):  # beside an invalid pause, the others mean nothing
                exchange.switch(name, self._guard.switch_record(name), 1 if i else len(NAMES))
        return exchange
