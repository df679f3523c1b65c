"""--untrusted: no code that a file names runs, no macros are expanded, memory and processor time are limited."""

import argparse
import contextlib
import subprocess
import sys

import pytest
from commands import run_libgz

from libgz import World
from libgz.apps import command_line
from libgz.base.errors import GazeboError
from libgz.base.trust import UNTRUSTED, UntrustedError, check_trusted, without_trust
from libgz.cxx.plugin import load as load_compiled
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.plugins import load_plugin

READERS = (
    *(
        "check",
        "convert",
        "export",
        "log",
        "model",
        "picture",
        "play",
        "player",
        "plot",
        "sdf",
        "snapshot",
        "upgrade",
        "view",
    ),
    *("gazebo", "gzclient", "gzserver"),
)
PLUGIN = """
from pathlib import Path
Path(__file__).with_suffix(".ran").touch()
from libgz import GZ_REGISTER_PLUGIN, Model
from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
class Old(Model): pass
class New(ModelPlugin):
    def Load(self, model, sdf): pass
GZ_REGISTER_PLUGIN("Old", Old)
GZ_REGISTER_MODEL_PLUGIN(New)
"""
OLD = """<gz:world xmlns:gz="g" xmlns:model="m">
<model:Old><plugin>evil.py</plugin><model:SimpleSolid/></model:Old> <model:SimpleSolid><id>s</id></model:SimpleSolid>
</gz:world>"""
NEW = """<sdf version="1.6"><world name="default"><model name="m"><link name="l"/>
<plugin name="p" filename="libevil.so"/> <plugin name="d" filename="libBuoyancyPlugin.so"/></model></world></sdf>"""
MACROS = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:property name="p" value="$(env HOME)"/><link name="${p}"/></robot>"""


@pytest.fixture
def files(tmp_path, monkeypatch):
    for name, text in (("evil.py", PLUGIN), ("old.world", OLD), ("new.world", NEW), ("robot.urdf", MACROS)):
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def untrusted(files, monkeypatch):
    monkeypatch.setenv(UNTRUSTED, "1")
    yield files
    assert not list(files.glob("*.ran"))


def test_no_plugin_of_a_worldfile_is_loaded_and_the_rest_runs(untrusted, caplog):
    with World() as world:
        world.LoadFile(untrusted / "old.world")
        assert [model.GetId() for model in world.legacy.models] == ["s"]
    assert "plugin 'evil.py' is left out: files are untrusted" in caplog.text


def test_no_plugin_of_an_sdf_world_is_loaded_not_even_by_a_state(untrusted, caplog, monkeypatch):
    monkeypatch.delenv(UNTRUSTED)
    (untrusted / "evil.py").write_text(PLUGIN.replace("Path(__file__)", "#"))
    with World() as world:
        world.LoadFile(untrusted / "new.world")
        world.Initialize()
        assert len(list(world.companions[0].plugins.running())) == 2
        state = world.get_state()
    monkeypatch.setenv(UNTRUSTED, "1")
    with World() as world:
        world.LoadFile(untrusted / "new.world")
        world.Initialize()
        assert not list(world.companions[0].plugins.running())
        assert caplog.text.count("files are untrusted") == 2
        assert ":2: <plugin>" in caplog.text
        with contextlib.suppress(GazeboError):  # as the worlds differ
            world.set_state(state)
        assert not list(world.companions[0].plugins.running())


def test_files_of_code_are_refused_wherever_they_are_loaded(untrusted):
    for load in (load_plugin, load_compiled):
        with pytest.raises(UntrustedError, match="is left out"):
            load(untrusted / "evil.py")


def test_a_block_without_trust_notes_what_it_refused():
    check_trusted("a")
    with without_trust():
        pass
    with pytest.raises(UntrustedError, match="a is left out"), without_trust(), contextlib.suppress(UntrustedError):
        check_trusted("a")
    check_trusted("a")


def test_a_refused_state_of_strangers_leaves_a_world_its_own_plugins(files):
    """Also where its own models are built again on the way: those are trusted."""
    text = NEW.replace("</world>", "<model name='n'><link name='l'/></model></world>")
    more = NEW[NEW.index("<model") : NEW.index("</world>")].replace('"m"', '"guest"')
    (files / "new.world").write_text(text)
    (files / "evil.py").write_text(PLUGIN.replace("Path(__file__)", "#"))
    with World.from_file(files / "new.world") as world:
        world.extension(SdfWorld).insert(SdfFile.from_string(f"<sdf version='1.6'>{more}</sdf>", folder=files))
        state = world.get_state()
    with World.from_file(files / "new.world") as world:
        world.remove(world.entities[:1])
        world.extension(SdfWorld).insert(SdfFile.from_string(f"<sdf version='1.6'>{more}</sdf>", folder=files))
        before, names = world.get_state(), [entity.GetId() for entity in world.entities]
        with pytest.raises(GazeboError, match="'p' of guest of the state cannot be loaded again"):
            world.set_state(state, untrusted=True)
        assert [entity.GetId() for entity in world.entities] == names
        assert len(list(world.companions[0].plugins.running())) == 2
        assert world.get_state() == before
        world.set_state(state)
        assert len(list(world.companions[0].plugins.running())) == 4


def test_macros_are_not_expanded(untrusted):
    with pytest.raises(GazeboError, match=r"robot.urdf:1: <robot>: .* untrusted"):
        SdfFile.load(untrusted / "robot.urdf")


def test_all_commands_that_read_files_have_the_option():
    parsers = command_line.command_parsers()
    subcommands = next(a for a in parsers["libgz"]._actions if isinstance(a, argparse._SubParsersAction)).choices
    for name in READERS:
        assert "--untrusted" in {**parsers, **subcommands}[name].option_names(), name


def test_a_command_with_the_option_runs_no_plugin(files):
    done = run_libgz("check", "--untrusted", "old.world")
    assert "plugin 'evil.py' is left out" in done.stdout
    assert not list(files.glob("*.ran"))
    done = run_libgz("check", "old.world")
    assert list(files.glob("*.ran")), done


WORK = """
import argparse, os, re, sys
from libgz.apps.untrusted import confined
from libgz.base.errors import GazeboError
try:
    with confined("work", argparse.Namespace(untrusted=True)):
        {}
except GazeboError as error:
    sys.exit(str(error))
"""


@pytest.mark.parametrize(
    ("work", "says"),
    [
        ("pass", ""),
        ("bytearray(1 << 40)", "the memory of 4096 MiB that files of strangers may take is used up"),
        ("os.abort()", "work: the process has crashed or was killed; files of strangers may take 4096 MiB"),
        ("re.match('(a+)+$', 60 * 'a' + 'b')", "work: the processor time of 1 s that files of strangers may take"),
    ],
    ids=["done", "memory", "crash", "time"],
)
def test_limits_end_with_a_sentence(work, says, monkeypatch):
    monkeypatch.setenv("LIBGZ_UNTRUSTED_TIME", "1")
    done = subprocess.run([sys.executable, "-c", WORK.format(work)], stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.stderr.startswith(says) if says else done.stderr == ""
    assert bool(done.returncode) == bool(says)
