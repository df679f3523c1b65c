"""hector_gazebo_ros_imu: what an IMU on a link measures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.math import Quaterniond, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import OFFSETS, Endpoint, Parameter, Publishing, Rate, Ticks, set_point, set_quaternion
from libgz.ros.session import set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class HectorGazeboRosImu(Publishing, ModelPlugin):
    """Publishes an Imu message of a link: rate and specific force in the link's frame, the orientation in the world."""

    STATE = ("ticks", "velocity", "last")

    parameters = (
        Parameter("topicName", "imu", "measurements"),
        Parameter("serviceName", "", "a service for calibration, which does nothing (the topic's with /calibrate)"),
        Parameter("bodyName", str, "the link"),
        Parameter("frameId", "", "the frame of the measurements (the link's name)"),
        Parameter("updateRate", Rate(0.0), "[Hz]; 0: each iteration"),
        Parameter("accelGaussianNoise", Vector3d(), "standard deviations [m/s^2]"),
        Parameter("rateGaussianNoise", Vector3d(), "standard deviations [rad/s]"),
        *OFFSETS,
    )
    endpoints = (
        Endpoint("publishes", "<topicName>", "sensor_msgs/Imu"),
        Endpoint("serves", "<topicName>/calibrate", "std_srvs/Empty"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        self.world, self.link = model.GetWorld(), named_link(model, ros_elements(sdf), "bodyName")
        self.turn, self.ticks = Quaterniond(*given.rpyOffset), Ticks(given.updateRate)
        message = self.message = message_type("sensor_msgs/Imu")()
        message.header.frame_id = self.frame(given.frameId or given.bodyName)
        message.angular_velocity_covariance[::4] = [value**2 for value in given.rateGaussianNoise]
        message.linear_acceleration_covariance[::4] = [value**2 for value in given.accelGaussianNoise]
        self.publication = self.advertise(given.topicName, "sensor_msgs/Imu", 10)
        name = given.serviceName or f"{given.topicName}/calibrate"
        self.service = self.serve(name, "std_srvs/Empty", self.OnCalibrate)
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
        turn, given, message = self.link.WorldPose().Rot() * self.turn, self.given, self.message
        set_stamp(message.header.stamp, now)
        set_quaternion(message.orientation, turn)
        rate = turn.RotateVectorReverse(self.link.WorldAngularVel())
        force = turn.RotateVectorReverse(change - self.world.Gravity())
        set_point(message.angular_velocity, rate, max(given.rateGaussianNoise))
        set_point(message.linear_acceleration, force, max(given.accelGaussianNoise))
        self.publication.publish(message)


GZ_REGISTER_MODEL_PLUGIN(HectorGazeboRosImu)
