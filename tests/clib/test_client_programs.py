"""The C header and library, and C programs that are clients."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from c_programs import COMPILER, WARNINGS, compile_c, config, needs_compiler, number_for, run, scalars_of
from wire_layout import LAYOUT

import libgz
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzQuaternFromEuler
from libgz.clib import FOLDER, header, library
from libgz.interfaces.catalog import INTERFACES, new_interface
from libgz.interfaces.gripper import Gripper
from libgz.transport.server import Server

# Generated files ------------------------------------------------------------------------------------------------


def test_the_generated_files_are_up_to_date():
    again = "run `python -m libgz.clib.header`"
    assert (FOLDER / "gazebo.h").read_text() == header.header(), again
    assert (FOLDER / "interfaces.def").read_text() == header.interface_list(), again


def structs_and_variants():
    names = [name for name, entry in LAYOUT.items() if isinstance(entry, dict) and "fields" in entry]
    return [name for name in names if name != "gz_gripper_data_cvs"]


def c_assertions(name, entry):
    yield f'_Static_assert(sizeof({name}) == {entry["size"]}, "{name}");'
    yield f'_Static_assert(_Alignof({name}) == {entry["align"]}, "{name}");'
    for field, (offset, size, _) in entry["fields"].items():
        yield f'_Static_assert(offsetof({name}, {field}) == {offset}, "{name}.{field}");'
        yield f'_Static_assert(sizeof((({name} *) 0)->{field}) == {size}, "{name}.{field}");'


@needs_compiler
def test_struct_layouts_in_c(tmp_path, flags):
    lines = ["#include <gazebo.h>"]
    for name in structs_and_variants():
        lines += c_assertions(LAYOUT[name]["typedef"], LAYOUT[name])
    lines += [f'_Static_assert({name} == {value}, "{name}");' for name, value in LAYOUT["_macros"].items()]
    lines.append("int main(void) { return 0; }")
    compile_c(tmp_path, "\n".join(lines), *flags)
    assert len(lines) > 500
    later = ["#define GAZEBO_GRIPPER_CVS", "#include <gazebo.h>"]
    later += [*c_assertions("gz_gripper_data_t", LAYOUT["gz_gripper_data_cvs"]), "int main(void) { return 0; }"]
    compile_c(tmp_path, "\n".join(later), *flags)


@needs_compiler
def test_every_declared_function_is_in_the_library(tmp_path, flags):
    words = (FOLDER / "gazebo.h").read_text().replace("*", " ").split()
    names = sorted({word.partition("(")[0] for word in words if word.startswith("gz_") and "(" in word})
    assert len(names) > 170
    lines = ["#include <gazebo.h>", "typedef void (*function)(void);", "function all[] = {"]
    lines += [f"    (function) {name}," for name in names]
    lines += ["};", "int main(void) { return all[0] == 0; }"]
    run(compile_c(tmp_path, "\n".join(lines), *flags, "-Wno-cast-function-type"))


@needs_compiler
def test_the_library_compiles_without_warnings(tmp_path):
    for source in library.SOURCES:
        command = [COMPILER, *WARNINGS, "-std=gnu99", "-c", str(FOLDER / source), "-o", str(tmp_path / "object.o")]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 0, done.stderr


@needs_compiler
@pytest.mark.skipif(shutil.which("g++") is None, reason="there is no C++ compiler here")
def test_a_cplusplus_program_compiles_and_links(tmp_path, flags):
    source = tmp_path / "program.cc"
    source.write_text("#include <gazebo.h>\nint main() { gz_client_t *c = gz_client_alloc(); gz_client_free(c); }\n")
    done = subprocess.run(["g++", *WARNINGS, str(source), *flags, "-o", str(tmp_path / "p")], timeout=60, check=False)
    assert done.returncode == 0


def test_python_has_every_name_of_the_header():
    words = (FOLDER / "gazebo.h").read_text().replace("*", " ").split()
    names = {word.partition("(")[0] for word in words if word.startswith("gz_") and "(" in word}
    names |= set(LAYOUT["_macros"])
    assert not {name for name in names if not name.startswith("gz_iface_")} - set(dir(libgz))


def test_a_program_for_the_old_python_module(server):
    served = new_interface("position")
    served.create(server, "robot1")
    served.data.pos[0] = 1.25
    program = f"""
import libgz as gazebo

client = gazebo.gz_client_alloc()
assert gazebo.gz_client_connect_wait(client, {server.server_id}, gazebo.GZ_CLIENT_ID_USER_FIRST) == 0
position = gazebo.gz_position_alloc()
assert gazebo.gz_position_open(position, client, "robot1") == 0
gazebo.gz_position_lock(position, 1)
print(position.data.pos[0], position.data.head.version == gazebo.LIBGAZEBO_VERSION)
position.data.cmd_vel_pos[0] = 0.5
gazebo.gz_position_unlock(position)
gazebo.gz_position_close(position)
gazebo.gz_client_disconnect(client)
gazebo.gz_position_free(position)
gazebo.gz_client_free(client)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=30, check=False)
    assert (done.stdout, done.stderr) == ("1.25 True\n", "")
    assert served.data.cmd_vel_pos[0] == 0.5


# Reading and commanding ------------------------------------------------------------------------------------------

CLIENT = r"""
#include <stdio.h>
#include <stdlib.h>
#include <gazebo.h>

int main(int count, char **words)
{
    gz_client_t *client = gz_client_alloc();
    gz_%(type)s_t *face = gz_%(type)s_alloc();
    int i;

    if (count != 2 || gz_client_connect_wait(client, atoi(words[1]), 3) != 0)
        return 1;
    if (gz_%(type)s_open(face, client, "%(id)s") != 0)
        return 2;
    if (gz_client_wait(client) != 0 || gz_%(type)s_lock(face, 1) != 0)
        return 3;
    printf("%%x %%lu %%s %%d %%d\n", face->data->head.version, (unsigned long) face->data->head.size,
           face->data->head.model_type, face->data->head.model_id, face->data->head.parent_model_id);
%(body)s
    gz_%(type)s_unlock(face);
    if (gz_%(type)s_close(face) != 0 || gz_client_disconnect(client) != 0)
        return 4;
    (void) i;
    gz_%(type)s_free(face);
    gz_client_free(client);
    return 0;
}
"""


@needs_compiler
@pytest.mark.parametrize("kind", INTERFACES)
def test_a_c_program_reads_and_commands_every_interface(tmp_path, flags, server, kind):
    served = new_interface(kind)
    name = "default" if kind == "sim" else "thing1"
    served.create(server, name, "Tester", 7, 3)
    reading = list(scalars_of(served.data_class, "S"))
    writing = list(scalars_of(served.data_class, "C"))
    body = [f'    printf("%.6f\\n", (double) face->data->{path});' for path, _ in reading]
    body += [f"    face->data->{path} = {number_for(i + 50, ctype)};" for i, (path, ctype) in enumerate(writing)]
    values = {"type": kind, "id": name, "body": "\n".join(body)}
    program = compile_c(tmp_path, CLIENT % values, *flags)
    for i, (path, ctype) in enumerate(reading):
        exec(f"data.{path} = value", {"data": served.data, "value": number_for(i, ctype)})
    server.post()
    done = run(program, server.server_id)
    lines = done.stdout.splitlines()
    assert lines[0] == f"60 {served.size} Tester 7 3"
    assert [float(line) for line in lines[1:]] == [number_for(i, ctype) for i, (_, ctype) in enumerate(reading)]
    for i, (path, ctype) in enumerate(writing):
        assert eval(f"data.{path}", {"data": served.data}) == number_for(i + 50, ctype), path
    assert reading or writing


@needs_compiler
def test_a_c_program_of_late_2006_reads_the_gripper_struct_of_2006(tmp_path, flags, server):
    served = Gripper(later=True)
    served.create(server, "thing1", "Tester", 7, 3)
    served.data.state, served.data.lift_down = 2, 1
    body = '    printf("%d %d\\n", face->data->state, face->data->lift_down); face->data->cmd = 4;'
    source = CLIENT % {"type": "gripper", "id": "thing1", "body": body}
    later = compile_c(tmp_path, "#define GAZEBO_GRIPPER_CVS\n" + source, *flags, name="later")
    release = compile_c(tmp_path, source.replace("face->data->state", "0"), *flags, name="release")
    server.post()
    assert run(later, server.server_id).stdout.splitlines() == ["60 200 Tester 7 3", "2 1"]
    assert served.data.cmd == 4
    assert "expected file size: 224 < 200" in run(release, server.server_id, code=2).stderr
    new_interface("sim").create(server, "default")
    with libgz.Client(server.server_id) as client:
        assert client.gripper("thing1").closed
        assert not client.gripper("thing1").opened


RAW = r"""
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <unistd.h>

int main(int count, char **words)
{
    int file = open(words[count - 1], O_RDWR), version;
    unsigned long size = 0;
    double number;
    char *memory;

    if (file < 0 || (memory = mmap(NULL, %(size)d, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0)) == MAP_FAILED)
        return 1;
    flock(file, LOCK_EX);
    memcpy(&version, memory + %(version)d, 4);
    memcpy(&size, memory + %(head_size)d, 8);
    memcpy(&number, memory + %(time)d, 8);
    printf("%%x %%lu %%s %%.3f\n", version, size, memory + %(model_type)d, number);
%(body)s
    flock(file, LOCK_UN);
    return 0;
}
"""


@needs_compiler
@pytest.mark.parametrize("kind", sorted(LAYOUT["_files"]))
def test_a_c_program_without_the_library_reads_by_offsets(tmp_path, server, kind):
    served = new_interface(kind)
    served.create(server, "default" if kind == "sim" else "thing1", "Tester")
    struct, head = LAYOUT[LAYOUT["_files"][kind]["struct"]], LAYOUT["gz_data"]["fields"]
    fields = struct["fields"]
    clock = "sim_time" if "sim_time" in fields else "time"
    setattr(served.data, clock, 12.5)
    commands = [name for name, (_, size, _) in fields.items() if name.startswith("cmd") and size in (4, 8)]
    body = [f"    memset(memory + {fields[name][0]}, 1, {fields[name][1]});" for name in commands]
    values = {
        "size": struct["size"],
        "version": head["version"][0],
        "head_size": head["size"][0],
        "model_type": head["model_type"][0],
        "time": fields[clock][0],
        "body": "\n".join(body),
    }
    program = compile_c(tmp_path, RAW % values)
    done = run(program, Path(server.path) / f"{kind}.{served.id}")
    assert done.stdout.split() == ["60", str(struct["size"]), "Tester", "12.500"]
    for name in commands:
        field = getattr(served.data_class, name)
        start = field.offset
        assert bytes(memoryview(served.data).cast("B")[start : start + field.size]) == b"\1" * field.size


@needs_compiler
@pytest.mark.parametrize("kind", ["truth", "camera"])
def test_a_c_program_reads_0x050_by_offsets(tmp_path, wire, kind):
    server = Server(wire, version=0x050)
    server.start()
    served = new_interface(kind)
    served.create(server, "thing1", "Tester")
    served.data.time = 12.5
    struct, head = LAYOUT["_versions"]["0x050"]["differs"][f"gz_{kind}_data"], LAYOUT["gz_data"]["fields"]
    last = list(struct["fields"].values())[-1]
    values = {
        "size": struct["size"],
        "version": head["version"][0],
        "head_size": head["size"][0],
        "model_type": head["model_type"][0],
        "time": struct["fields"]["time"][0],
        "body": f"    memset(memory + {last[0]}, 1, {last[1]});",
    }
    done = run(compile_c(tmp_path, RAW % values), Path(server.path) / f"{kind}.thing1")
    assert done.stdout.split() == ["50", str(struct["size"]), "Tester", "12.500"]
    array = served.array("cmd_rot" if kind == "truth" else "image")
    assert array.tobytes() == b"\1" * last[1]
    server.stop()


@needs_compiler
def test_a_client_that_posts_gets_an_error(tmp_path, flags, server):
    new_interface("ptz").create(server, "p")
    source = f"""
        #include <gazebo.h>
        int main(void) {{
            gz_client_t *client = gz_client_alloc();
            gz_ptz_t *ptz = gz_ptz_alloc();
            if (gz_ptz_post(ptz) != -1 || gz_client_connect_wait(client, {server.server_id}, 0) != 0)
                return 1;
            if (gz_ptz_open(ptz, client, "p") != 0)
                return 2;
            return gz_ptz_post(ptz) == -1 ? 0 : 3;
        }}"""
    done = run(compile_c(tmp_path, source, *flags))
    assert done.stderr.count("belongs to a client, and only servers post") == 2


@needs_compiler
def test_a_c_program_drives_the_robot_of_a_running_server(tmp_path, flags, gazebo):
    body = r"""
    face->data->cmd_vel_pos[0] = 0.4;
    for (i = 0; i < 3000 && face->data->pos[0] < 0.5; i++) {
        gz_position_unlock(face);
        if (gz_client_wait(client) != 0)
            return 5;
        gz_position_lock(face, 1);
    }
    face->data->cmd_vel_pos[0] = 0.0;
    printf("%.3f\n", face->data->pos[0]);"""
    world = installed_worlds() / "pioneer2at.world"
    program = compile_c(tmp_path, CLIENT % {"type": "position", "id": "robot1", "body": body}, *flags)
    running = gazebo(world, "--rate", "10")
    lines = run(program, running.id).stdout.splitlines()
    assert lines[0].split()[2] == "Pioneer2AT"
    assert 0.5 <= float(lines[1]) < 0.7


@needs_compiler
def test_rotations_equal_those_of_python(tmp_path, flags):
    source = r"""
#include <stdio.h>
#include <gazebo.h>
int main(void)
{
    double e[3] = {0.3, -1.2, 2.5}, q[4], back[3];
    gz_truth_quatern_from_euler(NULL, q, e);
    gz_truth_euler_from_quatern(NULL, back, q);
    printf("%.15g %.15g %.15g %.15g %.15g %.15g %.15g\n", q[0], q[1], q[2], q[3], back[0], back[1], back[2]);
    return 0;
}
"""
    numbers = [float(word) for word in run(compile_c(tmp_path, source, *flags)).stdout.split()]
    assert numbers == pytest.approx([*GzQuaternFromEuler(0.3, -1.2, 2.5), 0.3, -1.2, 2.5], abs=1e-14)


# libgz config ----------------------------------------------------------------------------------------------------


@needs_compiler
def test_the_library_is_compiled_once(tmp_path):
    first = config("--libs", XDG_CACHE_HOME=str(tmp_path))
    archives = list(tmp_path.rglob("libgazebo.a"))
    before = archives[0].stat().st_mtime_ns
    assert config("--libs", XDG_CACHE_HOME=str(tmp_path)).stdout == first.stdout
    assert [a.stat().st_mtime_ns for a in tmp_path.rglob("libgazebo.a")] == [before]
    assert config("--cflags").stdout == f"-I{FOLDER}\n"
    folder = archives[0].parent.rename(tmp_path / "elsewhere")
    archives[0].parent.symlink_to(folder)
    assert config("--libs", XDG_CACHE_HOME=str(tmp_path)).stdout == first.stdout
    folder.chmod(0o777)
    assert "can be written by all users" in config("--libs", XDG_CACHE_HOME=str(tmp_path)).stderr


def test_a_missing_compiler_is_reported():
    done = config("--libs", CC="no-such-cc")
    assert done.returncode == 1
    assert "the compiler 'no-such-cc', named by CC, is not installed" in done.stderr
