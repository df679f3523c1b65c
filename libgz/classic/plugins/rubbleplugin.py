"""RubblePlugin: a heap of blocks and planks at random."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.classic.math import Pose3d, Quaterniond, Rand, Vector3d
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.sdfworld.population import MOST_MODELS

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element

BLOCK = Vector3d(0.2032, 0.2032, 0.4064)  # a building block of 8 x 8 x 16 inches [m]
PLANK = (0.1016, 0.0508)  # width and height of a plank of 4 x 2 inches [m]
LENGTHS = (0.6096, 2.4384)  # of planks, 2 to 8 feet [m]
TILT = 0.1  # [rad], at most


class RubblePlugin(WorldPlugin):
    """Inserts boxes rubble_0, rubble_1, ... at random poses in a region: building blocks, and planks of random length.

    Elements:
        bottom_right, top_left: two corners of the region [m].
        min_mass, max_mass: of a box [kg].
        count: of the boxes.
        min_size, max_size: read and not used, as in Gazebo.
    """

    STATE = ()

    def Load(self, world: World, sdf: Element) -> None:
        """Read the elements.

        Raises:
            ParameterError: a mass is not positive, or the count is out of range.
        """
        self.world = world
        corners = [sdf.Get(Vector3d, tag) for tag in ("bottom_right", "top_left")]
        self.low, self.high = (Vector3d(*map(side, *corners)) for side in (min, max))
        self.masses = sdf.Get(float, "min_mass", 1.0)[0], sdf.Get(float, "max_mass", 1.0)[0]
        self.count = sdf.Get(int, "count")
        if not 0.0 < self.masses[0] <= self.masses[1]:
            raise ParameterError(
                f"{sdf.where}: <min_mass> is {self.masses[0]:g} and <max_mass> {self.masses[1]:g}; "
                "both must be positive, and the first one not larger"
            )
        if not 0 <= self.count <= MOST_MODELS:
            raise ParameterError(f"{sdf.where}: <count> is {self.count}; it must be from 0 to {MOST_MODELS}")

    def Init(self) -> None:
        """Insert the boxes."""
        for i in range(self.count):
            self.world.InsertModelString(self._box(f"rubble_{i}"))

    def _box(self, name: str) -> str:
        block = Rand.IntUniform(0, 1) == 0
        x, y, z = size = BLOCK if block else Vector3d(Rand.DblUniform(*LENGTHS), *PLANK)
        mass = Rand.DblUniform(*self.masses)
        place = [Rand.DblUniform(a, b) for a, b in zip(self.low, self.high, strict=True)]
        place[2] = max(place[2], z / 2.0)
        turn = Rand.DblUniform(0.0, math.pi), Rand.DblUniform(-TILT, TILT), Rand.DblUniform(0.0, math.pi)
        moments = [mass / 12.0 * square for square in (y * y + z * z, x * x + z * z, x * x + y * y)]
        inertia = "".join(f"<{tag}>{value}</{tag}>" for tag, value in zip(("ixx", "iyy", "izz"), moments, strict=True))
        shape = f"<geometry><box><size>{size}</size></box></geometry>"
        return (
            f"<sdf version='1.6'><model name='{name}'><allow_auto_disable>true</allow_auto_disable>"
            f"<pose>{Pose3d(place, Quaterniond(*turn))}</pose><link name='link'>"
            "<velocity_decay><linear>0.01</linear><angular>0.01</angular></velocity_decay>"
            f"<inertial><mass>{mass}</mass><inertia>{inertia}</inertia></inertial>"
            f"<collision name='collision'>{shape}</collision><visual name='visual'>{shape}</visual>"
            "</link></model></sdf>"
        )


GZ_REGISTER_WORLD_PLUGIN(RubblePlugin)
