"""gazebo_ros_bumper: contacts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import Endpoint, Parameter
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics.contact import ContactPoints
    from libgz.sdf.element import Element


class GazeboRosBumper(RosSensor, SensorPlugin):
    """Publishes the contacts of a contact sensor, in the world's frame."""

    parameters = (
        Parameter("bumperTopicName", "bumper_states", "contacts"),
        Parameter("frameName", "world", "frame in the message; the values are in the world's"),
    )
    endpoints = (Endpoint("publishes", "<bumperTopicName>", "gazebo_msgs/ContactsState"),)

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf)
        self.frame_name = self.frame(self.given.frameName)
        self.publication = self.advertise(self.given.bumperTopicName, "gazebo_msgs/ContactsState")
        self.message = message_type("gazebo_msgs/ContactsState")()
        self.states: list[Any] = []  # as many as there ever were contacts
        self.begin()

    def send(self) -> None:
        """Publish the contacts."""
        contacts = self.sensor.points()
        self.states += [message_type("gazebo_msgs/ContactState")() for _ in contacts[len(self.states) :]]
        for index, (state, contact) in enumerate(zip(self.states, contacts, strict=False)):
            _fill(state, contact, index, len(contacts))
        self.stamp(self.message)
        self.message.header.frame_id = self.frame_name
        self.message.states = self.states[: len(contacts)]
        self.publication.publish(self.message)


def _fill(state: Any, contact: ContactPoints, index: int, count: int) -> None:
    """Fill a ContactState."""
    state.collision1_name, state.collision2_name = one, other = contact.names
    seconds, nanoseconds = divmod(contact.time, 10**9)
    state.info = (
        f"Debug:  i:({index}/{count})     my geom:{one}   other geom:{other}         time:{seconds}.{nanoseconds:09d}\n"
    )
    force, torque = state.total_wrench.force, state.total_wrench.torque
    force.x, force.y, force.z, torque.x, torque.y, torque.z = contact.wrenches.sum(0).tolist()
    state.wrenches, state.depths = contact.wrenches, contact.depths
    state.contact_positions, state.contact_normals = contact.positions, contact.normals


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosBumper)
