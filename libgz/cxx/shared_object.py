"""SharedObject: a plugin's file in this process, until nothing uses it."""

from __future__ import annotations

import _ctypes
import ctypes
import os
import platform
import re
import shutil
import struct
import tempfile
import weakref
from pathlib import Path
from typing import Any

import numpy as np

from libgz.base.errors import PluginError
from libgz.base.files import read_limited

__all__ = ["SharedObject"]

UNDEFINED = re.compile(r"undefined symbol: (\w+)")
RENDERING = re.compile(r"gl[A-Z]\w*|glu\w+|glut\w+|X[A-Z]\w+")  # functions of OpenGL and X, which models never call
FOLDER = "libgz-plugin-"  # beginning of the names of folders with copies, before the number of their process
ELF = b"\x7fELF"
ELF64 = b"\x7fELF\x02\x01"
HEADER = 20  # bytes: class and order of bytes from 4 on, and the processor at MACHINE
MACHINE = slice(18, 20)
PROCESSORS = {3: "x86", 20: "PowerPC", 21: "PowerPC", 40: "arm", 62: "x86-64", 183: "aarch64", 243: "RISC-V"}
DYNAMIC_SYMBOLS = 11  # SHT_DYNSYM
SYMBOL = 24  # bytes of an entry there; the fifth one has binding and type
WEAK, UNIQUE = 2, 10  # bindings


class SharedObject:
    """A plugin's file, loaded from a copy: the file can be built again meanwhile, and each version is loaded anew.

    Args:
        path: the file.

    Attributes:
        library: its functions.
        renders_with: a function of OpenGL that nothing defines, or None; it must not be called.

    Raises:
        PluginError: it cannot be loaded.
    """

    def __init__(self, path: Path) -> None:
        data = bytearray(read_limited(path))
        _check_processor(data, path)
        try:
            _make_its_own(data)
        except (struct.error, ValueError, OverflowError):  # its tables lie beyond its end, or have an odd size
            raise PluginError(f"error loading plugin: {path}: the file is truncated; build it again") from None
        _remove_stale()
        folder = Path(tempfile.mkdtemp(prefix=f"{FOLDER}{os.getpid()}-"))
        remove = weakref.finalize(self, _remove, folder, os.getpid())
        copy = folder / path.name
        self.renders_with: str | None = None
        if b"$ORIGIN" in data:  # it has libraries beside it
            for beside in path.parent.glob("*.so*"):
                (folder / beside.name).symlink_to(beside.resolve())
            copy.unlink(missing_ok=True)
        copy.write_bytes(data)
        self.library = self._open(copy, path)
        if b".debug_info" not in data:  # gdb needs the file
            remove()
        weakref.finalize(self, _ctypes.dlclose, self.library._handle).atexit = False

    def _open(self, copy: Path, path: Path) -> Any:
        try:
            return ctypes.CDLL(str(copy), mode=os.RTLD_NOW | os.RTLD_LOCAL)
        except OSError as error:
            missing = UNDEFINED.search(str(error))
            if missing is not None and RENDERING.fullmatch(missing[1]):
                self.renders_with = missing[1]
                return ctypes.CDLL(str(copy), mode=os.RTLD_LAZY | os.RTLD_LOCAL)
            reason = str(error).replace(f"{copy}: ", "")
            if missing is not None:
                reason = f"nothing defines {missing[1]}; link the file or library that does"
            raise PluginError(f"error loading plugin: {path}: {reason}") from None


def _check_processor(data: bytes | bytearray, path: Path) -> None:
    """Check that a file is for the processor that runs this process: the loader says of others that they are not there.

    Raises:
        PluginError: it is for another one.
    """
    with Path("/proc/self/exe").open("rb") as program:
        here = program.read(HEADER)
    if not data.startswith(ELF) or len(data) < HEADER or data[4:6] + data[MACHINE] == here[4:6] + here[MACHINE]:
        return
    (machine,) = struct.unpack_from("<H" if data[5] == 1 else ">H", data, MACHINE.start)
    built_for = f"{PROCESSORS.get(machine, f'processor {machine} of ELF')} ({32 if data[4] == 1 else 64} bits)"
    raise PluginError(
        f"error loading plugin: {path} was built for {built_for}, and this is {platform.machine()}; build it again here"
    )


def _remove_stale() -> None:
    """Remove what this user's processes that crashed have left; a file that is in use stays in memory."""
    for folder in Path(tempfile.gettempdir()).glob(f"{FOLDER}*"):
        process = folder.name.removeprefix(FOLDER).partition("-")[0]
        if process.isdigit() and not Path("/proc", process).exists() and _is_own(folder):
            shutil.rmtree(folder, ignore_errors=True)


def _is_own(folder: Path) -> bool:
    """Whether a folder is this user's: in those of others, depth and size are whatever they want."""
    try:
        return folder.lstat().st_uid == os.geteuid()
    except OSError:  # its process has just removed it
        return False


def _remove(folder: Path, process: int) -> None:
    if process == os.getpid():  # not one that was forked
        shutil.rmtree(folder, ignore_errors=True)


def _make_its_own(data: bytearray) -> None:
    """Let each loaded file have its own symbols: static variables of inline functions are else those of the process.

    GCC marks them as unique in a process. Two plugins with a class of one name, or two versions of one plugin, would
    share them, and neither could be unloaded.
    """
    if not data.startswith(ELF64):
        return
    (sections,) = struct.unpack_from("<Q", data, 0x28)
    size, count = struct.unpack_from("<HH", data, 0x3A)
    for i in range(count):
        start = sections + i * size
        (kind,) = struct.unpack_from("<I", data, start + 4)
        place, length = struct.unpack_from("<QQ", data, start + 0x18)
        if kind == DYNAMIC_SYMBOLS:
            info = np.frombuffer(data, np.uint8, length, place).reshape(-1, SYMBOL)[:, 4]
            unique = info >> 4 == UNIQUE
            info[unique] = WEAK << 4 | info[unique] & 15
