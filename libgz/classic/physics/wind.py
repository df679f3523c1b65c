"""Wind: the wind of a world, and a function that makes it vary."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzVector, VectorLike
from libgz.classic.math import Vector3d
from libgz.classic.names import takes_names
from libgz.physics.check import finite_tuple
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.event import Callback

if TYPE_CHECKING:
    from libgz.classic.physics.base import Entity
    from libgz.classic.physics.link import Link
    from libgz.classic.physics.world import World
    from libgz.sdfworld.air import Wind as Air

__all__ = ["Wind"]

KEY = "linear_velocity"


@takes_names
class Wind:
    """The wind of a world. It moves nothing by itself: WindPlugin and other plugins ask for it, and apply forces."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._function: Callback | None = None
        self._at_links: tuple[int, dict[Link, Vector3d]] = (-1, {})  # iteration, and the wind at links in it

    @property
    def _air(self) -> Air:
        return self._world.core.extension(SdfWorld).settings.wind

    def LinearVel(self) -> Vector3d:
        """The velocity of the world's wind, without what a function adds [m/s]."""
        return Vector3d(*self._air.velocity)

    def SetLinearVel(self, vel: VectorLike) -> None:
        """Set that velocity [m/s].

        Raises:
            ParameterError: it is not three finite numbers.
        """
        self._air.velocity = GzVector(*finite_tuple(vel, 3, "wind [m/s]"))

    def SetLinearVelFunc(self, func: Callable[[Wind, Entity], VectorLike]) -> None:
        """Let a function compute the wind at an entity [m/s], in the world frame; it is called once in an iteration
        for each link in the wind.

        Raises:
            ParameterError: it cannot be called.
        """
        self._function = Callback(
            "the wind function", func, lambda found: Vector3d(*finite_tuple(found, 3, "wind [m/s]"))
        )
        self._at_links = (-1, {})

    def WorldLinearVel(self, entity: Entity) -> Vector3d:
        """The wind at an entity now [m/s], in the world frame; calls the function, if there is one."""
        if self._function is None:
            return self.LinearVel()
        found: Vector3d = self._function(self, entity, otherwise=self.LinearVel())
        return found

    def RelativeLinearVel(self, entity: Entity) -> Vector3d:
        """The wind at an entity now [m/s], in its own frame."""
        return Vector3d(*entity.WorldPose().rot.RotateVectorReverse(self.WorldLinearVel(entity)))

    def at_link(self, link: Link) -> Vector3d:
        """The wind at a link in this iteration [m/s]; zero where the link is not in the wind, or wind is disabled."""
        if not (link.WindMode() and self._air.enabled):
            return Vector3d()
        if self._function is None:
            return self.LinearVel()
        iteration = self._world.core.iterations
        if self._at_links[0] != iteration:
            links = [one for model in self._world.all_models() for one in model.GetLinks() if one.WindMode()]
            self._at_links = iteration, {one: self.WorldLinearVel(one) for one in links}
        found = self._at_links[1].get(link)
        return Vector3d(*found) if found is not None else self.WorldLinearVel(link)

    def save(self) -> Any:
        """The wind at links that was computed in the last iteration, as plain data; None without a function."""
        if self._function is None:
            return None
        iteration, found = self._at_links
        return iteration, [
            (link.GetScopedName(), *velocity) for link, velocity in found.items() if not link.body.closed
        ]

    def load(self, saved: Any) -> None:
        """Take what `save` returned."""
        iteration, found = saved or (-1, ())
        links = {link.GetScopedName(): link for model in self._world.all_models() for link in model.GetLinks()}
        self._at_links = iteration, {links[name]: Vector3d(*rest) for name, *rest in found if name in links}

    def SetParam(self, key: str, value: Any) -> bool:
        """Set `linear_velocity` [m/s]; false for another key."""
        if key != KEY:
            return False
        self.SetLinearVel(value)
        return True

    def Param(self, key: str) -> Vector3d:
        """The value of `linear_velocity` [m/s].

        Raises:
            ParameterError: another key.
        """
        if key != KEY:
            raise ParameterError(f"wind has no parameter {key!r}; it has {KEY}")
        return self.LinearVel()

    GetParam = Param
