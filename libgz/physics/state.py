"""EngineState: what an engine's next steps depend on, as plain data.

ODE's own memory is copied by the step (`Step.get_state`), the tables are copied as arrays. What Python knows besides
(names, sizes, stops, who is attached to whom) changes rarely: it is collected as tuples at each call, by getters that
are made once for all objects of a class, and only encoded again when one of them differs from the last time.

Objects are numbered in the order of their construction, so that a state fits another process that built the same world.

`Engine.get_state()` returns plain data, `Engine.set_state(state)` puts it back, and what follows is the same to the
bit.
`libgz/physics/state.py` puts it together; what is new in the engine belongs into one of its parts:

- ODE's memory, copied by the step, in both forms (`gz_get_state` in `step.c`, `python_state.py`). ODE's setters change
  last bits (they
  normalise quaternions), and it has no getters for idle counters, for what joints measure their angles from, or for
the marks of geoms that have moved. `libgz/ode/memory.py` finds where these lie when the first engine is made: it writes
  odd values with
  ODE's functions and looks for them, and it counts sizes with an allocator of its own. So of a body all from its mass
  to its idle counters is copied, its switches and its damping; of a joint all behind its links to other objects:
  parameters, anchors and axes, reference rotations, limits; of a geom bits, lengths, offset and marks. No pointer is
copied; those that link bodies are exchanged. Where an ODE has another order, states raise LibraryError, and all else
  works.
- Orders. ODE finds contacts in the order of the geoms of a space, islands in the order in which bodies were made, and
  solves joints in the order in which bodies were attached. Bodies that were made in another order are linked anew
  (`order_bodies`), as where a plugin made a link after models that are built again. Geoms are
  removed from their spaces and added again, last one first, parents after their parts; then
boxes are computed, and the marks are written: a marked geom keeps its place when it moves, others go to the front.
  Joints are
  attached again from the first one on that differs from `Engine.attached`.
- Tables: centres of mass, states, springs, turns that were counted, surfaces, by objects in order of construction. The
  same call as for
ODE's memory copies them: `Parts` has their addresses, and is made again when a row was taken or freed. Rows are part of
  a state:
springs are applied in their order, and contacts are recorded with them. Objects that were built again get the rows of
  the old ones.
- What Python knows besides: the attributes that a class names in `KEPT` (sizes, masses, stops, names) and how geoms
  look. Assignments to
them are counted (`physics/edits.py`). They are collected only after one, and encoded again only if one differs from the
  last time;
a class that gets a new attribute that may change later adds it there, and replaces its value instead of changing it in
  place.
- Settings of the engine, its counters and random state, recorded contacts, feedback of joints, gears and threads.

Objects have numbers, in order of construction. They are found by those, and where that does not fit, as in another
process, by their
names, bodies and models; spaces by the geoms in them, screws and gears by their joints. What was made since is closed,
newest first; if
something is missing, StateError names it and nothing has changed. `tests/physics/test_random_states.py` looks for what
is forgotten: add new changes there.

ODE keeps nothing else that matters: the quick solver starts each step from zero, meshes without temporal caches, the
hash
space from the order of its geoms and its levels, which are restored. Memory of joints that ODE's constructors do not
set is zeroed, so
equal engines have equal states.
"""

from __future__ import annotations

import base64
import ctypes
import functools
import json
import struct
import weakref
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from libgz.base.errors import ParameterError, StateError
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.ode.context import StepContext
from libgz.ode.lib import ode
from libgz.ode.memory import layout, order_bodies
from libgz.ode.parts import Parts
from libgz.ode.types import ContactRule, JointFeedback, Mass
from libgz.physics.edits import edits
from libgz.physics.meshes import Mesh

__all__ = ["PARTS", "EngineState"]

MOST_ROWS = 1 << 24  # of a table
MOST_NAMED = 5  # missing objects in a message

PARTS = ("ode", "settings", "numbers", "quirks", "objects", "memory", "fresh", "dummies", "couplings", "contacts")

# Fields of the context that are saved as their bytes, for they follow each other.
SAVED_FIELDS = (
    *("step", "quick", "contact_rule", "count_turns", "seed", "steps", "contact_count"),
    *("max_contacts", "cone", "gravity", "record_contacts"),
)
_FIELDS = struct.Struct("=d3qQ4q3dq")
_FIRST = getattr(StepContext, SAVED_FIELDS[0]).offset
_PROGRESS, _REST = (getattr(StepContext, name).offset - _FIRST for name in ("seed", "max_contacts"))
# The attributes of an engine that set most of them.
SETTINGS = (
    *("step_time", "contact_rule", "count_turns"),
    *("max_contacts", "cone", "gravity", "record_contacts"),
)
# Other attributes of an engine: settings, those that are set together, and plain ones.
SWITCHES = ("record_motion", "exact_rest", "surface_layer")
SOLVER = ("iterations", "over_relaxation")
CONSTRAINTS = ("erp", "cfm", "correcting_velocity")
COUNTERS = ("collisions", "abandoned")
_POSE = struct.Struct("7d")
_numbers = attrgetter(
    *("_context.record_motion", "_context.exact_rest", "_surface_layer"),
    *(*SOLVER, *CONSTRAINTS, "_context.max_distance", *COUNTERS),
)
_NUMBERS = len(SWITCHES) + len(SOLVER) + len(CONSTRAINTS) + 1 + len(COUNTERS)


_type: Any = type  # mypy takes a class for no key of a cache


@functools.cache
def _getter(kind: Any) -> Callable[[Any], tuple[Any, ...]]:
    """Reads what a class and its bases keep: their attributes KEPT."""
    names = _kept(kind)
    get = attrgetter(*names)
    return get if len(names) > 1 else lambda thing: (get(thing),)


@functools.cache
def _watcher(kind: Any, *more: str) -> Callable[[Any], Any]:
    """Reads what a class keeps, and more attributes."""
    return attrgetter(*_kept(kind), *more)


@functools.cache
def _kept(kind: Any) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for base in reversed(kind.__mro__) for name in vars(base).get("KEPT", ())))


def _pose_bytes(pose: GzPose) -> bytes:
    place, turn = pose.pos, pose.rot
    return _POSE.pack(place.x, place.y, place.z, turn.u, turn.x, turn.y, turn.z)


class _Present:
    """The objects of an engine, as they were when the tables last changed.

    Attributes:
        changes: of the tables, then.
        rows: of bodies, joints and geoms.
        watched: getters of what decides how objects are encoded, each with the objects of its class.
    """

    def __init__(self, engine: Any) -> None:
        tables = engine.tables
        of_each = (tables.bodies, tables.joints, tables.geoms)
        self.changes = tables.changes
        self.rows = [_rows(table) for table in of_each]
        self.bodies, self.geoms, self.joints = (
            list(table.values()) for table in (engine.bodies, engine.geoms, engine.joints)
        )
        watched: dict[Any, list[Any]] = {}
        looks = ((self.bodies, ()), (self.geoms, ("appearance.edits", "space")), (self.joints, ("bodies", "_feedback")))
        for things, more in looks:
            for thing in things:
                watched.setdefault(_watcher(_type(thing), "_id", *more), []).append(thing)
        self.watched = list(watched.items())


class EngineState:
    """Gets and sets the state of an engine.

    Args:
        engine: the `Engine`, which is not named here: it stands above this module.
        context: its context.
    """

    def __init__(self, engine: Any, context: StepContext) -> None:
        self._owner = weakref.ref(engine)
        self._context = context
        self._now: _Present | None = None
        self._collected: list[Any] = []  # at the last encoding
        self._block = b""  # that encoding
        self._seen: tuple[int, ...] = ()  # how much was edited by then, and how many objects there were
        self._parts: Parts | None = None
        self._parts_have_motion = 0
        self._settings = memoryview(context).cast("B")[_FIRST : _FIRST + _FIELDS.size]
        self._dummy_moves = -1  # the count when their poses were read last
        self._dummies = b""  # those

    @property
    def _engine(self) -> Any:
        return self._owner()

    @functools.cached_property
    def _digest(self) -> str:
        return layout().digest

    def forget(self) -> None:
        """Drop what was collected, which can be large."""
        self._now, self._collected, self._block, self._seen, self._parts = None, [], b"", (), None

    # Get ---------------------------------------------------------------------------------------------------------

    def get(self) -> dict[str, Any]:
        """The state; see `Engine.get_state`."""
        return dict(zip(PARTS, self.values(), strict=True))

    def values(self, kept: Callable[[bytes], Any] = bytes) -> tuple[Any, ...]:
        """The parts of the state, in the order of PARTS; ODE's memory, which can be large, as `kept` returns it."""
        engine: Any = self._owner()
        context, tables = self._context, engine.tables
        turning = context.count_turns
        if tables.touched:
            _refresh(tables.bodies)
            if not turning:  # else reading would count turns
                _refresh(tables.joints)
        present = self._present(engine)
        objects = self._objects(engine, present)
        joints, dummies, couplings, quirks = present.joints, engine.dummies, engine.couplings, engine.quirks
        return (
            self._digest,
            self._settings.tobytes(),
            _numbers(engine),
            sorted(quirks) if quirks else [],
            objects,
            kept(engine.native.get_state(self._present_parts(engine, present))),
            bytes([tables.joints.fresh[joint.row] for joint in joints]) if turning and joints else b"",
            self._dummy_poses(dummies) if dummies else b"",
            _couplings(couplings, joints) if couplings else [],
            engine.contacts.tobytes() if context.record_contacts else b"",
        )

    def _dummy_poses(self, dummies: Iterable[Any]) -> bytes:
        """The poses of dummies, read again only after one was set, or one came or went."""
        if self._dummy_moves != (moves := self._engine.dummy_moves):
            self._dummies = b"".join([_pose_bytes(dummy._pose) for dummy in dummies])
            self._dummy_moves = moves
        return self._dummies

    def _present(self, engine: Any) -> _Present:
        if self._now is None or self._now.changes != engine.tables.changes:
            self._now = _Present(engine)
        return self._now

    def _present_parts(self, engine: Any, present: _Present) -> Parts:
        """For the step; to be called after `_objects`, which notices other handles."""
        motion = self._context.record_motion
        if self._parts is None or self._parts_have_motion != motion:
            geoms = [0] * engine.tables.geoms.used
            for row, geom in engine.geoms.items():
                geoms[row] = geom._id or 0
            self._parts = Parts(
                layout(),
                [body._id for body in present.bodies],
                [joint._id for joint in present.joints],
                geoms,
                [engine.top.id, *(space._id for space in engine.spaces)],
                [*_memory(engine.tables, present, motion), *_feedbacks(present.joints)],
            )
            self._parts_have_motion = motion
        return self._parts

    def _objects(self, engine: Any, present: _Present) -> bytes:
        """What Python knows of the objects, as compressed JSON."""
        seen = edits.last, len(engine.dummies), len(engine.attached), len(engine.spaces)
        if self._seen == seen and self._collected[0] is present:
            return self._block
        dummies, attached = list(engine.dummies), list(engine.attached)
        collected: list[Any] = [present, dummies, attached, list(engine.spaces)]
        collected += [list(map(get, things)) for get, things in present.watched]
        collected += [_getter(_type(dummy))(dummy) for dummy in dummies]
        if collected != self._collected:
            text = self._encode(present.bodies, dummies, present.geoms, present.joints, attached)
            self._block = zlib.compress(text, 1)
            self._collected, self._parts = collected, None
        self._seen = seen
        return self._block

    def _encode(
        self, bodies: list[Any], dummies: list[Any], geoms: list[Any], joints: list[Any], attached: list[Any]
    ) -> bytes:
        engine, tables = self._engine, self._engine.tables
        codes = _codes(bodies, dummies)
        place = {space: i for i, space in enumerate((engine.top, *engine.spaces))}
        number = {joint: i for i, joint in enumerate(joints)}
        plain = {
            "rows": [table.census() for table in (tables.bodies, tables.joints, tables.geoms)],
            "bodies": [[body.label, _named(body)] for body in bodies],
            "dummies": [[body.label, _named(body)] for body in dummies],
            "geoms": [
                [type(geom).__name__, codes[geom.body], _named(geom), _appearance(geom.appearance)] for geom in geoms
            ],
            "joints": [
                [type(joint).__name__, [codes.get(body) for body in joint.bodies], _named(joint)] for joint in joints
            ],
            "feedback": [joint._feedback is not None for joint in joints],
            "attached": [number[joint] for joint in attached],
            "spaces": [place[space.parent] for space in engine.spaces],
            "inside": [None if geom.space is None else place[geom.space] for geom in geoms],
        }
        return json.dumps(plain, separators=(",", ":")).encode()

    # Set ---------------------------------------------------------------------------------------------------------

    def set(self, state: dict[str, Any]) -> None:
        """Set a state; see `Engine.set_state`."""
        engine = self._engine
        if state.get("ode") != self._digest:
            raise StateError("this state was made with another build of ODE")
        block, present = state["objects"], self._present(engine)
        if block != self._objects(engine, present):
            saved = _decoded(block)
            _check_objects(saved)
            self._restore_objects(saved)
            present = self._present(engine)
            self._objects(engine, present)
        self._restore_settings(state)
        if not engine.native.set_state(self._present_parts(engine, present), bytes(state["memory"])):
            raise StateError("geoms are in other spaces, or on other bodies, than in this state")
        self._restore_tables(state)
        self._restore_parts(state)
        engine.tables.disturb()

    def _restore_settings(self, state: dict[str, Any]) -> None:
        engine, context = self._engine, self._context
        engine.quirks = frozenset(state["quirks"])
        numbers = tuple(state["numbers"])
        if len(numbers) != _NUMBERS or len(state["settings"]) != _FIELDS.size:
            raise StateError("the state is damaged: it has not all numbers of an engine")
        settings, present = state["settings"], self._settings
        if settings[:_PROGRESS] != present[:_PROGRESS] or settings[_REST:] != present[_REST:]:
            then, now = _fields(settings), _fields(present)
            for name in SETTINGS:
                if then[name] != now[name]:
                    setattr(engine, name, then[name])
            context.quick = then["quick"]
        present[_PROGRESS:_REST] = settings[_PROGRESS:_REST]  # random state, how many steps and contacts there were
        if numbers != (others := _numbers(engine)):
            for name, value, other in zip(SWITCHES, numbers, others, strict=False):
                if value != other:
                    setattr(engine, name, value)
            rest = iter(numbers[len(SWITCHES) :])
            engine.set_quick_step(*islice(rest, len(SOLVER)))
            engine.set_constraints(*islice(rest, len(CONSTRAINTS)))
            if (distance := next(rest)) != context.max_distance:
                engine.set_range(distance)
            engine.collisions, engine.abandoned = rest

    def _restore_tables(self, state: dict[str, Any]) -> None:
        """What follows from the tables, whose numbers were copied with ODE's memory."""
        engine, tables = self._engine, self._engine.tables
        bodies, joints, geoms = tables.bodies, tables.joints, tables.geoms
        joints.find_sprung()
        bodies.fresh[:] = b"\1" * len(bodies.fresh)
        joints.fresh[:] = b"\1" * len(joints.fresh)
        for joint, fresh in zip(engine.joints.values(), state["fresh"], strict=bool(state["fresh"])):
            joints.fresh[joint.row] = fresh
        geoms.edits += 1
        tables.touched = True

    def _restore_parts(self, state: dict[str, Any]) -> None:
        engine = self._engine
        if state["couplings"] or engine.couplings:
            joints = list(engine.joints.values())
            present = {joints.index(one.line): one for one in engine.couplings if not one.broken}
            engine.couplings = [present[place] for place, _ in state["couplings"]]
            for coupling, (_, values) in zip(engine.couplings, state["couplings"], strict=True):
                for name, value in zip(_kept(_type(coupling)), values, strict=True):
                    setattr(coupling, name, value)
        engine.moved_dummies.update(engine.dummies)
        engine.tables.record.changes += 1
        if engine.dummies and state["dummies"] != self._dummy_poses(engine.dummies):
            for dummy, place in zip(engine.dummies, _POSE.iter_unpack(state["dummies"]), strict=True):
                dummy._pose = GzPose(GzVector(*place[:3]), GzQuatern(*place[3:]))
            engine.dummy_moves += 1
        if engine.record_contacts:
            engine.native.set_contacts(state["contacts"])

    # Objects -----------------------------------------------------------------------------------------------------

    def _restore_objects(self, saved: dict[str, Any]) -> None:
        engine, tables = self._engine, self._engine.tables
        matched = self._match(saved)
        keep = set(map(id, (thing for things in matched for thing in things)))
        present = (engine.joints.values(), engine.geoms.values(), engine.bodies.values(), engine.dummies)
        for things in present:
            for thing in reversed(list(things)):
                if id(thing) not in keep and not thing.closed:
                    thing.close()
        bodies, dummies, geoms, joints, spaces = matched
        for space in reversed([space for space in engine.spaces if space not in spaces]):
            space.close()
        engine.spaces.clear()
        engine.spaces.update(dict.fromkeys(spaces))
        engine.couplings = [coupling for coupling in engine.couplings if not coupling.broken]
        if list(engine.bodies.values()) != bodies:
            order_bodies(engine.world, [body._id for body in bodies])
        ordered = ((tables.bodies, bodies), (tables.joints, joints), (tables.geoms, geoms))
        for (table, things), census in zip(ordered, saved["rows"], strict=True):
            if table.census() != _tuples(census) or list(table.objects.values()) != things:
                table.arrange(things, *census)
        tables.publish()
        tables.bodies.ids[:] = tables.joints.ids[:] = 0
        for body in bodies:
            tables.bodies.ids[body.row] = body._id
        for body, (_, values) in zip((*bodies, *dummies), (*saved["bodies"], *saved["dummies"]), strict=True):
            _assign(body, values)
        engine.auto_disabled.clear()
        engine.auto_disabled.update(body for body in bodies if body.auto_disable)
        for geom, (_, _, values, look) in zip(geoms, saved["geoms"], strict=True):
            self._restore_geom(geom, values, look)
        self._restore_joints(saved, joints, [*bodies, *dummies], len(bodies))

    def _restore_geom(self, geom: Any, values: list[Any], look: dict[str, Any]) -> None:
        if geom._id is not None:
            ode().dGeomSetData(geom._id, geom.row)
        self._engine.tables.geoms.owner[geom.row] = geom.body.number
        changed = _assign(geom, values)
        if look != (present := _appearance(geom.appearance)):
            if look.keys() != present.keys():
                raise StateError("the state is damaged: a geom has other looks")
            for name, value in look.items():
                setattr(geom.appearance, name, _value(value))
            changed = True
        geom.appearance.version += changed
        geom.mark()

    def _restore_joints(self, saved: dict[str, Any], joints: list[Any], bodies: list[Any], count: int) -> None:
        engine, table = self._engine, self._engine.tables.joints
        found = {i if i < count else count - 1 - i: body for i, body in enumerate(bodies)}
        for joint, (_, _, values), feedback in zip(joints, saved["joints"], saved["feedback"], strict=True):
            _assign(joint, values)
            joint.provide_feedback(feedback)
        pairs = [tuple(None if code is None else found[code] for code in codes) for _, codes, _ in saved["joints"]]
        order = [(joints[i], pairs[i]) for i in saved["attached"]]
        same = 0
        for joint, (other, pair) in zip(list(engine.attached), order, strict=False):
            if joint is not other or joint.bodies != pair:
                break
            same += 1
        for joint in list(engine.attached)[same:]:
            joint.Detach()
        for joint, pair in order[same:]:
            try:
                joint.check_bodies(*pair)
            except ParameterError as error:
                raise StateError(f"the state is damaged: {error}") from error
            joint._join(*pair)
        for joint in joints:
            table.ids[joint.row] = joint._id if joint in engine.attached else 0
            table.types[joint.row] = int(joint.kind)

    def _match(self, saved: dict[str, Any]) -> tuple[list[Any], list[Any], list[Any], list[Any], list[Any]]:
        """The objects that are in the state: bodies, dummies, geoms, joints, spaces; nothing is changed yet."""
        engine, tables = self._engine, self._engine.tables
        censuses = dict(zip(("bodies", "joints", "geoms"), saved["rows"], strict=True))
        # By numbers from 0 on, and from -1 on downwards, as `_codes`.
        names = [label for label, _ in (*saved["bodies"], *reversed(saved["dummies"]))]
        missing: list[str] = []

        def find(
            kind: str, wanted: list[Any], things: Iterable[Any], trait: Callable[[Any], Any], least: int
        ) -> list[Any]:
            """Things of these traits, else of their first parts: those of the same numbers first, then any."""
            table, present = getattr(tables, kind, None), list(things)
            numbers = dict(zip(table.census()[1], present, strict=True)) if table is not None else {}
            found = [numbers.get(number) for number in censuses[kind][1]] if table is not None else []
            for parts in (None, least):
                for candidates in (found, _chosen(present, wanted, trait, parts)):
                    traits = [trait(thing)[:parts] if thing is not None else None for thing in candidates]
                    if traits == [want[:parts] for want in wanted]:
                        return candidates
            chosen = _chosen(present, wanted, trait, least)
            missing.extend(_text(kind, want, names) for want, one in zip(wanted, chosen, strict=True) if one is None)
            return chosen

        bodies, dummies = (
            find(kind, [(values[0], label) for label, values in saved[kind]], things, _body_trait, 1)
            for kind, things in (("bodies", engine.bodies.values()), ("dummies", engine.dummies))
        )
        codes = _codes(bodies, dummies)
        wanted = [tuple(row[:2]) for row in saved["geoms"]]
        geoms = find("geoms", wanted, engine.geoms.values(), lambda g: (type(g).__name__, codes.get(g.body)), 2)
        joints = find(
            "joints",
            [(kind, values[0], *pair) for kind, pair, values in saved["joints"]],
            engine.joints.values(),
            lambda joint: (type(joint).__name__, joint.name, *map(codes.get, joint.bodies)),
            2,
        )
        spaces = self._match_spaces(saved, geoms)
        if None in spaces:
            missing.append(f"{spaces.count(None)} spaces of geoms")
        if missing:
            more = len(missing) - MOST_NAMED
            listed = ", ".join(missing[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
            raise StateError(f"this state has what the world has not (any more): {listed}")
        return bodies, dummies, geoms, joints, spaces

    def _match_spaces(self, saved: dict[str, Any], geoms: list[Any]) -> list[Any]:
        """The spaces in the order of the state: known by their geoms, and by their parts; of empty ones any."""
        engine, parents = self._engine, saved["spaces"]
        found: dict[int, Any] = {0: engine.top}
        for geom, place in zip(geoms, saved["inside"], strict=True):
            if place is not None and geom is not None and geom.space is not None:
                found.setdefault(place, geom.space)
        for i in range(len(parents), 0, -1):
            if i in found:
                found.setdefault(parents[i - 1], found[i].parent)
        left = [space for space in engine.spaces if space not in found.values()]
        for i, parent in enumerate(parents, 1):
            if i not in found:
                found[i] = next((space for space in left if space.parent is found.get(parent)), None)
                left = [space for space in left if space is not found[i]]
        return [found[i] for i in range(1, len(parents) + 1)]


def _couplings(couplings: Iterable[Any], joints: list[Any]) -> list[tuple[int, list[Any]]]:
    """What couplings keep, each behind the number of its first joint."""
    return [(joints.index(one.line), [*_plain_values(one)]) for one in couplings if not one.broken]


def _body_trait(body: Any) -> tuple[Any, ...]:
    return body.bodyName, body.label


def _text(kind: str, trait: Sequence[Any], names: Sequence[str]) -> str:
    """What is missing, in words."""
    if kind in ("bodies", "dummies"):
        return f"body {trait[0] or 'unnamed'!r}"
    return f"{trait[0]} of body {names[trait[1]]!r}" if kind == "geoms" else f"{trait[0]} {trait[1] or 'unnamed'!r}"


def _chosen(
    things: Iterable[Any], wanted: Sequence[Any], trait: Callable[[Any], Any], least: int | None
) -> list[Any | None]:
    """A thing for each of the wanted traits: by all of it, else by its first parts; None where there is none."""
    left, found = list(things), [None] * len(wanted)
    for parts in dict.fromkeys((None, least)):
        by_trait: dict[Any, list[Any]] = {}
        for thing in reversed(left):
            by_trait.setdefault(trait(thing)[:parts], []).append(thing)
        for i, want in enumerate(wanted):
            if found[i] is None and by_trait.get(want[:parts]):
                found[i] = by_trait[want[:parts]].pop()
        left = [thing for others in by_trait.values() for thing in reversed(others)]
    return found


def _codes(bodies: Sequence[Any], dummies: Sequence[Any]) -> dict[Any, int]:
    """Bodies by numbers from 0 on, dummies by -1 and less."""
    return {body: i for i, body in enumerate(bodies)} | {body: ~i for i, body in enumerate(dummies)}


# Tables -------------------------------------------------------------------------------------------------------------


def _rows(table: Any) -> list[tuple[int, int]]:
    """The rows in use, in order of construction: (first, count) of those that follow each other."""
    runs: list[tuple[int, int]] = []
    for row in table.objects:
        if runs and row == sum(runs[-1]):
            runs[-1] = (runs[-1][0], runs[-1][1] + 1)
        else:
            runs.append((row, 1))
    return runs


def _memory(tables: Any, present: _Present, motion: bool) -> Iterator[tuple[int, int]]:
    """Where the numbers of all objects are in the tables: (address, size [byte]) of rows that follow each other."""
    bodies, joints, geoms = present.rows
    arrays = [(tables.bodies.com, bodies), (tables.bodies.state, bodies)]
    arrays += [(tables.bodies.motion, bodies)] * bool(motion)
    arrays += [(tables.joints.state, joints), (tables.joints.springs, joints), (tables.geoms.surface, geoms)]
    for array, rows in arrays:
        width = array.strides[0]
        for first, count in rows:
            yield array.ctypes.data + first * width, count * width


def _feedbacks(joints: Iterable[Any]) -> Iterator[tuple[int, int]]:
    for joint in joints:
        if joint._feedback is not None:
            yield ctypes.addressof(joint._feedback), ctypes.sizeof(JointFeedback)


def _refresh(table: Any) -> None:
    """Read stale rows from ODE."""
    fresh = table.fresh
    if fresh.find(0, 0, table.used) >= 0:
        for row in table.objects:
            if not fresh[row]:
                table.read(row)


def _decoded(block: bytes) -> Any:
    try:
        return json.loads(zlib.decompress(block))
    except (zlib.error, ValueError) as error:
        raise StateError(f"the state is damaged: {error}") from error


def _check_objects(saved: Any) -> None:
    """Check that the parts of a list of objects fit each other.

    Raises:
        StateError: they do not.
    """
    try:
        bodies, dummies, geoms, joints, spaces = (
            saved[kind] for kind in ("bodies", "dummies", "geoms", "joints", "spaces")
        )
        things, inside, attached = (bodies, joints, geoms), saved["inside"], saved["attached"]
        held = [body for _, body, *_ in geoms]
        held += [body for _, (one, two), _ in joints for body in (one, two) if body is not None]
        fits = (
            all(_counts(census, len(some)) for census, some in zip(saved["rows"], things, strict=True))
            and (len(inside), len(saved["feedback"])) == (len(geoms), len(joints))
            and all(-len(dummies) <= body < len(bodies) for body in held)
            and len(set(attached)) == len(attached)
            and all(0 <= joint < len(joints) for joint in attached)
            and all(any(body is not None and body >= 0 for body in joints[joint][1]) for joint in attached)
            and all(0 <= parent <= len(spaces) for parent in spaces)
            and all(place is None or 0 <= place <= len(spaces) for place in inside)
        )
    except (TypeError, ValueError, KeyError, IndexError) as error:
        raise StateError(f"the state is damaged: its list of objects is incomplete ({error})") from error
    if not fits:
        raise StateError("the state is damaged: its bodies, geoms, joints and spaces do not fit each other")


def _counts(census: Any, count: int) -> bool:
    """Whether a census is one of so many objects."""
    rows, numbers, free, (used, _) = census
    taken = {*rows, *free}
    return (
        len(rows) == len(numbers) == len(set(numbers)) == count
        and len(taken) == len(rows) + len(free)
        and all(0 <= row < used <= MOST_ROWS for row in taken)
    )


# Plain data ---------------------------------------------------------------------------------------------------------


def _plain_values(thing: Any) -> Iterable[Any]:
    return (list(v) if isinstance(v, (list, tuple)) else v for v in _getter(_type(thing))(thing))


def _fields(settings: Any) -> dict[str, Any]:
    """What is to be set, by the names of SETTINGS, and `quick`."""
    step, quick, rule, *values = _FIELDS.unpack(settings)
    if quick not in (0, 1) or rule not in list(ContactRule):
        raise StateError("the state is damaged: the engine has no such solver or rule of contacts")
    turns, _, _, _, most, cone, x, y, z, record = values
    return {
        **{"step_time": step, "quick": quick, "contact_rule": rule, "count_turns": turns},
        **{"max_contacts": most, "cone": cone, "gravity": (x, y, z), "record_contacts": record},
    }


def _named(thing: Any) -> list[Any]:
    """What an object keeps, in the order of its KEPT."""
    return [_plain(value) for value in _getter(_type(thing))(thing)]


def _appearance(look: Any) -> dict[str, Any]:
    return {name: _plain(value) for name, value in vars(look).items() if name not in ("version", "edits")}


def _assign(thing: Any, values: list[Any]) -> bool:
    """Set what an object keeps; returns whether something was different."""
    changed = False
    for name, value, present in zip(_kept(_type(thing)), values, _named(thing), strict=True):
        if value != present:
            setattr(thing, name, _value(value))
            changed = True
    return changed


def _plain(value: Any) -> Any:
    """A value as JSON has them; others than numbers, texts and lists as {kind: data}."""
    if isinstance(value, GzPose):
        return {"pose": [*value.pos, *value.rot]}
    for kind in (GzVector, GzQuatern, GzColor):  # also where a layer above has a class of its own for them
        if isinstance(value, kind):
            return {kind.__name__: list(value)}
    if isinstance(value, Mass):
        return {"mass": [value.mass, *value.c, *value.I]}
    if isinstance(value, np.ndarray):
        return {"array": [value.dtype.str, list(value.shape), base64.b64encode(value.tobytes()).decode()]}
    if isinstance(value, Mesh):
        return {"mesh": [_plain(value.vertices), _plain(value.triangles)]}
    if isinstance(value, Path):
        return {"path": str(value)}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    return value


def _value(plain: Any) -> Any:
    """The value that `_plain` was made of; lists become tuples."""
    if isinstance(plain, list):
        return tuple(map(_value, plain))
    if not isinstance(plain, dict):
        return plain
    ((kind, data),) = plain.items()
    if kind == "pose":
        return GzPose(GzVector(*data[:3]), GzQuatern(*data[3:]))
    if kind == "mass":
        mass = Mass(data[0])
        mass.c[:], mass.I[:] = data[1:5], data[5:]
        return mass
    if kind == "array":
        kind_of_number, shape, text = data
        return np.frombuffer(base64.b64decode(text), dtype=kind_of_number).reshape(shape).copy()
    if kind == "mesh":
        return Mesh(*map(_value, data))
    if kind == "path":
        return Path(data)
    return {"GzVector": GzVector, "GzQuatern": GzQuatern, "GzColor": GzColor}[kind](*data)


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
