"""VariableGearboxPlugin: a gearbox whose ratio depends on the angle."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Link, Model
    from libgz.sdf.element import Element


class VariableGearboxPlugin(ModelPlugin):
    """Lets the output angle y of a gearbox joint be a smooth function of its input angle x.

    The function passes through points with given slopes, as cubic Hermite polynomials; before the first and after the
    last point it is a line. x is the position of the joint whose child is the gearbox' parent link; its position at the
    start is 0.

    Elements:
        gearbox_joint_name: the gearbox.
        x_y_dydx: a point, one or more, in the order of x: x [rad], y [rad], slope.
    """

    STATE = ()  # it follows from the angle

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and read the points.

        Raises:
            NotFoundError: a joint or an element is missing.
            ParameterError: the joint is no gearbox, its input is ambiguous, or the points are not in order.
        """
        self.gearbox = named_joint(model, sdf, "gearbox_joint_name")
        if self.gearbox.core.kind != "gearbox":
            raise ParameterError(f"{sdf.where}: joint {self.gearbox.GetName()!r} is no gearbox")
        self.input = self._joint_of(self.gearbox.GetParent(), sdf)
        self.points = [tuple(element.Get(Vector3d)) for element in sdf.named("x_y_dydx")]
        if not self.points:
            raise NotFoundError(f"{sdf.where}: <x_y_dydx> is missing; a point has x, y [rad] and a slope")
        for before, after in pairwise(self.points):
            if not before[0] < after[0]:
                raise ParameterError(
                    f"{sdf.where}: Out of order x_y_dydx element detected: {before[0]:g} should be less than "
                    f"{after[0]:g}"
                )
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def _joint_of(self, link: Link, sdf: Element) -> Joint:
        """The joint that carries a link, other than the gearbox.

        Raises:
            ParameterError: there is none, or there are several.
        """
        found = [joint for joint in link.GetParentJoints() if joint is not self.gearbox]
        if len(found) != 1:
            names = ", ".join(joint.GetName() for joint in found) or "none"
            raise ParameterError(
                f"{sdf.where}: link {link.GetName()!r} of the gearbox must be the child of one other joint; it is "
                f"that of {names}"
            )
        return found[0]

    def OnUpdate(self) -> None:
        """Set the ratio of the present angle, and where it holds."""
        x, y, slope = _tangent(self.points, self.input.Position(0))
        self.gearbox.SetParam("reference_angle1", 0, y)
        self.gearbox.SetParam("reference_angle2", 0, x)
        self.gearbox.SetParam("ratio", 0, -slope)


def _tangent(points: list[tuple[float, ...]], x: float) -> tuple[float, float, float]:
    """A point of the tangent at x, and its slope, of the curve through points (x, y, slope)."""
    if x <= points[0][0]:
        first: tuple[float, float, float] = points[0]  # type: ignore[assignment]
        return first
    if x >= points[-1][0]:
        last: tuple[float, float, float] = points[-1]  # type: ignore[assignment]
        return last
    (x0, y0, m0), (x1, y1, m1) = next(pair for pair in pairwise(points) if x <= pair[1][0])
    h = x1 - x0
    t = (x - x0) / h
    y = (
        (1.0 + 2.0 * t) * (1.0 - t) ** 2 * y0
        + t * (1.0 - t) ** 2 * h * m0
        + t * t * (3.0 - 2.0 * t) * y1
        + t * t * (t - 1.0) * h * m1
    )
    slope = 6.0 * t * (1.0 - t) * (y1 - y0) / h + (1.0 - t) * (1.0 - 3.0 * t) * m0 + t * (3.0 * t - 2.0) * m1
    return x, y, slope


GZ_REGISTER_MODEL_PLUGIN(VariableGearboxPlugin)
