"""World as users know it: it reads worldfiles of both eras, and gets from each era what its worlds need."""

from __future__ import annotations

import gc
import io
import logging
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar, Unpack

import libgz.models as models  # `from libgz import` would look among the public names first
from libgz.base.errors import GazeboError, LibraryError, NotFoundError, WorldFileError, nearest
from libgz.base.extras import install
from libgz.base.files import exists
from libgz.base.geometry import GzPose
from libgz.legacy.factory import ModelFactory, register_builtin
from libgz.legacy.model import Model
from libgz.legacy.plugin_search import register_compiled
from libgz.legacy.settings import GlobalAttributes
from libgz.legacy.world import LegacyWorld
from libgz.physics.lock import exclusive
from libgz.sdf.recognition import is_sdf, is_sdf_text
from libgz.simulation import world
from libgz.simulation.plugins import Plugin
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode
from libgz.worldfile.search import find_worldfile, why_missing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from libgz.sdf.reader import SdfFile

__all__ = ["World", "WorldOptions"]

log = logging.getLogger("libgz.worldfile")

W = TypeVar("W", bound="World")

register_builtin(models.MODELS, Path(models.__file__).parent)


def _is_cxx_plugin(path: Path) -> bool:
    """Whether a file is a C++ plugin; the adapter is imported by worlds that name one."""
    from libgz.cxx.plugin import is_plugin

    return is_plugin(path)


def _load_cxx_plugin(path: Path) -> Plugin:
    from libgz.cxx.plugin import load

    return load(path)


register_compiled(_is_cxx_plugin, _load_cxx_plugin)


@contextmanager
def _without_collector() -> Iterator[None]:
    """Load without Python's garbage collector: what is built stays, and it would look through it again and again."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


class WorldOptions(TypedDict, total=False):
    """The arguments of `World`, as its other constructors take them; `World` describes them."""

    server_id: int | None
    force: bool
    seed: int
    solver: str
    wire_version: int
    abi: str
    strict: bool


class World(world.World):
    """A simulated world.

    In process, without the wire::

        with libgz.World.from_file("pioneer2at") as world:
            world.interface("position", "robot1").command(vx=0.3)
            world.step(1000)
            print(world.model("robot1").GetPose())

    Every call is safe in every thread; `libgz.simulation.world.World` says how.

    Args:
        server_id: serve the models' interfaces to other programs under this id; None keeps them in this process.
        force: take over a server id whose owner may still be alive.
        seed: of everything random in this world.
        solver: ``"world"``, ODE's exact solver, ``"quick"``, its iterative one, or ``"tree"``, exact and for robots
            with many joints; SDF files choose between the first two themselves.
        wire_version: of the interfaces: 0x060, or 0x050 for clients of Gazebo 0.5.
        abi: of the programs that it serves: ``"x86_64"`` for those of this machine, ``"i386"`` for 32-bit ones.
        strict: whether the first error of a model or plugin, or warning about the world, raises StrictError, at the end
            of the step or of loading. Otherwise the model or plugin is stopped, and the world runs on.

    Raises:
        LibraryError: ODE is absent or unfit.
        ParameterError: there is no such solver or version, or the seed is negative.
    """

    legacy: LegacyWorld

    def _first_era(self) -> LegacyWorld:
        self.legacy = self.extension(LegacyWorld)
        self.legacy.apply(GlobalAttributes(), False)
        return self.legacy

    @classmethod
    def from_file(
        cls: type[W],
        filename: str | os.PathLike[str],
        *,
        arguments: Mapping[str, str] | None = None,
        **options: Unpack[WorldOptions],
    ) -> W:
        """Load a worldfile and make it ready to step.

        Args:
            filename: the worldfile, or the name of one of libgz's worlds, such as ``"pioneer2at"``: a file of that name
                in the current directory comes first, then one in a directory of GAZEBOPATH.
            arguments: of the macros (xacro) of a robot description, by their names.
            **options: those of World.

        Raises:
            WorldFileError: there is no such worldfile, or it has errors; the message lists them all.
            PluginError: a model's Init failed.
            ServerError: the server id is in use.
        """
        return cls._ready(lambda world: world.LoadFile(filename, arguments), options)

    @classmethod
    def from_string(cls: type[W], text: str, **options: Unpack[WorldOptions]) -> W:
        """Load the text of a legacy worldfile or an SDF document, as `from_file` does."""
        if is_sdf_text(text):
            from libgz.sdf.reader import SdfFile  # legacy worlds do without it

            return cls._ready(lambda world: world.load_sdf(SdfFile.from_string(text)), options)
        file = WorldFile()
        file.LoadString(text)
        return cls._ready(lambda world: world.Load(file), options)

    @classmethod
    @_without_collector()
    def _ready(cls: type[W], load: Callable[[W], object], options: WorldOptions) -> W:
        world = cls(**options)
        try:
            load(world)
            world.Initialize()
        except BaseException:
            world.close()
            raise
        return world

    @_without_collector()
    def LoadFile(self, filename: str | os.PathLike[str], arguments: Mapping[str, str] | None = None) -> int:
        """Build all models of a legacy worldfile or an SDF file, distinguished by the root element; 0.

        Args:
            filename: found by its path or name, as by `from_file`.
            arguments: of the macros (xacro) of a robot description, by their names.

        Raises:
            WorldFileError: the file cannot be read, or has errors; the message lists them all, one a line.
        """
        path = find_worldfile(filename)
        if is_sdf(path):
            from libgz.sdf.reader import SdfFile

            return self.load_sdf(SdfFile.load(path, arguments=arguments))
        if not exists(path):
            raise WorldFileError(f"cannot read worldfile {str(path)!r}: it does not exist{why_missing(filename)}")
        if arguments:
            log.warning("%s has no macros: %s has no effect", path, ", ".join(arguments))
        return self.Load(WorldFile.from_file(path))

    @exclusive
    def load_sdf(self, file: SdfFile) -> int:
        """Build what an SDF document describes, and load Gazebo classic's part of it if it has any; 0.

        Raises:
            WorldFileError: it has errors; the message lists them all.
        """
        from libgz.sdfworld.world import SdfWorld  # legacy worlds do without it

        self.extension(SdfWorld).load(file)
        if file.busy:
            self.attach_era()
        self.problems.check()
        return 0

    @exclusive
    def attach_era(self) -> None:
        """Attach Gazebo classic's plugins, sensors, views and topics to an SDF world. Can be called twice."""
        if self.sdf is not None:
            from libgz.classic.server import attach  # a world without plugins and sensors does not need it
            from libgz.classic_cxx.registration import register

            register()
            attach(self)

    @property
    def sdf(self) -> SdfFile | None:
        """The SDF document; None in a legacy world."""
        from libgz.sdfworld.world import SdfWorld

        found = self.present_extension(SdfWorld)  # a new one would be in states from now on
        return found.file if found is not None else None

    # Legacy ----------------------------------------------------------------------------------------------------------

    @exclusive
    def Load(self, file: WorldFile) -> int:
        """Build all models of a worldfile; 0.

        Errors are collected over the whole file. Warnings are logged; attributes that nothing read are among them.

        Raises:
            WorldFileError: there are errors; the message lists them all, one a line.
        """
        self.legacy.load(file)
        self.problems.check()
        return 0

    @exclusive
    def LoadModel(self, node: WorldFileNode, parent: Model | None = None) -> Model | None:
        """Build the model of an element, and those inside it; None if there is none to build."""
        return self.legacy.loader.load_model(node, parent)

    @exclusive
    def InsertModel(self, text: str, label: str = "<string>") -> list[Model]:
        """Add the models of a text, one `<model:...>` element or a worldfile's; they take part from the next step.

        Raises:
            WorldFileError: the text has errors or no model; nothing was added.
            PluginError: an Init failed; nothing was added.
            GazeboError: a step is running; use `after_step`.
        """
        added = self.legacy.insert(text, label)
        self.problems.check()
        return added

    # In a notebook; a world that nobody looks at loads neither OpenGL nor matplotlib --------------------------------

    def start_pose(self, width: int = 640, height: int = 480) -> GzPose:
        """Where a user's view begins: the pose of ObserverCam or `<gui><camera>`, or one that shows all models."""
        from libgz.rendering.framing import overview

        return self.era.start_view(self) or overview(self, (width, height))

    def image(self, width: int = 640, height: int = 480, pose: GzPose | None = None) -> NDArray[np.uint8]:
        """An image of the world as it is now, shape (height, width, 3), red, green, blue, top row first.

        Args:
            width, height: [px].
            pose: of the camera, which looks along x [m]; None for `start_pose`.

        Raises:
            LibraryError: rendering is disabled, or OpenGL does not work here.
            ParameterError: the size is out of range.
        """
        from libgz.rendering.framing import free_camera

        pose = self.start_pose(width, height) if pose is None else pose
        with free_camera(self, pose, (width, height), shadows=True) as camera:
            if camera.blind:
                raise LibraryError("rendering is disabled (--gl none or LIBGZ_GL), so there is no image of the world")
            return camera.Update().copy()

    def plot(self, *names: str) -> Any:
        """A matplotlib figure of what interfaces hold now.

        Args:
            *names: of models, for all their interfaces, or of interfaces, such as ``laser.laser1``; none for all.

        Raises:
            NotFoundError: there is no such model or interface.
            LibraryError: matplotlib is not installed.
            ParameterError: there is nothing to plot.
        """
        from libgz.interfaces.charts import figure_of

        served = {key: one for key, one in self.gz_server.interfaces.items() if key[0] not in ("sim", "factory")}
        if not names:
            return figure_of(list(served.values()))
        found = []
        for name in names:
            kind, dot, label = name.partition(".")
            mine = [one for key, one in served.items() if (key == (kind, label) if dot else key[1] == name)]
            if not mine:
                known = [*dict.fromkeys(key[1] for key in served), *(".".join(key) for key in served)]
                raise NotFoundError(f"nothing called {name!r} serves data{nearest(name, known)}")
            found += mine
        return figure_of(found)

    def view(self, **options: Any) -> Any:
        """The live world in a browser, embedded where a notebook shows it.

        Args:
            **options: those of the viewer.

        Raises:
            LibraryError: no viewer is installed.
        """
        import importlib.metadata  # slow to import

        for entry in importlib.metadata.entry_points(group="libgz.viewers"):
            return entry.load()(self, **options)
        raise LibraryError(f"there is no viewer here: {install('view')}; world.image() needs none")

    def _repr_png_(self) -> bytes | None:
        """What a notebook shows: an image of the world."""
        from PIL import Image

        try:
            image = self.image()
        except GazeboError:
            return None  # it is closed, or nothing renders here: the text is shown
        out = io.BytesIO()
        Image.fromarray(image).save(out, "PNG")
        return out.getvalue()

    @property
    def file(self) -> WorldFile | None:
        """The legacy worldfile; None in a world of SDF."""
        return self.legacy.file

    @property
    def settings(self) -> GlobalAttributes:
        """The settings of the legacy worldfile."""
        return self.legacy.settings

    @property
    def factory(self) -> ModelFactory:
        """The model classes by their names in worldfiles."""
        return self.legacy.factory
