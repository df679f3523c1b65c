"""What hostile clients cost a server of Gazebo classic's protocol: a step with and without each kind of attack.

    python benchmarks/hostile.py [PAIRS [ATTACK ...]]

A world of 20 boxes publishes its poses to a client that reads them. Another process attacks, and rests, in turn; a
block is measured after half a second in which the attack settles. The figures are the median ratio of blocks side by
side, and the 95 % interval of that median: CPU times of the whole server process, for the step waits for what its
thread of topics does; and wall-clock times, which say the same on an idle machine. Then the most that was held for
clients (see SECURITY.md), and the memory of the process. The exit code is 1 if an interval of CPU times is wholly above
the limit, or more is held than all bounds together allow.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from rounds import interval, text_of

import libgz
from libgz.classic.transport import TopicManager, serve

PAIRS, LIMIT = 15, 0.05
LIMIT_OF_COMMANDS = 2.0  # what their messages ask for may take as long as all else; then native code makes single steps
SETTLING, BLOCK = 0.5, 0.7  # [s]
BOXES = 20
BOX = """<model name='b{i}'><allow_auto_disable>0</allow_auto_disable><pose>{i} 0 0.5 0 0 0</pose><link name='l'>
<collision name='c'><geometry><box><size>0.5 0.5 0.5</size></box></geometry></collision></link></model>"""
GROUND = "<include><uri>model://ground_plane</uri></include>"
ATTACKS = {
    "garbage": "lengths that are no numbers, as fast as the server takes them",
    "giant": "headers that announce 4 GB, with data behind them",
    "half": "200 connections with half a packet",
    "valid": "valid requests as fast as the server takes them",
    "slow": "10 subscribers to poses that read nothing",
    "thousand": "1000 connections, opened and closed again and again",
    "sinks": "300 subscribers to poses that read nothing",
    "parts": "400 connections with nearly all of a packet of 64 KiB",
    "flood": "a publisher of messages of 1 MiB to ~/factory",
    "lists": "a publisher of messages with 9,999 parts to ~/model/modify",
    "resets": "a publisher of resets to ~/world_control",
}
COMMANDS = "lists", "resets"
HELD = (64 + 128 + 64) << 20  # [bytes] of all bounds together

ATTACKER = r"""
import resource, select, socket, sys, time

master, topics = int(sys.argv[1]), int(sys.argv[2])
resource.setrlimit(resource.RLIMIT_NOFILE, (4096, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))

def field(number, data):
    return bytes([number << 3 | 2, len(data) & 127 | 128, len(data) >> 7]) + data

def packet(kind, content):
    data = field(1, b"\x08\x01\x10\x01") + field(2, kind) + field(3, content)
    return b"%08x" % len(data) + data

def connect(port, data=b""):
    made = socket.socket()
    made.settimeout(2.0 if kind in FLOODS else 0.2)
    try:
        made.connect(("127.0.0.1", port))
        made.sendall(data)
    except OSError:
        pass
    kept.append(made)

def release():
    for made in kept:
        made.close()
    kept.clear()

def framed(data):
    return b"%08x" % len(data) + data

# of each the topic, the type, and what is sent
FLOODS = {
    "flood": (b"factory", b"Factory", framed(b"\x12\xfc\xff\x3f" + b"x" * ((1 << 20) - 4))),  # a name of a file
    "lists": (b"model/modify", b"Model", framed(b"\x0a\x02b1" + b"\x42\x03\x0a\x01v" * 9999)),
    "resets": (b"world_control", b"WorldControl", framed(b"\x22\x02\x08\x01") * 100),
}
REQUEST = packet(b"request", b"\x08\x01\x12\x0aget_topics")
SUBSCRIBE = packet(b"sub", field(1, b"/gazebo/default/pose/info") + field(2, b"127.0.0.1") + b"\x18\x01"
                   + field(4, b"gazebo.msgs.PosesStamped"))
kept = []
kind = "none"
connect(topics, SUBSCRIBE)
reader = kept.pop()
reader.setblocking(False)
while True:
    try:
        reader.recv(1 << 20)
    except BlockingIOError:
        pass
    while kind != "end" and select.select([sys.stdin], [], [], 0.0)[0]:
        kind = sys.stdin.readline().strip() or "end"
        release()
    if kind == "end":
        break
    if kind == "garbage":
        for port in (master, topics):
            connect(port, b"-12x4z!?" * 8)
        release()
    elif kind == "giant":
        for port in (master, topics):
            connect(port, b"ffffffff" + b"x" * 60000)
        release()
    elif kind == "half" and len(kept) < 200:
        connect(master, REQUEST[:20])
    elif kind == "valid":
        if not kept:
            connect(master)
        kept[0].setblocking(False)
        try:
            kept[0].send(REQUEST * 200)
        except OSError:
            time.sleep(0.001)
        try:
            while kept[0].recv(1 << 20):
                pass
            release()
        except BlockingIOError:
            pass
        except OSError:
            release()
    elif kind == "slow" and len(kept) < 10:
        connect(topics, SUBSCRIBE)
    elif kind == "thousand":
        connect(master)
        if len(kept) >= 1000:
            release()
    elif kind == "sinks" and len(kept) < 300:
        connect(topics, SUBSCRIBE)
    elif kind == "parts" and len(kept) < 400:
        connect(master, b"0000ffff" + b"x" * 65000)
    elif kind in FLOODS:
        topic, type_name, content = FLOODS[kind]
        if not kept:
            listener = socket.create_server(("127.0.0.1", 0))
            listener.settimeout(2.0)
            kept.append(listener)
            port = listener.getsockname()[1]
            about = field(1, b"/gazebo/default/" + topic) + field(2, b"gazebo.msgs." + type_name)
            about += field(3, b"127.0.0.1")
            digits = bytes([port & 127 | 128, port >> 7 & 127 | 128, port >> 14])
            connect(master, packet(b"advertise", about + b"\x20" + digits))
            try:
                kept.append(listener.accept()[0])
                kept[-1].setblocking(False)
                rest = b""
            except OSError:
                release()
                continue
        try:
            rest = rest or content
            rest = rest[kept[-1].send(rest):]
        except OSError:
            time.sleep(0.001)
    else:
        time.sleep(0.01)
"""


class Held:
    """The most that the process has held for clients [bytes]."""

    def __init__(self) -> None:
        self.most = 0
        network: Any = TopicManager.Instance().remote
        self._loop = network._loop

    def look(self) -> None:
        """Take the present value, if it is more."""
        now = self._loop.backlog.size + self._loop._partial + TopicManager.Instance().received.size
        self.most = max(self.most, now)

    def __str__(self) -> str:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return f"{self.most / 2**20:.1f} MiB held, process {pages * os.sysconf('SC_PAGE_SIZE') / 2**20:.0f} MiB"


def block(world: libgz.World, seconds: float, held: Held) -> tuple[float, float]:
    """CPU time and wall-clock time of one step in a block of so many seconds [us]."""
    steps, begin, cpu = 0, time.perf_counter(), time.process_time()
    while (passed := time.perf_counter() - begin) < seconds:
        world.step(10)
        steps += 10
        if not steps % 100:
            held.look()
    return (time.process_time() - cpu) / steps * 1e6, passed / steps * 1e6


def measure(
    world: libgz.World, attacker: subprocess.Popen[str], kind: str, pairs: int, held: Held
) -> list[list[float]]:
    """The ratios of blocks with an attack to those without, side by side: of CPU times, of wall-clock times."""
    ratios: list[list[float]] = [[], []]
    for number in range(pairs):
        times = {}
        for order in ("none", kind) if number % 2 else (kind, "none"):
            print(order, file=attacker.stdin, flush=True)
            block(world, SETTLING, held)
            times[order] = block(world, BLOCK, held)
        for found, attacked, alone in zip(ratios, times[kind], times["none"], strict=True):
            found.append(attacked / alone)
    return ratios


def main() -> int:
    """Print a table; the exit code."""
    pairs = int(sys.argv[1]) if len(sys.argv) > 1 else PAIRS
    wanted = sys.argv[2:] or list(ATTACKS)
    boxes = "".join(BOX.format(i=i) for i in range(BOXES))
    text = f"<sdf version='1.6'><world name='default'>{GROUND}{boxes}</world></sdf>"
    missed = 0
    with serve("http://127.0.0.1:0") as link, libgz.World.from_string(text) as world:
        world.attach_era()
        remote = TopicManager.Instance().remote
        port = remote._own[1]  # type: ignore[union-attr]
        command = [sys.executable, "-c", ATTACKER, str(link.address.port), str(port)]
        with subprocess.Popen(command, stdin=subprocess.PIPE, text=True) as attacker:
            try:
                os.setpriority(os.PRIO_PROCESS, attacker.pid, 19)  # it is to cost the server, not the machine
                for kind, what in ((kind, what) for kind, what in ATTACKS.items() if kind in wanted):
                    held = Held()
                    cpu, wall = measure(world, attacker, kind, pairs, held)
                    limit = LIMIT_OF_COMMANDS if kind in COMMANDS else LIMIT
                    missed += interval(cpu)[0] > 1.0 + limit or held.most > HELD
                    print(f"{text_of(cpu)} CPU, {text_of(wall)} wall, {held}: {what}", flush=True)
                print("the server answers" if link.connected() else "the server does not answer")
                missed += not link.connected()
            finally:
                attacker.kill()
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
