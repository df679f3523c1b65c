"""gazebo_ros_imu: orientation, rate and acceleration of a link."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.math import Quaterniond, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import (
    NOISE,
    OFFSETS,
    Endpoint,
    Parameter,
    Publishing,
    Rate,
    Ticks,
    noise,
    set_point,
    set_quaternion,
)
from libgz.ros.session import set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosImu(Publishing, ModelPlugin):
    """Publishes an Imu message of a link, as the original does: the acceleration is without gravity.

    Rate and acceleration are differences in the world's frame, turned by the link's rotation and not by its inverse;
    gazebo_ros_imu_sensor is the one that measures what an IMU does.
    """

    STATE = ("ticks", "velocity", "last")

    parameters = (
        Parameter("topicName", "/default_imu", "measurements"),
        Parameter("serviceName", "/default_imu", "a service for calibration, which does nothing"),
        Parameter("bodyName", str, "the link"),
        Parameter("frameName", "", "the frame of the measurements (the link's name)"),
        Parameter("updateRate", Rate(0.0), "[Hz]; 0: each iteration"),
        NOISE,
        *OFFSETS,
    )
    endpoints = (
        Endpoint("publishes", "<topicName>", "sensor_msgs/Imu"),
        Endpoint("serves", "<serviceName>", "std_srvs/Empty"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        self.world, self.link = model.GetWorld(), named_link(model, ros_elements(sdf), "bodyName")
        self.turn, self.ticks = Quaterniond(*given.rpyOffset), Ticks(given.updateRate)
        message = self.message = message_type("sensor_msgs/Imu")()
        message.header.frame_id = given.frameName or given.bodyName
        for name in ("orientation", "angular_velocity", "linear_acceleration"):
            getattr(message, f"{name}_covariance")[::4] = given.gaussianNoise**2
        self.publication = self.advertise(given.topicName, "sensor_msgs/Imu")
        self.service = self.serve(given.serviceName, "std_srvs/Empty", self.OnCalibrate)
        self.Reset()
        self.run()

    def Reset(self) -> None:
        """Begin again."""
        self.velocity, self.last = self.link.WorldLinearVel(), self.world.core.GetSimTime()

    def OnCalibrate(self, _request: Any) -> Any:
        """Nothing to do."""
        return self.service.kind.response()

    def work(self, now: float) -> None:
        """Publish."""
        elapsed, self.last = now - self.last, now
        velocity, before = self.link.WorldLinearVel(), self.velocity
        self.velocity = velocity
        change = (velocity - before) / elapsed if elapsed > 0.0 else Vector3d()
        turn, deviation, message = self.turn * self.link.WorldPose().Rot(), self.given.gaussianNoise, self.message
        set_stamp(message.header.stamp, now)
        set_quaternion(message.orientation, turn)
        set_point(message.angular_velocity, turn.RotateVector(_noisy(self.link.WorldAngularVel(), deviation)))
        set_point(message.linear_acceleration, turn.RotateVector(_noisy(change, deviation)))
        self.publication.publish(message)


def _noisy(vector: Vector3d, deviation: float) -> Vector3d:
    return vector + Vector3d(noise(deviation), noise(deviation), noise(deviation)) if deviation > 0.0 else vector


GZ_REGISTER_MODEL_PLUGIN(GazeboRosImu)
