"""Animations: key frame animations of entities and joints, in sim time."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from libgz.base.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.classic.common import NumericAnimation, PoseAnimation
from libgz.classic.math import Pose3d
from libgz.classic.physics.place import found_at, place_of
from libgz.simulation.event import Callback
from libgz.simulation.state import get_state, set_state

if TYPE_CHECKING:
    from libgz.classic.physics.base import Entity
    from libgz.classic.physics.world import Model, World

__all__ = ["Animations"]

log = logging.getLogger("libgz.classic")

MOST_ENDED = 1000  # runs whose callbacks are kept for states of earlier moments

A = TypeVar("A", PoseAnimation, NumericAnimation)


class _Run:
    """A running animation.

    Args:
        now: sim time [s].
        play: advances the animations by a time [s]; returns whether they have ended.
        animations: what it plays; joints' by name, an entity's under an empty one.
        done: called at the end.
        number: of this run among all of its world.
    """

    def __init__(
        self,
        now: float,
        play: Callable[[float], bool],
        animations: Mapping[str, PoseAnimation | NumericAnimation],
        done: Callback | None,
        number: int,
    ) -> None:
        self._last, self._play, self._done = now, play, done
        self.animations, self.number = dict(animations), number

    def save(self) -> tuple[Any, ...]:
        """Its state as plain data."""
        return self._last, self.number, {name: get_state(one) for name, one in self.animations.items()}

    def load(self, state: Sequence[Any]) -> None:
        """Take what `save` returned."""
        self._last, self.number, animations = state
        for name, one in animations.items():
            set_state(self.animations[name], one)

    def advance(self, now: float) -> bool:
        """Advance to a sim time [s]; returns whether it has ended."""
        passed, self._last = max(0.0, now - self._last), now
        return self._play(passed)

    def again(self, other: _Run) -> _Run:
        """Another run of the same animations, with the callback of this one."""
        other._done = self._done
        return other

    def finish(self) -> None:
        """Call the callback of the end."""
        if self._done is not None:
            self._done()


class Animations:
    """The running animations of a world."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._runs: dict[tuple[Entity, str], _Run] = {}
        self._count = 0  # of runs that were started
        self._ended: deque[_Run] = deque(maxlen=MOST_ENDED)  # a state may start them again, with their callbacks

    def start(self, entity: Entity, animation: PoseAnimation, done: Callable[[], object] | None) -> None:
        """Play an animation of an entity's pose relative to its parent.

        Raises:
            ParameterError: it is not a PoseAnimation, or `done` cannot be called.
        """
        self._start(entity, "pose", {"": _checked(animation, PoseAnimation)}, done)

    def start_joints(
        self, model: Model, animations: dict[str, NumericAnimation], done: Callable[[], object] | None
    ) -> None:
        """Play animations of joint positions of a model, by joint name.

        Raises:
            ParameterError: one is not a NumericAnimation, or `done` cannot be called.
        """
        rows = {name: _checked(animation, NumericAnimation) for name, animation in dict(animations).items()}
        self._start(model, "joints", rows, done)

    def _start(self, entity: Entity, what: str, rows: dict[str, Any], done: Callable[[], object] | None) -> None:
        call = Callback(f"the end of the animation of {entity.GetScopedName()}", done) if done is not None else None
        self._end((entity, what))
        self._count += 1
        self._runs[entity, what] = self._run(entity, what, rows, call, self._count)

    def _run(self, entity: Any, what: str, rows: dict[str, Any], done: Callback | None, number: int) -> _Run:
        play = partial(_move, entity, rows[""]) if what == "pose" else partial(_move_joints, entity, rows)
        return _Run(self._world.core.GetSimTime(), play, rows, done, number)

    def stop(self, entity: Entity) -> None:
        """Stop the animations of an entity and its joints."""
        for what in ("pose", "joints"):
            self._end((entity, what))

    def _end(self, key: tuple[Entity, str]) -> None:
        run = self._runs.pop(key, None)
        if run is not None:
            self._ended.append(run)

    def save(self) -> tuple[Any, ...]:
        """The state of all running animations, as plain data."""
        if not self._runs:
            return self._count, []
        return self._count, [(place_of(entity), what, run.save()) for (entity, what), run in self._runs.items()]

    def load(self, state: Sequence[Any]) -> None:
        """Take what `save` returned: animations that ended since run again, those that began since end.

        The callback of the end is that of the same run, as far as this process knows it.
        """
        self._count, rows = state
        known = {run.number: run for run in (*self._ended, *self._runs.values())}
        by_key = dict(self._runs)
        self._runs = {}
        for place, what, one in rows:
            entity = found_at(self._world, place)
            before = by_key.get((entity, what))
            run = before if before is not None and before.number == one[1] else known.get(one[1], before)
            if run is None or run.animations.keys() != one[2].keys():
                kind = PoseAnimation if what == "pose" else NumericAnimation
                run = self._run(entity, what, {name: kind(name, 1.0, False) for name in one[2]}, None, one[1])
            run = run.again(self._run(entity, what, run.animations, None, one[1]))
            run.load(one)
            self._runs[entity, what] = run

    @property
    def running(self) -> bool:
        """Whether there are any."""
        return bool(self._runs)

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
                self._end(key)
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
