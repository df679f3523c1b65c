"""Actor: a model that follows a script, or a plugin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError, nearest
from libgz.classic.common import SkeletonAnimation
from libgz.classic.physics.base import Base
from libgz.classic.physics.model import Model
from libgz.physics.check import finite

if TYPE_CHECKING:
    from libgz.sdfworld.actor import SdfActor

__all__ = ["Actor", "TrajectoryInfo"]


@dataclass
class TrajectoryInfo:
    """What a plugin gives an actor instead of its script.

    Attributes:
        type: name of the animation that is played.
        id, duration, startTime, endTime, translated: as in Gazebo, without effect.
    """

    id: int = 0
    type: str = ""
    duration: float = 0.0
    startTime: float = 0.0
    endTime: float = 0.0
    translated: bool = False


class Actor(Model):
    """A view on an actor. Each bone of its skeleton is a link, by the bone's name."""

    entity_type = Base.ENTITY | Base.MODEL | Base.ACTOR
    core: SdfActor

    def Play(self) -> None:
        """Begin the script."""
        self.core.play()

    def Stop(self) -> None:
        """Stop; the actor stays as it is."""
        self.core.stop()

    def IsActive(self) -> bool:
        """Whether it plays its script, or the animation of a plugin."""
        return self.core.active

    def ScriptTime(self) -> float:
        """The time in the present trajectory, or what SetScriptTime has set [s]."""
        return self.core.script_time

    def SetScriptTime(self, time: float) -> None:
        """Set the time in the animation that a plugin plays [s].

        Raises:
            ParameterError: it is not a finite number.
        """
        self.core.script_time = finite(time, "script time [s]")

    def SkeletonAnimations(self) -> dict[str, SkeletonAnimation]:
        """Its animations by name; the one of the skin itself, if it is played, has the name ``__default__``."""
        figure = self.core.figure
        if figure is None:
            return {}
        return {name: SkeletonAnimation(name, figure.names, clip.animation) for name, clip in self.core.clips.items()}

    def SetCustomTrajectory(self, trajInfo: TrajectoryInfo | Any) -> None:
        """Play an animation while a plugin moves the actor by SetWorldPose and SetScriptTime, instead of the script.

        Raises:
            ParameterError: the actor has no animation of that type.
        """
        kind = str(trajInfo.type)
        if self.core.clips and kind not in self.core.clips:
            known = self.core.clips
            raise ParameterError(
                f"actor {self.GetName()!r} has no animation {kind!r}; it has {', '.join(known)}{nearest(kind, known)}"
            )
        self.core.follow_plugin(kind)
        self._trajectory = trajInfo

    def CustomTrajectory(self) -> TrajectoryInfo | Any:
        """What SetCustomTrajectory has set; None while the script is followed."""
        kind = self.core.custom
        if kind is None:
            return None
        given = getattr(self, "_trajectory", None)
        return given if given is not None and given.type == kind else TrajectoryInfo(type=kind)

    def ResetCustomTrajectory(self) -> None:
        """Follow the script again."""
        self.core.custom = None

    def SetSelfCollide(self, collide: bool) -> None:
        """Without effect: the links of an actor never touch each other."""

    def GetSelfCollide(self) -> bool:
        """False."""
        return False

    GetScriptTime = ScriptTime
