"""libgz doctor: check what libgz needs on this machine."""

from __future__ import annotations

import argparse
import dataclasses
import importlib.metadata
import json
import os
import platform
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from libgz._version import __version__
from libgz.apps.console import say
from libgz.base.errors import GazeboError
from libgz.base.extras import install
from libgz.ode.lib import ode
from libgz.ode.step import library_path
from libgz.rendering.context import CONTEXTS
from libgz.transport.semaphores import SemaphoreSet

__all__ = ["Finding", "configure", "examine", "run"]

PACKAGES = ("numpy", "lxml", "pillow", "PyYAML")


@dataclass(frozen=True)
class Extra:
    """An optional extra of the package: what it provides, and what works without it."""

    packages: tuple[str, ...]
    gives: str
    without: str


EXTRAS = {
    "lsp": Extra(
        ("pygls",),
        "errors, completion and meanings in text editors",
        "libgz check and libgz sdf --check report the same errors",
    ),
    "mesh": Extra(
        ("trimesh",),
        "meshes and skins of more formats",
        "STL, OBJ and COLLADA meshes of SDF and 3DS skins work",
    ),
    "video": Extra(("imageio", "av"), "videos by --record", "cameras, and saving their images as files, work"),
    "plot": Extra(("matplotlib",), "plots by libgz plot", "libgz echo and libgz export print the same figures"),
    "log": Extra(
        ("mcap", "foxglove-schemas-protobuf"),
        "logs by --mcap, libgz play and libgz export",
        "worlds run, and gzserver -r records state.log",
    ),
    "view": Extra(("aiohttp",), "running worlds in a browser", "everything else works"),
    "notebook": Extra(
        ("aiohttp", "anywidget"),
        "world.view() over the channel of a notebook",
        "with the extra view it opens a port of its own",
    ),
    "gym": Extra(("gymnasium", "aiohttp"), "environments of Gymnasium", "everything else works"),
    "cluster": Extra(
        ("distributed", "pyarrow"), "sweeps on clusters, and as Parquet", "libgz sweep runs here, and writes CSV"
    ),
}


@dataclass(frozen=True)
class Finding:
    """The result of one check."""

    name: str
    text: str
    good: bool = True
    needed: bool = True  # whether worlds need it

    def __str__(self) -> str:
        mark = "ok" if self.good else "MISSING" if self.needed else "absent"
        return f"{mark:8}{self.name:14}{self.text}"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--json", action="store_true", help="print a JSON array: name, text, good, needed")


def run(options: argparse.Namespace) -> int:
    """Print all findings; return 1 if something that worlds need is missing."""
    findings = list(examine())
    if options.json:
        say(json.dumps([dataclasses.asdict(finding) for finding in findings], indent=2))
    else:
        for finding in findings:
            say(finding)
    return 0 if all(f.good for f in findings if f.needed) else 1


def examine() -> Iterator[Finding]:
    """Run all checks."""
    yield Finding("libgz", __version__)
    yield Finding("python", f"{platform.python_version()} on {platform.system()} {platform.machine()}")
    for package in PACKAGES:
        version = _version(package)
        yield Finding(package, version or f"not installed; pip install {package}", good=version is not None)
    for name, extra in EXTRAS.items():
        yield _extra(name, extra)
    yield _try("ode", lambda: f"{ode().path}, {ode().origin}: {ode().configuration}")
    yield _try("step", lambda: str(library_path()))
    yield _try("semaphores", _semaphores)
    yield _try("directory", _directory)
    yield from _contexts()


def _version(package: str) -> str | None:
    """The version of an installed package, or None."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _extra(name: str, extra: Extra) -> Finding:
    """Whether all packages of an extra are installed, and what is unavailable without them."""
    versions = {package: _version(package) for package in extra.packages}
    absent = [package for package, version in versions.items() if version is None]
    if absent:
        text = f"no {extra.gives} without {' and '.join(absent)}; {extra.without}; {install(name)}"
        return Finding(name, text, good=False, needed=False)
    return Finding(name, f"{extra.gives}: " + ", ".join(f"{package} {v}" for package, v in versions.items()))


def _try(name: str, look: Callable[[], str]) -> Finding:
    try:
        return Finding(name, look())
    except (GazeboError, OSError) as error:
        return Finding(name, str(error), good=False)


def _semaphores() -> str:
    """Whether semaphore sets can be created."""
    probe = 900_000_000 + os.getpid() % 1_000_000
    semaphores = SemaphoreSet.create(probe)
    semaphores.post()
    semaphores.remove()
    return "System V semaphores work"


def _directory() -> str:
    """Whether a server's directory can be created."""
    place = os.environ.get("TMP", "/tmp")  # the default of libgazebo
    with tempfile.TemporaryDirectory(dir=place):
        return f"servers keep their files in {place}"


def _contexts() -> Iterator[Finding]:
    """The off-screen OpenGL contexts, each with the reason if it does not work; worlds with cameras need one."""
    for name, kind in CONTEXTS.items():
        try:
            context = kind()
        except GazeboError as error:
            yield Finding(name, str(error), good=False, needed=False)
            continue
        yield Finding(name, f"renders: {context.description}")
        context.close()
