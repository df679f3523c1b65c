"""ModelPropShop: five images of a model, for a catalogue of models."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError
from libgz.base.files import read_limited
from libgz.classic import msgs, transport
from libgz.classic.common.console import gzerr, gzmsg
from libgz.classic.event import Events
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.physics import get_world
from libgz.classic.plugin import GZ_REGISTER_SYSTEM_PLUGIN, SystemPlugin
from libgz.rendering.framing import free_camera
from libgz.rendering.image import write_image

if TYPE_CHECKING:
    from libgz.classic.physics import Model, World

# Directions from which the images look: from above at a corner, above, front, side, back.
DIRECTIONS = ((-1.0, 1.0, -0.7), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
SIZE = 960, 540  # of an image [px]
DISTANCE = 1.2  # of the camera from the centre, in diagonals of the model
PATIENCE = 100  # iterations


class ModelPropShop(SystemPlugin):
    """Inserts a model, saves the images 1.png to 5.png of it, and ends the server.

    ``gzserver -s libModelPropShop.so worlds/blank.world --propshop-save FOLDER --propshop-model MODEL.sdf``; without
    --propshop-model it is the first model of the world. The world must not be paused.
    """

    STATE = ()

    def Load(self, argc: int = 0, argv: list[str] | None = None) -> None:
        """Read the command line.

        Raises:
            NotFoundError: there is no such file.
        """
        given = argv or []
        words = dict(pairwise(given))
        words |= dict(word.split("=", 1) for word in given if word.startswith("--propshop-") and "=" in word)
        self.folder = Path(words.get("--propshop-save", "."))
        self.file = words.get("--propshop-model")
        if self.file is not None and not Path(self.file).is_file():
            raise NotFoundError(f"Unable to open file[{self.file}]")
        self.iterations = 0
        self.connections = [Events.ConnectWorldCreated(self.OnWorldCreated)]

    def OnWorldCreated(self, name: str) -> None:
        """Insert the model."""
        self.world: World = get_world(name)
        self.before = {model.GetName() for model in self.world.Models()} if self.file is not None else set()
        if self.file is not None:
            self.world.InsertModelString(read_limited(Path(self.file)).decode())
        self.connections.append(Events.ConnectWorldUpdateEnd(self.OnUpdate))

    def OnUpdate(self) -> None:
        """Save the images as soon as the model is there, and end the server."""
        self.iterations += 1
        model = next((model for model in self.world.Models() if model.GetName() not in self.before), None)
        if model is None and self.iterations < PATIENCE:
            return
        self.connections.clear()
        try:
            if model is None:
                gzerr("ModelPropShop: there is no model")
            else:
                self._save(model)
        finally:
            self._end_server()

    def _end_server(self) -> None:
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.ServerControl, "/gazebo/server/control")
        self.publisher.Publish(msgs.ServerControl(stop=True))

    def _save(self, model: Model) -> None:
        low, high = _bounds(model)
        centre, distance = (low + high) / 2.0, DISTANCE * max((high - low).Length(), 0.1)
        self.folder.mkdir(parents=True, exist_ok=True)
        camera = free_camera(self.world.core, Pose3d(), SIZE)
        try:
            for number, direction in enumerate(DIRECTIONS, 1):
                look = Vector3d(*direction).Normalize()
                turn = Quaterniond(0.0, -math.asin(look.Z()), math.atan2(look.Y(), look.X()))
                camera.SetPose(Pose3d(centre - look * distance, turn))
                write_image(self.folder / f"{number}.png", camera.Update())
        finally:
            camera.close()
        gzmsg(f"ModelPropShop: saved 5 images of {model.GetName()} in {self.folder}")


def _bounds(model: Model) -> tuple[Vector3d, Vector3d]:
    """The least and the greatest coordinates of what is visible of a model [m]; its origin where that has no size."""
    corners: list[Any] = [
        corner for link in model.family_links() for geom in link.visuals() for corner in geom.bounds()
    ]
    corners = [corner for corner in corners if all(map(math.isfinite, corner))] or [tuple(model.WorldPose().Pos())]
    low, high = (Vector3d(*(side(corner[k] for corner in corners) for k in range(3))) for side in (min, max))
    return low, high


GZ_REGISTER_SYSTEM_PLUGIN(ModelPropShop)
