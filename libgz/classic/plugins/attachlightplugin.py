"""AttachLightPlugin: lights of the world that move with links."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, nearest
from libgz.classic.event import Events
from libgz.classic.math import Pose3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link

if TYPE_CHECKING:
    from libgz.classic.physics import Light, Link, Model
    from libgz.sdf.element import Element


class AttachLightPlugin(ModelPlugin):
    """Moves lights of the world with links of the model.

    Elements:
        link: one a link.
            link_name: its name.
            light: one a light: `light_name`, of the world, and `pose` [m, rad] in the link's frame (0 0 0 0 0 0).
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find links and lights.

        Raises:
            NotFoundError: there is no such link or light.
        """
        self.lights: list[tuple[Link, Light, Pose3d]] = []
        for part in sdf.named("link"):
            link = named_link(model, part)
            for element in part.named("light"):
                pose = element.Get(Pose3d, "pose") if element.HasElement("pose") else Pose3d()
                self.lights.append((link, self._light(model, element), pose))
        if not self.lights:
            raise NotFoundError(f"{sdf.where}: <link> with <light> is missing; there must be one for each light")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @staticmethod
    def _light(model: Model, element: Element) -> Light:
        name = element.Get(str, "light_name").strip()
        world = model.GetWorld()
        light = world.Light(name)
        if light is None:
            names = [light.GetName() for light in world.Lights()]
            raise NotFoundError(
                f"{element.where}: <light_name> is {name!r}; the world has {', '.join(names) or 'no light'}"
                f"{nearest(name, names)}"
            )
        found: Light = light
        return found

    def OnUpdate(self) -> None:
        """Place the lights."""
        for link, light, pose in self.lights:
            light.SetWorldPose(pose + link.WorldPose())


GZ_REGISTER_MODEL_PLUGIN(AttachLightPlugin)
