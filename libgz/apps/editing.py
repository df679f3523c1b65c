"""Shared by gazebo and gzserver: the requests that edit a world, with undo and redo, and those that hold a model."""

from __future__ import annotations

import dataclasses
import logging
import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from libgz.base.errors import GazeboError, ParameterError, StateError
from libgz.base.geometry import GzCoordPoseSub, GzPose, GzQuatern, GzVector
from libgz.front import World
from libgz.simulation.editor import Editor, History, Moment, numbers_of, return_to
from libgz.simulation.entity import Entity

if TYPE_CHECKING:
    from libgz.physics.body import Body

__all__ = ["Editing", "in_parent", "pose_of"]

log = logging.getLogger("libgz.gazebo")

HOLD = 6.0  # [s] of real time after its last request, that something is held: a page may be slow
TOGETHER = 1.0  # [s] of real time between two moves of one model that are undone as one
MOST_HELD = 16
LONGEST_DIFF = 1 << 20  # characters
SPACE = 0.1  # [m] between a model and its copy


@dataclasses.dataclass
class _Held:
    """An entity that is held where it is."""

    entity: Entity
    pose: GzPose
    until: float  # [s] of time.monotonic


class Editing:
    """Edits a world between two steps, and keeps the moments before each change.

    Args:
        world: it is initialized.
        replaced: is called around a state that is set.
        insert: inserts what a request asks for; the names of what came.
    """

    def __init__(
        self, world: World, replaced: Callable[[], Any], insert: Callable[[dict[str, Any]], list[str]]
    ) -> None:
        self._world, self._replaced, self._insert = world, replaced, insert
        self._history = History()
        self._last_move = ("", 0.0)
        self._held: dict[str, _Held] = {}
        self.verbs: dict[str, Callable[[str, dict[str, Any]], Any]] = {
            "attributes": self._attributes,
            "edit": self._edit,
            "embed": self._embed,
            "undo": lambda _argument, _content: self._travel(self._history.undo),
            "redo": lambda _argument, _content: self._travel(self._history.redo),
            "history": self._list,
            "duplicate": self._duplicate,
            "align": self._align,
            "diff": self._diff,
            "hold": self._hold,
        }

    # Changes ---------------------------------------------------------------------------------------------------------

    def change(self, label: str, action: Callable[[], Any], *, begins: bool = True) -> Any:
        """Do something that can be undone; if it fails, the world is as before.

        Args:
            label: what it is, for a user.
            action: does it.
            begins: whether a reset returns to what it makes, if no step was made yet.

        Raises:
            GazeboError: that failed.
        """
        before = self._before(label)
        try:
            answer = action()
        except BaseException:
            if before is not None:
                with self._replaced():
                    return_to(self._world, before)
            raise
        self._remember(before)
        self._last_move = ("", 0.0)
        if begins:
            self._settle()
        return answer

    def _before(self, label: str) -> Moment | None:
        """The present moment; None if the world's state cannot be saved, such as that of a user's model."""
        try:
            return Moment.of(self._world, label)
        except GazeboError as error:
            log.debug("%s cannot be undone: %s", label, error)
            return None

    def _remember(self, before: Moment | None) -> None:
        """Add the moment before a change; without one, nothing before it can be undone any more."""
        if before is None:
            self._history.clear()
        else:
            self._history.add(before)

    def move(self, name: str, action: Callable[[], Any]) -> Any:
        """The same for a move, many of which may be one drag of a hand."""
        last, now = self._last_move, time.monotonic()
        if name in self._held or (last[0] == name and now - last[1] < TOGETHER):
            answer = action()
            self._settle()
        else:
            answer = self.change(f"move {name}", action)
        self._last_move = (name, now)
        return answer

    def _settle(self) -> None:
        """What is changed before the first step belongs to what a reset returns to."""
        if not self._world.iterations:
            self._world.begin_here()

    def _travel(self, there: Callable[[World], str | None]) -> dict[str, Any] | None:
        paused = self._world.paused
        with self._replaced():
            label = there(self._world)
        self._world.paused = paused
        self._last_move = ("", 0.0)
        if label is None:
            return None
        self._settle()
        return {"text": label, "undo": len(self._history.done), "redo": len(self._history.undone)}

    def _list(self, _argument: str, _content: dict[str, Any]) -> dict[str, list[str]]:
        return {
            "undo": [moment.label for moment in self._history.done],
            "redo": [moment.label for moment in reversed(self._history.undone)],
        }

    # Values ----------------------------------------------------------------------------------------------------------

    def _editor(self) -> Editor:
        if self._world.sdf is not None:
            from libgz.sdfworld.editor import SdfEditor

            return self._world.extension(SdfEditor)
        from libgz.legacy.editor import LegacyEditor

        return self._world.extension(LegacyEditor)

    def _entity(self, content: dict[str, Any]) -> Entity | None:
        name = str(content.get("name", ""))
        found: Entity | None = self._world.model(name) if name else None
        return found

    def _attributes(self, _argument: str, content: dict[str, Any]) -> list[dict[str, Any]]:
        """The values of an entity or of a part of it that can be edited, or those of the world."""
        part, kind = str(content.get("part") or ""), str(content.get("kind") or "")
        values = self._editor().values(self._entity(content), part, kind)
        return [_plain(value) for value in values]

    def _edit(self, _argument: str, content: dict[str, Any]) -> dict[str, Any]:
        """Change one value."""
        entity, key = self._entity(content), str(content.get("key", ""))
        part, kind = str(content.get("part") or ""), str(content.get("kind") or "")
        owner = entity.GetId() if entity is not None else "the world"
        editor = self._editor()
        if "value" not in content:
            raise ParameterError("the value is missing")

        def act() -> Entity | None:
            found = editor.edit(entity, part, kind, key, content["value"])
            self.finish()
            return found

        now = self.change(f"{key.rpartition('/')[2]} of {owner}", act)
        kept = str(content["value"]) if part and key == "@name" else part
        values = editor.values(now, kept, kind)
        value = next((one.value for one in values if one.key == key), content["value"])
        return {"value": value, "name": now.GetId() if now is not None else ""}

    def _embed(self, _argument: str, content: dict[str, Any]) -> dict[str, str]:
        """Write an included model into the world's file; its name."""
        entity, editor = self._required(content), self._editor()

        def act() -> Entity:
            found = editor.embed(entity)
            self.finish()
            return found

        now: Entity = self.change(f"copy {entity.GetId()} into the world", act)
        return {"name": now.GetId()}

    def finish(self) -> None:
        """Make the sensors of new models and load their plugins, if the world has what does that."""
        if self._world.companions and self._world.sdf is not None:
            from libgz.classic.server import attach

            attach(self._world).finish_added()

    def _duplicate(self, _argument: str, content: dict[str, Any]) -> list[str]:
        """Insert a copy of an entity beside it; the names of what came."""
        entity = self._required(content)
        while entity.parent is not None and self._world.sdf is not None:
            entity = entity.parent
        text = self._editor().copy_text(entity)

        def act() -> list[str]:
            low, high = _bounds(entity)
            width = max(high.y - low.y, 0.0) + SPACE
            names = self._insert({"text": text})
            copy = self._world.model(names[0])
            pose = entity.GetPose()
            self._world.SetModelPose(copy, GzPose(GzVector(pose.pos.x, pose.pos.y + width, pose.pos.z), pose.rot))
            copy.initPose = copy.GetPose()
            return names

        names: list[str] = self.change(f"duplicate {entity.GetId()}", act)
        return names

    def _required(self, content: dict[str, Any]) -> Entity:
        found: Entity = self._world.model(str(content.get("name", "")))
        return found

    def _align(self, argument: str, content: dict[str, Any]) -> None:
        """Move entities so that their boxes are aligned with that of the first one: `x`, `y` or `z`, and where."""
        names, where = content.get("names"), content.get("to", "center")
        if argument not in ("x", "y", "z") or where not in ("low", "center", "high"):
            raise ParameterError(f"align is {argument!r} to {where!r}; allowed are x, y and z, to low, center and high")
        different = dict.fromkeys(str(name) for name in names) if isinstance(names, list) else {}
        if len(different) < 2:
            raise ParameterError("align needs the names of two or more models")
        entities = [self._world.model(name) for name in different]

        def at(entity: Entity) -> float:
            low, high = (getattr(corner, argument) for corner in _bounds(entity))
            return float({"low": low, "high": high, "center": 0.5 * (low + high)}[where])

        def act() -> None:
            for entity in entities[1:]:
                pose = entity.GetPose()
                setattr(pose.pos, argument, getattr(pose.pos, argument) + at(entities[0]) - at(entity))
                self._world.SetModelPose(entity, in_parent(entity, pose))

        self.change(f"align {len(entities)} models", act)

    def _diff(self, _argument: str, _content: dict[str, Any]) -> dict[str, str]:
        """What `write` would change in the world's file."""
        import difflib  # for a user who looks

        name, before, after = self._world.era.saved_text(self._world)
        label = name or self._world.name
        old, new = (text.decode("utf-8", "replace").splitlines(keepends=True) for text in (before, after))
        lines = difflib.unified_diff(old, new, label, label)
        text = "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)
        return {"file": label, "text": text[:LONGEST_DIFF]}

    # Holding ---------------------------------------------------------------------------------------------------------

    @property
    def holds(self) -> bool:
        """Whether something is held."""
        return bool(self._held)

    def _hold(self, argument: str, content: dict[str, Any]) -> None:
        """Hold an entity at a pose, or where it is, for a short time; or release it."""
        if argument not in ("on", "off"):
            raise ParameterError(f"hold is {argument!r}; allowed are on and off")
        if argument == "off":
            self._held.pop(str(content.get("name", "")), None)
            return
        entity = self._required(content)
        name, until = entity.GetId(), time.monotonic() + HOLD
        pose = pose_of(content) if "pose" in content else None
        if name not in self._held:
            if len(self._held) >= MOST_HELD:
                raise StateError(f"{MOST_HELD} models are held already; release one first")
            self._remember(self._before(f"move {name}"))
            self._held[name] = _Held(entity, entity.GetPose(), until)
        held = self._held[name]
        held.entity, held.until = entity, until
        if pose is not None:
            held.pose = pose
            self._keep(held)
            self._settle()

    def release_all(self) -> None:
        """Hold nothing any more."""
        self._held.clear()

    def act(self) -> None:
        """Keep what is held where it is; called after each step."""
        now, world = time.monotonic(), self._world
        for name, held in list(self._held.items()):
            if now > held.until or held.entity not in world.entities:
                del self._held[name]
            elif not world.paused:
                self._keep(held)

    def _keep(self, held: _Held) -> None:
        world = self._world
        world.SetModelPose(held.entity, in_parent(held.entity, held.pose))
        if world.paused:
            return
        gravity = world.engine.gravity
        for body in (body for one in held.entity.with_attached() for body in one.bodies):
            _bear(body, gravity)


def _bear(body: Body, gravity: Any) -> None:
    """Apply the force that keeps a body from falling in the next step."""
    if not body.dummy and body.GetGravityMode():
        body.AddForce(*(-body.mass * part for part in gravity))


def in_parent(entity: Entity, pose: GzPose) -> GzPose:
    """A global pose, as `World.SetModelPose` takes it for an entity [m]."""
    parent = entity.parentBody
    return GzCoordPoseSub(pose, parent.GetPose()) if parent is not None else pose


def pose_of(content: dict[str, Any]) -> GzPose:
    """The pose of a request.

    Raises:
        ParameterError: it has none.
    """
    try:
        numbers = numbers_of(content.get("pose"), 7, 7)
    except ParameterError:
        numbers = []
    length = math.hypot(*numbers[3:])
    if not 0.0 < length < math.inf:
        raise ParameterError("a pose is seven finite numbers: x, y, z [m] and a quaternion u, x, y, z")
    return GzPose(GzVector(*numbers[:3]), GzQuatern(*(part / length for part in numbers[3:])))


def _plain(value: Any) -> dict[str, Any]:
    """A value as JSON can have it, without what is empty."""
    fields = dataclasses.asdict(value)
    kept = {key: item for key, item in fields.items() if key in ("key", "value") or item not in (None, "", [], 0)}
    kept.setdefault("label", value.key)
    kept |= {"group": value.group, "type": value.type}
    for limit in ("low", "high", "above"):
        if fields[limit] is not None:
            kept[limit] = fields[limit]
    if isinstance(kept["value"], float) and not math.isfinite(kept["value"]):
        kept["value"] = str(kept["value"])
    if isinstance(kept["value"], list):
        kept["value"] = [v if math.isfinite(v) else str(v) for v in kept["value"]]
    return kept


def _bounds(entity: Entity) -> tuple[GzVector, GzVector]:
    """The box around an entity and all that is attached to it [m]; its own place, if nothing has a size."""
    boxes = [geom.bounds() for one in entity.with_attached() for body in one.bodies for geom in body.geoms]
    finite = [(a, b) for a, b in boxes if all(map(math.isfinite, (*a, *b))) and tuple(a) != tuple(b)]
    if not finite:
        place = entity.GetPose().pos
        return GzVector(*place), GzVector(*place)
    lows, highs = zip(*finite, strict=True)
    return GzVector(*map(min, zip(*lows, strict=True))), GzVector(*map(max, zip(*highs, strict=True)))
