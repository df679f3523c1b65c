"""CxxModel: a model whose methods are those of a C++ object."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import c_bool, c_double, c_float, c_int, c_void_p
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import PluginError
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.cxx.host import HostedServer
from libgz.cxx.objects import LoadedFile, Session, enter, running
from libgz.legacy.model import Model
from libgz.simulation.entity import packed_pose
from libgz.simulation.world import World
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

if TYPE_CHECKING:
    from libgz.physics.mass import Mass
    from libgz.physics.rays import RayProximity

__all__ = ["CxxModel"]

METHODS = ("Load", "Init", "Fini")  # by their numbers in ModelFactory.hh


class _ModelFields(ctypes.Structure):
    """The public data of the C++ class Model."""

    _fields_ = [
        ("world", c_void_p),
        ("node", c_void_p),
        ("parent", c_void_p),
        ("parentBody", c_void_p),
        ("initPose", c_double * 7),
        ("joint", c_void_p),
        ("relPose", c_double * 7),
        ("fixed", c_bool),
        ("modelSpaceId", c_void_p),
        ("logPoses", c_bool),
        ("poseCount", c_int),
        ("poseMaxCount", c_int),
        ("poses", c_void_p),
    ]


class _WorldFields(ctypes.Structure):
    """The public data of the C++ class World."""

    _fields_ = [
        ("gz_server", c_void_p),
        ("worldId", c_void_p),
        ("simSpeed", c_double),
        ("utcOffset", c_double),
        ("utmZone", c_double * 3),
        ("utmOffset", c_double * 3),
        ("fogDensity", c_double),
        ("skyColor", c_float * 4),
        ("fogColor", c_float * 4),
        ("server_id", c_int),
        ("fogEnable", c_bool),
    ]


class WorldData:
    """The C++ object of a world, whose data plugins read and write; an extension of the world."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.session = world.extension(Session)
        self.server: HostedServer | None = None
        self._fields: _WorldFields | None = None
        self._known = b""
        self._seen: tuple[Any, ...] = ()

    def pointer(self, model: CxxModel) -> int:
        """The C++ object; a session has one."""
        pointer = self.session.pointer(self.world, model)
        if self.server is None:
            self.server = HostedServer(self.world, self._number)
            fields = self._fields = _WorldFields.from_address(model.plugin.fields(pointer))
            fields.gz_server = self.server.address
            fields.worldId = self.world.engine.world
            fields.server_id = self.world.server_id or 0
            self._seen = ()
            self.to_plugin()
        return pointer

    def _number(self, low: int) -> int | None:
        """The number of the model whose C++ object has an address with these low 32 bits."""
        for pointer, model in self.session.model_objects() if low else ():
            if pointer & 0xFFFFFFFF == low:
                return model.GetIntId()
        return None

    def to_plugin(self) -> None:
        """Write what the world has, where it has changed."""
        if self.server is not None and self.server.shadows:
            self.server.pull()
        world, fields = self.world, self._fields
        seen = (
            world.simSpeed,
            world.utcOffset,
            world.utmZone,
            world.utmOffset,
            world.fogDensity,
            world.skyColor,
            world.fogEnable,
        )
        if seen == self._seen or fields is None:
            return
        fields.simSpeed, fields.utcOffset = world.simSpeed, world.utcOffset
        fields.utmZone[:], fields.utmOffset[:] = tuple(world.utmZone), tuple(world.utmOffset)
        fields.fogDensity, fields.fogEnable = world.fogDensity, bool(world.fogEnable)
        fields.skyColor[:] = tuple(world.skyColor)
        self._seen, self._known = seen, bytes(fields)

    def from_plugin(self) -> None:
        """Take what a plugin has changed."""
        if self.server is not None and self.server.shadows:
            self.server.push()
        world, fields = self.world, self._fields
        if fields is None or bytes(fields) == self._known:
            return
        world.simSpeed, world.utcOffset = fields.simSpeed, fields.utcOffset
        world.utmZone, world.utmOffset = GzVector(*fields.utmZone), GzVector(*fields.utmOffset)
        world.fogDensity, world.fogEnable = fields.fogDensity, fields.fogEnable
        world.skyColor = GzColor(*fields.skyColor)
        self._seen = ()
        self.to_plugin()

    def close(self) -> None:
        """The session has ended."""
        if self.server is not None:
            self.server.close()
        self.server = self._fields = None


class _PoseField:
    """A pose that the C++ object has, too."""

    def __set_name__(self, owner: type[CxxModel], name: str) -> None:
        self.name, self.own = name, f"_{name}"

    def __get__(self, model: CxxModel, owner: type[CxxModel] | None = None) -> GzPose:
        if model.fields is not None:
            x, y, z, u, qx, qy, qz = getattr(model.fields, self.name)
            return GzPose(GzVector(x, y, z), GzQuatern(u, qx, qy, qz))
        pose: GzPose = vars(model)[self.own]
        return pose

    def __set__(self, model: CxxModel, pose: GzPose) -> None:
        vars(model)[self.own] = pose
        if model.fields is not None:
            getattr(model.fields, self.name)[:] = (*pose.pos, *pose.rot)


class _SwitchField:
    """A switch that the C++ object has, too."""

    def __set_name__(self, owner: type[CxxModel], name: str) -> None:
        self.name, self.own = name, f"_{name}"

    def __get__(self, model: CxxModel, owner: type[CxxModel] | None = None) -> bool:
        if model.fields is not None:
            return bool(getattr(model.fields, self.name))
        return bool(vars(model)[self.own])

    def __set__(self, model: CxxModel, value: bool) -> None:
        vars(model)[self.own] = value
        if model.fields is not None:
            setattr(model.fields, self.name, bool(value))


class _ObjectField:
    """An object that the C++ object points to."""

    def __set_name__(self, owner: type[CxxModel], name: str) -> None:
        self.name, self.own = name, f"_{name}"

    def __get__(self, model: CxxModel, owner: type[CxxModel] | None = None) -> Any:
        return vars(model)[self.own]

    def __set__(self, model: CxxModel, value: Any) -> None:
        vars(model)[self.own] = value
        model.show(self.name, value)


class CxxModel(Model):
    """Base of the models of C++ plugins; each registered name has a subclass.

    Attributes:
        plugin: the file that it comes from.
        create: the function that creates the C++ object.
        pointer: the C++ object; 0 where there is none.
        fields: its public data.
        made: the C++ objects that its code made, by handle.
        sensors: its ray sensors, which states keep.
    """

    STATE: ClassVar[tuple[str, ...]] = ("sensors",)

    plugin: ClassVar[LoadedFile]
    create: ClassVar[int]

    initPose: Any = _PoseField()
    relPose: Any = _PoseField()
    fixed: Any = _SwitchField()
    logPoses: Any = _SwitchField()
    parent: Any = _ObjectField()
    parentBody: Any = _ObjectField()
    node: Any = _ObjectField()

    fields: _ModelFields | None = None
    pointer = 0

    @property
    def _homes(self) -> bytes:
        return packed_pose(self.initPose) + packed_pose(self.relPose)

    @_homes.setter
    def _homes(self, packed: bytes) -> None:
        Model._homes.fset(self, packed)  # type: ignore[attr-defined]

    def __init__(self, world: World) -> None:
        self.made: dict[int, int] = {}
        self.sensors: list[RayProximity] = []
        self.mass: Mass | None = None  # that was asked for last
        self.image = b""  # that was read last
        self._trail: Any = None
        self.label = b""
        self.session = world.extension(Session)
        self.data = world.extension(WorldData)
        super().__init__(world)
        self._relabel()
        self.session.models[self] = None
        try:
            with self._runs():
                self._object = self.plugin.create(self.create, self.data.pointer(self), self.label)
        except BaseException:
            super().close()
            self._release()
            raise
        if not self.pointer:
            super().close()
            self._release()
            raise PluginError(f"plugin {self.plugin.path}: the constructor of {self._name} made no Model")

    def constructed(self, pointer: int, fields: int) -> int:
        """The C++ base class was constructed; the handle of this model."""
        self.pointer = pointer
        handle = enter(self, pointer)
        del self.made[handle]
        poses = self.initPose, self.relPose
        self.fields = _ModelFields.from_address(fields)
        self.initPose, self.relPose = poses
        self.fields.modelSpaceId = self.modelSpaceId.id
        return handle

    def _relabel(self) -> None:
        who = f"model {self._id!r}" if self._id else f"a model of class {type(self).__name__!r}"
        self.label = f"{who}, plugin {self.plugin.path}".encode(errors="replace")

    def SetId(self, id: str) -> None:
        """Set the name of the model and of its interfaces."""
        super().SetId(id)
        self._relabel()

    @contextmanager
    def _runs(self) -> Iterator[None]:
        """Code of the plugin runs, for this model."""
        outer, running.model = running.model, self
        self.data.to_plugin()
        try:
            yield
        finally:
            running.model = outer
            self.data.from_plugin()

    def _call(self, method: int, file: WorldFile | None, node: WorldFileNode | None) -> int:
        session = self.session
        with self._runs():
            pointers = session.pointer(file, self), session.pointer(node, self)
            status, result, text = self.plugin.call(self.pointer, method, *pointers, self.label)
        self.plugin.check(status, METHODS[method], result, text, f"model {self._id!r}")
        return 0

    def Load(self, file: WorldFile, node: WorldFileNode) -> int:
        """Call Load of the C++ object."""
        return self._call(0, file, node)

    def Init(self, file: WorldFile, node: WorldFileNode) -> int:
        """Call Init of the C++ object."""
        return self._call(1, file, node)

    def Fini(self) -> int:
        """Call Fini of the C++ object."""
        return self._call(2, None, None) if self.pointer else 0

    def Update(self, step: float) -> None:
        """Call Update of the C++ object."""
        plugin = self.plugin
        outer, running.model = running.model, self
        self.data.to_plugin()
        status = plugin.update(self.pointer, step, self.label, plugin.text, 1024)
        running.model = outer
        self.data.from_plugin()
        if status:
            plugin.check(status, "Update", 0, plugin.text, f"model {self._id!r}")

    def show(self, name: str, value: Any) -> None:
        """Let the C++ object point to an object, for which the plugin may have to make one of its own."""
        if self.fields is not None:
            with self._runs():
                setattr(self.fields, name, self.session.pointer(value, self))

    def Attach(self) -> None:
        """Weld the canonical body to the parent body."""
        super().Attach()
        self.show("joint", self._weld)

    def Detach(self) -> None:
        """Take it off its parent."""
        self.show("joint", None)
        super().Detach()

    def LogPose(self) -> None:
        """Add the canonical body's centre of mass to the trail."""
        super().LogPose()
        count = len(self.poses)
        if self.fields is not None and self.fields.poseCount != count:
            numbers = [number for pose in self.poses for number in (*pose.pos, *pose.rot)]
            self._trail = (c_double * (7 * count))(*numbers)
            self.fields.poses = ctypes.addressof(self._trail)
            self.fields.poseCount = self.fields.poseMaxCount = count

    # End -------------------------------------------------------------------------------------------------------------

    def _entity_end(self) -> None:
        """Delete the C++ objects."""
        self._delete()
        self._release()

    def close(self) -> None:
        """Delete the C++ objects, and destroy bodies, joints and space."""
        self._delete()
        super().close()
        self._release()

    def _delete(self) -> None:
        """Delete the model's C++ object, and those that its code made and left."""
        pointer, self.pointer = self.pointer, 0
        if not pointer:
            return
        poses, switches = (self.initPose, self.relPose), (self.fixed, self.logPoses)
        self.fields = None
        self.initPose, self.relPose = poses
        self.fixed, self.logPoses = switches
        with self._runs():
            self.plugin.delete(pointer, self.label)
            while self.made:
                _, left = self.made.popitem()
                if self.plugin.on_heap(left):
                    self.plugin.delete(left, self.label)

    def _release(self) -> None:
        """Leave the session."""
        self.session.leave(self)
        if not self.session.models:
            self.data.close()
