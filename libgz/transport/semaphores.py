"""The semaphore set by which a server wakes its clients: one System V set, one semaphore a client id.

Python's sysv_ipc makes sets of one semaphore only and has no SETALL, so these few calls go to libc directly.
"""

from __future__ import annotations

import ctypes
import errno
import functools
import os
import time

from libgz.errors import InterfaceError, ParameterError, ServerGoneError

__all__ = ["CLIENTS", "GZ_SEM_KEY", "SemaphoreSet"]

GZ_SEM_KEY = 0x135135FA
CLIENTS = 16

IPC_CREAT, IPC_EXCL = 0o1000, 0o2000
IPC_RMID = 0
GETPID, GETVAL, GETNCNT, SETALL = 11, 12, 14, 17
SEM_UNDO = 0x1000
MODE = 0o700


class _SemBuf(ctypes.Structure):
    _fields_ = [("num", ctypes.c_ushort), ("op", ctypes.c_short), ("flg", ctypes.c_short)]


class _TimeSpec(ctypes.Structure):
    _fields_ = [("sec", ctypes.c_long), ("nsec", ctypes.c_long)]


_libc = ctypes.CDLL(None, use_errno=True)
_libc.semget.argtypes = [ctypes.c_int, ctypes.c_int, ctypes.c_int]
_libc.semctl.argtypes = [ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_void_p]
_libc.semtimedop.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]

# Posting is a microsecond: keep the interpreter lock for it.
_quick = ctypes.PyDLL(None, use_errno=True)
_quick.semctl.argtypes = _libc.semctl.argtypes

_ONES = (ctypes.c_ushort * CLIENTS)(*[1] * CLIENTS)
_ZEROS = (ctypes.c_ushort * CLIENTS)()


class SemaphoreSet:
    """The set of one server id. The key does not hold the user: two users cannot serve the same id."""

    def __init__(self, server_id: int, handle: int) -> None:
        self.server_id = server_id
        self._handle = handle
        # A look-up of its own is free of types, and its arguments are ready-made: half the time of a plain call.
        arguments = (ctypes.c_int(handle), ctypes.c_int(0), ctypes.c_int(SETALL), ctypes.byref(_ONES))
        self._raise_flags = functools.partial(_quick["semctl"], *arguments)

    @staticmethod
    def _get(server_id: int, count: int, flags: int) -> int:
        handle: int = _libc.semget(GZ_SEM_KEY + server_id, count, flags)
        if handle < 0:
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number))
        return handle

    @classmethod
    def create(cls, server_id: int) -> SemaphoreSet:
        """A new set, all flags down.

        Raises:
            FileExistsError: there is one for this id.
        """
        new = cls(server_id, cls._get(server_id, CLIENTS, IPC_CREAT | IPC_EXCL | MODE))
        new.clear()
        return new

    @classmethod
    def attach(cls, server_id: int) -> SemaphoreSet:
        """The set that is there.

        Raises:
            FileNotFoundError: there is none.
            PermissionError: it is another user's.
        """
        return cls(server_id, cls._get(server_id, 0, MODE))

    def _control(self, number: int, command: int, argument: object = None) -> int:
        result: int = _quick.semctl(self._handle, number, command, argument)
        if result < 0:
            error = ctypes.get_errno()
            raise OSError(error, os.strerror(error))
        return result

    def clear(self) -> None:
        """Put all flags down."""
        self._control(0, SETALL, _ZEROS)

    def post(self) -> None:
        """Raise the flag of every client; a flag, not a count.

        Raises:
            OSError: the set was removed.
        """
        if self._raise_flags() < 0:
            error = ctypes.get_errno()
            raise OSError(error, os.strerror(error))

    def last_poster(self) -> int:
        """Pid of the process that last set the flags: the server's; 0 if it is in another pid namespace."""
        return self._control(CLIENTS - 1, GETPID)

    def waiting(self, client_id: int) -> int:
        """How many processes wait under this client id."""
        return self._control(client_id, GETNCNT)

    def remove(self) -> None:
        """Remove the set; waiting clients wake with an error."""
        self._control(0, IPC_RMID)

    def wait(self, client_id: int, timeout: float | None) -> bool:
        """Sleep until the flag of `client_id` is up, and take it down.

        Args:
            client_id: 0 to 15.
            timeout: [s]; None waits for ever.

        Returns:
            Whether the flag was up before the time was over.

        Raises:
            ServerGoneError: the server ended.
            ParameterError: the timeout is negative or NaN.
        """
        if timeout is not None and not timeout >= 0.0:
            raise ParameterError(f"timeout is {timeout} s; it must not be negative")
        end = None if timeout is None else time.monotonic() + timeout
        operation = _SemBuf(client_id, -1, SEM_UNDO)
        while True:
            limit = None
            if end is not None:
                left = max(0.0, end - time.monotonic())
                limit = ctypes.byref(_TimeSpec(int(left), int(left % 1.0 * 1e9)))
            if _libc.semtimedop(self._handle, ctypes.byref(operation), 1, limit) == 0:
                return True
            error = ctypes.get_errno()
            if error == errno.EAGAIN:
                return False
            if error in (errno.EIDRM, errno.EINVAL):
                raise ServerGoneError(f"server {self.server_id} ended: its semaphores are gone")
            if error != errno.EINTR:
                raise InterfaceError(f"error on semaphore wait [{os.strerror(error)}]")
