"""The C library, compiled from the sources of this package on demand and stored in the user's cache."""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

from libgz.clib import FOLDER
from libgz.errors import LibraryError

__all__ = ["SOURCES", "compiler", "library_folder"]

SOURCES = ("client.c", "error.c", "iface.c", "interfaces.c", "server.c")
FLAGS = ("-O2", "-std=gnu99", "-fPIC")
ARCHIVE = "libgazebo.a"


def compiler() -> list[str]:
    """The C compiler's command: CC if it is set, else cc or gcc.

    Raises:
        LibraryError: there is no compiler.
    """
    wanted = shlex.split(os.environ.get("CC", ""))
    for command in [wanted] if wanted else [["cc"], ["gcc"]]:
        if shutil.which(command[0]):
            return command
    problem = f"the compiler {wanted[0]!r}, named by CC, is not installed" if wanted else "no C compiler is installed"
    raise LibraryError(f"{problem}; the C library needs one: apt-get install gcc libc6-dev")


def library_folder() -> Path:
    """The directory of libgazebo.a, which is compiled if it is not in the cache.

    Raises:
        LibraryError: there is no compiler, it failed, or the cache cannot be written.
    """
    command = compiler()
    folder = _cache() / f"libgz-{_fingerprint(command)}"
    if not (folder / ARCHIVE).exists():
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=folder) as temporary:
                _compile(command, Path(temporary))
                # Atomically, so that no program links an incomplete archive.
                (Path(temporary) / ARCHIVE).replace(folder / ARCHIVE)
        except OSError as error:
            raise LibraryError(f"the C library cannot be stored in {folder}: {error}; set XDG_CACHE_HOME") from None
    return folder


def _cache() -> Path:
    place = os.environ.get("XDG_CACHE_HOME", "")
    return Path(place) if Path(place).is_absolute() else Path.home() / ".cache"


def _fingerprint(command: list[str]) -> str:
    """A short hash of the sources and of the compiler's command."""
    digest = hashlib.sha256(" ".join([*command, *FLAGS]).encode())
    for path in [*sorted(FOLDER.glob("*.[ch]")), FOLDER / "interfaces.def"]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _compile(command: list[str], folder: Path) -> None:
    sources = [str(FOLDER / name) for name in SOURCES]
    objects = [name.replace(".c", ".o") for name in SOURCES]
    archiver = shutil.which("ar")
    if archiver is None:
        raise LibraryError("`ar` is not installed; the C library needs it: apt-get install binutils")
    for step in ([*command, *FLAGS, "-c", *sources], [archiver, "rcs", ARCHIVE, *objects]):
        done = subprocess.run(step, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise LibraryError(f"the C library does not compile: {shlex.join(step)}\n{done.stderr.strip()}")
