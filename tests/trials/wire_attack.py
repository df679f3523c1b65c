"""A program that attacks interface files at full speed: `wire_attack.py KIND SEED`, with orders on stdin.

KIND is `bytes` (random bytes), `locked` (the same, under the lock), `pieces` (of random bytes) or `truncate`. An order
is one line of paths, which it attacks until the next; an empty line ends it. It answers each order with the number of
attacks on the last one.
"""

from __future__ import annotations

import fcntl
import os
import random
import select
import sys
from collections.abc import Callable
from pathlib import Path

Target = tuple[int, list[bytes], int]  # descriptor, contents, size


def targets(paths: list[str], generator: random.Random) -> list[Target]:
    """The files of an order."""
    found = []
    for path in paths:
        size = Path(path).stat().st_size
        count = 16 if size < 100_000 else 3
        found.append((os.open(path, os.O_RDWR), [generator.randbytes(size) for _ in range(count)], size))
    return found


def write(target: Target, generator: random.Random) -> None:
    descriptor, contents, _ = target
    os.pwrite(descriptor, generator.choice(contents), 0)


def write_locked(target: Target, generator: random.Random) -> None:
    fcntl.flock(target[0], fcntl.LOCK_EX)
    write(target, generator)
    fcntl.flock(target[0], fcntl.LOCK_UN)


def write_piece(target: Target, generator: random.Random) -> None:
    """64 bytes anywhere: mostly not the head."""
    descriptor, contents, size = target
    start = generator.randrange(size)
    os.pwrite(descriptor, generator.choice(contents)[start : start + 64], start)


def truncate(target: Target, generator: random.Random) -> None:
    descriptor, _, size = target
    os.ftruncate(descriptor, generator.choice((0, 1, 151, size // 2, max(0, size - 1))))


ATTACKS: dict[str, Callable[[Target, random.Random], None]] = {
    "bytes": write,
    "locked": write_locked,
    "pieces": write_piece,
    "truncate": truncate,
}


def main() -> None:
    attack, generator = ATTACKS[sys.argv[1]], random.Random(int(sys.argv[2]))
    while line := sys.stdin.readline().strip():
        files, count = targets(line.split("\t"), generator), 0
        print("begin", flush=True)
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            for _ in range(50):
                attack(generator.choice(files), generator)
            count += 50
        for descriptor, _, _ in files:
            os.close(descriptor)
        print(count, flush=True)


if __name__ == "__main__":
    main()
