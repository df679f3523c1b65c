"""Files that a robot description may read: those of its folder and package, and of the search paths."""

from __future__ import annotations

import fnmatch
import os
import re
from collections.abc import Iterator
from pathlib import Path

from lxml import etree

from libgz.base.errors import NotFoundError
from libgz.base.files import exists, is_file, read_limited, xml_parser
from libgz.sdf.paths import find_uri, model_directories, resource_directories
from libgz.sdf.xacro.limits import LONGEST_TEXT, Budget, ExpansionError

__all__ = ["Files", "UnreadableError", "package_of"]

MANIFESTS = ("package.xml", "manifest.xml", "model.config")  # of packages of ROS, old ones, and models
WILDCARD = re.compile(r"[*?[]")


class UnreadableError(ExpansionError):
    """A file does not exist, or must not be read."""


def package_of(path: Path) -> Path | None:
    """The folder of the package that a file or folder belongs to: the nearest one above with a manifest."""
    for folder in (path, *path.parents):
        if any(is_file(folder / name) for name in MANIFESTS):
            return folder
    return None


def _search_paths() -> list[Path]:
    """Those of models and resources, without the current directory."""
    try:
        here = Path.cwd()
        return [place for place in (*model_directories(), *resource_directories()) if place != here]
    except OSError:  # the current directory was deleted
        return model_directories()


def _name_of(package: Path) -> str:
    """The name that a package's manifest gives it; an empty string if it has none."""
    manifest = package / MANIFESTS[0]
    try:
        root = etree.fromstring(read_limited(manifest) if is_file(manifest) else b"", xml_parser())
    except (OSError, etree.XMLSyntaxError):
        return ""
    return (root.findtext("name") or "").strip()


class Files:
    """Finds and reads files below some folders, each of them a plain file.

    Links may lead out of a folder only from the search paths into a package, as in a workspace of links to sources.

    Args:
        folder: of the robot description; None for a text.
        budget: counts what is read.
    """

    def __init__(self, folder: Path | None, budget: Budget) -> None:
        self.folder = folder.absolute() if folder is not None else None
        self.budget = budget
        self._folders: list[Path] = []  # what may be read
        self._own = package_of(self.folder) if self.folder is not None else None
        for own in (self.folder, self.folder.resolve()) if self.folder is not None else ():
            self._folders += [package_of(own) or own, own]
        self._searched = _search_paths()

    def package(self, name: str) -> Path:
        """The folder of a package: that of the description, if its manifest has the name, or by `package://`.

        Raises:
            UnreadableError: it is not there.
        """
        if not name or "/" in name or name in (".", ".."):
            raise UnreadableError(f"{name!r} is not the name of a package")
        if self._own is not None and _name_of(self._own) == name:
            return self._own
        try:
            found = find_uri(f"package://{name}", self.folder).absolute()
        except NotFoundError as error:
            raise UnreadableError(str(error)) from None
        if package_of(found) == found and found not in self._folders:
            self._folders.append(found)
        return found

    def path(self, name: str, beside: Path | None) -> Path:
        """A file by its name, which may be relative to the folder of another one.

        Raises:
            UnreadableError: it is relative, and there is no folder.
        """
        if "\0" in name or len(name) > LONGEST_TEXT:
            raise UnreadableError(f"{name[:80]!r} is not the name of a file")
        if os.path.isabs(name):  # noqa: PTH117 - of a text
            return Path(name)
        if beside is None:
            raise UnreadableError(f"{name!r} is relative, and the description is a text without a folder")
        return beside / name

    def matching(self, pattern: Path) -> list[Path]:
        """The files that a name with wildcards stands for, sorted; the name itself, if it has none."""
        if not WILDCARD.search(str(pattern)):
            return [pattern]
        parts = pattern.parts
        first = next(i for i, part in enumerate(parts) if WILDCARD.search(part))
        start = Path(*parts[:first])
        self._check(start, str(pattern))
        return sorted(self._matching(start, parts[first:]))

    def _matching(self, folder: Path, parts: tuple[str, ...]) -> Iterator[Path]:
        part, *rest = parts
        if not WILDCARD.search(part):
            names = [part] if exists(folder / part) else []
        else:
            try:
                names = os.listdir(folder)  # noqa: PTH208 - names
            except OSError:
                return
            self.budget.spend(len(names) + 1)
            hidden = part.startswith(".")
            names = [name for name in fnmatch.filter(names, part) if hidden or not name.startswith(".")]
        for name in names:
            self.budget.spend(1)
            if rest:
                yield from self._matching(folder / name, tuple(rest))
            else:
                yield folder / name

    def read(self, path: Path, largest: int | None = None) -> bytes:
        """The bytes of a file.

        Raises:
            UnreadableError: it is not there, is no plain file, or is outside of what may be read.
            LimitError: it is too large, or too much was read.
        """
        self._check(path, str(path))
        try:
            if not path.is_file():
                raise UnreadableError(f"{path} {'is no plain file' if path.exists() else 'does not exist'}")
            size = path.stat().st_size
            self.budget.add_file(size)
            if largest is not None and size > largest:
                raise UnreadableError(f"{path} is larger than {largest >> 10} KiB")
            return read_limited(path)
        except OSError as error:
            raise UnreadableError(f"{path}: {error.strerror}") from None
        except ValueError as error:
            raise UnreadableError(f"{str(path)[:80]!r}: {error}") from None

    def _check(self, path: Path, name: str) -> None:
        try:
            real = path.resolve()
        except (OSError, RuntimeError, ValueError) as error:
            raise UnreadableError(f"{name[:200]}: {error}") from None
        plain = Path(os.path.normpath(path.absolute()))
        allowed = [*self._folders, *self._searched]
        if any(real.is_relative_to(folder) or real.is_relative_to(folder.resolve()) for folder in allowed):
            return
        linked = any(plain.is_relative_to(folder) for folder in self._searched)
        if linked and package_of(real.parent) is not None:
            return
        raise UnreadableError(
            f"{name[:200]} is outside of the description's folder, its package and the search paths: such files are "
            "not read; set ROS_PACKAGE_PATH"
        )
