"""Never stricter than Gazebo classic: each refusal of the readers has a row in refusals.tsv, with its reason.

A row is a module, a message with {} for what varies, a kind, and why:

gazebo    Gazebo 11.1 (or the old server, for worldfiles) refuses the file, too, as its sources and sdformat's say
bound     SECURITY.md publishes the bound
later     of an SDF version that Gazebo 11.1 does not know
part      the part is left out with a warning, and the rest loads
damaged   the file as a whole cannot be read
call      raised for arguments of calls, or states; no file reaches it
passed on the function that takes the message of others
stricter  libgz is stricter, and should not be

A new message fails this test until it has a row; one of the first three kinds needs a case below, too.
"""

import ast
import re
from pathlib import Path

import pytest
from bone_files import two_bones
from PIL import Image
from sample_files import gltf, sample

import libgz
from libgz.base.errors import GazeboError
from libgz.physics import mesh_files, skeletons
from libgz.physics.image_files import open_image
from libgz.physics.mesh_files import read_mesh
from libgz.rendering.skin import read_skin
from libgz.sdf import reader
from libgz.sdf.paths import find_world
from libgz.sdf.reader import SdfFile
from libgz.worldfile.file import WorldFile

ROOT = Path(__file__).parents[2]
READERS = (
    *("libgz/sdf/**/*.py", "libgz/sdfworld/**/*.py", "libgz/worldfile/**/*.py", "libgz/classic/sensors/*.py"),
    *("libgz/physics/*_files.py", "libgz/physics/skeletons.py", "libgz/physics/outlines.py", "libgz/physics/faces.py"),
    "libgz/base/entities.py",
)
MACROS = "libgz/sdf/xacro"  # its errors leave a description without its macros
ROWS = [line.split("\t") for line in (ROOT / "tests/refusals/refusals.tsv").read_text().splitlines()[1:]]
KINDS = {"gazebo", "bound", "later", "part", "damaged", "call", "passed on", "stricter"}
WITH_CASES = ("gazebo", "bound", "later")


def template(node):
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return ""


def refusals(path):
    """The messages of the errors that a module raises or collects."""
    for node in ast.walk(ast.parse(path.read_text())):
        call = node.exc if isinstance(node, ast.Raise) else node
        collected = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        collected = collected and node.func.attr in ("error", "_error") and ast.unparse(node.func.value) != "log"
        if isinstance(call, ast.Call) and (isinstance(node, ast.Raise) or collected):
            yield " | ".join(filter(None, map(template, call.args))) or "{}"


def test_each_refusal_has_one_row_and_each_row_a_refusal():
    paths = {path for pattern in READERS for path in ROOT.glob(pattern)} - set((ROOT / MACROS).glob("*.py"))
    found = {(str(path.relative_to(ROOT)), message) for path in paths for message in refusals(path)}
    rows = [(module, message) for module, message, _, _ in ROWS]
    assert sorted(rows) == sorted(set(rows))
    assert set(rows) - found == set()
    assert found - set(rows) == set()
    assert {kind for _, _, kind, _ in ROWS} <= KINDS
    assert all(why for _, _, _, why in ROWS)


def sdf(inside, version="1.6"):
    return f"<sdf version='{version}'><world name='w'>{inside}</world></sdf>"


def model(inside):
    return sdf(f"<model name='m'><link name='a'/><link name='b'/>{inside}</model>")


def robot(inside, name=" name='r'"):
    return f"<robot{name}>{inside}</robot>"


def joint(kind="revolute", ends="<parent>a</parent><child>b</child>", axes="<axis><xyz>0 0 1</xyz></axis>"):
    return model(f"<joint name='j' type='{kind}'>{ends}{axes}</joint>")


def sensor(kind, inside):
    return model(f"<link name='c'><sensor name='s' type='{kind}'>{inside}</sensor></link>")


def legacy(inside):
    names = "xmlns:gz='g' xmlns:model='m' xmlns:param='p'"
    return f"<gz:world {names}>{inside}</gz:world>"


RAYS = "<ray><scan><horizontal><samples>{}</samples><resolution>{}</resolution></horizontal>{}</scan></ray>"
ROWS_OF_RAYS = "<vertical><samples>5000</samples></vertical>"
MASS = "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"
BALL = "<collision><geometry><sphere radius='1'/></geometry></collision>"
SOLID = f"<link name='a'>{MASS}{BALL}</link>"
LINKS = "".join(f"<link name='{name}'>{MASS}</link>" for name in "abc")
ENTITY = "<!DOCTYPE sdf [<!ENTITY e {}>]><sdf version='1.6'><model name='m'><static>&e;</static></model></sdf>"


def urdf_joint(name, parent, child, kind="fixed", more=""):
    return f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{more}</joint>"


POSE = "<model name='m'><link name='l'><pose {}>{}</pose></link></model>"
CASES = {
    ("libgz/base/entities.py", "{}:{}: <{}>: it has {} attributes; at most {} are read"): sdf(
        "<model {}/>".format(" ".join(f"a{i}='1'" for i in range(1001)))
    ),
    ("libgz/base/entities.py", "entity &{}; is not text of this file; other files are not read"): ENTITY.format(
        "SYSTEM 'other'"
    ),
    ("libgz/base/entities.py", "entity &{}; holds elements; only text is replaced"): ENTITY.format("'<b/>'"),
    ("libgz/classic/sensors/camera_sdf.py", "width | the image has {} px; {} px in all are allowed"): sensor(
        "camera", "<camera><image><width>16000</width><height>16000</height></image></camera>"
    ),
    ("libgz/classic/sensors/ray.py", "resolution"): sensor("ray", RAYS.format(10, "1e9", "")),
    ("libgz/classic/sensors/ray.py", "samples | there are more than {} rays or readings"): sensor(
        "ray", RAYS.format(5000, 1, ROWS_OF_RAYS)
    ),
    ("libgz/classic/sensors/read.py", "is {}; it must be at most {}"): sensor("ray", RAYS.format(99999999, 1, "")),
    ("libgz/sdf/reader.py", "<{}> is missing and must be given"): joint(ends="<parent>a</parent>"),
    ("libgz/sdf/reader.py", "attribute {} is missing and must be given"): sdf("<model/>"),
    ("libgz/sdf/reader.py", "degrees have no meaning for rotation_format='quat_xyzw'"): sdf(
        POSE.format("rotation_format='quat_xyzw' degrees='1'", "0 0 0 0 0 0 1"), "1.9"
    ),
    ("libgz/sdf/reader.py", "rotation_format is {}; euler_rpy and quat_xyzw are allowed"): sdf(
        POSE.format("rotation_format='rpy'", "0 0 0 0 0 0"), "1.9"
    ),
    ("libgz/sdf/reader.py", "{} is not allowed; a quaternion must not be zero"): sdf(
        POSE.format("rotation_format='quat_xyzw'", "0 0 0 0 0 0 0"), "1.9"
    ),
    ("libgz/sdf/reader.py", "{} is not allowed; it must be {} numbers"): sdf(POSE.format("degrees='1'", "0 0"), "1.9"),
    (
        "libgz/sdf/reader.py",
        "version is missing and must be given",
    ): "<sdf><model name='m'><link name='l'/></model></sdf>",
    ("libgz/sdf/reader.py", "version {} is not allowed; {} to {} are"): sdf("", "new"),
    ("libgz/sdf/reader.py", "{} is not allowed; it must be {}"): sdf(
        "<physics><max_step_size>x</max_step_size></physics>"
    ),
    ("libgz/sdf/robot.py", "<{} link='...'> is missing and must be given"): robot(
        LINKS + "<joint name='j' type='fixed'><parent link='a'/></joint>"
    ),
    ("libgz/sdf/robot.py", "attribute 'name' is missing and must be given"): robot(LINKS[: len(LINKS) // 3], ""),
    ("libgz/sdf/robot.py", "each link is the child of a joint: the joints are a loop"): robot(
        LINKS + urdf_joint("i", "a", "b") + urdf_joint("j", "b", "c") + urdf_joint("k", "c", "a")
    ),
    ("libgz/sdf/robot.py", "links {} have no parent; all but one must be the child of a joint"): robot(LINKS),
    ("libgz/sdf/robot.py", "there is a {} {} already, at {}; names must differ"): robot(LINKS + "<link name='a'/>"),
    ("libgz/sdf/robot.py", "there is no <link>; a robot must have one"): robot(""),
    ("libgz/sdf/robot.py", "there is no link {}{}"): robot(LINKS + urdf_joint("j", "a", "x")),
    ("libgz/sdf/robot.py", "type is {}; it must be {}"): robot(LINKS + urdf_joint("j", "a", "b", "rigid")),
    ("libgz/sdf/robot.py", "{} is {}; it must be {}"): robot(
        LINKS + urdf_joint("j", "a", "b", more="<origin xyz='x y z'/>")
    ),
    ("libgz/sdf/robot.py", "{}; a link must have one parent"): robot(
        LINKS + urdf_joint("i", "a", "b") + urdf_joint("j", "c", "b")
    ),
    ("libgz/sdf/urdf.py", "{} is not allowed; it must be a number"): robot(
        SOLID + "<gazebo reference='a'><kp>x</kp></gazebo>"
    ),
    ("libgz/sdf/xml.py", "{}"): "<sdf version='1.6'><world></sdf>",
    ("libgz/sdfworld/world.py", "{}: <sdf>: holds no world, model or light"): "<sdf version='1.6'/>",
    ("libgz/worldfile/attributes.py", "{} is not allowed; {}{} must be {}{}"): legacy(
        "<model:SimpleSolid><shape>pyramid</shape></model:SimpleSolid>"
    ),
    ("libgz/worldfile/attributes.py", "{} must be finite, and at most {}"): legacy(
        "<model:ObserverCam><updateRate>1e400</updateRate></model:ObserverCam>"
    ),
    (
        "libgz/worldfile/file.py",
        "{}:{}: <{}>: this is a world of Gazebo 0.8 - 0.10, which libgz does not read; "
        "worlds of 0.3 - 0.7 have a root like <gz:world>",
    ): "<gazebo:world xmlns:gazebo='http://playerstage.sourceforge.net/gazebo/xmlschema/#gz'/>",
    ("libgz/worldfile/node.py", "'nan' is not allowed here"): legacy(
        "<model:SimpleSolid><xyz>nan 0 0</xyz></model:SimpleSolid>"
    ),
    ("libgz/worldfile/node.py", "{} are not allowed here"): legacy(
        "<model:SimpleSolid><xyz>inf 0 0</xyz></model:SimpleSolid>"
    ),
}


# Cases that need more than a text: functions of a folder and monkeypatch.


def too_large_an_image(folder, _monkeypatch):
    Image.new("L", (20, 20)).save(folder / "a.png")
    with open_image(folder / "a.png", 100):
        pass


def too_many_triangles(folder, monkeypatch):
    monkeypatch.setattr(mesh_files, "MOST_TRIANGLES", 1)
    (folder / "a.dae").write_bytes(sample("dae", 0))
    read_mesh(folder / "a.dae")


def too_many_nodes(folder, monkeypatch):
    monkeypatch.setattr(mesh_files, "MOST_NODES", 1)
    (folder / "a.dae").write_bytes(sample("dae", 0))
    read_mesh(folder / "a.dae")


def too_many_parts(folder, monkeypatch):
    monkeypatch.setattr(mesh_files, "MOST_NODES", 1)
    (folder / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\ng b\nf 1 2 3\n")
    read_mesh(folder / "a.obj")


def too_many_references(folder, monkeypatch):
    monkeypatch.setattr(mesh_files, "MOST_READ", -(1 << 30))
    (folder / "a.dae").write_bytes(sample("dae", 0))
    read_mesh(folder / "a.dae")


def too_large_a_mesh(folder, monkeypatch):
    monkeypatch.setattr(mesh_files, "LARGEST_FILE", 1)
    (folder / "a.dae").write_bytes(sample("dae", 0))
    read_mesh(folder / "a.dae")


def an_archive(folder, monkeypatch):
    pytest.importorskip("trimesh")
    (folder / "a.zip").write_bytes(b"")
    read_mesh(folder / "a.zip")


def bounded_gltf(bound, most=1):
    def read(folder, monkeypatch):
        pytest.importorskip("trimesh")
        monkeypatch.setattr(mesh_files, bound, most)
        (folder / "a.gltf").write_text(gltf(nodes=[{"mesh": 0}] * 2, scenes=[{"nodes": [0, 1]}]))
        read_skin(folder / "a.gltf")

    return read


def too_many_bones(folder, monkeypatch):
    monkeypatch.setattr(skeletons, "MOST_KEYS", 1)
    (folder / "a.dae").write_text(two_bones())
    skeletons.read_figure(folder / "a.dae")


def an_include_of_itself(folder, monkeypatch, uri="model://m"):
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(folder))
    (folder / "m").mkdir()
    (folder / "m" / "model.config").write_text("<model><sdf version='1.6'>m.sdf</sdf></model>")
    (folder / "m" / "m.sdf").write_text(
        f"<sdf version='1.6'><model name='m'><include><uri>{uri}</uri></include></model></sdf>"
    )
    SdfFile.load(folder / "m" / "m.sdf").diagnostics.raise_errors()


def an_include_of_another(folder, monkeypatch):
    monkeypatch.setattr(reader, "DEEPEST_INCLUDE", 0)
    an_include_of_itself(folder, monkeypatch)


def too_many_includes(folder, monkeypatch):
    monkeypatch.setattr(reader, "MOST_INCLUDED", 1)
    an_include_of_itself(folder, monkeypatch, "model://ground_plane")


def no_such_file(folder, _monkeypatch):
    SdfFile.load(folder / "nothing.sdf")


def no_such_world(_folder, _monkeypatch):
    find_world("nothing.world")


def no_such_worldfile(folder, _monkeypatch):
    WorldFile().Load(str(folder / "nothing.world"))


def text_of(text):
    return lambda _folder, _monkeypatch: WorldFile().LoadString(text, "w.world")


MORE = {
    ("libgz/physics/image_files.py", "image {} has {} x {} pixels; {} are allowed"): too_large_an_image,
    ("libgz/physics/mesh_files.py", "its parts refer to each other so often that reading it takes too long"): (
        too_many_references
    ),
    ("libgz/physics/mesh_files.py", "{} {} cannot be read: it is an archive"): an_archive,
    ("libgz/physics/mesh_files.py", "mesh {} is larger than {} MiB"): too_large_a_mesh,
    ("libgz/physics/mesh_files.py", "it is larger than {} MiB"): bounded_gltf("LARGEST_FILE"),
    ("libgz/physics/mesh_files.py", "it declares {} vertices and indices; {} are allowed"): bounded_gltf(
        "MOST_NUMBERS"
    ),
    ("libgz/physics/mesh_files.py", "it has more than {} nodes and geometries"): bounded_gltf("MOST_NODES"),
    ("libgz/physics/mesh_files.py", "its nodes are nested more than {} deep, or contain themselves"): bounded_gltf(
        "MOST_DEPTH", -1
    ),
    ("libgz/physics/mesh_files.py", "mesh {} has more than {} parts"): too_many_parts,
    ("libgz/physics/mesh_files.py", "it has more than {} triangles, or three vertices for each of so many"): (
        bounded_gltf("MOST_TRIANGLES")
    ),
    ("libgz/physics/mesh_files.py", "its scene has more than {} nodes and geometries"): too_many_nodes,
    ("libgz/physics/mesh_files.py", "mesh {} has more than {} triangles"): too_many_triangles,
    ("libgz/physics/skeletons.py", "its skeleton has too many nodes"): too_many_bones,
    ("libgz/sdf/paths.py", "there is no world {}; looked for {}; set GAZEBO_RESOURCE_PATH"): no_such_world,
    ("libgz/sdf/reader.py", "Unable to read sdf file[{}]: {}"): no_such_file,
    ("libgz/sdf/reader.py", "includes are nested deeper than {}"): an_include_of_another,
    ("libgz/sdf/reader.py", "includes have more than {} MiB together"): too_many_includes,
    ("libgz/sdf/reader.py", "{} includes itself"): an_include_of_itself,
    ("libgz/worldfile/file.py", "cannot read worldfile {}: {}"): no_such_worldfile,
}
# Refusals of a text that other tests have: words in one of them.
ELSEWHERE = {
    ("libgz/base/entities.py", "entity &{}; contains itself, or is longer than {} characters in all"): "longer than",
    (
        "libgz/sdf/reader.py",
        "{}:{}: <{}>: the root of an SDF file must be <sdf version='...'>",
    ): "root of an SDF file must be",
    ("libgz/worldfile/file.py", "{}"): "mismatch",
    ("libgz/worldfile/file.py", "{}:{}: {}"): "mismatch",
    (
        "libgz/worldfile/file.py",
        "{}:{}: <{}>: this is {}, not a worldfile of 0.3 - 0.7, whose root is like <gz:world>",
    ): "not a worldfile of 0.3",
    ("libgz/worldfile/node.py", "attribute <{}> is missing and must be given{}"): "must be given; did you mean",
}


def test_each_refusal_of_a_file_has_a_case():
    wanted = {(module, message) for module, message, kind, _ in ROWS if kind in WITH_CASES}
    assert wanted == set(CASES) | set(MORE) | set(ELSEWHERE)


@pytest.mark.parametrize(("module", "message"), CASES, ids=lambda value: str(value)[-60:])
def test_the_case_of_a_refusal_is_refused(module, message, tmp_path):
    path = tmp_path / ("w.urdf" if CASES[module, message].startswith("<robot") else "w.world")
    path.write_text(CASES[module, message])
    with pytest.raises(GazeboError) as caught:
        load(path)
    assert matches(message, str(caught.value)), str(caught.value)


@pytest.mark.parametrize(("module", "message"), MORE, ids=lambda value: str(value)[-60:])
def test_the_other_cases_of_refusals_are_refused(module, message, tmp_path, monkeypatch):
    with pytest.raises(GazeboError) as caught:
        MORE[module, message](tmp_path, monkeypatch)
    assert matches(message, str(caught.value)), str(caught.value)


def test_the_tests_of_other_refusals_are_there():
    own = Path(__file__)
    texts = [path.read_text() for path in (ROOT / "tests").rglob("test_*.py") if path != own]
    assert [words for words in ELSEWHERE.values() if not any(words in text for text in texts)] == []


def load(path):
    """Load a world, or the description of a robot."""
    if path.suffix == ".urdf":
        SdfFile.load(path).diagnostics.raise_errors()
    else:
        libgz.World.from_file(path).close()


def matches(message, text):
    """Whether a text has the words of a message in its order."""
    words = [re.escape(word) for word in re.split(r"\{\}| \| ", message) if word.strip(": ")]
    return re.search(".*".join(words), text, re.DOTALL) is not None
