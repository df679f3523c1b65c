"""Which user is at the other end of a connection from this machine, by what the kernel says."""

from __future__ import annotations

import errno
import ipaddress
import logging
import os
import socket
import struct
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

__all__ = ["PeerCheck"]

log = logging.getLogger("libgz.transport")

TABLES = (Path("/proc/net/tcp"), Path("/proc/net/tcp6"))
NETLINK_SOCK_DIAG, SOCK_DIAG_BY_FAMILY, NLM_F_REQUEST = 4, 20, 1  # linux/netlink.h, linux/sock_diag.h
HEADER = struct.Struct("=IHHII")  # length, kind, flags, number, port: struct nlmsghdr
REQUEST = struct.Struct("=BBBBI2s2s16s16sI8s")  # struct inet_diag_req_v2 of linux/inet_diag.h
ANSWER = struct.Struct("=BBBB2s2s16s16sI8sIIIII")  # struct inet_diag_msg; its last fields are user and inode
ERROR = struct.Struct("=i")  # the first field of struct nlmsgerr of linux/netlink.h
ATTEMPTS = 3  # the kernel may leave a row out while others come and go
ROOT = 0
CLOSED = -1  # the user of a socket that its process has closed

End: TypeAlias = tuple[Any, ...]  # address and port; of IPv6 flow and scope, too


class PeerCheck:
    """Decides who may connect from this machine: the user of this process, and root; and everybody from other ones.

    A peer that has closed its socket has no user any more, and is refused; so is one of whom the kernel cannot be asked
    just now, such as without descriptors. Where the kernel neither answers nor lists connections (no /proc, or no
    access to it), that is said once, and nobody is refused: there nobody could connect at all.
    """

    def __init__(self) -> None:
        self._uid = os.geteuid()
        self._asking = _answers()

    @cached_property
    def _tables(self) -> list[Path]:
        """The kernel's lists of all sockets."""
        try:
            tables = [table for table in TABLES if table.exists() and table.read_bytes()]
        except OSError:
            tables = []
        if not tables:
            log.warning("%s cannot be read: every user of this machine may connect to this server", TABLES[0])
        return tables

    def refusal(self, connection: socket.socket) -> str:
        """Why a connection is refused; empty if it is not."""
        try:
            near, far = connection.getsockname(), connection.getpeername()
        except OSError:
            return "it is closed"
        near_by = _address(far[0]).is_loopback
        for _ in range(ATTEMPTS):
            try:
                uid = self._owner(far, near)
            except OSError as error:
                return f"its user is unknown: {error}"
            # Another machine has no socket here. This one may have, at the address that others reach, too.
            if uid not in (None, CLOSED):
                return "" if uid in (self._uid, ROOT) else f"it is of user {uid}, not of user {self._uid} or root"
            if uid is None and not (near_by and (self._asking or self._tables)):
                return ""
        return "its user is unknown: it has closed its socket"

    def _owner(self, local: End, remote: End) -> int | None:
        """The user of the socket with these ends; None if there is none, or CLOSED.

        Raises:
            OSError: neither the kernel nor its lists can be asked now.
        """
        return _asked_for(local, remote) if self._asking else self._listed(local, remote)

    def _listed(self, local: End, remote: End) -> int | None:
        """The same, by the kernel's lists of all sockets, which take up to 30 ms to read.

        Who connects and leaves at once, again and again, would keep a server reading; so lists are read only where the
        kernel answers no questions.
        """
        wanted = {
            (_words(local[0], mapped), local[1], _words(remote[0], mapped), remote[1]) for mapped in (False, True)
        }
        for table in self._tables:
            for row in table.read_bytes().splitlines()[1:]:
                words = row.split()
                # A socket that its process has closed has inode 0, and root's number whoever had it.
                if len(words) > 9 and _ends(words) in wanted and words[9] != b"0":
                    return int(words[7])
        return None


def _answers() -> bool:
    """Whether the kernel answers questions about sockets: it is asked about one of this process."""
    try:
        with socket.create_server(("127.0.0.1", 0)) as near, socket.socket() as own:
            own.connect(near.getsockname())
            return _asked_for(own.getsockname(), own.getpeername()) is not None
    except OSError:
        return False


def _asked_for(local: End, remote: End) -> int | None:
    """The user of the socket with these ends, by one question to the kernel; None if there is none, or CLOSED.

    Raises:
        OSError: it cannot be asked, or does not answer.
    """
    ends = [_address(end[0]) for end in (local, remote)]
    family = socket.AF_INET if all(end.version == 4 for end in ends) else socket.AF_INET6
    near, far = (end.packed.ljust(16, b"\0") for end in ends)
    ports = [end[1].to_bytes(2, "big") for end in (local, remote)]
    scope = local[3] if len(local) > 3 else 0  # the interface of a link-local address, which each of them may have
    request = REQUEST.pack(family, socket.IPPROTO_TCP, 0, 0, 0, *ports, near, far, scope, b"\xff" * 8)
    header = HEADER.pack(HEADER.size + REQUEST.size, SOCK_DIAG_BY_FAMILY, NLM_F_REQUEST, 0, 0)
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, NETLINK_SOCK_DIAG) as kernel:
        kernel.settimeout(1.0)
        kernel.send(header + request)
        answer = kernel.recv(1 << 12)
    if len(answer) < HEADER.size + ANSWER.size:  # that of no socket has the question, too
        raise OSError(f"an answer of {len(answer)} bytes about a socket")
    if HEADER.unpack_from(answer)[1] != SOCK_DIAG_BY_FAMILY:
        (code,) = ERROR.unpack_from(answer, HEADER.size)
        if code != -errno.ENOENT:
            raise OSError(-code, os.strerror(-code))
        return None
    fields = ANSWER.unpack_from(answer, HEADER.size)
    uid, inode = fields[-2:]
    if list(fields[4:6]) != ports:  # a socket that listens has no other end
        return None
    return int(uid) if inode else CLOSED


def _ends(words: list[bytes]) -> tuple[bytes, int, bytes, int]:
    """Addresses and ports in a row."""
    near, _, near_port = words[1].partition(b":")
    far, _, far_port = words[2].partition(b":")
    return near, int(near_port, 16), far, int(far_port, 16)


def _address(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """An address; an IPv4 one that is mapped into IPv6 as itself."""
    address = ipaddress.ip_address(text.partition("%")[0])
    return getattr(address, "ipv4_mapped", None) or address


def _words(text: str, mapped: bool) -> bytes:
    """An address as the kernel writes it: words of 32 bits in the machine's order; IPv4 also as mapped into IPv6."""
    packed = _address(text).packed
    if mapped and len(packed) == 4:
        packed = b"\0" * 10 + b"\xff\xff" + packed
    return b"".join(b"%08X" % word for word in struct.unpack(f"={len(packed) // 4}I", packed))
