"""BuoyancyPlugin: buoyancy of a model in a fluid that fills the world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.law import law
from libgz.classic.common import gzwarn
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Link, Model
    from libgz.sdf.element import Element

WATER = 999.1026  # [kg/m^3] at 15 degrees and normal pressure


class BuoyancyPlugin(ModelPlugin):
    """Applies to each link the buoyancy of the fluid that it displaces: -density * volume * gravity.

    The force acts at the centre of volume. Volumes are those of the collisions where the element of the link does not
    give them; those of meshes are their bounding boxes', as in Gazebo. The fluid has no surface and no drag;
    `<velocity_decay>` or another plugin can add drag.

    Elements:
        fluid_density: [kg/m^3] (999.1026, water).
        link name="...": of a link, with volume [m^3] and center_of_volume [m] in the link's frame (those of its
            collisions).
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the density, and the volumes of all links."""
        self.world = model.GetWorld()
        self.density = sdf.Get(float, "fluid_density", WATER)[0]
        given = {element.Get(str, "name"): element for element in sdf.named("link")}
        self.volumes: list[tuple[Link, float, Vector3d]] = []
        for link in model.GetLinks():
            element = given.pop(link.GetName(), None)
            volume, centre = volume_of(link)
            if element is not None:
                volume, centre = _given(element, volume, centre)
            if volume > 0.0:
                self.volumes.append((link, volume, centre))
            else:
                gzwarn(f"{self.GetHandle()}: link {link.GetScopedName()} has no volume, and no buoyancy")
        for name, element in given.items():
            gzwarn(f"{element.where}: Specified link [{name}] not found.")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @law
    def OnUpdate(self) -> None:
        """Apply the forces."""
        up = -self.world.Gravity() * self.density
        for link, volume, centre in self.volumes:
            link.AddForceAtWorldPosition(up * volume, link.WorldPose().CoordPositionAdd(centre))


def _given(element: Element, volume: float, centre: Vector3d) -> tuple[float, Vector3d]:
    """Volume and centre of an element; where they are missing or invalid, those of the collisions."""
    given = element.Get(float, "volume")
    if given > 0.0:
        volume = given
    else:
        gzwarn(f"{element.where}: <volume> is {given:g} m^3; it must be positive; that of the collisions is used")
    return volume, element.Get(Vector3d, "center_of_volume", centre)[0]


def volume_of(link: Link) -> tuple[float, Vector3d]:
    """(volume [m^3], its centre in the link's frame [m]) of a link's collisions."""
    total, moment = 0.0, Vector3d()
    for collision in link.GetCollisions():
        volume = collision.GetShape().ComputeVolume()
        total += volume
        moment += collision.RelativePose().Pos() * volume
    return total, moment / total if total > 0.0 else moment


GZ_REGISTER_MODEL_PLUGIN(BuoyancyPlugin)
