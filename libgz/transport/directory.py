"""ServerDirectory: a server's directory, its lock file and its interface files."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import logging
import mmap
import os
import stat

from libgz.base.errors import ServerError
from libgz.transport.paths import CONTROL_SOCKET, LOCK_FILE
from libgz.transport.segment import Segment, raise_file_limit

__all__ = ["ServerDirectory"]

log = logging.getLogger("libgz.transport")

_FILE_FLAGS = os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC


class ServerDirectory:
    """A directory that one server uses at a time: the one that holds the lock on its lock file.

    Args:
        path: the directory; it need not exist yet.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._descriptor: int | None = None
        self._lock: int | None = None
        self._created = {CONTROL_SOCKET}  # names of this server's files, which may be removed already
        self._pid = os.getpid()

    @property
    def locked(self) -> bool:
        """Whether this object holds the lock."""
        return self._lock is not None

    @property
    def owned(self) -> bool:
        """Whether this process took the lock; False in a forked child, which must not remove anything."""
        return os.getpid() == self._pid

    def open(self) -> None:
        """Create the directory, or open it if it exists and belongs to this user only.

        Raises:
            ServerError: it cannot be used.
        """
        try:
            with contextlib.suppress(FileExistsError):
                os.mkdir(self.path, 0o700)  # noqa: PTH102
            self._descriptor = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
        except OSError as error:
            raise self.unusable(error) from None
        about = os.fstat(self._descriptor)
        if about.st_uid != os.geteuid():
            self._close()
            raise ServerError(f"{self.path} belongs to another user (uid {about.st_uid}); use another server id: -s")
        if about.st_mode & 0o077:
            os.fchmod(self._descriptor, 0o700)

    def unusable(self, error: OSError) -> ServerError:
        """The error for a directory that cannot be used."""
        return ServerError(
            f"cannot use {self.path} as the server's directory: {error.strerror}; "
            "set TMP to a directory you may write in, or use another server id: -s"
        )

    def take_lock(self) -> str | None:
        """Hold a lock for as long as this process lives, as proof that the server is alive.

        Returns:
            None, or the pid of the live server that holds the lock.

        Raises:
            OSError: the lock file cannot be written.
        """
        self._pid = os.getpid()
        lock = os.open(LOCK_FILE, _FILE_FLAGS | os.O_CREAT, 0o600, dir_fd=self._descriptor)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            owner = os.pread(lock, 32, 0).split() or [b"unknown"]
            os.close(lock)
            return owner[0].decode(errors="replace")
        self._lock = lock
        os.ftruncate(lock, 0)
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)
        return None

    def create_file(self, name: str, size: int) -> Segment:
        """Create a file of `size` zero bytes with mode 0600, hidden until `show_file`, and map it.

        A client must not open a file before it is complete, its head included.

        Raises:
            OSError: it cannot be created or mapped.
            ServerError: the directory was removed and cannot be created again.
        """
        flags, hidden = _FILE_FLAGS | os.O_CREAT | os.O_TRUNC, _hidden(name)
        try:
            descriptor = os.open(hidden, flags, 0o600, dir_fd=self._descriptor)
        except FileNotFoundError:
            # Some old programs delete every server's directory before they start their own.
            log.warning("the directory %s was removed under the running server; it is created again", self.path)
            if self._descriptor is not None:
                os.close(self._descriptor)
            self.open()
            descriptor = os.open(hidden, flags, 0o600, dir_fd=self._descriptor)
        try:
            # Allocate the blocks, too: access to a mapped page that does not fit on a full disk raises SIGBUS.
            os.posix_fallocate(descriptor, 0, size)
            segment = Segment(mmap.mmap(descriptor, size), descriptor)
        except OSError:
            self.unlink_file(hidden, descriptor)
            os.close(descriptor)
            raise
        raise_file_limit(descriptor)
        log.debug("creating %s/%s %d", self.path, name, size)
        self._created.add(name)
        return segment

    def show_file(self, name: str) -> None:
        """Give a hidden file its name, and replace an existing file of that name.

        Raises:
            OSError: the hidden file was removed.
        """
        os.rename(_hidden(name), name, src_dir_fd=self._descriptor, dst_dir_fd=self._descriptor)

    def write_file(self, name: str, content: bytes) -> None:
        """Write a whole file with mode 0600; readers see the former one or this one.

        Raises:
            OSError: it cannot be written.
            ServerError: the directory was removed and cannot be created again.
        """
        segment = self.create_file(name, max(len(content), 1))
        descriptor, left = segment.descriptor or 0, memoryview(content)
        try:
            while left:
                left = left[os.write(descriptor, left) :]
            self.show_file(name)
        except OSError:
            self.unlink_file(_hidden(name), descriptor)
            raise
        finally:
            os.close(descriptor)

    def remove_file(self, name: str) -> None:
        """Remove a file of this server, if it is there. A forked child removes nothing."""
        if self.owned and self._descriptor is not None:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(name, dir_fd=self._descriptor)
            self._created.discard(name)

    def unlink_file(self, name: str, descriptor: int) -> None:
        """Remove a file if it is the one behind `descriptor`. A forked child removes nothing."""
        if not self.owned:
            return
        with contextlib.suppress(FileNotFoundError):
            current = os.stat(name, dir_fd=self._descriptor, follow_symlinks=False)
            if os.path.samestat(current, os.fstat(descriptor)):
                os.unlink(name, dir_fd=self._descriptor)
                self._created.discard(name)
        log.debug("deleting %s/%s", self.path, name)

    def remove_stale_files(self) -> None:
        """Remove all files but the lock file. Links are removed and never followed.

        Raises:
            OSError: a file cannot be removed.
        """
        for name in os.listdir(self._descriptor):  # noqa: PTH208
            about = os.stat(name, dir_fd=self._descriptor, follow_symlinks=False)
            if name != LOCK_FILE and not stat.S_ISDIR(about.st_mode):
                log.info("removing stale file %s/%s", self.path, name)
                os.unlink(name, dir_fd=self._descriptor)

    def abandon(self) -> None:
        """Undo `open` and `take_lock` after a failed start."""
        if self._lock is not None:
            self.unlink_file(LOCK_FILE, self._lock)
            with contextlib.suppress(OSError):
                os.rmdir(self.path)  # noqa: PTH106
        self._close()

    def remove(self) -> None:
        """Remove the directory and release its lock. A forked child only closes its descriptors."""
        if self._lock is not None and self.owned:
            self.unlink_file(LOCK_FILE, self._lock)
            self._remove_directory()
        self._close()

    def _remove_directory(self) -> None:
        try:
            os.rmdir(self.path)  # noqa: PTH106
        except FileNotFoundError:
            return
        except OSError as error:
            if error.errno != errno.ENOTEMPTY:
                log.warning("failed to cleanly remove [%s] : [%s]", self.path, error.strerror)
                return
            # After a second signal, which waits for nothing, the server's own files are still there.
            for name in self._created:
                with contextlib.suppress(OSError):
                    os.unlink(name, dir_fd=self._descriptor)
            if os.listdir(self._descriptor):  # noqa: PTH208
                log.info("failed to cleanly remove [%s]: it contains files that are not the server's", self.path)
                self.remove_stale_files()
            with contextlib.suppress(OSError):
                os.rmdir(self.path)  # noqa: PTH106

    def _close(self) -> None:
        for descriptor in (self._lock, self._descriptor):
            if descriptor is not None:
                os.close(descriptor)
        self._lock = self._descriptor = None


def _hidden(name: str) -> str:
    return f".{name}.new"
