"""Compiling C++ plugins: libgz cxx, libgz config, the headers, and the commands of the old HOWTO."""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from c_programs import config
from commands import run_libgz
from cxx_plugins import needs_cxx, source, world_text

import libgz
from libgz.apps.libgz import main
from libgz.cxx import FOLDER, headers
from libgz.cxx.build import LONGEST_MESSAGE, compiler, cxxflags

pytestmark = needs_cxx

EXAMPLES = Path(__file__).parents[2] / "examples" / "cxx"
NO_PKG_CONFIG = pytest.mark.skipif(shutil.which("pkg-config") is None, reason="pkg-config is not installed")
ALL_HEADERS = sorted(path.name for path in (FOLDER / "include" / "gazebo").glob("*.hh"))


@pytest.fixture
def cxx(tmp_path, monkeypatch, capsys):
    """Runs `libgz cxx` in this process: its exit code, and what it printed."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        code = main(["cxx", *map(str, arguments)])
        return code, *capsys.readouterr()

    return run


def test_generated_headers_are_up_to_date():
    for path, text in headers.generated().items():
        assert (FOLDER / path).read_text() == text, f"run `python -m libgz.cxx.headers`: {path} is out of date"


def test_a_built_plugin_runs(tmp_path):
    (tmp_path / "My.cc").write_text(source("Tester").replace('"Tester"', '"My"'))
    command = [sys.executable, "-m", "libgz.apps.libgz", "cxx", "build", "My.cc", "-o", "My.so"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert (done.returncode, done.stdout) == (0, "My.so: My\n"), done.stderr
    (tmp_path / "w.world").write_text(world_text("My"))
    with libgz.World.from_file(tmp_path / "w.world") as world:
        world.step(3)
        assert world.models[0].GetName() == "My"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["My.cc", "My.so", "w.world"]


def test_several_sources_options_and_symbols(tmp_path, cxx):
    (tmp_path / "inc").mkdir()
    (tmp_path / "inc" / "speed.h").write_text("int speed();\n")
    (tmp_path / "speed.cc").write_text("#include <gazebo/World.hh>\nint speed() { return SPEED; }\n")
    (tmp_path / "My.cc").write_text(
        '#include "speed.h"\n' + source(update="this->body->SetLinearVel( GzVectorSet( speed(), 0, 0 ) );")
    )
    done = cxx("build", "My.cc", "speed.cc", "-I", "inc", "-D", "SPEED=3", "-l", "m", "--debug")
    assert done[0] == 0, done
    assert b".debug_info" in (tmp_path / "My.so").read_bytes()
    (tmp_path / "w.world").write_text(world_text("Tester").replace("Tester.so", "My.so"))
    with libgz.World.from_file(tmp_path / "w.world") as world:
        world.step()
        assert world.models[0].GetBody().GetLinearVel().x == 3.0


def test_libraries_beside_a_plugin_are_found_when_it_is_loaded(tmp_path, cxx):
    (tmp_path / "own, libs").mkdir()
    (tmp_path / "speed.cc").write_text("int speed() { return 3; }\n")
    library = tmp_path / "own, libs" / "libspeed.so"
    subprocess.run([*compiler(), "-shared", "-fPIC", "speed.cc", "-o", library], cwd=tmp_path, check=True)
    (tmp_path / "My.cc").write_text("int speed();\n" + source(update="this->steps += speed();"))
    assert cxx("build", "My.cc", "-L", "own, libs", "-l", "speed") == (0, "My.so: Tester\n", "")


@pytest.mark.parametrize("name", ["@x.cc", "@d/x.cc", "d/@x.cc", "-wrapper.cc"])
@pytest.mark.parametrize("verb", ["build", "check"])
def test_the_name_of_a_source_is_no_option_of_the_compiler(tmp_path, cxx, verb, name):
    """An option can be the name of a program that the compiler runs, or of a file with more options."""
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text(source())
    (tmp_path / "x.cc").write_text("-wrapper touch,stolen\n")
    code, _out, said = cxx(verb, *(["-o", "My.so"] if verb == "build" else []), "--", name)
    assert code == (1 if Path(name).name == "@x.cc" else 0)
    assert ("a name that compilers take for a file with options" in said) == (code == 1)
    assert not (tmp_path / "stolen").exists()


def test_check_explains_what_is_missing_with_its_line(tmp_path, cxx):
    lines = [
        "#include <gazebo/World.hh>",
        "#include <gazebo/ModelFactory.hh>",
        "void f( Body *body ) {",
        "  body->SetPositon( GzVectorSet( 0, 0, 0 ) );",
        "  cout << 3;",
        "  GzVectorAd( 1 );",
        "  BoxGeom *geom;",
        "  gz_position_alloc();",
        "  dJointSetPRAxis1( 0, 0, 0, 0 );",
        "}",
        "class X : public Model { X( World *world ) : Model( world ) {} };",
        'GZ_REGISTER_PLUGIN( "X", X )',
    ]
    (tmp_path / "bad.cc").write_text("\n".join(lines))
    code, printed, _ = cxx("check", "bad.cc")
    assert code == 1
    found = printed.splitlines()
    for line, text in (
        (4, "has no member named 'SetPositon'; did you mean 'SetPosition'"),
        (5, "add `using namespace std;`, or write std::cout"),
        (6, "did you mean 'GzVectorAdd'"),
        (7, "add #include <gazebo/BoxGeom.hh>"),
        (9, "apt-get install libode-dev"),
        (12, "a model must define int Load(WorldFile *, WorldFileNode *)"),
    ):
        assert any(row.startswith(f"bad.cc:{line}: ") and text in row for row in found), (line, text, found)
    (tmp_path / "gone.cc").write_text("#include <gazebo/Wrld.hh>\n")
    assert (
        "gone.cc:1: gazebo/Wrld.hh: No such file or directory; did you mean 'World.hh'"
        in cxx("check", tmp_path / "gone.cc")[1]
    )
    (tmp_path / "gone.cc").write_text("#include <libxml/parser.h>\n#include <GL/glut.h>\n")
    (tmp_path / "good.cc").write_text(source())
    assert cxx("check", "good.cc")[1] == "good.cc: no errors\n"


def test_wrong_commands_are_explained(tmp_path, cxx, monkeypatch):
    assert "there is no file 'gone.cc'" in cxx("build", "gone.cc")[2]
    (tmp_path / "My.cc").write_text(source())
    assert "ends with .so, and 'My.o' does not" in cxx("build", "My.cc", "-o", "My.o")[2]
    (tmp_path / "Empty.cc").write_text("#include <gazebo/ModelFactory.hh>\n")
    assert "registers nothing" in cxx("build", "Empty.cc")[2]
    monkeypatch.setenv("CXX", "no-such-compiler")
    code, _, errors = cxx("check", "My.cc")
    assert code == 1
    assert "the compiler 'no-such-compiler', named by CXX, is not installed" in errors


def test_config_prints_the_options(tmp_path):
    assert config("--cxxflags").stdout == f"{shlex.join(cxxflags())}\n"  # with which the headers are compiled below
    assert {"-fPIC", "-fpermissive"} <= set(cxxflags())
    assert "--install excludes" in config("--install", str(tmp_path), "--cxxflags").stderr


@pytest.mark.parametrize(
    "standard", ["c++98", *(pytest.param(f"c++{year}", marks=pytest.mark.trial) for year in (11, 14, 17)), "c++20"]
)
def test_headers_compile_without_warnings(tmp_path, standard):
    text = "".join(f"#include <gazebo/{name}>\n" for name in ALL_HEADERS)
    (tmp_path / "all.cc").write_text("#include <gazebo.h>\n" + text + source())
    command = ["c++", f"-std={standard}", "-Wall", "-Werror", "-fsyntax-only", *cxxflags(), str(tmp_path / "all.cc")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("names", [["SliderJoint.hh"], pytest.param(ALL_HEADERS, marks=pytest.mark.trial)], ids=len)
def test_headers_compile_alone_without_headers_of_ode_and_opengl(tmp_path, names):
    folder = tmp_path / "fallback"  # as if there were no others
    for path in (FOLDER / "fallback").rglob("*.h"):
        copy = folder / path.relative_to(FOLDER / "fallback")
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(path.read_text().replace("defined( __has_include_next )", "0"))
    for name in names:
        (tmp_path / f"{name}.cc").write_text(f"#include <gazebo/{name}>\n")
    sources = [str(tmp_path / f"{name}.cc") for name in names]
    command = ["c++", "-std=c++98", "-Wall", "-Werror", "-fsyntax-only", f"-I{folder}", *cxxflags(), *sources]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


HOWTO = """
g++ -Wall -g3 `pkg-config --cflags gazebo` -c ExampleModel.cc
g++ -shared -nostartfiles -o ExampleModel.so ExampleModel.o
"""


@NO_PKG_CONFIG
@pytest.mark.parametrize("way", ["howto", pytest.param("make", marks=pytest.mark.trial)])
def test_the_commands_of_the_howto(tmp_path, gazebo, way):
    prefix, folder = tmp_path / "local", tmp_path / "fresh"
    assert config("--install", str(prefix)).returncode == 0
    folder.mkdir()
    for name in ("ExampleModel.cc", "ExampleModel.hh", "example.world", *(("Makefile",) if way == "make" else ())):
        shutil.copy(EXAMPLES / name, folder)
    if way == "make":
        shutil.copy(EXAMPLES / "LiftScanner.cc", folder)
    environment = {**os.environ, "PKG_CONFIG_PATH": str(prefix / "lib" / "pkgconfig")}
    script = HOWTO if way == "howto" else "make"
    for command in filter(None, script.splitlines()):
        done = subprocess.run(
            ["sh", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
    server = gazebo(folder / "example.world", "--rate", "5")
    with libgz.Client(server.id, timeout=10.0) as client:
        robot = client.position("robot1")
        robot.command(vx=0.2)
        while robot.pose[0] < 0.2:
            client.wait(timeout=5.0)
    code, _, errors = server.stop()
    assert (code, errors.count("error")) == (0, 0), errors


def test_lines_of_any_length_are_read_at_once(tmp_path):
    """Compilers show lines of sources, and names in messages, as they are."""
    fake, file = tmp_path / "compiler", tmp_path / "a.cc"
    (tmp_path / "output").write_text(f"{file}:1:2: error: {400_000 * 'a'}\n{400_000 * 'b '}\n")
    fake.write_text(f"#!/bin/sh\ncat {tmp_path}/output >&2\nexit 1\n")
    fake.chmod(0o755)
    file.write_text("int x;\n")
    done = run_libgz("cxx", "check", file, env={**os.environ, "CXX": str(fake)}, timeout=60)
    assert done.returncode == 1
    assert done.stdout == f"{file}:1: {LONGEST_MESSAGE * 'a'}\n"
