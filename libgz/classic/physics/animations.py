"""Animations: models and joints that are moved along key frames by sim time."""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from libgz.classic.common import NumericAnimation, PoseAnimation
from libgz.classic.math import Pose3d
from libgz.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.simulation.event import Callback

if TYPE_CHECKING:
    from libgz.classic.physics.base import Entity
    from libgz.classic.physics.model import Model
    from libgz.classic.physics.world import World

__all__ = ["Animations"]

log = logging.getLogger("libgz.classic")

A = TypeVar("A", PoseAnimation, NumericAnimation)


class _Run:
    """An animation under way.

    Args:
        now: sim time [s].
        play: goes on by some seconds; whether that was the end.
        done: what to call at the end.
    """

    def __init__(self, now: float, play: Callable[[float], bool], done: Callback | None) -> None:
        self._last, self._play, self._done = now, play, done

    def go_on(self, now: float) -> bool:
        """Move on to a sim time [s]; whether it is over."""
        passed, self._last = max(0.0, now - self._last), now
        return self._play(passed)

    def finish(self) -> None:
        """Tell that it is over."""
        if self._done is not None:
            self._done()


class Animations:
    """The animations that run in a world."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._runs: dict[tuple[Entity, str], _Run] = {}

    def start(self, entity: Entity, animation: PoseAnimation, done: Callable[[], object] | None) -> None:
        """Move an entity along poses in what it is a part of.

        Raises:
            ParameterError: it is no PoseAnimation, or `done` cannot be called.
        """
        self._start(entity, "pose", partial(_move, entity, _checked(animation, PoseAnimation)), done)

    def start_joints(
        self, model: Model, animations: dict[str, NumericAnimation], done: Callable[[], object] | None
    ) -> None:
        """Move joints of a model, by name.

        Raises:
            ParameterError: one is no NumericAnimation, or `done` cannot be called.
        """
        rows = {name: _checked(animation, NumericAnimation) for name, animation in dict(animations).items()}
        self._start(model, "joints", partial(_move_joints, model, rows), done)

    def _start(
        self, entity: Entity, what: str, play: Callable[[float], bool], done: Callable[[], object] | None
    ) -> None:
        call = Callback(f"the end of the animation of {entity.GetScopedName()}", done) if done is not None else None
        self._runs[entity, what] = _Run(self._world.core.GetSimTime(), play, call)

    def stop(self, entity: Entity) -> None:
        """Leave an entity and its joints where they are."""
        for what in ("pose", "joints"):
            self._runs.pop((entity, what), None)

    def update(self) -> None:
        """Move everything on to the present sim time; an animation that leads nowhere is told of, and ends."""
        now = self._world.core.GetSimTime()
        for key, run in list(self._runs.items()):
            if self._runs.get(key) is not run:  # the end of another has stopped or replaced it
                continue
            try:
                over = run.go_on(now)
            except GazeboError as error:
                log.error("the animation of %s ends: %s", key[0].GetScopedName(), error)
                del self._runs[key]
                continue
            if over:
                del self._runs[key]
                run.finish()


def _checked(animation: A, kind: type[A]) -> A:
    if not isinstance(animation, kind):
        raise ParameterError(f"{animation!r} is no {kind.__name__}")
    return animation


def _move(entity: Entity, animation: PoseAnimation, seconds: float) -> bool:
    over = _advance(animation, seconds)
    frame = animation.GetInterpolatedKeyFrame()
    entity.SetRelativePose(Pose3d(frame.Translation(), frame.Rotation()))
    return over


def _move_joints(model: Model, animations: dict[str, NumericAnimation], seconds: float) -> bool:
    controller = model.GetJointController()
    for name in animations:
        if controller.scoped_name(name) is None:
            raise NotFoundError(f"there is no joint {name!r}{nearest(name, controller.GetJoints())}")
    over = [_advance(animation, seconds) for animation in animations.values()]
    model.SetJointPositions({name: one.GetInterpolatedKeyFrame().Value() for name, one in animations.items()})
    return all(over)


def _advance(animation: PoseAnimation | NumericAnimation, seconds: float) -> bool:
    """Let time pass; whether the animation is over."""
    before = animation.GetTime()
    animation.AddTime(seconds)
    return not animation.repeat and before + seconds >= animation.GetLength()
