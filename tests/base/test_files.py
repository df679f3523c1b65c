"""Files: sizes, whole writes, pipes."""

import errno
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from libgz import WorldFile
from libgz.base import files
from libgz.base.errors import LibraryError, WorldFileError
from libgz.base.files import own_cache, read_limited, write_whole
from libgz.classic_cxx import library as classic_cxx
from libgz.sdf.reader import SdfFile


@pytest.mark.parametrize("load", [WorldFile.from_file, SdfFile.load])
def test_a_file_that_is_too_large_is_not_read(tmp_path, monkeypatch, load):
    path = tmp_path / "large.world"
    path.write_text("<gz:world xmlns:gz='g'/>")
    os.truncate(path, 1 << 40)  # without blocks of the disk: more than there is memory
    monkeypatch.setattr(files, "LARGEST_FILE", 10)
    with pytest.raises(WorldFileError, match="it is larger than 0 MiB"):
        load(path)


@pytest.mark.parametrize("find", [own_cache, classic_cxx.cache_folder])
def test_code_is_kept_in_no_folder_of_another_user(tmp_path, monkeypatch, find):
    """As in one of a directory that all may write, or of a home that sudo has kept."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    words = ("libgz",) if find is own_cache else ()
    folder = find(*words)
    assert folder.is_relative_to(tmp_path)
    folder.mkdir(parents=True, exist_ok=True)
    assert find(*words) == folder
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    with pytest.raises(LibraryError, match="is no directory of user 12345, and what it holds would be run"):
        find(*words)
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder.chmod(0o777)
    with pytest.raises(LibraryError, match="can be written by all users, and what it holds would be run"):
        find(*words)


@pytest.mark.parametrize("mine", [True, False])
def test_the_cache_may_be_a_link_of_the_user_to_a_folder_of_the_user(tmp_path, monkeypatch, mine):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "libgz").symlink_to(tmp_path / "elsewhere")
    if mine:
        assert own_cache("libgz") == tmp_path / "libgz"
        return
    lstat = Path.lstat

    def of_another(path):
        about = list(lstat(path))
        about[4] += 1  # st_uid
        return os.stat_result(about)

    monkeypatch.setattr(Path, "lstat", of_another)
    with pytest.raises(LibraryError, match="is no directory of user"):
        own_cache("libgz")


def test_what_is_kept_in_the_cache_is_nobody_elses_whatever_the_umask(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    before = os.umask(0)
    try:
        own_cache("libgz", "code", create=True)
    finally:
        os.umask(before)
    folder = own_cache("libgz", "code")
    assert [one.stat().st_mode & 0o777 for one in (folder, folder.parent, tmp_path / "cache")] == [0o700] * 3


def test_a_folder_that_another_user_makes_at_the_same_moment_is_refused(tmp_path, monkeypatch):
    def of_another(path, mode=0o777, parents=False, exist_ok=False):
        os.mkdir(path)  # noqa: PTH102
        path.chmod(0o777)

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(Path, "mkdir", of_another)
    with pytest.raises(LibraryError, match="can be written by all users"):
        own_cache("libgz", "code", create=True)


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


KILLED = """
import os, signal, sys
from pathlib import Path
from libgz.base import files
os.fchmod = lambda *_: os.kill(os.getpid(), signal.SIGKILL)  # everything is written, and has no name yet
files.write_whole(Path(sys.argv[1]), b"new" * 1000)
"""


def test_a_killed_process_leaves_the_file_and_nothing_else(tmp_path):
    target = tmp_path / "kept.state"
    target.write_bytes(b"old")
    done = subprocess.run([sys.executable, "-c", KILLED, target], capture_output=True, timeout=60)
    assert done.returncode == -signal.SIGKILL
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"kept.state": b"old"}


@pytest.mark.parametrize("unnamed", [True, False])
@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "full"), KeyboardInterrupt()])
def test_a_file_whose_writing_ends_early_is_as_before(tmp_path, monkeypatch, error, unnamed):
    target = tmp_path / ("x" * 255)
    target.write_bytes(b"old")
    target.chmod(0o640)
    if not unnamed:  # a file system that has no files without a name
        monkeypatch.setattr(os, "O_TMPFILE", os.O_TMPFILE | os.O_CREAT)  # EINVAL
    write_whole(target, b"new")
    assert (target.read_bytes(), target.stat().st_mode & 0o777) == (b"new", 0o640)

    def fail(*_):
        raise error

    monkeypatch.setattr(os, "fchmod", fail)
    with pytest.raises(type(error)):
        write_whole(target, b"newer")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {target.name: b"new"}


@pytest.mark.parametrize("allowed", [True, False])
def test_folders_that_cannot_be_listed_are_none(tmp_path, monkeypatch, allowed):
    """Root may read all, so that modes of files do not show it."""
    asked = []
    monkeypatch.setattr(os, "access", lambda path, mode: asked.append((path, mode)) or allowed)
    assert files.is_folder(tmp_path) is allowed
    assert asked == [(tmp_path, os.R_OK | os.X_OK)]


def test_files_that_this_user_may_not_write_are_kept(tmp_path, monkeypatch):
    target = tmp_path / "a.world"
    target.write_bytes(b"old")
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    with pytest.raises(PermissionError, match="it is write-protected"):
        write_whole(target, b"new")
    assert target.read_bytes() == b"old"
    monkeypatch.undo()
    target.chmod(0o444)
    with pytest.raises(PermissionError, match="it is write-protected"):
        write_whole(target, b"new")
    assert target.read_bytes() == b"old"


def test_a_world_may_have_64_mebibytes():
    assert files.LARGEST_FILE == 1 << 26


def test_what_is_no_file_is_named(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(tmp_path / "socket"))
        (tmp_path / "device").symlink_to("/dev/null")
        for name, what in (("pipe", "it is a pipe"), ("device", "it is a device"), ("socket", "No such device")):
            with pytest.raises(OSError, match=what):
                files.open_file(tmp_path / name)
    with pytest.raises(IsADirectoryError):
        files.open_file(tmp_path)


def test_a_file_that_has_nothing_to_read_yet_is_named(tmp_path, monkeypatch):
    """/proc/kmsg is one: it says that it is a file, and who reads it waits for a message of the kernel."""

    def read(*_values):
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    (tmp_path / "file").touch()
    monkeypatch.setattr(os, "pread", read)
    with pytest.raises(BlockingIOError, match=f"temporarily unavailable: '{tmp_path / 'file'}'"):
        files.open_file(tmp_path / "file")


@pytest.mark.parametrize("unnamed", [True, False])
def test_what_is_being_written_belongs_to_its_user_alone(tmp_path, monkeypatch, unnamed):
    opened, asked = os.open, []

    def note(path, flags, mode=0o777, **where):
        if flags & os.O_WRONLY:
            asked.append(mode)
            if not unnamed and flags & os.O_TMPFILE == os.O_TMPFILE:
                raise OSError(errno.EOPNOTSUPP, "no such files here")
        return opened(path, flags, mode, **where)

    monkeypatch.setattr(os, "open", note)
    write_whole(tmp_path / "file", b"text")
    assert set(asked) == {0o600}
    assert (tmp_path / "file").read_bytes() == b"text"


def test_a_name_that_no_file_can_have_is_an_error_of_files(tmp_path):
    for name in ("a\0b", "x" * 5000):
        with pytest.raises(OSError, match=r"null byte|File name too long"):
            files.open_file(tmp_path / name)


def test_a_link_to_itself_is_replaced(tmp_path):
    target = tmp_path / "loop"
    target.symlink_to("loop")
    write_whole(target, b"data")
    assert target.read_bytes() == b"data"
    assert not target.is_symlink()


def test_a_bound_takes_no_memory_of_its_own(tmp_path):
    """A small file is read where there is no room for the largest that would be read."""
    path = tmp_path / "small.3ds"
    path.write_bytes(b"few bytes")
    assert read_limited(path, 1 << 46) == b"few bytes"
    assert read_limited(path, 9) == b"few bytes"
    with pytest.raises(OSError, match="larger than 0 MiB"):
        read_limited(path, 8)
    status = read_limited(Path("/proc/self/cmdline"))  # whose size is 0
    assert status.startswith(os.fsencode(sys.executable)[:1])
    with pytest.raises(OSError, match="larger than 0 MiB"):
        read_limited(Path("/proc/self/cmdline"), 3)
