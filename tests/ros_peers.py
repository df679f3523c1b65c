"""A master of ROS 1 and a node of the tests' own, by the standard library; nothing of libgz's wire is used here."""

import functools
import socket
import struct
import threading
import time
import xmlrpc.client
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

PATIENCE = 20.0  # [s]


def ask(uri, method, *values):
    """Call a method by XML-RPC."""
    with xmlrpc.client.ServerProxy(uri, allow_none=True) as peer:
        return getattr(peer, method)(*values)


class Quiet(SimpleXMLRPCRequestHandler):
    def log_message(self, *_values):
        pass


class Master:
    """Keeps lists of publishers, subscribers, services and parameters; tells subscribers of new publishers."""

    def __init__(self, port=0):
        self.publishers, self.subscribers, self.services, self.parameters, self.nodes = {}, {}, {}, {}, {}
        self.sockets = []  # of the tests' node
        self.server = SimpleXMLRPCServer(("127.0.0.1", port), Quiet, allow_none=True, logRequests=False)
        self.port = self.server.server_address[1]
        self.uri = f"http://127.0.0.1:{self.port}/"
        for name in dir(self):
            if name[0] != "_" and name[0].islower() and any(map(str.isupper, name)):
                self.server.register_function(getattr(self, name), name)
        self.thread = threading.Thread(target=self.server.serve_forever, args=(0.02,), daemon=True)
        self.thread.start()

    def close(self):
        for sock in self.sockets:
            sock.close()
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()

    def registerPublisher(self, caller, topic, kind, uri):
        self.nodes[caller] = uri
        self.publishers.setdefault(topic, {})[caller] = (kind, uri)
        for other in self.subscribers.get(topic, {}).values():
            ask(other, "publisherUpdate", "/master", topic, [one for _, one in self.publishers[topic].values()])
        return 1, "", []

    def registerSubscriber(self, caller, topic, kind, uri):
        self.nodes[caller] = uri
        self.subscribers.setdefault(topic, {})[caller] = uri
        return 1, "", [one for _, one in self.publishers.get(topic, {}).values()]

    def registerService(self, caller, name, service, uri):
        self.nodes[caller] = uri
        self.services[name] = service
        return 1, "", 0

    def unregisterPublisher(self, caller, topic, uri):
        return 1, "", int(self.publishers.get(topic, {}).pop(caller, None) is not None)

    def unregisterSubscriber(self, caller, topic, uri):
        return 1, "", int(self.subscribers.get(topic, {}).pop(caller, None) is not None)

    def unregisterService(self, caller, name, service):
        return 1, "", int(self.services.pop(name, None) is not None)

    def lookupNode(self, caller, name):
        return (1, "", self.nodes[name]) if name in self.nodes else (-1, f"unknown node {name}", "")

    def lookupService(self, caller, name):
        return (1, "", self.services[name]) if name in self.services else (-1, f"no service {name}", "")

    def hasParam(self, caller, key):
        return 1, "", key in self.parameters

    def getParam(self, caller, key):
        return (1, "", self.parameters[key]) if key in self.parameters else (-1, f"{key} is not set", 0)

    def setParam(self, caller, key, value):
        self.parameters[key] = value
        return 1, "", 0


def wait_for(condition, also=lambda: None):
    """Wait until a condition holds, doing something meanwhile."""
    end = time.monotonic() + PATIENCE
    while not (value := condition()):
        assert time.monotonic() < end, "it did not happen in time"
        also()
        time.sleep(0.002)
    return value


def within(lock, act):
    """Act in a thread that holds a lock; whether it comes to an end."""

    def run():
        with lock:
            act()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(PATIENCE)
    return not thread.is_alive()


def encode(fields):
    parts = [f"{key}={value}".encode() for key, value in fields.items()]
    body = b"".join(struct.pack("<I", len(part)) + part for part in parts)
    return struct.pack("<I", len(body)) + body


def read_exactly(sock, size):
    data = b""
    while len(data) < size:
        piece = sock.recv(size - len(data))
        if not piece:
            raise EOFError
        data += piece
    return data


def read_block(sock):
    return read_exactly(sock, struct.unpack("<I", read_exactly(sock, 4))[0])


def decode(body):
    fields, at = {}, 0
    while at < len(body):
        (size,) = struct.unpack_from("<I", body, at)
        key, _, value = body[at + 4 : at + 4 + size].partition(b"=")
        fields[key.decode()] = value.decode()
        at += 4 + size
    return fields


def open_topic(master, topic, **fields):
    """(socket, header) of a subscription to a topic, once it is published."""
    wait_for(lambda: master.publishers.get(topic))
    ((_, uri),) = master.publishers[topic].values()
    code, text, (_, host, port) = ask(uri, "requestTopic", "/tester", topic, [["TCPROS"]])
    assert code == 1, text
    sock = socket.create_connection((host, port), PATIENCE)
    master.sockets.append(sock)
    sock.sendall(encode({"callerid": "/tester", "topic": topic, "type": "*", "md5sum": "*", **fields}))
    return sock, decode(read_block(sock))


class Service:
    """A persistent connection to a service, once it is served."""

    def __init__(self, master, name, **fields):
        wait_for(lambda: name in master.services)
        host, port = master.services[name].removeprefix("rosrpc://").split(":")
        self.socket = socket.create_connection((host, int(port)), PATIENCE)
        master.sockets.append(self.socket)
        header = {"callerid": "/tester", "service": name, "md5sum": "*", "persistent": "1", **fields}
        self.socket.sendall(encode(header))
        self.header = decode(read_block(self.socket))

    def send(self, body):
        self.socket.sendall(struct.pack("<I", len(body)) + body)

    def answer(self):
        good = read_exactly(self.socket, 1)
        return good == b"\1", read_block(self.socket)


class Talker:
    """Publishes one topic, once it is subscribed to: a node with one connection at a time."""

    def __init__(self, master, topic, kind, md5, name="/talker"):
        wait_for(lambda: master.subscribers.get(topic))  # else nobody is told of it
        self.topic, self.kind, self.md5 = topic, kind, md5
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.server = SimpleXMLRPCServer(("127.0.0.1", 0), Quiet, allow_none=True, logRequests=False)
        self.server.register_function(self._request, "requestTopic")
        self.thread = threading.Thread(target=self.server.serve_forever, args=(0.02,), daemon=True)
        self.thread.start()
        uri = f"http://127.0.0.1:{self.server.server_address[1]}/"
        self.unregister = functools.partial(master.unregisterPublisher, name, topic, uri)
        master.registerPublisher(name, topic, kind, uri)
        self.socket, _ = self.listener.accept()
        master.sockets += [self.socket, self.listener]
        self.asked = decode(read_block(self.socket))
        self.socket.sendall(encode({"callerid": name, "type": kind, "md5sum": md5, "latching": 0}))

    def _request(self, _caller, _topic, _protocols):
        return 1, "", ["TCPROS", "127.0.0.1", self.listener.getsockname()[1]]

    def send(self, body):
        self.socket.sendall(struct.pack("<I", len(body)) + body)

    def close(self):
        self.unregister()
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()
        self.socket.close()
        self.listener.close()
