"""A bridge without ROS 2: a process that passes the server's frames on to the test, which plays the graph."""

import json
import socket
import struct
import sys
import threading
from collections import defaultdict

from ros_peers import PATIENCE, read_exactly, wait_for
from ros_types import described

from libgz.ros.packing import Codec, read_schema
from libgz.ros.types import message_type, service_type

EMPTY = "<sdf version='1.6'><world name='default'/></sdf>"
DECLARE, DROP, MESSAGE, ANSWER, HELLO, DECLARED, REFUSED, LISTENED, REQUEST = range(1, 10)

# Copies bytes between the descriptor that the server gives and the test's socket.
RELAY = """
import os, socket, sys, threading
ours = socket.socket(fileno=int(sys.argv[1]))
theirs = socket.socket(socket.AF_UNIX)
theirs.connect(sys.argv[2])
def copy(a, b):
    while data := a.recv(1 << 20):
        b.sendall(data)
    os._exit(0)
threading.Thread(target=copy, args=(ours, theirs), daemon=True).start()
copy(theirs, ours)
"""


class FakeGraph:
    """Answers declarations as a bridge does; keeps what is published.

    Attributes:
        python: what runs as the user's Python.
        about: what bridges say of themselves.
        declared: names -> declarations of the present bridge.
        taken: those of topics that are subscribed to.
        received: names -> bytes of messages.
        refused: names of packages that it does not have.
        silent: whether bridges that come say nothing.
    """

    def __init__(self, folder):
        self.refused, self.links, self.silent = set(), 0, False
        self.about = {"distribution": "test", "middleware": "none"}
        self.declared, self.taken, self.received, self.answers = {}, {}, defaultdict(list), {}
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(folder / "graph"))
        self._listener.listen()
        relay = folder / "relay.py"
        relay.write_text(RELAY)
        self.python = folder / "python3"
        self.python.write_text(f'#!/bin/sh\nexec {sys.executable} -S {relay} "$2" {folder / "graph"}\n')
        self.python.chmod(0o755)
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self):
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join(PATIENCE)

    def _run(self):
        while True:
            try:
                self.socket, _ = self._listener.accept()
            except OSError:
                return
            self.declared.clear()
            self.taken.clear()
            if not self.silent:
                self.send(HELLO, 0, json.dumps(self.about).encode())
            self.links += 1
            try:
                while True:
                    size, sort, number = struct.unpack("<IBI", read_exactly(self.socket, 9))
                    self._frame(sort, number, read_exactly(self.socket, size - 5))
            except (OSError, EOFError):
                self.socket.close()

    def _frame(self, sort, number, body):
        if sort == DECLARE:
            about = json.loads(body)
            package, kind, name = about["type"].split("/")
            if kind == "action":  # a part of one, such as Name.Impl.SendGoalService
                owner, _, part = name.split(".")
                name = f"{owner}_{part.removesuffix('Service')}"
                kind = "srv" if part.endswith("Service") else "msg"
            if package in self.refused:
                self.send(REFUSED, number, f"ModuleNotFoundError: No module named '{package}'".encode())
            else:
                self.send(DECLARED, number, json.dumps(fields(f"{package}/{name}", kind)).encode())
            row = {**about, "number": number}  # noted last, so that what a test says comes after the answer
            if about["verb"] == "subscribe":
                self.taken[about["name"]] = row
            if about["verb"] != "subscribe" or about["name"] not in self.declared:
                self.declared[about["name"]] = row
        elif sort == DROP:
            self.declared = {key: one for key, one in self.declared.items() if one["number"] != number}
        elif sort == MESSAGE:
            (name,) = (key for key, one in self.declared.items() if one["number"] == number)
            self.received[name].append(body)
        elif sort == ANSWER:
            self.answers[body[:8]] = body[8:]

    def send(self, sort, number, body):
        with self._lock:
            self.socket.sendall(struct.pack("<IBI", len(body) + 5, sort, number) + body)

    def number(self, name):
        return wait_for(lambda: self.declared.get(name))["number"]

    def listen(self, name, count=1):
        self.send(LISTENED, self.number(name), struct.pack("<I", count))

    def publish(self, name, body):
        self.send(MESSAGE, wait_for(lambda: self.taken.get(name))["number"], body)

    def call(self, name, body, also):
        """Send a request; the answer, while `also` is done."""
        key = struct.pack("<Q", len(self.answers) + 1)
        self.send(REQUEST, self.number(name), key + body)
        return wait_for(lambda: self.answers.get(key), also)


def fields(name, kind):
    """What a bridge says of the fields of a type."""
    if kind == "srv":
        service = service_type(name, 2)
        kinds = [service.request, service.response]
    else:
        kinds = [message_type(name, 2)]
    tables = []
    for one in kinds:
        table = described(one)
        table[""] = table.pop(one.name)
        tables.append(table)
    return tables


def cdr(kind, table):
    named = {kind.name if name == "" else name: rows for name, rows in table.items()}
    return Codec(kind, cdr=True, schema=read_schema(named, kind))


class Server:
    """A world that speaks ROS 2 with the tests' graph."""

    def __init__(self, graph, core, ros):
        self.graph, self.core, self.ros = graph, core, ros

    def topic(self, name):
        """The next message of a topic."""
        kind = message_type(
            wait_for(lambda: self.graph.declared.get(name), self.core.Step)["type"].replace("/msg/", "/"), 2
        )
        self.graph.listen(name)
        self.graph.received[name].clear()
        body = wait_for(lambda: self.graph.received[name], self.core.Step)[0]
        return cdr(kind, fields(kind.name, "msg")[0]).unpack(body)

    def send(self, topic, kind, **values):
        """Publish a message, for the server to receive."""
        message = message_type(kind, 2)(**values)
        self.graph.publish(topic, cdr(message.kind, fields(kind, "msg")[0]).pack(message))

    def call(self, name, kind, /, **values):
        service = service_type(kind, 2)
        request, response = fields(kind, "srv")
        body = cdr(service.request, request).pack(service.request(**values))
        answer = self.graph.call(name, body, self.core.Step)
        assert answer[:1] == b"\1", answer
        return cdr(service.response, response).unpack(answer[1:])
