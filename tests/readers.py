"""The readers of files from anywhere: how each is called, valid files to begin with, and what a reader must not do."""

from __future__ import annotations

import contextlib
import functools
import os
import re
import struct
import tempfile
from collections.abc import Callable
from pathlib import Path

from sample_files import SETTINGS, TEXTURE_FORMATS, sample, with_library, with_texture, worlds

from libgz import GazeboError, GzVector, World
from libgz.base.errors import UNFORESEEN, StateError
from libgz.base.files import installed_worlds
from libgz.classic.log import LogPlay, LogReader, LogRecord, read_states
from libgz.classic.server import attach
from libgz.models.greyimage import read_grey
from libgz.models.gzb import read_gzb
from libgz.models.roadfile import read_road
from libgz.physics.bone_motion import read_motion
from libgz.physics.mesh_files import read_mesh
from libgz.player.configuration import read_configuration
from libgz.recording.capture import Capture
from libgz.recording.reader import LogReader as McapReader
from libgz.rendering.image import read_image
from libgz.rendering.skin import read_skin
from libgz.ros.packages import exported_folders, with_paths
from libgz.ros.parameters import Parameters
from libgz.sdf.packages import all_packages, find_package
from libgz.sdf.upgrade import NEWEST
from libgz.study.variant import Variant
from libgz.sweep.study import Study
from libgz.view.assets import Assets
from libgz.view.local import LocalSource
from libgz.view.protocol import scene_message

__all__ = ["ASSETS", "KINDS", "SAVED", "TEXT", "problem", "seeds", "warm"]

ROOT = Path(__file__).parents[1]
EVERYTHING = ROOT / "tests" / "data" / "worlds" / "everything.sdf"

# Where each kind of asset stands in a world ({0}: its name, {1}: without suffix), and what reads it alone. A road's
# model adds the file's name; the files that name libraries and textures are written beside them.
GEOMETRY = (
    "<sdf version='1.6'><model name='m'><static>1</static><link name='l'>"
    "<collision name='c'><geometry>{}</geometry></collision></link></model></sdf>"
)
LEGACY = "<gz:world xmlns:gz='g' xmlns:model='m'>{}</gz:world>"
LOOK = GEOMETRY.replace("</link>", "<visual name='v'><geometry>{}</geometry></visual></link>")
HEIGHTS = "<heightmap><uri>{0}</uri><size>10 10 1</size></heightmap>"
ACTOR = (
    "<sdf version='1.6'><world name='w'><actor name='a'>"
    "<animation name='walk'><filename>{0}</filename></animation></actor></world></sdf>"
)
MESH = "<mesh><uri>{0}</uri></mesh>"
SHOWN = (
    "".join(
        f"<visual name='v{i}'><geometry><mesh><uri>{{1}}.{kind}</uri></mesh></geometry></visual>"
        for i, kind in enumerate(("obj", "dae"))
    )
    + "</link>"
)
ASSET_WORLDS = {
    "3ds": LEGACY.format("<model:SimpleSolid><skinFile>{0}</skinFile></model:SimpleSolid>"),
    "gzb": LEGACY.format("<model:Terrain><terrainFile>{0}</terrainFile></model:Terrain>"),
    "road": LEGACY.format("<model:Road><roadFile>{0}</roadFile></model:Road>"),
    **dict.fromkeys(("ppm", "png"), GEOMETRY.format(HEIGHTS)),
    "jpeg": LEGACY.format("<model:Terrain><dataFile>{0}</dataFile></model:Terrain>"),
    **dict.fromkeys(("stl", "obj", "dae"), LOOK.format(MESH, MESH)),
    "bvh": ACTOR,
    **dict.fromkeys(("mtl", "texture"), GEOMETRY.format(MESH.format("{1}.obj")).replace("</link>", SHOWN)),
}
READERS: dict[str, list[Callable[[Path], object]]] = {
    "3ds": [read_skin],
    "gzb": [read_gzb],
    "road": [lambda path: read_road(path, GzVector())],
    **{kind: [read_image, read_grey] for kind in ("ppm", "png", "jpeg")},
    **{kind: [read_mesh] for kind in ("stl", "obj", "dae")},
    "bvh": [read_motion],
    "mtl": [lambda path: read_mesh(with_library(path))],
    "texture": [read_image, lambda path: with_texture(path)],
}
ASSETS = tuple(ASSET_WORLDS)
SAVED = ("state", "mcap", "log")  # what libgz itself wrote while a world ran; log: state.log
MAGIC, CHUNK, DATA_END = b"\x89MCAP0\r\n", 0x06, 0x0F  # of an MCAP file
KINDS = ("legacy", "sdf", "xacro", *ASSETS, *SAVED, *SETTINGS)
TEXT = ("legacy", "sdf", "xacro", "road", "obj", "dae", "bvh", "mtl", "log", *SETTINGS)
WITH_LOOKS = ("obj", "dae", "mtl", "texture")  # kinds that say how meshes look


def seeds(kind: str) -> list[bytes]:
    """Valid files of a kind: worlds of this project, or small assets."""
    if kind == "legacy":
        return [path.read_bytes() for path in worlds(installed_worlds(), b"gz:world")]
    if kind == "sdf":
        robots = sorted((ROOT / "tests" / "data" / "urdf").rglob("*.urdf"))
        files = [EVERYTHING] * 8 + worlds(ROOT / "examples", b"<sdf") + robots
        return [path.read_bytes() for path in (*files, *_further(".sdf", ".world", ".urdf"))]
    if kind == "mcap":
        return [_log(), uncompressed(_log())]
    if kind == "log":
        return [_state_log(encoding) for encoding in ("txt", "txt", "txt", "zlib", "bz2")]
    if kind == "state":
        return [_world(path).get_state() for path in STATE_WORLDS]
    if kind == "xacro":
        files = sorted((ROOT / "tests" / "data" / "urdf").rglob("*.xacro"))
        return [path.read_bytes() for path in (*files, *_further(".xacro"))]
    if kind in SETTINGS:
        return [text.encode() for text in SETTINGS[kind]]
    return [sample(kind, number) for number in range(len(TEXTURE_FORMATS) if kind == "texture" else 2)]


def _further(*suffixes: str) -> list[Path]:
    """Files of the folder TRIAL_SEEDS, such as checkouts of public robots, with these suffixes."""
    folder = os.environ.get("TRIAL_SEEDS")
    found = sorted(Path(folder).rglob("*")) if folder else []
    return [path for path in found if path.suffix in suffixes and path.is_file() and path.stat().st_size < 200_000]


def warm() -> None:
    """Load worlds with all models and sensors, so that their modules are imported."""
    for path in (*worlds(installed_worlds(), b"gz:world"), EVERYTHING):
        with World.from_file(path) as world:
            world.step(1)


def problem(kind: str, path: Path, after: Callable[[World], object] | None = None) -> str:
    """What is wrong with how a file is read; an empty string if it is read, or refused as it should be.

    Args:
        kind: of the file, one of KINDS.
        path: the file; the world of an asset is written beside it.
        after: called with the loaded world, if it is given.
    """

    def load(path: Path) -> None:
        with World.from_file(path) as world:
            if kind in WITH_LOOKS:
                show(world)
            if after is not None:
                after(world)

    if kind == "state":
        return _problem_of_state(path)
    if kind == "mcap":
        return _problem(path, _read_log)
    if kind == "log":
        return _problem(path, _play_state_log)
    if kind in SETTINGS:
        return _problem_of_settings(kind, path, load)
    if kind not in ASSETS:
        return _problem(path, load, line=True)
    for reader in READERS[kind]:
        found = _problem(path, reader)
        if found and kind != "road":
            return found
    world = path.with_suffix(".world")
    world.write_text(ASSET_WORLDS[kind].format(path.name, path.stem))
    return _problem(world, load, line=True)


def _problem_of_settings(kind: str, path: Path, load: Callable[[Path], None]) -> str:
    """Read a file that says how to run what others contain."""
    if kind == "player":
        return _problem(path, read_configuration, line=True)
    if kind == "parameters":
        return _problem(path, lambda path: Parameters().read(path))
    if kind == "study":
        return _problem(path, _read_study)
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    if kind == "material":
        world = path.with_suffix(".world")
        script = "<material><script><uri>{}</uri><name>{}</name></script></material>"
        scripts = (f"<visual name='{n}'><geometry/>{script.format(path, n)}</visual>" for n in ("Plain", "Own", "none"))
        world.write_text(f"<sdf version='1.6'><model name='m'><link name='l'>{''.join(scripts)}</link></model></sdf>")
        return _problem(world, load, line=True)
    world = folder / "a.world"
    world.write_text(f"<sdf version='1.6'><world name='w'><include><uri>{folder}</uri></include></world></sdf>")
    (folder / "model.sdf").write_text("<sdf version='1.6'><model name='m'><link name='l'/></model></sdf>")
    path.replace(folder / ("model.config" if kind == "config" else "package.xml"))
    if kind == "config":
        return _problem(world, load, line=True)
    os.environ["ROS_PACKAGE_PATH"] = str(folder)  # one package, known by its folder's name whatever its manifest says
    if list(all_packages([folder])) != [folder] or find_package(folder.name, [folder]) != folder:
        return "the package is not found by its folder's name"
    exported_folders()
    return "" if with_paths(f"package://{folder.name}/a") == f"file://{folder}/a" else "its path is not inserted"


def _read_study(path: Path) -> None:
    study = Study.load(path)
    for number in range(min(len(study), 3)):
        with contextlib.suppress(GazeboError):  # of the world, with these values
            Variant(study.world).load(study.run(number).changes).close()


STATE_WORLDS = (installed_worlds() / "pioneer2at.world", ROOT / "examples" / "sdf" / "gripper.world")


@functools.cache
def _world(path: Path) -> World:
    world = World.from_file(path)
    world.step(5)
    return world


def _problem_of_state(path: Path) -> str:
    """Set a state in worlds that have others, one of which may be its own."""
    data = path.read_bytes()
    for world in map(_world, STATE_WORLDS):
        before = world.get_state()
        try:
            world.set_state(data)
        except StateError:
            if world.get_state() != before:
                return "a refused state has changed the world"
            continue
        with contextlib.suppress(Exception):  # an attribute may hold anything, also what its class cannot use
            world.step(3)
        world.set_state(before)
        if world.get_state() != before:
            return "a sound state that follows is not the same"
    return ""


def _log() -> bytes:
    """A log of a few steps."""
    with tempfile.TemporaryDirectory(prefix="libgz-log-") as folder:
        path = Path(folder) / "log.mcap"
        with World.from_file(STATE_WORLDS[0]) as world, Capture(world, path) as log:
            for _ in range(5):
                world.Step()
                log.take()
        return path.read_bytes()


def uncompressed(log: bytes) -> bytes:
    """A log whose chunks are neither compressed nor have check sums, without a summary: its content can be mutated."""
    import zstandard

    found, at = bytearray(MAGIC), len(MAGIC)
    while at < len(log) - len(MAGIC):
        opcode, size = struct.unpack_from("<BQ", log, at)
        content = log[at + 9 : at + 9 + size]
        if opcode == DATA_END:
            break
        if opcode == CHUNK:
            begin = 28 + 4 + len("zstd") + 8
            data = zstandard.ZstdDecompressor().decompress(content[begin:])
            content = content[:24] + struct.pack("<IIQ", 0, 0, len(data)) + data
        found += struct.pack("<BQ", opcode, len(content)) + content
        at += 9 + size
    return bytes(found)


def _read_log(path: Path) -> None:
    with McapReader(path) as log:
        for message in log.messages():
            _ = message.data
        log.last(log.end)


def _state_log(encoding: str) -> bytes:
    """A state.log of a few steps, in which models come and go."""
    with tempfile.TemporaryDirectory(prefix="libgz-log-") as folder:
        path = Path(folder) / "state.log"
        with World.from_file(STATE_WORLDS[1]) as world, LogRecord(world, path, encoding=encoding):
            world.step(3)
            view = attach(world).world
            view.InsertModelString("<sdf version='1.6'><model name='new'><link name='l'/></model></sdf>")
            world.step(3)
            view.RemoveModel("new")
            world.step(2)
        return path.read_bytes()


def _play_state_log(path: Path) -> None:
    """Read a state.log as `libgz log` does, and play it forwards and backwards."""
    reader = LogReader(path)
    for state in read_states(reader):
        state.text(NEWEST)
    with LogPlay(path) as play:
        play.Span()
        for _ in range(6):
            play.Step()
        play.StepBack(4)
        play.Forward()
        play.Rewind()


def show(world: World) -> None:
    """Make all that a page of the browser loads of a world."""
    source = LocalSource(world)
    assets = Assets(source)
    addresses = assets.of_scene(source.scene)
    scene_message(source.scene, addresses)
    for address in filter(None, addresses.values()):
        assets.get(address)


def _problem(path: Path, action: Callable[[Path], object], line: bool = False) -> str:
    try:
        action(path)
    except GazeboError as error:
        text = str(error)
        if UNFORESEEN in text or "Load failed with" in text or "Init failed with" in text:
            return text[:2000]
        if not (re.match(r".+:\d+: ", text) if line else path.name in text):
            return f"the message names no {'line' if line else 'file'}: {text[:2000]}"
    return ""
