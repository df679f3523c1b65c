"""Animations: models and joints that are moved along key frames by sim time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from libgz.classic.common import NumericAnimation, PoseAnimation
from libgz.classic.math import Pose3d

if TYPE_CHECKING:
    from libgz.classic.physics.base import Entity
    from libgz.classic.physics.model import Model
    from libgz.classic.physics.world import World

__all__ = ["Animations"]

Done = Callable[[], object] | None


class Animations:
    """The animations that run in a world."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._poses: dict[Entity, tuple[PoseAnimation, Done]] = {}
        self._joints: dict[Model, tuple[dict[str, NumericAnimation], Done]] = {}
        self._last = 0.0

    def start(self, entity: Entity, animation: PoseAnimation, done: Done) -> None:
        """Move an entity along poses in what it is a part of."""
        self._poses[entity] = animation, done
        self._last = self._world.core.GetSimTime()

    def start_joints(self, model: Model, animations: dict[str, NumericAnimation], done: Done) -> None:
        """Move joints of a model, by name."""
        self._joints[model] = animations, done
        self._last = self._world.core.GetSimTime()

    def stop(self, entity: Entity) -> None:
        """Leave an entity and its joints where they are."""
        self._poses.pop(entity, None)
        self._joints.pop(entity, None)  # type: ignore[call-overload]

    def update(self) -> None:
        """Move everything on to the present sim time."""
        if not self._poses and not self._joints:
            return
        now = self._world.core.GetSimTime()
        passed, self._last = max(0.0, now - self._last), now
        for entity, (animation, done) in list(self._poses.items()):
            ended = _advance(animation, passed)
            frame = animation.GetInterpolatedKeyFrame()
            entity.SetRelativePose(Pose3d(frame.Translation(), frame.Rotation()))
            if ended:
                del self._poses[entity]
                if done is not None:
                    done()
        for model, (animations, done) in list(self._joints.items()):
            over = [_advance(animation, passed) for animation in animations.values()]
            places = {}
            for name, numeric in animations.items():
                places[name] = numeric.GetInterpolatedKeyFrame().Value()
            model.SetJointPositions(places)
            if all(over):
                del self._joints[model]
                if done is not None:
                    done()


def _advance(animation: PoseAnimation | NumericAnimation, seconds: float) -> bool:
    """Let time pass; whether the animation is over."""
    before = animation.GetTime()
    animation.AddTime(seconds)
    return not animation.repeat and before + seconds >= animation.GetLength()
