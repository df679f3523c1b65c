"""Plugins that misbehave, in each method of each kind: the server lives on, or ends as documented."""

import itertools
import os
import select
import signal
import subprocess
import sys
import textwrap
import time

import pytest
from gzserver_process import SERVER, new_environment

pytestmark = pytest.mark.trial

CLIENT = [sys.executable, "-m", "libgz.apps.gzclient"]
START, END = 60.0, 20.0  # [s]
STEPS = 50

# Kind -> the arguments of Load, and its methods. CALLBACK is one that an event calls.
CALLBACK = "Callback"
ALL = ("__init__", "Load", "Init", "Reset", CALLBACK)
KINDS = {
    "World": ("world, sdf", ALL),
    "Model": ("model, sdf", ALL),
    "Sensor": ("sensor, sdf", ALL),
    "System": ("argc=0, argv=()", ALL),
    "Visual": ("visual, sdf", ALL),
    "GUI": ("sdf", ("__init__", "Load", CALLBACK)),
}
BEHAVIOURS = {
    "raise": "raise ValueError('on purpose')",
    "exit": "sys.exit(7)",
    "hang": "print('hangs', flush=True)\nwhile True: pass",
    "fork": """
        child = os.fork()
        if child == 0:
            os._exit(0)
        os.waitpid(child, 0)
        subprocess.run(["true"], check=True)
        """,
    "thread": """
        def work():
            time.sleep(0.2)
        threading.Thread(target=work).start()
        def run():
            while True:
                physics.get_world()
                time.sleep(0.001)
        threading.Thread(target=run, daemon=True).start()
        """,
}
ERRORS = {"raise": "ValueError: on purpose", "exit": "SystemExit: 7"}  # that are reported, with the file
CASES = [
    (kind, method, how)
    for kind, (_, methods) in KINDS.items()
    for method, how in itertools.product(methods, BEHAVIOURS)
]

# Resets the world once, and reports that the run was complete.
PROBE = f"""
from libgz.classic import *
from libgz.classic.event import Events
class Probe(WorldPlugin):
    def Load(self, world, sdf):
        self.world, self.count = world, 0
        self.connection = Events.ConnectWorldUpdateEnd(self.OnUpdate)
    def OnUpdate(self):
        self.count += 1
        if self.count == 10:
            self.world.Reset()
        if self.count == {STEPS} - 5:
            print("complete", flush=True)
GZ_REGISTER_WORLD_PLUGIN(Probe)
"""


def plugin_text(kind, method, how):
    """A plugin of a kind that misbehaves once, in one method."""
    load = KINDS[kind][0]
    event = "PreRender" if kind in ("Visual", "GUI") else "WorldUpdateBegin"
    wrong = textwrap.indent(textwrap.dedent(BEHAVIOURS[how]).strip(), " " * 8)
    parts = [
        "import os, subprocess, sys, threading, time",
        "from libgz.classic import *",
        "from libgz.classic import physics",
    ]
    parts += ["from libgz.classic.event import Events", f"class Wrong({kind}Plugin):", "    done = False"]
    for name, arguments in (("__init__", ""), ("Load", load), ("Init", ""), ("Reset", "")):
        parts.append(f"    def {name}({', '.join(filter(None, ('self', arguments)))}):")
        if name == "Load":
            parts.append(f"        self.connection = Events.Connect{event}(self.{CALLBACK})")
        parts.append(wrong if name == method else "        pass")
    parts += [f"    def {CALLBACK}(self, *_):", "        if self.done: return", "        self.done = True"]
    parts.append(wrong if method == CALLBACK else "        pass")
    return "\n".join([*parts, f"GZ_REGISTER_{kind.upper()}_PLUGIN(Wrong)", ""])


def world_text(kind):
    plugin = "<plugin name='wrong' filename='libwrong.so'/>"
    at = {name: plugin if name == kind else "" for name in KINDS}
    camera = "<camera><image><width>8</width><height>8</height></image></camera>"
    ball = "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
    eye = f"<sensor name='eye' type='camera'><always_on>1</always_on>{camera}</sensor>" if kind == "Visual" else ""
    return f"""<sdf version='1.6'><world name='default'>
      <plugin name='probe' filename='libprobe.so'/>{at["World"]}
      <model name='m'>{at["Model"]}<link name='l'>
        <visual name='v'><pose>1 0 0 0 0 0</pose>{ball}{at["Visual"]}</visual>{eye}
        <sensor name='s' type='imu'><always_on>1</always_on>{at["Sensor"]}</sensor>
      </link></model></world></sdf>"""


class Process:
    """A command, whose output is read as it comes."""

    def __init__(self, command, environment):
        self.process = subprocess.Popen(
            list(map(str, command)), env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        self.output = ""

    def wait_for(self, word, limit):
        """Read until a word was printed or the process ended; returns whether it was printed."""
        end = time.monotonic() + limit
        while word not in self.output and (left := end - time.monotonic()) > 0:
            if select.select([self.process.stdout], [], [], left)[0]:
                more = os.read(self.process.stdout.fileno(), 65536)
                if not more:
                    break
                self.output += more.decode()
        return word in self.output

    def end(self, limit):
        """The exit code; None if it did not end in time."""
        try:
            more, _ = self.process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            return None
        self.output += more.decode()
        return self.process.returncode

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()


@pytest.fixture
def start(tmp_path):
    environment, started = {**new_environment(tmp_path), "PYTHONUNBUFFERED": "1"}, []

    def run(*command):
        started.append(Process(command, environment))
        return started[-1]

    yield run
    for process in reversed(started):
        process.close()


@pytest.mark.parametrize(("kind", "method", "how"), CASES, ids=map("-".join, CASES))
def test_plugins_that_misbehave(tmp_path, start, kind, method, how):
    (tmp_path / "wrong.py").write_text(plugin_text(kind, method, how))
    (tmp_path / "probe.py").write_text(PROBE)
    (tmp_path / "w.world").write_text(world_text(kind))
    if kind == "GUI":
        server = start(*SERVER, tmp_path / "w.world")
        assert server.wait_for("complete", START), server.output
        # Until its first frame, gzclient ends at the first signal; after it, a callback that hangs takes a second.
        first = () if (method, how) == (CALLBACK, "hang") else ("--picture", tmp_path / "p.png")
        process = start(*CLIENT, "--gui-client-plugin", "libwrong.so", *first)
    else:
        system = ["-s", "libwrong.so"] if kind == "System" else []
        process = start(*SERVER, "--verbose", *system, "--iters", STEPS, tmp_path / "w.world")
    if how == "hang":
        assert process.wait_for("hangs", START), process.output
        once = kind == "GUI" and method != CALLBACK
        for _ in range(1 if once else 2):
            process.process.send_signal(signal.SIGINT)
            time.sleep(0.5)
        assert process.end(END) == (0 if once else 130), process.output
    else:
        code = process.end(START)
        assert code is not None, f"it did not end: {process.output}"
        assert code >= 0, f"it was ended by signal {-code}: {process.output}"
        assert code == 0, process.output
        assert kind == "GUI" or "complete" in process.output, process.output
        if how in ERRORS:
            assert ERRORS[how] in process.output
            assert "wrong.py" in process.output
    if kind == "GUI":
        server.process.send_signal(signal.SIGTERM)
        assert server.end(END) is not None
