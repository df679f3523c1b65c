"""A client of Gazebo classic's protocol: Google's protobuf and plain sockets, without any code of libgz."""

from __future__ import annotations

import functools
import socket
import time
from pathlib import Path

from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto

TABLE = Path(__file__).parents[1] / "libgz" / "classic" / "msgs" / "messages.txt"
PATIENCE = 60.0  # [s]: a machine under load
_opened = []


def close_all():
    """Close what a test that failed has left open: the warning of it would fail another test."""
    for one in _opened:
        one.close()
    _opened.clear()


@functools.cache
def declared():
    """Name to declaration of all messages and enumerations."""
    lines = [line.split(": ", 1) for line in TABLE.read_text().splitlines() if not line.startswith("#")]
    return dict(lines)


@functools.cache
def types():
    """All message types by their names, in one file."""
    file = FileDescriptorProto(name="classic.proto", package="gazebo.msgs", syntax="proto2")
    made = {}
    for name in sorted(declared(), key=lambda name: name.count(".")):
        outer, _, short = name.rpartition(".")
        if declared()[name].startswith("enum "):
            enum = made[outer].enum_type.add(name=short)
            for part in declared()[name].removeprefix("enum ").split(", "):
                enum.value.add(name=part.split()[0], number=int(part.split()[1]))
        else:
            made[name] = made[outer].nested_type.add(name=short) if outer else file.message_type.add(name=short)
    for name, message in made.items():
        for part in declared()[name].split(", "):
            words, _, default = part.partition(" = ")
            kind, field, number = words.split()
            label = 3 if field.endswith("[]") else 2 if field.endswith("!") else 1
            new = message.field.add(name=field.rstrip("[]!"), number=int(number), label=label)
            if kind in declared():
                new.type = 14 if declared()[kind].startswith("enum ") else 11
                new.type_name = f".gazebo.msgs.{kind}"
            else:
                new.type = FieldDescriptorProto.Type.Value(f"TYPE_{kind.upper()}")
            if default:
                new.default_value = default.strip('"')
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return {name: message_factory.GetMessageClass(pool.FindMessageTypeByName(f"gazebo.msgs.{name}")) for name in made}


def new(kind, /, **values):
    """A message by the name of its type."""
    return types()[kind](**values)


def frame(data):
    return b"%08x" % len(data) + data


def packet(kind, message):
    """A framed packet."""
    made = new("Packet", type=kind, serialized_data=message.SerializeToString())
    made.stamp.sec, made.stamp.nsec = int(time.time()), 0
    return frame(made.SerializeToString())


def receive(connection):
    """The content of the next frame."""
    data = b""
    size = 8
    while len(data) < size:
        part = connection.recv(size - len(data))
        if not part:
            raise EOFError("the connection was closed")
        data += part
        if len(data) == 8 and size == 8:
            size = 8 + int(data, 16)
    return data[8:]


class Connection:
    """A connection to a master."""

    def __init__(self, port, host="127.0.0.1"):
        self.socket = socket.create_connection((host, port), timeout=PATIENCE)
        _opened.append(self)
        self.first = [self.packet() for _ in range(3)]
        self.host, self.port = self.socket.getsockname()

    def packet(self):
        found = new("Packet")
        found.ParseFromString(receive(self.socket))
        return found

    def wait(self, kinds, name, condition=lambda message: True):
        """The next message of a kind of packet, or one of several, for which a condition holds."""
        while True:
            found = self.packet()
            if found.type in kinds.split():
                message = types()[name].FromString(found.serialized_data)
                if condition(message):
                    return message

    def send(self, kind, message):
        self.socket.sendall(packet(kind, message))

    def ask(self, request, answer, name, data=""):
        """Send a request, and return its answer."""
        self.send("request", new("Request", id=1, request=request, data=data))
        return self.wait(answer, name)

    def close(self):
        self.socket.close()


class Subscription:
    """A subscription to a topic at its publisher."""

    def __init__(self, master, topic, name, latching=False):
        self.name = name
        own = new("Subscribe", topic=topic, host="127.0.0.1", port=1, msg_type=f"gazebo.msgs.{name}", latching=latching)
        master.send("subscribe", own)
        # The first one if it is advertised already, the second one if that is on its way.
        kinds = "publisher_subscribe publisher_advertise"
        at = master.wait(kinds, "Publish", lambda found: found.topic == topic)
        assert at.msg_type == f"gazebo.msgs.{name}"
        self.socket = socket.create_connection((at.host, at.port), timeout=PATIENCE)
        _opened.append(self)
        self.socket.sendall(packet("sub", own))

    def next(self):
        return types()[self.name].FromString(receive(self.socket))

    def until(self, condition):
        """The first message for which a condition holds."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if condition(message := self.next()):
                return message
        raise AssertionError("it did not come")

    def close(self):
        self.socket.close()


class Publication:
    """A topic that this client publishes, and the server subscribes to."""

    def __init__(self, master, topic, name):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.socket = self.listener  # until the server has connected
        _opened.append(self)
        self.listener.settimeout(PATIENCE)
        host, port = self.listener.getsockname()
        master.send("advertise", new("Publish", topic=topic, msg_type=f"gazebo.msgs.{name}", host=host, port=port))
        self.socket, _ = self.listener.accept()
        self.socket.settimeout(PATIENCE)
        found = types()["Packet"].FromString(receive(self.socket))
        self.subscription = types()["Subscribe"].FromString(found.serialized_data)
        assert (found.type, self.subscription.topic) == ("sub", topic)

    def publish(self, message):
        self.socket.sendall(frame(message.SerializeToString()))

    def close(self):
        self.socket.close()
        self.listener.close()
