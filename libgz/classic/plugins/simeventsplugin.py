"""SimEventsPlugin: publishes events of a world on a topic."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.classic.plugins._sim_event import TOPIC, sim_event

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, World
    from libgz.sdf.element import Element


class Region:
    """A union of axis-aligned boxes."""

    def __init__(self, element: Element) -> None:
        self.name = element.Get(str, "name").strip()
        corners = [(v.Get(Vector3d, "min"), v.Get(Vector3d, "max")) for v in element.named("volume")]
        self.boxes = [(tuple(map(min, a, b)), tuple(map(max, a, b))) for a, b in corners]

    def contains(self, point: Iterable[float]) -> bool:
        """Whether a point [m] is in one of the boxes."""
        x = tuple(point)
        return any(all(a <= v <= b for a, v, b in zip(low, x, high, strict=True)) for low, high in self.boxes)


class SimEventsPlugin(WorldPlugin):
    """Publishes a SimEvent on /gazebo/sim_events whenever one of its events occurs.

    A message has the event's name, its type, the world's statistics, and as data a JSON text, such as
    ``{"state": "inside", "region": "end", "model": "can1"}``.

    Elements:
        region: `<name>`, and `<volume>` elements with `<min>` and `<max>`, corners of boxes [m].
        event: `<name>`, `<type>`, and `<active>` (true). The types:
            sim_state: the world is paused or resumed. States paused, running.
            existence: a model whose name begins with `<model>`, or any model without it, is inserted or removed. States
                creation, deletion.
            inclusion: the origin of `<model>` enters or leaves `<region>`. States inside, outside.
            joint: `<joint>` of `<model>` (or the first model whose name begins so) enters or leaves `<range>`: `<type>`
                position, normalized_angle (within +-pi), velocity or applied_force; `<min>`, `<max>` [rad], [m] and per
                second, [N m], [N]. States in_range, out_of_range.
            occupied: in each iteration, for each model that is not static and whose origin is in `<region>`, a GzString
                with `<msg_data>` is published on `<topic>`; no SimEvent.
    """

    STATE = ("number", "conditions", "existing")

    def Load(self, world: World, sdf: Element) -> None:
        """Read regions and events."""
        self.world = world
        self.node = transport.Node()
        self.node.Init(world.Name())
        self.publisher = self.node.Advertise(msgs.SimEvent, TOPIC)
        self.regions = {region.name: region for region in map(Region, sdf.named("region"))}
        self.connections: list[Any] = []
        self.checks: list[Callable[[], None]] = []
        self.number = 0
        self.conditions: list[bool] = []  # that are watched, in the order of the events
        self.existing: list[dict[str, None]] = []  # names of models that events of existence know
        kinds = {
            "sim_state": self._sim_state,
            "existence": self._existence,
            "inclusion": self._inclusion,
            "joint": self._joint,
            "occupied": self._occupied,
        }
        for event in sdf.named("event"):
            kind = event.Get(str, "type").strip()
            if kind not in kinds:
                raise ParameterError(
                    f'{event.where}: Unknown event type: "{kind}"; {", ".join(kinds)} are known{nearest(kind, kinds)}'
                )
            kinds[kind](event)
        self.connections.append(Events.ConnectWorldUpdateBegin(self.OnUpdate))

    def OnUpdate(self) -> None:
        """Check all events that need it."""
        for check in self.checks:
            check()

    def Reset(self) -> None:
        """Reset the states of all events."""
        self.conditions[:] = [False] * len(self.conditions)

    def _emit(self, event: Element, /, **data: Any) -> None:
        if event.Get(str, "active", "true")[0].strip() not in ("true", "1"):
            return
        self.number += 1
        kind, name = event.Get(str, "type").strip(), event.Get(str, "name").strip()
        self.publisher.Publish(sim_event(self.world, self.number, kind, name, data))

    def _watch(self, test: Callable[[], bool | None], notify: Callable[[bool], None]) -> None:
        """Call `notify` when a condition changes; None means that it is unknown."""
        index = len(self.conditions)
        self.conditions.append(False)

        def check() -> None:
            now = test()
            if now is not None and now != self.conditions[index]:
                self.conditions[index] = now
                notify(now)

        self.checks.append(check)

    def _region(self, event: Element) -> Region:
        name = event.Get(str, "region").strip()
        if name not in self.regions:
            raise NotFoundError(
                f"{event.where}: there is no region {name!r}; there are {', '.join(self.regions) or 'none'}"
                + nearest(name, self.regions)
            )
        return self.regions[name]

    # Kinds -------------------------------------------------------------------------------------------------------

    def _sim_state(self, event: Element) -> None:
        def notify(paused: bool) -> None:
            self._emit(event, state="paused" if paused else "running")

        self.connections.append(Events.ConnectPause(notify))

    def _existence(self, event: Element) -> None:
        prefix = event.Get(str, "model").strip()
        models = dict.fromkeys(model.GetName() for model in self.world.Models())  # lights are removed, too
        self.existing.append(models)

        def added(name: str) -> None:
            if any(model.GetName() == name for model in self.world.Models()):
                models[name] = None
                notify(name, "creation")

        def removed(name: str) -> None:
            if name in models:
                del models[name]
                notify(name, "deletion")

        def notify(name: str, state: str) -> None:
            if name.startswith(prefix):
                self._emit(event, event="existence", state=state, model=name)

        self.connections.append(Events.ConnectAddEntity(added))
        self.connections.append(Events.ConnectDeleteEntity(removed))

    def _inclusion(self, event: Element) -> None:
        region, name = self._region(event), _required(event, "model")

        def test() -> bool | None:
            model = self.world.ModelByName(name)
            return region.contains(model.WorldPose().Pos()) if model is not None else None

        def notify(inside: bool) -> None:
            self._emit(event, state="inside" if inside else "outside", region=region.name, model=name)

        self._watch(test, notify)

    def _joint(self, event: Element) -> None:
        name, joint_name, limits = _required(event, "model"), _required(event, "joint"), event.child("range")
        low, high = limits.Get(float, "min", -math.inf)[0], limits.Get(float, "max", math.inf)[0]
        kind = limits.Get(str, "type").strip()
        values: dict[str, Callable[[Joint], float]] = {
            "position": lambda joint: joint.Position(0),
            "normalized_angle": lambda joint: math.remainder(joint.Position(0), 2.0 * math.pi),
            "velocity": lambda joint: joint.GetVelocity(0),
            "applied_force": lambda joint: joint.GetForce(0),
        }
        if kind not in values:
            raise ParameterError(
                f"{limits.where}: <range> has type {kind!r}; allowed are {', '.join(values)}{nearest(kind, values)}"
            )

        def test() -> bool | None:
            joint = self._find_joint(name, joint_name)
            return low <= values[kind](joint) <= high if joint is not None else None

        def notify(inside: bool) -> None:
            joint = self._find_joint(name, joint_name)
            if joint is not None:
                self._emit(
                    event,
                    state="in_range" if inside else "out_of_range",
                    model=name,
                    joint=joint.GetName(),
                    range=kind,
                    value=values[kind](joint),
                    position=joint.Position(0),
                    velocity=joint.GetVelocity(0),
                    force=joint.GetForce(0),
                )

        self._watch(test, notify)

    def _find_joint(self, name: str, joint: str) -> Joint | None:
        models = self.world.Models()
        model = self.world.ModelByName(name) or next((m for m in models if m.GetName().startswith(name)), None)
        return model.GetJoint(joint) if model is not None else None

    def _occupied(self, event: Element) -> None:
        region = self._region(event)
        publisher = self.node.Advertise(msgs.GzString, _required(event, "topic"))
        message = msgs.GzString(data=event.Get(str, "msg_data").strip())

        def check() -> None:
            for model in self.world.Models():
                if not model.IsStatic() and region.contains(model.WorldPose().Pos()):
                    publisher.Publish(message)

        self.checks.append(check)


def _required(event: Element, tag: str) -> str:
    text = event.Get(str, tag).strip()
    if not text:
        name, kind = (event.Get(str, key).strip() for key in ("name", "type"))
        raise NotFoundError(f"{event.where}: event {name!r} is of type {kind}, and requires a <{tag}>")
    return text


GZ_REGISTER_WORLD_PLUGIN(SimEventsPlugin)
