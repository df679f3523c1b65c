"""C++ plugins that break, in all ways that were thought of: each ends in one clear line that names plugin and function.

One process has loaded libgz, and forks for each case: what ends a process ends its child only.
"""

import json
import os
import shutil
import signal
import struct
import subprocess
import sys

import pytest
from master_uri import free_master_uri

from libgz.classic_cxx.build import check
from libgz.cxx.build import compiler

PLUGIN = '<plugin name="checks" filename="libmodel.so"><check>{}</check></plugin>'
WORLD = """\
<sdf version="1.6"><world name="default"><model name="robot"><link name="base"/>{}</model>
<model name="other"><link name="link"/></model></world></sdf>
"""
RUNNER = """\
import gc, json, logging, os, resource, signal, sys, time
import libgz
from libgz.classic import msgs, transport

resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
plugin = "<plugin name='p' filename='libworld.so'/>"
warm = libgz.World.from_string(f"<sdf version='1.6'><world name='w'>{plugin}</world></sdf>")
warm.step(1)
warm.close()
del warm
gc.collect()

def run(text, check):
    logging.basicConfig(format="%(message)s", stream=sys.stderr, level=logging.WARNING, force=True)
    world = libgz.World.from_string(text)
    if "OnPing" in check:
        node = transport.Node()
        node.Init("default")
        node.Advertise(msgs.Vector3d, "~/ping").Publish(msgs.Vector3d(x=1.5, y=0, z=0))
    world.step(3)
    if "Reset" in check:
        world.reset()
    world.step(3)
    if "destructor" in check or "left thread" in check:
        world.close()
        del world
        gc.collect()
        if "left thread" in check:
            os.utime("libmodel.so")
            world = libgz.World.from_string(text.replace(check, "step"))  # the file as it is now
            gc.collect()
            time.sleep(20)
    print("the world runs on" if "world" not in locals() or world.GetSimTime() > 0.0025 else "it does not run")
    sys.stdout.flush()

for line in sys.stdin:
    name, text, check = json.loads(line)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        os.dup2(writer, 1)
        os.dup2(writer, 2)
        signal.alarm(100)
        os.environ["LIBGZ_TEST_CHECK"] = check
        run(text, check)
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, errors="replace") as output:
        said = output.read()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    print(json.dumps([name, status, said]), flush=True)
"""
NOT_KEPT = "states and resets do not keep"  # is said of each C++ plugin, once
STOPS = "in the {} function of plugin with name[checks] and filename[libmodel.so]. This plugin will not run"
EVENT = "in a callback of event {} of plugin with name[checks] and filename[libmodel.so]. This plugin will not run"
SEGV, ABRT, FPE, ILL, BUS = -11, -6, -8, -4, -7
THREW = "it threw "
DIED = "SIG{} in {} of plugin 'checks' ("

# What breaks and where; how its process ends; what is said.
CASES = {
    "throw in constructor": (
        0,
        "in the constructor of plugin with name[checks]",
        THREW + "std::runtime_error: no luck",
    ),
    "throw in Load": (0, STOPS.format("Load"), THREW + "std::runtime_error: no luck"),
    "throw in Init": (0, STOPS.format("Init"), THREW + "std::runtime_error: no luck"),
    "throw in Reset": (0, STOPS.format("Reset"), THREW + "std::runtime_error: no luck"),
    "throw in OnUpdate": (0, EVENT.format("WorldUpdateBegin"), THREW + "std::runtime_error: no luck"),
    "throw in OnEnd": (0, EVENT.format("WorldUpdateEnd"), THREW + "std::runtime_error: no luck"),
    "throw in OnPing": (
        0,
        "in a callback of topic /gazebo/default/ping of plugin with name[checks]",
        THREW + "std::runtime_error: no luck",
    ),
    "throw in destructor": (ABRT, DIED.format("ABRT", "the destructor"), "no luck"),
    "text in Load": (0, STOPS.format("Load"), THREW + "the text a plain text"),
    "string in OnUpdate": (0, EVENT.format("WorldUpdateBegin"), THREW + "the text a string"),
    "int in Init": (0, STOPS.format("Init"), THREW + "int"),
    "struct in Reset": (0, STOPS.format("Reset"), THREW + "Failure"),
    "gzthrow in OnUpdate": (0, EVENT.format("WorldUpdateBegin"), "gazebo::common::Exception at"),
    "cast in Load": (0, STOPS.format("Load"), "bad_any_cast"),
    "at in OnUpdate": (0, EVENT.format("WorldUpdateBegin"), THREW + "std::out_of_range"),
    "memory in Load": (0, STOPS.format("Load"), THREW + "std::bad_alloc"),
    "silent in Load": (0, STOPS.format("Load"), THREW + "Saying: (it says nothing)"),
    "null text in Reset": (0, STOPS.format("Reset"), THREW + "the text (it says nothing)"),
    "several lines in OnUpdate": (0, EVENT.format("WorldUpdateBegin"), THREW + "Saying: one [Err] two  [2Jthree\n"),
    "long in Load": (0, STOPS.format("Load"), THREW + "Saying: aaa"),
    "no text in Init": (0, STOPS.format("Init"), THREW + "Saying: no "),
    "pointer in OnUpdate": (0, EVENT.format("WorldUpdateBegin"), THREW + "std::runtime_error*"),
    "enum in Load": (0, STOPS.format("Load"), THREW + "Kind"),
    "function in OnUpdate": (0, EVENT.format("WorldUpdateBegin"), THREW + "std::bad_function_call"),
    "mutex in Load": (0, STOPS.format("Load"), THREW + "std::system_error"),
    "promise in Init": (0, STOPS.format("Init"), THREW + "std::future_error"),
    "dynamic cast in Reset": (0, STOPS.format("Reset"), THREW + "std::bad_cast"),
    "assert in Load": (0, STOPS.format("Load"), "no luck"),
    "boost null in OnUpdate": (
        0,
        EVENT.format("WorldUpdateBegin"),
        "a null pointer was used: one to a gazebo::physics::",
    ),
    "other class in Load": (0, STOPS.format("Load"), THREW + "std::invalid_argument"),
    "exit in constructor": (3, "exit() was called in the constructor of plugin 'checks' ("),
    "exit in Load": (3, "exit() was called in Load of plugin 'checks' ("),
    "exit in OnUpdate": (3, "exit() was called in a callback of event WorldUpdateBegin of plugin 'checks' ("),
    "quick_exit in Init": (3, "exit() was called in Init of plugin 'checks' ("),
    "thread exit in Load": (3, "exit() was called in a thread of plugin "),
    "abort in Load": (ABRT, DIED.format("ABRT", "Load")),
    "abort in Reset": (ABRT, DIED.format("ABRT", "Reset")),
    "terminate in OnUpdate": (ABRT, DIED.format("ABRT", "a callback of event WorldUpdateBegin")),
    "segv in constructor": (SEGV, DIED.format("SEGV", "the constructor")),
    "segv in Load": (SEGV, DIED.format("SEGV", "Load")),
    "segv in Init": (SEGV, DIED.format("SEGV", "Init")),
    "segv in Reset": (SEGV, DIED.format("SEGV", "Reset")),
    "segv in OnUpdate": (SEGV, DIED.format("SEGV", "a callback of event WorldUpdateBegin")),
    "segv in OnEnd": (SEGV, DIED.format("SEGV", "a callback of event WorldUpdateEnd")),
    "segv in destructor": (SEGV, DIED.format("SEGV", "the destructor")),
    "call null in OnUpdate": (SEGV, DIED.format("SEGV", "a callback of event WorldUpdateBegin")),
    "ill in Load": (ILL, DIED.format("ILL", "Load")),
    "fpe in Load": (FPE, DIED.format("FPE", "Load")),
    "bus in Load": (BUS, DIED.format("BUS", "Load")),
    "segv with a handler in OnUpdate": (
        SEGV,
        DIED.format("SEGV", "a callback of event WorldUpdateBegin"),
        ": a handler that was installed later follows\nown words",
    ),
    "segv with handlers in OnUpdate": (  # as of two plugins
        SEGV,
        DIED.format("SEGV", "a callback of event WorldUpdateBegin"),
        ": a handler that was installed later follows\nsecond words\nfirst words",
    ),
    "segv with an exit in OnUpdate": (
        4,
        DIED.format("SEGV", "a callback of event WorldUpdateBegin"),
        "installed later follows",
    ),
    "own event in OnUpdate": (SEGV, DIED.format("SEGV", "a callback of event WorldUpdateBegin")),
    "overflow in Load": (SEGV, DIED.format("SEGV", "Load")),
    "overflow in OnUpdate": (SEGV, DIED.format("SEGV", "a callback of event WorldUpdateBegin")),
    "double free in Load": (ABRT, DIED.format("ABRT", "Load")),
    "heap in Load": (ABRT, DIED.format("ABRT", "Load")),
    "pure in Load": (ABRT, DIED.format("ABRT", "Load"), "pure virtual"),
    "thread in Load": (ABRT, "SIGABRT in a thread of plugin ", "no luck in a thread"),
    "thread segv in OnUpdate": (SEGV, "SIGSEGV in a thread of plugin "),
    "joinable in Load": (ABRT, DIED.format("ABRT", "Load")),
    "left thread in Load": (SEGV, "SIGSEGV in a thread that was left by plugin ", "has to join its threads"),
}
# Files, and what is said of them; the world runs on.
FILES = {
    "null": "returned no plugin",
    "static": "SIGABRT in its constructors",
    "missing": "nothing defines _Z7nowherev; link the file or library that does",
    "needs": "libnowhere.so.1: cannot open shared object file",
    "hidden": "hides its RegisterPlugin; build it without -fvisibility",
    "unregistered": "this file is no C++ plugin of libgz",
    "old": "was built with another version of libgz or Python; build it again",
    "wrongkind": "detected an incorrect plugin type",
    "text": "this file is no C++ plugin of libgz",
    "empty": "this file is no C++ plugin of libgz",
    "truncated": "the file is truncated; build it again",
    "folder": "tried",
    "pipe": "tried",
    "dangling": "this link leads to nowhere.so, where there is no file",
    "absent": "cannot open shared object file",
    "bits": "was built for x86-64 (32 bits), and this is x86_64; build it again here",
    "processor": "was built for arm (64 bits), and this is x86_64; build it again here",
}
MARK = """
extern "C" const char *libgz_classic_plugin() {{ return "libgz classic plugin: Model; {key}; {folder};"; }}
"""
SOURCES = {
    "null": 'extern "C" void *libgz_new_plugin() { return nullptr; }',
    "static": 'int fail() { throw 7; } int number = fail(); extern "C" void *libgz_new_plugin() { return nullptr; }',
    "missing": 'void nowhere(); extern "C" void *libgz_new_plugin() { nowhere(); return nullptr; }',
    "needs": 'extern "C" void *libgz_new_plugin() { return nullptr; }',
    "hidden": "static int nothing;",
}


def make_files(place, library):
    """The files that are wrong, in a folder."""
    for name, source in SOURCES.items():
        (place / f"{name}.cc").write_text(source + MARK.format(key=library.key, folder=library.lib))
        options = []
        if name == "needs":
            subprocess.run(
                [
                    *compiler(),
                    "-shared",
                    "-Wl,-soname,libnowhere.so.1",
                    "-o",
                    place / "libnowhere.so",
                    "-x",
                    "c++",
                    os.devnull,
                ],
                check=True,
            )
            options = [f"-L{place}", "-Wl,--no-as-needed", "-lnowhere"]
        command = [*compiler(), "-shared", "-fPIC", "-o", place / f"lib{name}.so", place / f"{name}.cc", *options]
        subprocess.run(command, check=True)
    model = (place / "libmodel.so").read_bytes()
    (place / "libunregistered.so").write_bytes((place / "libnowhere.so").read_bytes())
    start = model.index(b"libgz classic plugin: Model; ") + 29
    (place / "libold.so").write_bytes(model[:start] + b"0" * 16 + model[start + 16 :])
    shutil.copy(place / "libworld.so", place / "libwrongkind.so")
    (place / "libtext.so").write_text("a text\n")
    (place / "libempty.so").write_bytes(b"")
    (place / "libtruncated.so").write_bytes(model[: model.index(b";", start) + 4096])
    (place / "libfolder.so").mkdir()
    os.mkfifo(place / "libpipe.so")
    (place / "libdangling.so").symlink_to("nowhere.so")
    (place / "libbits.so").write_bytes(model[:4] + b"\1" + model[5:])
    (place / "libprocessor.so").write_bytes(model[:18] + struct.pack("<H", 0x28) + model[20:])


def test_each_broken_plugin_ends_in_a_clear_line(place, library):
    make_files(place, library)
    jobs = [[case, WORLD.format(PLUGIN.format(case)), case] for case in CASES]
    jobs += [[f"file {name}", WORLD.format(f'<plugin name="checks" filename="lib{name}.so"/>'), ""] for name in FILES]
    done = subprocess.run(
        [sys.executable, "-P", "-c", RUNNER],
        input="".join(json.dumps(job) + "\n" for job in jobs),
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, "LC_ALL": "C"},
        check=False,
    )
    answers = {name: (status, said) for name, status, said in map(json.loads, done.stdout.splitlines())}
    assert len(answers) == len(jobs) > 50, done.stderr[-2000:]
    wrong = []
    for case, (code, *texts) in CASES.items():
        status, said = answers[case]
        naming = [line for line in said.splitlines() if "libmodel.so" in line and NOT_KEPT not in line]
        if status != code or not all(text in said for text in texts) or len(naming) != 1:
            wrong.append(f"{case}: {status}, not {code}\n{said}")
        elif code == 0 and "the world runs on" not in said:
            wrong.append(f"{case}: the world does not run on\n{said}")
    for name, text in FILES.items():
        status, said = answers[f"file {name}"]
        if text not in said or f"lib{name}.so" not in said or "Traceback" in said:
            wrong.append(f"file {name}: {status}\n{said}")
    assert not wrong, "\n\n".join(wrong)


def test_a_file_that_registers_two_plugins_is_told_so(library, tmp_path):
    plugin = "struct {0} : gazebo::ModelPlugin {{ void Load(gazebo::physics::ModelPtr, sdf::ElementPtr) {{}} }};\n"
    text = "#include <gazebo/common/Plugin.hh>\n"
    text += "".join(plugin.format(name) + f"GZ_REGISTER_MODEL_PLUGIN({name})\n" for name in ("One", "Two"))
    (tmp_path / "two.cc").write_text(text)
    errors = [error.message for error in check([tmp_path / "two.cc"])]
    assert any(error.endswith("; a plugin has one GZ_REGISTER_..._PLUGIN") for error in errors), errors


@pytest.mark.parametrize("case", ["loop in OnUpdate", "deadlock in Load"])
def test_the_second_interrupt_ends_what_does_not_end(place, case):
    (place / "w.world").write_text(WORLD.format(PLUGIN.format(case)))
    command = [sys.executable, "-P", "-m", "libgz.apps.gzserver", "w.world"]
    environment = {**os.environ, "GAZEBO_MASTER_URI": free_master_uri()}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as server:
        lines = []
        while "begins" not in "".join(lines[-1:]):
            lines.append(server.stderr.readline())
            assert lines[-1], "".join(lines)
        server.send_signal(signal.SIGINT)
        while "second" not in "".join(lines[-1:]):  # what the second one will do
            lines.append(server.stderr.readline())
            assert lines[-1], "".join(lines)
        server.send_signal(signal.SIGINT)
        lines += server.stderr.readlines()
    assert server.returncode == 128 + signal.SIGINT
    assert "plugin with name[checks] and filename[libmodel.so]" in "".join(lines)
