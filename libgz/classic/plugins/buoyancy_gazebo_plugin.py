"""buoyancy_gazebo_plugin: bodies that float on water with a surface and waves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic.event import Events
from libgz.classic.math import Pose3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._water import Hull, hull_of, waves_of

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Link, Model
    from libgz.sdf.element import Element


class Float(NamedTuple):
    """A shape that displaces water: its link, its pose there, its hull."""

    link: Link
    pose: Pose3d
    hull: Hull


class BuoyancyGazeboPlugin(ModelPlugin):
    """Lets shapes float: each has the weight of the water that its part below the surface displaces, upwards there.

    The surface is at a level, with waves (`waves_of` in `_water`); water resists in proportion to velocity and to the
    share of the shape that is below. Volumes are sums of 512 small boxes at most.

    Elements:
        fluid_density: [kg/m^3] (997.7735).
        fluid_level: height of the surface [m] (0).
        linear_drag, angular_drag: [N s/m], [N m s] (0).
        buoyancy: several; `link_name`, `pose` in the link's frame [m, rad], `geometry` with a box, cylinder or sphere.
        wave: several; `amplitude` [m] (0), `period` [s] (5), `direction` (1 0), `phase` [rad] (0), and a group by
            `number` (1), `scale` (1) and `angle` [rad] (0).
        wave_model: the name of a model whose plugins have such `<wave>`, in place of own ones.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the shapes.

        Raises:
            NotFoundError: there is no such link, or no shape.
            ParameterError: a number is not allowed.
        """
        self.world = model.GetWorld()
        self.density = sdf.Get(float, "fluid_density", 997.7735)[0]
        self.level = sdf.Get(float, "fluid_level", 0.0)[0]
        self.drag = sdf.Get(float, "linear_drag", 0.0)[0], sdf.Get(float, "angular_drag", 0.0)[0]
        if not all(math.isfinite(value) and value >= 0.0 for value in (self.density, *self.drag)):
            raise ParameterError(f"{sdf.where}: <fluid_density>, <linear_drag> and <angular_drag> must not be negative")
        self.floats = [
            Float(named_link(model, shape), shape.Get(Pose3d, "pose", Pose3d())[0], hull_of(shape.child("geometry")))
            for shape in sdf.named("buoyancy")
        ]
        if not self.floats:
            raise NotFoundError(f"{sdf.where}: <buoyancy> is missing; it names a link and its shape")
        self.waves = waves_of(sdf)
        self.wave_model = sdf.Get(str, "wave_model").strip()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Init(self) -> None:
        """Read the waves of the other model: now all models are there."""
        if self.wave_model and not self.waves:
            other = self.world.ModelByName(self.wave_model)
            if other is None:
                raise NotFoundError(f"<wave_model> is {self.wave_model!r}; the world has no such model")
            plugins = list(other.GetSDF().named("plugin"))  # their <wave>, or those in elements such as <wave_field>
            self.waves = waves_of(*(part for plugin in plugins for part in (plugin, *plugin.children)))

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the forces."""
        gravity, time = self.world.Gravity(), info.simTime.Double()
        for link, pose, hull in self.floats:
            volume, centre = hull.submerged(pose + link.WorldPose(), self.level, self.waves, time)
            if not volume > 0.0:
                continue
            share = volume / hull.volume
            link.AddForceAtWorldPosition(gravity * (-self.density * volume), centre)
            link.AddForce(link.WorldLinearVel() * (-self.drag[0] * share))
            link.AddTorque(link.WorldAngularVel() * (-self.drag[1] * share))


GZ_REGISTER_MODEL_PLUGIN(BuoyancyGazeboPlugin)
