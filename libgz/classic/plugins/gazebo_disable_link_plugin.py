"""gazebo_disable_link_plugin: puts a link to sleep."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class DisableLinkPlugin(ModelPlugin):
    """Puts a link to sleep at its load, until something touches or moves it.

    Elements:
        link: its name.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Put the link to sleep.

        Raises:
            NotFoundError: there is no such link.
        """
        named_link(model, sdf, "link").SetEnabled(False)


GZ_REGISTER_MODEL_PLUGIN(DisableLinkPlugin)
