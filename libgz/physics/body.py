"""Body: a rigid body with geoms, or a dummy that only has a pose.

A body is the parent of its geoms and joints: their modules import this one, and this one names their types only.
"""

from __future__ import annotations

import contextlib
import ctypes
import itertools
import logging
import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ClosedError, ParameterError
from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzPose,
    GzPoseOf,
    GzQuatern,
    GzQuaternIdent,
    GzQuaternInverse,
    GzQuaternMul,
    GzQuaternNormal,
    GzQuaternSetVector,
    GzVector,
    GzVectorAdd,
    QuaternLike,
    VectorLike,
    place_of,
    rotate,
)
from libgz.ode.lib import ode
from libgz.physics import mass as mass_
from libgz.physics.check import FAR, LARGEST, finite_tuple, not_negative, rotation_tuple
from libgz.physics.engine import Engine, HasEngine
from libgz.physics.lock import built, exclusive

if TYPE_CHECKING:
    from libgz.physics.geom import Geom
    from libgz.physics.joint import Joint

    _MassSums: TypeAlias = tuple[mass_.MassSum[Geom], mass_.MassSum[Geom]]

__all__ = ["Body", "place_dummies"]

log = logging.getLogger("libgz.physics")

# When a body is at rest and may sleep, as in Gazebo classic.
REST_SPEED, REST_TIME, REST_STEPS = 0.1, 1.0, 5  # [m/s and rad/s], [s]

_STILL = (0.0, 0.0, 0.0)

_numbers = itertools.count(1)


class Body:
    """A rigid body.

    Its frame is the one its geoms are placed in; ODE's own origin is the centre of mass, and the difference is kept
    here. Poses are global and of the body frame, velocities of the centre of mass.

    Attributes:
        model: what it was added to.
        kinematic: whether it moves by its velocity only.
        made_static: whether a user has made it static since; no more than a mark.
        auto_disable: whether it sleeps when it rests.
        diverged: whether it ever diverged, which is reported once.
        in_wind: whether wind acts on it, by what computes its force.
        facade: the object by which the API of a layer above presents this body; set by that layer.

    Args:
        world: the World, or an Engine.
        name: for look-up; a model's canonical body is renamed ``canonical``.
        dummy: no ODE body: it has a pose, never moves by itself, and forces do nothing.
    """

    SAVED: ClassVar[tuple[str, ...]] = (
        "bodyName",
        "kinematic",
        "made_static",
        "auto_disable",
        "diverged",
        "damping",
        "in_wind",
        "_given_mass",
    )

    @built
    def __init__(self, world: HasEngine, name: str | None = None, dummy: bool = False) -> None:
        self.engine: Engine = world.engine
        self.bodyName = name
        self.number = next(_numbers)  # of this body among all, never used again
        self.model: Any = None
        self.facade: Any = None
        self.diverged = False
        self.kinematic = self.made_static = False
        self.auto_disable = False
        self.geoms: list[Geom] = []
        self.joints: dict[Joint, None] = {}
        self._frame = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]  # of a dummy, see `frame`
        self._given_mass: mass_.Mass | None = None
        self._sums: _MassSums | None = None  # while geoms are added
        self.damping = 0.0, 0.0
        self.in_wind = False
        self._closed = False
        self._id: int | None = None
        self._table = self.engine.tables.bodies
        self.row = -1
        if not dummy:
            handle = ode().dBodyCreate(self.engine.world)
            self._id = handle
            self.row = self.engine.tables.add_body(self, handle)
            if self.engine.explicit_gyroscopic:
                ode().dBodySetGyroscopicMode(handle, 0)
        else:
            self.engine.dummies[self] = None

    def __repr__(self) -> str:
        return f"<Body {self.bodyName or 'unnamed'}{' dummy' if self.dummy else ''}{place_of(self)}>"

    @property
    def dummy(self) -> bool:
        """Whether this body is only a pose."""
        return self.row < 0

    @property
    def id(self) -> int:
        """The ODE handle; 0 for a dummy.

        Raises:
            ClosedError: the body was closed.
        """
        self._require_open()
        return self._id or 0

    @property
    def closed(self) -> bool:
        """Whether it was destroyed."""
        return self._closed

    def _require_open(self) -> None:
        """Check that the body was not closed: its row may belong to another one.

        Raises:
            ClosedError: it was.
        """
        if self._closed:
            raise ClosedError(f"body {self.bodyName or 'unnamed'!r} was closed")

    @property
    def label(self) -> str:
        """Its name for messages: ``model::body``."""
        names = [self.model.GetId()] if self.model is not None else []
        return "::".join((*names, self.bodyName or "unnamed"))

    def GetBodyId(self) -> int:
        """The ODE handle; 0 for a dummy."""
        return self.id

    @exclusive
    def close(self) -> None:
        """Destroy the body, its geoms, and the joints that hold it."""
        if self._closed:
            return
        self.engine.wake()
        for joint in list(self.joints):
            joint.close()
        for geom in list(self.geoms):
            geom.close()
        for bundle in [bundle for bundle in self.engine.ray_bundles if bundle.body is self]:
            self.engine.ray_bundles.discard(bundle)
        if self._id is not None:
            self.engine.auto_disabled.discard(self)
            self._table.remove(self.row)
            ode().dBodyDestroy(self._id)
            self._id = None
        self.engine.moved_dummies.discard(self)
        self.engine.dummies.pop(self, None)
        self._closed = True

    # State -------------------------------------------------------------------------------------------------------

    def _values(self, first: int, last: int) -> list[float]:
        """Columns of this body's row; see `Engine.states`."""
        if self._closed:
            self._require_open()
        table, row = self._table, self.row
        if not table.fresh[row]:
            self._read()
        values: list[float] = table.values[16 * row + first : 16 * row + last].tolist()  # type: ignore[assignment]
        return values

    @exclusive
    def _read(self) -> None:
        """Copy the state from ODE: another thread may be stepping it, or have destroyed the body."""
        self._require_open()
        if not self._table.fresh[self.row]:
            self.engine.native.read_body(self.row)
            self._table.fresh[self.row] = 1

    def GetPose(self) -> GzPose:
        """Global pose of the body frame [m]."""
        x, y, z, qu, qx, qy, qz = self.frame()
        return GzPose(GzVector(x, y, z), GzQuatern(qu, qx, qy, qz))

    def frame(self) -> list[float]:
        """Position [m] and quaternion (u, x, y, z) of the body frame, global."""
        return self._values(0, 7) if self.row >= 0 else [*self._frame]

    def GetPosition(self) -> GzVector:
        """Global position of the body frame [m]."""
        return self.GetPose().pos

    def GetRotation(self) -> GzQuatern:
        """Global rotation of the body frame."""
        return self.GetPose().rot

    @exclusive
    def SetPose(self, pose: GzPose) -> None:
        """Put the body frame at a global pose [m]; velocities stay as they are.

        Raises:
            ParameterError: a component is not finite.
        """
        pose = GzPoseOf(pose)
        position = GzVector(*finite_tuple(pose.pos, 3, "position [m]", LARGEST))
        rotation = GzQuaternNormal(rotation_tuple(pose.rot, "rotation"))
        if max(map(abs, position)) > FAR:
            self.engine.extend_range()
        if self.row < 0:
            self._frame = [*position, *rotation]
            self.engine.moved_dummies.add(self)
            self.engine.tables.record.changes += 1
            for geom in self.geoms:
                geom.follow_dummy()
            self.engine.wake()
            return
        origin = GzVectorAdd(position, rotate(rotation, self.com))
        ode().dBodySetPosition(self.id, *origin)
        ode().dBodySetQuaternion(self.id, (ctypes.c_double * 4)(*rotation))
        if self.auto_disable:
            self.Enable(True)
        self.engine.tables.body_moved(self.row)

    def SetPosition(self, position: VectorLike) -> None:
        """Move the body frame to a global position [m]."""
        self.SetPose(GzPose(GzVector(*finite_tuple(position, 3, "position [m]")), self.GetRotation()))

    def SetRotation(self, rotation: QuaternLike) -> None:
        """Turn the body about its frame's origin."""
        self.SetPose(GzPose(self.GetPosition(), GzQuatern(*rotation_tuple(rotation, "rotation"))))

    def GetCoMPose(self) -> GzPose:
        """Global pose of the centre of mass [m]."""
        if self.row < 0:
            return self.GetPose()
        values = self._values(3, 10)
        return GzPose(GzVector(*values[4:7]), GzQuatern(*values[:4]))

    @property
    def com(self) -> GzVector:
        """The centre of mass in the body frame [m]; zero for a dummy."""
        if self.row < 0:
            return GzVector()
        self._require_open()
        return GzVector(*self._table.com[self.row].tolist())

    def GetLinearVel(self) -> GzVector:
        """Velocity of the centre of mass [m/s], global; zero for a dummy."""
        return GzVector(*self._values(10, 13)) if self.row >= 0 else GzVector()

    def SetLinearVel(self, velocity: VectorLike) -> None:
        """Set the velocity of the centre of mass [m/s], global."""
        self._set_velocity(ode().dBodySetLinearVel, velocity, "linear velocity [m/s]")

    def GetAngularRate(self) -> GzVector:
        """Angular velocity [rad/s], global; zero for a dummy."""
        return GzVector(*self._values(13, 16)) if self.row >= 0 else GzVector()

    def GetAngularVel(self) -> GzQuatern:
        """The quaternion's derivative, (0, w/2) q, as in the legacy server; `GetAngularRate` is in [rad/s]."""
        half_rate = (0.5 * w for w in self.GetAngularRate())
        return GzQuaternMul(GzQuaternSetVector(GzVector(*half_rate)), self.GetRotation())

    def SetAngularVel(self, velocity: VectorLike) -> None:
        """Set the angular velocity [rad/s], global."""
        self._set_velocity(ode().dBodySetAngularVel, velocity, "angular velocity [rad/s]")

    @exclusive
    def _set_velocity(self, function: Callable[..., Any], velocity: VectorLike, what: str) -> None:
        values = finite_tuple(velocity, 3, what, LARGEST)
        if self.row >= 0:
            function(self.id, *values)
            self.wake()
            self.engine.tables.body_moved(self.row)

    def GetPointVel(self, point: VectorLike) -> GzVector:
        """Velocity of the body at a global point [m/s], global."""
        if self.row < 0:
            return GzVector()
        return point_velocity(self._values(7, 16), point)

    def GetLinearAccel(self) -> GzVector:
        """Acceleration of the centre of mass in the last step [m/s^2], global, gravity and contacts included.

        Zero unless the engine's `record_motion` is on.
        """
        return self._motion(0)

    def GetAngularAccel(self) -> GzVector:
        """Angular acceleration in the last step [rad/s^2], global; zero unless the engine's `record_motion` is on."""
        return self._motion(3)

    def GetAppliedForce(self) -> GzVector:
        """The force applied to the body in the last step [N], global; without gravity, contacts and joints.

        Zero unless the engine's `record_motion` is on.
        """
        return self._motion(6)

    def GetAppliedTorque(self) -> GzVector:
        """The torque applied in the last step [N m], likewise."""
        return self._motion(9)

    def GetWeight(self) -> GzVector:
        """The force of gravity in the last step [N], global; zero unless the engine's `record_motion` is on."""
        if self.row < 0:
            return GzVector()
        self._require_open()
        if not self._table.motion[self.row, 12]:
            return GzVector()
        mass = self.mass
        return GzVector(*(mass * g for g in self.engine.gravity))

    def _motion(self, column: int) -> GzVector:
        """Three columns of what the last step recorded."""
        if self.row < 0:
            return GzVector()
        self._require_open()
        return GzVector(*self._table.motion[self.row, column : column + 3].tolist())

    def GetKineticEnergy(self) -> float:
        """Energy of motion [J]: m v^2 / 2 + w I w / 2."""
        mass, spin = self.GetMass(), self.GetAngularRate()
        w = rotate(GzQuaternInverse(self.GetRotation()), spin)
        turning = sum(w[i] * mass.I[4 * i + j] * w[j] for i in range(3) for j in range(3))
        return 0.5 * float(mass.mass * sum(v * v for v in self.GetLinearVel()) + turning)

    def GetPotentialEnergy(self) -> float:
        """Energy of height in the world's gravity [J], from the origin; 0 where gravity does not act."""
        if not self.GetGravityMode():
            return 0.0
        height = sum(g * x for g, x in zip(self.engine.gravity, self.GetCoMPose().pos, strict=True))
        return -self.mass * height

    # Switches ----------------------------------------------------------------------------------------------------

    @exclusive
    def Enable(self, enable: bool) -> None:
        """Switch the body's motion on or off; a disabled body wakes when an enabled one touches it."""
        if self.row >= 0:
            self.engine.tables.disturb()
            if enable:
                ode().dBodyEnable(self.id)
            else:
                ode().dBodyDisable(self.id)

    def wake(self) -> None:
        """Wake the body if it may sleep; one that was disabled stays so."""
        if self.auto_disable:
            self.Enable(True)

    @exclusive
    def set_auto_disable(self, on: bool) -> None:
        """Whether the body sleeps after 1 s and 5 steps below 0.1 m/s and 0.1 rad/s.

        It wakes when something awake touches it, and when it is moved or an effort is applied to it.
        """
        if self.row < 0:
            return
        self._require_open()
        lib, self.auto_disable = ode(), bool(on)
        if on:
            self.engine.auto_disabled.add(self)
        else:
            self.engine.auto_disabled.discard(self)
        lib.dBodySetAutoDisableLinearThreshold(self.id, REST_SPEED)
        lib.dBodySetAutoDisableAngularThreshold(self.id, REST_SPEED)
        lib.dBodySetAutoDisableTime(self.id, REST_TIME)
        lib.dBodySetAutoDisableSteps(self.id, REST_STEPS)
        lib.dBodySetAutoDisableFlag(self.id, int(self.auto_disable))
        self.Enable(True)  # which restarts the idle time

    @exclusive
    def IsEnabled(self) -> bool:
        """Whether the body is awake; a dummy never is."""
        return self.row >= 0 and bool(ode().dBodyIsEnabled(self.id))

    @exclusive
    def SetGravityMode(self, mode: bool) -> None:
        """Whether gravity acts on this body."""
        if self.row >= 0:
            ode().dBodySetGravityMode(self.id, int(bool(mode)))

    @exclusive
    def GetGravityMode(self) -> int:
        """1 if gravity acts on this body, else 0."""
        return int(ode().dBodyGetGravityMode(self.id)) if self.row >= 0 else 0

    @exclusive
    def SetFiniteRotationMode(self, mode: int) -> None:
        """1: rotations are integrated exactly, which suits fast wheels; 0: the quick way."""
        if self.row >= 0:
            ode().dBodySetFiniteRotationMode(self.id, int(bool(mode)))

    @exclusive
    def SetFiniteRotationAxis(self, x: float, y: float, z: float) -> None:
        """The global axis about which mode 1 is exact; zero for all axes."""
        if self.row >= 0:
            ode().dBodySetFiniteRotationAxis(self.id, *finite_tuple((x, y, z), 3, "axis"))

    @exclusive
    def set_damping(self, linear: float, angular: float) -> None:
        """Share of linear and angular velocity that is lost in each step, 0 to 1."""
        self.damping = min(1.0, not_negative(linear, "damping")), min(1.0, not_negative(angular, "angular damping"))
        if self.row >= 0:
            ode().dBodySetLinearDamping(self.id, self.damping[0])
            ode().dBodySetAngularDamping(self.id, self.damping[1])

    @exclusive
    def set_kinematic(self, kinematic: bool) -> None:
        """Whether the body moves by its velocity only: forces and contacts do not move it."""
        if self.row >= 0:
            self.kinematic = bool(kinematic)
            if kinematic:
                ode().dBodySetKinematic(self.id)
            else:
                ode().dBodySetDynamic(self.id)

    # Forces: they act for one step -------------------------------------------------------------------------------

    @exclusive
    def GetForce(self) -> GzVector:
        """The global force accumulated for the next step [N]."""
        return GzVector(*ode().dBodyGetForce(self.id).contents[:3]) if self.row >= 0 else GzVector()

    @exclusive
    def GetTorque(self) -> GzVector:
        """The global torque accumulated for the next step [N m]."""
        return GzVector(*ode().dBodyGetTorque(self.id).contents[:3]) if self.row >= 0 else GzVector()

    def SetForce(self, force: VectorLike) -> None:
        """Replace the force of the next step [N], global, at the centre of mass."""
        self._force(ode().dBodySetForce, force)

    def SetTorque(self, x: float, y: float, z: float) -> None:
        """Replace the torque of the next step [N m], global."""
        self._force(ode().dBodySetTorque, (x, y, z))

    def AddForce(self, x: float, y: float, z: float) -> None:
        """Add a global force at the centre of mass [N]."""
        self._force(ode().dBodyAddForce, (x, y, z))

    def AddTorque(self, x: float, y: float, z: float) -> None:
        """Add a global torque [N m]."""
        self._force(ode().dBodyAddTorque, (x, y, z))

    def AddRelForce(self, x: float, y: float, z: float) -> None:
        """Add a force along the body's own axes [N]."""
        self._force(ode().dBodyAddRelForce, (x, y, z))

    def AddRelTorque(self, x: float, y: float, z: float) -> None:
        """Add a torque about the body's own axes [N m]."""
        self._force(ode().dBodyAddRelTorque, (x, y, z))

    def AddForceAtPos(self, fx: float, fy: float, fz: float, px: float, py: float, pz: float) -> None:
        """Add a global force [N] at a global point [m]."""
        self._force(ode().dBodyAddForceAtPos, (fx, fy, fz, px, py, pz))

    def AddForceAtRelPos(self, fx: float, fy: float, fz: float, px: float, py: float, pz: float) -> None:
        """Add a global force [N] at a point given relative to the centre of mass, in body axes [m]."""
        self._force(ode().dBodyAddForceAtRelPos, (fx, fy, fz, px, py, pz))

    @exclusive
    def _force(self, function: Callable[..., Any], values: VectorLike | Sequence[float]) -> None:
        numbers = finite_tuple(values, len(values), "force [N], torque [N m] or point [m]")
        if self.row >= 0:
            function(self.id, *numbers)
            self.engine.tables.disturb()
            self.wake()

    # Divergence --------------------------------------------------------------------------------------------------

    @exclusive
    def recover(self, *, drop_efforts: bool) -> None:
        """After a step in which ODE failed or bodies diverged: stop this body if its state is out of range.

        Args:
            drop_efforts: the step was abandoned, so efforts that were to act in it only are still there.
        """
        if drop_efforts:
            self._drop_efforts()
        pose = self.GetPose()
        position, rotation = pose.pos, pose.rot
        speeds = *self.GetLinearVel(), *self.GetAngularRate()
        numbers = (*position, *self.GetCoMPose().pos, *rotation, *speeds)
        if all(abs(number) <= 2.0 * LARGEST for number in numbers):
            return
        self.report_divergence()
        self._drop_efforts()
        self._table.motion[self.row] = 0.0
        self.SetLinearVel(_STILL)
        self.SetAngularVel(_STILL)
        usable = all(map(math.isfinite, rotation)) and any(rotation)
        inside = GzVector(*(_clamped(number) for number in position))
        self.SetPose(GzPose(inside, rotation if usable else GzQuaternIdent()))

    def _drop_efforts(self) -> None:
        self.SetForce(_STILL)
        self.SetTorque(*_STILL)

    def report_divergence(self) -> None:
        """Report that this body diverged and was stopped, the first time."""
        if self.diverged:
            return
        self.diverged = True
        log.error(
            "body %s diverged; its velocity was reset: a force, gain or stiffness is too large or a mass too small for "
            "the step time, or joints and contacts contradict each other",
            self.label,
        )

    # Geoms and mass ----------------------------------------------------------------------------------------------

    def GetGeoms(self) -> list[Geom]:
        """The geoms in order of construction."""
        return list(self.geoms)

    def GetNumGeoms(self) -> int:
        """How many geoms there are."""
        return len(self.geoms)

    @property
    def mass(self) -> float:
        """Total mass [kg]; 0 for a dummy."""
        return float(self.GetMass().mass)

    @exclusive
    def GetMass(self) -> mass_.Mass:
        """The mass matrix ODE uses: mass [kg], inertia [kg m^2] about the centre of mass in body axes."""
        result = mass_.Mass()
        if self.row >= 0:
            ode().dBodyGetMass(self.id, ctypes.addressof(result))
        return result

    @exclusive
    def UpdateCoM(self) -> None:
        """Recompute mass and centre of mass from the geoms; nothing moves in the world. Geoms call this themselves."""
        if self.row < 0:
            return
        if self._given_mass is not None:
            self._take_mass(self._given_mass)
            return
        own, volumes = self._sums or _mass_sums()
        total = own.of(self.geoms)
        if total is None:
            # ODE needs some mass: that of the volumes at 1 kg/m^3, if all geoms are massless.
            total = volumes.of(self.geoms)
        if total is not None:
            self._take_mass(total)

    @contextlib.contextmanager
    def assembly(self) -> Iterator[None]:
        """For a `with` block that adds geoms, and changes none but the last one of them.

        The body's mass is always that of its geoms, as without it, but the time of each new one does not grow with
        their number; ODE's geoms are placed about the centre of mass at the end.
        """
        self._sums = _mass_sums()
        try:
            yield
        finally:
            self._sums = None
            for geom in self.geoms:
                geom.place()

    @exclusive
    def SetMassMatrix(self, mass: mass_.Mass) -> None:
        """Give the body a mass matrix, in its own frame, in place of the sum of its geoms'.

        Raises:
            ParameterError: it is not a possible mass matrix; the body keeps the one it has.
        """
        if not isinstance(mass, mass_.Mass):
            raise ParameterError(f"body {self.label!r} takes a mass matrix; {mass!r} is none")
        before, self._given_mass = self._given_mass, mass
        try:
            self.UpdateCoM()
        except ParameterError:
            self._given_mass = before
            raise

    def _take_mass(self, total: mass_.Mass) -> None:
        """Set ODE's mass matrix; the body frame stays where it is."""
        pose = self.GetPose()
        with_quirk = "originInertia" in self.engine.quirks
        final = mass_.about_origin(total) if with_quirk else mass_.about_centre(total)
        if not (max(map(abs, total.c[:3])) <= LARGEST and mass_.is_possible(final)):
            raise ParameterError(
                f"body {self.bodyName or 'unnamed'!r}: {total.mass:g} kg about {tuple(total.c[:3])} with such moments "
                "of inertia is out of range"
            )
        self._table.com[self.row] = total.c[:3]
        ode().dBodySetMass(self.id, ctypes.addressof(final))
        if self.kinematic:
            self.set_kinematic(True)  # ODE resets it with a new mass
        if self._sums is None:
            for geom in self.geoms:
                geom.place()
        self.SetPose(pose)

    def global_pose(self, relative: GzPose) -> GzPose:
        """A pose given in this body's frame, expressed globally."""
        return GzCoordPoseAdd(relative, self.GetPose())


def _mass_sums() -> _MassSums:
    """Sums of the geoms' masses, and of those that their volumes have."""
    return mass_.MassSum(lambda geom: geom.GetBodyMassMatrix()), mass_.MassSum(
        lambda geom: geom.body_mass(geom.volume_mass)
    )


def _clamped(number: float) -> float:
    return max(-LARGEST, min(LARGEST, number)) if math.isfinite(number) else 0.0


def point_velocity(motion: Sequence[float], point: VectorLike) -> GzVector:
    """Velocity of a body at a global point [m/s]: v + w x (point - centre).

    Args:
        motion: position of the centre of mass [m], its velocity [m/s], angular velocity [rad/s]; all global.
        point: [m].
    """
    x, y, z, vx, vy, vz, wx, wy, wz = motion
    px, py, pz = point
    px, py, pz = px - x, py - y, pz - z
    return GzVector(vx + (wy * pz - wz * py), vy + (wz * px - wx * pz), vz + (wx * py - wy * px))


@exclusive
def place_dummies(
    engine: Engine, bodies: Sequence[Body], positions: NDArray[np.float64], rotations: NDArray[np.float64]
) -> None:
    """Put dummies at global poses, as `Body.SetPose` puts each: positions [m], shape (n, 3); rotations, shape (n, 4).

    Raises:
        ParameterError: a number is not finite.
    """
    frames = engine.native.frames(positions, rotations, FAR)
    if frames is None:
        for body, position, rotation in zip(bodies, positions.tolist(), rotations.tolist(), strict=True):
            body.SetPose(GzPose(GzVector(*position), GzQuatern(*rotation)))
        return
    handles, rows = [], []
    for row, (body, frame) in enumerate(zip(bodies, frames.tolist(), strict=True)):
        body._frame = frame
        for geom in body.geoms:
            if handle := geom.centred:
                handles.append(handle)
                rows.append(row)
            else:
                geom.follow_dummy()
    engine.native.place(handles, rows, frames)
    engine.moved_dummies.update(bodies)
    engine.tables.record.changes += 1
    engine.wake()
