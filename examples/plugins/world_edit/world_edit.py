"""A World plugin that changes gravity, step size and real-time factor of its world, from the plugin's element.

A World plugin gets the world, which gives access to all objects, and its own <plugin> element.
"""

from libgz.classic import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin, gzmsg
from libgz.classic.math import Vector3d


class WorldEdit(WorldPlugin):
    """Elements: `<gravity>` [m/s^2], `<max_step_size>` [s], `<real_time_update_rate>` [Hz], `<iters>`; all optional."""

    STATE = ()  # nothing of its own to remember

    # Parameters of the physics engine with one number; gravity has three.
    PARAMETERS = {"max_step_size": float, "real_time_update_rate": float, "iters": int}

    def Load(self, world, sdf):
        physics = world.Physics()
        for name, kind in self.PARAMETERS.items():
            if sdf.HasElement(name):
                before = physics.GetParam(name)
                physics.SetParam(name, sdf.Get(kind, name))
                gzmsg(f"{name}: {before} -> {physics.GetParam(name)}")
        # With a default, Get returns (value, found): found is whether the file has the element.
        gravity, found = sdf.Get(Vector3d, "gravity", world.Gravity())
        if found:
            world.SetGravity(gravity)
            gzmsg(f"gravity: {gravity}")


GZ_REGISTER_WORLD_PLUGIN(WorldEdit)
