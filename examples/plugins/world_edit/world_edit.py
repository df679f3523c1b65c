"""A World plugin that changes the physics of its world: gravity, step size and update rate, by the plugin's element.

What every World plugin gets is the world, and its own <plugin> element; from the world it reaches everything else.
"""

from libgz.classic import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin, gzmsg
from libgz.classic.math import Vector3d


class WorldEdit(WorldPlugin):
    """Elements: `<gravity>` [m/s^2], `<max_step_size>` [s], `<real_time_update_rate>` [Hz], `<iters>`; all optional."""

    # Numbers of the physics engine that have a name; gravity is not one, but three.
    PARAMETERS = {"max_step_size": float, "real_time_update_rate": float, "iters": int}

    def Load(self, world, sdf):
        physics = world.Physics()
        for name, kind in self.PARAMETERS.items():
            if sdf.HasElement(name):
                before = physics.GetParam(name)
                physics.SetParam(name, sdf.Get(kind, name))
                gzmsg(f"{name}: {before} -> {physics.GetParam(name)}")
        # With a third argument, the default, Get returns (value, found).
        gravity, found = sdf.Get(Vector3d, "gravity", world.Gravity())
        if found:
            world.SetGravity(gravity)
            gzmsg(f"gravity: {gravity}")


GZ_REGISTER_WORLD_PLUGIN(WorldEdit)
