"""BuoyancyPlugin: buoyancy of a model in a fluid that fills the world."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.classic.common import gzwarn
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.physics import BoxShape, CylinderShape, SphereShape
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Collision, Link, Model
    from libgz.sdf.element import Element

WATER = 999.1026  # [kg/m^3] at 15 degrees and normal pressure


class BuoyancyPlugin(ModelPlugin):
    """Applies to each link the buoyancy of the fluid that it displaces: -density * volume * gravity.

    The force acts at the centre of volume. Volumes are those of the collisions (box, sphere, cylinder) where the
    element of the link does not give them. The fluid has no surface and no drag; `<velocity_decay>` or another plugin
    can add drag.

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
        volume = shape_volume(collision)
        total += volume
        moment += collision.RelativePose().Pos() * volume
    return total, moment / total if total > 0.0 else moment


def shape_volume(collision: Collision) -> float:
    """The volume of a collision [m^3]; 0 for shapes other than box, sphere and cylinder."""
    shape = collision.GetShape()
    if isinstance(shape, BoxShape):
        return math.prod(shape.Size())
    if isinstance(shape, SphereShape):
        return 4.0 / 3.0 * math.pi * shape.GetRadius() ** 3
    if isinstance(shape, CylinderShape):
        return math.pi * shape.GetRadius() ** 2 * shape.GetLength()
    return 0.0


GZ_REGISTER_MODEL_PLUGIN(BuoyancyPlugin)
