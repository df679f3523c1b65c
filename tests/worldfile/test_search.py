"""Worlds by their names: what is found where, and in which order."""

import logging
import os
import shutil

import pytest

import libgz
from libgz.base.files import installed_worlds
from libgz.reference.check import check
from libgz.worldfile.search import find_worldfile, ready_worlds

READY = installed_worlds()


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch, caplog):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("GAZEBOPATH", raising=False)
    caplog.set_level(logging.INFO, logger="libgz")
    return tmp_path


@pytest.mark.parametrize("name", ["ptz", "ptz.world", "worlds/ptz.world", "worlds/ptz"])
def test_a_world_of_libgz_has_a_name(name, caplog):
    assert find_worldfile(name) == READY / "ptz.world"
    assert f"world {name} is {READY / 'ptz.world'}, of libgz" in caplog.text


def test_a_world_loads_by_its_name():
    with libgz.World.from_file("pioneer2at") as world:
        assert world.interface("position", "robot1").pose == (0.0, 0.0, 0.0)
    with libgz.World.from_file("empty.world") as world:
        assert world.sdf is not None
    assert [error for error in check("pioneer2at") if error.severity == "error"] == []


def test_the_current_directory_comes_first_then_gazebopath(tmp_path, monkeypatch, caplog):
    here, one, two = tmp_path / "roomba.world", tmp_path / "one", tmp_path / "two"
    for folder in (one, two):
        folder.mkdir()
        shutil.copy(READY / "truth.world", folder / "roomba.world")
    monkeypatch.setenv("GAZEBOPATH", f"{tmp_path / 'nothing'}{os.pathsep}{one}{os.pathsep}{two}")
    assert find_worldfile("roomba") == one / "roomba.world"
    assert "in GAZEBOPATH; libgz has a world of this name, too" in caplog.text
    shutil.copy(READY / "truth.world", here)
    assert find_worldfile("roomba").resolve() == here
    assert "world roomba is roomba.world, here; libgz has a world of this name, too" in caplog.text
    caplog.clear()
    assert find_worldfile("roomba.world").resolve() == here
    assert caplog.text == ""  # it is the file that was named


def test_a_folder_of_that_name_is_no_world(tmp_path):
    (tmp_path / "ptz").mkdir()
    assert find_worldfile("ptz") == READY / "ptz.world"


@pytest.mark.parametrize("name", ["./ptz.world", "../ptz", "/ptz.world"])
def test_paths_are_not_searched_for(name):
    with pytest.raises(libgz.WorldFileError, match=r"cannot read worldfile .*does not exist$"):
        libgz.World.from_file(name)


@pytest.mark.parametrize("name", ["pionere2at", "pionere2at.world"])
def test_an_unknown_name_is_answered_with_the_nearest(name):
    with pytest.raises(libgz.WorldFileError, match=r"among the worlds of libgz.*did you mean 'pioneer2at'"):
        libgz.World.from_file(name)
    [error] = check(name)
    assert "did you mean 'pioneer2at'" in error.message


def test_a_world_of_libgz_is_never_written_to(caplog):
    before = (READY / "simplesolids.world").read_bytes()
    with libgz.World.from_file("simplesolids") as world:
        world.step(3)
        assert world.Save() == -1
    assert "belongs to libgz and is not written to" in caplog.text
    assert (READY / "simplesolids.world").read_bytes() == before


def test_every_ready_world_says_what_it_shows():
    worlds = ready_worlds()
    assert len(worlds) > 25
    assert all(world.summary for world in worlds)
    assert len({world.name for world in worlds}) == len(worlds)
