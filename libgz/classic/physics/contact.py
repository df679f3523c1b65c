"""Contact: the contact points of two collisions in a step."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from libgz.classic import msgs
from libgz.classic.common import Time
from libgz.classic.math import Vector3d

if TYPE_CHECKING:
    from libgz.classic.physics.collision import Collision
    from libgz.classic.physics.world import World
    from libgz.physics.geom import Geom

__all__ = ["Contact", "JointWrench", "loaded_contacts", "read_contacts"]


@dataclass
class JointWrench:
    """Forces [N] and torques [N m] on two bodies."""

    body1Force: Vector3d = field(default_factory=Vector3d)
    body1Torque: Vector3d = field(default_factory=Vector3d)
    body2Force: Vector3d = field(default_factory=Vector3d)
    body2Torque: Vector3d = field(default_factory=Vector3d)


@dataclass
class Contact:
    """The contact points of two collisions: positions [m] and normals in the world frame, depths [m], wrenches."""

    world: World
    collision1: Collision
    collision2: Collision
    time: Time
    positions: list[Vector3d] = field(default_factory=list)
    normals: list[Vector3d] = field(default_factory=list)
    depths: list[float] = field(default_factory=list)
    wrench: list[JointWrench] = field(default_factory=list)

    def save(self) -> tuple[Any, ...]:
        """The contact as plain data, for `loaded_contacts`."""
        wrenches = [
            tuple(tuple(part) for part in (w.body1Force, w.body1Torque, w.body2Force, w.body2Torque))
            for w in self.wrench
        ]
        geoms = [_place(collision.geom) for collision in (self.collision1, self.collision2)]
        vectors = [tuple(map(tuple, rows)) for rows in (self.positions, self.normals)]
        return geoms, self.time.nanoseconds, vectors, self.depths, wrenches

    @property
    def count(self) -> int:
        """The number of points."""
        return len(self.positions)

    @property
    def names(self) -> tuple[str, str]:
        """The scoped names of both collisions."""
        return self.collision1.GetScopedName(), self.collision2.GetScopedName()

    def FillMsg(self, msg: Any) -> None:
        """Fill a msgs.Contact with what it has."""
        msg.Clear()
        msg.world = self.world.Name()
        msg.collision1, msg.collision2 = self.names
        msgs.Set(msg.time, self.time)
        msg.position = [msgs.Convert(position) for position in self.positions]
        msg.normal = [msgs.Convert(normal) for normal in self.normals]
        msg.depth = self.depths
        msg.wrench = [self._wrench_message(wrench) for wrench in self.wrench]

    def _wrench_message(self, wrench: JointWrench) -> Any:
        message = msgs.JointWrench()
        message.body_1_name, message.body_2_name = self.names
        message.body_1_id, message.body_2_id = self.collision1.GetId(), self.collision2.GetId()
        msgs.Set(message.body_1_wrench.force, wrench.body1Force)
        msgs.Set(message.body_1_wrench.torque, wrench.body1Torque)
        msgs.Set(message.body_2_wrench.force, wrench.body2Force)
        msgs.Set(message.body_2_wrench.torque, wrench.body2Torque)
        return message

    def Reset(self) -> None:
        """Forget its points."""
        for values in (self.positions, self.normals, self.depths, self.wrench):
            values.clear()

    def DebugString(self) -> str:
        """Its collisions, points and depths as text, for people."""
        lines = [f"World[{self.world.Name()}]", "Collision1[{}]\nCollision2[{}]".format(*self.names)]
        lines += [f"Time[{self.time}]", f"Contact Count[{self.count}]"]
        for i, (position, normal, depth) in enumerate(zip(self.positions, self.normals, self.depths, strict=True)):
            lines += [f"--- Contact[{i}]", f"  Depth[{depth:g}]", f"  Position[{position}]", f"  Normal[{normal}]"]
        return "\n".join(lines) + "\n"


def read_contacts(world: World, points: NDArray[np.void]) -> list[Contact]:
    """Records of contact points (see `Engine.contacts`) as contacts, one for each pair of collisions."""
    engine, now = world.core.engine, world.SimTime()
    pairs: dict[tuple[int, int], Contact] = {}
    for point in points:
        rows = int(point["geom1"]), int(point["geom2"])
        if rows not in pairs:
            geoms = [engine.geoms[row] for row in rows if row in engine.geoms]
            touching = [found for geom in geoms if (found := world.collision_of(geom)) is not None]
            if len(touching) < 2:
                continue
            pairs[rows] = Contact(world, touching[0], touching[1], now)
        contact = pairs[rows]
        contact.positions.append(Vector3d(*point["position"].tolist()))
        contact.normals.append(Vector3d(*point["normal"].tolist()))
        contact.depths.append(float(point["depth"]))
        contact.wrench.append(_wrench(contact, point))
    return list(pairs.values())


def _wrench(contact: Contact, point: np.void) -> JointWrench:
    """Forces and torques on both links, in the link frames, as in Gazebo."""
    turn1, turn2 = contact.collision1.link.WorldPose().rot, contact.collision2.link.WorldPose().rot
    return JointWrench(
        turn1.RotateVectorReverse(Vector3d(*point["force1"].tolist())),
        turn1.RotateVectorReverse(Vector3d(*point["torque1"].tolist())),
        turn2.RotateVectorReverse(Vector3d(*point["force2"].tolist())),
        turn2.RotateVectorReverse(Vector3d(*point["torque2"].tolist())),
    )


def _place(geom: Geom) -> tuple[str, int, int]:
    """The id of a geom's entity, the number of its link, and its own number there."""
    body = geom.body
    return body.model.GetId(), body.model.bodies.index(body), body.geoms.index(geom)


def loaded_contacts(world: World, states: Iterable[Any]) -> list[Contact]:
    """Contacts again from what `Contact.save` returned, without those of collisions that are not there any more."""
    contacts = []
    for geoms, nanoseconds, (positions, normals), depths, wrenches in states:
        pair = [world.collision_of(world.core.model(owner).bodies[link].geoms[at]) for owner, link, at in geoms]
        if pair[0] is None or pair[1] is None:
            continue
        contact = Contact(world, pair[0], pair[1], Time(0, nanoseconds))
        contact.positions = [Vector3d(*vector) for vector in positions]
        contact.normals = [Vector3d(*vector) for vector in normals]
        contact.depths = list(depths)
        contact.wrench = [JointWrench(*(Vector3d(*part) for part in wrench)) for wrench in wrenches]
        contacts.append(contact)
    return contacts
