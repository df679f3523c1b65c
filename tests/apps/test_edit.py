"""libgz edit: a world that runs paused, and an empty one where there is none."""

import argparse
import os
from pathlib import Path

import pytest

import libgz
from libgz.apps import edit, gazebo
from libgz.base.errors import ParameterError
from libgz.classic.transport.address import Address, listening_sockets
from libgz.reference.check import check


def options(path, **more):
    given = {"sdf": False, "no_open": True, "untrusted": False, "view_port": 8080, "view_host": "127.0.0.1"}
    return argparse.Namespace(file=path, **{**given, **more})


@pytest.mark.parametrize(("name", "sdf"), [("a.world", False), ("a.sdf", True), ("b.sdf.world", True)])
def test_an_empty_world_is_created_once_and_runs_paused(tmp_path, monkeypatch, capsys, name, sdf):
    words = []
    monkeypatch.setattr(gazebo, "main", lambda given: words.append(given) or 0)
    path = tmp_path / name
    assert edit.run(options(path)) == 0
    assert "is new" in capsys.readouterr().out
    assert check(path) == []
    with libgz.World.from_file(path) as world:
        assert (world.sdf is not None) == sdf
        assert len(world.models) >= 1
    path.write_text(path.read_text() + "<!-- mine -->\n")
    assert edit.run(options(path, untrusted=True, no_open=False)) == 0
    assert "mine" in path.read_text()
    assert {"--pause", "--view", "--open", "--untrusted"} <= set(words[1])
    assert "--open" not in words[0]
    assert ("-s" in words[0]) != sdf


def test_several_sdf_worlds_can_be_edited_at_a_time(monkeypatch):
    [taken] = listening_sockets(Address("127.0.0.1", 0))
    with taken:
        uri = f"http://127.0.0.1:{taken.getsockname()[1]}"
        monkeypatch.setenv("GAZEBO_MASTER_URI", uri)
        edit.take_free_port()
        assert os.environ["GAZEBO_MASTER_URI"] == "http://127.0.0.1:0"
    monkeypatch.setenv("GAZEBO_MASTER_URI", uri)
    edit.take_free_port()
    assert os.environ["GAZEBO_MASTER_URI"] == uri


def test_a_directory_is_no_world(tmp_path):
    with pytest.raises(ParameterError, match="is no file"):
        edit.run(options(tmp_path))


def test_the_format_may_be_chosen():
    assert "<sdf" in edit.empty_world(Path("x.world"), sdf=True)


def test_gazebo_starts_paused(tmp_path, monkeypatch):
    path = tmp_path / "a.world"
    path.write_text(edit.empty_world(path))
    seen, loop = [], gazebo.Run.loop
    monkeypatch.setattr(gazebo.Run, "loop", lambda run, world: (loop(run, world), seen.append(world.iterations)))
    assert gazebo.main(["--pause", "-s", "auto", "-d", "0", "--steps", "3", "--rate", "0", str(path)]) == 0
    assert seen == [0]
