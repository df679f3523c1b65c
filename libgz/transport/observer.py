"""Observer: reads the states and the scene of a world that runs in another process, and leaves it undisturbed."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.closing import Closing
from libgz.base.errors import ClosedError, InterfaceError, NotFoundError, ServerGoneError, nearest
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuatern, GzVector
from libgz.transport.paths import (
    SCENE_FILE,
    TABLES_FILE,
    check_owner,
    check_server_id,
    is_data_file,
    server_directory,
)
from libgz.transport.server import alive
from libgz.transport.tables import BODY_COLUMNS, FORMAT, HEADER, JOINT_COLUMNS, MAGIC, Status, start_time

__all__ = [
    "ObservedBody",
    "ObservedEntity",
    "ObservedJoint",
    "ObservedShape",
    "ObservedState",
    "Observer",
    "arrays_of",
    "state_of",
]

T = TypeVar("T")

_POLL, _LONGEST_POLL = 0.0002, 0.002  # [s]
_PATIENCE = 2.0  # [s] for a server that is about to finish what it writes
_CHECK_PERIOD = 0.1  # [s] between two looks at whether the server is alive
_SPINS = 100  # attempts to read before a look at whether the server is alive
_SEQUENCE = HEADER.fields["sequence"][1]  # type: ignore[index]


@dataclass(frozen=True)
class ObservedState:
    """The states of one moment.

    Attributes:
        number: of this publication; it grows by one with each step, paused ones included.
        revision: of the scene that belongs to it.
        steps: done, pauses excluded.
        paused: whether the step was a paused one.
        sim_time, pause_time, real_time: [s].
        bodies: shape (rows, 16): position [m] and quaternion (u, x, y, z) of the body frame, position of the centre of
            mass [m], linear [m/s] and angular velocity [rad/s]; global. `ObservedBody.row` says whose a row is; rows
            that no body has are of no meaning.
        joints: shape (rows, 4): angle or position 1 and 2 [rad or m], rate 1 and 2 [rad/s or m/s].
    """

    number: int
    revision: int
    steps: int
    paused: bool
    sim_time: float
    pause_time: float
    real_time: float
    bodies: NDArray[np.float64]
    joints: NDArray[np.float64]


@dataclass(frozen=True)
class ObservedShape:
    """A shape of a body, or a light.

    Attributes:
        id: never used again while the server runs.
        name: that of the file; empty where it has none.
        kind: box, sphere, cylinder, capsule, wheel, plane, mesh, heightfield, light, frustum, ray, dome, other.
        body: number of its body.
        pose: of its centre in the body frame.
        collides, visible: whether something can touch it, and whether it is rendered.
        data: all that the scene says of it: sizes, material, texture, skin; see docs/observer.md.
    """

    id: int
    name: str
    kind: str
    body: int
    pose: GzPose
    collides: bool
    visible: bool
    data: dict[str, Any]


@dataclass(frozen=True)
class ObservedBody:
    """A body.

    Attributes:
        id: never used again while the server runs.
        name: in its entity.
        entity: id of its entity; empty for none.
        row: in `ObservedState.bodies`.
        static: whether it never moves by itself.
        shapes: of it.
    """

    id: int
    name: str
    entity: str
    row: int
    static: bool
    shapes: tuple[ObservedShape, ...]


@dataclass(frozen=True)
class ObservedJoint:
    """A joint.

    Attributes:
        name, kind: by the names of the file's format.
        entity: id of its entity.
        row: in `ObservedState.joints`; -1 for one that has none.
        bodies: numbers of the two bodies; 0 for the world.
        frame: number of the body in whose frame anchor and axes are; 0 for the world.
        anchor: [m].
        axes: unit vectors.
    """

    name: str
    kind: str
    entity: str
    row: int
    bodies: tuple[int, int]
    frame: int
    anchor: GzVector
    axes: tuple[GzVector, ...]


@dataclass(frozen=True)
class ObservedEntity:
    """A model, a light, or the joints beside models.

    Attributes:
        number: of it in interface heads.
        id: its name.
        kind: model, light, joints.
        type: the class of a legacy model, such as ``Pioneer2AT``.
        parent: number of the entity that it is attached to; 0 for none.
        body: number of the body that its frame is fixed to; 0 for none, then `pose` is global.
        pose: of its frame in that body.
        data: all that the scene says of it: sensors and interfaces, too; see docs/observer.md.
    """

    number: int
    id: str
    kind: str
    type: str
    parent: int
    body: int
    pose: GzPose
    data: dict[str, Any]


class _Scene:
    """A scene, as it was read."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.data = data
        self.revision = int(data["revision"])
        self.entities = [_entity(one) for one in data["entities"]]
        self.bodies = [_body(one, entity["id"]) for entity in data["entities"] for one in entity["bodies"]]
        self.bodies += [_body(one, "") for one in data["others"]]
        self.joints = [_joint(one, entity["id"]) for entity in data["entities"] for one in entity["joints"]]
        self.by_number = {body.id: body for body in self.bodies}


def _pose(values: Iterable[float]) -> GzPose:
    x, y, z, *rotation = values
    return GzPose(GzVector(x, y, z), GzQuatern(*rotation))


def _entity(data: dict[str, Any]) -> ObservedEntity:
    return ObservedEntity(
        data["number"],
        data["id"],
        data["kind"],
        data["type"],
        data["parent"],
        data["body"],
        _pose(data["pose"]),
        data,
    )


def _body(data: dict[str, Any], entity: str) -> ObservedBody:
    shapes = tuple(
        ObservedShape(
            one["id"],
            one["name"],
            one["kind"],
            data["id"],
            _pose(one["pose"]),
            one["collides"],
            one["visible"],
            one,
        )
        for one in data["shapes"]
    )
    return ObservedBody(data["id"], data["name"], entity, data["row"], data["static"], shapes)


def _joint(data: dict[str, Any], entity: str) -> ObservedJoint:
    one, two = data["bodies"]
    axes = tuple(GzVector(*axis) for axis in data["axes"])
    anchor = GzVector(*data["anchor"])
    return ObservedJoint(data["name"], data["kind"], entity, data["row"], (one, two), data["frame"], anchor, axes)


def state_of(memory: bytes) -> ObservedState:
    """The states in a copy of header and tables."""
    return _state(np.frombuffer(memory, dtype=HEADER, count=1)[0], np.frombuffer(memory, offset=HEADER.itemsize))


def _state(head: Any, values: NDArray[np.float64]) -> ObservedState:
    bodies, joints = int(head["bodies"]) * BODY_COLUMNS, int(head["joints"]) * JOINT_COLUMNS
    return ObservedState(
        number=int(head["sequence"]) // 2,
        revision=int(head["revision"]),
        steps=int(head["steps"]),
        paused=bool(head["paused"]),
        sim_time=float(head["sim_time"]),
        pause_time=float(head["pause_time"]),
        real_time=float(head["real_time"]),
        bodies=values[:bodies].reshape(-1, BODY_COLUMNS),
        joints=values[bodies : bodies + joints].reshape(-1, JOINT_COLUMNS),
    )


def arrays_of(content: bytes, reference: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """The arrays in the data that a scene refers to."""
    found = {}
    for name, part in reference["arrays"].items():
        count = int(np.prod(part["shape"]))
        found[name] = np.frombuffer(content, part["type"], count, part["offset"]).reshape(part["shape"])
    return found


class Observer(Closing):
    """A view on a world that a server runs, in any process of this user; it neither locks nor slows the server.

    Args:
        server_id: of the server.
        timeout: how long to wait for the server to start [s].

    Raises:
        ParameterError: the server id is invalid, or the path of its directory is too long.
        ServerGoneError: no server runs under this id.
        InterfaceError: its files cannot be read, or are of another version of the format.
    """

    def __init__(self, server_id: int = 0, timeout: float = 0.0) -> None:
        self.server_id = check_server_id(server_id)
        self.path = server_directory(self.server_id)
        self._descriptor: int | None = None
        self._pid = self._start = self._size = 0
        self._next_check = 0.0
        self._scene: _Scene | None = None
        self.reconnect(timeout)

    def __repr__(self) -> str:
        head = self._read_head() if self._descriptor is not None else None
        state = "closed" if self._descriptor is None else "ended" if not self.alive else "running"
        now = "" if head is None else f", sim time {head['sim_time']:.3f} s"
        return f"<{type(self).__name__} of server {self.server_id}, {state}{now}>"

    def close(self) -> None:
        """End the observation. Can be called twice."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    # Connection ----------------------------------------------------------------------------------------------------

    def reconnect(self, timeout: float = 0.0) -> None:
        """Observe the server that runs under this id now, such as one that was started again.

        Args:
            timeout: how long to wait for it [s].

        Raises:
            ServerGoneError: no server runs under this id.
            InterfaceError: its files cannot be read, or are of another version of the format.
        """
        end = time.monotonic() + timeout
        while True:
            self.close()
            self._scene = None
            try:
                self._open()
                if self.alive:
                    return
            except FileNotFoundError:
                pass
            except OSError as error:
                raise InterfaceError(f"{self.path}/{TABLES_FILE} cannot be read: {error.strerror}") from None
            if time.monotonic() >= end:
                self.close()
                raise ServerGoneError(f"server {self.server_id} is not running: there is no live server in {self.path}")
            time.sleep(_LONGEST_POLL)

    def _open(self) -> None:
        """Open the file of tables, once it is complete.

        Raises:
            OSError: it cannot be opened.
            InterfaceError: it is of another version of the format.
        """
        self.close()
        check_owner(self.path)
        self._descriptor = os.open(f"{self.path}/{TABLES_FILE}", os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
        head = self._read_head()
        if head is None:
            raise FileNotFoundError(TABLES_FILE)
        if head["format"] != FORMAT:
            raise InterfaceError(
                f"server {self.server_id} writes format {head['format']} of its tables, and this libgz reads {FORMAT}; "
                "install the same libgz for both"
            )
        self._pid, self._start, self._size = int(head["pid"]), int(head["start"]), int(head["size"])

    def _read_head(self) -> Any:
        """The header; None if it is not complete, as while a truncated file is being restored."""
        if self._descriptor is None:
            raise ClosedError(f"the observer of server {self.server_id} is closed")
        raw = os.pread(self._descriptor, HEADER.itemsize, 0)
        if len(raw) < HEADER.itemsize or not raw.startswith(MAGIC):
            return None
        return np.frombuffer(raw, dtype=HEADER)[0]

    @property
    def pid(self) -> int:
        """The process of the server."""
        return self._pid

    @property
    def alive(self) -> bool:
        """Whether the observed server still runs; one that was started again is another one: see `reconnect`."""
        try:
            head = self._read_head()
        except ClosedError:
            return False
        if head is not None and head["status"] == Status.ENDED:
            return False
        if os.fstat(self._descriptor or 0).st_nlink == 0 and (head is None or head["status"] != Status.REPLACED):
            return False
        if self._start and start_time(self._pid) not in (0, self._start):
            return False
        return alive(self._pid)

    def _gone(self) -> ServerGoneError:
        return ServerGoneError(f"server {self.server_id} (pid {self._pid}) has ended; reconnect waits for another one")

    def _check_alive(self, end: float, what: str) -> None:
        if not self.alive:
            raise self._gone()
        self._next_check = time.monotonic() + _CHECK_PERIOD
        if time.monotonic() >= end:
            raise InterfaceError(f"{what} of server {self.server_id} could not be read for {_PATIENCE:g} s")

    # States --------------------------------------------------------------------------------------------------------

    def state(self) -> ObservedState:
        """The states after the last step, consistent: all of the same moment.

        Raises:
            ServerGoneError: the server ended; of one that was killed, it is noticed 0.1 s later at most.
            InterfaceError: the file is damaged, and the server does not repair it, for it does not step.
            ClosedError: the observer was closed.
        """
        attempts, end = 0, time.monotonic() + _PATIENCE
        while True:
            head = self._read_head()
            if head is not None and head["status"] == Status.REPLACED:
                self._follow(end)
                continue
            if head is not None and head["status"] == Status.RUNNING and not head["sequence"] & 1 and head["sequence"]:
                found = self._read_tables(head)
                if found is not None:
                    if time.monotonic() >= self._next_check:
                        self._check_alive(end, "the tables")
                    return found
            attempts += 1
            if attempts % _SPINS == 0 or head is None or head["status"] != Status.RUNNING:
                self._check_alive(end, "the tables")
                time.sleep(_POLL)

    def _follow(self, end: float) -> None:
        """Open the file that replaced this one."""
        try:
            self._open()
        except FileNotFoundError:
            if not alive(self._pid) or time.monotonic() >= end:
                raise self._gone() from None
            time.sleep(_POLL)

    def _read_tables(self, head: Any) -> ObservedState | None:
        """The tables that belong to a header; None if the server wrote meanwhile."""
        descriptor, size = self._descriptor or 0, int(head["size"])
        raw = os.pread(descriptor, size - HEADER.itemsize, HEADER.itemsize)
        sequence = os.pread(descriptor, 8, _SEQUENCE)
        if len(raw) < size - HEADER.itemsize or sequence != head["sequence"].tobytes():
            return None
        return _state(head, np.frombuffer(raw))

    def wait(self, newer_than: ObservedState | None = None, timeout: float | None = None) -> ObservedState:
        """The first state that is newer than another one, as soon as there is one.

        Args:
            newer_than: a state of this observer; None: the present one.
            timeout: [s]; None waits without a limit.

        Raises:
            ServerGoneError: the server ended.
            InterfaceError: there was no newer state before the timeout.
            ClosedError: the observer was closed.
        """
        end = None if timeout is None else time.monotonic() + timeout
        last, pause, checked = self.state() if newer_than is None else newer_than, _POLL, time.monotonic()
        while True:
            head = self._read_head()
            if head is None or head["status"] != Status.RUNNING or int(head["sequence"]) // 2 > last.number:
                found = self.state()
                if found.number > last.number:
                    return found
            now = time.monotonic()
            if end is not None and now >= end:
                raise InterfaceError(f"server {self.server_id} made no step within {timeout:g} s")
            if now - checked > _CHECK_PERIOD:
                checked = now
                if not self.alive:
                    raise self._gone()
            time.sleep(pause)
            pause = min(2.0 * pause, _LONGEST_POLL)

    # Scene ---------------------------------------------------------------------------------------------------------

    @property
    def revision(self) -> int:
        """The number of the present scene; it grows with each change of what there is, or how it looks."""
        return self._present().revision

    @property
    def scene(self) -> dict[str, Any]:
        """The present scene as plain data; see docs/observer.md."""
        return self._present().data

    @property
    def entities(self) -> list[ObservedEntity]:
        """Models, lights and joints beside models, in order of the file."""
        return list(self._present().entities)

    @property
    def bodies(self) -> list[ObservedBody]:
        """All bodies."""
        return list(self._present().bodies)

    @property
    def shapes(self) -> list[ObservedShape]:
        """All shapes and lights of all bodies."""
        return [shape for body in self._present().bodies for shape in body.shapes]

    @property
    def joints(self) -> list[ObservedJoint]:
        """All joints."""
        return list(self._present().joints)

    def _present(self) -> _Scene:
        """The scene that belongs to the present states."""
        return self._scene_of(self.state())[0]

    def _scene_of(self, state: ObservedState) -> tuple[_Scene, ObservedState]:
        """A scene, and states that belong to it: these, or newer ones."""
        end = time.monotonic() + _PATIENCE
        while self._scene is None or self._scene.revision != state.revision:
            if self._scene is None or self._scene.revision < state.revision:
                self._read_scene()
            if self._scene is None or self._scene.revision != state.revision:
                self._check_alive(end, "the scene")
                time.sleep(_POLL)
                state = self.state()
        return self._scene, state

    def _read_scene(self) -> None:
        with contextlib.suppress(FileNotFoundError), self._understood("its scene"):
            self._scene = _Scene(json.loads(Path(self.path, SCENE_FILE).read_bytes()))

    @contextlib.contextmanager
    def _understood(self, what: str) -> Iterator[None]:
        """What reading damaged data raises becomes one error: a server that plays a log writes what is in the log."""
        try:
            yield
        except (AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
            raise InterfaceError(f"server {self.server_id}: {what} is not understood: {error}") from None

    def pose(self, name: str) -> GzPose:
        """The global pose of an entity by its id [m], or of a body by ``entity::body``.

        Raises:
            NotFoundError: there is none of this name.
            ServerGoneError: the server ended.
        """
        scene, state = self._scene_of(self.state())
        for entity in scene.entities:
            if entity.id == name:
                body = scene.by_number.get(entity.body)
                return (
                    entity.pose
                    if body is None
                    else GzCoordPoseAdd(entity.pose, _pose(state.bodies[body.row, :7].tolist()))
                )
        for body in scene.bodies:
            if f"{body.entity}::{body.name}" == name:
                return _pose(state.bodies[body.row, :7].tolist())
        names = [entity.id for entity in scene.entities] + [f"{body.entity}::{body.name}" for body in scene.bodies]
        raise NotFoundError(f"there is no entity or body {name!r}{nearest(name, names)}")

    def data(self, reference: dict[str, Any]) -> dict[str, NDArray[Any]]:
        """The arrays of a mesh, height field or bundle of rays.

        Args:
            reference: what the scene has as ``data`` of it.

        Raises:
            NotFoundError: the file was removed, for the scene has changed since.
            InterfaceError: the scene names no such file, or no arrays of it.
        """
        name = reference["file"]
        if not is_data_file(name):
            raise InterfaceError(f"server {self.server_id}: its scene names data {name!r}, which is no file of its own")
        try:
            content = Path(self.path, name).read_bytes()
        except FileNotFoundError:
            raise NotFoundError(f"{name} was removed: the scene has changed since") from None
        with self._understood(f"{name} in its scene"):
            return arrays_of(content, reference)
