"""What Player's clients get, and what hostile ones cost them: latency of commands, lost samples, memory.

    python benchmarks/player.py [SECONDS]

`libgz player` runs a world with a Pioneer 2 AT in real time; 20 clients of 1.6 and 2.1 read its odometry at 10 Hz,
while one attack after another runs for so many seconds (default 20). Printed are the samples that a client missed, as
their times show; the longest time between two of them; the longest time from a command to a sample that obeys it;
and the memory of the server. The exit code is 1 if a sample is missing, a command takes longer than two updates of the
robot and 100 ms, or the memory grows by more than what clients may take. All but the memory needs an idle machine.
"""

from __future__ import annotations

import contextlib
import resource
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

CLIENTS, LIMIT = 20, 0.3  # [s] of a command: two updates of 100 ms, and 100 ms
MEMORY = 64 + 128  # [MiB] that clients may take
CONFIGURATION = """
driver ( name "gz_position" provides ["position:0"] gz_id "robot1" )
driver ( name "gz_laser" provides ["laser:0"] gz_id "laser1" )
driver ( name "gz_sim" provides ["simulation:0"] worldfile "pioneer2at.world" )
"""
HEADER1, HEADER2 = struct.Struct(">2s3H6I"), struct.Struct(">6IdII")


def message1(kind: int, code: int, payload: bytes) -> bytes:
    """A message of 1.6."""
    return HEADER1.pack(b"Xx", kind, code, 0, 0, 0, 0, 0, 0, len(payload)) + payload


def message2(kind: int, code: int, number: int, payload: bytes = b"") -> bytes:
    """A message of 2.1."""
    return HEADER2.pack(0, 0, code, 0, kind, number, 0.0, 0, len(payload)) + payload


OPEN1 = message1(3, 1, struct.pack(">HB", 5, 4)) + message1(3, 1, struct.pack(">HHHB", 3, 4, 0, ord("a")))
OPEN2 = message2(3, 1, 5, struct.pack(">I", 1)) + message2(3, 1, 3, struct.pack(">7I", 0, 0, 4, 0, 1, 0, 0))
OPEN_LASER = message2(3, 1, 5, struct.pack(">I", 1)) + message2(3, 1, 3, struct.pack(">7I", 0, 0, 6, 0, 1, 0, 0))


class Reader:
    """A client that reads the odometry."""

    def __init__(self, port: int, old: bool) -> None:
        self.old = old
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.sendall(OPEN1 if old else OPEN2)
        self.received = self.socket.recv(32, socket.MSG_WAITALL)[32:]
        self.samples: list[tuple[float, float, float]] = []  # sim time, real time, speed

    def read(self) -> None:
        """Take what has come."""
        self.received += self.socket.recv(1 << 16)
        header = HEADER1 if self.old else HEADER2
        while len(self.received) >= header.size:
            parts = header.unpack_from(self.received)
            end = header.size + parts[-1]
            if len(self.received) < end:
                return
            payload, self.received = self.received[header.size : end], self.received[end:]
            kind, code = (parts[1], parts[2]) if self.old else (parts[4], parts[2])
            if (kind, code) == (1, 4):
                stamp = parts[6] + parts[7] / 1e6 if self.old else parts[6]
                speed = (
                    struct.unpack_from(">4i", payload)[3] / 1000 if self.old else struct.unpack_from(">4d", payload)[3]
                )
                self.samples.append((stamp, time.monotonic(), speed))

    def command(self, speed: float) -> None:
        """Drive forward [m/s]."""
        if self.old:
            self.socket.sendall(message1(2, 4, struct.pack(">6i2B", 0, 0, 0, round(speed * 1000), 0, 0, 1, 0)))
        else:
            self.socket.sendall(message2(2, 4, 1, struct.pack(">3dI", speed, 0.0, 0.0, 1)))


class Attack:
    """Sockets of an attacker, which `turn` uses for a while."""

    def __init__(self, port: int) -> None:
        self.port = port
        self.sockets: list[socket.socket] = []

    def connect(self, data: bytes = b"", buffer: int = 0) -> socket.socket | None:
        """A connection that sends something first; None if it was refused."""
        made = socket.socket()
        if buffer:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        made.settimeout(0.2)
        try:
            made.connect(("127.0.0.1", self.port))
            made.sendall(data)
        except OSError:
            made.close()
            return None
        made.setblocking(False)
        self.sockets.append(made)
        return made

    def send(self, data: bytes) -> None:
        """As much as each connection takes."""
        for one in self.sockets:
            with contextlib.suppress(OSError):
                one.send(data)

    def end(self) -> None:
        """Close all."""
        for one in self.sockets:
            one.close()
        self.sockets.clear()


def nothing(attack: Attack) -> None:
    """No attack."""


def garbage(attack: Attack) -> None:
    """Another protocol, again and again."""
    attack.end()
    for _ in range(5):
        attack.connect(b"GET / HTTP/1.1\r\n\r\n" * 100)


def sizes(attack: Attack) -> None:
    """Messages that announce 4 GB, with data behind them."""
    if not attack.sockets:
        attack.connect(HEADER1.pack(b"Xx", 3, 1, 0, 0, 0, 0, 0, 0, 0xFFFFFFFF))
        attack.connect(HEADER2.pack(0, 0, 1, 0, 3, 5, 0.0, 0, 32 << 20))
    attack.send(b"z" * 65536)


def halves(attack: Attack) -> None:
    """200 connections with half a message."""
    while len(attack.sockets) < 200 and attack.connect(message1(3, 1, bytes(60_000))[:50_000]):
        pass


def thousand(attack: Attack) -> None:
    """1000 connections, opened and closed again and again."""
    for _ in range(50):
        attack.connect()
    if len(attack.sockets) >= 1000:
        attack.end()


def sinks(attack: Attack) -> None:
    """100 clients that subscribe to scans and read nothing."""
    while len(attack.sockets) < 100 and attack.connect(OPEN_LASER, 4096):
        pass


def requests(attack: Attack) -> None:
    """10 clients that ask for the list of devices as fast as they can, and read nothing."""
    while len(attack.sockets) < 10 and attack.connect(b"", 4096):
        pass
    attack.send(message1(3, 1, struct.pack(">H", 1)) * 500)


def commands(attack: Attack) -> None:
    """5 clients that command a laser as fast as they can."""
    while len(attack.sockets) < 5 and attack.connect(OPEN_LASER):
        pass
    attack.send(message2(2, 6, 1, bytes(28)) * 500)


ATTACKS = (nothing, garbage, sizes, halves, thousand, sinks, requests, commands)


def memory(pid: int) -> float:
    """The resident memory of a process [MiB]."""
    text = Path(f"/proc/{pid}/status").read_text()
    return int(text.partition("VmRSS:")[2].split()[0]) / 1024


def measure(port: int, attack_turn, seconds: float) -> tuple[int, float, float]:
    """Samples missed by any client, and the longest gap and delay of a command [s], while an attack runs."""
    attacker = subprocess.Popen([sys.executable, __file__, "--attack", attack_turn.__name__, str(port)])
    readers = [Reader(port, bool(number % 2)) for number in range(CLIENTS)]
    by_socket = {reader.socket: reader for reader in readers}
    driver, forward, sent, delay = readers[0], False, 0.0, 0.0
    end = time.monotonic() + seconds
    while (now := time.monotonic()) < end:
        if sent == 0.0 and now < end - 1.0:
            forward = not forward
            driver.command(0.1 if forward else -0.1)
            sent = now
        for ready in select.select(list(by_socket), [], [], 0.05)[0]:
            by_socket[ready].read()
        if sent and driver.samples and driver.samples[-1][1] > sent and (driver.samples[-1][2] > 0.0) == forward:
            delay, sent = max(delay, driver.samples[-1][1] - sent), 0.0
    attacker.send_signal(signal.SIGTERM)
    attacker.wait()
    missed, gap = 0, 0.0
    for reader in readers:
        stamps = [stamp for stamp, _, _ in reader.samples]
        missed = max(missed, sum(round((b - a) / 0.1) - 1 for a, b in pairwise(stamps)))
        gap = max([gap, *(b[1] - a[1] for a, b in pairwise(reader.samples))])
        reader.socket.close()
    if sent:
        delay = max(delay, time.monotonic() - sent - 1.0)
    return max(missed, 0), gap, delay


def run_attack(name: str, port: int) -> None:
    """The process of an attacker."""
    resource.setrlimit(resource.RLIMIT_NOFILE, (4096, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
    attack, turn = Attack(port), next(turn for turn in ATTACKS if turn.__name__ == name)
    while True:
        turn(attack)
        time.sleep(0.002)


def main() -> int:
    """Print the table."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    with tempfile.TemporaryDirectory() as folder, socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
        free.close()
        path = Path(folder) / "robot.cfg"
        path.write_text(CONFIGURATION)
        command = [sys.executable, "-m", "libgz", "player", str(path), "-p", str(port)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            try:
                print(server.stdout.readline().strip() if server.stdout else "")
                time.sleep(2.0)
                before, wrong = memory(server.pid), False
                print(f"{'attack':10}{'missed':>8}{'gap [ms]':>10}{'command [ms]':>14}{'memory [MiB]':>14}")
                for attack in ATTACKS:
                    missed, gap, delay = measure(port, attack, seconds)
                    now = memory(server.pid)
                    print(f"{attack.__name__:10}{missed:8}{gap * 1e3:10.0f}{delay * 1e3:14.0f}{now:14.1f}", flush=True)
                    wrong |= missed > 0 or delay > LIMIT or now > before + MEMORY or server.poll() is not None
            finally:
                server.terminate()
        return int(wrong)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--attack"]:
        run_attack(sys.argv[2], int(sys.argv[3]))
    sys.exit(main())
