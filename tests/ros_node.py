"""A node of the tests' own beside a world in the same process: it steps the world while it waits."""

import struct

from ros_peers import Service, Talker, open_topic, read_block, wait_for

from libgz.ros.api import SERVICES
from libgz.ros.packing import codec
from libgz.ros.types import message_type, service_type


class Node:
    """The tests' node beside a world."""

    def __init__(self, master, core, ros):
        self.master, self.core, self.ros = master, core, ros

    def topic(self, name, kind):
        """A function that steps the world until a message of a topic has come, and returns it."""
        wait_for(lambda: self.master.publishers.get(name), self.core.Step)
        sock, header = open_topic(self.master, name)
        assert header.get("type") == kind, header
        sock.settimeout(0.001)
        pack, data = codec(message_type(kind)), bytearray()

        def read():
            nonlocal data

            def whole():
                try:
                    data.extend(sock.recv(1 << 16))
                except TimeoutError:
                    self.core.Step()
                return len(data) >= 4 and len(data) >= 4 + struct.unpack_from("<I", data)[0]

            wait_for(whole)
            (size,) = struct.unpack_from("<I", data)
            body, data = bytes(data[4 : 4 + size]), data[4 + size :]
            return pack.unpack(body)

        return read

    def call(self, name, **values):
        """Call a service of /gazebo."""
        return self.ask(f"/gazebo/{name}", SERVICES[name], **values)

    def ask(self, name, type, **values):
        """Call a service."""
        kind = service_type(type)
        wait_for(lambda: name in self.master.services, self.core.Step)
        client = Service(self.master, name, md5sum=kind.md5)
        client.send(codec(kind.request).pack(kind.request(**values)))
        client.socket.settimeout(0.001)

        def first():
            try:
                return client.socket.recv(1)
            except TimeoutError:
                return b""

        good = wait_for(first, self.core.Step)
        client.socket.settimeout(10.0)
        body = read_block(client.socket)
        assert good == b"\1", body
        return codec(kind.response).unpack(body)

    def talk(self, topic, type):
        """What publishes messages on a topic that the world subscribes to, with the type of the messages."""
        kind = message_type(type)
        wait_for(lambda: topic in self.master.subscribers, self.core.Step)
        talker = Talker(self.master, topic, kind.name, kind.md5)

        def send(**values):
            message = kind()
            for path, value in values.items():
                *way, last = path.split("__")
                part = message
                for name in way:
                    part = getattr(part, name)
                setattr(part, last, value)
            talker.send(codec(kind).pack(message))

        return send
