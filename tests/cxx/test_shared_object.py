"""SharedObject: files that lie about themselves, and folders that are left."""

import os
import shutil
import struct
import tempfile
from pathlib import Path

import pytest

import libgz.ode
from libgz.base.errors import PluginError
from libgz.cxx import shared_object
from libgz.cxx.shared_object import DYNAMIC_SYMBOLS, SharedObject

LIBRARY = Path(libgz.ode.__file__).with_name("_step.so")
SECTIONS = 0x28  # place of the table of sections in a file
PLACE, LENGTH = 0x18, 0x20  # in an entry of it


def symbols_of(data):
    """Where the entry of the dynamic symbols begins."""
    (start,) = struct.unpack_from("<Q", data, SECTIONS)
    size, count = struct.unpack_from("<HH", data, 0x3A)
    starts = range(start, start + size * count, size)
    return next(one for one in starts if struct.unpack_from("<I", data, one + 4)[0] == DYNAMIC_SYMBOLS)


@pytest.mark.parametrize("value", [25, 24 * 10**7, 2**40, 2**63, 2**64 - 1])
@pytest.mark.parametrize("field", ["sections", "place", "length"])
def test_tables_that_do_not_fit_are_an_error_of_the_plugin(tmp_path, field, value):
    data = bytearray(LIBRARY.read_bytes())
    symbols = symbols_of(data)
    if field == "sections":
        value = max(value, len(data))
    if field == "place":
        value = max(value, len(data) + 1)
    place = {"sections": SECTIONS, "place": symbols + PLACE, "length": symbols + LENGTH}[field]
    struct.pack_into("<Q", data, place, value)
    path = tmp_path / "libodd.so"
    path.write_bytes(data)
    with pytest.raises(PluginError, match=r"libodd.so: the file is truncated; build it again"):
        SharedObject(path)


@pytest.fixture
def left(tmp_path, monkeypatch):
    """A folder of a process that is no more."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    folder = tmp_path / f"{shared_object.FOLDER}{2**40}-x"
    folder.mkdir()
    (folder / "libold.so").touch()
    return folder


def test_folders_of_processes_that_crashed_are_removed(left):
    SharedObject(LIBRARY)
    assert not left.exists()


def test_folders_of_others_are_left_alone(left, monkeypatch):
    user = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: user + 1)
    SharedObject(LIBRARY)
    assert (left / "libold.so").exists()


def test_links_are_not_followed(left, tmp_path):
    shutil.rmtree(left)
    (tmp_path / "kept").mkdir()
    left.symlink_to(tmp_path / "kept")
    SharedObject(LIBRARY)
    assert (tmp_path / "kept").is_dir()
