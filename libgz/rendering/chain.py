"""Chain: the libraries behind an off-screen context, which of them are missing, and the packages that contain them."""

from __future__ import annotations

import ctypes
import os
import platform
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

__all__ = ["CHAINS", "Part", "advice"]

INSTALLERS = {"Debian, Ubuntu": "apt-get install", "Fedora": "dnf install", "Arch": "pacman -S"}
DRIVER_FOLDERS = (
    f"/usr/lib/{platform.machine()}-linux-gnu/dri",
    "/usr/lib64/dri",
    "/usr/lib/dri",
    "/usr/local/lib/dri",
    "/run/opengl-driver/lib/dri",
)
VENDOR_FOLDERS = ("/etc/glvnd/egl_vendor.d", "/usr/share/glvnd/egl_vendor.d")
_MISSING = re.compile(r"(\S+): cannot open shared object file")


@dataclass(eq=False, repr=False)
class Part:
    """A part of a chain: a file, and its packages in Debian and Ubuntu, Fedora, and Arch; "" where there is none."""

    name: str
    packages: tuple[str, str, str]

    def problem(self) -> str | None:
        """What is missing, or None."""
        return _loads(self.name)


class EglVendor(Part):
    """The file that connects libEGL with Mesa."""

    def problem(self) -> str | None:
        """What is missing, or None."""
        if "libGLdispatch" not in _loaded():
            return None  # this libEGL is Mesa's own
        if named := os.environ.get("__EGL_VENDOR_LIBRARY_FILENAMES"):
            return None if any(Path(name).exists() for name in named.split(":")) else named
        folders = os.environ.get("__EGL_VENDOR_LIBRARY_DIRS", "").split(":")
        found = [path for folder in (*filter(None, folders), *VENDOR_FOLDERS) for path in Path(folder).glob("*.json")]
        return None if found else self.name


class MesaDriver(Part):
    """The software renderer: a library of its own, or since Mesa 24.3 one that libEGL_mesa needs."""

    def problem(self) -> str | None:
        """What is missing, or None."""
        if "libgallium" in _loaded():
            return None
        folders = os.environ.get("LIBGL_DRIVERS_PATH", "").split(":")
        for folder in (*filter(None, folders), *DRIVER_FOLDERS):
            if (driver := Path(folder) / self.name).exists():
                return _loads(str(driver))
        return self.name


CHAINS: dict[str, tuple[Part, ...]] = {
    "osmesa": (Part("libOSMesa.so.8", ("libosmesa6", "mesa-compat-libOSMesa", "")),),
    "egl": (
        Part("libEGL.so.1", ("libegl1", "libglvnd-egl", "libglvnd")),
        EglVendor("egl_vendor.d/50_mesa.json", ("libegl-mesa0", "mesa-libEGL", "mesa")),
        Part("libEGL_mesa.so.0", ("libegl-mesa0", "mesa-libEGL", "mesa")),
        MesaDriver("swrast_dri.so", ("libgl1-mesa-dri", "mesa-dri-drivers", "mesa")),
    ),
}


def advice(backend: str) -> str:
    """What a backend of OpenGL lacks, and the commands that install it; for one that does not work."""
    problems = {part: problem for part in CHAINS[backend] if (problem := part.problem()) is not None}
    if not problems:
        return f"all libraries of {backend} are present"
    commands = "; ".join(_commands([part.packages for part in problems]))
    without = "; systems with Mesa 25.1 or later have EGL only" if backend == "osmesa" else ""
    return f"missing: {', '.join(problems.values())}; install with {commands}{without}"


def _commands(packages: list[tuple[str, str, str]]) -> Iterator[str]:
    for (system, installer), names in zip(INSTALLERS.items(), zip(*packages, strict=True), strict=True):
        if wanted := " ".join(filter(None, dict.fromkeys(names))):
            yield f"{installer} {wanted} ({system})"


def _loads(library: str) -> str | None:
    """Which library is missing when this one is loaded, or None."""
    try:
        ctypes.CDLL(library)
    except OSError as error:
        absent = _MISSING.match(str(error))
        if absent is None:
            return f"{library} ({error})"
        return library if absent[1] == library else f"{absent[1]}, which {library} needs"
    return None


def _loaded() -> str:
    """The files that this process has loaded."""
    return Path("/proc/self/maps").read_text(errors="replace")
