"""32-bit programs: layouts of both ABIs from one declaration, `libgz config --m32`, and servers with --abi i386."""

import ctypes
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from c_programs import COMPILER, compile_c, config, needs_compiler, number_for, run, scalars_of

import libgz
from libgz.base.files import installed_worlds
from libgz.interfaces.catalog import INTERFACES, new_interface
from libgz.interfaces.gripper import GripperDataCvs
from libgz.transport.layout import ABIS, I386, c_name, fields_of, for_abi
from libgz.transport.server import Server


def makes_i386():
    """Whether the compiler makes 32-bit programs, and this machine runs them."""
    if COMPILER is None:
        return False
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder, "check.c"), Path(folder, "check")
        source.write_text("#include <stdlib.h>\nint main(void) { return 0; }\n")
        made = subprocess.run([COMPILER, "-m32", str(source), "-o", str(program)], capture_output=True, check=False)
        return made.returncode == 0 and subprocess.run([str(program)], check=False).returncode == 0


needs_m32 = pytest.mark.skipif(not makes_i386(), reason="gcc -m32 does not work here: apt-get install gcc-multilib")

# Of the original header, compiled for 32-bit PCs.
SIZES = {
    "sim": 180, "camera": 921764, "factory": 4248, "fiducial": 21008, "guicam": 2359604, "gps": 240, "gripper": 212,
    "laser": 5036, "position": 304, "power": 232, "ptz": 200, "sonar": 2856, "stereo": 4300976, "truth": 268,
    "wifi": 764, "joint": 2636, "actarray": 608, "ir": 2856,
}  # fmt: skip


@pytest.fixture(scope="module")
def flags32(tmp_path_factory):
    """The options of a compiler for 32-bit programs."""
    done = config("--m32", XDG_CACHE_HOME=str(tmp_path_factory.mktemp("cache")))
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_sizes_of_32_bit_structs():
    found = {kind: ctypes.sizeof(for_abi(cls.data_class, I386)) for kind, cls in INTERFACES.items()}
    assert found == SIZES
    older = {kind: ctypes.sizeof(for_abi(cls.older[0x050], I386)) for kind, cls in INTERFACES.items() if cls.older}
    assert older == {"camera": 230564, "truth": 252}
    assert ctypes.sizeof(for_abi(GripperDataCvs, I386)) == 192


def assertions(struct, name):
    yield f'_Static_assert(sizeof({name}) == {ctypes.sizeof(struct)}, "{name}");'
    for field, declared in fields_of(struct).items():
        place = getattr(struct, field)
        yield f'_Static_assert(offsetof({name}, {field}) == {place.offset}, "{name}.{field}");'
        yield f'_Static_assert(sizeof((({name} *) 0)->{field}) == {place.size}, "{name}.{field}");'
        if hasattr(declared.ctype, "declared"):
            yield from assertions(declared.ctype, f"{c_name(declared.ctype)}_t")


@pytest.mark.parametrize("version", [0x050, 0x060])
@pytest.mark.parametrize("abi", [ABIS[0], pytest.param(I386, marks=needs_m32)])
@needs_compiler
def test_the_compiler_agrees_on_every_field(tmp_path, abi, version):
    lines = [f"#define LIBGAZEBO_VERSION {version:#05x}", "#include <gazebo.h>"]
    for cls in INTERFACES.values():
        struct = for_abi(cls.older.get(version, cls.data_class), abi)
        lines += dict.fromkeys(assertions(struct, f"{c_name(struct)}_t"))
    lines.append("int main(void) { return 0; }")
    assert len(lines) > 350
    compile_c(tmp_path, "\n".join(lines), *config("--cflags").stdout.split(), *(["-m32"] if abi == I386 else []))


ONE = r"""
static int use_%(type)s(gz_client_t *client)
{
    gz_%(type)s_t *face = gz_%(type)s_alloc();

    if (gz_%(type)s_open(face, client, "%(id)s") != 0)
        return 2;
    if (gz_client_wait(client) != 0 || gz_%(type)s_lock(face, 1) != 0)
        return 3;
    printf("%%x %%lu %%s %%d %%d\n", face->data->head.version, (unsigned long) face->data->head.size,
           face->data->head.model_type, face->data->head.model_id, face->data->head.parent_model_id);
%(body)s
    gz_%(type)s_unlock(face);
    gz_%(type)s_close(face);
    gz_%(type)s_free(face);
    return 0;
}
"""
MAIN = r"""
int main(int count, char **words)
{
    gz_client_t *client = gz_client_alloc();

    if (count != 3 || gz_client_connect_wait(client, atoi(words[1]), 3) != 0)
        return 1;
%(choice)s
    return 9;
}
"""


def paths_of(kind):
    data = INTERFACES[kind].data_class
    return list(scalars_of(data, "S")), list(scalars_of(data, "C"))


@pytest.fixture(scope="module")
def programs(tmp_path_factory, flags32, flags):
    """A program that is a client of every interface, for both ABIs."""
    parts = ["#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n#include <gazebo.h>"]
    for kind in INTERFACES:
        reading, writing = paths_of(kind)
        body = [f'    printf("%.6f\\n", (double) face->data->{path});' for path, _ in reading]
        body += [f"    face->data->{path} = {number_for(i + 50, ctype)};" for i, (path, ctype) in enumerate(writing)]
        parts.append(ONE % {"type": kind, "id": "default" if kind == "sim" else "thing1", "body": "\n".join(body)})
    choice = [f'    if (strcmp(words[2], "{kind}") == 0)\n        return use_{kind}(client);' for kind in INTERFACES]
    text = "\n".join([*parts, MAIN % {"choice": "\n".join(choice)}])
    folder = tmp_path_factory.mktemp("programs")
    return {
        I386: compile_c(folder, text, *flags32, name="narrow"),
        ABIS[0]: compile_c(folder, text, *flags, name="wide"),
    }


@needs_m32
@pytest.mark.parametrize("kind", INTERFACES)
def test_32_bit_clients_read_and_command_every_interface(programs, wire, kind):
    server = Server(wire, abi=I386)
    server.start()
    try:
        served = new_interface(kind)
        served.create(server, "default" if kind == "sim" else "thing1", "Tester", 7, 3)
        assert served.size == SIZES[kind]
        reading, writing = paths_of(kind)
        for i, (path, ctype) in enumerate(reading):
            exec(f"data.{path} = value", {"data": served.data, "value": number_for(i, ctype)})
        server.post()
        lines = run(programs[I386], wire, kind).stdout.splitlines()
        assert lines[0] == f"60 {served.size} Tester 7 3"
        assert [float(line) for line in lines[1:]] == [number_for(i, ctype) for i, (_, ctype) in enumerate(reading)]
        for i, (path, ctype) in enumerate(writing):
            assert eval(f"data.{path}", {"data": served.data}) == number_for(i + 50, ctype), path
        # Clients in Python read both.
        other = new_interface(kind)
        if kind != "sim":
            new_interface("sim").create(server, "default")
        with libgz.Client(wire) as client:
            other.open(client, served.id)
            assert other.get_bytes() == served.get_bytes()
            other.close()
    finally:
        server.stop()


@needs_m32
def test_a_32_bit_client_drives_a_robot(tmp_path, flags32, gazebo):
    source = r"""
#include <stdio.h>
#include <gazebo.h>

int main(int count, char **words)
{
    gz_client_t *client = gz_client_alloc();
    gz_position_t *robot = gz_position_alloc();
    int i;

    if (count != 2 || gz_client_connect_wait(client, atoi(words[1]), 0) != 0)
        return 1;
    if (gz_position_open(robot, client, "robot1") != 0)
        return 2;
    robot->data->cmd_vel_pos[0] = 0.4;
    for (i = 0; i < 3000 && robot->data->pos[0] < 0.5; i++)
        if (gz_client_wait(client) != 0)
            return 3;
    printf("%u %.3f\n", (unsigned) sizeof(void *), robot->data->pos[0]);
    return 0;
}
"""
    program = compile_c(tmp_path, source, *flags32)
    running = gazebo(installed_worlds() / "pioneer2at.world", "--rate", "10", "--abi", "i386")
    size, x = run(program, running.id).stdout.split()
    assert size == "4"
    assert float(x) >= 0.5


@needs_m32
def test_a_client_of_the_other_abi_gets_a_clear_error(programs, wire):
    for abi, other in ((I386, ABIS[0]), (ABIS[0], I386)):
        server = Server(wire, abi=abi)
        server.start()
        try:
            new_interface("position").create(server, "thing1", "Tester")
            errors = run(programs[other], wire, "position", code=2).stderr
            assert f"position.thing1 has the layout of {abi} programs, and this program is one of {other}" in errors
            assert f"start the server {'without' if abi == I386 else 'with'} --abi i386" in errors
        finally:
            server.stop()


@needs_m32
@needs_compiler
def test_an_installation_for_32_bit_programs(tmp_path):
    assert config("--m32", "--install", str(tmp_path)).returncode == 0
    text = (tmp_path / "lib" / "pkgconfig" / "gazebo.pc").read_text()
    assert "Libs: -m32 -L" in text
    assert "Cflags: -m32 -fPIC" in text
    assert (tmp_path / "lib" / "libgazebo.so.0").read_bytes()[4] == 1  # ELFCLASS32


def test_wrong_options_are_explained(tmp_path):
    assert "--m32 excludes --cxxflags" in config("--m32", "--cxxflags").stderr
    fake = tmp_path / "cc"
    fake.write_text("#!/bin/sh\nexit 1\n")
    fake.chmod(0o755)
    done = config("--m32", "--libs", CC=str(fake))
    assert (done.returncode, "apt-get install gcc-multilib" in done.stderr) == (1, True)
    with pytest.raises(libgz.ParameterError, match="ABI is 'arm'; allowed are x86_64, i386"):
        libgz.World(abi="arm")
    command = [sys.executable, "-m", "libgz.apps.gazebo", "--abi", "mips", "pioneer2at"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, "allowed are x86_64, i386" in done.stderr) == (2, True)


def test_a_world_of_32_bit_interfaces_moves_alike():
    states = []
    for abi in ABIS:
        with libgz.World.from_file("pioneer2at", abi=abi) as world:
            world.interface("position", "robot1").command(vx=0.3, vyaw=0.2)
            world.run(2.0)
            state = world.get_state()
            world.run(2.0)
            after = world.interface("position", "robot1").pose
            world.set_state(state)
            world.run(2.0)
            assert world.interface("position", "robot1").pose == after
            with world.clone() as other:
                assert other.gz_server.abi == abi
            states.append((after, world.engine.states.tobytes()))
    assert states[0] == states[1]
