"""Attacks on the port of a viewer that runs as users have it: it serves a page meanwhile, and holds little."""

import os
import re
import socket
import threading
import time
from pathlib import Path

import pytest
from view_pages import served
from view_sockets import Socket

from libgz.transport.server import free_server_id

pytestmark = pytest.mark.trial

SPAN = 3.0  # [s] of each attack
LARGEST = 200 << 20  # [byte] that the viewer may grow


def children(process):
    return [int(pid) for pid in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def memory(process):
    """Resident memory [byte]."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def greeting(port, path="/socket"):
    head = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    return f"{head}Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()


def frame(payload, opcode=1, length=None):
    """A masked frame; `length` is what it announces."""
    size = len(payload) if length is None else length
    return bytes([0x80 | opcode, 0x80 | 127]) + size.to_bytes(8, "big") + bytes(4) + payload


ATTACKS = {
    "silent connections": [b""],
    "half a request": [b"GET / HTTP/1.1\r\nHost: 127"],
    "requests without an end": [b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 20000],
    "garbage": [os.urandom(4096)],
    "traversal": [b"GET /client/../../../../etc/passwd HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"],
    "giant frames": [None, frame(b"x" * 65536, length=1 << 62)],
    "valid messages": [None, frame(b'{"want": "fields", "names": ["a.b.c"]}') * 500],
    "requests": [None, frame(b'{"ask": "describe", "number": 1, "content": {"name": "robot1"}}') * 500],
    "deep messages": [None, frame(b'{"ask":' + b"[" * 100000)],
    "pages that do not read": [None],
}


def attack(port, parts, ended):
    """Open connections, and send, as fast as they are taken."""
    opened = []
    while not ended.is_set():
        one = socket.socket()
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        one.settimeout(0.2)
        try:
            one.connect(("127.0.0.1", port))
            for part in parts:
                one.sendall(greeting(port) if part is None else part)
            opened.append(one)
        except OSError:
            one.close()
        if len(opened) > 250:
            opened.pop(0).close()
        time.sleep(0.002)
    for one in opened:
        one.close()


@pytest.mark.parametrize("kind", ATTACKS)
def test_a_page_is_served_under_attack(kind):
    server_id = free_server_id(300 + os.getpid() % 500)
    with served("-s", server_id, "-d", 0, "worlds/pioneer2at.world") as (process, url), Socket(url) as page:
        page.until("state")
        [viewer] = children(process.pid)
        port, before = int(re.search(r":(\d+)/", url)[1]), memory(viewer)
        ended = threading.Event()
        attackers = [threading.Thread(target=attack, args=(port, ATTACKS[kind], ended)) for _ in range(2)]
        for one in attackers:
            one.start()
        try:
            end, states = time.monotonic() + SPAN, 0
            while time.monotonic() < end:
                page.until("state")
                states += 1
        finally:
            ended.set()
            for one in attackers:
                one.join()
        assert states > SPAN
        assert page.ask("pause", "on")[1] in (None, "the server has not answered the requests before; try again later")
        assert children(process.pid) == [viewer]
        assert memory(viewer) < before + LARGEST
