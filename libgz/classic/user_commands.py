"""UserCommands: what users do in a client's window, and how it is undone and done again."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from libgz.base.errors import GazeboError, ParameterError
from libgz.classic import msgs
from libgz.classic.physics.world import World

__all__ = ["Handlers", "UserCommands"]

MOST = 100  # commands that can be undone
MOST_BYTES = 256 << 20  # of their states


class Handlers(NamedTuple):
    """What carries out the parts of a command."""

    model: Callable[[Any], None]
    light: Callable[[Any], None]
    world_control: Callable[[Any], None]
    wrench: Callable[[str, Any], None]


@dataclass(eq=False, repr=False)
class _Command:
    """A command that was carried out."""

    message: Any
    before: bytes  # state of the world
    after: bytes = b""  # at its last undo


class UserCommands:
    """Carries out commands of ~/user_cmd, undoes and repeats them by ~/undo_redo, and lists them on ~/user_cmd_stats.

    An undo brings the whole world into its state before the command, as classic did; the pause stays.

    Args:
        world: the world.
        handlers: carry out commands.
        publish: publishes a UserCmdStats.
    """

    def __init__(self, world: World, handlers: Handlers, publish: Callable[[Any], object]) -> None:
        self._world, self._handlers, self._publish = world, handlers, publish
        self._numbers = itertools.count()
        self._done: deque[_Command] = deque(maxlen=MOST)
        self._undone: list[_Command] = []

    def carry_out(self, message: Any) -> None:
        """Do what a UserCmd says; between two steps.

        Raises:
            GazeboError: it cannot be done.
        """
        kinds = type(message)
        numbered = kinds()
        numbered.CopyFrom(message)
        numbered.id = next(self._numbers)
        before = self._world.core.snapshots.save()
        if message.type in (kinds.MOVING, kinds.SCALING):
            for model in message.model:
                self._handlers.model(model)
            for light in message.light:
                self._handlers.light(light)
        elif message.type == kinds.WORLD_CONTROL:
            self._handlers.world_control(message.world_control)
        else:
            self._handlers.wrench(message.entity_name, message.wrench)
        self._done.append(_Command(numbered, before))
        self._undone.clear()
        while len(self._done) > 1 and sum(len(one.before) for one in self._done) > MOST_BYTES:
            self._done.popleft()
        self._publish_lists()

    def undo_redo(self, message: Any) -> None:
        """Undo or repeat the last command, or all up to the one whose id is given; between two steps.

        Raises:
            ParameterError: there is no such command.
            GazeboError: the world cannot be brought into that state.
        """
        undo = message.undo
        source: deque[_Command] | list[_Command] = self._done if undo else self._undone
        target: deque[_Command] | list[_Command] = self._undone if undo else self._done
        what = "undone" if undo else "repeated"
        if not source:
            raise ParameterError(f"no command can be {what}")
        numbers = [one.message.id for one in source]
        wanted = message.id if message.HasField("id") else numbers[-1]
        if wanted not in numbers:
            raise ParameterError(f"command {wanted} cannot be {what}; those that can are {numbers}")
        now = self._world.core.snapshots.save()
        self._restore(source[numbers.index(wanted)].before if undo else source[numbers.index(wanted)].after)
        later = now
        while True:
            command = source.pop()
            if undo:  # each ends where the next one began
                command.after, later = later, command.before
            target.append(command)
            if command.message.id == wanted:
                break
        self._publish_lists()

    def _restore(self, state: bytes) -> None:
        core = self._world.core
        paused = core.paused
        try:
            core.snapshots.restore(state)
        except GazeboError:
            self._done.clear()
            self._undone.clear()
            self._publish_lists()
            raise
        core.paused = paused

    def _publish_lists(self) -> None:
        message = msgs.UserCmdStats(undo_cmd_count=len(self._done), redo_cmd_count=len(self._undone))
        message.undo_cmd.extend(one.message for one in self._done)
        message.redo_cmd.extend(one.message for one in self._undone)
        self._publish(message)
