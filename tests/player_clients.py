"""Clients of Player's protocols for tests, written from the documents of the protocol and not from libgz's tables."""

import socket
import struct

CODES = {"power": 2, "gripper": 3, "position2d": 4, "sonar": 5, "laser": 6, "ptz": 8, "speech": 12, "gps": 13}
CODES |= {
    "fiducial": 10,
    "truth": 15,
    "ir": 22,
    "wifi": 23,
    "mcom": 26,
    "position3d": 30,
    "simulation": 31,
    "camera": 40,
}
CODES |= {"actarray": 53}
DATA, COMMAND, REQUEST, ACK, SYNCH, NACK, ERROR = range(1, 8)


def free_port():
    """A port that nobody listens on."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        return free.getsockname()[1]


class Client:
    """A connection to a server in this process, whose loop is turned until something has come."""

    def __init__(self, server, port=None):
        self.server = server
        self.socket = socket.create_connection(("127.0.0.1", port or server.ports[0]), timeout=5.0)
        self.socket.setblocking(False)
        self.buffer, self.kept = b"", []
        self.banner = self.read(32)

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        self.socket.close()

    def read(self, size):
        for _ in range(2000):
            if len(self.buffer) >= size:
                found, self.buffer = self.buffer[:size], self.buffer[size:]
                return found
            try:
                part = self.socket.recv(1 << 16)
            except BlockingIOError:
                self.server.turn(0.002)
                continue
            if part == b"":
                raise EOFError("the server closed the connection")
            self.buffer += part
        raise TimeoutError(f"{len(self.buffer)} of {size} bytes came")

    def closed(self):
        try:
            while True:
                self.read(1)
        except EOFError:
            return True
        except TimeoutError:
            return False

    def answer(self):
        """The next message that is no data; what comes before it is kept."""
        while True:
            found = self.receive()
            if found[0] not in (DATA, SYNCH):
                return found
            self.kept.append((found, self.time))

    def message(self):
        """The next message."""
        if not self.kept:
            return self.receive()
        found, self.time = self.kept.pop(0)
        return found

    def data(self, interface, index=0):
        """The payload of the next data of a device."""
        for _ in range(100):
            kind, code, at, *_, payload = self.message()
            if (kind, code, at) == (DATA, CODES[interface], index):
                return payload
        raise TimeoutError(f"no data of {interface}")


class Client1(Client):
    """1.6: messages are (type, code, index, payload)."""

    def send(self, kind, code, index, payload):
        self.socket.send(struct.pack(">2s3H6I", b"Xx", kind, code, index, 0, 0, 0, 0, 0, len(payload)) + payload)

    def receive(self):
        mark, kind, code, index, _, _, seconds, part, _, size = struct.unpack(">2s3H6I", self.read(32))
        assert mark == b"Xx"
        self.time = seconds + part / 1e6
        return kind, code, index, self.read(size)

    def request(self, interface, payload, index=0):
        self.send(REQUEST, 1 if interface == "player" else CODES[interface], index, payload)
        return self.answer()

    def command(self, interface, payload, index=0):
        self.send(COMMAND, CODES[interface], index, payload)

    def subscribe(self, interface, index=0, access="a"):
        kind, _, _, payload = self.request("player", struct.pack(">HHHB", 3, CODES[interface], index, ord(access)))
        assert kind == ACK
        subtype, code, at, granted, driver = struct.unpack(">HHHB64s", payload)
        assert (subtype, code, at) == (3, CODES[interface], index)
        return chr(granted), driver.rstrip(b"\0").decode()


class Client2(Client):
    """2.0 and later: messages are (type, code, index, subtype, payload)."""

    sequence = 0  # 2.0 sends any number

    def send(self, kind, code, index, subtype, payload=b""):
        header = struct.pack(">6IdII", 0, 0, code, index, kind, subtype, 0.0, self.sequence, len(payload))
        self.socket.send(header + payload)

    def receive(self):
        host, robot, code, index, kind, subtype, self.time, _, size = struct.unpack(">6IdII", self.read(40))
        assert (host, robot) == (0x0100007F, self.server.ports[0])  # by which clients find their device
        return kind, code, index, subtype, self.read(size)

    def request(self, interface, subtype, payload=b"", index=0):
        self.send(REQUEST, 1 if interface == "player" else CODES[interface], index, subtype, payload)
        found = self.answer()
        assert found[3] == subtype
        return found

    def command(self, interface, subtype, payload=b"", index=0):
        self.send(COMMAND, CODES[interface], index, subtype, payload)

    def subscribe(self, interface, index=0, access=1):
        kind, *_, payload = self.request("player", 3, struct.pack(">7I", 0, 0, CODES[interface], index, access, 0, 0))
        if kind == NACK:
            return None
        _, _, code, at, granted, count, again = struct.unpack_from(">7I", payload)
        assert (code, at, count) == (CODES[interface], index, again)
        return granted, payload[28 : 28 + count].rstrip(b"\0").decode()

    def mode(self, mode):
        assert self.request("player", 5, struct.pack(">I", mode))[0] == ACK
