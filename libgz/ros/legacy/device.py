"""Device: one interface of a legacy model, served to ROS; `Devices`, all those of a world."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ClosedError
from libgz.base.geometry import GzCoordPoseSub, GzPose
from libgz.ros.legacy.grip import Grip
from libgz.ros.legacy.kinds import KINDS, Frames, Kind, Obey, Order, Switch
from libgz.ros.session import Service, Session, Subscription, finite, set_stamp
from libgz.ros.types import Message, Stamp, message_type, service_type
from libgz.simulation.event import unowned

if TYPE_CHECKING:
    from libgz.simulation.entity import Entity
    from libgz.simulation.world import World
    from libgz.transport.interface import Interface

__all__ = ["Device", "Devices"]

WORLD = "world"  # the frame of what is attached to no other device
DEPTH, RANGES = 10, 100  # of queues of messages: one for each of a robot's sonars comes at once


class Device:
    """One interface of a model.

    Attributes:
        session: serves it.
        kind: its declaration.
        interface: the interface, open in this process.
        model: the model that has it.
        id: of the interface, and its namespace.
        frame: its frame in TF; that of a robot is its base link.
    """

    def __init__(self, session: Session, kind: Kind, interface: Interface[Any], model: Entity) -> None:
        self.session, self.kind, self.interface, self.model = session, kind, interface, model
        self.id = interface.id
        robot = any(one.type == "position" for one in model.world.interfaces_of(model))
        self.frame = f"{self.id}/base_link" if robot else self.id
        self._time = math.nan  # of the sample that was published last [s]
        self._waiting: dict[str, tuple[Obey, Any]] = {}  # commands, as long as a client holds the lock
        self._streams = [
            (stream, session.publish(stream.topic, stream.kind, depth, space=self.id), message_type(stream.kind)())
            for stream in kind.streams
            for depth in (RANGES if stream.kind == "sensor_msgs/Range" else DEPTH,)
        ]
        self._commands: list[Subscription | Service] = [
            *map(self._subscribe, kind.orders),
            *map(self._serve, kind.switches),
        ]
        self._grip = Grip(self) if kind.grips else None

    def _subscribe(self, order: Order) -> Subscription:
        def take(message: Any) -> None:
            if finite(message):
                self.command(order.topic, order.obey, message)
            else:
                self.session.log_refusal(f"{self.id}/{order.topic}", "a number is not finite")

        return self.session.subscribe(order.topic, order.kind, take, 10, space=self.id)

    def _serve(self, switch: Switch) -> Service:
        def answer(request: Any) -> Message:
            self.command(switch.name, switch.obey, request)
            done: Message = service_type("std_srvs/Empty").response()
            return done

        return self.session.serve(switch.name, "std_srvs/Empty", answer, space=self.id)

    @property
    def busy(self) -> bool:
        """Whether something is to be done after the next step: a subscriber, a command, a goal."""
        heard = any(publication.listened for _, publication, _ in self._streams)
        return heard or bool(self._waiting) or (self._grip is not None and self._grip.busy)

    def end(self) -> None:
        """Serve it no longer: its model leaves."""
        for command in self._commands:
            command.end()
        if self._grip is not None:
            self._grip.end()
        self._streams.clear()

    def command(self, topic: str, obey: Obey, message: Any) -> None:
        """Write a command into the interface, as soon as no client holds its lock; the topic's last one counts."""
        self._waiting[topic] = (obey, message)
        with contextlib.suppress(ClosedError):  # a message before it in the queue has removed the model
            self._write()

    def _write(self) -> None:
        if not self._waiting or not self.interface.lock():
            return
        refusals = {topic: obey(self, message) for topic, (obey, message) in self._waiting.items()}
        self._waiting.clear()
        self.interface.unlock()
        for topic, refusal in refusals.items():
            if refusal:
                self.session.log_refusal(f"{self.id}/{topic}", refusal)

    def update(self) -> Stamp | None:
        """Publish the sample of the interface; its time, if it is a new one."""
        self._write()
        if self._grip is not None:
            self._grip.update()
        time = float(self.interface.data.time)
        if time == self._time or not math.isfinite(time) or time < 0.0:
            return None
        self._time, stamp = time, Stamp()
        set_stamp(stamp, time)
        for stream, publication, message in self._streams:
            if not publication.listened:
                continue
            if hasattr(message, "header"):
                message.header.stamp = stamp
                message.header.frame_id = f"{self.frame}_optical" if stream.optical else self.frame
            for _ in stream.fill(self, message):
                publication.publish(message)
        return stamp


class Devices:
    """All devices of a world: they come and go with its models.

    Args:
        session: serves them.
        core: the world.
    """

    def __init__(self, session: Session, core: World) -> None:
        self._session, self._core = session, core
        self._devices: dict[Interface[Any], Device] = {}
        self._sent: dict[str, Stamp] = {}  # frames -> the time of their last transform
        self.stale = True  # models have come or gone

    @property
    def busy(self) -> bool:
        """Whether something is to be done after the next step."""
        if self.stale:
            return True
        return any(one.busy for one in self._devices.values()) or (
            bool(self._devices) and self._session.transforms().listened
        )

    def step(self) -> None:
        """Publish what is new."""
        if self.stale:
            self.stale = False
            self._refresh()
        for device in self._devices.values():
            stamp = device.update()
            if stamp is not None and self._session.transforms().listened:
                self._send_frames(device, stamp)

    def end(self) -> None:
        """Serve them no longer: the world ends."""
        for device in self._devices.values():
            device.end()
        self._devices.clear()

    def _refresh(self) -> None:
        models = {model.GetIntId(): model for model in self._core.entities}
        present = [
            one for one in self._core.gz_server.interfaces.values() if one.type in KINDS and one.model_id in models
        ]
        for gone in [one for one in self._devices if one not in present]:
            self._devices.pop(gone).end()
        with unowned():
            for one in present:
                if one not in self._devices:
                    self._devices[one] = Device(self._session, KINDS[one.type], one, models[one.model_id])

    def _send_frames(self, device: Device, stamp: Stamp) -> None:
        """Publish the frames of a device, each once for a time: several interfaces of a model share one."""
        frames: Frames = [] if device.interface.type == "position" else self._own_frame(device)
        frames += device.kind.transforms(device) if device.kind.transforms is not None else []
        new = [one for one in frames if self._sent.get(one[1]) != stamp]
        self._sent.update((child, stamp) for _, child, _ in new)
        for parent, child, pose in new:
            u, x, y, z = pose.rot
            self._session.send_transform(stamp, parent, child, pose.pos, (x, y, z, u))

    def _own_frame(self, device: Device) -> Frames:
        """The frame of a device in that of the nearest device that carries it; none if it is that of a robot."""
        if device.frame != device.id:
            return []
        place, carrier = self._place(device.model), device.model.parent
        while carrier is not None:
            found = next(self._devices_of(carrier), None)
            if found is not None:
                return [(found.frame, device.frame, GzCoordPoseSub(place, self._place(carrier)))]
            carrier = carrier.parent
        return [(WORLD, device.frame, place)]

    def _devices_of(self, model: Entity) -> Iterator[Device]:
        return (one for one in self._devices.values() if one.model is model)

    def _place(self, model: Entity) -> GzPose:
        """The global pose of the frame of a model's devices: that of the sensor among them."""
        places = (one.kind.place(one) for one in self._devices_of(model) if one.kind.place is not None)
        return next(places, None) or model.GetPose()
