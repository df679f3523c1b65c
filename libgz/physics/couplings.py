"""Motions that depend on each other: screws and gears, which Debian's ODE does not have.

Both are made of ODE's double ball, which keeps one distance and so is one row of the solver: a force along a line.
Placed along the flank of a thread, or along a tooth, and updated before every step, that row is the constraint, solved
together with all others; the distance that it keeps corrects the drift.
"""

from __future__ import annotations

import math

from libgz.base.geometry import (
    GzCoordPositionSub,
    GzPose,
    GzQuatern,
    GzQuaternInverse,
    GzQuaternMul,
    GzVector,
    GzVectorAdd,
    GzVectorCross,
    GzVectorDot,
    GzVectorMul,
    GzVectorSub,
    GzVectorUnit,
    rotate,
)
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.types import JointType, dParamERP, dParamFMax, dParamFMax2
from libgz.physics.body import Body
from libgz.physics.check import LARGEST
from libgz.physics.engine import HasEngine
from libgz.physics.joint import AxisJoint, HingeJoint, Joint, JointFunctions
from libgz.physics.lock import exclusive
from libgz.physics.mass import given_mass

__all__ = ["Gears", "LineJoint", "PistonJoint", "Thread", "TieJoint"]

FLANK = math.sqrt(0.5)  # sine and cosine of the angle between a thread's flank and its axis
RACK = 0.1  # mass of a gear's rack as a share of what it drives
LEVER = 1e4  # radii at the rack, in radii of gyration
STIFF = 1e9  # inertia of a rack that is to slide and not to turn [kg m^2]


class PistonJoint(AxisJoint):
    """One axis to turn about and to slide along; the angle is value 1, the position value 2."""

    kind, motors = JointType.PISTON, (dParamFMax, dParamFMax2)

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(
            lib.dJointCreatePiston,
            lib.dJointSetPistonParam,
            lib.dJointGetPistonParam,
            lib.dJointSetPistonAnchor,
            lib.dJointGetPistonAnchor,
            lib.dJointSetPistonAxis,
            lib.dJointGetPistonAxis,
        )

    def GetPosition(self) -> float:
        """Position along the axis [m]."""
        return self._value(1)

    def GetPositionRate(self) -> float:
        """Velocity along the axis [m/s]."""
        return self._value(3)


class LineJoint(Joint):
    """A force along one line that prevents motion along it: ODE's double ball."""

    kind = JointType.DBALL

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(lib.dJointCreateDBall, lib.dJointSetDBallParam, lib.dJointGetDBallParam)

    @exclusive
    def place(self, point: GzVector, direction: GzVector, error: float) -> None:
        """Put the line through a global point [m]; `error` [m] is how far the first body is ahead along it."""
        error = max(-LARGEST, min(error, LARGEST))
        length = max(1.0, 2.0 * error)  # ODE keeps a distance, which is above zero
        px, py, pz = point
        dx, dy, dz = GzVectorMul(0.5 * length, direction)
        lib, handle = ode(), self.id
        lib.dJointSetDBallAnchor1(handle, px + dx, py + dy, pz + dz)
        lib.dJointSetDBallAnchor2(handle, px - dx, py - dy, pz - dz)
        lib.dJointSetDBallDistance(handle, length - error)


class TieJoint(Joint):
    """Without any constraint; bodies that it joins do not touch each other: ODE's motor without axes."""

    kind = JointType.AMOTOR

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(lib.dJointCreateAMotor, lib.dJointSetAMotorParam, lib.dJointGetAMotorParam)


def _perpendicular(axis: GzVector) -> GzVector:
    """Some unit vector at right angles to an axis."""
    other = GzVector(1.0, 0.0, 0.0) if abs(axis.x) < 0.9 else GzVector(0.0, 1.0, 0.0)
    return GzVectorUnit(GzVectorCross(axis, other))


class Thread:
    """Couples a piston's two motions: position = -angle / pitch.

    Args:
        piston: attached, with anchor and axis.
        pitch: [rad/m], not zero.
    """

    SAVED = ("pitch",)

    def __init__(self, piston: PistonJoint, pitch: float) -> None:
        self.piston = piston
        self.pitch = pitch
        self.line = LineJoint(piston.engine, name=f"{piston.name} thread")
        self.line.Attach(*piston.bodies)
        piston.engine.add_coupling(self)

    @property
    def broken(self) -> bool:
        """Whether a body that it held was closed."""
        return self.line.closed

    @property
    def error(self) -> float:
        """How far the position is off [m]."""
        return self.piston.GetPosition() + self.piston.GetAngle() / self.pitch

    def provide_feedback(self, on: bool) -> None:
        """Whether `feedback` is filled in each step."""
        self.line.provide_feedback(on)

    @property
    def feedback(self) -> tuple[GzVector, GzVector, GzVector, GzVector]:
        """Forces and torques of the thread on the piston's bodies in the last step; see `Joint.feedback`."""
        return self.line.feedback

    def update(self) -> None:
        """Place the line along the flank, before a step."""
        axis = self.piston.GetAxis()
        outward = _perpendicular(axis)
        tangent = GzVectorCross(axis, outward)
        point = GzVectorAdd(self.piston.GetAnchor(), GzVectorMul(1.0 / self.pitch, outward))
        self.line.place(point, GzVectorMul(FLANK, GzVectorAdd(axis, tangent)), FLANK * self.error)

    def close(self) -> None:
        """Remove the coupling."""
        self.line.close()


class Gears:
    """Couples the rotations of two bodies: angle 2 = -ratio * angle 1, as seen from a third.

    As in Gazebo, the bodies get torques alone, and the third one none; a share of the error, ODE's ERP, is corrected in
    each step, and an error beyond half a turn the other way round. Both angles count from references [rad], zero at
    first; together with the ratio they may change in each step.

    A rack of little mass slides past both; each meshes with it at its own radius. The effort that accelerates the rack
    beyond what is foreseen is compensated in the next step.

    Args:
        world: the World, or an Engine.
        bodies: the two bodies; neither is a dummy.
        axes: their axes, global.
        ratio: not zero.
        reference: whose turns do not count; None for the world's.
    """

    SAVED = (
        "ratio",
        "references",
        "angles",
        "_local",
        "_hubs",
        "_speed",
        "_change",
        "_foreseen",
        "_radii",
        "_mass",
        "_moments",
        "_begins",
    )

    def __init__(
        self,
        world: HasEngine,
        bodies: tuple[Body, Body],
        axes: tuple[GzVector, GzVector],
        ratio: float,
        reference: Body | None = None,
    ) -> None:
        self.engine = world.engine
        self.bodies, self.reference, self.ratio = bodies, reference, ratio
        self._local = [rotate(GzQuaternInverse(b.GetRotation()), a) for b, a in zip(bodies, axes, strict=True)]
        self._hubs = [self._find_hub(body) for body in bodies]
        self.angles, self.references = [0.0, 0.0], [0.0, 0.0]
        self._begins = [self._seen(body) for body in bodies]
        self._speed: float | None = None  # of the second gear's tooth before the last step [m/s]
        self._change = self._foreseen = 0.0  # by how much the error changed it, and what it should have become [m/s]
        self.rack = Body(world, name=f"rack of {bodies[0].label} and {bodies[1].label}")
        self._set_rack_mass()
        self._lines = []
        for body in bodies:
            line = LineJoint(world, name="tooth")
            line.Attach(body, self.rack)
            self._lines.append(line)
        self._tie = TieJoint(world, name="gears")
        self._tie.Attach(*bodies)
        self.engine.add_coupling(self)

    def _set_rack_mass(self) -> None:
        """Choose radii so large that the bodies get a torque and hardly a force; set a share of the smaller mass."""
        masses = [body.GetMass() for body in self.bodies]
        self._moments = [
            sum(axis[i] * mass.I[4 * i + j] * axis[j] for i in range(3) for j in range(3))
            for axis, mass in zip(self._local, masses, strict=True)
        ]
        least = min(self._moments[0] / self.ratio**2, self._moments[1])
        radius = LEVER * max(math.sqrt(own / mass.mass) for own, mass in zip(self._moments, masses, strict=True))
        radius /= min(1.0, abs(self.ratio))
        self._radii = (-self.ratio * radius, radius)
        self._mass = RACK * least / radius**2
        self.rack.SetMassMatrix(given_mass(self._mass, (STIFF, STIFF, STIFF, 0.0, 0.0, 0.0), GzPose()))
        self.rack.SetGravityMode(False)

    def _find_hub(self, body: Body) -> GzVector:
        """A point of a body's axis, in its frame: where its hinge is, else its centre of mass."""
        hinges = [joint for joint in body.joints if isinstance(joint, HingeJoint)]
        pose = body.GetPose()
        point = hinges[0].GetAnchor() if hinges else body.GetCoMPose().pos
        return GzCoordPositionSub(point, pose.pos, pose.rot)

    def _seen(self, body: Body) -> GzQuatern:
        """The rotation of a body as the reference sees it."""
        rotation = body.GetRotation()
        return GzQuaternMul(GzQuaternInverse(self.reference.GetRotation()), rotation) if self.reference else rotation

    def rates(self) -> tuple[float, float]:
        """Rates of both bodies about their axes [rad/s], seen from the reference."""
        spin = self.reference.GetAngularRate() if self.reference is not None else GzVector()
        first, second = (
            GzVectorDot(GzVectorSub(body.GetAngularRate(), spin), self.direction(index))
            for index, body in enumerate(self.bodies)
        )
        return first, second

    @property
    def broken(self) -> bool:
        """Whether a body that it held was closed."""
        return any(line.closed for line in self._lines)

    @property
    def line(self) -> LineJoint:
        """The first of its joints."""
        return self._lines[0]

    def direction(self, index: int) -> GzVector:
        """The current axis of the first (0) or second (1) body, global."""
        return rotate(self.bodies[index].GetRotation(), self._local[index])

    def set_ratio(self, ratio: float) -> None:
        """Replace the ratio; angles are zero at the current pose."""
        self.ratio = ratio
        self._set_rack_mass()
        self.restore()

    def vary_ratio(self, ratio: float) -> None:
        """Replace the ratio, which may be zero; the angles stay."""
        self.ratio = ratio
        self._radii = (-ratio * self._radii[1], self._radii[1])

    def restore(self) -> None:
        """Set the angles to zero."""
        self.angles = [0.0, 0.0]
        self._begins = [self._seen(body) for body in self.bodies]
        self._speed = None

    def _count(self) -> None:
        """Measure both angles; each is the one next to that of the step before."""
        for index, (body, axis, begin) in enumerate(zip(self.bodies, self._local, self._begins, strict=True)):
            turned = GzQuaternMul(GzQuaternInverse(begin), self._seen(body))
            angle = 2.0 * math.atan2(GzVectorDot(GzVector(turned.x, turned.y, turned.z), axis), turned.u)
            self.angles[index] += math.remainder(angle - self.angles[index], math.tau)

    def update(self, step: float) -> None:
        """Place the rack, and both lines along it, before a step [s]."""
        self._count()
        poses = [body.GetPose() for body in self.bodies]
        axes = [rotate(pose.rot, axis) for pose, axis in zip(poses, self._local, strict=True)]
        along = GzVectorCross(*axes)
        square = GzVectorDot(along, along)
        along = GzVectorMul(1.0 / math.sqrt(square), along) if square > 1e-6 else _perpendicular(axes[0])
        points = [
            GzVectorAdd(GzVectorAdd(pose.pos, rotate(pose.rot, hub)), GzVectorMul(radius, GzVectorCross(along, axis)))
            for pose, hub, axis, radius in zip(poses, self._hubs, axes, self._radii, strict=True)
        ]
        (first, second), (first_zero, second_zero) = self.angles, self.references
        apart = math.remainder(second - second_zero + self.ratio * (first - first_zero), math.tau)
        rates = [GzVectorDot(body.GetAngularRate(), axis) for body, axis in zip(self.bodies, axes, strict=True)]
        wanted = -self.line.GetParam(dParamERP) / step * apart - (rates[1] + self.ratio * rates[0])
        change = wanted / (1.0 + self.ratio**2 * self._moments[1] / self._moments[0])
        self._place_rack(poses[1], along, self._radii[1] * rates[1], self._radii[1] * change, step)
        for line, point, off in zip(self._lines, points, (-self._radii[1] * apart, 0.0), strict=True):
            line.place(point, along, off)

    def _place_rack(self, pose: GzPose, along: GzVector, speed: float, change: float, step: float) -> None:
        """Move the rack with the second gear, as it will move, and compensate what was not foreseen of the last step.

        Args:
            pose: of the rack.
            along: its direction.
            speed: of the gear's tooth [m/s].
            change: of that speed that the error makes in this step, with the moments of both gears alone [m/s].
            step: [s].
        """
        rack, foreseen = self.rack, speed + change
        if self._speed is not None:
            foreseen += speed - self._speed - self._change  # other efforts act as in the last step
            rack.AddForce(*GzVectorMul(self._mass * (speed - self._foreseen) / step, along))
        foreseen = max(-LARGEST, min(foreseen, LARGEST))  # large errors of gears with extreme ratios are beyond
        self._speed, self._change, self._foreseen = speed, change, foreseen
        rack.SetPose(pose)
        rack.SetLinearVel(GzVectorMul(foreseen, along))
        rack.SetAngularVel(GzVector())

    def close(self) -> None:
        """Remove the coupling."""
        self._tie.close()
        self.rack.close()
