"""ImuSensor: turning rate, acceleration and orientation of its link."""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.common import Time
from libgz.classic.math import Quaterniond, Vector3d
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.read import choice, custom_topic, wrong
from libgz.classic.sensors.sensor import Sensor
from libgz.geometry import QuaternLike
from libgz.sdf.element import Element

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.manager import WorldSensors

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


class ImuSensor(Sensor):
    """An inertial measurement unit: everything along its own axes.

    The acceleration is the change of its velocity since the last measurement, less gravity; at rest it is g upwards.
    """

    topic_suffix: ClassVar[str | None] = "imu"
    message_type: ClassVar[str] = "IMU"

    def __init__(self, sensors: WorldSensors, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.link = parent
        self._imu = sdf.child("imu")
        self._read_noise()
        self._reference = self._read_reference()
        self._tells_orientation = "enable_orientation" not in self._known() or self._imu.Get(bool, "enable_orientation")
        self._velocity = Vector3d()
        self._true = self._noisy = Vector3d(), Vector3d()  # turning rate, acceleration
        self._orientation = Quaterniond(1.0, 0.0, 0.0, 0.0)

    def _known(self) -> Any:
        return self._imu.description.children if self._imu.description is not None else {}

    def _read_noise(self) -> None:
        """Of each axis; in SDF 1.4 and 1.5 also one for all axes of a kind."""
        for key, kinds in (("angular_velocity", RATE_NOISE), ("linear_acceleration", ACCEL_NOISE)):
            holder = next(self._imu.named(key), None)
            for axis, kind in zip("xyz", kinds, strict=True):
                self.add_noise(kind, next(holder.named(axis), None) if holder is not None else None)
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
        """The frame that the orientation is told in; None for the one it begins in."""
        if not self._imu.HasElement("orientation_reference_frame"):
            return None
        frame = self._imu.child("orientation_reference_frame")
        name = choice(frame, "localization", ("CUSTOM", *FRAMES, "GRAV_UP", "GRAV_DOWN"))
        if name in FRAMES:
            return Quaterniond(*FRAMES[name])
        key = "custom_rpy" if name == "CUSTOM" else "grav_dir_x"
        given = next(frame.named(key), None)
        if given is not None and given.Get(str, "parent_frame"):
            log.warning("%s: <%s>: parent_frame is not used; the world's frame is", given.where, key)
        value = frame.Get(Vector3d, key)
        return Quaterniond(*value) if name == "CUSTOM" else self._along_gravity(frame, value, name == "GRAV_UP")

    def _along_gravity(self, frame: Element, ahead: Vector3d, up: bool) -> Quaterniond:
        """A frame with z against gravity, or along it, and x as near as can be to a direction."""
        z = Vector3d(*self.world.Gravity()) * (-1.0 if up else 1.0)
        x = ahead - z * (ahead.Dot(z) / z.Dot(z)) if z.Length() > 0.0 else Vector3d()
        if x.Length() < 1e-9:
            raise wrong(frame, "grav_dir_x", "has no direction across gravity, or there is no gravity")
        x, z = x.Normalized(), z.Normalized()
        y = z.Cross(x)
        return _from_axes(x, y, z)

    def Topic(self) -> str:
        """``~/model/link/sensor/imu``, or what its file says."""
        return custom_topic(self._imu) or super().Topic()

    GetTopic = Topic

    def Init(self) -> None:
        """Take the present orientation as the reference, unless the file has one."""
        if self._reference is None:
            self.SetReferencePose()
        self._velocity = self.link.WorldLinearVel(self._pose.pos)

    def reset(self) -> None:
        """Begin anew where the link stands now."""
        self._velocity = self.link.WorldLinearVel(self._pose.pos)
        super().reset()

    # Measuring ---------------------------------------------------------------------------------------------------

    def measure(self, now: float) -> bool:
        """Measure; nothing if no time has passed."""
        passed = now - self._measured
        self._measured = now
        if passed <= 0.0:
            return False
        turn = self.link.WorldPose().rot * self._pose.rot
        velocity = self.link.WorldLinearVel(self._pose.pos)
        change = (velocity - self._velocity) / passed
        self._velocity = velocity
        rate = turn.RotateVectorReverse(self.link.WorldAngularVel())
        acceleration = turn.RotateVectorReverse(change - self.world.Gravity())
        self._true = rate, acceleration
        self._noisy = self._with_noise(rate, RATE_NOISE), self._with_noise(acceleration, ACCEL_NOISE)
        if self._tells_orientation and self._reference is not None:
            self._orientation = self._reference.Inverse() * turn
        if self.listened():
            self.publish(self.ImuMessage())
        return True

    def _with_noise(self, value: Vector3d, kinds: tuple[SensorNoiseType, ...]) -> Vector3d:
        if not self.noises:
            return value
        return Vector3d(*(self.noisy(kind, part) for kind, part in zip(kinds, value, strict=True)))

    def ImuMessage(self) -> Any:
        """The last measurement as a msgs.IMU."""
        from libgz.classic import msgs

        msg = self.new_message(entity_name=self.ParentName())
        msgs.Set(msg.stamp, Time(self._measured))
        msgs.Set(msg.orientation, self._orientation)
        msgs.Set(msg.angular_velocity, self._noisy[0])
        msgs.Set(msg.linear_acceleration, self._noisy[1])
        return msg

    GetImuMessage = ImuMessage

    def AngularVelocity(self, noiseFree: bool = False) -> Vector3d:
        """Turning rate [rad/s]."""
        return Vector3d(*(self._true if noiseFree else self._noisy)[0])

    def LinearAcceleration(self, noiseFree: bool = False) -> Vector3d:
        """Acceleration less gravity [m/s^2]."""
        return Vector3d(*(self._true if noiseFree else self._noisy)[1])

    def Orientation(self) -> Quaterniond:
        """Orientation in the reference frame."""
        return Quaterniond(*self._orientation)

    def SetReferencePose(self) -> None:
        """Tell orientations from now on from the present one."""
        self._reference = self.link.WorldPose().rot * self._pose.rot

    def SetWorldToReferenceOrientation(self, orientation: QuaternLike) -> None:
        """Set the orientation of the reference frame in the world."""
        self._reference = Quaterniond(*orientation)

    GetAngularVelocity, GetLinearAcceleration, GetOrientation = AngularVelocity, LinearAcceleration, Orientation


def _from_axes(x: Vector3d, y: Vector3d, z: Vector3d) -> Quaterniond:
    """The rotation that brings the world's axes onto three others."""
    m = [[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]]
    pitch = math.asin(max(-1.0, min(1.0, -m[2][0])))
    return Quaterniond(math.atan2(m[2][1], m[2][2]), pitch, math.atan2(m[1][0], m[0][0]))
