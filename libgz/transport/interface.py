"""One interface: a struct in a shared file (or in this process's memory), with its lock."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import fcntl
import logging
import mmap
import os
import sys
import time
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Generic, Protocol, TypeAlias, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ClosedError, InterfaceError
from libgz.base.law import constant
from libgz.base.records import LinkRecord, SpanRecord
from libgz.transport.layout import (
    GAZEBO_MAX_MODEL_TYPE,
    LIBGAZEBO_VERSION,
    Data,
    abi_of,
    commands_of,
    fields_of,
    for_abi,
    numpy_type,
)
from libgz.transport.paths import check_id, check_owner, file_name
from libgz.transport.patience import Patience
from libgz.transport.segment import Segment, file_limit_hint, raise_file_limit
from libgz.transport.tally import Tally
from libgz.transport.truncation import Watch, watch

__all__ = ["DataClass", "Interface", "InterfaceClient", "InterfaceServer", "View"]

log = logging.getLogger("libgz.transport")

D = TypeVar("D", bound=Data)
DataClass: TypeAlias = "type[Data]"  # Interface.type hides the builtin

SERVER_TIMEOUT = 0.02  # [s] that a server waits for a lock
_POLL = 0.0002  # [s]
_SPINS = 10  # attempts before the first pause: most clients hold a lock for microseconds
_OVERWRITTEN = "a client overwrote the head of"
_CHECK_PERIOD = 0.05  # [s] between checks of a file's length where its truncation is survived, and copies of commands


class InterfaceServer(Protocol):
    """The server of an interface, as the interface uses it."""

    version: int  # of the wire
    abi: str  # of its clients
    patience: Patience  # with clients that hold locks

    def allocate(self, interface: Interface[Any]) -> Segment:
        """Register a new interface and return zeroed memory of `interface.size` bytes for it.

        Clients do not see it before `show`. If the server has another interface of this type and id, the memory
        belongs to this process only.

        Raises:
            OSError: the file cannot be created.
        """

    def show(self, interface: Interface[Any]) -> None:
        """Make an interface visible to clients, once its head is written.

        Raises:
            OSError: the file cannot be renamed.
        """

    def release(self, interface: Interface[Any]) -> None:
        """Remove an interface and its file."""

    def post(self) -> None:
        """Wake all clients."""


class InterfaceClient(Protocol):
    """The client of an interface, as the interface uses it."""

    path: str  # of the server's directory
    opened: list[Interface[Any]]

    def hint(self, kind: str, name: str) -> str:
        """The end of an error message about an interface that is not served."""


class View:
    """A field of an interface as a numpy array on the shared memory; it is not a copy and takes no lock."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __set_name__(self, owner: type[Interface[Any]], _name: str) -> None:
        field = fields_of(owner.data_class)[self.name]
        unit = f" [{field.unit}]" if field.unit else ""
        shape = f", shape {field.shape}" if field.shape else ""
        self.__doc__ = f"{field.help}{unit}{shape}; a view of the shared memory."

    @overload
    def __get__(self, instance: None, owner: type[Any]) -> View: ...

    @overload
    def __get__(self, instance: Interface[Any], owner: type[Any]) -> NDArray[Any]: ...

    def __get__(self, instance: Interface[Any] | None, owner: type[Any]) -> View | NDArray[Any]:
        if instance is None:
            return self
        return instance.array(self.name)


class Interface(Generic[D]):
    """Base of all interfaces, for servers and clients.

    `data` is the struct as C programs see it; each kind adds numpy views and properties. Take the lock to read or write
    several fields that must be consistent::

        with robot.locked() as data:
            data.cmd_vel_pos[0] = 0.2

    Attributes:
        id: its id.
        layout: the struct.
        server, client: what it is open on.
        descriptor: of its file; None for memory of this process.
        link: what native updates know of it; an exchange is done there or here.
    """

    type: ClassVar[str]
    data_class: ClassVar[DataClass]
    older: ClassVar[Mapping[int, DataClass]] = {}  # wire version -> struct, where it differs
    has_post: ClassVar[bool] = True

    def __init__(self) -> None:
        self.id = ""
        self.layout = self.data_class
        self.server: InterfaceServer | None = None
        self.client: InterfaceClient | None = None
        self.descriptor: int | None = None  # of the file; None for memory of this process
        self._memory: mmap.mmap | bytearray | None = None
        self._data: D | None = None
        self._arrays: dict[str, NDArray[Any]] = {}
        self._owner = ("", 0, 0)  # model type, model id, id of the parent model
        self._head = b""  # as the server wrote it
        self._no_head = b""  # of a file that was truncated
        self._watch: Watch | None = None
        self._tally = Tally()
        self.link = LinkRecord(descriptor=-1)
        self._kept = bytearray()  # what clients had written when it was last found whole
        self._spans: ctypes.Array[SpanRecord] = (SpanRecord * 0)()  # where they write

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.type}.{self.id}{', closed' if self._data is None else self._place()}>"

    def _place(self) -> str:
        """What its `repr` shows of the pose in it, read without the lock; empty for kinds that have none."""
        return ""

    @property
    def model_id(self) -> int:
        """The number of the model that created the interface; server only."""
        return self._owner[1]

    @property
    def size(self) -> int:
        """Size of the struct and of its file [byte]."""
        return ctypes.sizeof(self.layout)

    def layout_for(self, version: int, length: int | None) -> DataClass:
        """The struct of a wire version.

        Args:
            version: the wire version.
            length: size of the file [byte]; None on the server, which creates the file.
        """
        return self.older.get(version, self.data_class)

    @property
    @constant
    def data(self) -> D:
        """The struct on the shared memory.

        Raises:
            ClosedError: the interface is not open.
        """
        if self._data is None:
            raise ClosedError(f"interface {self.type}.{self.id} is not open")
        return self._data

    def array(self, name: str) -> NDArray[Any]:
        """A numeric field as a numpy array on the shared memory.

        Raises:
            ClosedError: the interface is not open.
        """
        found = self._arrays.get(name)
        if found is None:
            _ = self.data
            field = fields_of(self.layout)[name]
            shape = field.shape or ()
            buffer: Any = self._memory
            offset = getattr(self.layout, name).offset
            found = np.ndarray(shape, dtype=numpy_type(field), buffer=buffer, offset=offset)
            self._arrays[name] = found
        return found

    # Server ------------------------------------------------------------------------------------------------------

    def create(
        self,
        server: InterfaceServer,
        id: str | None,
        model_type: str = "",
        model_id: int = 0,
        parent_model_id: int = 0,
    ) -> None:
        """Create the interface on a server.

        If the server already has one of this type and id, the server warns and clients cannot reach this one: its
        memory belongs to this process only.

        Args:
            server: the server.
            id: the interface id, part of the file's name.
            model_type: the class of the model that owns the interface.
            model_id: the number of the model.
            parent_model_id: the number of the model that this model is attached to, or 0.

        Raises:
            InterfaceError: the id is invalid, the interface is open already, or the file cannot be created.
        """
        self.id = check_id(self.type, id)
        self._require_closed()
        self.layout = for_abi(self.layout_for(server.version, None), server.abi)
        self._owner = (model_type, model_id, parent_model_id)
        self.server = server
        try:
            self._map(server.allocate(self))
            self.write_head()
            server.show(self)
        except OSError as error:
            self.destroy()
            reason = f"{error.strerror} ({self.type}.{self.id}){file_limit_hint(error)}"
            raise InterfaceError(f"error creating mmap file: {reason}") from None

    def set_owner(self, model_type: str, model_id: int, parent_model_id: int) -> None:
        """Change the model that owns the interface; server only. See `create`."""
        self._owner = (model_type, model_id, parent_model_id)
        self.write_head()

    def write_head(self) -> None:
        """Write version, size and owner into the memory; server only."""
        head = self.data.head
        model_type, model_id, parent_model_id = self._owner
        head.version = self.server.version if self.server is not None else LIBGAZEBO_VERSION
        head.size = self.size
        head.model_type = model_type.encode()[: GAZEBO_MAX_MODEL_TYPE - 1]
        head.model_id = _int32(model_id)
        head.parent_model_id = _int32(parent_model_id)
        self._set_head(bytes(head))

    def _set_head(self, head: bytes) -> None:
        self._head, self._no_head = head, bytes(len(head))
        self.link.head_size = len(head)
        ctypes.memmove(ctypes.addressof(self.link) + LinkRecord.head.offset, head, len(head))

    @property
    def gap(self) -> tuple[int, int] | None:
        """Where bytes that are no state begin and end now, such as the unused end of an image; None without any."""
        return None

    def get_bytes(self) -> bytes:
        """The bytes that are state, head included; under the lock, if a client does not hold it for long.

        Raises:
            ClosedError: the interface is not open.
        """
        taken = self.lock()
        try:
            memory: Any = self._memory
            gap = self.gap
            if gap is None:
                return bytes(memory)
            begin, end = gap
            with memoryview(memory) as view:
                return b"".join((view[:begin], view[end : self.size]))
        finally:
            if taken:
                self.unlock()

    @property
    def memory(self) -> memoryview:
        """The bytes of the struct, as they are in memory; to be read only, and without the lock.

        Raises:
            ClosedError: the interface is not open.
        """
        if self._memory is None:
            raise ClosedError(f"interface {self.type}.{self.id} is not open")
        return memoryview(self._memory)[: self.size].toreadonly()

    def set_bytes(self, state: bytes) -> None:
        """Write bytes that `get_bytes` returned, head included, and zeros between them.

        Raises:
            InterfaceError: they are too few or too many, as of another wire version.
            ClosedError: the interface is not open.
        """
        taken = self.lock()
        try:
            memory: Any = self._memory
            gap = self.gap
            if gap is None:
                if len(state) != self.size:
                    raise InterfaceError(f"{self.type}.{self.id} has {self.size} bytes, and not {len(state)}")
                memory[:] = state
            else:
                before, end = gap
                begin = len(state) - (self.size - end)
                content = memoryview(state)
                memory[:begin], memory[end : self.size] = content[:begin], content[begin:]
                if before > begin:
                    memory[begin:before] = bytes(before - begin)
            if state[: len(self._head)] != self._head:
                self._set_head(bytes(state[: len(self._head)]))
                head = self.data.head
                self._owner = (head.model_type.decode(errors="replace"), head.model_id, head.parent_model_id)
            if self.descriptor is not None:
                self.keep_commands()
        finally:
            if taken:
                self.unlock()

    def destroy(self) -> None:
        """Remove the interface from its server. Can be called twice."""
        if self.server is not None:
            self.server.release(self)
        self._unmap()

    def take_segment(self) -> Segment:
        """Its memory, and its file with a descriptor and mapping of their own, which stay when it is destroyed.

        Raises:
            OSError: there are no descriptors left.
        """
        if self.descriptor is None:
            memory: Any = self._memory
            return Segment(memory)
        descriptor = os.dup(self.descriptor)
        os.ftruncate(descriptor, self.size)
        return Segment(mmap.mmap(descriptor, self.size), descriptor)

    def post(self) -> None:
        """Wake the server's clients."""
        if self.server is not None:
            self.server.post()

    # Client ------------------------------------------------------------------------------------------------------

    def open(self, client: InterfaceClient, id: str | None) -> None:
        """Open an interface that a server serves.

        Raises:
            InterfaceError: the id is invalid, this object is open already, the server has no interface of this type and
                id, or the file is smaller than the struct.
        """
        self.id = check_id(self.type, id)
        self._require_closed()
        path = f"{client.path}/{self.type}.{self.id}"
        try:
            check_owner(client.path)
            descriptor = os.open(path, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW)
        except OSError as error:
            hint = client.hint(self.type, self.id) if error.errno == errno.ENOENT else file_limit_hint(error)
            raise InterfaceError(f"error opening device file {path} : {error.strerror}{hint}") from None
        try:
            head = os.pread(descriptor, 8, 0)
            version = int.from_bytes(head[:4], sys.byteorder)
            length = os.fstat(descriptor).st_size
            self.layout = for_abi(self.layout_for(version, length), abi_of(head))
            size = self.size
            if length < size:
                raise InterfaceError(f"expected file size: {size} < {length} ({path})")
            memory = mmap.mmap(descriptor, size)
        except (OSError, InterfaceError) as error:
            os.close(descriptor)
            if isinstance(error, InterfaceError):
                raise
            raise InterfaceError(f"error mapping device file: {error.strerror} ({path})") from None
        raise_file_limit(descriptor)
        self._map(Segment(memory, descriptor))
        announced = self.data.head.size
        if announced < size:
            self._unmap()
            raise InterfaceError(f"expected file size: {size} < {announced} ({path})")
        self.client = client
        client.opened.append(self)

    def close(self) -> None:
        """Close the interface. Can be called twice."""
        if self.client is not None and self in self.client.opened:
            self.client.opened.remove(self)
        self.client = None
        self._unmap()

    @property
    def replaced(self) -> bool:
        """Whether the server has created the interface again since it was opened, so that this file is stale."""
        if self.client is None or self.descriptor is None:
            return False
        try:
            current = os.stat(f"{self.client.path}/{file_name(self.type, self.id)}")  # noqa: PTH116
        except OSError:
            return False  # some old programs delete all files: what is open is still in use then
        return not os.path.samestat(current, os.fstat(self.descriptor))

    # Lock --------------------------------------------------------------------------------------------------------

    def lock(self, timeout: float | None = None) -> bool:
        """Take the lock that server and clients share.

        Args:
            timeout: [s]. None: a client waits without a limit; a server waits 20 ms, and not at all while a client
                still holds the lock that the server failed to get last time, so that no client can stop the simulation.

        Returns:
            Whether the lock was taken; if not, a server skips the interface in this step.

        Raises:
            ClosedError: the interface is not open.
        """
        if self.descriptor is None:
            if self._data is None:
                _ = self.data  # raises
            return True
        if timeout is None and self.server is None:
            fcntl.flock(self.descriptor, fcntl.LOCK_EX)
            return True
        try:
            fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if not self._wait_for_lock(timeout):
                return False
        self.link.blocked = 0
        if self.server is not None:
            self._repair()
        return True

    def _wait_for_lock(self, timeout: float | None) -> bool:
        """Wait for a lock that a client holds [s]; None: as long as the server can wait."""
        if timeout is not None:
            taken = self._poll_lock(timeout)
        elif self.link.blocked or self.server is None:
            return False
        else:
            patience, begin = self.server.patience, time.monotonic()
            left = patience.left(begin)
            taken = left > 0.0 and self._poll_lock(min(SERVER_TIMEOUT, left))
            if left > 0.0:
                patience.spend(time.monotonic() - begin)
        if not taken and self.server is not None and not self.link.blocked:
            self.link.blocked = 1
            self._warn("a client holds the lock of", "the simulation continues without it")
        return taken

    def _poll_lock(self, timeout: float) -> bool:
        """Try to take the lock until the timeout [s]."""
        descriptor, end, attempts = self.descriptor or 0, time.monotonic() + timeout, 0
        while time.monotonic() < end:
            if attempts >= _SPINS:
                time.sleep(_POLL)
            attempts += 1
            with contextlib.suppress(BlockingIOError):
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return True
        return False

    def _warn(self, what: str, consequence: str, times: int = 1) -> None:
        """Log what a client did: the first time, then at growing counts."""
        if self._tally.due(what, times):
            log.warning("%s %s.%s; %s%s", what, self.type, self.id, consequence, self._tally.times(what))

    # Repair ------------------------------------------------------------------------------------------------------

    def _repair(self) -> None:
        """Restore length, head and commands of the file; the caller holds the lock.

        Where a client overwrote the head, the commands beside it mean nothing, either: earlier ones stay in force.

        Access to mapped memory beyond the end of a file raises SIGBUS. Where that is not survived, the length comes
        first, at each lock.
        """
        memory: Any = self._memory
        now, truncated, link = time.monotonic(), False, self.link
        due = now >= link.next_check
        if due:
            link.next_check, link.keeps = now + _CHECK_PERIOD, 1
        if self._watch is None:
            truncated = self._restore_length()
        size = len(self._head)
        head = memory[:size]
        if self._watch is not None and (due or head == self._no_head):
            truncated = self._restore_length()
            truncated |= self._report_failures(self._watch)
        if head != self._head:
            memory[:size] = self._head
            begin = 0
            for span in self._spans if link.kept_any else ():
                memory[span.offset : span.offset + span.size] = self._kept[begin : begin + span.size]
                begin += span.size
            if not truncated:
                self._warn(_OVERWRITTEN, "it was restored", 1 + link.restored)
                link.restored, link.most_restored = 0, self._tally.unlogged(_OVERWRITTEN)

    def intact(self) -> bool:
        """Whether no client has overwritten the head since the server took the lock.

        If one has, without the lock, then what was read since is no command but overwritten memory.
        """
        memory: Any = self._memory
        return bool(memory[: len(self._head)] == self._head)

    def keep_commands(self) -> None:
        """Keep commands as they are now, to restore them if a client overwrites the file; the caller holds the lock.

        Texts are not kept: they are requests, which must not come again.
        """
        self.link.keeps = 0
        memory: Any = self._memory
        found = b"".join(
            [bytes(place.stop - place.start) if text else memory[place] for place, text in commands_of(self.layout)]
        )
        if self.intact():
            self._kept[:] = found
            self.link.kept_any = 1

    def _restore_length(self) -> bool:
        """Extend the file if it is too short; whether it was."""
        descriptor = self.descriptor or 0
        if os.lseek(descriptor, 0, os.SEEK_END) >= self.size:  # quicker than fstat; the file offset is not used
            return False
        try:
            os.ftruncate(descriptor, self.size)
        except OSError as error:
            self._warn("a client truncated", f"its length cannot be restored: {error.strerror}")
        else:
            self._warn("a client truncated", "its length was restored")
        return True

    def _report_failures(self, found: Watch) -> bool:
        """Log accesses that failed since the last report; whether there were any."""
        seen = self.link.seen
        (recovered, lost), (recovered_before, lost_before) = (found.counts.recovered, found.counts.lost), seen
        if (recovered, lost) == (recovered_before, lost_before):
            return False
        seen[:] = recovered, lost
        if recovered > recovered_before:
            self._warn("a client truncated", "its length was restored", recovered - recovered_before)
        if lost > lost_before:
            self._warn("there is no space on the disk for", "clients do not see all of it", lost - lost_before)
        return True

    def unlock(self) -> None:
        """Release the lock."""
        self.link.exchanges += 1
        if self.descriptor is not None:
            if self.link.keeps:
                self.keep_commands()
            fcntl.flock(self.descriptor, fcntl.LOCK_UN)

    @contextlib.contextmanager
    def locked(self, timeout: float | None = None) -> Iterator[D]:
        """The struct, under the lock.

        Args:
            timeout: [s], as for `lock`.

        Raises:
            InterfaceError: the lock was not available before the timeout.
            ClosedError: the interface is not open.
        """
        if not self.lock(timeout):
            raise InterfaceError(f"the lock of {self.type}.{self.id} was not available before the timeout")
        try:
            yield self.data
        finally:
            self.unlock()

    # Memory ------------------------------------------------------------------------------------------------------

    def _require_closed(self) -> None:
        if self._data is not None:
            raise InterfaceError(f"interface {self.type}.{self.id} is open already")

    def _map(self, segment: Segment) -> None:
        self.descriptor = segment.descriptor
        self._memory = segment.memory
        memory: Any = segment.memory
        self._data = self.layout.from_buffer(memory)  # type: ignore[assignment]
        if segment.descriptor is not None and isinstance(segment.memory, mmap.mmap):
            self._watch = watch(segment.memory, segment.descriptor)
        self._link(segment)

    def _link(self, segment: Segment) -> None:
        """Let native updates exchange numbers with the memory; until `_unmap`, which they notice."""
        link, memory = self.link, segment.memory
        places = commands_of(self.layout)
        self._spans = (SpanRecord * len(places))(*(SpanRecord(p.start, p.stop - p.start, text) for p, text in places))
        size = sum(span.size for span in self._spans)
        self._kept, self._found = bytearray(size), ctypes.create_string_buffer(size)
        link.kept = ctypes.addressof(ctypes.c_char.from_buffer(self._kept)) if size else None
        link.found, link.kept_any = ctypes.addressof(self._found), 0
        link.commands, link.command_count = ctypes.addressof(self._spans), len(places)
        link.size, link.seen[:] = self.size, (0, 0)
        link.counts = None if self._watch is None else ctypes.addressof(self._watch.counts)
        link.descriptor = -1 if segment.descriptor is None else segment.descriptor
        link.memory = ctypes.addressof(ctypes.c_char.from_buffer(memory))

    def _unmap(self) -> None:
        """Release memory and file; the memory itself stays mapped while a view of it exists."""
        self.link.memory, self.link.descriptor, self.link.keeps, self.link.kept_any = None, -1, 0, 0
        self._data = None
        self._arrays.clear()
        self._memory = None
        self.server = None
        if self._watch is not None:
            self._watch.release()
            self._watch = None
        if self.descriptor is not None:
            fcntl.flock(self.descriptor, fcntl.LOCK_UN)
            os.close(self.descriptor)
            self.descriptor = None


def _int32(value: int) -> int:
    """The low 32 bits of an int, as the signed C int of the head."""
    return (int(value) & 0xFFFFFFFF) - ((int(value) & 0x80000000) << 1)
