"""Clients of the viewer's port without a browser, for tests."""

import asyncio
import contextlib
import io
import json
import struct
import threading
import time
import zlib

import aiohttp
import numpy as np

import libgz
from libgz.view.local import LocalSource
from libgz.view.viewer import Viewer

PATIENCE = 60.0  # [s]


class Socket:
    """A page's socket: `open` raises aiohttp.WSServerHandshakeError if it is refused."""

    def __init__(self, url, **headers):
        self.loop = asyncio.new_event_loop()
        self.number = 0
        try:
            self.run(self._open(url, {name.replace("_", "-"): text for name, text in headers.items()}))
        except BaseException:
            self.loop.close()
            raise

    async def _open(self, url, headers):
        self.session = aiohttp.ClientSession(headers=headers)
        try:
            async with self.session.get(url) as answer:
                address = str(answer.url)
            self.socket = await self.session.ws_connect(address + "socket", max_msg_size=0)
        except BaseException:
            await self.session.close()
            raise

    def run(self, what):
        return self.loop.run_until_complete(asyncio.wait_for(what, PATIENCE))

    def send(self, message):
        text = message if isinstance(message, str) else json.dumps(message)
        self.run(self.socket.send_str(text))

    def receive(self):
        """The next message: a dictionary; a binary one has one of the keys state, image, scene."""
        message = self.run(self.socket.receive())
        if message.type == aiohttp.WSMsgType.TEXT:
            return json.loads(message.data)
        assert message.type == aiohttp.WSMsgType.BINARY, message
        [kind] = struct.unpack("<I", message.data[:4])
        return {("state", "image", "scene")[kind - 1]: message.data}

    def until(self, accept):
        """The first message that `accept` likes, or has the key `accept`."""
        end = time.monotonic() + PATIENCE
        while True:
            message = self.receive()
            if accept in message if isinstance(accept, str) else accept(message):
                return message
            assert time.monotonic() < end

    def ask(self, verb, argument="-", **content):
        """(answer, error) of a request."""
        self.number += 1
        self.send({"ask": verb, "number": self.number, "argument": argument, "content": content})
        answer = self.until(lambda message: message.get("answer") == self.number)
        return answer.get("value"), answer.get("error")

    def close(self):
        self.run(self.socket.close())
        self.run(self.session.close())
        self.loop.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def state_of(raw):
    """(numbers of the head, times, bodies, joints) of the message of a state."""
    head, times = struct.unpack("<8I", raw[:32]), struct.unpack("<4d", raw[32:64])
    tables = np.frombuffer(raw, "<f4", offset=64)
    size = head[3] * head[4]
    return head, times, tables[:size].reshape(head[3], head[4]), tables[size:].reshape(head[5], head[6])


def scene_of(raw):
    """The scene of its message."""
    return json.loads(zlib.decompress(raw[4:]))


@contextlib.contextmanager
def running(source, controls=None, **options):
    """A viewer that shows frames in a thread."""
    with contextlib.redirect_stdout(io.StringIO()), Viewer(source, controls, port=18960, **options) as viewer:
        ended = threading.Event()
        thread = threading.Thread(target=viewer.run, args=(ended.is_set,))
        thread.start()
        try:
            yield viewer
        finally:
            ended.set()
            thread.join()


@contextlib.contextmanager
def showing(text, controls=None, **options):
    """(world, viewer) of a world of this process."""
    with libgz.World.from_string(text) as world:
        made = controls(world) if controls is not None else None
        with running(LocalSource(world), made, **options) as viewer:
            yield world, viewer
