"""libgz_legacy: legacy models in an SDF world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.common import gzwarn
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.legacy.world import LegacyWorld

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element

PREFIX = "model:"


class LegacyPlugin(WorldPlugin):
    """Inserts legacy models into an SDF world, with all elements of legacy worldfiles.

    They have contacts with SDF models, serve their interfaces to clients, are `physics` models for other plugins, and
    return to their initial poses when the world is reset. Ground and light are those of the SDF world.

    Elements:
        model:<Class>: as in a worldfile, `<model:Pioneer2AT xmlns:model="model"><id>robot1</id>...</model:Pioneer2AT>`;
            any number of them.
    """

    STATE = ()

    def Load(self, world: World, sdf: Element) -> None:
        """Insert the models.

        Raises:
            WorldFileError: the text of a model has errors; none of it was added.
        """
        models = [element for element in sdf.children if element.GetName().startswith(PREFIX)]
        for element in models:
            world.core.extension(LegacyWorld).insert(element.ToString(), element.where)
        if not models:
            gzwarn(f"{self.GetHandle()}: it has no <{PREFIX}...> element")


GZ_REGISTER_WORLD_PLUGIN(LegacyPlugin)
