"""CxxRay: a ray that plugins collide with geoms by functions of ODE, as the old API has no other way to cast it."""

from __future__ import annotations

from libgz.base.geometry import VectorLike
from libgz.ode.lib import ode
from libgz.physics.body import Body
from libgz.physics.geoms import RayGeom
from libgz.physics.lock import exclusive
from libgz.physics.space import Space

__all__ = ["CxxRay"]


class CxxRay(RayGeom):
    """A ray with a geom of ODE's.

    That geom is in a space that the plugin made, and in no other one: a model's own space is part of the step, which
    would make contacts of it.

    Args:
        body: with which it closes.
        space: where the plugin wants it.
    """

    def __init__(self, body: Body, space: Space | None) -> None:
        super().__init__(body)
        made = space is not None and space is not body.engine.top and space not in body.engine.spaces
        self._adopt(ode().dCreateRay(space.id if made and space is not None else None, self.GetLength()))
        self._update()

    @exclusive
    def _update(self) -> None:
        start, direction = self.Get()
        ode().dGeomRaySetLength(self.id, self.GetLength())
        ode().dGeomRaySet(self.id, *start, *direction)

    def Set(self, pos: VectorLike, dir: VectorLike) -> None:
        """Place the ray: start [m] and direction, global."""
        super().Set(pos, dir)
        self._update()

    def SetLength(self, length: float) -> None:
        """Length of the ray [m]."""
        super().SetLength(length)
        self._update()
