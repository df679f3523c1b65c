"""gazebo_ros_bumper: contacts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import Endpoint, Parameter
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import Message, message_type

if TYPE_CHECKING:
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
        self.begin()

    def send(self) -> None:
        """Publish the contacts."""
        contacts = self.sensor.Contacts()
        message = message_type("gazebo_msgs/ContactsState")()
        self.stamp(message)
        message.header.frame_id = self.frame_name
        count = len(contacts.contact)
        message.states = [_state(one, index, count) for index, one in enumerate(contacts.contact)]
        self.publication.publish(message)


def _state(contact: Any, index: int, count: int) -> Message:
    state: Any = message_type("gazebo_msgs/ContactState")()
    state.collision1_name, state.collision2_name = contact.collision1, contact.collision2
    state.info = (
        f"Debug:  i:({index}/{count})     my geom:{contact.collision1}   other geom:{contact.collision2}"
        f"         time:{contact.time.sec}.{contact.time.nsec:09d}\n"
    )
    total = state.total_wrench
    for joint in contact.wrench:
        wrench = message_type("geometry_msgs/Wrench")()
        for part in ("force", "torque"):
            source, target, sum_ = getattr(joint.body_1_wrench, part), getattr(wrench, part), getattr(total, part)
            for axis in "xyz":
                value = getattr(source, axis)
                setattr(target, axis, value)
                setattr(sum_, axis, getattr(sum_, axis) + value)
        state.wrenches.append(wrench)
    vector = message_type("geometry_msgs/Vector3")
    state.contact_positions = [vector(x=one.x, y=one.y, z=one.z) for one in contact.position]
    state.contact_normals = [vector(x=one.x, y=one.y, z=one.z) for one in contact.normal]
    state.depths = list(contact.depth)
    return state  # type: ignore[no-any-return]


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosBumper)
