"""The C++ objects of plugins, and the objects of libgz that they stand for, by handles."""

from __future__ import annotations

import ctypes
import itertools
import shutil
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from libgz.base.errors import ClosedError, PluginError
from libgz.legacy.model import Model
from libgz.ode.lib import ode
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.joint import HingeJoint
from libgz.physics.space import Space
from libgz.simulation.world import World
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["OBJECTS", "LoadedFile", "Maker", "Session", "current", "enter", "forget", "known", "running"]


class LoadedFile(Protocol):
    """A loaded plugin, as its models use it; `CxxPlugin` is one."""

    path: Path
    wire: int  # version of the structs of interfaces that it was compiled with
    text: Any  # for the description of an exception
    update: Any
    fields: Any
    on_heap: Any

    def model_class(self, name: str, function: int) -> Any:
        """The class of the models that a function of the plugin creates."""

    def create(self, function: int, world: int, label: bytes) -> int:
        """Create a model by a function that the plugin registered."""

    def call(self, model: int, method: int, file: int, node: int, label: bytes) -> tuple[int, int, Any]:
        """Call Load, Init or Fini: how it ended, its result, and the text of an exception."""

    def delete(self, pointer: int, label: bytes) -> None:
        """Delete a C++ object."""

    def wrap(self, kind: str, handle: int, world: int) -> int:
        """A C++ object of a class for an object of libgz."""

    def check(self, status: int, method: str, result: int, text: Any, who: str = "") -> None:
        """Raise what a method failed with."""


class Maker(Protocol):
    """A model of a plugin, as its C++ code uses it; `CxxModel` is one."""

    world: World
    pointer: int
    label: bytes
    made: dict[int, int]
    sensors: list[Any]
    image: bytes
    mass: Any
    modelSpaceId: Space

    @property
    def plugin(self) -> LoadedFile:
        """The file that it comes from."""

    @property
    def session(self) -> Session:
        """That of its world."""

    def constructed(self, pointer: int, fields: int) -> int:
        """The C++ base class was constructed; the handle of the model."""

    def GetIntId(self) -> int:
        """Its number in interface headers."""


OBJECTS: dict[int, Any] = {}  # by handle
_pointers: dict[int, tuple[int, int]] = {}  # id of such an object -> its C++ object, and the handle
_makers: dict[int, Maker] = {}  # handle -> the model whose code made the C++ object
_handles = itertools.count(1)

# The classes of which there are C++ objects for what libgz made.
KINDS = (
    ("World", World),
    ("Model", Model),
    ("Body", Body),
    ("Geom", Geom),
    ("HingeJoint", HingeJoint),
    ("WorldFile", WorldFile),
    ("WorldFileNode", WorldFileNode),
)


class _Running(threading.local):
    """The model of a plugin whose code this thread runs."""

    model: Maker | None = None
    failure: BaseException | None = None  # of the function of libgz that failed last
    registered: list[tuple[str, int]] | None = None  # names and functions of the plugin that is being loaded


running = _Running()


def current() -> Maker:
    """The model whose code this thread runs.

    Raises:
        PluginError: none; a thread of a plugin's own calls.
    """
    if running.model is None:
        raise PluginError("threads of a plugin cannot create objects of Gazebo; do that in Load or Init")
    return running.model


def known(handle: int) -> Any:
    """The object of a handle; None for 0.

    Raises:
        ClosedError: it was deleted.
    """
    if not handle:
        return None
    try:
        return OBJECTS[handle]
    except KeyError:
        raise ClosedError("this object was deleted, or belongs to a world that was closed") from None


def enter(thing: Any, pointer: int) -> int:
    """Give an object a handle; `pointer` is the C++ object that stands for it."""
    handle = next(_handles)
    OBJECTS[handle] = thing
    _pointers[id(thing)] = pointer, handle
    model = running.model
    if model is not None:
        _makers[handle] = model
        model.made[handle] = pointer
    return handle


def forget(handle: int) -> Any:
    """Release a handle, whose C++ object is deleted; the object, or None."""
    thing = OBJECTS.pop(handle, None)
    if thing is not None:
        _pointers.pop(id(thing), None)
    model = _makers.pop(handle, None)
    if model is not None:
        model.made.pop(handle, None)
    return thing


class Session:
    """What the plugins of one world use, until its last model of a plugin is closed; an extension of the world."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.models: dict[Maker, None] = {}
        self._texts: dict[bytes, ctypes.Array[ctypes.c_char]] = {}
        self._wrappers: dict[int, tuple[int, Maker]] = {}  # handle -> C++ object, and who can delete it
        self._folder: Path | None = None
        self._spaces: dict[int, Space] = {}

    def text(self, value: str | None) -> int | None:
        """The address of a text, which stays until the session ends; None for None."""
        if value is None:
            return None
        data = value.encode(errors="surrogateescape")
        buffer = self._texts.get(data)
        if buffer is None:
            buffer = self._texts[data] = ctypes.create_string_buffer(data)
        return ctypes.addressof(buffer)

    def pointer(self, thing: Any, model: Maker) -> int:
        """The C++ object that stands for an object; one that libgz made gets one now. 0 for None.

        Args:
            thing: the object.
            model: whose plugin creates it.

        Raises:
            PluginError: plugins cannot use objects of this class.
        """
        if thing is None:
            return 0
        found = _pointers.get(id(thing))
        if found is not None:
            return found[0]
        kind = next((name for name, cls in KINDS if isinstance(thing, cls)), None)
        if kind is None:
            raise PluginError(f"a C++ plugin cannot use {thing!r}")
        handle = next(_handles)
        OBJECTS[handle] = thing
        world = self.pointer(self.world, model) if kind == "Model" else 0
        pointer = model.plugin.wrap(kind, handle, world)
        _pointers[id(thing)] = pointer, handle
        self._wrappers[handle] = pointer, model
        return pointer

    def model_objects(self) -> Iterator[tuple[int, Maker | Model]]:
        """(C++ object, model) of all models that plugins can see: those of plugins, and others that they were shown."""
        yield from ((model.pointer, model) for model in self.models)
        for handle, (pointer, _) in self._wrappers.items():
            thing = OBJECTS.get(handle)
            if isinstance(thing, Model):
                yield pointer, thing

    def space(self, address: int | None) -> Space | None:
        """The space of an address of ODE's, which may be one that the plugin made itself; None for None.

        Raises:
            PluginError: it is a geom.
        """
        if not address:
            return None
        engine = self.world.engine
        found = self._spaces.get(address)
        if found is None or found.engine is not engine:
            spaces = [engine.top, *engine.spaces]
            found = next((space for space in spaces if space.id == address), None)
            if found is None:
                if not ode().dGeomIsSpace(address):
                    raise PluginError(f"{address:#x} is no space; models pass their modelSpaceId")
                found = Space(engine, address)
            self._spaces[address] = found
        if found not in engine.spaces and found is not engine.top:
            ode().dSpaceSetCleanup(address, 0)  # bodies destroy their geoms, also after the plugin destroyed its space
        return found

    def folder(self) -> Path:
        """A folder for files, until the session ends."""
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="libgz-"))
        return self._folder

    def leave(self, model: Maker) -> None:
        """A model was closed; with the last one the session ends."""
        self.models.pop(model, None)
        for address in [a for a, space in self._spaces.items() if space is model.modelSpaceId]:
            del self._spaces[address]
        if self.models:
            return
        while self._wrappers:
            _, (pointer, maker) = self._wrappers.popitem()
            maker.plugin.delete(pointer, maker.label)  # which forgets the handle
        self._texts.clear()
        self._spaces.clear()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None
