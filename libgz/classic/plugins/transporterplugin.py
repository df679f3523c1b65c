"""TransporterPlugin: moves models from pad to pad at once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic import transport
from libgz.classic.event import Events
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model, World
    from libgz.sdf.element import Element


NOWHERE = Vector3d(math.nan, math.nan, math.nan)  # no place is between two of these


@dataclass
class Pad:
    """A place that models leave from and arrive at.

    Attributes:
        low, high: corners of the box that models leave from [m].
        arrival: the pose at which models arrive [m], [rad].
        destination: the name of the pad that models go to; "" for none.
        manual: whether models leave only when the topic names the pad.
    """

    low: Vector3d
    high: Vector3d
    arrival: Pose3d
    destination: str
    manual: bool

    def holds(self, model: Model) -> bool:
        """Whether the origin of a model is in the box."""
        place = model.WorldPose().Pos()
        return all(a <= v <= b for a, v, b in zip(self.low, place, self.high, strict=True))


class TransporterPlugin(WorldPlugin):
    """Moves models that stand on a pad to the pad that it leads to.

    Elements:
        activation_topic: of GzString messages, each the name of a pad whose models leave now.
        pad: with an attribute `name`.
            destination: the name of the pad that it leads to.
            outgoing: `<min>` and `<max>`, corners of the box that models leave from, in the world frame [m]; without
                it none leave.
            incoming: `<pose>`, at which models arrive, in the world frame [m], [rad].
            activation: auto, or manual: by the topic (auto).
    """

    STATE = ("called",)

    def Load(self, world: World, sdf: Element) -> None:
        """Read the pads.

        Raises:
            NotFoundError: a pad leads to one that there is not.
            ParameterError: an activation is neither auto nor manual.
        """
        self.world = world
        self.pads = {element.Get(str, "name").strip(): self._pad(element) for element in sdf.named("pad")}
        for name, pad in self.pads.items():
            if pad.destination and pad.destination not in self.pads:
                raise NotFoundError(
                    f"{sdf.where}: pad {name!r} leads to {pad.destination!r}; there are {', '.join(self.pads)}"
                    + nearest(pad.destination, self.pads)
                )
        self.called: list[str] = []
        topic = sdf.Get(str, "activation_topic").strip()
        if topic:
            self.node = transport.Node()
            self.node.Init(world.Name())
            self.subscriber = self.node.Subscribe(topic, self.OnActivation, kind="GzString")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @staticmethod
    def _pad(element: Element) -> Pad:
        activation = element.Get(str, "activation", "auto")[0].strip()
        if activation not in ("auto", "manual"):
            raise ParameterError(f"{element.where}: <activation> is {activation!r}; it must be auto or manual")
        outgoing, incoming = (next(element.named(tag), None) for tag in ("outgoing", "incoming"))
        one, two = (outgoing.Get(Vector3d, tag) if outgoing is not None else NOWHERE for tag in ("min", "max"))
        return Pad(
            Vector3d(*map(min, one, two)),
            Vector3d(*map(max, one, two)),
            incoming.Get(Pose3d, "pose") if incoming is not None else Pose3d(),
            element.Get(str, "destination").strip(),
            activation == "manual",
        )

    def Reset(self) -> None:
        """Forget which pads were called."""
        self.called.clear()

    def OnActivation(self, message: Any) -> None:
        """Let the models of a pad leave in the next iteration."""
        name = message.data.strip()
        if name in self.pads and name not in self.called:  # all would stay as long as the world is paused
            self.called.append(name)

    def OnUpdate(self) -> None:
        """Move the models that leave; one that arrives leaves again in the next iteration at the earliest."""
        models = [model for model in self.world.Models() if not model.IsStatic()]
        leaving = [
            (model, self.pads[pad.destination])
            for name, pad in self.pads.items()
            if pad.destination and (not pad.manual or name in self.called)
            for model in models
            if pad.holds(model)
        ]
        self.called.clear()
        for model, target in leaving:
            model.SetWorldPose(target.arrival)


GZ_REGISTER_WORLD_PLUGIN(TransporterPlugin)
