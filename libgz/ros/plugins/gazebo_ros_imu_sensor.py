"""gazebo_ros_imu_sensor: measurements of an IMU."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.law import Number, ends, law, rarely, unrecorded
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond
from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.ros.packed import PackedMessage
from libgz.ros.plugin import NOISE, OFFSETS, Endpoint, Parameter, Rate, noisy
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.sdf.element import Element
    from libgz.simulation.event import Connection

# Of the sensor itself, by the fields that have their variances in ROS 2.
NOISES = {
    field: [SensorNoiseType[f"IMU_{name.format(axis)}"] for axis in "XYZ"]
    for field, name in {
        "angular_velocity": "ANGVEL_{}_NOISE_RADIANS_PER_S",
        "linear_acceleration": "LINACC_{}_NOISE_METERS_PER_S_SQR",
    }.items()
}


class GazeboRosImuSensor(RosSensor, SensorPlugin):
    """Publishes each measurement; the orientation is that in the world. Noise is on all ten values.

    It looks for measurements at the beginning of iterations: native code measures where nobody is called for it.
    """

    STATE = ("ticks", "last")

    last = Number()  # when what was published last was measured [s]
    connection: Connection | None = None
    own_namespace = True
    parameters = (
        Parameter("topicName", "imu_data", "measurements", ros2="~/out"),
        Parameter("frameName", str, "the frame of the measurements (in ROS 2 the link's name)", ros2=""),
        Parameter("updateRateHZ", Rate(1.0), "at most so many a second [Hz]; 0: each measurement", ros2=Rate(0.0)),
        NOISE,
        *OFFSETS,
        Parameter("initialOrientationAsReference", False, "orientations relative to the one at the start"),
    )
    endpoints = (Endpoint("publishes", "<topicName>", "sensor_msgs/Imu"),)

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRateHZ)
        if not self.given.initialOrientationAsReference:
            sensor.SetWorldToReferenceOrientation(Quaterniond(1.0, 0.0, 0.0, 0.0))
        self.turn = Quaterniond(*self.given.rpyOffset)
        message = message_type("sensor_msgs/Imu")()
        message.header.frame_id = self.frame_of(self.given.frameName) if self.two else self.given.frameName
        for name in ("orientation", "angular_velocity", "linear_acceleration"):
            own = [self.variance(kind) for kind in NOISES.get(name, ())] if self.two else []
            getattr(message, f"{name}_covariance")[::4] = own or self.given.gaussianNoise**2
        self.publication = self.advertise(self.given.topicName, "sensor_msgs/Imu")
        self.message = PackedMessage(self.publication, message)
        self.lawful = not self.two and self.given.gaussianNoise <= 0.0 and not sensor.noises
        self.begin()

    def begin(self) -> None:
        """Begin; the topic is advertised."""
        self.match_activity()

    def match_activity(self) -> None:
        """Let the sensor measure if somebody listens, and publish what it measures from now on."""
        super().match_activity()
        listened = self.publication.listened
        if listened and self.connection is None:
            self.last = self.sensor.schedule.measured
            self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        elif not listened and self.connection is not None:
            self.connection.Disconnect()
            self.connection = None

    @law
    def OnUpdate(self) -> None:
        """Publish the last measurement, if it is a new one and it is time."""
        measured = self.sensor.schedule.measured
        new = (measured > 0.0) & (measured != self.last)
        due = new & self.ticks.is_due(measured)
        if not self.lawful:
            if rarely(due):
                self._publish(measured)
        elif not ends(due == 0.0):
            self.publish_measurement(measured)

    @unrecorded
    def _publish(self, measured: float) -> None:
        self.publish_measurement(measured)

    @law
    def publish_measurement(self, measured: Any) -> None:
        """Publish the last measurement, which was made at a sim time [s]."""
        self.last = measured
        self.ticks.tick(measured)
        message, sensor, deviation = self.message, self.sensor, self.given.gaussianNoise
        w, x, y, z = self.turn * sensor.Orientation()
        message.stamp(measured)
        message.put("orientation", noisy((x, y, z, w), deviation))
        message.put("linear_acceleration", noisy(tuple(sensor.LinearAcceleration()), deviation))
        message.put("angular_velocity", noisy(tuple(sensor.AngularVelocity()), deviation))
        message.send()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosImuSensor)
