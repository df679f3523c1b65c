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
from libgz.base.errors import LibraryError
from libgz.base.geometry import GzVector
from libgz.classic import msgs
from libgz.classic.api import classic_api
from libgz.classic_cxx.generate import bodies, headers
from libgz.classic_cxx.layouts import RECORDS, shared
from libgz.classic_cxx.messages import file_of, proto_files
from libgz.classic_cxx.recognition import is_classic, version_flags
from libgz.classic_cxx.table import rows, split
from libgz.classic_cxx.values import message_type_of
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
    assert len(missing) < 260, missing
    assert {"physics::Link::WorldPose", "physics::Entity::WorldPose"} & declared
    assert sum(row.kind == "method" for row in rows()) > 2300


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


def test_what_is_missing_is_named_with_the_command(monkeypatch):
    monkeypatch.setenv("PATH", "/nothing")
    monkeypatch.delenv("CXX", raising=False)
    library_module._packages.cache_clear()
    library_module._package_flags.cache_clear()
    try:
        with pytest.raises(LibraryError, match=r"apt-get install g\+\+ pkg-config protobuf-compiler python3-dev"):
            library_module.check_needs()
    finally:
        library_module._packages.cache_clear()
        library_module._package_flags.cache_clear()


def test_sources_of_classic_are_recognised(tmp_path):
    new, old = tmp_path / "new.cc", tmp_path / "old.cc"
    new.write_text(HELLO)
    old.write_text('#include <gazebo/World.hh>\n#include <gazebo/ModelFactory.hh>\nGZ_REGISTER_PLUGIN("A", A)\n')
    assert is_classic([new])
    assert not is_classic([old])
    assert version_flags([new]) == []
    new.write_text("math::Pose pose = model->GetWorldPose();")
    assert version_flags([new]) == ["-DGAZEBO_MAJOR_VERSION=7"]
    old.write_text("ignition::math::Vector3d v; // math::Vector3d")
    assert version_flags([old]) == []


def test_installation(library, tmp_path, monkeypatch, capsys):
    cache = library_module.cache_folder()
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(library_module, "cache_folder", lambda: cache)
    prefix = tmp_path / "prefix"
    assert main(["config", "--install-classic", str(prefix)]) == 0
    assert "export PKG_CONFIG_PATH=" in capsys.readouterr().err
    assert (tmp_path / ".cmake/packages/gazebo/libgz").read_text() == f"{prefix}/lib/cmake/gazebo\n"
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
    assert not (tmp_path / ".cmake/packages/gazebo/libgz").exists()


@pytest.mark.trial
def test_the_tutorial_as_typed(library, tmp_path, monkeypatch):
    """cmake ../, make, GAZEBO_PLUGIN_PATH, gzserver hello.world --verbose; then by a Makefile's command."""
    cache = library_module.cache_folder()
    homes = {"HOME": tmp_path, "XDG_CACHE_HOME": cache.parents[1], "XDG_DATA_HOME": tmp_path / ".local/share"}
    env = {**os.environ, **{name: str(path) for name, path in homes.items()}}
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
