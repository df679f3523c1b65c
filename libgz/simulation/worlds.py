"""Worlds: many worlds that step beside each other, on all cores."""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Iterator, Sequence
from typing import Generic, TypeVar, overload

from libgz.base.closing import Closing
from libgz.base.errors import ClosedError, GazeboError, ParameterError
from libgz.ode.crew import Crew
from libgz.simulation.world import World

__all__ = ["Worlds"]

W = TypeVar("W", bound=World)

_taken: weakref.WeakSet[World] = weakref.WeakSet()  # worlds of some Worlds: they would wait for each other's locks


class Worlds(Closing, Sequence[W], Generic[W]):
    """Worlds that step together, each on a core that is free.

    ::

        with libgz.Worlds(libgz.World.from_file("pioneer2at", seed=seed) for seed in range(64)) as worlds:
            worlds.step(1000)
            print([world.model("robot1").GetPose() for world in worlds])

    Native code runs in several threads, without the interpreter lock; what a world needs of Python, such as plugins and
    callbacks, is done by the calling thread, one world after the other. Each world does what it would do alone, to the
    bit, with any number of threads. Worlds with meshes or height fields collide one at a time, and the quick solver
    iterates for one at a time: ODE has common memory and random numbers for these.

    It is a sequence of its worlds, which may be used by themselves, too. Closing it closes them.

    Args:
        worlds: that are ready to step.
        threads: how many step, with the calling one; None for one a core.

    Raises:
        ParameterError: there is no world, one of them is there twice or in other `Worlds`, or the number of threads is
            not 1 to 256.
        ClosedError: a world is closed.
    """

    def __init__(self, worlds: Iterable[W], threads: int | None = None) -> None:
        self._worlds = tuple(worlds)
        if not self._worlds:
            raise ParameterError("there is no world to step; give at least one")
        before: set[W] = set()
        for number, world in enumerate(self._worlds):
            if world in before:
                raise ParameterError(f"world {number} is there twice; give a world of its own, such as world.clone()")
            before.add(world)
            if world in _taken:
                raise ParameterError(f"world {number} is one of other Worlds already")
        self._check_ready()
        self._crew = Crew(threads, len(self._worlds))
        _taken.update(self._worlds)

    @property
    def threads(self) -> int:
        """How many threads step, with the calling one."""
        return self._crew.threads

    def __len__(self) -> int:
        return len(self._worlds)

    @overload
    def __getitem__(self, index: int) -> W: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[W, ...]: ...
    def __getitem__(self, index: int | slice) -> W | tuple[W, ...]:
        """One world, or several."""
        return self._worlds[index]

    def __iter__(self) -> Iterator[W]:
        return iter(self._worlds)

    def step(self, count: int = 1) -> None:
        """Run `count` steps of each world, as fast as possible.

        Where a step of a world raises, that world ends there; the others make all their steps before the first such
        error is raised.

        Raises:
            ClosedError: a world was closed; none has made a step then.
            GazeboError: the step of a world failed; the message has its number, and the cause is its error. Or another
                thread steps them already, or what a step calls does it.
        """
        self._check_ready()
        for number, outcome in enumerate(self._crew.run([world.step_beside(count) for world in self._worlds])):
            if outcome is not None:
                raise GazeboError(f"world {number} of {len(self)}: {outcome}") from outcome

    def close(self) -> None:
        """Close all worlds, and end the threads; waits for a step in another thread. Can be called twice.

        Raises:
            GazeboError: what a step calls does it.
        """
        self._crew.close()
        for world in self._worlds:
            _taken.discard(world)
            world.close()

    def _check_ready(self) -> None:
        for number, world in enumerate(self._worlds):
            if not world.clock.running:
                raise ClosedError(f"world {number} of {len(self._worlds)} is closed, or was not initialized")
