"""QtSources: what plugins with widgets of Qt need of the compiler, and what Qt's moc makes of their classes."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

from libgz.base.errors import LibraryError
from libgz.classic_cxx.library import QT, package_flags

__all__ = ["QtSources"]

_QT = re.compile(r"^\s*#\s*include\s*[<\"](gazebo/gui/|Q[A-Z]|Qt)", re.MULTILINE)
_OBJECT = re.compile(r"^\s*Q_OBJECT\b", re.MULTILINE)
_INCLUDE = re.compile(r"^\s*#\s*include\s*[<\"]([^>\"]+)[>\"]", re.MULTILINE)
MISSING = "plugins with widgets need a package that is missing: apt-get install qtbase5-dev"


class QtSources:
    """The sources of a plugin with the headers of its own, as far as Qt is concerned.

    Args:
        sources: C++ files.
        options: of the compiler; headers are looked for in the folders that they name.

    Raises:
        LibraryError: a class needs Qt's moc, and Qt is missing.
    """

    def __init__(self, sources: Sequence[Path], options: Sequence[str]) -> None:
        self._folders = [Path(word[2:]) for word in options if word.startswith("-I") and len(word) > 2]
        self._folders += [Path(word.removeprefix("-idirafter")) for word in options if word.startswith("-idirafter")]
        self._sources = [path for path in sources if path.is_file()]
        self._texts: dict[Path, str] = {}
        self._known: set[Path] = set()  # the files that were read, once links are followed
        for path in self._sources:
            self._read(path)
        self._include = package_flags("--cflags-only-I", QT) if any(map(_QT.search, self._texts.values())) else []
        self._objects = [path for path, text in self._texts.items() if _OBJECT.search(text)]
        if self._objects and not self._include:
            raise LibraryError(MISSING)

    def _read(self, path: Path) -> None:
        """Read a file, and those that it includes of the plugin's own."""
        self._known.add(path.resolve())
        self._texts[path] = text = path.read_text(errors="replace")
        for name in _INCLUDE.findall(text):
            found = next((folder / name for folder in (path.parent, *self._folders) if (folder / name).is_file()), None)
            if found is not None and found.resolve() not in self._known:
                self._read(found)

    def flags(self, folder: str) -> list[str]:
        """The compiler's options; `folder` is where `make` has made files."""
        return [f"-I{folder}", *self._include] if self._include else []

    def libraries(self) -> list[str]:
        """The linker's options."""
        return package_flags("--libs", QT) if self._include else []

    def make(self, folder: Path) -> list[str]:
        """Have moc make files of all classes that need it, in a folder; those that must be compiled, too.

        Raises:
            LibraryError: moc fails, or two files include what it makes by one name.
        """
        included = {Path(name).name for text in self._texts.values() for name in _INCLUDE.findall(text)}
        made: list[str] = []
        named: dict[str, Path] = {}
        for number, path in enumerate(self._objects):
            header = path not in self._sources
            name = f"moc_{path.stem}.cpp" if header else f"{path.stem}.moc"
            if header and name not in included:
                name = f"moc_{number}_{path.stem}.cpp"  # headers of several folders may have one name
                made.append(str(folder / name))
            elif named.setdefault(name, path) is not path:
                raise LibraryError(f"{named[name]} and {path} both need a file {name} of Qt's moc; rename one of them")
            moc = Path(package_flags("--variable=host_bins", ("Qt5Core",))[0], "moc")
            given = [*self._include, *(f"-I{one}" for one in self._folders)]
            words = [str(moc), *given, str(path.absolute()), "-o", str(folder / name)]
            done = subprocess.run(words, capture_output=True, text=True, errors="replace", check=False)
            if done.returncode != 0:
                raise LibraryError(f"Qt's moc failed: {done.stderr.strip()}")
        return made
