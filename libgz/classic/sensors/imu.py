"""ImuSensor: turning rate, acceleration and orientation of its link."""

from __future__ import annotations

import ctypes
import logging
import math
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import StateError
from libgz.base.geometry import QuaternLike
from libgz.base.law import constant, law, unrecorded
from libgz.classic import msgs
from libgz.classic.math import Quaterniond, Vector3d
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.read import choice, custom_topic, first, known_children, substituted
from libgz.classic.sensors.sensor import LinkSensor, SensorOwner
from libgz.sdf.element import Element

if TYPE_CHECKING:
    from libgz.classic.physics import Link

__all__ = ["ImuSensor"]

log = logging.getLogger("libgz.classic")

_T = SensorNoiseType
RATE_NOISE = (
    _T.IMU_ANGVEL_X_NOISE_RADIANS_PER_S,
    _T.IMU_ANGVEL_Y_NOISE_RADIANS_PER_S,
    _T.IMU_ANGVEL_Z_NOISE_RADIANS_PER_S,
)
ACCEL_NOISE = (
    _T.IMU_LINACC_X_NOISE_METERS_PER_S_SQR,
    _T.IMU_LINACC_Y_NOISE_METERS_PER_S_SQR,
    _T.IMU_LINACC_Z_NOISE_METERS_PER_S_SQR,
)
# Frames by their axes in the world's, which is east, north, up: roll, pitch, yaw [rad].
FRAMES = {"ENU": (0.0, 0.0, 0.0), "NWU": (0.0, 0.0, math.pi / 2.0), "NED": (math.pi, 0.0, math.pi / 2.0)}


class _Reading(ctypes.Structure):
    """A measurement along the sensor's axes, and the velocity then [m/s], which is global."""

    _fields_ = [
        ("velocity", ctypes.c_double * 3),
        ("rate", ctypes.c_double * 3),  # [rad/s]
        ("acceleration", ctypes.c_double * 3),  # [m/s^2]
        ("orientation", ctypes.c_double * 4),
    ]


class ImuSensor(LinkSensor):
    """An inertial measurement unit: everything along its own axes.

    The acceleration is the change of its velocity since the last measurement, less gravity; at rest it is g upwards.
    """

    STATE = ("_reference", "_noisy", "measured")

    topic_suffix: ClassVar[str | None] = "imu"
    topic_added = True
    message_type: ClassVar[Any] = msgs.IMU

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._imu = sdf.child("imu")
        self._read_noise()
        self._reference = self._read_reference()
        described = "enable_orientation" in known_children(self._imu)
        self._has_orientation = not described or self._imu.Get(bool, "enable_orientation")
        self._reading = _Reading(orientation=(1.0, 0.0, 0.0, 0.0))
        self._noisy = Vector3d(), Vector3d()  # turning rate, acceleration, if there is noise

    def _read_noise(self) -> None:
        """Add the noise of each axis; SDF 1.4 and 1.5 also have one for all axes of a kind."""
        for key, kinds in (("angular_velocity", RATE_NOISE), ("linear_acceleration", ACCEL_NOISE)):
            self.add_axis_noise(kinds, first(self._imu, key), "xyz")
        for old in self._imu.named("noise"):
            word = old.Get(str, "type")
            for key, kinds in (("rate", RATE_NOISE), ("accel", ACCEL_NOISE)):
                holder = Element(key, file=old.file, line=old.line)
                noise = old.child(key).Clone()
                noise.name = "noise"
                noise.set_attribute("type", word)
                holder.InsertElement(noise)
                for axis_kind in kinds:
                    self.add_noise(axis_kind, holder)

    def _read_reference(self) -> Quaterniond | None:
        """The reference frame of orientations; None for the one at the start."""
        if not self._imu.HasElement("orientation_reference_frame"):
            return None
        frame = self._imu.child("orientation_reference_frame")
        name = choice(frame, "localization", ("CUSTOM", *FRAMES, "GRAV_UP", "GRAV_DOWN"), "CUSTOM")
        if name in FRAMES:
            return Quaterniond(*FRAMES[name])
        key = "custom_rpy" if name == "CUSTOM" else "grav_dir_x"
        given = first(frame, key)
        if given is not None and given.Get(str, "parent_frame").strip() not in ("", "world"):
            log.warning("%s: <%s>: parent_frame is not used; the world's frame is", given.where, key)
        value = frame.Get(Vector3d, key)
        return Quaterniond(*value) if name == "CUSTOM" else self._along_gravity(frame, value, name == "GRAV_UP")

    def _along_gravity(self, frame: Element, ahead: Vector3d, up: bool) -> Quaterniond:
        """A frame with z against gravity, or along it, and x as close as possible to a direction."""
        z = Vector3d(*self.world.Gravity()) * (-1.0 if up else 1.0)
        x = ahead - z * (ahead.Dot(z) / z.Dot(z)) if z.Length() > 0.0 else Vector3d()
        if x.Length() < 1e-9:
            substituted(frame, "grav_dir_x", "has no direction across gravity, or there is no gravity: ENU is used")
            return Quaterniond(*FRAMES["ENU"])
        x, z = x.Normalized(), z.Normalized()
        y = z.Cross(x)
        return _from_axes(x, y, z)

    def custom_topic(self) -> str:
        """The topic that its file names; an empty string for none."""
        return custom_topic(self._imu) or super().custom_topic()

    def Init(self) -> None:
        """Take the present orientation as the reference, unless the file has one."""
        if self._reference is None:
            self.SetReferencePose()
        self._reading.velocity[:] = tuple(self.world_velocity())

    def reset(self) -> None:
        """Start again with the present state of the link."""
        self._reading.velocity[:] = tuple(self.world_velocity())
        super().reset()

    @property
    def measured(self) -> bytes:
        """The last measurement, for a state."""
        return bytes(self._reading)

    @measured.setter
    def measured(self, values: bytes) -> None:
        if not isinstance(values, bytes) or len(values) != ctypes.sizeof(self._reading):
            raise StateError("the state is damaged: these are not the numbers of an IMU")
        memoryview(self._reading).cast("B")[:] = values  # native code knows where they are

    # Measuring ---------------------------------------------------------------------------------------------------

    def ready(self, elapsed: float) -> bool:
        """Whether time has passed."""
        return elapsed > 0.0

    @law
    def measure(self, elapsed: Any) -> None:
        """Measure rates, acceleration and orientation."""
        turn, reading = self.world_rotation(), self._reading
        velocity, before, gravity = self.world_velocity(), reading.velocity, self.world.core.engine.gravity
        felt = Vector3d(*((v - b) / elapsed - g for v, b, g in zip(velocity, before, gravity, strict=True)))
        reading.rate[:] = tuple(turn.RotateVectorReverse(self.link.body.GetAngularRate()))
        reading.acceleration[:] = tuple(turn.RotateVectorReverse(felt))
        reading.velocity[:] = tuple(velocity)
        if self._has_orientation and self._reference is not None:
            reading.orientation[:] = tuple(self._reference.Inverse() * turn)

    def disturb(self) -> None:
        """Add noise to rates and acceleration."""
        if self.noises:
            rate, acceleration = Vector3d(*self._reading.rate), Vector3d(*self._reading.acceleration)
            self._noisy = self.noisy_vector(RATE_NOISE, rate), self.noisy_vector(ACCEL_NOISE, acceleration)

    def message(self) -> Any:
        """The last measurement as a msgs.IMU."""
        msg = msgs.IMU(entity_name=self.ParentName())
        msgs.Set(msg.stamp, self.LastMeasurementTime())
        msgs.Set(msg.orientation, self.Orientation())
        msgs.Set(msg.angular_velocity, self.AngularVelocity())
        msgs.Set(msg.linear_acceleration, self.LinearAcceleration())
        return msg

    ImuMessage = GetImuMessage = message

    @property
    @constant
    def _has_noise(self) -> bool:
        return bool(self.noises)

    @unrecorded
    def _disturbed(self, index: int) -> Vector3d:
        return self._noisy[index]

    @law
    def AngularVelocity(self, noiseFree: bool = False) -> Vector3d:
        """Turning rate [rad/s]."""
        return Vector3d(*(self._reading.rate if noiseFree or not self._has_noise else self._disturbed(0)))

    @law
    def LinearAcceleration(self, noiseFree: bool = False) -> Vector3d:
        """Acceleration less gravity [m/s^2]."""
        return Vector3d(*(self._reading.acceleration if noiseFree or not self._has_noise else self._disturbed(1)))

    @law
    def Orientation(self) -> Quaterniond:
        """Orientation in the reference frame."""
        return Quaterniond(*self._reading.orientation)

    def SetReferencePose(self) -> None:
        """Take the present orientation as the reference."""
        self._refer_to(self.world_rotation())

    def SetWorldToReferenceOrientation(self, orientation: QuaternLike) -> None:
        """Set the orientation of the reference frame in the world."""
        self._refer_to(Quaterniond(*orientation))

    def _refer_to(self, orientation: Quaterniond) -> None:
        self._reference = orientation
        self.world.core.update_rows_changed()

    GetAngularVelocity, GetLinearAcceleration, GetOrientation = AngularVelocity, LinearAcceleration, Orientation


def _from_axes(x: Vector3d, y: Vector3d, z: Vector3d) -> Quaterniond:
    """The rotation that brings the world's axes onto three others."""
    m = [[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]]
    pitch = math.asin(max(-1.0, min(1.0, -m[2][0])))
    return Quaterniond(math.atan2(m[2][1], m[2][2]), pitch, math.atan2(m[1][0], m[0][0]))
