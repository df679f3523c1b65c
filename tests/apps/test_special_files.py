"""A pipe, a socket or a device instead of a file is refused at once: reading it could wait for ever."""

import os
import socket

import pytest
from commands import run_libgz

from libgz.base.errors import GazeboError
from libgz.base.files import open_file, read_limited, read_text
from libgz.models.gzb import read_gzb
from libgz.physics.bone_motion import read_motion
from libgz.physics.image_files import open_image
from libgz.physics.mesh_files import read_mesh

COMMANDS = (
    ("check",),
    ("convert", "-o", "converted.sdf"),
    ("export",),
    ("log", "--echo", "-f"),
    ("log", "--info", "-f"),
    ("picture",),
    ("play",),
    ("play", "--info"),
    ("sdf", "--check"),
    ("sdf", "--print"),
    ("snapshot", "restore"),
    ("sweep",),
    ("sweep", "report"),
    ("upgrade",),
)


@pytest.fixture
def pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe.world")
    return tmp_path / "pipe.world"


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_commands_refuse_a_pipe(pipe, command):
    ended = run_libgz(*command, pipe, cwd=pipe.parent)
    assert ended.returncode not in (0, 130, 143)
    assert "Traceback" not in ended.stderr
    assert str(pipe) in ended.stdout + ended.stderr


@pytest.mark.parametrize("suffix", ["stl", "obj", "dae", "ply", "png", "bvh", "gzb"])
def test_assets_refuse_a_pipe(tmp_path, suffix):
    path = tmp_path / f"asset.{suffix}"
    os.mkfifo(path)
    read = {"bvh": read_motion, "gzb": read_gzb, "png": lambda path: open_image(path).__enter__()}.get(
        suffix, read_mesh
    )
    with pytest.raises(GazeboError, match="it is a pipe, not a file"):
        read(path)


def test_what_is_no_file_is_named(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "socket"))
        for path, said in (
            (tmp_path / "pipe", "it is a pipe, not a file"),
            (tmp_path / "socket", "No such device or address"),
            (tmp_path, "Is a directory"),
            ("/dev/zero", "it is a device, not a file"),
            (tmp_path / "none", "No such file or directory"),
        ):
            with pytest.raises(OSError, match=said):
                open_file(path)
    for read in (read_limited, read_text):
        with pytest.raises(OSError, match="it is a pipe, not a file"):
            read(tmp_path / "pipe")
