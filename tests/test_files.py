"""Files: sizes, whole writes, pipes."""

import os

import pytest

from libgz import WorldFile, files
from libgz.errors import WorldFileError
from libgz.files import write_whole
from libgz.sdf.reader import SdfFile


@pytest.mark.parametrize("load", [WorldFile.from_file, SdfFile.load])
def test_a_file_that_is_too_large_is_not_read(tmp_path, monkeypatch, load):
    path = tmp_path / "large.world"
    path.write_text("<gz:world xmlns:gz='g'/>")
    monkeypatch.setattr(files, "LARGEST_FILE", 10)
    with pytest.raises(WorldFileError, match="it is larger than 0 MiB"):
        load(path)


def test_pipes_and_devices_are_written_to_and_never_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reading = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, b"text")
    assert os.read(reading, 100) == b"text"
    os.close(reading)
    assert pipe.is_fifo()


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    target = tmp_path / "no" / "such.world"
    with pytest.raises(FileNotFoundError) as raised:
        write_whole(target, b"")
    assert raised.value.filename == str(target)
