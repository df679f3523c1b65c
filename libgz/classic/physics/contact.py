"""Contact: the contact points of two collisions in a step."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.classic import msgs
from libgz.classic.common import Time
from libgz.classic.math import Quaterniond, Vector3d
from libgz.ode.context import CONTACT

if TYPE_CHECKING:
    from libgz.classic.physics.collision import Collision
    from libgz.classic.physics.world import World

__all__ = ["RECORD", "Contact", "ContactPoints", "JointWrench", "contact_points", "contact_records", "read_contacts"]

# A contact point with its sim time [ns], and the numbers of both geoms and rotations of their links at that time.
RECORD = np.dtype([("time", np.int64), ("number", np.int64, 2), ("turn", np.float64, (2, 4)), ("point", CONTACT)])


@dataclass
class JointWrench:
    """Forces [N] and torques [N m] on two bodies."""

    body1Force: Vector3d = field(default_factory=Vector3d)
    body1Torque: Vector3d = field(default_factory=Vector3d)
    body2Force: Vector3d = field(default_factory=Vector3d)
    body2Torque: Vector3d = field(default_factory=Vector3d)

    def __add__(self, other: JointWrench) -> JointWrench:
        return self._each(operator.add, other)

    def __sub__(self, other: JointWrench) -> JointWrench:
        return self._each(operator.sub, other)

    def _each(self, combine: Callable[[Vector3d, Vector3d], Vector3d], other: JointWrench) -> JointWrench:
        if not isinstance(other, JointWrench):
            return NotImplemented
        names = [one.name for one in fields(self)]
        return JointWrench(*(combine(getattr(self, name), getattr(other, name)) for name in names))


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


class ContactPoints(NamedTuple):
    """The contact points of two collisions in an iteration as arrays with a row for each.

    Attributes:
        names: scoped names of both collisions.
        time: sim time [ns].
        positions, normals: n x 3, in the world frame [m].
        depths: n [m].
        wrenches: n x 6: force [N] and torque [N m] on the first collision's link, in its frame.
    """

    names: tuple[str, str]
    time: int
    positions: NDArray[np.float64]
    normals: NDArray[np.float64]
    depths: NDArray[np.float64]
    wrenches: NDArray[np.float64]


def contact_records(world: World, points: NDArray[np.void]) -> NDArray[np.void]:
    """Contact points of the last iteration (see `Engine.contacts`) as numbers that `read_contacts` can read later."""
    found = np.zeros(len(points), RECORD)
    if not len(points):
        return found
    found["point"], found["time"] = points, world.SimTime().nanoseconds
    rows = points["geom1"].tolist(), points["geom2"].tolist()
    known = {row: _number_and_turn(world, row) for row in {*rows[0], *rows[1]}}
    for side, column in enumerate(rows):
        found["number"][:, side] = [known[row][0] for row in column]
        found["turn"][:, side] = [known[row][1] for row in column]
    return found


def _number_and_turn(world: World, row: int) -> tuple[int, tuple[float, ...]]:
    """The number of a collision, and the rotation of its link; 0 for what is not a collision of a model."""
    table = world.core.engine.tables.geoms
    geom = table.objects.get(row)
    if geom is None or world.collision_of(geom) is None:
        return 0, (1.0, 0.0, 0.0, 0.0)
    turn = geom.body.GetPose().rot
    return table.number(row), (turn.u, turn.x, turn.y, turn.z)


def read_contacts(world: World, records: NDArray[np.void]) -> list[Contact]:
    """Contacts from `contact_records`, one for each pair of collisions and iteration; without removed collisions."""
    table = world.core.engine.tables.geoms
    contacts: dict[tuple[int, ...], Contact] = {}
    columns = [records[name].tolist() for name in ("time", "number", "turn")]
    columns += [records["point"][name].tolist() for name in CONTACT.names or ()]
    for nanoseconds, numbers, turns, row1, row2, position, normal, depth, *efforts in zip(*columns, strict=True):
        if [table.number(row1), table.number(row2)] != numbers or 0 in numbers:
            continue
        key = nanoseconds, row1, row2
        contact = contacts.get(key)
        if contact is None:
            first, second = (world.collision_of(table.objects[row]) for row in (row1, row2))
            if first is None or second is None:
                continue
            contact = contacts[key] = Contact(world, first, second, Time(0, nanoseconds))
        contact.positions.append(Vector3d(*position))
        contact.normals.append(Vector3d(*normal))
        contact.depths.append(depth)
        turn1, turn2 = (Quaterniond(*turn) for turn in turns)
        parts = zip((turn1, turn1, turn2, turn2), efforts, strict=True)
        # In the link frames, as in Gazebo.
        contact.wrench.append(JointWrench(*(turn.RotateVectorReverse(part) for turn, part in parts)))
    return [*contacts.values()]


def contact_points(world: World, records: NDArray[np.void]) -> list[ContactPoints]:
    """What `read_contacts` finds in `contact_records`, as arrays: much cheaper where there are many."""
    table, points = world.core.engine.tables.geoms, records["point"]
    numbers = records["number"].tolist()
    names: dict[int, tuple[int, str]] = {}
    rows_of: dict[tuple[int, int, int], list[int]] = {}
    columns = records["time"].tolist(), points["geom1"].tolist(), points["geom2"].tolist()
    for index, key in enumerate(zip(*columns, strict=True)):
        for row, number in zip(key[1:], numbers[index], strict=True):
            if row not in names:
                found = world.collision_of(table.objects[row]) if number and table.number(row) == number else None
                names[row] = (number, found.GetScopedName()) if found is not None else (-1, "")
        if [names[row][0] for row in key[1:]] == numbers[index]:
            rows_of.setdefault(key, []).append(index)
    turn = records["turn"][:, 0]
    efforts = np.hstack([_turned_back(turn, points["force1"]), _turned_back(turn, points["torque1"])])
    return [
        ContactPoints(
            (names[first][1], names[second][1]),
            time,
            points["position"][rows],
            points["normal"][rows],
            points["depth"][rows],
            efforts[rows],
        )
        for (time, first, second), rows in rows_of.items()
    ]


def _turned_back(turns: NDArray[np.float64], vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors, each rotated by the inverse of a unit quaternion (u, x, y, z)."""
    axis, scalar = -turns[:, 1:], turns[:, :1]
    across = 2.0 * np.cross(axis, vectors)
    return vectors + scalar * across + np.cross(axis, across)
