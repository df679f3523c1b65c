"""The package itself: its public names, and what importing it costs."""

import subprocess
import sys
from pathlib import Path

import libgz

ROOT = Path(__file__).parent.parent


def test_every_public_name_can_be_imported():
    for name in dir(libgz):
        assert getattr(libgz, name) is not None
    assert {"World", "Model", "Body", "HingeJoint", "Client", "GZ_REGISTER_PLUGIN", "dParamVel"} <= set(dir(libgz))


def test_a_star_import_brings_every_public_name():
    names = {}
    exec("from libgz import *", names)
    assert {"World", "gz_client_alloc", "gz_position_open", "GZ_SEM_KEY"} <= set(names)


def test_a_wrong_name_is_answered_with_the_right_one():
    try:
        _ = libgz.Wordl
    except AttributeError as error:
        assert "did you mean 'World'" in str(error)
    else:
        raise AssertionError("no error")


# What few worlds need, of either era; an era's own are in its test.
FOR_FEW = (
    "libgz.apps.editing",  # requests of viewers and of `libgz snapshot`
    "libgz.apps.world_control",
    "libgz.legacy.replacement",
    "libgz.physics.mesh_files",
    "libgz.simulation.batch",
    "libgz.simulation.editor",
    "libgz.simulation.reloading",
    "libgz.simulation.rewind",
    "libgz.worldfile.source",
)


def loaded_after(statement):
    code = f"import sys\n{statement}\nprint(' '.join(sys.modules))"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


# Methods that a start makes by compiling their texts, as `dataclass` does, 0.1 ms each: six for a frozen class that
# compares, one with eq=False and repr=False, none for a named tuple.
MOST_TEXTS = {"gazebo": 70, "gzserver": 85}


def count_texts(statement):
    """How many texts a statement compiles, without those of numpy."""
    code = f"""
import sys
import numpy
texts = []
def note(event, values):
    if event == "exec" and values[0].co_filename == "<string>":
        texts.append(values[0])
sys.addaudithook(note)
{statement}
print(len(texts))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return int(done.stdout.split()[-1])


def test_a_command_compiles_little_text(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("TMP", str(tmp_path))
    monkeypatch.setenv("GAZEBO_MASTER_URI", "http://localhost:0")
    commands = {"gazebo": ["-s", "32", "--steps", "1", "pioneer2at"], "gzserver": ["--iters", "1"]}
    for name, words in commands.items():
        found = count_texts(f"from libgz.apps.{name} import main\nassert main({words}) == 0")
        assert found <= MOST_TEXTS[name], f"{name} compiles {found} texts; see which classes are new dataclasses"


def test_importing_the_package_loads_next_to_nothing():
    assert not {"numpy", "lxml", "ctypes", "OpenGL"} & loaded_after("import libgz")


def test_a_world_without_cameras_never_loads_opengl():
    world = ROOT / "worlds" / "pioneer2at.world"
    loaded = loaded_after(
        f"import libgz\nw = libgz.World.from_file({str(world)!r})\nw.step(20)\nw.close()\n"
        "print(open('/proc/self/maps').read())"
    )
    assert "libgz.front" in loaded
    assert not [name for name in loaded if name.startswith(("OpenGL", "libgz.rendering", "PIL"))]
    assert not [name for name in loaded if "libOSMesa" in name or "libEGL" in name or "libGL" in name]


def test_a_command_loads_only_what_its_world_needs(tmp_path, monkeypatch):
    monkeypatch.setenv("TMP", str(tmp_path))
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    loaded = loaded_after(
        "from libgz.apps.gazebo import main\nimport os\n"
        "assert main(['-s', '31', '--steps', '1', 'pioneer2at']) == 0\n"
        "print('threads=' + os.environ['OPENBLAS_NUM_THREADS'])"
    )
    assert "libgz.front" in loaded
    assert "threads=1" in loaded
    slow = ("OpenGL", "PIL", "libgz.sdfworld", "libgz.classic", "urllib.request", "importlib.metadata", "http", "ssl")
    slow += (
        "numpy.random",
        "numpy.ctypeslib",
        "shutil",
        "lzma",
        "encodings.idna",
        "subprocess",
        "tempfile",
        "difflib",
        "shlex",
        "pkgutil",
        "libgz.sdf.reader",
    )
    slow += ("libgz.physics.skeletons", *FOR_FEW)
    assert not [name for name in loaded if name.startswith(slow)]


def test_a_server_of_classic_loads_only_what_its_world_needs(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("TMP", str(tmp_path))
    monkeypatch.setenv("GAZEBO_MASTER_URI", "http://localhost:0")
    loaded = loaded_after("from libgz.apps.gzserver import main\nassert main(['--iters', '1']) == 0")
    assert {"libgz.classic.server", "libgz.sdfworld.model"} <= loaded
    slow = (
        "OpenGL",
        "PIL",
        "http",
        "ssl",
        "asyncio",
        "multiprocessing",
        "shutil",
        "lzma",
        "encodings.idna",
        "subprocess",
        "tempfile",
        "shlex",
        "pkgutil",
    )
    slow += ("scipy", "numpy.random", "numpy.polynomial", "urllib.request", "importlib.metadata", "importlib.resources")
    slow += ("libgz.ros.", "libgz.recording", "libgz.view.", "libgz.classic.sensors", "libgz.classic.rendering.")
    slow += ("libgz.sdf.xacro.expansion", "libgz.sdf.urdf", "libgz.sdfworld.actor", "libgz.sdfworld.terrain")
    slow += (
        "libgz.physics.skeletons",
        "libgz.classic.physics.actor",
        "libgz.classic.math.spline",
        "libgz.classic.log.play",
        "libgz.classic.log.record",
        "libgz.classic.physics.inertial",
        "libgz.classic.physics.joint_controller",
        "libgz.classic.physics.ray_shape",
        "libgz.classic.physics.state",
        "libgz.legacy.checks",
        "libgz.sdf.conversion",
        "libgz.sdf.state",
        *FOR_FEW,
    )
    assert not [name for name in loaded if name.startswith(slow)]


def test_a_package_loads_the_modules_of_the_names_that_are_used():
    loaded = loaded_after("from libgz.classic import math\nassert math.Vector3d(1, 2, 3).X() == 1 and math.sin(0) == 0")
    assert "libgz.classic.math.vector3" in loaded
    assert not {"libgz.classic.math.spline", "libgz.classic.math.box"} & loaded


def test_an_image_loads_the_reader_of_its_format_alone():
    image = ROOT / "worlds" / "grid.png"
    loaded = loaded_after(
        "from pathlib import Path\nfrom libgz.physics.image_files import open_image\n"
        f"with open_image(Path({str(image)!r})) as image:\n    assert image.format == 'PNG'"
    )
    assert "PIL.PngImagePlugin" in loaded
    assert not {"PIL.DdsImagePlugin", "PIL.TiffImagePlugin", "PIL.EpsImagePlugin"} & loaded


def test_commands_need_no_extra_to_be_imported():
    """Completion, man pages and `libgz echo` work where only the required packages are installed."""
    code = """
import sys
EXTRAS = {"mcap", "zstandard", "foxglove_schemas_protobuf", "matplotlib", "aiohttp", "trimesh", "imageio", "av"}
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in EXTRAS:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Absent())
from libgz.apps.command_line import command_parsers
assert "play" in command_parsers()["libgz"].format_help()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
