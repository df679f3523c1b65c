"""libgz_legacy: models of legacy worldfiles in an SDF world."""

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
    """Puts models of the legacy era into an SDF world, with all that legacy worldfiles can say of them.

    They touch the SDF models, serve their interfaces to clients, can be looked at as `physics` models by other plugins,
    and go back to their places when the world is reset. Ground and light are those of the SDF world.

    Elements:
        model:<Class>: as in a worldfile, `<model:Pioneer2AT xmlns:model="model"><id>robot1</id>...</model:Pioneer2AT>`;
            any number of them.
    """

    def Load(self, world: World, sdf: Element) -> None:
        """Insert the models.

        Raises:
            WorldFileError: the text of a model has errors; none of it was added.
        """
        models = [element for element in sdf.children if element.GetName().startswith(PREFIX)]
        for element in models:
            world.core.extension(LegacyWorld).insert(element.ToString(), element.where)
        if not models:
            gzwarn(f"{self.GetHandle()}: there is no <{PREFIX}...> element in it")


GZ_REGISTER_WORLD_PLUGIN(LegacyPlugin)
