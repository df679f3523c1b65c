"""The C library, compiled from the sources of this package on demand and stored in the user's cache."""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

from libgz.base.errors import LibraryError
from libgz.base.files import own_cache
from libgz.clib import FOLDER
from libgz.transport.layout import LIBGAZEBO_VERSION

__all__ = ["ARCHIVE", "FOR_I386", "SHARED", "SOURCES", "compiler", "library_folder"]

SOURCES = ("client.c", "error.c", "iface.c", "interfaces.c", "server.c")
FLAGS = ("-O2", "-std=gnu99", "-fPIC")
FOR_I386 = "-m32"
ARCHIVE = "libgazebo.a"
SHARED = "libgazebo.so.0"  # which -lgazebo does not find: programs of `libgz config --libs` contain the library


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


def library_folder(version: int = LIBGAZEBO_VERSION, *, i386: bool = False) -> Path:
    """The directory of libgazebo.a and libgazebo.so.0, which are compiled if they are not in the cache.

    Args:
        version: of the structs, one of `libgz.transport.layout.VERSIONS`.
        i386: for 32-bit programs.

    Raises:
        LibraryError: there is no compiler, it failed, or the cache cannot be written, or is another user's.
    """
    command = [*compiler(), *FLAGS, f"-DLIBGAZEBO_VERSION={version:#05x}"]
    if i386:
        command += [FOR_I386, "-D_FILE_OFFSET_BITS=64"]  # for files with large numbers
        _check_i386(command)
    name = f"libgz-{_fingerprint(command)}"
    folder = own_cache(name)
    if not ((folder / ARCHIVE).exists() and (folder / SHARED).exists()):
        try:
            own_cache(name, create=True)
            with tempfile.TemporaryDirectory(dir=folder) as temporary:
                _compile(command, Path(temporary))
                # Atomically, so that no program links an incomplete library.
                for file in (ARCHIVE, SHARED):
                    (Path(temporary) / file).replace(folder / file)
        except LibraryError:  # which is an OSError, too
            raise
        except OSError as error:
            raise LibraryError(f"the C library cannot be stored in {folder}: {error}; set XDG_CACHE_HOME") from None
    return folder


def _check_i386(command: list[str]) -> None:
    """Check that the compiler can make 32-bit programs."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "check.c")
        source.write_text("#include <stdlib.h>\nint main(void) { return 0; }\n")
        words = [*command, str(source), "-o", str(source.with_suffix(""))]
        if subprocess.run(words, capture_output=True, check=False).returncode != 0:
            raise LibraryError(
                f"{command[0]} cannot make 32-bit programs ({FOR_I386}) here: apt-get install gcc-multilib"
            )


def _fingerprint(command: list[str]) -> str:
    """A short hash of the sources and of the compiler's command."""
    digest = hashlib.sha256(" ".join(command).encode())
    for path in [*sorted(FOLDER.glob("*.[ch]")), FOLDER / "interfaces.def"]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _compile(command: list[str], folder: Path) -> None:
    sources = [str(FOLDER / name) for name in SOURCES]
    objects = [name.replace(".c", ".o") for name in SOURCES]
    archiver = shutil.which("ar")
    if archiver is None:
        raise LibraryError("`ar` is not installed; the C library needs it: apt-get install binutils")
    shared = [*command, "-shared", f"-Wl,-soname,{SHARED}", "-o", SHARED, *objects, "-lm"]
    for step in ([*command, "-c", *sources], [archiver, "rcs", ARCHIVE, *objects], shared):
        done = subprocess.run(step, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise LibraryError(f"the C library does not compile: {shlex.join(step)}\n{done.stderr.strip()}")
