"""FiducialCameraPlugin: the places of models in the image of a camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.math import Pose3d
from libgz.classic.physics import get_world
from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN
from libgz.classic.plugins.hooks import CameraPlugin

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class FiducialCameraPlugin(CameraPlugin):
    """Publishes which models a camera sees on ~/<sensor>/fiducial, a PosesStamped with each image.

    Each pose has a model's name, and the pixel of the model's origin from the upper left as x and y. A model is seen if
    that pixel shows it.

    Elements:
        fiducial: the name of a model, several. None: all models but the camera's own.
    """

    STATE = ()

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Read the names, and connect to images."""
        self.names = [element.Get(str).strip() for element in sdf.named("fiducial")]
        self.own = sensor.ParentName().partition("::")[0]
        self.world = get_world(sensor.WorldName())
        self.node = transport.Node()
        self.node.Init(sensor.WorldName())
        self.publisher = self.node.Advertise(msgs.PosesStamped, f"~/{sensor.Name()}/fiducial")
        super().Load(sensor, sdf)

    def OnNewFrame(self, data: bytes, width: int, height: int, depth: int, image_format: str) -> None:
        """Publish the models of an image."""
        message = msgs.PosesStamped()
        msgs.Set(message.time, self.sensor.LastMeasurementTime())
        scene = self.camera.GetScene()
        for model in self.world.Models():
            name = model.GetName()
            if name not in self.names if self.names else name == self.own:
                continue
            pixel = self.camera.Project(model.WorldPose().Pos())
            if not (0 <= pixel.X() < width and 0 <= pixel.Y() < height):
                continue
            seen = scene.GetModelVisualAt(self.camera, pixel)
            if seen is not None and seen.Name() == name:
                pose = message.pose.add()
                msgs.Set(pose, Pose3d(pixel.X(), pixel.Y(), 0.0, 0.0, 0.0, 0.0))
                pose.name = name
        self.publisher.Publish(message)


GZ_REGISTER_SENSOR_PLUGIN(FiducialCameraPlugin)
