"""The System V semaphore set with which a server wakes its clients: one semaphore for each client id.

Python's sysv_ipc supports only sets of one semaphore and has no SETALL, so this module calls libc directly.
"""

from __future__ import annotations

import ctypes
import errno
import functools
import os
import time

from libgz.base.errors import InterfaceError, ParameterError, ServerGoneError
from libgz.base.records import PostRecord
from libgz.base.waiting import PERIOD

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

# Posting takes a microsecond: less than releasing the interpreter lock for it.
_quick = ctypes.PyDLL(None, use_errno=True)
_quick.semctl.argtypes = _libc.semctl.argtypes

_ONES = (ctypes.c_ushort * CLIENTS)(*[1] * CLIENTS)
_ZEROS = (ctypes.c_ushort * CLIENTS)()


class SemaphoreSet:
    """The set of one server id. The key does not contain the user: two users cannot serve the same id."""

    def __init__(self, server_id: int, handle: int) -> None:
        self.server_id = server_id
        self._handle = handle
        # Indexing gives a function object without argtypes: with prepared arguments, half the time of a plain call.
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
        """A new set with all flags cleared.

        Raises:
            FileExistsError: a set of this id exists.
            OSError: the set cannot be created.
        """
        new = cls(server_id, cls._get(server_id, CLIENTS, IPC_CREAT | IPC_EXCL | MODE))
        new.clear()
        return new

    @classmethod
    def attach(cls, server_id: int) -> SemaphoreSet:
        """The existing set.

        Raises:
            FileNotFoundError: there is none.
            PermissionError: it belongs to another user.
        """
        return cls(server_id, cls._get(server_id, 0, MODE))

    def _control(self, number: int, command: int, argument: object = None) -> int:
        result: int = _quick.semctl(self._handle, number, command, argument)
        if result < 0:
            error = ctypes.get_errno()
            raise OSError(error, os.strerror(error))
        return result

    def clear(self) -> None:
        """Clear all flags.

        Raises:
            OSError: the set was removed.
        """
        self._control(0, SETALL, _ZEROS)

    def post(self) -> None:
        """Set the flag of every client; it is a flag, not a count.

        Raises:
            OSError: the set was removed.
        """
        if self._raise_flags() < 0:
            error = ctypes.get_errno()
            raise OSError(error, os.strerror(error))

    def posting(self) -> PostRecord:
        """What native updates need to set the flags."""
        return PostRecord(self._handle, ctypes.addressof(_ONES))

    def last_poster(self) -> int:
        """Pid of the process that last set the flags, the server; 0 if it is in another pid namespace.

        Raises:
            OSError: the set was removed.
        """
        return self._control(CLIENTS - 1, GETPID)

    def waiting(self, client_id: int) -> int:
        """The number of processes that wait under this client id, 0 to 15.

        Raises:
            OSError: the set was removed.
        """
        return self._control(client_id, GETNCNT)

    def remove(self) -> None:
        """Remove the set; the waits of clients end with an error.

        Raises:
            OSError: the set was removed already.
        """
        self._control(0, IPC_RMID)

    def wait(self, client_id: int, timeout: float | None) -> bool:
        """Sleep until the flag of `client_id` is set, and clear it.

        Args:
            client_id: 0 to 15.
            timeout: [s]; None waits without a limit.

        Returns:
            Whether the flag was set before the timeout.

        Raises:
            ServerGoneError: the server ended.
            InterfaceError: the wait failed for another reason.
            ParameterError: the timeout is negative or NaN.
        """
        if timeout is not None and not timeout >= 0.0:
            raise ParameterError(f"timeout is {timeout} s; it must not be negative")
        end = None if timeout is None else time.monotonic() + timeout
        operation = _SemBuf(client_id, -1, SEM_UNDO)
        while True:
            left = PERIOD if end is None else min(PERIOD, max(0.0, end - time.monotonic()))
            limit = _TimeSpec(int(left), int(left % 1.0 * 1e9))
            if _libc.semtimedop(self._handle, ctypes.byref(operation), 1, ctypes.byref(limit)) == 0:
                return True
            error = ctypes.get_errno()
            if error == errno.EAGAIN:
                if end is not None and time.monotonic() >= end:
                    return False
                continue
            if error in (errno.EIDRM, errno.EINVAL):
                raise ServerGoneError(f"server {self.server_id} ended: its semaphores were removed")
            if error != errno.EINTR:
                raise InterfaceError(f"error on semaphore wait [{os.strerror(error)}]")
