"""A Sensor plugin that logs the begin and the end of contacts of its contact sensor."""

from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin, gzmsg


class TouchTeller(SensorPlugin):
    def Load(self, sensor, sdf):
        self.sensor = sensor
        self.touching = set()
        # Sensors measure when they are active: by always_on in the file, or by SetActive.
        sensor.SetActive(True)
        self.connection = sensor.ConnectUpdated(self.OnUpdate)

    def OnUpdate(self):
        # The contacts since the last measurement, a pair of collisions each, with all points where they touch.
        contacts = self.sensor.Contacts().contact
        touching = {(contact.collision1, contact.collision2) for contact in contacts}
        for one, other in sorted(touching - self.touching):
            gzmsg(f"{one} touches {other}")
        for one, other in sorted(self.touching - touching):
            gzmsg(f"{one} has left {other}")
        self.touching = touching

    def Reset(self):
        self.touching = set()


GZ_REGISTER_SENSOR_PLUGIN(TouchTeller)
