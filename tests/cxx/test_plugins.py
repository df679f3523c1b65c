"""C++ plugins in worlds: how they are found, loaded, called and ended, and how their errors are reported."""

import gc
import logging
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from cxx_plugins import MODEL, compiled, load, needs_cxx, source, world_text

import libgz
from libgz.base.errors import PluginError, WorldFileError
from libgz.cxx.headers import mark
from libgz.cxx.model import CxxModel
from libgz.cxx.objects import OBJECTS

pytestmark = needs_cxx

PYTHON = """
from libgz import GZ_REGISTER_PLUGIN, Body, Model, SphereGeom

class NAME(Model):
    STATE = ()

    def Load(self, file, node):
        body = Body(self.world)
        SphereGeom(body, self.modelSpaceId, 0.1).SetMass(1.0)
        self.AddBody(body, True)

GZ_REGISTER_PLUGIN("NAME", NAME)
"""


INTRUDER = """
#include <gazebo/Body.hh>
static void *intrude( void *world )
{
  new Body( (World *) world );
  return NULL;
}
"""

# What the models of one plugin do, by the attribute `case`: method -> code. It is compiled once for all tests.
CASES = {}


def case(name, **code):
    """Add a case; returns its name."""
    assert name not in CASES
    CASES[name] = code
    return name


def code_of(method):
    """What all cases do in a method."""
    return "".join(
        f'if ( this->kind == "{name}" ) {{ {code[method]} }}\n' for name, code in CASES.items() if method in code
    )


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """A compiled plugin, which does nothing without a case."""
    load_ = f'this->kind = node->GetString( "case", "" ); this->out = node->GetString( "out", "" ); {code_of("load")}'
    text = source(load=load_, init=code_of("init"), update=code_of("update"), fini=code_of("fini"))
    text = text.replace("public: int steps;", "public: int steps; std::string kind, out; gz_position_t *iface;")
    includes = "#include <stdexcept>\n#include <string>\n#include <pthread.h>\n#include <gazebo/Camera.hh>\n"
    return compiled(tmp_path_factory.mktemp("plain"), text=includes + INTRUDER + text)


@pytest.fixture(autouse=True)
def handles():
    """The handles before a test, such as those of objects at file scope; it leaves no others."""
    before = set(OBJECTS)
    yield before
    assert set(OBJECTS) <= before


@pytest.fixture
def world_of(tmp_path, plain):
    """Loads a world of models of that plugin, by their cases."""

    def load_cases(*cases, more="", **options):
        shutil.copy(plain, tmp_path)
        return load(tmp_path, *(("Tester", f"<case>{name}</case>{more}") for name in cases), **options)

    return load_cases


def test_a_shared_object_comes_before_a_python_file(tmp_path, plain, caplog):
    caplog.set_level("INFO")
    shutil.copy(plain, tmp_path)
    (tmp_path / "Tester.py").write_text(PYTHON.replace("NAME", "Tester"))
    with load(tmp_path, "Tester") as world:
        assert isinstance(world.models[0], CxxModel)
    assert "plugin 'Tester.so': Tester.so is used, not Tester.py beside it" in caplog.text
    text = world_text("Tester").replace("Tester.so", "Tester.py")
    (tmp_path / "python.world").write_text(text)
    with libgz.World.from_file(tmp_path / "python.world") as world:
        assert not isinstance(world.models[0], CxxModel)


def test_a_shared_object_that_is_no_plugin_is_passed_over(tmp_path):
    (tmp_path / "Tester.so").write_bytes(b"\x7fELF" + bytes(100))
    with pytest.raises(WorldFileError, match=r"this file is no C\+\+ plugin of libgz, so build its source with"):
        load(tmp_path, "Tester")
    (tmp_path / "Tester.py").write_text(PYTHON.replace("NAME", "Tester"))
    with load(tmp_path, "Tester") as world:
        assert not isinstance(world.models[0], CxxModel)


def test_a_plugin_for_another_libgz_is_refused_with_both_versions(tmp_path, plain):
    data = plain.read_bytes()
    own = mark().encode()
    assert own in data
    (tmp_path / "Tester.so").write_bytes(data.replace(own, own.replace(b"libgz 0.1.0", b"libgz 0.0.9")))
    with pytest.raises(
        WorldFileError, match=r"needs libgz 0\.0\.9, interface \w+, and this is libgz 0\.1\.0, interface"
    ):
        load(tmp_path, "Tester")


def test_only_a_source_is_explained(tmp_path):
    (tmp_path / "Tester.cc").write_text(source())
    with pytest.raises(WorldFileError, match=r"Tester.cc is C\+\+ source: build it, `libgz cxx build .*/Tester.cc`"):
        load(tmp_path, "Tester")


ERRORS = {
    'throw std::runtime_error( "no battery" );': "Load of model 'm0' threw std::runtime_error: no battery",
    "throw 7;": "Load of model 'm0' threw int",
    'throw "text";': r"Load of model 'm0' threw char const\*: text",
    "return -1;": "Load of model 'm0' returned -1, which is not 0",
    "geom->SetMass( -1 );": r"Load of model 'm0': mass \[kg\] of SphereGeom 1 .* must not be negative",
    "new BoxGeom( this->body, this->modelSpaceId, -1, 1, 1 );": "Load of model 'm0': box length",
    "new Body( NULL );": "Load of model 'm0': a Body needs its model's world, not NULL",
    "INIT return 3;": "Init of model 'm0' returned 3",
    "this->SetId( NULL );": "Load of model 'm0': SetId needs a text, not NULL",
    'INIT throw std::runtime_error( "later" );': "Init of model 'm0' threw std::runtime_error: later",
}


for number, (code, _message) in enumerate(ERRORS.items()):
    case(f"error {number}", **({"init": code[5:]} if code.startswith("INIT") else {"load": code}))


@pytest.mark.parametrize("number", range(len(ERRORS)))
def test_errors_name_plugin_method_and_model(tmp_path, world_of, number):
    with pytest.raises((WorldFileError, PluginError)) as caught:
        world_of(f"error {number}")
    message = list(ERRORS.values())[number]
    assert re.search(f"plugin {re.escape(str(tmp_path))}/Tester.so: {message}", str(caught.value))


NAN = case("NaN", update="if ( this->steps == 3 ) this->body->SetLinearVel( GzVectorSet( 0, 0, NAN ) );")


def test_an_error_in_update_stops_the_model(tmp_path, world_of, caplog):
    with world_of(NAN, NAN) as world:
        world.step(5)
        assert "Update of model 'm0': linear velocity [m/s]" in str(world.models[0].error)
    assert "model 'm0' stopped, its motors off" in caplog.text
    assert f"plugin {tmp_path}/Tester.so: Update of model 'm1'" in caplog.text


MARKER = "struct Note { Geom *geom; ~Note() { geom->SetFiducial( 5 ); } } note = { geom };"
MARKS = case("marks", update=f"Geom *geom = this->body->GetGeoms()[0]; {MARKER} geom->SetMass( -1 );")


THREAD = "pthread_t other; pthread_create( &other, NULL, intrude, this->world ); pthread_join( other, NULL );"
INTRUDES = case("intrudes", update=THREAD)


def test_threads_that_create_objects_are_refused(world_of, caplog):
    with world_of(INTRUDES) as world:
        world.step()
        assert world.models[0].error is None
    assert "a call of a plugin's own thread failed: threads of a plugin cannot create objects" in caplog.text


@pytest.mark.parametrize("what", ["throw 5;", "return -2;"])
def test_errors_at_the_end_are_one_line(tmp_path, what, caplog):
    compiled(tmp_path, fini=what)
    load(tmp_path, "Tester").close()
    message = caplog.records[-1].getMessage()
    assert message.startswith("Fini of model 'm0' failed with\nlibgz.base.errors.PluginError: plugin /")
    assert message.count("\n") == 1


def test_another_name_than_the_world_s_is_reported(tmp_path, caplog):
    compiled(tmp_path, text=source().replace('GZ_REGISTER_PLUGIN( "Tester"', 'GZ_REGISTER_PLUGIN( "Taster"'))
    with load(tmp_path, "Tester") as world:
        assert not world.models
    assert "unknown model class, skipped with all that is in it; its plugin has Taster" in caplog.text


def test_objects_are_destroyed_when_an_exception_passes(world_of):
    with world_of(MARKS) as world:
        world.step()
        assert world.models[0].GetBody().geoms[0].GetFiducial() == 5


def test_what_nothing_defines_is_named(tmp_path):
    compiled(tmp_path, text="extern int lost_function();\n" + source(update="lost_function();"))
    with pytest.raises(WorldFileError, match=r"nothing defines _Z13lost_functionv; link the file or library that does"):
        load(tmp_path, "Tester")


def test_functions_of_opengl_need_no_library(tmp_path, caplog):
    caplog.set_level("INFO")
    text = 'extern "C" void gluSurely( unsigned );\n' + source().replace(
        "public: Body *body;",
        "public: virtual void Render( int, RenderOptions * ) { gluSurely( 1 ); } public: Body *body;",
    )
    compiled(tmp_path, text=text)
    with load(tmp_path, "Tester") as world:
        world.step()
    assert "renders with gluSurely: its Render is never called" in caplog.text


def test_two_plugins_with_several_instances_and_python_models(tmp_path):
    # Both define a class of the same name, as HMT_RED and HMT_BLUE did.
    for name, speed in (("Red", 1), ("Blue", 2)):
        text = source("HMT", update=f"this->body->SetLinearVel( GzVectorSet( {speed}, 0, 0 ) );")
        compiled(tmp_path, name, text=text.replace('"HMT"', f'"{name}"'))
    (tmp_path / "Green.py").write_text(PYTHON.replace("NAME", "Green"))
    more = [(name, f"<xyz>0 {y} 10</xyz>") for y, name in enumerate(["Red", "Blue", "Green", "Red", "Blue", "Green"])]
    with load(tmp_path, *more) as world:
        world.step(10)
        speeds = [model.GetBody().GetLinearVel().x for model in world.models]
        assert speeds == [1.0, 2.0, 0.0, 1.0, 2.0, 0.0]
        world.DeleteModel("m0")
        world.step(10)
        assert len(world.models) == 5


CHILD = case(
    "child",
    init='if ( this->parent == NULL || this->parentBody == NULL || strcmp( this->parent->GetId(), "base" ) ) return -1;'
    "if ( this->joint == NULL || this->parent->GetBody() != this->parentBody ) return -2;",
)


def test_the_parent_and_children(tmp_path, plain):
    shutil.copy(plain, tmp_path)
    text = world_text(("Tester", "<case>child</case><xyz>0 0 1</xyz>")).replace(
        "<model:Tester>", "<model:SimpleSolid><id>base</id><shape>box</shape><model:Tester>", 1
    )
    (tmp_path / "w.world").write_text(text.replace("</model:Tester>", "</model:Tester></model:SimpleSolid>"))
    with libgz.World.from_file(tmp_path / "w.world") as world:
        child = world.model("m0")
        assert child.welded is not None
        assert child.relPose.pos.z == child.initPose.pos.z == 1.0
        world.step(3)


def test_states_say_what_they_keep(tmp_path, plain, caplog):
    shutil.copy(plain, tmp_path)
    with load(tmp_path, ("Tester", "<xyz>0 0 5</xyz>")) as world:
        world.step(10)
        state = world.get_state()
        assert "states and resets keep its bodies, joints, sensors and interfaces" in caplog.text
        assert f"C++ plugin {tmp_path}/Tester.so" in caplog.text
        world.step(10)
        after = world.engine.states.tobytes()
        world.set_state(state)
        world.step(10)
        assert world.engine.states.tobytes() == after
        world.Reset()
        assert world.models[0].GetPose().pos.z == 5.0
        with world.clone() as other:
            other.step(10)
            assert isinstance(other.models[0], CxxModel)
        world.DeleteModel("m0")
        world.set_state(state)  # which builds the model again
        world.step(10)
        assert world.engine.states.tobytes() == after


CRASHES = {
    "null": ("*(volatile int *) 0 = 1;", "SIGSEGV", -11),
    "abort": ("abort();", "SIGABRT", -6),
    "recursion": (
        "this->steps = 3; volatile char pad[1000]; pad[0] = 1; this->Update( step + 1 ); pad[1] = pad[0];",
        "SIGSEGV",
        -11,
    ),
    "exit": ("exit( 5 );", "exit() was called", 5),
}


for name, (code, _what, _exit) in CRASHES.items():
    case(name, update=f"if ( this->steps == 4 ) {{ {code} }}")

# One process that forks for each world, as a start of Python takes most of the time.
CRASHING = """
import os, sys, libgz
from libgz.cxx import model, plugin
for path in sys.argv[1:]:
    output = os.open(path + ".err", os.O_CREAT | os.O_WRONLY)
    child = os.fork()
    if child == 0:
        os.dup2(output, 2)
        with libgz.World.from_file(path) as world:
            world.step(50)
            if "elsewhere" in path:
                import ctypes
                ctypes.string_at(0)
        os._exit(0)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.fixture(scope="module")
def crashes(tmp_path_factory, plain):
    """What each case printed, and its exit code; and the plugin's path."""
    folder = tmp_path_factory.mktemp("crashes")
    path = shutil.copy(plain, folder)
    worlds = [folder / f"{name}.world" for name in (*CRASHES, "elsewhere")]
    for world in worlds:
        world.write_text(world_text(("Tester", f"<case>{world.stem}</case>")))
    command = [sys.executable, "-c", CRASHING, *map(str, worlds)]
    environment = {**os.environ, "TMPDIR": str(folder)}  # where crashes leave files
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env=environment)
    copies = [path.name for path in folder.iterdir() if path.is_dir()]
    assert len(copies) <= 1, copies  # that of the last one: each one removes what the one before left
    errors = [world.with_name(f"{world.name}.err").read_text() for world in worlds]
    codes = [int(line) for line in done.stdout.split()]
    return dict(zip((*CRASHES, "elsewhere"), zip(errors, codes, strict=True), strict=True)), path


@pytest.mark.parametrize("name", CRASHES)
def test_the_last_line_after_a_crash_names_plugin_and_method(crashes, name):
    (errors, code), path = crashes[0][name], crashes[1]
    _, what, exit_code = CRASHES[name]
    last = errors.strip().splitlines()[-1]
    assert last.startswith(f"error   : {what} in Update of model 'm0', plugin {path}")
    assert code == exit_code


def test_a_crash_elsewhere_names_no_plugin(crashes):
    errors, code = crashes[0]["elsewhere"]
    assert code == -11
    assert "plugin" not in errors


MESSAGES = case("messages", load='PRINT_ERR1( "bad %d", 3 ); PRINT_MSG0( 5, "detail" );')


def test_messages_have_the_place_in_the_source(world_of, caplog):
    caplog.set_level(logging.DEBUG)
    world_of(MESSAGES).close()
    records = {record.getMessage(): record for record in caplog.records if record.name == "libgz.plugin"}
    assert (records["bad 3"].levelno, records["detail"].levelno) == (logging.ERROR, logging.DEBUG)
    assert records["bad 3"].filename == "Tester.cc"


CAMERA = """
  int width, height;
  if ( this->steps != 2 ) return;
  Camera camera( this->world );
  if ( camera.Init( 64, 48, 1.0, 0.1, 20, "GLX", 24 ) != 0 ) return;
  camera.SetPose( GzPoseSet( GzVectorSet( -2, 0, 0.5 ), GzQuaternIdent() ) );
  camera.SetSavePath( ( this->out + "/saved" ).c_str() ); camera.EnableSaveFrame( true );
  camera.Update(); camera.GetImageSize( &width, &height );
  const unsigned char *image = camera.GetImageData();
  FILE *file = fopen( ( this->out + "/image.raw" ).c_str(), "wb" );
  fwrite( image, 3, width * height, file ); fclose( file );
  double z = camera.GetZValue( 32, 10 );
  GzPose moved = camera.CalcCameraDelta( 0, GzVectorSet( 10, 10, 0.5 ), GzVectorSet( 10, 10, 0.5 ) );
  this->world->simSpeed = z; this->world->fogDensity = GzVectorMag( moved.pos ) + 1;
  camera.Fini();
"""


case("camera", update=CAMERA)


def test_a_camera_s_image_has_its_bottom_row_first(tmp_path, plain):
    shutil.copy(plain, tmp_path)
    path = tmp_path / "w.world"
    ground = "<model:GroundPlane><id>g</id><color>0 1 0</color></model:GroundPlane>"
    more = f"<case>camera</case><out>{tmp_path}</out><xyz>5 5 5</xyz>"
    light = "<model:LightSource><id>l</id><xyz>0 0 5</xyz></model:LightSource>"
    path.write_text(world_text(("Tester", more)).replace("</gz:world>", f"{ground}{light}</gz:world>"))
    with libgz.World.from_file(path) as world:
        world.step(3)
        assert 0.9 < world.simSpeed <= 1.0
        assert world.fogDensity == 1.0
    data = (tmp_path / "image.raw").read_bytes()
    rows = [data[i * 192 : (i + 1) * 192] for i in range(48)]
    assert rows[0][1] > 2 * rows[0][2]  # green ground
    assert rows[47][2] > rows[47][1]  # blue sky
    saved = (tmp_path / "saved" / "0000.pnm").read_bytes()
    assert saved.startswith(b"P6\n# Gazebo\n64 48\n255\n")
    assert saved.endswith(rows[0])


INTERFACE_INIT = """
  this->iface = gz_position_alloc();
  gz_server_t *server = this->world->gz_server;
  if ( gz_position_create( this->iface, server, this->GetId(), "Tester", (int) (long) this, 0 ) != 0 ) return -1;
  if ( gz_position_create( gz_position_alloc(), server, "a.b", "Tester", 1, 0 ) != -1 ) return -2;
"""
INTERFACE_UPDATE = """
  if ( gz_position_lock( this->iface, 1 ) != 0 ) return;
  this->iface->data->time = this->world->GetSimTime();
  this->iface->data->pos[0] += this->iface->data->cmd_vel_pos[0];
  gz_position_unlock( this->iface ); gz_position_post( this->iface );
"""
INTERFACE_FINI = "gz_position_destroy( this->iface ); gz_position_free( this->iface );"


SERVES = case("serves", init=INTERFACE_INIT, update=INTERFACE_UPDATE, fini=INTERFACE_FINI)


def test_interfaces_are_those_of_the_world(world_of, capfd):
    with world_of(SERVES) as world:
        robot = world.interface("position", "m0")
        assert robot.data.head.model_id == world.models[0].GetIntId()
        assert robot.data.head.model_type == b"Tester"
        robot.command(vx=0.5)
        world.step(4)
        assert (robot.pose[0], robot.data.time) == (2.0, pytest.approx(0.06))
        world.DeleteModel("m0")
        assert ("position", "m0") not in world.gz_server.interfaces
    assert "invalid id [a.b]" in capfd.readouterr().err


def test_clients_reach_them(world_of, wire):
    with world_of(SERVES, server_id=wire) as world, libgz.Client(wire) as client:
        robot = client.position("m0")
        robot.command(vx=0.25)
        world.step(4)
        assert robot.pose[0] == 1.0
        assert client.wait(timeout=5.0)


@pytest.mark.parametrize("abi", ["x86_64", "i386"])
def test_plugins_serve_32_bit_clients(world_of, abi):
    with world_of(SERVES, abi=abi) as world:
        robot = world.interface("position", "m0")
        assert robot.size == {"x86_64": 312, "i386": 304}[abi]
        robot.command(vx=0.5)
        world.step(4)
        assert (robot.pose[0], robot.data.time) == (2.0, pytest.approx(0.06))
        robot.command(vx=0.25)
        world.step(4)
        assert robot.pose[0] == 3.0


@pytest.fixture(scope="module")
def older(tmp_path_factory):
    """A plugin of the same name, compiled for interfaces of version 0x050."""
    text = source(init=INTERFACE_INIT.replace("position", "truth").partition("if ( gz_truth_create( gz_truth")[0])
    text = text.replace("public: int steps;", "public: int steps; gz_truth_t *iface;")
    return compiled(tmp_path_factory.mktemp("older"), text="#define LIBGAZEBO_VERSION 0x050\n" + text)


def test_another_version_of_the_structs_is_refused(tmp_path, older, capfd):
    shutil.copy(older, tmp_path)
    with pytest.raises(PluginError, match="Init of model 'm0' returned -1"):
        load(tmp_path, "Tester")
    assert (
        "truth of version 0x050, and the server's interfaces are of 0x060; compile it with -DLIBGAZEBO_VERSION=0x060"
        in (capfd.readouterr().err)
    )
    with load(tmp_path, "Tester", wire_version=0x050) as world:
        assert world.interface("truth", "m0").size == 264


def loaded_files():
    """The files of plugins in this process's memory."""
    return {line.split()[5] for line in Path("/proc/self/maps").read_text().splitlines() if "libgz-plugin" in line}


@pytest.mark.parametrize("way", ["new file", "in place"])
def test_a_rebuilt_file_is_used_by_worlds_loaded_later(tmp_path, plain, older, way):
    shutil.copy(plain, tmp_path)
    before = loaded_files()
    with load(tmp_path, ("Tester", "<case>serves</case>")) as first:
        # The worlds of the old version run on.
        if way == "new file":
            Path(shutil.copy(older, tmp_path / "next.so")).replace(tmp_path / "Tester.so")
        else:
            shutil.copy(older, tmp_path)
        with load(tmp_path, "Tester", wire_version=0x050) as second:
            for world in (first, second):
                world.step(4)
            assert ("position", "m0") in first.gz_server.interfaces
            assert ("truth", "m0") in second.gz_server.interfaces
        assert len(loaded_files() - before) == 2
    del first, second, world
    shutil.copy(plain, tmp_path)
    load(tmp_path, "Tester").close()
    gc.collect()
    assert len(loaded_files() - before) == 1  # what no world uses was unloaded


STATIC = """
struct Note { Note() : left( NULL ) {} ~Note() { if ( left ) fputs( left, stderr ); } const char *left; };
static Note note; // destroyed when the file is unloaded, or at the end
static WorldFile own; // made before there is any model
inline int counted() { static int count = 0; return ++count; } // one for each file, not for the process
"""


def test_objects_at_file_scope(tmp_path):
    text = (
        "#include <gazebo.h>\n#include <gazebo/WorldFile.hh>\n"
        + STATIC
        + source(
            load='note.left = "end"; own.LoadString( "<a><b>3</b></a>" );'
            'this->steps = own.GetRootNode()->GetInt( "b", 0 );',
            update="this->world->fogDensity = this->steps + counted();",
        )
    )
    first = compiled(tmp_path, text=text)
    (tmp_path / "other").mkdir()
    shutil.copy(first, tmp_path / "other")
    code = (
        f"import sys\nsys.path.insert(0, {str(Path(__file__).parents[1])!r})\n"
        "from pathlib import Path\nfrom cxx_plugins import load\n"
        f"for folder in ({str(tmp_path)!r}, {str(tmp_path / 'other')!r}):\n"
        "    with load(Path(folder), 'Tester') as world:\n"
        "        world.step()\n        print(world.fogDensity)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False)
    assert (done.returncode, done.stdout) == (0, "5.0\n5.0\n"), done.stderr
    assert done.stderr.endswith("endend")


def test_the_model_template_has_no_leftovers():
    assert "NAME" not in source()
    assert "LOAD" in MODEL


@pytest.mark.trial
@pytest.mark.parametrize(("way", "count"), [("the same file", 1000), ("rebuilt files", 300)])
def test_a_thousand_loads_leave_nothing(tmp_path, plain, way, count, handles):
    resource = pytest.importorskip("resource")
    shutil.copy(plain, tmp_path)
    sizes, objects, before = [], [], loaded_files()
    for i in range(count):
        if way == "rebuilt files":
            os.utime(tmp_path / "Tester.so", ns=(i, i))
        with load(tmp_path, ("Tester", "<case>serves</case>"), "Tester") as world:
            world.step(2)
        assert set(OBJECTS) <= handles
        if (i + 1) % (count // 20) == 0:
            # A closed world is a cycle. Those that a collection met while they were open wait for a full one, which
            # comes the later the more objects the tests before have left.
            del world
            gc.collect()
            sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
            objects.append(len(gc.get_objects()))
    assert sizes[-1] - sizes[3] < 4096  # [kB]
    assert objects[-1] - objects[3] < 10
    assert len(loaded_files() - before) < 10
