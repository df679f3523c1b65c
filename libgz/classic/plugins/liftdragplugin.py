"""LiftDragPlugin: lift and drag of a wing, a rudder or a rotor blade."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.base.law import acos, copysign, ends, largest, law, least, rarely, where
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint, named_link

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

MIN_SPEED = 0.01  # [m/s]; below, no force is applied
HALF = math.pi / 2.0
PARALLEL = 1e-6  # sine of the smallest angle between forward and upward


class LiftDragPlugin(ModelPlugin):
    """Applies lift and drag of a surface to a link, at the centre of pressure.

    With v the velocity of the centre of pressure, q = air_density v^2 / 2 and alpha the angle of attack, lift = cl q
    area, normal to v in the plane of `forward` and `upward`, and drag = |cd| q area, opposite to v. Up to the stall
    angle cl = cla alpha and cd = cda alpha; beyond it both continue with the slopes cla_stall and cda_stall, and cl
    keeps its sign. Both are multiplied by the squared cosine of the sweep, the angle between the velocity and the
    plane. All of that is Gazebo 11.1's, with three peculiarities for which models are tuned: where the air comes from
    the side, v is taken times 1 - s, s the sine of the sweep, positive towards forward x upward; the force acts at `cp`
    from the centre of mass, while the velocity is that at `cp` from the link's origin; and there is no moment: cma and
    cma_stall are read and have no effect.

    Elements:
        link_name: the link.
        a0: angle of attack at zero incidence [rad] (0).
        cla, cda: slopes of the coefficients [1/rad] (1, 0.01).
        alpha_stall: [rad] (pi / 2).
        cla_stall, cda_stall: slopes beyond it [1/rad] (0, 1).
        cp: centre of pressure along the link's axes [m] (0 0 0).
        forward, upward: directions in the link's frame (1 0 0, 0 0 1).
        area: [m^2] (1).
        air_density: [kg/m^3] (1.2041).
        radial_symmetry: true: `upward` is normal to `forward`, in the plane of the velocity, for bodies of revolution
            (false).
        control_joint_name: a joint whose position is added to cl, such as that of a flap.
        control_joint_rad_to_cl: factor of that position [1/rad] (4).
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the parameters of the surface."""
        self.link = named_link(model, sdf)

        def number(tag: str, default: float) -> float:
            return sdf.Get(float, tag, default)[0]

        self.alpha0 = number("a0", 0.0)
        self.alpha_stall = number("alpha_stall", HALF)
        self.cla, self.cla_stall = number("cla", 1.0), number("cla_stall", 0.0)
        self.cda, self.cda_stall = number("cda", 0.01), number("cda_stall", 1.0)
        self.area, self.density = number("area", 1.0), number("air_density", 1.2041)
        self.cp = sdf.Get(Vector3d, "cp", Vector3d())[0]
        self.forward = sdf.Get(Vector3d, "forward", Vector3d(1.0, 0.0, 0.0))[0].Normalize()
        self.upward = sdf.Get(Vector3d, "upward", Vector3d(0.0, 0.0, 1.0))[0].Normalize()
        if self.forward.Cross(self.upward).Length() < PARALLEL:
            raise ParameterError(f"{sdf.where}: <forward> and <upward> must be two directions, not along one line")
        self.radial = sdf.Get(bool, "radial_symmetry", False)[0]
        self.control: Joint | None = None
        if sdf.HasElement("control_joint_name"):
            self.control = named_joint(model, sdf, "control_joint_name")
        self.control_to_cl = number("control_joint_rad_to_cl", 4.0)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @law
    def OnUpdate(self) -> None:
        """Apply lift and drag."""
        velocity = self.link.WorldLinearVel(self.cp)
        if ends(velocity.Length() <= MIN_SPEED):
            return
        turn = self.link.WorldPose().Rot()
        forward, upward = turn.RotateVector(self.forward), turn.RotateVector(self.upward)
        if self.radial:
            across = forward.Cross(forward.Cross(velocity))
            usual = across.Length() > 0.0
            across.Normalize()
            upward = Vector3d(*(where(usual, a, b) for a, b in zip(across, upward, strict=True)))
        self.link.AddForceAtRelativePosition(self.force(velocity, forward, upward), self.cp)

    @law
    def force(self, velocity: Vector3d, forward: Vector3d, upward: Vector3d) -> Vector3d:
        """The sum of lift and drag [N] at a velocity [m/s]; all vectors in the world frame."""
        span = forward.Cross(upward).Normalize()
        sweep = _within_one(span.Dot(velocity) / velocity.Length())
        cos_sweep2 = 1.0 - sweep * sweep
        flow = velocity * (1.0 - sweep)
        speed = flow.Length()
        if rarely(speed == 0.0):
            return Vector3d()
        lift_direction = span.Cross(flow).Normalize()
        alpha = self.attack(lift_direction, forward, upward)
        cl, cd = self.coefficients(alpha)
        cl *= cos_sweep2
        if self.control is not None:
            cl += self.control_to_cl * self.control.Position(0)
        pressure = 0.5 * self.density * speed * speed * self.area
        return lift_direction * (cl * pressure) - flow * (abs(cd) * cos_sweep2 * pressure / speed)

    @law
    def attack(self, lift_direction: Vector3d, forward: Vector3d, upward: Vector3d) -> float:
        """The angle of attack [rad], within +-pi / 2; positive for flow from below."""
        angle = acos(_within_one(upward.Dot(lift_direction)))
        alpha = self.alpha0 + copysign(angle, forward.Dot(lift_direction))
        alpha = where(abs(alpha) > HALF, alpha - copysign(math.pi, alpha), alpha)
        while rarely(abs(alpha) > HALF):  # a large angle at zero incidence
            alpha -= copysign(math.pi, alpha)
        return alpha  # type: ignore[no-any-return]

    @law
    def coefficients(self, alpha: float) -> tuple[float, float]:
        """(cl, cd) at an angle of attack [rad], without sweep."""
        side, beyond = copysign(1.0, alpha), abs(alpha) - self.alpha_stall
        cl = side * largest(0.0, self.cla * self.alpha_stall + self.cla_stall * beyond)
        cd = side * (self.cda * self.alpha_stall + self.cda_stall * beyond)
        flies = abs(alpha) <= self.alpha_stall
        return where(flies, self.cla * alpha, cl), where(flies, self.cda * alpha, cd)


def _within_one(value: float) -> float:
    return largest(least(value, 1.0), -1.0)  # type: ignore[no-any-return]


GZ_REGISTER_MODEL_PLUGIN(LiftDragPlugin)
