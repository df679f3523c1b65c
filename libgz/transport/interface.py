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
from typing import Any, ClassVar, Generic, TypeAlias, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from libgz.errors import ClosedError, InterfaceError
from libgz.transport.client import Client
from libgz.transport.layout import GAZEBO_MAX_MODEL_TYPE, LIBGAZEBO_VERSION, Data, fields_of, numpy_type
from libgz.transport.paths import LONGEST_PATH, check_id, file_name
from libgz.transport.server import LocalServer, Server

__all__ = ["DataClass", "Interface", "View"]

log = logging.getLogger("libgz.transport")

D = TypeVar("D", bound=Data)
DataClass: TypeAlias = "type[Data]"  # Interface.type hides the builtin

SERVER_PATIENCE = 0.02  # [s] a server waits for a lock that a client holds
_POLL = 0.0002  # [s]


class View:
    """A field of an interface as a numpy array on the shared memory: no copy, and no lock."""

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
    """Base of all interfaces, on either side of the wire.

    `data` is the struct as C programs see it; numpy views and properties come with each kind. Read and write under the
    lock if the fields must belong together::

        with robot.locked() as data:
            data.cmd_vel_pos[0] = 0.2
    """

    type: ClassVar[str]
    data_class: ClassVar[DataClass]
    older: ClassVar[Mapping[int, DataClass]] = {}  # version -> struct, where it was another one
    has_post: ClassVar[bool] = True

    def __init__(self) -> None:
        self.id = ""
        self.layout = self.data_class
        self.server: LocalServer | None = None
        self.client: Client | None = None
        self._descriptor: int | None = None
        self._memory: mmap.mmap | bytearray | None = None
        self._data: D | None = None
        self._arrays: dict[str, NDArray[Any]] = {}
        self._owner = ("", 0, 0)  # model type, model id, id of the parent model
        self._served = False
        self._stuck = False

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.type}.{self.id}>"

    @property
    def model_id(self) -> int:
        """The number of the model that made it, on the server's side."""
        return self._owner[1]

    @property
    def size(self) -> int:
        """Bytes of the struct, and of its file."""
        return ctypes.sizeof(self.layout)

    def layout_for(self, version: int, length: int | None) -> DataClass:
        """The struct of a wire version, in a file of so many bytes; None on the server's side, which makes the file."""
        return self.older.get(version, self.data_class)

    @property
    def data(self) -> D:
        """The struct on the shared memory.

        Raises:
            ClosedError: the interface is not open.
        """
        if self._data is None:
            raise ClosedError(f"interface {self.type}.{self.id} is not open")
        return self._data

    def array(self, name: str) -> NDArray[Any]:
        """A numeric field as a numpy array on the shared memory."""
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

    # Server's side -----------------------------------------------------------------------------------------------

    def create(
        self,
        server: LocalServer,
        id: str | None,
        model_type: str = "",
        model_id: int = 0,
        parent_model_id: int = 0,
    ) -> None:
        """Make the interface on a server.

        If the server has one of this type and id already, this one becomes memory of this process that nobody reads,
        with a warning: the model runs on without it.

        Raises:
            InterfaceError: the id cannot be used, or the file cannot be made.
        """
        self.id = check_id(self.type, id)
        self._require_closed()
        self.layout = self.layout_for(server.version, None)
        size = self.size
        self.server = server
        self._served = server.claim(self)
        if self._served and isinstance(server, Server):
            _warn_of_length(f"{server.path}/{file_name(self.type, self.id)}")
            try:
                self._descriptor = server.create_file(file_name(self.type, self.id), size)
                self._memory = mmap.mmap(self._descriptor, size)
            except OSError as error:
                server.release(self)
                raise InterfaceError(f"error creating mmap file: {error.strerror} ({self.type}.{self.id})") from None
        else:
            self._memory = bytearray(size)
        self._map()
        self._owner = (model_type, model_id, parent_model_id)
        self._write_head()
        if self._descriptor is not None and isinstance(server, Server):
            try:
                server.show_file(file_name(self.type, self.id))
            except OSError as error:
                self.destroy()
                raise InterfaceError(f"error creating mmap file: {error.strerror} ({self.type}.{self.id})") from None

    def _write_head(self) -> None:
        head = self.data.head
        model_type, model_id, parent_model_id = self._owner
        head.version = self.server.version if self.server is not None else LIBGAZEBO_VERSION
        head.size = self.size
        head.model_type = model_type.encode()[: GAZEBO_MAX_MODEL_TYPE - 1]
        head.model_id = _int32(model_id)
        head.parent_model_id = _int32(parent_model_id)

    def destroy(self) -> None:
        """Take the interface off its server. Can be called twice."""
        server = self.server
        if server is not None and self._served:
            if isinstance(server, Server) and self._descriptor is not None:
                server.unlink_file(file_name(self.type, self.id), self._descriptor)
            server.release(self)
        self._release()

    def post(self) -> None:
        """Wake the server's clients."""
        if self.server is not None:
            self.server.post()

    # Client's side -----------------------------------------------------------------------------------------------

    def open(self, client: Client, id: str | None) -> None:
        """Open an interface that a server serves.

        Raises:
            InterfaceError: there is none of this type and id, or it is of another version.
        """
        self.id = check_id(self.type, id)
        self._require_closed()
        path = f"{client.path}/{self.type}.{self.id}"
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        except OSError as error:
            hint = client.hint(self.type, self.id) if error.errno == errno.ENOENT else ""
            raise InterfaceError(f"error opening device file {path} : {error.strerror}{hint}") from None
        try:
            version = int.from_bytes(os.pread(descriptor, 4, 0), sys.byteorder)
            length = os.fstat(descriptor).st_size
            self.layout = self.layout_for(version, length)
            size = self.size
            if length < size:
                raise InterfaceError(f"expected file size: {size} < {length} ({path})")
            self._memory = mmap.mmap(descriptor, size)
        except (OSError, InterfaceError) as error:
            os.close(descriptor)
            if isinstance(error, InterfaceError):
                raise
            raise InterfaceError(f"error mapping device file: {error.strerror} ({path})") from None
        self._descriptor = descriptor
        self._map()
        if self.data.head.size < size:
            told = self.data.head.size
            self._release()
            raise InterfaceError(f"expected file size: {size} < {told} ({path})")
        self.client = client
        client.opened.append(self)

    def close(self) -> None:
        """Close the interface. Can be called twice."""
        if self.client is not None and self in self.client.opened:
            self.client.opened.remove(self)
        self.client = None
        self._release()

    @property
    def replaced(self) -> bool:
        """Whether the server serves another interface of this type and id now, and this one is nobody's any more."""
        if self.client is None or self._descriptor is None:
            return False
        try:
            there = os.stat(f"{self.client.path}/{self.type}.{self.id}")  # noqa: PTH116
        except OSError:
            return False  # some old programs delete all files: what is open is still in use then
        return not os.path.samestat(there, os.fstat(self._descriptor))

    # Lock --------------------------------------------------------------------------------------------------------

    def lock(self, timeout: float | None = None) -> bool:
        """Take the lock that both sides share.

        Args:
            timeout: [s]. None: a client waits for as long as it takes; a server waits briefly, and where a client sits
                on the lock goes on without, for nothing a client does may stop the simulation.

        Returns:
            Whether the lock was taken; a server then leaves the interface alone for this step.
        """
        if self._descriptor is None:
            _ = self.data
            return True
        if timeout is None and self.server is None:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX)
            return True
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            patience = SERVER_PATIENCE if timeout is None else timeout
            if not self._poll_lock(0.0 if self._stuck and timeout is None else patience):
                return False
        self._stuck = False
        if self.server is not None:
            self._mend()
        return True

    def _poll_lock(self, patience: float) -> bool:
        """Try for the lock until the time is over."""
        descriptor, end = self._descriptor or 0, time.monotonic() + patience
        while time.monotonic() < end:
            time.sleep(_POLL)
            with contextlib.suppress(BlockingIOError):
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return True
        if self.server is not None and not self._stuck:
            self._stuck = True
            log.warning("a client holds the lock of %s.%s; the simulation goes on without it", self.type, self.id)
        return False

    def _mend(self) -> None:
        """Give a file that a client cut short its length back: memory beyond the end of a file kills who touches it."""
        descriptor = self._descriptor or 0
        if os.lseek(descriptor, 0, os.SEEK_END) < self.size:  # quicker than fstat; nobody reads at an offset
            os.ftruncate(descriptor, self.size)
            log.warning("a client cut %s.%s short; it has its length again", self.type, self.id)
            self._write_head()

    def unlock(self) -> None:
        """Give the lock back."""
        if self._descriptor is not None:
            fcntl.flock(self._descriptor, fcntl.LOCK_UN)

    @contextlib.contextmanager
    def locked(self, timeout: float | None = None) -> Iterator[D]:
        """The struct, under the lock.

        Raises:
            InterfaceError: the lock was not to be had in time.
        """
        if not self.lock(timeout):
            raise InterfaceError(f"the lock of {self.type}.{self.id} was not to be had in time")
        try:
            yield self.data
        finally:
            self.unlock()

    # Memory ------------------------------------------------------------------------------------------------------

    def _require_closed(self) -> None:
        if self._data is not None:
            raise InterfaceError(f"interface {self.type}.{self.id} is open already")

    def _map(self) -> None:
        memory: Any = self._memory
        self._data = self.layout.from_buffer(memory)  # type: ignore[assignment]

    def _release(self) -> None:
        """Let memory and file go; the memory itself lives as long as somebody holds a view of it."""
        self._data = None
        self._arrays.clear()
        self._memory = None
        self.server = None
        self._served = False
        if self._descriptor is not None:
            fcntl.flock(self._descriptor, fcntl.LOCK_UN)
            os.close(self._descriptor)
            self._descriptor = None


def _warn_of_length(path: str) -> None:
    if len(os.fsencode(path)) > LONGEST_PATH:
        log.warning(
            "C programs cannot open %s: their paths end after %d bytes; set TMP shorter, or the id", path, LONGEST_PATH
        )


def _int32(value: int) -> int:
    """Any int as the C int that a header holds."""
    return (int(value) & 0xFFFFFFFF) - ((int(value) & 0x80000000) << 1)
