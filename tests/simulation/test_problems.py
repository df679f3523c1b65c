"""Errors of models and plugins: `World.errors`, `Model.error`, and strict worlds."""

import logging
import subprocess
import sys
import textwrap
import threading

import pytest
from gzserver_process import new_environment, run

import libgz
from libgz.base.errors import StrictError

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
MODEL = """
from libgz import GZ_REGISTER_PLUGIN, Body, Model

class Bad(Model):
    def Load(self, file, node):
        self.AddBody(Body(self.world), True)
    def Init(self, file, node):
        {init}
    def Update(self, step):
        {update}
    def Fini(self):
        {fini}

GZ_REGISTER_PLUGIN("Bad", Bad)
"""
PLUGIN = """
from libgz.classic import *
from libgz.classic.event import Events

class Bad({kind}Plugin):
    def Load(self, parent, sdf):
        {load}
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
    def OnUpdate(self, info):
        {update}

GZ_REGISTER_{upper}_PLUGIN(Bad)
"""


def legacy(folder, update="pass", init="pass", fini="pass", more=""):
    (folder / "Bad.py").write_text(MODEL.format(update=update, init=init, fini=fini))
    path = folder / "bad.world"
    path.write_text(
        f"{HEAD}<model:Bad><id>bad1</id><plugin>{folder / 'Bad.py'}</plugin></model:Bad>"
        f"<model:SimpleSolid><id>good</id></model:SimpleSolid>{more}</gz:world>"
    )
    return path


def classic(folder, kind="World", load="pass", update="pass", filename="libBad.so"):
    (folder / "Bad.py").write_text(PLUGIN.format(kind=kind, upper=kind.upper(), load=load, update=update))
    element = f"<plugin name='bad' filename='{filename}'/>"
    inside = f"<model name='box'><link name='link'/>{element}</model>" if kind == "Model" else element
    path = folder / "w.world"
    path.write_text(f"<sdf version='1.6'><world name='default'>{inside}</world></sdf>")
    return path


def test_an_error_of_a_model_can_be_read(tmp_path):
    path = legacy(tmp_path, update="1 / 0")
    with libgz.World.from_file(path) as world:
        assert (world.errors, world.warnings, world.model("bad1").error) == ([], [], None)
        world.step(3)
        (problem,) = world.errors
        assert (problem.source, problem.severity) == ("model 'bad1'", "error")
        assert problem.message == "its Update failed with ZeroDivisionError: division by zero"
        assert f'File "{tmp_path / "Bad.py"}", line 10, in Update' in problem.traceback
        assert isinstance(world.model("bad1").error, ZeroDivisionError)
        assert world.model("good").error is None


def test_a_model_may_have_an_error_of_its_own(tmp_path):
    with libgz.World.from_file(legacy(tmp_path, update="self.error = 0.5")) as world:
        world.step(2)
        assert (world.model("bad1").error, world.errors) == (0.5, [])


@pytest.mark.parametrize("kind", ["World", "Model"])
@pytest.mark.parametrize(("load", "update"), [("1 / 0", "pass"), ("pass", "1 / 0")])
def test_an_error_of_a_plugin_can_be_read(tmp_path, monkeypatch, caplog, kind, load, update):
    path = classic(tmp_path, kind, load, update)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    with libgz.World.from_file(path) as world:
        world.step(2)
        (problem,) = world.errors
        assert problem.source == "plugin with name[bad] and filename[libBad.so]"
        assert "ZeroDivisionError" in problem.message
        assert "Bad.py" in problem.traceback
        assert problem.where == f"{path}:1"
        assert f"{path}:1: <plugin>: Exception occured in " in caplog.text
        if kind == "Model":
            assert isinstance(world.model("box").error, ZeroDivisionError)


@pytest.mark.parametrize("kind", ["World", "Model", "Sensor"])
@pytest.mark.parametrize(
    "content", [None, "1 / 0", "", "from libgz.classic import *\nGZ_REGISTER_GUI_PLUGIN(GUIPlugin)"]
)
def test_a_plugin_that_cannot_be_loaded_is_named_with_the_line_of_its_element(
    tmp_path, monkeypatch, caplog, kind, content
):
    if content is not None:
        (tmp_path / "Bad.py").write_text(content)
    plugin = "\n<plugin name='bad' filename='libBad.so'/>"
    sensor = f"<sensor name='s' type='imu'><always_on>1</always_on>{plugin if kind == 'Sensor' else ''}</sensor>"
    model = f"<model name='m'><link name='l'>{sensor}</link>{plugin if kind == 'Model' else ''}</model>"
    path = tmp_path / "w.world"
    path.write_text(f"<sdf version='1.6'><world name='d'>{model}{plugin if kind == 'World' else ''}</world></sdf>")
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    with libgz.World.from_file(path) as world:
        (problem,) = world.errors
    assert problem.message.startswith(f"{path}:2: <plugin>: ")


THREAD = "import threading as t; w = t.Thread(target={}, name='w'); w.start(); w.join()"


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_an_error_in_a_thread_of_a_model_can_be_read(tmp_path):
    before = []
    for folder in ("one", "other"):
        (tmp_path / folder).mkdir()
    path = legacy(tmp_path / "one", update=THREAD.format("lambda: 1 / 0"))
    with libgz.World.from_file(legacy(tmp_path / "other")) as other, libgz.World.from_file(path) as world:
        hook = threading.excepthook
        threading.excepthook = lambda args: before.append(args) or hook(args)  # another library's, which chains
        try:
            world.step()
        finally:
            threading.excepthook = hook
        (problem,) = world.errors
        assert problem.source == f"thread 'w' of plugin {tmp_path / 'one' / 'Bad.py'}"
        assert problem.message == "it failed with ZeroDivisionError: division by zero"
        assert 'Bad.py", line 10, in <lambda>' in problem.traceback
        assert (world.model("bad1").error, other.errors, len(before)) == (None, [], 1)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_an_error_in_a_thread_of_a_plugin_ends_a_strict_world(tmp_path, monkeypatch):
    path = classic(tmp_path, update=THREAD.format("lambda: 1 / 0"))
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    with (
        pytest.raises(StrictError, match=r"(?s)thread 'w' of plugin .*Bad.py: it failed with ZeroDivisionError"),
        libgz.World.from_file(path, strict=True) as world,
    ):
        world.step(100)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
@pytest.mark.parametrize(("end", "errors"), [("'no device'", 1), ("3", 1), ("", 0), ("0", 0)])
def test_a_thread_that_exits_with_an_error_is_reported(tmp_path, caplog, end, errors):
    with libgz.World.from_file(
        legacy(tmp_path, update=THREAD.format(f"lambda: __import__('sys').exit({end})"))
    ) as world:
        world.step()
        assert [problem.message for problem in world.errors] == errors * [
            f"it failed with SystemExit: {end.strip(chr(39))}"
        ]
        assert caplog.text.count("Bad.py: it failed with SystemExit") == errors


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_errors_of_other_threads_and_ends_of_threads_are_none_of_a_world(tmp_path):
    with libgz.World.from_file(legacy(tmp_path, update=THREAD.format("__import__('sys').exit"))) as world:
        world.step()
        foreign = threading.Thread(target=lambda: 1 / 0)
        foreign.start()
        foreign.join()
        assert world.errors == []


def test_errors_and_warnings_belong_to_their_world(tmp_path):
    text = f"{HEAD}<model:SimpleSolid><id>a</id><colour>1 0 0</colour></model:SimpleSolid></gz:world>"
    with libgz.World.from_string(text) as one, libgz.World.from_string(f"{HEAD}</gz:world>") as two:
        assert "<colour>" in one.warnings[0].message
        assert two.warnings == two.errors == one.errors == []
        one.model("a").Update = lambda step: 1 / 0
        one.step()
        two.step()
        assert (len(one.errors), len(two.errors)) == (1, 0)


def test_warnings_are_still_printed_where_no_logging_is_set_up():
    text = f"{HEAD}<model:SimpleSolid><colour>1 0 0</colour></model:SimpleSolid></gz:world>"
    program = f"import libgz; libgz.World.from_string({text!r}).close()"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stderr.count("<colour>") == 1


def test_silent_logging_keeps_errors(tmp_path):
    logging.getLogger("libgz").setLevel(logging.CRITICAL + 1)
    with libgz.World.from_file(legacy(tmp_path, update="1 / 0")) as world:
        world.step()
        assert len(world.errors) == 1


@pytest.mark.parametrize("error", ["GeneratorExit", "__import__('asyncio').CancelledError"])
def test_errors_that_are_no_exceptions_stop_the_plugin_only(tmp_path, monkeypatch, error):
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    with libgz.World.from_file(classic(tmp_path, "Model", update=f"raise {error}")) as world:
        world.step(2)
        (problem,) = world.errors
        assert error.split(".")[-1] in problem.message


def test_a_strict_world_ends_at_the_first_error(tmp_path):
    with (
        pytest.raises(StrictError, match=r"(?s)model 'bad1': its Update failed with ZeroDivisionError.*line 10"),
        libgz.World.from_file(legacy(tmp_path, update="1 / 0"), strict=True) as world,
    ):
        world.step(100)
    assert world.iterations == 1


def test_a_strict_world_refuses_warnings():
    text = f"{HEAD}<model:SimpleSolid><colour>1 0 0</colour></model:SimpleSolid></gz:world>"
    with pytest.raises(StrictError, match="<colour>"):
        libgz.World.from_string(text, strict=True)


def test_the_end_of_a_strict_world_counts(tmp_path):
    world = libgz.World.from_file(legacy(tmp_path, fini="1 / 0"), strict=True)
    world.step()
    with pytest.raises(StrictError, match="its Fini"):
        world.close()
    world.close()


@pytest.mark.parametrize("part", ["update", "init", "fini", "more"])
def test_gazebo_strict(tmp_path, part, wire):
    warned = "<model:SimpleSolid><colour>1 0 0</colour></model:SimpleSolid>"
    path = legacy(tmp_path, **{part: warned if part == "more" else "1 / 0"})
    words = [sys.executable, "-m", "libgz.apps.gazebo", "-n", "-s", str(wire), "--steps", "5", str(path)]
    loose = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert loose.returncode == (1 if part == "init" else 0)
    done = subprocess.run([*words, "--strict"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 3
    assert ("<colour>" if part == "more" else "ZeroDivisionError") in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "options",
    [{"load": "1 / 0"}, {"update": "1 / 0"}, {"filename": "libmissing.so"}, {"kind": "Model", "load": "1 / 0"}],
)
def test_gzserver_strict(tmp_path, options):
    path = classic(tmp_path, **options)
    environment = new_environment(tmp_path)
    assert run(environment, path, "--iters", 5).returncode == 0
    done = run(environment, path, "--iters", 5, "--strict")
    assert done.returncode == 3
    assert ("missing" if "filename" in options else "ZeroDivisionError") in done.stderr
    assert "Traceback" not in done.stderr


def test_gzserver_strict_at_the_end(tmp_path):
    path = classic(tmp_path, load="self.last = Events.ConnectStop(lambda: 1 / 0)")
    assert run(new_environment(tmp_path), path, "--iters", 5, "--strict").returncode == 3


@pytest.mark.parametrize("text", ["def Load(self, argc, argv): 1 / 0", "def Init(self): 1 / 0"])
def test_gzserver_strict_system_plugin(tmp_path, text):
    (tmp_path / "sys.py").write_text(
        textwrap.dedent(f"""
        from libgz.classic import *
        class S(SystemPlugin):
            def Load(self, argc, argv): pass
            {text}
        GZ_REGISTER_SYSTEM_PLUGIN(S)
        """)
    )
    (tmp_path / "sys.py").rename(tmp_path / "failing.py")
    world = tmp_path / "w.world"
    world.write_text("<sdf version='1.6'><world name='default'/></sdf>")
    words = (world, "-s", "libfailing.so", "--iters", 2)
    assert run(new_environment(tmp_path), *words, "--strict").returncode == 3


def test_a_strict_run_without_problems_ends_as_usual(tmp_path, wire):
    words = [sys.executable, "-m", "libgz.apps.gazebo", "-n", "-s", str(wire), "--steps", "5", "--strict"]
    done = subprocess.run([*words, str(legacy(tmp_path))], capture_output=True, text=True, timeout=60)
    assert (done.returncode, "error" in done.stderr, "warning" in done.stderr) == (0, False, False)
