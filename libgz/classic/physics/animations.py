"""Animations: key frame animations of entities and joints, in sim time."""

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
    from libgz.classic.physics.world import Model, World

__all__ = ["Animations"]

log = logging.getLogger("libgz.classic")

A = TypeVar("A", PoseAnimation, NumericAnimation)


class _Run:
    """A running animation.

    Args:
        now: sim time [s].
        play: advances the animation by a time [s]; returns whether it has ended.
        done: called at the end.
    """

    def __init__(self, now: float, play: Callable[[float], bool], done: Callback | None) -> None:
        self._last, self._play, self._done = now, play, done

    def advance(self, now: float) -> bool:
        """Advance to a sim time [s]; returns whether it has ended."""
        passed, self._last = max(0.0, now - self._last), now
        return self._play(passed)

    def finish(self) -> None:
        """Call the callback of the end."""
        if self._done is not None:
            self._done()


class Animations:
    """The running animations of a world."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._runs: dict[tuple[Entity, str], _Run] = {}

    def start(self, entity: Entity, animation: PoseAnimation, done: Callable[[], object] | None) -> None:
        """Play an animation of an entity's pose relative to its parent.

        Raises:
            ParameterError: it is not a PoseAnimation, or `done` cannot be called.
        """
        self._start(entity, "pose", partial(_move, entity, _checked(animation, PoseAnimation)), done)

    def start_joints(
        self, model: Model, animations: dict[str, NumericAnimation], done: Callable[[], object] | None
    ) -> None:
        """Play animations of joint positions of a model, by joint name.

        Raises:
            ParameterError: one is not a NumericAnimation, or `done` cannot be called.
        """
        rows = {name: _checked(animation, NumericAnimation) for name, animation in dict(animations).items()}
        self._start(model, "joints", partial(_move_joints, model, rows), done)

    def _start(
        self, entity: Entity, what: str, play: Callable[[float], bool], done: Callable[[], object] | None
    ) -> None:
        call = Callback(f"the end of the animation of {entity.GetScopedName()}", done) if done is not None else None
        self._runs[entity, what] = _Run(self._world.core.GetSimTime(), play, call)

    def stop(self, entity: Entity) -> None:
        """Stop the animations of an entity and its joints."""
        for what in ("pose", "joints"):
            self._runs.pop((entity, what), None)

    def update(self) -> None:
        """Advance all animations to the present sim time; one that fails is logged, and ends."""
        now = self._world.core.GetSimTime()
        for key, run in list(self._runs.items()):
            if self._runs.get(key) is not run:  # stopped or replaced by the callback of another
                continue
            try:
                ended = run.advance(now)
            except GazeboError as error:
                log.error("the animation of %s ends: %s", key[0].GetScopedName(), error)
                del self._runs[key]
                continue
            if ended:
                del self._runs[key]
                run.finish()


def _checked(animation: A, kind: type[A]) -> A:
    if not isinstance(animation, kind):
        raise ParameterError(f"{animation!r} is not a {kind.__name__}")
    return animation


def _move(entity: Entity, animation: PoseAnimation, seconds: float) -> bool:
    ended = _advance(animation, seconds)
    frame = animation.GetInterpolatedKeyFrame()
    entity.SetRelativePose(Pose3d(frame.Translation(), frame.Rotation()))
    return ended


def _move_joints(model: Model, animations: dict[str, NumericAnimation], seconds: float) -> bool:
    controller = model.GetJointController()
    for name in animations:
        if controller.scoped_name(name) is None:
            raise NotFoundError(f"there is no joint {name!r}{nearest(name, controller.GetJoints())}")
    ended = [_advance(animation, seconds) for animation in animations.values()]
    model.SetJointPositions({name: one.GetInterpolatedKeyFrame().Value() for name, one in animations.items()})
    return all(ended)


def _advance(animation: PoseAnimation | NumericAnimation, seconds: float) -> bool:
    """Advance an animation by a time [s]; returns whether it has ended."""
    before = animation.GetTime()
    animation.AddTime(seconds)
    return not animation.repeat and before + seconds >= animation.GetLength()
