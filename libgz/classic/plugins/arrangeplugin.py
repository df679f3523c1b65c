"""ArrangePlugin: puts models into arrangements by name."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from libgz.base.errors import nearest
from libgz.classic import transport
from libgz.classic.math import Pose3d
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element

log = logging.getLogger("libgz.classic")


class ArrangePlugin(WorldPlugin):
    """Moves models to the poses of an arrangement, whose name comes as a GzString on a topic.

    Models that an arrangement does not name return to where they were at the start.

    Elements:
        topic_name: of the requests (~/arrange).
        model_name: a model that may be moved; any number of them.
        arrangement: with an attribute `name`; it has a `<pose>` with an attribute `model` for each model, in the world
            frame [m], [rad].
        initial_arrangement: the name of that of the start; none: poses of the file.
    """

    STATE = ()

    def Load(self, world: World, sdf: Element) -> None:
        """Read the arrangements, and subscribe."""
        self.world, self.names = world, [e.Get(str).strip() for e in sdf.named("model_name")]
        self.arrangements = {
            element.Get(str, "name").strip(): {
                pose.Get(str, "model").strip(): pose.Get(Pose3d) for pose in element.named("pose")
            }
            for element in sdf.named("arrangement")
        }
        self.initial = sdf.Get(str, "initial_arrangement").strip()
        self.node = transport.Node()
        self.node.Init(world.Name())
        topic = sdf.Get(str, "topic_name", "~/arrange")[0].strip()
        self.subscriber = self.node.Subscribe(topic, self.OnRequest, kind="GzString")

    def Init(self) -> None:
        """Make the initial arrangement; all models are there now."""
        self.start = {}
        for name in self.names:
            model = self.world.ModelByName(name)
            if model is None:
                known = [model.GetName() for model in self.world.Models()]
                log.warning("ArrangePlugin: there is no model %r; it is left out%s", name, nearest(name, known))
                continue
            self.start[name] = model.WorldPose()
        self.Reset()

    def Reset(self) -> None:
        """Make the initial arrangement again."""
        if self.initial:
            self.arrange(self.initial)

    def OnRequest(self, message: Any) -> None:
        """Make an arrangement."""
        self.arrange(message.data.strip())

    def arrange(self, name: str) -> None:
        """Move the models; a name that is unknown is reported."""
        if name not in self.arrangements:
            known = ", ".join(self.arrangements) or "none"
            log.error(
                "ArrangePlugin: there is no arrangement %r; there are %s%s",
                name,
                known,
                nearest(name, self.arrangements),
            )
            return
        for model_name, start in self.start.items():
            model = self.world.ModelByName(model_name)
            if model is not None:
                model.SetWorldPose(self.arrangements[name].get(model_name, start))
                model.ResetPhysicsStates()


GZ_REGISTER_WORLD_PLUGIN(ArrangePlugin)
