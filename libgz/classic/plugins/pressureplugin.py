"""PressurePlugin: the pressure on the collisions of a contact sensor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.physics import BoxShape, get_world
from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN
from libgz.classic.plugins.hooks import ContactPlugin

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class PressurePlugin(ContactPlugin):
    """Publishes the pressure on each box of a contact sensor on ~/<sensor>/tactile, a msgs.Tactile.

    The pressure [Pa] is the normal force of all contacts over the area of the largest side of the box. As in Gazebo,
    only boxes have one, and there is a message only while something presses.
    """

    STATE = ()

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Find the boxes."""
        world = get_world(sensor.WorldName())
        self.areas: dict[str, float] = {}
        for i in range(sensor.GetCollisionCount()):
            name = sensor.GetCollisionName(i)
            collision: Any = world.EntityByName(name)
            shape = collision.GetShape() if collision is not None else None
            if isinstance(shape, BoxShape):
                _, width, length = sorted(shape.Size())
                self.areas[name] = width * length
        self.node = transport.Node()
        self.node.Init(sensor.WorldName())
        self.publisher = self.node.Advertise(msgs.Tactile, f"~/{sensor.Name()}/tactile")
        super().Load(sensor, sdf)

    def OnUpdate(self) -> None:
        """Publish the pressures of a measurement."""
        message = msgs.Tactile()
        for name, area in self.areas.items():
            force = self._normal_force(name)
            if force > 0.0:
                message.collision_name.append(name)
                message.collision_id.append(0)
                message.pressure.append(force / area)
        if message.pressure:
            msgs.Set(message.time, self.sensor.LastMeasurementTime())
            self.publisher.Publish(message)

    def _normal_force(self, name: str) -> float:
        """The force along the normals of the last contact with each other collision [N]."""
        total = 0.0
        for contact in self.sensor.Contacts(name).values():
            turn = contact.collision1.link.WorldPose().Rot()
            for wrench, normal in zip(contact.wrench, contact.normals, strict=True):
                total += abs(turn.RotateVector(wrench.body1Force).Dot(normal))
        return total


GZ_REGISTER_SENSOR_PLUGIN(PressurePlugin)
