"""The server's side of the wire: its directory, its semaphores, and the interfaces it serves."""

from __future__ import annotations

import atexit
import contextlib
import errno
import fcntl
import logging
import os
import stat
from typing import TYPE_CHECKING, Any

from libgz.errors import ParameterError, ServerError
from libgz.transport.layout import LIBGAZEBO_VERSION, VERSIONS
from libgz.transport.paths import LOCK_FILE, check_server_id, server_directory
from libgz.transport.semaphores import SemaphoreSet

if TYPE_CHECKING:
    from libgz.transport.interface import Interface

__all__ = ["LocalServer", "Server", "alive", "free_server_id"]

log = logging.getLogger("libgz.transport")

_running: set[Server] = set()

_FILE_FLAGS = os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC


class LocalServer:
    """A server without a wire: its interfaces are memory of this process, for worlds that run in process.

    Args:
        version: what interfaces announce.

    Raises:
        ParameterError: there is no such version.
    """

    server_id: int | None = None

    def __init__(self, version: int = LIBGAZEBO_VERSION) -> None:
        if version not in VERSIONS:
            allowed = ", ".join(f"{known:#05x}" for known in VERSIONS)
            raise ParameterError(f"wire version is {version:#05x}; allowed are {allowed}")
        self.version = version
        self.interfaces: dict[tuple[str, str], Interface[Any]] = {}

    def start(self) -> None:
        """Nothing to do."""

    def claim(self, interface: Interface[Any]) -> bool:
        """Take an interface in; false if one of its type and id is there already."""
        key = (interface.type, interface.id)
        if key in self.interfaces:
            log.warning(
                "there is a second %s interface with id %r: the first one is served, the second model runs without it",
                *key,
            )
            return False
        self.interfaces[key] = interface
        return True

    def release(self, interface: Interface[Any]) -> None:
        """Let an interface go."""
        key = (interface.type, interface.id)
        if self.interfaces.get(key) is interface:
            del self.interfaces[key]

    def post(self) -> None:
        """Wake all clients: there are none."""

    def stop(self) -> None:
        """Destroy what models left behind."""
        for interface in list(self.interfaces.values()):
            interface.destroy()


class Server(LocalServer):
    """A server of the wire.

    Args:
        server_id: 0 and up; several servers on one machine need different ones.
        force: take over an id whose owner cannot be told to be dead. A server that is alive is never disturbed.
        version: what interfaces announce, and lie by: 0x060, or 0x050 for clients of Gazebo 0.5.
    """

    server_id: int

    def __init__(self, server_id: int = 0, force: bool = False, version: int = LIBGAZEBO_VERSION) -> None:
        super().__init__(version)
        self.server_id = check_server_id(server_id)
        self.force = force
        self.path = server_directory(self.server_id)
        self._directory: int | None = None
        self._lock: int | None = None
        self._semaphores: SemaphoreSet | None = None
        self._gone = False
        self._pid = os.getpid()

    # Start -------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Make the directory and the semaphores; what a dead server left is cleared away.

        Raises:
            ServerError: the id is in use, or the directory cannot be used.
        """
        self._pid = os.getpid()
        self._open_directory()
        try:
            self._take_lock()
            left = self._left_semaphores()
            # Old files go before new semaphores come: a client that finds the new set never opens an old file.
            self._remove_files()
            self._make_semaphores(left)
        except BaseException as error:
            self._abandon()
            if isinstance(error, OSError):
                raise self._unusable(error) from None
            raise
        _running.add(self)
        log.debug("creating %s", self.path)

    def _abandon(self) -> None:
        """Leave no trace of a start that failed."""
        if self._lock is not None:
            self.unlink_file(LOCK_FILE, self._lock)
            with contextlib.suppress(OSError):
                os.rmdir(self.path)  # noqa: PTH106
            os.close(self._lock)
            self._lock = None
        self._close_directory()

    def _open_directory(self) -> None:
        """Make the directory, or open the one that is there if it is ours alone."""
        try:
            with contextlib.suppress(FileExistsError):
                os.mkdir(self.path, 0o700)  # noqa: PTH102
            self._directory = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
        except OSError as error:
            raise self._unusable(error) from None
        about = os.fstat(self._directory)
        if about.st_uid != os.geteuid():
            self._close_directory()
            raise ServerError(f"{self.path} belongs to another user (uid {about.st_uid}); use another server id: -s")
        if about.st_mode & 0o077:
            os.fchmod(self._directory, 0o700)

    def _unusable(self, error: OSError) -> ServerError:
        return ServerError(
            f"cannot use {self.path} as the server's directory: {error.strerror}; "
            "set TMP to a directory you may write in, or use another server id: -s"
        )

    def _take_lock(self) -> None:
        """Hold a lock for as long as this process lives; whoever cannot have it knows that we are alive."""
        lock = os.open(LOCK_FILE, _FILE_FLAGS | os.O_CREAT, 0o600, dir_fd=self._directory)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            owner = os.pread(lock, 32, 0).split() or [b"unknown"]
            os.close(lock)
            raise self._in_use(f"pid {owner[0].decode(errors='replace')}", "") from None
        self._lock = lock
        os.ftruncate(lock, 0)
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)

    def _in_use(self, who: str, advice: str) -> ServerError:
        return ServerError(
            f"there is another server running with id {self.server_id} ({who}); use -s to try a different server id"
            + advice
        )

    def _left_semaphores(self) -> SemaphoreSet | None:
        """The set of a dead server, or of any server if force is on; None if there is no set."""
        try:
            semaphores = SemaphoreSet.attach(self.server_id)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self._in_use(f"its semaphores belong to another user: {error.strerror}", "") from None
        poster = semaphores.last_poster()
        if not self.force and poster != os.getpid() and alive(poster):
            # Our own lock was free, so this is a server of another kind, or one that lost its directory.
            advice = ", or -f if you definitely want to use this id"
            raise self._in_use(f"pid {poster} posts to its semaphores", advice)
        return semaphores

    def _make_semaphores(self, left: SemaphoreSet | None) -> None:
        """Create the set. One that a dead server left is removed, not used again: who waits on it must learn that the
        files it has open are nobody's any more."""
        try:
            if left is not None:
                log.info("removing the semaphores that a dead server left (id %d)", self.server_id)
                left.remove()
            self._semaphores = SemaphoreSet.create(self.server_id)
        except FileExistsError:
            raise self._in_use("it started just now", "") from None
        except OSError as error:
            raise ServerError(f"failed to allocate semaphore [{error.strerror}]") from None

    def _remove_files(self) -> None:
        """Remove what a dead server left in the directory. Links are removed, never followed."""
        for name in os.listdir(self._directory):  # noqa: PTH208
            about = os.stat(name, dir_fd=self._directory, follow_symlinks=False)
            if name != LOCK_FILE and not stat.S_ISDIR(about.st_mode):
                log.info("removing %s/%s, left by a dead server", self.path, name)
                os.unlink(name, dir_fd=self._directory)

    # Files -------------------------------------------------------------------------------------------------------

    def create_file(self, name: str, size: int) -> int:
        """A new file of zeros in the directory, mode 0600, hidden until `show_file`; its descriptor.

        A client that opens a file must find it whole, its head included.

        Raises:
            OSError: it cannot be made.
        """
        flags, hidden = _FILE_FLAGS | os.O_CREAT | os.O_TRUNC, _hidden(name)
        try:
            descriptor = os.open(hidden, flags, 0o600, dir_fd=self._directory)
        except FileNotFoundError:
            # Some old programs delete every server's directory before they start their own.
            log.warning("the directory %s was removed under the running server, and is made again", self.path)
            if self._directory is not None:
                os.close(self._directory)
            self._open_directory()
            descriptor = os.open(hidden, flags, 0o600, dir_fd=self._directory)
        try:
            # Not only its length: a page of shared memory that the disk has no room for kills who touches it.
            os.posix_fallocate(descriptor, 0, size)
        except OSError:
            self.unlink_file(hidden, descriptor)
            os.close(descriptor)
            raise
        log.debug("creating %s/%s %d", self.path, name, size)
        return descriptor

    def show_file(self, name: str) -> None:
        """Give a new file its name, in place of one that has it.

        Raises:
            OSError: it is gone.
        """
        os.rename(_hidden(name), name, src_dir_fd=self._directory, dst_dir_fd=self._directory)

    def unlink_file(self, name: str, descriptor: int) -> None:
        """Remove a file if it is still the one behind `descriptor`; in a child that was forked, leave it."""
        if not self._is_own():
            return
        with contextlib.suppress(FileNotFoundError):
            there = os.stat(name, dir_fd=self._directory, follow_symlinks=False)
            if os.path.samestat(there, os.fstat(descriptor)):
                os.unlink(name, dir_fd=self._directory)
        log.debug("deleting %s/%s", self.path, name)

    # Run and stop ------------------------------------------------------------------------------------------------

    def post(self) -> None:
        """Wake all clients."""
        if self._semaphores is None or self._gone:
            return
        try:
            self._semaphores.post()
        except OSError as error:
            self._gone = True
            log.warning(
                "the semaphores of server %d were removed (%s): clients cannot wait any more",
                self.server_id,
                error.strerror,
            )

    def stop(self) -> None:
        """Remove all files, the directory and the semaphores. Can be called twice."""
        super().stop()
        _running.discard(self)
        if self._lock is not None:
            if self._is_own():
                self._remove_directory()
            os.close(self._lock)
            self._lock = None
        if self._semaphores is not None:
            if self._is_own():
                with contextlib.suppress(OSError):
                    self._semaphores.remove()
            self._semaphores = None
        self._close_directory()

    def _is_own(self) -> bool:
        """Whether this process started the server: a child that a program forks has a copy, and must not end it."""
        return os.getpid() == self._pid

    def _remove_directory(self) -> None:
        if self._lock is not None:
            self.unlink_file(LOCK_FILE, self._lock)
        try:
            os.rmdir(self.path)  # noqa: PTH106
        except FileNotFoundError:
            return
        except OSError as error:
            if error.errno != errno.ENOTEMPTY:
                log.warning("failed to cleanly remove [%s] : [%s]", self.path, error.strerror)
                return
            log.info("failed to cleanly remove [%s]: it holds files that are not the server's", self.path)
            self._remove_files()
            with contextlib.suppress(OSError):
                os.rmdir(self.path)  # noqa: PTH106

    def _close_directory(self) -> None:
        if self._directory is not None:
            os.close(self._directory)
            self._directory = None


@atexit.register
def _stop_all() -> None:
    """Leave nothing behind of servers whose program ended without closing their worlds."""
    for server in list(_running):
        server.stop()


def free_server_id() -> int:
    """The lowest id that no server, dead or alive, has semaphores or a directory for.

    Raises:
        ServerError: the first thousand are all taken.
    """
    for server_id in range(1000):
        try:
            SemaphoreSet.attach(server_id)
        except FileNotFoundError:
            if not os.path.lexists(server_directory(server_id)):
                return server_id
        except OSError:
            continue
    raise ServerError("server ids 0 to 999 are all taken; name another one: -s")


def alive(pid: int) -> bool:
    """Whether a process lives; pid 0, of another pid namespace, counts as alive."""
    if pid == 0:
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def _hidden(name: str) -> str:
    return f".{name}.new"
