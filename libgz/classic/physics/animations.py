"""Animations: models and joints that are moved along key frames by sim time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from libgz.classic.common import NumericAnimation, PoseAnimation
from libgz.classic.math import Pose3d
from libgz.simulation.event import Event

if TYPE_CHECKING:
    from libgz.classic.physics.base import Entity
    from libgz.classic.physics.model import Model
    from libgz.classic.physics.world import World

__all__ = ["Animations"]

Done = Callable[[], object] | None


class _Run:
    """The time of an animation, and whom to call at its end."""

    def __init__(self, now: float, done: Done) -> None:
        self._last = now
        self._end = Event("end of an animation")
        self._kept = self._end.Connect(done) if done is not None else None

    def passed(self, now: float) -> float:
        """Sim time since the last call [s]."""
        seconds, self._last = max(0.0, now - self._last), now
        return seconds

    def finish(self) -> None:
        """Tell that it is over."""
        self._end()


class Animations:
    """The animations that run in a world."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._poses: dict[Entity, tuple[PoseAnimation, _Run]] = {}
        self._joints: dict[Model, tuple[dict[str, NumericAnimation], _Run]] = {}

    def start(self, entity: Entity, animation: PoseAnimation, done: Done) -> None:
        """Move an entity along poses in what it is a part of."""
        self._poses[entity] = animation, _Run(self._world.core.GetSimTime(), done)

    def start_joints(self, model: Model, animations: dict[str, NumericAnimation], done: Done) -> None:
        """Move joints of a model, by name."""
        self._joints[model] = animations, _Run(self._world.core.GetSimTime(), done)

    def stop(self, entity: Entity) -> None:
        """Leave an entity and its joints where they are."""
        self._poses.pop(entity, None)
        self._joints.pop(entity, None)  # type: ignore[call-overload]

    def update(self) -> None:
        """Move everything on to the present sim time."""
        if not self._poses and not self._joints:
            return
        now = self._world.core.GetSimTime()
        for entity, (animation, run) in list(self._poses.items()):
            over = _advance(animation, run.passed(now))
            frame = animation.GetInterpolatedKeyFrame()
            entity.SetRelativePose(Pose3d(frame.Translation(), frame.Rotation()))
            if over:
                del self._poses[entity]
                run.finish()
        for model, (animations, run) in list(self._joints.items()):
            seconds = run.passed(now)
            ended = [_advance(animation, seconds) for animation in animations.values()]
            model.SetJointPositions(
                {name: numeric.GetInterpolatedKeyFrame().Value() for name, numeric in animations.items()}
            )
            if all(ended):
                del self._joints[model]
                run.finish()


def _advance(animation: PoseAnimation | NumericAnimation, seconds: float) -> bool:
    """Let time pass; whether the animation is over."""
    before = animation.GetTime()
    animation.AddTime(seconds)
    return not animation.repeat and before + seconds >= animation.GetLength()
