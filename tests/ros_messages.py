"""What two servers say on topics: messages as numbers and texts, and how far apart they are."""

import itertools
import re
import select
import socket
import statistics
import struct

import numpy as np
from ros_peers import decode, encode, read_block

from libgz.ros.packing import codec
from libgz.ros.types import Message, Stamp, message_type

SHOWN = 24  # of the numbers of an array that are kept
COUNTED = re.compile(r"i:\(\d+/\d+\)|time:.*\n")  # in texts of bumpers
SOME = 12  # messages of a moment: of all that share a stamp, as those of /tf


class Tap:
    """Reads topics by their addresses: names -> (host, port)."""

    def __init__(self, addresses):
        self.headers, self.messages, self._data, self._poll = {}, {}, {}, select.poll()
        self._sockets = {}
        for topic, address in addresses.items():
            one = socket.create_connection(address, 20.0)
            one.sendall(encode({"callerid": "/tap", "topic": topic, "type": "*", "md5sum": "*"}))
            header = self.headers[topic] = decode(read_block(one))
            assert "error" not in header, header
            self.messages[topic], self._data[topic] = [], bytearray()
            self._sockets[one.fileno()] = topic, one
            self._poll.register(one, select.POLLIN)

    def read(self, patience=0.0):
        """Take what has come [s]."""
        while found := self._poll.poll(patience * 1e3):
            for number, _ in found:
                topic, one = self._sockets[number]
                data = self._data[topic]
                piece = one.recv(1 << 20)
                if not piece:
                    self._poll.unregister(one)
                data += piece
                while len(data) >= 4 and len(data) >= 4 + (size := struct.unpack_from("<I", data)[0]):
                    kind = message_type(self.headers[topic]["type"])
                    self.messages[topic].append(codec(kind).unpack(bytes(data[4 : 4 + size])))
                    del data[: 4 + size]
            patience = 0.0

    def close(self):
        for _, one in self._sockets.values():
            one.close()


def stamp_of(message):
    """The time of a message [s]; None without one."""
    if hasattr(message, "clock"):
        return message.clock.seconds
    if hasattr(message, "transforms"):
        return message.transforms[0].header.stamp.seconds
    return message.header.stamp.seconds if hasattr(message, "header") else None


def last_time(messages):
    """The time of the last message [s]; those without one come with each iteration."""
    if not messages:
        return -1.0
    stamp = stamp_of(messages[-1])
    return len(messages) * 1e-3 if stamp is None else stamp


def digest(messages, seconds, wanted=None):
    """What one topic said until a time: rates, and messages at two times as flat tables: half of it and its end."""
    timed = [(stamp_of(one), one) for one in messages]
    if messages and timed[0][0] is None:  # of each iteration
        timed = [(number * 1e-3, one) for number, one in enumerate(messages, 1)]
    timed = [(at, one) for at, one in timed if at <= seconds + 1e-6]
    times = sorted({at for at, _ in timed})
    gaps = [b - a for a, b in itertools.pairwise(times)]
    samples = []
    for moment in wanted or (seconds / 2.0, seconds):
        nearest = min(times, key=lambda at: abs(at - moment))
        same = [flat(one) for at, one in timed if at == nearest]
        samples.append([round(nearest, 9), sorted(same[:SOME], key=str)])
    return {"count": len(timed), "gap": round(statistics.median(gaps), 6), "samples": samples}


def flat(value, path="", found=None):
    """The fields of a message by their paths; of long arrays, the length and some values."""
    found = {} if found is None else found
    if isinstance(value, Message):
        if value.kind.name == "geometry_msgs/Quaternion" and value.w < 0.0:  # the same turn
            value = value.kind(x=-value.x, y=-value.y, z=-value.z, w=-value.w)
        for field in value.kind.fields:
            part = numbers_of(value) if field.name == "data" else getattr(value, field.name)
            if field.name != "seq":
                flat(part, f"{path}.{field.name}" if path else field.name, found)
    elif isinstance(value, Stamp):
        pass  # the times are compared by themselves
    elif isinstance(value, str):
        found[path] = COUNTED.sub("", value)
    elif isinstance(value, list) and value and isinstance(value[0], Message):
        found[f"{path}.length"] = len(value)
        for number in chosen(len(value)):
            flat(value[number], f"{path}.{number}", found)
    elif isinstance(value, list) and value and isinstance(value[0], str):
        found[path] = value
    elif isinstance(value, bytes) or hasattr(value, "__len__"):
        array = np.frombuffer(value, "u1") if isinstance(value, bytes) else np.asarray(value)
        found[f"{path}.length"] = len(array)
        found[path] = [number_of(array[index]) for index in chosen(len(array))]
    else:
        found[path] = number_of(value)
    return found


def numbers_of(message):
    """The data of an image or of a cloud as numbers, without the colours of points."""
    data = message.data
    if message.kind.name == "sensor_msgs/PointCloud2":
        return np.frombuffer(data, "<f4").reshape(-1, message.point_step // 4)[:, :3].ravel()
    return np.frombuffer(data, "<f4") if getattr(message, "encoding", "") == "32FC1" else data


def chosen(length):
    """Indices of an array that are kept."""
    return range(length) if length <= SHOWN else sorted({round(at) for at in np.linspace(0, length - 1, SHOWN)})


def number_of(value):
    """A number as JSON can hold it."""
    value = float(value)
    return float(f"{value:.7g}") if np.isfinite(value) else str(value)


def differences(topic, there, here, tolerances):
    """Sentences about what differs between the digests of a topic."""
    found = []
    if abs(there["gap"] - here["gap"]) > 0.02 * there["gap"] + 1.1e-3:
        found.append(f"{topic}: a message each {there['gap']} s there, each {here['gap']} s here")
    for (at, one), (moment, other) in zip(there["samples"], here["samples"], strict=True):
        if abs(at - moment) > 0.5 * there["gap"] + 1.1e-3:
            found.append(f"{topic}: a message of {at} s there, of {moment} s here")
        if len(one) != len(other):
            found.append(f"{topic} at {at} s: {len(one)} messages there, {len(other)} here")
        for number, (left, right) in enumerate(itertools.zip_longest(one, other, fillvalue={})):
            for path in dict.fromkeys([*left, *right]):
                place = f"{topic}:{path}"
                most, share = next((value for part, value in tolerances.items() if part in place), (2e-4, 0.0))
                if not alike(left.get(path), right.get(path), most, share):
                    found.append(f"{place} [{number}] at {at} s: {left.get(path)} there, {right.get(path)} here")
    return found


def alike(one, other, most, share=0.0):
    """Whether two values are as far apart as they may be; in arrays, a share of the numbers may be farther."""
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        far = sum(not alike(a, b, most) for a, b in zip(one, other, strict=True))
        return far <= share * len(one)
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= most * max(1.0, abs(one))
    return one == other
