"""Companion: what runs beside a world and is built on it, such as the sensors and plugins of Gazebo classic."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from libgz.simulation.entity import Entity
    from libgz.simulation.plan import Plan

__all__ = ["Companion", "Stateless"]


class Companion(Protocol):
    """What a world notifies of its events."""

    def start(self) -> None:
        """All entities are loaded and initialized."""

    def model_added(self, model: Entity) -> None:
        """An entity was built; while a world loads, others may still follow."""

    def model_removed(self, model: Entity) -> None:
        """An entity was taken off the world's lists; its bodies still exist."""

    def idle_until(self) -> float:
        """The sim time [s] up to which steps need nothing of it: `prepare`, `update` and `step` are not called before.

        -inf: the next one needs it. Asked before and in steps; what happens meanwhile may make it earlier.
        """

    def skipped(self) -> None:
        """Steps have been made without it."""

    def returned(self) -> None:
        """One step or more are over, however they were made."""

    def prepare(self) -> None:
        """Entities have been updated, and what `plan_update` added comes next."""

    def plan_update(self, plan: Plan) -> None:
        """Add what it does in each step ahead of `update`. Where that changes, the rows of the world have to."""

    def plan_end(self, plan: Plan) -> None:
        """Add the laws of the end of steps that are made without it. Where these change, the world's rows have to."""

    def update(self) -> None:
        """Sim time has grown, entities and what `plan_update` added have been updated, physics comes next."""

    def step(self, paused: bool) -> None:
        """A step is over."""

    def reset(self) -> None:
        """Clock and entities were reset."""

    def loads_plugins(self, state: Any) -> bool:
        """Whether plugins must be loaded again for a state: on entities as their files have them."""

    def entities_rebuilt(self, state: Any) -> None:
        """The entities of a state are there, some of them built again; their states come next."""

    def reseed(self, seed: int) -> None:
        """Begin the random numbers of a world that was made with this seed."""

    def get_state(self) -> object:
        """Its own state as plain data, for `World.get_state`; None if it has none."""

    def check_state(self) -> None:
        """Find out which of its parts keeps its state from being encoded.

        Raises:
            ParameterError: there is one, which is named.
        """

    def set_state(self, state: Any) -> bool:
        """Take a state that `get_state` returned, or None. Entities may have been built again just before.

        Returns:
            Whether plugins came or went: these may have changed anything, so that all is to be set once more.
        """

    def close(self) -> None:
        """The world ends; its entities still exist."""


class Stateless:
    """What is common to companions that are no part of a world's state, such as logs: they continue as they were."""

    def idle_until(self) -> float:
        """-inf: it has something to do in each step."""
        return -math.inf

    def skipped(self) -> None:
        """Nothing to do."""

    def returned(self) -> None:
        """Nothing to do."""

    def prepare(self) -> None:
        """Nothing to do."""

    def plan_update(self, plan: Plan) -> None:
        """Nothing to add."""

    def plan_end(self, plan: Plan) -> None:
        """Nothing to add."""

    def reseed(self, seed: int) -> None:
        """Nothing to do."""

    def loads_plugins(self, state: object) -> bool:
        """False: it has no plugins."""
        return False

    def entities_rebuilt(self, state: object) -> None:
        """Nothing to do."""

    def get_state(self) -> object:
        """None: it has no state."""
        return None

    def check_state(self) -> None:
        """Nothing to do."""

    def set_state(self, state: object) -> bool:
        """False: no plugins came or went."""
        return False
