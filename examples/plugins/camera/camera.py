"""A Sensor plugin that finds a red object in each image of its camera, and prints its direction.

Images are wrapped as numpy arrays without a copy.
"""

import math

import numpy as np

from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin, gzmsg


class RedFinder(SensorPlugin):
    """Elements: `<save_folder>`, where every image is saved; without it none is."""

    STATE = ("bearing", "frames")

    def Load(self, sensor, sdf):
        self.sensor = sensor
        self.camera = sensor.Camera()
        self.bearing = None  # [rad], left positive
        self.frames = 0
        if sdf.HasElement("save_folder"):
            self.camera.SetSaveFramePathname(sdf.Get(str, "save_folder"))
            self.camera.EnableSaveFrame(True)
        sensor.SetActive(True)
        self.connection = self.camera.ConnectNewImageFrame(self.OnFrame)

    def OnFrame(self, data, width, height, depth, image_format):
        self.frames += 1
        picture = np.frombuffer(data, dtype=np.uint8).reshape(height, width, 3).astype(int)
        red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
        columns = np.nonzero((red > 2 * green) & (red > 2 * blue) & (red > 40))[1]
        if not len(columns):
            self.bearing = None
            return
        # From the centre of the red pixels to an angle: the image plane is one focal length away.
        focal = width / 2.0 / math.tan(float(self.camera.HFOV()) / 2.0)
        self.bearing = math.atan2((width - 1) / 2.0 - columns.mean(), focal)
        if self.frames % 10 == 1:
            gzmsg(f"red at {math.degrees(self.bearing):+.1f} degrees")


GZ_REGISTER_SENSOR_PLUGIN(RedFinder)
