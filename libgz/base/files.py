"""Files: read up to a size, replaced in one step, parsed safely as XML; and where those of libgz are installed."""

from __future__ import annotations

import contextlib
import errno
import importlib.util
import io
import os
import stat
from pathlib import Path

from lxml import etree

from libgz.base.errors import LibraryError, WorldFileError

__all__ = [
    "check_size",
    "exists",
    "expand",
    "installed_worlds",
    "is_file",
    "is_folder",
    "new_file",
    "open_file",
    "own_cache",
    "read_file",
    "read_limited",
    "read_text",
    "save_file",
    "write_whole",
    "xml_attribute",
    "xml_parser",
    "xml_text",
]

PIECE = 1 << 16  # [bytes] read at once of a file that has more than its size says
LARGEST_FILE = 64 * 1024 * 1024  # bytes of a world

# Not those of xml.sax.saxutils, which imports urllib.request, ssl and email: a tenth of the start of a command.
_IN_TEXT = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})
_IN_ATTRIBUTE = _IN_TEXT | str.maketrans(
    {'"': "&quot;", "'": "&apos;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"},
)


def exists(path: Path) -> bool:
    """Whether there is such a file or folder; false for what cannot be asked for, such as too long a name."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def is_file(path: Path) -> bool:
    """Whether there is such a file; false for what cannot be asked for, such as too long a name."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Whether there is such a folder, and its contents can be listed."""
    try:
        return path.is_dir() and os.access(path, os.R_OK | os.X_OK)
    except (OSError, ValueError):
        return False


def expand(name: str) -> Path:
    """A path whose `~` is expanded; one that begins with the home of an unknown user stays as it is."""
    try:
        return Path(name).expanduser()
    except RuntimeError:
        return Path(name)


def open_file(path: str | os.PathLike[str]) -> io.BufferedReader:
    """Open a file for reading, but no pipe, socket or device, nor what has nothing to read yet: those may never end.

    Raises:
        OSError: it cannot be opened, or is none; `strerror` says what it is.
    """
    # Not blocking, because opening a pipe waits for its writer. What is opened is checked, not what has the name.
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY)
    except ValueError as error:  # a NUL in it
        raise OSError(errno.EINVAL, str(error), os.fspath(path)) from None
    try:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
        if not stat.S_ISREG(mode):
            kind = "pipe" if stat.S_ISFIFO(mode) else "socket" if stat.S_ISSOCK(mode) else "device"
            raise OSError(errno.EINVAL, f"it is a {kind}, not a file", os.fspath(path))
        try:
            os.pread(descriptor, 1, 0)
        except OSError as error:  # such as of /proc/kmsg, which says that it is a file
            raise OSError(error.errno, error.strerror, os.fspath(path)) from None
        return open(descriptor, "rb")  # noqa: PTH123 - for the caller's `with`
    except BaseException:
        os.close(descriptor)
        raise


def read_file(path: str | os.PathLike[str]) -> bytes:
    """The bytes of a file that is no pipe, socket or device.

    Raises:
        OSError: the file cannot be read.
    """
    with open_file(path) as file:
        return file.read()


def read_text(path: str | os.PathLike[str]) -> str:
    """The text of a file that is no pipe, socket or device; bytes that are no UTF-8 are replaced.

    Raises:
        OSError: the file cannot be read.
    """
    with io.TextIOWrapper(open_file(path), encoding="utf-8", errors="replace") as file:
        return file.read()


def read_limited(path: Path, most: int | None = None) -> bytes:
    """The bytes of a file of at most so many, by default the 64 MiB of a world or model.

    Raises:
        OSError: the file cannot be read, or is larger.
    """
    most = LARGEST_FILE if most is None else most
    with open_file(path) as file:
        # Not by the size alone that the system gives: /proc has files of 0 bytes. What is asked for is allocated first.
        size = os.fstat(file.fileno()).st_size
        parts, left = [], most + 1 if size <= most else 0
        while left > 0 and (part := file.read(min(left, max(size + 1, PIECE)))):
            parts.append(part)
            left -= len(part)
    data = b"".join(parts)
    if max(size, len(data)) > most:
        raise OSError(errno.EFBIG, f"it is larger than {most >> 20} MiB", str(path))
    return data


def check_size(data: bytes, label: str) -> None:
    """Refuse to write what `read_limited` would not read.

    Raises:
        WorldFileError: it has more than 64 MiB.
    """
    if len(data) > LARGEST_FILE:
        raise WorldFileError(f"{label} would be larger than {LARGEST_FILE >> 20} MiB, which is the most that is loaded")


def xml_text(text: str) -> str:
    """Text as it stands between the tags of XML."""
    return text.translate(_IN_TEXT)


def xml_attribute(text: str) -> str:
    """The value of an attribute as it stands between its quotes, of either kind."""
    return text.translate(_IN_ATTRIBUTE)


def xml_parser(*, recover: bool = False) -> etree.XMLParser:
    """A parser for files from anywhere: without entities, external files, network access and huge trees.

    Args:
        recover: parse what is not well-formed as far as possible; `error_log` of the parser lists what it skipped.
    """
    return etree.XMLParser(
        recover=recover, resolve_entities=False, no_network=True, load_dtd=False, dtd_validation=False, huge_tree=False
    )


def write_whole(target: Path, data: bytes) -> None:
    """Replace a file in one step, so that no reader ever finds half of it. Pipes and devices are written to.

    Raises:
        OSError: it cannot be written, or is write-protected. `filename` is the target.
    """
    try:
        if target.exists() and not target.is_file():
            target.write_bytes(data)
        else:
            _replace(Path(os.path.realpath(target)), data)  # Path.resolve raises RuntimeError for a link to itself
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(target)) from None


def new_file(name: str, flags: int) -> int:
    """For `open`, the opener of a file to be written, but not what a link names, and no pipe that nobody reads."""
    return os.open(name, flags | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)


def save_file(target: Path, data: bytes, before: bytes | None = None) -> None:
    """Replace a file in one step, as a running server does: a pipe or device, for which it could wait, is refused.

    Args:
        target: the file; for a link, what it names.
        data: what it then has.
        before: kept as `NAME.bak` beside it, in place of what has that name: a link there is not followed.

    Raises:
        OSError: it cannot be written, or is a folder. `filename` is that of the file or of the backup.
    """
    if target.exists() and not target.is_file():
        raise OSError(errno.EINVAL, "it is no plain file", str(target))
    if before is not None:
        name = Path(f"{target}.bak")
        try:
            if name.is_symlink():  # whose target may be write-protected
                name.unlink()
            _replace(name, before)
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(name)) from None
    write_whole(target, data)


def _replace(target: Path, data: bytes) -> None:
    mode = target.stat().st_mode & 0o777 if target.exists() else 0o644
    # Renaming would replace a write-protected file all the same.
    if not mode & 0o222 or (target.exists() and not os.access(target, os.W_OK)):
        raise PermissionError(errno.EACCES, "it is write-protected", str(target))
    folder = os.open(target.parent, os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)  # it need not be readable
    try:
        _write_and_rename(folder, target.name, data, mode)
    finally:
        os.close(folder)


def _write_and_rename(folder: int, name: str, data: bytes, mode: int) -> None:
    """Write a file without a name, which is gone if this process is killed, then give it that of the target."""
    beside, named = f".libgz-{os.urandom(8).hex()}", False
    try:
        try:
            descriptor = os.open(".", os.O_TMPFILE | os.O_WRONLY | os.O_CLOEXEC, 0o600, dir_fd=folder)
        except OSError as error:
            if error.errno not in (errno.EOPNOTSUPP, errno.EISDIR, errno.EINVAL):
                raise
            named = True  # this file system has no such files
            descriptor = os.open(beside, os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_CLOEXEC, 0o600, dir_fd=folder)
        with open(descriptor, "wb") as file:  # noqa: PTH123
            file.write(data)
            file.flush()
            os.fchmod(descriptor, mode)
            if not named:
                named = True
                os.link(f"/proc/self/fd/{descriptor}", beside, dst_dir_fd=folder)
        os.replace(beside, name, src_dir_fd=folder, dst_dir_fd=folder)
    except BaseException:
        if named:
            with contextlib.suppress(OSError):
                os.unlink(beside, dir_fd=folder)
        raise


def own_cache(*parts: str, create: bool = False) -> Path:
    """A folder in the user's cache, below XDG_CACHE_HOME or ~/.cache. It may hold code that is run.

    Args:
        parts: names of folders, each in the one before.
        create: make those that do not exist, for this user only, whatever the umask is; else they need not exist.

    Raises:
        LibraryError: one, or a link to it, belongs to another user, or all users may write there.
        OSError: one cannot be made.
    """
    place = Path(os.environ.get("XDG_CACHE_HOME", ""))
    folder = place if place.is_absolute() else Path.home() / ".cache"
    for part in parts:
        folder /= part
        if create:  # before it is checked: another user may make it at any moment
            _make_private(folder)
        with contextlib.suppress(FileNotFoundError):
            link, about = folder.lstat(), folder.stat()
            problem = ""
            if {link.st_uid, about.st_uid} != {os.geteuid()} or not stat.S_ISDIR(about.st_mode):
                problem = f"is no directory of user {os.geteuid()}"
            elif about.st_mode & stat.S_IWOTH:
                problem = "can be written by all users"
            if problem:
                raise LibraryError(f"{folder} {problem}, and what it holds would be run; set XDG_CACHE_HOME")
    return folder


def _make_private(folder: Path) -> None:
    """Create a folder, and those above it that do not exist, for this user only."""
    if not folder.parent.exists():
        _make_private(folder.parent)
    folder.mkdir(mode=0o700, exist_ok=True)


def installed_worlds() -> Path:
    """The directory of the worlds, textures and skins that are installed with libgz."""
    spec = importlib.util.find_spec("libgz.worlds")
    return Path(spec.origin).parent if spec is not None and spec.origin is not None else Path()
