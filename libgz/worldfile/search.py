"""Where worlds are found by their names: the current directory, GAZEBOPATH, and the worlds of libgz."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from libgz.base.errors import WorldFileError, nearest
from libgz.base.files import exists, expand, installed_worlds, is_file

__all__ = ["ReadyWorld", "find_worldfile", "is_ready_world", "ready_worlds", "why_missing"]

log = logging.getLogger("libgz.worldfile")

SUFFIX = ".world"
SDF_WORLDS = Path(__file__).parent.parent / "sdf" / "worlds"
_COMMENT = re.compile(r"<!--\s*(.*?)\s*-->", re.DOTALL)


class ReadyWorld(NamedTuple):
    """A world that is installed with libgz."""

    path: Path

    @property
    def name(self) -> str:
        """Its name, by which it is found, without the ending of its file."""
        return self.path.stem

    @property
    def summary(self) -> str:
        """The comment at the head of its file, in one line."""
        found = _COMMENT.search(self.path.read_text(encoding="utf-8"))
        return " ".join(found[1].split()) if found is not None else ""


def _folders() -> tuple[Path, ...]:
    return installed_worlds(), SDF_WORLDS


def ready_worlds() -> list[ReadyWorld]:
    """The worlds that are installed with libgz, by name."""
    found = (ReadyWorld(path) for folder in _folders() for path in folder.glob(f"*{SUFFIX}"))
    return sorted(found, key=lambda world: world.name)


def is_ready_world(path: Path) -> bool:
    """Whether a path leads to the installed worlds, which belong to libgz and are not written to."""
    return path.parent in _folders()


def find_worldfile(name: str | os.PathLike[str]) -> Path:
    """The file of a world, by its path or name; the name may lack the ending ``.world``.

    A file in the current directory comes first, then one in a directory of GAZEBOPATH, then the world of libgz. What is
    found beside the path as given is logged. Absolute paths, and those that begin with ``./`` or ``../``, are not
    searched for. A file that does not exist is returned as given.

    Raises:
        WorldFileError: the name is empty, as where a variable of a script is not set.
    """
    text, given = os.fspath(name), Path(name)
    if not text.strip():
        raise WorldFileError("no worldfile is named: the name is empty")
    if given.is_absolute() or text.startswith(("./", "../")):
        return given
    ready = next(_among_ready(given), None)
    for why, place in _places(given):
        if is_file(place):
            if place != given:
                too = "" if ready is None or ready.samefile(place) else "; libgz has a world of this name, too"
                log.info("world %s is %s, %s%s", text, place, why, too)
            return place
    if ready is not None and not (exists(given) and not given.is_dir()):
        log.info("world %s is %s, of libgz", text, ready)
        return ready
    return given


def _places(given: Path) -> Iterator[tuple[str, Path]]:
    """(where, path) of the files that come before the worlds of libgz."""
    named = [expand(part) for part in os.environ.get("GAZEBOPATH", "").split(os.pathsep) if part]
    for why, folder in (("here", Path()), *(("in GAZEBOPATH", folder) for folder in named)):
        for path in _spellings(given):
            yield why, folder / path


def _among_ready(given: Path) -> Iterator[Path]:
    """Files of that name among the worlds of libgz: `ptz`, `ptz.world`, `worlds/ptz.world`."""
    inside = given.relative_to("worlds") if given.parts[:1] == ("worlds",) else given
    return (folder / path for folder in _folders() for path in _spellings(inside) if is_file(folder / path))


def _spellings(given: Path) -> Iterator[Path]:
    yield given
    if given.name and given.suffix != SUFFIX:
        yield given.with_name(given.name + SUFFIX)


def why_missing(name: str | os.PathLike[str]) -> str:
    """The end of a message about a world that was not found: where it was looked for, and the nearest name."""
    text = os.fspath(name)
    if Path(text).is_absolute() or text.startswith(("./", "../")):
        return ""
    names = [world.name for world in ready_worlds()]
    stem = Path(text).name.removesuffix(SUFFIX)
    return f" here, in GAZEBOPATH or among the worlds of libgz, which `libgz worlds` lists{nearest(stem, names)}"
