"""RegionEventBoxPlugin: publishes an event when a model enters or leaves a box."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Pose3d
from libgz.classic.physics import BoxShape
from libgz.classic.physics.shape import shape_of
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._boxes import Box
from libgz.classic.plugins._sim_event import TOPIC, sim_event

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.physics.geom import Geom
    from libgz.sdf.element import Element


class RegionEventBoxPlugin(ModelPlugin):
    """Publishes a SimEvent on /gazebo/sim_events when the origin of another model enters or leaves this model's box.

    The box is the first collision of this model that is one, else the first visual; it moves with the model. The data
    of an event is a JSON text, such as ``{"state": "inside", "region": "gate", "model": "robot"}``.

    Elements:
        event: `<name>`, and `<type>`, which is inclusion.
    """

    STATE = ("inside", "number")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the box.

        Raises:
            NotFoundError: the model has no box.
            ParameterError: the event has another type.
        """
        self.model, self.world = model, model.GetWorld()
        event = sdf.child("event")
        self.name, kind = event.Get(str, "name").strip(), event.Get(str, "type", "inclusion")[0].strip()
        if kind != "inclusion":
            raise ParameterError(f"{sdf.where}: <event><type> is {kind!r}; it must be inclusion")
        self.geom, self.shape = self._box(sdf)
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.SimEvent, TOPIC)
        self.number = 0
        self.inside: list[str] = []  # names of the models in the box
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def _box(self, sdf: Element) -> tuple[Geom, BoxShape]:
        links = self.model.GetLinks()
        solid = [collision.geom for link in links for collision in link.GetCollisions()]
        seen = [geom for link in links for geom in link.visuals()]
        for geom in (*solid, *seen):
            shape = shape_of(geom)
            if isinstance(shape, BoxShape):
                return geom, shape
        raise NotFoundError(f"{sdf.where}: model {self.model.GetName()!r} has no box; its events need one")

    def Reset(self) -> None:
        """Forget which models are inside."""
        self.inside.clear()

    def OnUpdate(self) -> None:
        """Compare the places of all other models."""
        box = Box(Pose3d(self.geom.GetPose()), self.shape.Size())
        others = [model for model in self.world.Models() if model is not self.model]
        now = [model.GetName() for model in others if box.contains(model.WorldPose().Pos())]
        for name in now:
            if name not in self.inside:
                self._emit("inside", name)
        for name in self.inside:
            if name not in now:
                self._emit("outside", name)
        self.inside[:] = now

    def _emit(self, state: str, name: str) -> None:
        self.number += 1
        data = {"state": state, "region": self.name, "model": name}
        self.publisher.Publish(sim_event(self.world, self.number, "inclusion", self.name, data))


GZ_REGISTER_MODEL_PLUGIN(RegionEventBoxPlugin)
