"""The table of signatures, what is made of it, and the installation."""

import ctypes
import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import libgz.classic_cxx.library as library_module
from libgz.apps.libgz import main
from libgz.base.errors import LibraryError, ParameterError, PluginError
from libgz.base.geometry import GzVector
from libgz.base.manifest import Manifest
from libgz.classic import msgs
from libgz.classic.api import classic_api
from libgz.classic_cxx.generate import bodies, headers
from libgz.classic_cxx.layouts import RECORDS, shared
from libgz.classic_cxx.messages import file_of, proto_files
from libgz.classic_cxx.names import ABSENT, BASE_PLUGINS
from libgz.classic_cxx.own_messages import files_in
from libgz.classic_cxx.plugin import load
from libgz.classic_cxx.recognition import is_classic, version_flags
from libgz.classic_cxx.table import rows, split
from libgz.classic_cxx.values import message_type_of
from libgz.cxx.build import compiler
from libgz.physics.check import joint_value
from libgz.sdfworld.axis import Axis
from libgz.sdfworld.joint_record import PARAMETERS, RANGES, JointRecord

HELLO = """\
#include <gazebo/gazebo.hh>

namespace gazebo
{
  class WorldPluginTutorial : public WorldPlugin
  {
    public: WorldPluginTutorial() : WorldPlugin()
            {
              printf("Hello World!\\n");
            }

    public: void Load(physics::WorldPtr, sdf::ElementPtr)
            {
            }
  };
  GZ_REGISTER_WORLD_PLUGIN(WorldPluginTutorial)
}
"""
CMAKE = """\
cmake_minimum_required(VERSION 3.5)
find_package(gazebo REQUIRED)
include_directories(${GAZEBO_INCLUDE_DIRS})
link_directories(${GAZEBO_LIBRARY_DIRS})
list(APPEND CMAKE_CXX_FLAGS "${GAZEBO_CXX_FLAGS}")
add_library(hello_world SHARED hello_world.cc)
target_link_libraries(hello_world ${GAZEBO_LIBRARIES})
"""
WORLD = """\
<sdf version="1.4"><world name="default"><plugin name="hello_world" filename="libhello_world.so"/></world></sdf>
"""
# Names of Python that C++ has elsewhere: fields, values of sdformat and ignition-math, what is made by hand.
ELSEWHERE = ("math.", "sdf.", "gui.", "common.Color", "event.", "(module)")


def test_names_that_python_has_are_declared_in_cxx():
    """Every method that the table of Gazebo's API marks as present is one of the C++ API, or is named here."""
    declared = {
        f"{row.scope.removeprefix('gazebo::')}::{row.name}" for row in rows() if row.kind in ("method", "function")
    }
    own = {row.full_name.removeprefix("gazebo::").replace("::", ".") for row in rows() if row.kind == "class"}
    missing = []
    for row in classic_api():
        if row.state not in ("present", "differs") or row.holder.startswith(ELSEWHERE) or row.holder not in own:
            continue
        if f"{row.holder.replace('.', '::')}::{row.name}" not in declared:
            missing.append(f"{row.holder}.{row.name}")
    assert len(missing) < 140, missing
    assert {"physics::Link::WorldPose", "physics::Entity::WorldPose"} & declared
    assert sum(row.kind == "method" for row in rows()) > 2300


TEMPLATES = ("SingletonT", "EventT", "PluginT", "MovingWindowFilter", "get_sha1", "weakBind", "publish")


def declaration_checks():
    """C++ that uses all that the table says of what is declared by hand, each overload in a line of its own."""
    by_hand = {row.full_name for row in rows() if row.kind == "class" and "hand" in row.flags}
    for number, row in enumerate(rows()):
        name, owner = row.full_name.removeprefix("::"), row.scope.removeprefix("::")
        if any(one in f"{owner}::{row.name}" for one in (*TEMPLATES, "<")) or row.name.startswith(("~", "operator")):
            continue
        if row.kind == "class" and "hand" in row.flags:
            yield f"struct S{number} {{ friend class ::{name}; }};"
        elif row.kind in ("typedef", "enum"):
            yield f"using T{number} = ::{name};"
        elif row.kind == "function":
            kinds = ", ".join(one.partition(" = ")[0] for one in split(row.parameters))
            pointer = f"inline {row.type} (*F{number})({kinds}) = &::{name};"
            yield f"namespace {owner} {{ {pointer} }}" if owner else pointer
        elif row.kind == "method" and row.scope in by_hand and "ctor" not in row.flags:
            given = ", ".join(f"std::declval<{one.partition(' = ')[0]}>()" for one in split(row.parameters))
            call = f"std::declval<{'const ' if 'const' in row.flags else ''}::{owner} &>().{row.name}({given})"
            yield f"namespace {owner.rpartition('::')[0]} {{ using M{number} = decltype({call}); }}"


INCLUDES = "#include <gazebo/gazebo.hh>\n#include <gazebo/gui/gui.hh>"
BROUGHT_ALONG = """\
termios settings; ifreq request; struct sigaction handler; std::future<int> later;
epoll_event event; itimerspec timer; boost::unordered_map<int, int> numbers;
"""
OLD = """\
#include <gazebo/gazebo.hh>
using namespace gazebo;
double mu(physics::SurfaceParamsPtr surface) { return surface->GetFrictionPyramid()->MuPrimary(); }
math::Pose pose(physics::LinkPtr link) { return link->GetWorldPose(); }
"""


def errors_in(library, source, version):
    """What the compiler says of a source for a version of Gazebo."""
    flags = [*library.compiler_flags(), f"-DGAZEBO_MAJOR_VERSION={version}", "-w", "-fsyntax-only"]
    flags += ["-fno-access-control", "-fmax-errors=0"]
    done = subprocess.run([*compiler(), *flags, source], capture_output=True, text=True, check=False)
    errors = [line for line in done.stderr.splitlines() if "error:" in line]
    assert bool(errors) == bool(done.returncode), done.stderr
    return errors


def test_all_that_the_table_says_is_declared(library, tmp_path):
    source = tmp_path / "declared.cc"
    source.write_text("\n".join([INCLUDES, *declaration_checks(), BROUGHT_ALONG, ""]))
    assert errors_in(library, source, 11) == []


def test_headers_that_cannot_serve_say_why(library, tmp_path):
    absent = {name: reason for reason, names in ABSENT.items() for name in names}
    source = tmp_path / "absent.cc"
    source.write_text("".join(f"#include <{name}>\n" for name in absent))
    said = [line.partition("#error ")[2] for line in errors_in(library, source, 11)]
    assert said == [f"<{name}>: {reason}" for name, reason in absent.items()]


def test_names_of_gazebo_7_are_declared(library, tmp_path):
    source = tmp_path / "old.cc"
    source.write_text(OLD)
    assert errors_in(library, source, 7) == []


HEADERS_OF_THEN = """\
#include <gazebo-11/gazebo/gazebo.hh>
#include <gazebo-9/gazebo/physics/physics.hh>
#include <ignition/math4/ignition/math/Vector3.hh>
#include <ignition/math4/ignition/math/SemanticVersion.hh>
auto pose(gazebo::physics::ModelPtr model) { return model->SDFSemanticPose()->RawPose(); }
#if __has_include(<ignition/msgs/material.pb.h>)
gazebo::msgs::Material twice(const gazebo::msgs::Material &material)
{
  using gazebo::msgs::ConvertIgnMsg;
  ignition::msgs::Color color = ConvertIgnMsg(material.ambient());
  return ConvertIgnMsg(ConvertIgnMsg(material));
}
#endif
"""


def test_headers_and_names_of_gazebo_8_to_11_are_there(library, tmp_path):
    source = tmp_path / "then.cc"
    source.write_text(HEADERS_OF_THEN)
    assert errors_in(library, source, 9) == []


def test_records_are_those_of_python():
    """The compiler checks sizes and offsets; each parameter's bounds are within what the engine's joints take."""
    text = shared()
    for record in RECORDS:
        assert f"struct {record.__name__} {{" in text
        assert f"sizeof({record.__name__}) == {ctypes.sizeof(record)}" in text
    for key, bounds in RANGES.items():
        for bound in bounds:
            assert joint_value(PARAMETERS[key], bound) == bound
    record = JointRecord([Axis(GzVector(0.0, 0.0, 1.0))], 1)
    for step, effort in ((3, 1.5), (3, 0.25), (4, -2.0)):
        record.add_effort(effort, 0, SimpleNamespace(steps=step))
    assert (record.efforts_of(3), record.efforts_of(4), record.efforts_of(2)) == ((1.75, 0.0), (-2.0, 0.0), (0.0, 0.0))
    other = JointRecord([], 2)
    other.efforts = record.efforts
    assert (other.applied_at, other.before_at, other.effort(0), other.efforts) == (4, 3, -2.0, record.efforts)
    record.held(7.0, 2, 9)
    assert (record.efforts_of(9), record.efforts_of(8), record.effort(0)) == ((7.0, 0.0), (7.0, 0.0), 7.0)
    record.given = {("vel", 0): 2.0, ("suspension_erp", 1): 0.5}
    assert record.given == {("vel", 0): 2.0, ("suspension_erp", 1): 0.5}
    assert record.parameter("vel", 0) == 2.0
    assert math.isnan(record.parameter("fmax", 0))


def test_the_library_replaces_no_class_of_a_plugin(library):
    """Those who compile a plugin of Gazebo themselves have a class of its name; the linker would take the library's."""
    done = subprocess.run(["nm", "-DC", library.lib / "libgazebo.so"], capture_output=True, text=True, check=True)
    assert "gazebo::ready::WheelSlipPlugin::Load(" in done.stdout
    for name in (name for names in BASE_PLUGINS.values() for name in names):
        assert f" gazebo::{name}::" not in done.stdout


def test_generated_text_has_each_class_once():
    text = headers()["gazebo/libgz/classes.hh"]
    assert text.count("class GAZEBO_VISIBLE Link :") == 1
    assert text.index("class GAZEBO_VISIBLE Entity :") < text.index("class GAZEBO_VISIBLE Link :")
    link = text[text.index("class GAZEBO_VISIBLE Link :") :]
    assert "GetWorldLinearVel" in link[: link.index("}; }")]  # a form of links beside that of all entities
    assert "Link::SetLinearVel(const ignition::math::Vector3d & a0)" in bodies()
    assert {"gazebo/physics/physics.hh", "gazebo/common/common.hh", "gazebo/gazebo.hh"} <= headers().keys()
    assert split("const std::map<std::string, double> &, int = 0") == [
        "const std::map<std::string, double> &",
        "int = 0",
    ]


READS = """
import json
import sys
from pathlib import Path
read = set()
sys.addaudithook(lambda event, values: read.add(values[0]) if event == "open" else None)
from libgz.classic_cxx.generate import bodies, headers
from libgz.classic_cxx.messages import proto_files
headers(), bodies(), proto_files()
from libgz.classic_cxx.library import sources
root = Path(sys.modules["libgz"].__file__).resolve().parent
names = {Path(name).resolve() for name in read if isinstance(name, str)}
tables = {path for path in names if path.is_relative_to(root) and path.suffix not in (".py", ".pyc", ".so")}
print(json.dumps(sorted(str(path) for path in tables - {path.resolve() for path in sources()})))
"""


def test_the_key_depends_on_each_table_that_the_library_is_made_of():
    """It has the declarations of messages as objects."""
    done = subprocess.run([sys.executable, "-P", "-c", READS], capture_output=True, text=True, check=False)
    tables = [Path(path).name for path in json.loads(done.stdout)]
    assert tables == ["messages.txt"], done.stderr


def test_messages_have_the_files_of_classic():
    files = proto_files()
    assert file_of("PosesStamped") == "poses_stamped"
    assert 'import "vector3d.proto";' in files["pose.proto"]
    assert "  required double x = 1;" in files["vector3d.proto"]
    assert len(files) > 125


def test_messages_that_a_plugin_compiles_know_those_of_libgz():
    from google.protobuf.descriptor_pb2 import FileDescriptorProto

    vector = FileDescriptorProto(name="vector3d.proto", package="gazebo.msgs")
    vector.message_type.add(name="Vector3d")
    own = FileDescriptorProto(name="flow.proto", package="my.msgs", dependency=["vector3d.proto"], syntax="proto2")
    field = own.message_type.add(name="Flow").field.add(name="flow", number=1, label=1, type=11)
    field.type_name = ".gazebo.msgs.Vector3d"
    kind = message_type_of("my.msgs.Flow", [vector.SerializeToString(), own.SerializeToString()])
    assert kind(flow=msgs.Vector3d(x=1, y=2, z=3)).flow.y == 2
    assert message_type_of("gazebo.msgs.Vector3d", []) is msgs.Vector3d


def described(name, package, *fields, enum=(), imports=(), public=()):
    """A file with a message, as C++ code describes it."""
    from google.protobuf.descriptor_pb2 import FileDescriptorProto

    file = FileDescriptorProto(
        name=name, package=package, dependency=imports, public_dependency=public, syntax="proto2"
    )
    for kind in enum:
        file.enum_type.add(name=kind).value.add(name="NONE", number=0)
    if fields:
        message = file.message_type.add(name=fields[0])
        for number, (field, kind, type_name) in enumerate(fields[1:], 1):
            message.field.add(name=field, number=number, label=1, type=kind, type_name=type_name)
    return file.SerializeToString()


def test_files_of_messages_share_names_and_import_each_other_publicly():
    flow = described("flow.proto", "one", "Flow", ("x", 1, None), ("kind", 14, ".one.Kind"), enum=["Kind"])
    public = described("public.proto", "one", imports=["flow.proto"], public=[0])
    user = described("user.proto", "one", "User", ("flow", 11, ".one.Flow"), imports=["public.proto"])
    kind = message_type_of("one.Flow", [flow])
    assert message_type_of("one.User", [flow, public, user])(flow=kind(x=2.0)).flow.x == 2.0
    other = described("flow.proto", "two", "Flow", ("y", 1, None))
    assert message_type_of("two.Flow", [other])(y=3.0).y == 3.0
    assert msgs.declare("two.Flow", "double y") is message_type_of("two.Flow", [])  # as Python code declares it
    with pytest.raises(ParameterError, match=r"already a message type 'two\.Flow'"):
        msgs.declare("two.Flow", "double z")
    with pytest.raises(ParameterError, match="message Color of C\\+\\+ has no package, and Gazebo has a Color"):
        message_type_of("Color", [described("color.proto", "", "Color", ("r", 1, None))])
    assert message_type_of("gazebo.msgs.Color", []) is msgs.Color


MESSAGE_PLUGIN = """\
#include "{name}.pb.h"
extern "C" void *libgz_new_plugin() {{ return {package}::Level::descriptor() ? nullptr : nullptr; }}
extern "C" const char *libgz_classic_plugin() {{ return "libgz classic plugin: Model; {key}; {folder};"; }}
"""


def message_plugin(library, place, plugin, package):
    """Compile a plugin with messages of its own, of a file level.proto."""
    folder = place / plugin
    folder.mkdir()
    (folder / "level.proto").write_text(
        f'syntax = "proto2"; package {package}; import "time.proto";'
        "message Level { optional double z = 1; optional gazebo.msgs.Time at = 2; }"
    )
    proto = library.include / "gazebo/msgs/proto"
    subprocess.run(["protoc", f"--cpp_out={folder}", f"-I{folder}", f"-I{proto}", "level.proto"], check=True)
    text = MESSAGE_PLUGIN.format(name="level", package=package, key=library.key, folder=library.lib)
    (folder / "plugin.cc").write_text(text)
    sources = [folder / "plugin.cc", folder / "level.pb.cc"]
    command = [*compiler(), *library.compiler_flags(), "-O0", "-shared", "-o", folder / f"lib{plugin}.so", *sources]
    subprocess.run([*command, *library.linker_flags()], check=True)
    return folder / f"lib{plugin}.so"


def test_two_plugins_with_the_same_file_of_messages_share_it(library, tmp_path):
    first, second = (message_plugin(library, tmp_path, name, "deep") for name in ("first", "second"))
    other = message_plugin(library, tmp_path, "other", "shallow")
    assert set(files_in(first.read_bytes())) == {"level.proto"}
    load(first)
    load(second)
    with pytest.raises(PluginError, match=r"messages of a file level\.proto, and .*libfirst\.so has others"):
        load(other)
    os.utime(second)
    with pytest.raises(PluginError, match="messages of its own, which a process can load only once"):
        load(second)


def test_what_is_missing_is_named_with_the_command(monkeypatch):
    monkeypatch.setenv("PATH", "/nothing")
    monkeypatch.delenv("CXX", raising=False)
    library_module._packages.cache_clear()
    library_module.package_flags.cache_clear()
    try:
        with pytest.raises(LibraryError, match=r"apt-get install g\+\+ pkg-config protobuf-compiler python3-dev"):
            library_module.check_needs()
    finally:
        library_module._packages.cache_clear()
        library_module.package_flags.cache_clear()


def test_sources_of_classic_are_recognised(tmp_path):
    new, old = tmp_path / "new.cc", tmp_path / "old.cc"
    new.write_text(HELLO)
    old.write_text('#include <gazebo/World.hh>\n#include <gazebo/ModelFactory.hh>\nGZ_REGISTER_PLUGIN("A", A)\n')
    assert is_classic([new])
    assert not is_classic([old])
    assert version_flags([new]) == []
    old.write_text("#include <gazebo-7/gazebo/physics/Model.hh>")
    assert is_classic([old])
    new.write_text("math::Pose pose = model->GetWorldPose();")
    assert version_flags([new]) == ["-DGAZEBO_MAJOR_VERSION=7"]
    old.write_text("ignition::math::Vector3d v; // math::Vector3d")
    assert version_flags([old]) == []


def test_installation(library, tmp_path, monkeypatch, capsys):
    cache = library_module.cache_folder()
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache.parents[1]))
    prefix = tmp_path / "prefix"
    assert main(["config", "--install-classic", str(prefix)]) == 0
    assert "export PKG_CONFIG_PATH=" in capsys.readouterr().err
    for spelling in ("gazebo", "GAZEBO", "Gazebo"):
        assert (tmp_path / f".cmake/packages/{spelling}/libgz").read_text() == f"{prefix}/lib/cmake/gazebo\n"
    assert (prefix / "include/gazebo-7/gazebo/gazebo.hh").is_file()
    assert f'LIBGZ_FOLDER "{prefix}/lib"' in (prefix / "include/gazebo-11/gazebo/libgz/config.hh").read_text()
    if shutil.which("pkg-config"):
        env = {**os.environ, "PKG_CONFIG_PATH": str(prefix / "lib/pkgconfig")}
        command = ["pkg-config", "--cflags", "--libs", "gazebo"]
        found = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
        assert f"-I{prefix}/include/gazebo-11" in found.stdout
        assert "-lgazebo" in found.stdout
        assert "-ffp-contract=off" in found.stdout
    cmake = (prefix / "lib/cmake/gazebo/gazebo-config.cmake").read_text()
    assert 'set(GAZEBO_CXX_FLAGS "-std=c++17 -ffp-contract=off")' in cmake
    assert main(["config", "--install-classic", str(prefix), "--uninstall"]) == 0
    assert not prefix.exists()
    assert not list((tmp_path / ".cmake").rglob("libgz"))


def test_a_manifest_removes_only_what_is_as_it_was_written(tmp_path):
    """A prefix may be one of somebody else, or have been unpacked from an archive."""
    (tmp_path / "share" / "libgz").mkdir(parents=True)
    (tmp_path / "written").write_text("a")
    (tmp_path / "mine").write_text("b")
    manifest = tmp_path / library_module.MANIFEST
    Manifest(tmp_path, library_module.MANIFEST).write(["written", "mine"])
    (tmp_path / "mine").write_text("c")
    with manifest.open("a") as file:
        file.write("mine\n")
    assert library_module.uninstall(tmp_path) == [tmp_path / "written", manifest]
    assert [path.name for path in tmp_path.rglob("*")] == ["mine"]


@pytest.mark.trial
def test_the_tutorial_as_typed(library, tmp_path, monkeypatch):
    """cmake ../, make, GAZEBO_PLUGIN_PATH, gzserver hello.world --verbose; then by a Makefile's command."""
    cache = library_module.cache_folder()
    homes = {"HOME": tmp_path, "XDG_CACHE_HOME": cache.parents[1], "XDG_DATA_HOME": tmp_path / ".local/share"}
    env = {**os.environ, "GAZEBO_MASTER_URI": "http://localhost:0", **{name: str(path) for name, path in homes.items()}}
    folder = tmp_path / "gazebo_plugin_tutorial"
    (folder / "build").mkdir(parents=True)
    for name, text in (("hello_world.cc", HELLO), ("CMakeLists.txt", CMAKE), ("hello.world", WORLD)):
        (folder / name).write_text(text)

    def run(command, where):
        done = subprocess.run(command, cwd=where, env=env, capture_output=True, text=True, shell=True, timeout=600)
        assert done.returncode == 0, done.stderr + done.stdout
        return done.stdout

    bin_ = Path(sys.executable).parent
    run(f"{bin_}/libgz config --install-classic", folder)
    run("cmake ../ && make", folder / "build")
    serve = f"GAZEBO_PLUGIN_PATH={folder}/build {bin_}/gzserver hello.world --verbose --iters 10"
    assert run(serve, folder).rstrip().endswith("Hello World!")
    env["PKG_CONFIG_PATH"] = f"{tmp_path}/.local/share/libgz/gazebo-11/lib/pkgconfig"
    run(
        "g++ -shared -fPIC $(pkg-config --cflags gazebo) hello_world.cc -o libhello_world.so "
        "$(pkg-config --libs gazebo)",
        folder,
    )
    assert run(serve.replace("/build ", " "), folder).rstrip().endswith("Hello World!")
