"""SimpleTrackedVehiclePlugin: a vehicle whose tracks are solid links with a running surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, nearest
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._tracks import TrackedVehiclePlugin
from libgz.ode.types import Surface

if TYPE_CHECKING:
    from libgz.classic.physics import Link, Model
    from libgz.physics.geom import Geom
    from libgz.sdf.element import Element


class SimpleTrackedVehiclePlugin(TrackedVehiclePlugin):
    """Drives a vehicle by the surfaces of its tracks, which run round them; TrackedVehiclePlugin is its base.

    The tracks have no parts that move: whatever touches one, is carried by its surface, below backward, in front
    downward, and above forward. Flippers are tracks that joints turn.

    Elements:
        body: the link whose y axis is that of the tracks.
        left_track, right_track: links.
        left_flipper, right_flipper: links, which run with the track of their side; several.
        collide_without_contact_bitmask: read and not used.
        those of TrackedVehiclePlugin.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the links, and subscribe.

        Raises:
            NotFoundError: a link is missing.
        """
        self.body = named_link(model, sdf, "body")
        sides = [
            [named_link(model, sdf, f"{side}_track"), *self._flippers(model, sdf, side)] for side in ("left", "right")
        ]
        self.listen(model, sdf)
        self.tracks = [[geom for link in links for geom in self._surfaces(link)] for links in sides]
        model.SetAutoDisable(False)

    @staticmethod
    def _flippers(model: Model, sdf: Element, side: str) -> list[Link]:
        found = []
        for element in sdf.named(f"{side}_flipper"):
            name = element.Get(str).strip()
            link = model.GetLink(name)
            if link is None:
                names = [link.GetName() for link in model.family_links()]
                raise NotFoundError(
                    f"{element.where}: <{side}_flipper> link {name!r} does not exist; model {model.GetName()!r} has "
                    f"{', '.join(names)}{nearest(name, names)}"
                )
            found.append(link)
        return found

    def _surfaces(self, link: Link) -> list[Geom]:
        """The geoms of a track, whose surfaces can run from now on."""
        self.set_friction(link)
        across = self.body.WorldPose().Rot().RotateVector(Vector3d(0.0, 1.0, 0.0))
        geoms = []
        for collision in link.GetCollisions():
            axis = collision.WorldPose().Rot().RotateVectorReverse(across)
            for column, value in zip((Surface.FDIR1, Surface.FDIR1 + 1, Surface.FDIR1 + 2), axis, strict=True):
                collision.geom.set_surface(column, value)
            geoms.append(collision.geom)
        return geoms

    def OnUpdate(self) -> None:
        """Set the speeds of the surfaces, and the point about which the vehicle turns by them."""
        left, right = self.speeds
        kind, pivot = 1.0, Vector3d()
        if left != right:
            radius = (left + right) / (right - left) * self.separation / 2.0  # to the left
            kind, pivot = 2.0, self.body.WorldPose().CoordPositionAdd(Vector3d(0.0, radius, 0.0))
        for geoms, speed in zip(self.tracks, self.speeds, strict=True):
            for geom in geoms:
                geom.set_surface(Surface.TRACK, kind)
                geom.set_surface(Surface.TRACK_SPEED, speed)
                for k, value in enumerate(pivot):
                    geom.set_surface(Surface.PIVOT + k, value)


GZ_REGISTER_MODEL_PLUGIN(SimpleTrackedVehiclePlugin)
