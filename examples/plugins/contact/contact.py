"""A Sensor plugin that prints when contacts with the collisions of its contact sensor begin and end."""

from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin, gzmsg


class ContactPrinter(SensorPlugin):
    def Load(self, sensor, sdf):
        self.sensor = sensor
        self.touching = set()
        # Sensors measure while they are active: by always_on in the file, or by SetActive.
        sensor.SetActive(True)
        self.connection = sensor.ConnectUpdated(self.OnUpdate)

    def OnUpdate(self):
        # The contacts since the last measurement: pairs of collisions, each with all its contact points.
        contacts = self.sensor.Contacts().contact
        touching = {(contact.collision1, contact.collision2) for contact in contacts}
        for one, other in sorted(touching - self.touching):
            gzmsg(f"{one} touches {other}")
        for one, other in sorted(self.touching - touching):
            gzmsg(f"{one} has left {other}")
        self.touching = touching

    def SaveState(self):
        # A snapshot of the world keeps this; a set has no order, so it is a list there.
        return sorted(self.touching)

    def LoadState(self, state):
        self.touching = set(state)

    def Reset(self):
        self.touching = set()


GZ_REGISTER_SENSOR_PLUGIN(ContactPrinter)
