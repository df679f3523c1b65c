"""One process of libFuzzer for one reader; `python -m fuzz` starts it.

What a reader does wrong is written to the folder of findings, one file of each kind, and fuzzing continues. A crash, a
timeout or too little memory ends the process; libFuzzer has then written the input there.
"""

from __future__ import annotations

import contextlib
import os
import random
import re
import resource
import struct
import sys
import traceback
import zlib
from hashlib import sha1
from pathlib import Path

import atheris
from mutants import mutant

# Before anything of the package is imported, as the instrumentation is done then.
with atheris.instrument_imports(include=["libgz", "PIL"]):
    from damaged_states import damage
    from readers import TEXT, problem, warm

    from libgz.base.errors import StateError
    from libgz.rendering.choice import prefer

    prefer("none")
    warm()

MEMORY = 3 << 30  # bytes of address space, beyond what the process has at first
CHUNKS = 100  # of a PNG file, whose check sums are corrected


class Reader:
    """Runs inputs, and keeps those on which a reader fails."""

    def __init__(self, kind: str, folder: Path, findings: Path) -> None:
        self.kind, self.findings = kind, findings
        self.path = folder / f"input.{'world' if kind in ('legacy', 'sdf') else kind}"
        self.known: set[str] = set()

    def run(self, data: bytes) -> None:
        """Give an input to the reader."""
        self.path.write_bytes(data)
        try:
            what = problem(self.kind, self.path)
        except Exception:  # noqa: BLE001 - what is looked for
            what = traceback.format_exc()
        if what:
            self.keep(data, what)

    def keep(self, data: bytes, what: str) -> None:
        """Write a finding, unless one like it is known."""
        end = "\n".join(what.splitlines()[-4:])
        name = sha1(re.sub(r"'.*?'|\d+", "", end).encode()).hexdigest()[:12]
        if name not in self.known:
            self.known.add(name)
            (self.findings / f"wrong-{name}").write_bytes(data)

    def mutate(self, data: bytes, most: int, seed: int) -> bytes:
        """Change an input, by libFuzzer's ways or by those of the trials of mutated files."""
        rng = random.Random(seed)
        if rng.random() < 0.5:
            new = mutant(seed, 0, data, text=self.kind in TEXT)
        elif self.kind == "state" and rng.random() < 0.7:
            with contextlib.suppress(StateError):
                return damage(rng, data)[0][:most]
            return data
        else:
            new = atheris.Mutate(data, most)
        return (with_check_sums(new) if self.kind == "png" and rng.random() < 0.9 else new)[:most]


def with_check_sums(data: bytes) -> bytes:
    """A PNG file whose check sums are right, so that more than the check is tried."""
    new, place = bytearray(data), 8
    for _ in range(CHUNKS):
        if place + 12 > len(new):
            break
        end = place + 8 + struct.unpack_from(">I", new, place)[0]
        if end + 4 > len(new):
            break
        struct.pack_into(">I", new, end, zlib.crc32(bytes(new[place + 4 : end])))
        place = end + 4
    return bytes(new)


def main() -> None:
    """Arguments: kind of file, folder of findings, folder to work in, then libFuzzer's."""
    kind, findings, folder = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    os.chdir(folder)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, size + MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    reader = Reader(kind, folder, findings)
    atheris.Setup([sys.argv[0], *sys.argv[4:]], reader.run, custom_mutator=reader.mutate)
    atheris.Fuzz()


main()
