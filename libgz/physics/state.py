"""EngineState: what an engine's next steps depend on, as plain data.

ODE's own memory is copied by the step (`Step.get_state`), the tables are copied as arrays. What Python knows besides
(names, sizes, stops, who is attached to whom) is read from the objects: a class lists such attributes as SAVED.

Objects are numbered in the order of their construction, so that a state fits another process that built the same world.
A state is not trusted: what it says is checked before it reaches ODE (`bounds`). Its parts:

- ODE's memory, copied by the step (`gz_get_state`). ODE's setters change last bits (they normalise quaternions), and
  it has no getters for idle counters, what joints measure their angles from, and the marks of geoms that have moved.
  `ode/memory.py` finds where these lie. No pointer is copied; those that link bodies are exchanged.
- Orders: of geoms in spaces and on bodies, of bodies, and of joints as they were attached; ODE computes in them. Geoms
  are removed from their spaces and added again, last one first, parents after their parts; then boxes are computed, and
  the marks are written. Joints are attached again from the first one on that differs.
- Tables, by objects in order of construction. Rows are part of a state: springs are applied in their order, and
  contacts are recorded with them. Objects that were built again get the rows of the old ones.
- SAVED attributes, and how geoms look. A class that gets a new attribute that may change later adds it there, and
  replaces its value instead of changing it in place.
- Settings of the engine, its counters and random state, recorded contacts, feedback of joints, gears and threads.
- What was made since is closed, newest first; what is missing is named, and nothing has changed (`matching`).
"""

from __future__ import annotations

import ctypes
import math
import struct
import weakref
from collections.abc import Iterable, Sequence
from itertools import islice
from operator import attrgetter
from typing import Any

import numpy as np

from libgz.base import encoding
from libgz.base.errors import GazeboError, LibraryError, ParameterError, StateError
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.ode.context import CONTACT, SOLVERS, StepContext
from libgz.ode.lib import ode
from libgz.ode.memory import layout, order_bodies
from libgz.ode.parts import Parts
from libgz.ode.types import ContactRule, JointFeedback, Mass
from libgz.physics.bounds import FINITE, Block, check_memory
from libgz.physics.check import FAR, LARGEST
from libgz.physics.matching import codes_of, match
from libgz.physics.meshes import Mesh
from libgz.physics.saved import saved_names, saved_values

__all__ = ["PARTS", "EngineState"]

MOST_ROWS = 1 << 24  # of a table
PARTS = ("ode", "settings", "numbers", "quirks", "objects", "memory", "fresh", "dummies", "couplings", "contacts")

# Fields of the context that are saved as their bytes, for they follow each other.
SAVED_FIELDS = (
    *("step", "solver", "contact_rule", "count_turns", "seed", "steps", "contact_count"),
    *("max_contacts", "cone", "gravity", "record_contacts"),
)
_FIELDS = struct.Struct("=d3qQ4q3dq")
_FIRST = getattr(StepContext, SAVED_FIELDS[0]).offset
_PROGRESS, _REST = (getattr(StepContext, name).offset - _FIRST for name in ("seed", "max_contacts"))
# The attributes of an engine that set most of them.
SETTINGS = ("step_time", "contact_rule", "count_turns", "max_contacts", "cone", "gravity", "record_contacts")
# Other attributes of an engine: settings, those that are set together, and plain ones.
SWITCHES = ("record_motion", "exact_rest", "explicit_gyroscopic", "surface_layer")
SOLVER = ("iterations", "over_relaxation")
CONSTRAINTS = ("erp", "cfm", "correcting_velocity")
COUNTERS = ("collisions", "abandoned")
_POSE = struct.Struct("7d")
_numbers = attrgetter(
    *("_context.record_motion", "_context.exact_rest", "_context.explicit_gyroscopic", "_surface_layer"),
    *(*SOLVER, *CONSTRAINTS, "_context.max_distance", *COUNTERS),
)
_DISTANCE = len(SWITCHES) + len(SOLVER) + len(CONSTRAINTS)  # the number with which that begins
_NUMBERS = _DISTANCE + 1 + len(COUNTERS)


class EngineState:
    """Gets and sets the state of an engine.

    Args:
        engine: the `Engine`, which is not named here: it stands above this module.
        context: its context.
    """

    def __init__(self, engine: Any, context: StepContext) -> None:
        self._owner = weakref.ref(engine)
        self._context = context
        self._sound: tuple[Any, ...] = ()  # what was found sound last
        self._settings = memoryview(context).cast("B")[_FIRST : _FIRST + _FIELDS.size]

    @property
    def _engine(self) -> Any:
        return self._owner()

    # Get ---------------------------------------------------------------------------------------------------------

    def get(self) -> dict[str, Any]:
        """The state; see `Engine.get_state`."""
        engine, turning = self._engine, self._context.count_turns
        tables = engine.tables
        if tables.touched:
            _refresh(tables.bodies)
            if not turning:  # else reading would count turns
                _refresh(tables.joints)
        joints = list(engine.joints.values())
        return {
            "ode": layout().digest,
            "settings": self._settings.tobytes(),
            "numbers": list(_numbers(engine)),
            "quirks": sorted(engine.quirks),
            "objects": self._objects(),
            "memory": engine.native.get_state(self._parts(self._blocks(self._context.record_motion))),
            "fresh": bytes([tables.joints.fresh[joint.row] for joint in joints]) if turning else b"",
            "dummies": self._dummy_poses(),
            "couplings": [
                [joints.index(one.line), _lists(saved_values(one))] for one in engine.couplings if not one.broken
            ],
            "contacts": self._contacts() if self._context.record_contacts else b"",
        }

    def _dummy_poses(self) -> bytes:
        return b"".join([_POSE.pack(*dummy.frame()) for dummy in self._engine.dummies])

    def _parts(self, blocks: Sequence[Block]) -> Parts:
        """What is copied by the step."""
        engine, tables = self._engine, self._engine.tables
        geoms = [0] * tables.geoms.used
        for row, geom in engine.geoms.items():
            geoms[row] = geom._id or 0
        return Parts(
            layout(),
            [body._id for body in engine.bodies.values()],
            [joint._id for joint in engine.joints.values()],
            geoms,
            [engine.top.id, *(space._id for space in engine.spaces)],
            [(block.address, 8 * block.columns * block.rows) for block in blocks],
        )

    def _blocks(self, motion: int) -> list[Block]:
        """Rows of tables that follow each other; with their motion, if it is recorded."""
        engine, tables = self._engine, self._engine.tables
        bodies, joints, geoms = map(_runs, (tables.bodies, tables.joints, tables.geoms))
        arrays = [("com", tables.bodies.com, bodies), ("state", tables.bodies.state, bodies)]
        arrays += [("motion", tables.bodies.motion, bodies)] * bool(motion)
        arrays += [("joints", tables.joints.state, joints), ("springs", tables.joints.springs, joints)]
        arrays += [("surface", tables.geoms.surface, geoms)]
        found = [
            Block(name, array.shape[1], count, array.ctypes.data + first * array.strides[0])
            for name, array, runs in arrays
            for first, count in runs
        ]
        size = ctypes.sizeof(JointFeedback) // 8
        feedbacks = [joint._feedback for joint in engine.joints.values() if joint._feedback is not None]
        return found + [Block("feedback", size, 1, ctypes.addressof(feedback)) for feedback in feedbacks]

    def _contacts(self) -> bytes:
        """The contacts that are recorded, but those of geoms that have been removed since."""
        contacts, known = self._engine.contacts, [0, *self._engine.geoms]
        there = np.isin(contacts["geom1"], known) & np.isin(contacts["geom2"], known)
        kept: bytes = contacts[there].tobytes()
        return kept

    def _objects(self) -> bytes:
        """What Python knows of the objects, encoded."""
        engine, tables = self._engine, self._engine.tables
        bodies, geoms, joints = map(list, (engine.bodies.values(), engine.geoms.values(), engine.joints.values()))
        dummies = list(engine.dummies)
        codes: dict[Any, int | None] = {None: None, **codes_of(bodies, dummies)}
        place = {space: i for i, space in enumerate((engine.top, *engine.spaces))}
        number = {joint: i for i, joint in enumerate(joints)}
        plain = {
            "rows": [table.census() for table in (tables.bodies, tables.joints, tables.geoms)],
            "bodies": [[body.label, saved_values(body)] for body in bodies],
            "dummies": [[body.label, saved_values(body)] for body in dummies],
            "geoms": [
                [type(geom).__name__, codes[geom.body], saved_values(geom), geom.appearance.saved()] for geom in geoms
            ],
            "joints": [
                [type(joint).__name__, [codes.get(body) for body in joint.bodies], saved_values(joint)]
                for joint in joints
            ],
            "feedback": [joint._feedback is not None for joint in joints],
            "attached": [number[joint] for joint in engine.attached],
            "spaces": [place[space.parent] for space in engine.spaces],
            "inside": [None if geom.space is None else place[geom.space] for geom in geoms],
        }
        return encoding.encode(plain, exact=False)

    # Set ---------------------------------------------------------------------------------------------------------

    def set(self, state: dict[str, Any]) -> None:
        """Set a state; see `Engine.set_state`."""
        if state.get("ode") != layout().digest:
            raise StateError("this state was made with another build of ODE")
        try:
            self._set(state)
        except (StateError, LibraryError):
            raise
        except (
            GazeboError,
            ArithmeticError,
            AttributeError,
            LookupError,
            TypeError,
            ValueError,
            struct.error,
        ) as error:
            raise StateError(f"the state is damaged: {error}") from error

    def _set(self, state: dict[str, Any]) -> None:
        engine = self._engine
        if state["objects"] != self._objects():
            saved = encoding.decode(state["objects"])
            _check_objects(saved)
            self._restore_objects(saved)
        if state["dummies"] != self._dummy_poses():
            self._restore_dummies(state["dummies"])
        numbers, memory = list(state["numbers"]), bytes(state["memory"])
        if len(numbers) != _NUMBERS or len(state["settings"]) != _FIELDS.size:
            raise StateError("the state is damaged: it has not all numbers of an engine")
        blocks = self._blocks(numbers[0])
        parts, distance = self._parts(blocks), numbers[_DISTANCE]
        if distance not in (2.0 * FAR, 2.0 * LARGEST):
            raise StateError(f"the state is damaged: bodies may be {distance} m from the origin")
        checked = (state["objects"], parts.handles, blocks, memory, distance)
        if checked != self._sound:
            check_memory(parts, blocks, memory, engine.native.get_state(parts), distance)
            self._sound = checked
        self._restore_settings(state, numbers)
        if not engine.native.set_state(parts, memory):
            raise StateError("geoms are in other spaces, or on other bodies, than in this state")
        self._restore_tables(state)
        self._restore_parts(state)
        engine.tables.disturb()

    def _restore_dummies(self, poses: bytes) -> None:
        """Place dummies before ODE's memory is copied: from their poses follows which geoms ODE has."""
        for dummy, place in zip(self._engine.dummies, _POSE.iter_unpack(poses), strict=True):
            if not all(abs(number) <= LARGEST for number in place):
                raise StateError("the state is damaged: the pose of a body is out of range")
            if place != tuple(dummy._frame):
                dummy._frame = [*place]
                for geom in dummy.geoms:
                    geom.follow_dummy()

    def _restore_settings(self, state: dict[str, Any], numbers: list[Any]) -> None:
        engine, context = self._engine, self._context
        quirks = state["quirks"]
        if not all(isinstance(quirk, str) for quirk in quirks):
            raise StateError("the state is damaged: quirks have no names")
        if engine.quirks != frozenset(quirks):  # else laws that have taken them stay valid
            engine.quirks = frozenset(quirks)
        settings, present = state["settings"], self._settings
        if settings[:_PROGRESS] != present[:_PROGRESS] or settings[_REST:] != present[_REST:]:
            then, now = _fields(settings), _fields(present)
            for name in SETTINGS:
                if then[name] != now[name]:
                    setattr(engine, name, then[name])
            context.solver = then["solver"]
        present[_PROGRESS:_REST] = settings[_PROGRESS:_REST]  # random state, how many steps and contacts there were
        if numbers != (others := list(_numbers(engine))):
            for name, value, other in zip(SWITCHES, numbers, others, strict=False):
                if value != other:
                    setattr(engine, name, value)
            rest = iter(numbers[len(SWITCHES) :])
            engine.set_quick_step(*islice(rest, len(SOLVER)))
            engine.set_constraints(*islice(rest, len(CONSTRAINTS)))
            if (distance := next(rest)) != context.max_distance:
                engine.set_range(distance)
            engine.collisions, abandoned = map(int, rest)
            engine.abandoned = bool(abandoned)

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
            couplings = [(present[place], values) for place, values in state["couplings"]]
            for coupling, values in couplings:
                for name, value, present in zip(saved_names(coupling), values, saved_values(coupling), strict=True):
                    if not (_fits(name, value, present) and _is_bounded(value)):
                        raise StateError("the state is damaged: a screw or gear has numbers that none has")
                    setattr(coupling, name, value)
            engine.couplings = [coupling for coupling, _ in couplings]
        engine.moved_dummies.update(engine.dummies)
        engine.tables.record.changes += 1
        if engine.record_contacts:
            contacts = np.frombuffer(state["contacts"], CONTACT)
            known = {0, *engine.geoms}
            if not known.issuperset([*contacts["geom1"].tolist(), *contacts["geom2"].tolist()]):
                raise StateError("the state is damaged: a contact is one of a geom that is not there")
            engine.native.set_contacts(contacts.tobytes())

    # Objects -----------------------------------------------------------------------------------------------------

    def _restore_objects(self, saved: dict[str, Any]) -> None:
        engine, tables = self._engine, self._engine.tables
        matched = match(self._engine, saved)
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
            if [*map(list, table.census())] != census or list(table.objects.values()) != things:
                table.arrange(things, *census)
        tables.publish()
        tables.bodies.ids[:] = tables.joints.ids[:] = 0
        for body in bodies:
            tables.bodies.ids[body.row] = body._id
        for geom in geoms:  # before numbers are set, which may be refused: the rows are others now
            if geom._id is not None:
                ode().dGeomSetData(geom._id, geom.row)
            tables.geoms.owner[geom.row] = geom.body.number
        for body, (_, values) in zip((*bodies, *dummies), (*saved["bodies"], *saved["dummies"]), strict=True):
            _assign(body, values)
        engine.auto_disabled.clear()
        engine.auto_disabled.update(body for body in bodies if body.auto_disable)
        for geom, (_, _, values, look) in zip(geoms, saved["geoms"], strict=True):
            self._restore_geom(geom, values, look)
        self._restore_joints(saved, joints, [*bodies, *dummies], len(bodies))

    def _restore_geom(self, geom: Any, values: list[Any], look: list[Any]) -> None:
        changed = _assign(geom, values)
        if look != geom.appearance.saved():
            geom.appearance.restore(*look)
            changed = True
        geom.appearance.version += changed
        geom.mark()
        if changed and geom.body.dummy:
            geom.follow_dummy()

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


# Tables -------------------------------------------------------------------------------------------------------------


def _runs(table: Any) -> list[tuple[int, int]]:
    """The rows in use, in order of construction: (first, count) of those that follow each other."""
    runs: list[tuple[int, int]] = []
    for row in table.objects:
        if runs and row == sum(runs[-1]):
            runs[-1] = (runs[-1][0], runs[-1][1] + 1)
        else:
            runs.append((row, 1))
    return runs


def _refresh(table: Any) -> None:
    """Read stale rows from ODE."""
    fresh = table.fresh
    if fresh.find(0, 0, table.used) >= 0:
        for row in table.objects:
            if not fresh[row]:
                table.read(row)


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
            and all(isinstance(row[-1][0], (str, type(None))) for row in (*bodies, *dummies, *joints))
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


def _fields(settings: Any) -> dict[str, Any]:
    """What is to be set, by the names of SETTINGS, and `solver`."""
    step, solver, rule, *values = _FIELDS.unpack(settings)
    if solver not in range(len(SOLVERS)) or rule not in list(ContactRule):
        raise StateError("the state is damaged: the engine has no such solver or rule of contacts")
    turns, _, _, _, most, cone, x, y, z, record = values
    return {
        **{"step_time": step, "solver": solver, "contact_rule": rule, "count_turns": turns},
        **{"max_contacts": most, "cone": cone, "gravity": (x, y, z), "record_contacts": record},
    }


def _assign(thing: Any, values: list[Any]) -> bool:
    """Set what an object saves; returns whether something was different."""
    changed = False
    for name, value, present in zip(saved_names(thing), map(_tuples, values), saved_values(thing), strict=True):
        if encoding.encode(value) != encoding.encode(present):
            if not _fits(name, value, present):
                raise StateError(f"the state is damaged: {name} of a {type(thing).__name__} is out of its range")
            setattr(thing, name, value)
            changed = True
    return changed


def _lists(values: Iterable[Any]) -> list[Any]:
    return [list(value) if isinstance(value, (tuple, list)) else value for value in values]


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _made_mass(data: bytes) -> Mass:
    if len(data) != ctypes.sizeof(Mass):
        raise StateError("the state is damaged: a mass has other numbers")
    mass = Mass.from_buffer_copy(data)
    if not all(map(_is_finite, (mass.mass, *mass.c, *mass.I))):
        raise StateError("the state is damaged: a mass is not finite")
    return mass


encoding.register_raw(Mass, bytes, _made_mass)
encoding.register(Mesh, lambda mesh: [mesh.vertices, mesh.triangles], Mesh)


# SAVED attributes that may be None, and what they are else.
_OPTIONAL: dict[str, type] = {
    **{"bodyName": str, "name": str, "_given_mass": Mass, "_mass": Mass, "volume_mass": Mass, "changed_mesh": Mesh},
    "_speed": float,
}


def _fits(name: str, value: Any, present: Any) -> bool:
    """Whether a value of an attribute may stand where another one is: of the same kind, with as many numbers."""
    if value is None or present is None:
        kinds = (_OPTIONAL.get(name, type(None)), type(None))
        return isinstance(value, kinds) and isinstance(present, kinds) and value == value  # not NaN
    if isinstance(value, (tuple, list)):
        return (
            isinstance(present, (tuple, list))
            and len(value) == len(present)
            and all(_fits("", item, former) for item, former in zip(value, present, strict=True))
        )
    if isinstance(value, (int, float)):
        return not math.isnan(value) and isinstance(present, (int, float))
    if isinstance(value, GzPose):
        return isinstance(present, GzPose) and all(_is_finite(number) for number in _place_of(value))
    for kind in (GzVector, GzQuatern, GzColor):  # a layer above has vectors of its own
        if isinstance(value, kind):
            return isinstance(present, kind) and all(_is_finite(number) for number in value)
    return isinstance(value, (str, Mass, Mesh)) and type(present) is type(value)


def _is_finite(number: Any) -> bool:
    return isinstance(number, (int, float)) and abs(number) <= FINITE


def _is_bounded(value: Any) -> bool:
    """Whether all numbers of a screw or gear are finite."""
    if value is None or isinstance(value, (int, float)):
        return value is None or _is_finite(value)
    return all(map(_is_bounded, value))


_place_of = attrgetter("pos.x", "pos.y", "pos.z", "rot.u", "rot.x", "rot.y", "rot.z")
