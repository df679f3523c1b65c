"""Servers of interfaces: in shared memory for other processes, or in the memory of this process."""

from __future__ import annotations

import atexit
import contextlib
import logging
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from libgz.base.errors import ParameterError, ServerError
from libgz.base.records import PostRecord
from libgz.transport import ending
from libgz.transport.directory import ServerDirectory
from libgz.transport.interface import Interface
from libgz.transport.layout import ABIS, LIBGAZEBO_VERSION, NATIVE, VERSIONS
from libgz.transport.paths import LONGEST_PATH, check_server_id, file_name, server_directory
from libgz.transport.patience import Patience
from libgz.transport.segment import Segment
from libgz.transport.semaphores import SemaphoreSet
from libgz.transport.tables import LocalTables, SharedTables
from libgz.transport.tally import Tally

__all__ = ["LocalServer", "Server", "alive", "free_server_id", "on_free_server_id"]

log = logging.getLogger("libgz.transport")

T = TypeVar("T")


class LocalServer:
    """A server for this process only: its interfaces are memory of the process.

    Args:
        version: the wire version that interfaces announce: 0x060 or 0x050.
        abi: of the programs that it serves: ``"x86_64"`` for those of this machine, ``"i386"`` for 32-bit ones.

    Raises:
        ParameterError: the version or the ABI is not supported.
    """

    server_id: int | None = None
    shared: LocalTables | None = None  # what those that look on read, while a server for them runs

    def __init__(self, version: int = LIBGAZEBO_VERSION, abi: str = NATIVE) -> None:
        if abi not in ABIS:
            raise ParameterError(f"ABI is {abi!r}; allowed are {', '.join(ABIS)}")
        if version not in VERSIONS:
            allowed = ", ".join(f"{known:#05x}" for known in VERSIONS)
            raise ParameterError(f"wire version is {version:#05x}; allowed are {allowed}")
        self.version, self.abi = version, abi
        self.patience = Patience()
        self.interfaces: dict[tuple[str, str], Interface[Any]] = {}
        self.place = ""  # ``file:line: `` of the model that creates interfaces now, for messages
        self._kept: dict[tuple[str, str], Segment] | None = None  # of interfaces that may return
        self._returned: set[tuple[str, str]] = set()  # that clients see already
        self._handed: dict[tuple[str, str], Interface[Any]] = {}  # that new interfaces may replace

    def start(self) -> None:
        """Nothing to do."""

    def allocate(self, interface: Interface[Any]) -> Segment:
        """Register a new interface and return zeroed memory for it.

        If there is another interface of this type and id, the server warns, and the memory belongs to this process
        only.

        Raises:
            OSError: the file cannot be created.
        """
        key = (interface.type, interface.id)
        former = self.interfaces.get(key)
        if former is not None and self._handed.get(key) is former and former.size == interface.size:
            segment = former.take_segment()
            self._returned.add(key)
            self.interfaces[key] = interface
            return segment
        if former is not None:
            log.warning(
                "%sthere is a second %s interface with id %r: "
                "the first one is served, the second model runs without it",
                self.place,
                *key,
            )
            return Segment(bytearray(interface.size))
        kept = self._kept.pop(key, None) if self._kept is not None else None
        if kept is not None and len(kept.memory) == interface.size:
            segment = kept
            self._returned.add(key)
        else:
            segment = self._new_segment(file_name(*key), interface.size)
        self.interfaces[key] = interface
        return segment

    def _new_segment(self, name: str, size: int) -> Segment:
        return Segment(bytearray(size))

    def show(self, interface: Interface[Any]) -> None:
        """Nothing to do: there are no clients."""

    def serves(self, interface: Interface[Any]) -> bool:
        """Whether an interface is registered; the second one of a type and id is not."""
        return self.interfaces.get((interface.type, interface.id)) is interface

    def release(self, interface: Interface[Any]) -> None:
        """Remove an interface, if it is registered; in `hand_over` the one that it replaced returns."""
        if self.returns(interface):
            return
        if self.serves(interface):
            del self.interfaces[interface.type, interface.id]
            if self._kept is not None:
                self._kept[interface.type, interface.id] = interface.take_segment()

    @contextlib.contextmanager
    def keep_released(self) -> Iterator[None]:
        """Keep the memory and files of interfaces that are removed until the end, for new ones of their names.

        Clients that have such an interface open stay connected to the new one, and find the old content in it.
        """
        kept = self._kept = {}
        try:
            yield
        finally:
            self._kept = None
            for key, segment in kept.items():
                self._discard(file_name(*key), segment)

    @contextlib.contextmanager
    def hand_over(self, interfaces: Iterable[Interface[Any]]) -> Iterator[None]:
        """Until the end, let new interfaces take the memory of these, if they have the same type, id and size.

        Clients stay connected. If a new one is removed again before the end, the former one serves them on.
        """
        self._handed = {key: one for key, one in self.interfaces.items() if one in list(interfaces)}
        try:
            yield
        finally:
            self._handed = {}

    def returns(self, interface: Interface[Any]) -> bool:
        """Put back the interface that this one had replaced, if it is still open; whether that was done."""
        key = (interface.type, interface.id)
        former = self._handed.get(key)
        if not self.serves(interface) or former is None or former is interface:
            return False
        self.interfaces[key] = former
        former.write_head()
        return True

    def _discard(self, name: str, segment: Segment) -> None:
        """Free the memory of an interface that did not return."""

    def post(self) -> None:
        """Nothing to do: there are no clients."""

    def posting(self) -> PostRecord:
        """What native updates need to wake all clients."""
        return PostRecord(-1, None)

    def vanish(self) -> None:
        """Nothing to do: other processes see nothing of it."""

    def stop(self) -> None:
        """Destroy the interfaces that models have not destroyed. Can be called twice."""
        for interface in list(self.interfaces.values()):
            interface.destroy()


class Server(LocalServer):
    """A server for clients in other processes.

    Args:
        server_id: 0 and up; several servers on one machine need different ones.
        force: take over an id whose owner may be alive, if it is not a server of libgz. A live server of libgz is never
            disturbed.
        version: the wire version that interfaces announce, and whose structs they have: 0x060, or 0x050 for clients of
            Gazebo 0.5.
        abi: of the programs that it serves: ``"x86_64"`` for those of this machine, ``"i386"`` for 32-bit ones.

    Raises:
        ParameterError: the server id, the version or the ABI is invalid, or the path of the directory is too long.
    """

    server_id: int
    force: bool
    _directory: ServerDirectory

    def __init__(
        self, server_id: int = 0, force: bool = False, version: int = LIBGAZEBO_VERSION, abi: str = NATIVE
    ) -> None:
        super().__init__(version, abi)
        self._semaphores: SemaphoreSet | None = None
        self._posting = super().posting()
        self._tally = Tally()
        self.configure(server_id, force)

    @property
    def path(self) -> str:
        """The directory of the interface files."""
        return self._directory.path

    def configure(self, server_id: int, force: bool = False) -> None:
        """Set the id of a server that is not running.

        Raises:
            ParameterError: the server id is invalid, or the path of the directory is too long.
            ServerError: the server is running.
        """
        self._require_stopped()
        self.server_id = check_server_id(server_id)
        self.force = force
        self._directory = ServerDirectory(server_directory(self.server_id))

    def _require_stopped(self) -> None:
        if self._semaphores is not None:
            raise self._in_use(f"pid {os.getpid()}")

    def _in_use(self, who: str, advice: str = "") -> ServerError:
        return ServerError(
            f"there is another server running with id {self.server_id} ({who}); use -s to try a different server id"
            + advice
        )

    # Start -------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Create the directory and the semaphores; stale ones of a dead server are removed first.

        Raises:
            ServerError: the id is in use, or the directory cannot be used.
        """
        self._require_stopped()
        directory = self._directory
        directory.open()
        try:
            owner = directory.take_lock()
            if owner is not None:
                raise self._in_use(f"pid {owner}")
            stale = self._stale_semaphores()
            # Stale files are removed before semaphores are created: a client that finds the new set never opens one.
            directory.remove_stale_files()
            self._use(self._new_semaphores(stale))
        except BaseException as error:
            directory.abandon()
            if isinstance(error, OSError):
                raise directory.unusable(error) from None
            raise
        self.shared = SharedTables(directory)
        atexit.register(self.stop)
        log.debug("creating %s", self.path)

    def _stale_semaphores(self) -> SemaphoreSet | None:
        """The set of a dead server, or of any server if force is on; None if there is no set."""
        try:
            semaphores = SemaphoreSet.attach(self.server_id)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self._in_use(f"its semaphores belong to another user: {error.strerror}") from None
        poster = semaphores.last_poster()
        if not self.force and poster != os.getpid() and alive(poster):
            # This object holds the lock, so this is not a server of libgz, or its directory was removed.
            advice = ", or -f if you definitely want to use this id"
            raise self._in_use(f"pid {poster} posts to its semaphores", advice)
        return semaphores

    def _new_semaphores(self, stale: SemaphoreSet | None) -> SemaphoreSet:
        """Create the set. A stale one is removed, not used again: clients that wait on it must get an error, for the
        files that they have open are stale, too."""
        try:
            if stale is not None:
                log.info("removing stale semaphores of server id %d", self.server_id)
                stale.remove()
            return SemaphoreSet.create(self.server_id)
        except FileExistsError:
            raise self._in_use("it started just now") from None
        except OSError as error:
            raise ServerError(f"failed to allocate semaphore [{error.strerror}]") from None

    # Interfaces --------------------------------------------------------------------------------------------------

    def _new_segment(self, name: str, size: int) -> Segment:
        path = f"{self.path}/{name}"
        if len(os.fsencode(path)) > LONGEST_PATH:
            log.warning(
                "C programs cannot open %s: their limit is a path of %d bytes; shorten TMP or the id",
                path,
                LONGEST_PATH,
            )
        return self._directory.create_file(name, size)

    def show(self, interface: Interface[Any]) -> None:
        """Make an interface visible to clients, once its head is written.

        Raises:
            OSError: the file was removed.
        """
        key = (interface.type, interface.id)
        if key in self._returned:
            self._returned.remove(key)
        elif self.serves(interface):
            self._directory.show_file(file_name(interface.type, interface.id))

    def release(self, interface: Interface[Any]) -> None:
        """Remove an interface and its file, if it is registered."""
        if self.returns(interface):
            return
        if self.serves(interface) and interface.descriptor is not None and self._kept is None:
            self._directory.unlink_file(file_name(interface.type, interface.id), interface.descriptor)
        super().release(interface)

    def _discard(self, name: str, segment: Segment) -> None:
        if segment.descriptor is not None:
            self._directory.unlink_file(name, segment.descriptor)
            os.close(segment.descriptor)

    # Run and stop ------------------------------------------------------------------------------------------------

    def post(self) -> None:
        """Wake all clients; if somebody has removed the semaphores, those that connect from now on."""
        if self._semaphores is None:
            return
        try:
            self._semaphores.post()
        except OSError as error:
            self._replace_semaphores(error)

    def _replace_semaphores(self, why: OSError) -> None:
        """Make new semaphores in place of removed ones, unless another server has the id now."""
        try:
            self._use(SemaphoreSet.create(self.server_id))
            consequence = "clients can connect again"
        except OSError as error:
            consequence = f"new ones cannot be made ({error.strerror}), and clients can no longer wait"
        if self._tally.due(consequence):
            times = self._tally.times(consequence)
            gone = f"the semaphores of server {self.server_id} were removed ({why.strerror})"
            log.warning("%s: %s%s", gone, consequence, times)

    def _use(self, semaphores: SemaphoreSet) -> None:
        """Post to these from now on, in native code, too."""
        self._semaphores, new = semaphores, semaphores.posting()
        self._posting.set, self._posting.values = new.set, new.values
        ending.note(self.path, new.set)

    def posting(self) -> PostRecord:
        """What native updates need to wake all clients; it changes with the semaphores."""
        return self._posting

    def stop(self) -> None:
        """Remove all files, the directory and the semaphores. Can be called twice."""
        super().stop()
        self.vanish()
        self.shared = None

    def vanish(self) -> None:
        """Remove all files, the directory and the semaphores, but leave interfaces mapped, for code that uses them.

        It waits for nothing and can be called from any thread, right before the process ends.
        """
        atexit.unregister(self.stop)
        owned = self._directory.owned
        if self.shared is not None:
            self.shared.close()
        self._directory.remove()
        if self._semaphores is not None:
            if owned:
                with contextlib.suppress(OSError):
                    self._semaphores.remove()
            self._semaphores, self._posting.set = None, -1
        ending.forget(self.path)  # last: native code may end the process meanwhile, and removes what is left


def free_server_id(first: int = 0) -> int:
    """The lowest id from `first` for which there are neither semaphores nor a directory, of live or dead servers.

    Raises:
        ServerError: all up to 999 are taken.
    """
    for server_id in range(first, 1000):
        try:
            SemaphoreSet.attach(server_id)
        except FileNotFoundError:
            if not os.path.lexists(server_directory(server_id)):
                return server_id
        except OSError:
            continue
    raise ServerError(f"server ids {first} to 999 are all taken; name another one: -s")


def on_free_server_id(start: Callable[[int], T]) -> T:
    """Call `start` with a free server id, and with another one if another process takes that first; its result.

    Raises:
        ServerError: ids 0 to 999 are all taken, or the server cannot start for another reason.
    """
    while True:
        server_id = free_server_id()
        try:
            return start(server_id)
        except ServerError:
            if free_server_id() == server_id:
                raise  # the id is still free, so another process did not take it: the error has another cause


def alive(pid: int) -> bool:
    """Whether a process is alive; pid 0, a process of another pid namespace, counts as alive.

    One that has ended does not, though nobody has waited for it: the first process of a container may never do that.
    """
    if pid == 0:
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    with contextlib.suppress(OSError, IndexError, ValueError):
        fields = Path(f"/proc/{pid}/stat").read_bytes().rpartition(b")")[2].split()
        return not (fields[0] == b"Z" and int(fields[17]) <= 1)  # else a thread runs on after the first one's end
    return True
