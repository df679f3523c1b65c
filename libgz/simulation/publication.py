"""Publication: lets other processes see the states and the scene of a world that a server serves.

- Observers see copies (`libgz/simulation/publication.py`, `libgz/transport/tables.py`). At the end of each step of a
  served world, paused ones included, one native call copies the tables to shared memory, with a sequence counter. Stale
  rows are read from ODE into the copy, never into the tables: reading would count turns of joints. `Table.changes` and
  `Appearance.version` say when the scene has to be written again; each entity describes itself (`_entity_describe`).
"""

from __future__ import annotations

import ctypes
import json
import logging
import os
import struct
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, NotFoundError
from libgz.base.records import PublishRecord
from libgz.ode.context import Publication as Target
from libgz.physics.body import Body
from libgz.physics.geoms import DomeGeom, FrustrumGeom
from libgz.simulation.description import describe_body, offset_in, plain, pose_list
from libgz.simulation.entity import Entity
from libgz.transport.tables import BODY_COLUMNS, FORMAT, HEADER, LocalTables

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = ["Publication"]

log = logging.getLogger("libgz.simulation")

LOOK_PERIOD = 0.2  # [s] between two searches for changed appearances
LARGE = 100_000  # [byte]
LOOK_SHARE = 100  # of the time that a search and its consequences took, at least that long is waited
_NUMBERS = struct.Struct("=qqqddd")  # revision to real_time of the header
_NUMBERS_AT = HEADER.fields["revision"][1]  # type: ignore[index]


class Publication:
    """Copies the states of a world to shared memory after each step, and writes its scene whenever that changed.

    Bodies, joints, geoms and entities that come or go are in the scene of the same step; changed colours, names and
    places of joints up to 0.2 s later.

    Args:
        world: which runs.
        shared: the tables, in files for other processes or in memory.
    """

    def __init__(self, world: World, shared: LocalTables) -> None:
        self.world, self.shared = world, shared
        self.record = PublishRecord()  # lets native code publish as long as nothing but states changes
        self.changed = True
        self._revision = 0
        self._mark: tuple[int, ...] = ()  # counts of rows taken and freed when the scene was written
        self._look: list[Any] = []  # what else the scene depends on, as it was then
        self._next_look = 0.0
        self._chunks: dict[Entity | None, tuple[Any, str, set[str]]] = {}
        self._used: set[str] = set()  # data files of the entity that is being described
        self._stored: dict[tuple[int, ...], tuple[Any, dict[str, Any]]] = {}  # by the arrays, which are kept
        self._fixed: NDArray[np.float64] = np.zeros((16, BODY_COLUMNS))
        self._fixed_rows: dict[Body, int] = {}
        self._sizes = (0, 0, 0)
        self._looks: list[Any] = []
        self._frusta: list[FrustrumGeom] = []
        self._failed = False
        header = shared.header
        self._numbers = (ctypes.c_char * HEADER.itemsize).from_address(header.ctypes.data)
        self._target = Target(header=header.ctypes.data, header_size=HEADER.itemsize)
        self.record.publication = ctypes.addressof(self._target)
        self.record.numbers = header.ctypes.data + _NUMBERS_AT
        self._target.sequence_offset = HEADER.fields["sequence"][1]  # type: ignore[index]

    @property
    def changed(self) -> bool:
        """Whether entities came or went since the scene was written."""
        return self._changed

    @changed.setter
    def changed(self, value: bool) -> None:
        self._changed = value
        self.record.ready = 0

    def publish(self, paused: bool) -> None:
        """Copy out the states as they are now, between two steps; the caller holds the world's lock."""
        shared, world = self.shared, self.world
        self.record.ready = 0
        if self._failed or not shared.owned:
            return
        engine, clock = world.engine, world.clock
        tables = engine.tables
        bodies, joints = tables.bodies, tables.joints
        mark = (bodies.changes, joints.changes, tables.geoms.changes, len(world.gz_server.interfaces))
        new_file = False
        if mark != self._mark or self.changed or time.monotonic() >= self._next_look:
            try:
                new_file = self._refresh(mark)
            except (OSError, GazeboError) as error:
                self._fail(error)
                return
        if engine.moved_dummies:
            self._move_dummies()
        _NUMBERS.pack_into(
            self._numbers,
            _NUMBERS_AT,
            self._revision,
            clock.iterations,
            paused,
            clock.sim_time,
            clock.pause_time,
            clock.real_time,
        )
        self._target.stale = tables.touched
        self._target.copied = 0
        shared.restore_length()
        engine.native.publish(self._target)
        if new_file:
            try:
                shared.show()
            except OSError as error:
                self._fail(error)
                return
        self._target.stale = 0
        record = self.record
        record.revision, record.changes, record.next_look = self._revision, tables.record.changes, self._next_look
        record.process, record.ready = os.getpid(), not shared.must_restore

    def _fail(self, error: Exception) -> None:
        self._failed = True
        reason = getattr(error, "strerror", None) or error
        log.warning("observers cannot see this world any more: %s", reason)
        self.shared.close()

    # Tables ----------------------------------------------------------------------------------------------------------

    def _refresh(self, mark: tuple[int, ...]) -> bool:
        """Write the scene if it changed; whether the tables need a new file, which is hidden until it is filled."""
        begin, look = time.monotonic(), None
        rows_changed = mark != self._mark or self.changed
        if not rows_changed:
            look = self._present_look()
            if look == self._look:
                self._next_look = begin + LOOK_PERIOD
                return False
        new_file = self._place_rows() if rows_changed else False
        self._look = self._present_look() if look is None else look
        self._write_scene()
        self._mark, self.changed = mark, False
        self._next_look = begin + max(LOOK_PERIOD, LOOK_SHARE * (time.monotonic() - begin))
        return new_file

    def _place_rows(self) -> bool:
        """Give each body a row, and the tables a file of their size; whether it is a new one."""
        world, tables = self.world, self.world.engine.tables
        geoms = list(world.engine.geoms.values())
        self._looks = [geom.appearance for geom in geoms]
        self._frusta = [geom for geom in geoms if isinstance(geom, FrustrumGeom)]
        known = [body for entity in world.entities for body in entity.bodies] + [geom.body for geom in geoms]
        fixed = dict.fromkeys(body for body in known if body.dummy)
        rows = {body: row for body, row in self._fixed_rows.items() if body in fixed}
        free = iter(sorted(set(range(len(fixed))) - set(rows.values())))
        for body in fixed:
            if body not in rows:
                rows[body] = next(free)
        self._fixed_rows = rows
        while len(self._fixed) <= max(rows.values(), default=0):
            self._fixed = np.concatenate([self._fixed, np.zeros_like(self._fixed)])
        world.engine.moved_dummies.update(rows)
        target, sizes = self._target, (tables.bodies.size, len(self._fixed), tables.joints.size)
        target.fixed, target.fixed_size = self._fixed.ctypes.data, self._fixed.nbytes
        if sizes == self._sizes:
            return False
        self._sizes = sizes
        self.shared.resize(tables.bodies.size + len(self._fixed), tables.joints.size)
        head = self.shared.header[0]
        head["step_time"] = world.engine.step_time
        target.target = self.shared.address
        target.bodies_offset, target.joints_offset = int(head["bodies_offset"]), int(head["joints_offset"])
        target.fixed_offset = target.bodies_offset + tables.bodies.size * BODY_COLUMNS * 8
        return True

    def _row(self, body: Body) -> int:
        return body.row if not body.dummy else self._sizes[0] + self._fixed_rows[body]

    def _move_dummies(self) -> None:
        """Copy the poses of bodies that ODE does not know, where they were set."""
        moved = self.world.engine.moved_dummies
        for body in moved:
            row = self._fixed_rows.get(body)
            if row is not None:
                frame = body.frame()
                self._fixed[row, :10] = (*frame, *frame[:3])
        moved.clear()

    # Scene -----------------------------------------------------------------------------------------------------------

    def _present_look(self) -> list[Any]:
        """All that the scene depends on, beside which bodies, joints, geoms and entities there are."""
        world = self.world
        return [
            [look.version for look in self._looks],
            [geom.fov for geom in self._frusta],
            world.engine.tables.joints.edits,
            [(entity.GetId(), entity.parent) for entity in world.entities],
            list(world.gz_server.interfaces),
            self._surroundings(),
        ]

    def _surroundings(self) -> dict[str, Any]:
        world, back = self.world, self.world.backdrop
        fog = {
            "kind": back.fog_kind,
            "color": world.skyColor if back.fog_color is None else back.fog_color,
            "density": world.fogDensity,
            "start": back.fog_start,
            "end": back.fog_end,
        }
        view = world.era.start_view(world)
        return {
            "world": world.name,
            "file": world.era.file_name,
            "era": world.era.name,
            "background": tuple(world.skyColor),
            "ambient": tuple(back.ambient),
            "fog": fog if world.fogEnable else None,
            "shadows": back.shadows,
            "gravity": world.engine.gravity,
            "view": None if view is None else pose_list(view),
        }

    def _write_scene(self) -> None:
        """Write the scene as a new revision. What did not change is not described again."""
        world = self.world
        served: dict[int, list[dict[str, str]]] = {}
        for (kind, name), interface in world.gz_server.interfaces.items():
            served.setdefault(interface.model_id, []).append({"type": kind, "id": name})
        owned = {body for entity in world.entities for body in entity.bodies}
        loose = dict.fromkeys(geom.body for geom in world.engine.geoms.values() if geom.body not in owned)
        chunks: dict[Entity | None, tuple[Any, str, set[str]]] = {}
        for entity in world.entities:
            interfaces = served.get(entity.GetIntId(), [])
            key = (*self._key(entity.bodies), *self._entity_key(entity), interfaces)
            former = self._chunks.get(entity)
            chunks[entity] = former if former is not None and former[0] == key else self._chunk(key, entity, interfaces)
        self._used = set()
        others = json.dumps(plain([self._describe(body, {}) for body in loose]), allow_nan=False)
        used = self._used.union(*(chunk[2] for chunk in chunks.values()))
        self._chunks = chunks
        self._stored = {key: kept for key, kept in self._stored.items() if kept[1]["file"] in used}
        geoms = world.engine.geoms.values()
        dome = next((g for g in geoms if isinstance(g, DomeGeom) and g.appearance.visible), None)
        head = {
            "format": FORMAT,
            "revision": self._revision + 1,
            "sim_time": world.clock.sim_time,
            **self._surroundings(),
            "sky": None
            if dome is None
            else {"texture": dome.appearance.texture_file, "time_of_day": 86400.0 * dome.day_share},
        }
        start = json.dumps(plain(head), allow_nan=False)[:-1]
        entities = ",\n".join(chunk for _, chunk, _ in chunks.values())
        text = f'{start}, "entities": [\n{entities}],\n"others": {others}}}\n'
        self.shared.write_scene(text.encode(), used)
        self._revision += 1

    def _key(self, bodies: list[Body]) -> tuple[Any, ...]:
        return tuple(
            (
                body.number,
                body.bodyName,
                self._row(body),
                [(geom.number, geom.appearance.version, getattr(geom, "fov", 0.0)) for geom in body.geoms],
            )
            for body in bodies
        )

    def _entity_key(self, entity: Entity) -> tuple[Any, ...]:
        versions = self.world.engine.tables.joints.versions
        joints = [(joint.row, int(versions[joint.row])) for joint in entity._entity_joints()]
        return entity.GetId(), entity.GetParentIntId(), entity.parentBody, joints

    def _chunk(self, key: Any, entity: Entity, interfaces: list[dict[str, str]]) -> tuple[Any, str, set[str]]:
        """What the scene says of an entity, and the data files that it names."""
        self._used = set()
        own = entity._entity_describe(self._store)
        names = own.pop("shape_names", {})
        body, pose = None, None
        try:
            body = entity.GetBody()
            pose = offset_in(entity.GetPose(), body)
        except NotFoundError:
            pose = pose_list(entity.initPose)
        data = {
            "number": entity.GetIntId(),
            "id": entity.GetId(),
            "type": entity.GetName(),
            "parent": entity.GetParentIntId(),
            "parent_body": entity.parentBody.number if entity.parentBody is not None else 0,
            "body": body.number if body is not None else 0,
            "pose": pose,
            "interfaces": interfaces,
            **own,
            "bodies": [self._describe(body, names) for body in entity.bodies],
        }
        return key, json.dumps(plain(data), allow_nan=False), self._used

    def _describe(self, body: Body, names: dict[Any, str]) -> dict[str, Any]:
        return describe_body(body, self._row(body), names, self._store)

    def _store(self, arrays: dict[str, NDArray[Any]]) -> dict[str, Any]:
        """Keep arrays in a file. Large ones, meshes that do not change, are converted once for all descriptions."""
        sources = tuple(arrays.values())
        key = tuple(map(id, sources))
        if key in self._stored:
            found = self._stored[key][1]
        else:
            small = {name: part.astype(_small(part.dtype)) for name, part in arrays.items()}
            found = self.shared.write_data(small)
            if sum(part.nbytes for part in sources) >= LARGE:
                self._stored[key] = sources, found
        self._used.add(found["file"])
        return found


def _small(kind: np.dtype[Any]) -> str:
    """The type of numbers in which a file has an array: bytes of images stay bytes."""
    return "f4" if kind.kind == "f" else "u1" if kind == np.uint8 else "u4"
