"""Manifest: the files that were written below a folder, with their sums, so that they can be removed again."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from libgz.base.files import read_limited, write_whole

__all__ = ["Manifest"]


class Manifest:
    """A file with a line for each other one below a folder: its path, and the sum of what was written.

    Somebody else may have made the folder, or changed this file: it names what may be removed only as long as that is
    as it was written, and lies in the folder itself, not behind a link.

    Args:
        prefix: the folder.
        name: of the file, relative to it.
    """

    def __init__(self, prefix: Path, name: str | Path) -> None:
        self.prefix, self.file = prefix, prefix / name

    def write(self, paths: Iterable[str]) -> None:
        """List files as they are now; their paths are relative to the folder.

        Raises:
            OSError: one cannot be read, or this one not be written.
        """
        lines = [f"{_sum(self.prefix / path)} {path}\n" for path in paths]
        self.file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self.file, "".join(lines).encode(errors="surrogateescape"))

    def paths(self) -> list[str]:
        """Those of the files that are as they were written."""
        try:
            lines = read_limited(self.file).decode(errors="surrogateescape").splitlines()
        except OSError:
            return []
        found: dict[str, None] = {}
        for line in lines:
            sum_, _, path = line.partition(" ")
            with suppress(OSError):
                if self._is_inside(path) and _sum(self.prefix / path) == sum_:
                    found[path] = None
        return list(found)

    def remove(self, paths: Iterable[str]) -> None:
        """Remove files, what Python compiled of them, and the folders that are empty then.

        Raises:
            OSError: one cannot be removed.
        """
        files = [self.prefix / path for path in paths]
        for file in files:
            file.unlink(missing_ok=True)
        folders = {folder for file in files for folder in file.parents if folder.is_relative_to(self.prefix)}
        for source in (file for file in files if file.suffix == ".py"):
            cache = source.parent / "__pycache__"
            for compiled in () if cache.is_symlink() else cache.glob(f"{source.stem}.*.pyc"):
                compiled.unlink()
        for folder in sorted({*folders, *(folder / "__pycache__" for folder in folders)} - {self.prefix}, reverse=True):
            if folder.is_dir() and not folder.is_symlink() and not any(folder.iterdir()):
                folder.rmdir()

    def remove_all(self) -> list[Path]:
        """Remove the files that are as they were written, then this one, and the folder if it is empty; what is gone.

        Raises:
            OSError: one cannot be removed.
        """
        paths = self.paths()
        own = str(self.file.relative_to(self.prefix))
        self.remove([*paths, own])
        if self.prefix.is_dir() and not any(self.prefix.iterdir()):
            self.prefix.rmdir()
        return [self.prefix / path for path in (*paths, own)]

    def _is_inside(self, path: str) -> bool:
        """Whether a listed path is one of the folder itself, and none that leads elsewhere, such as by a link."""
        file = self.prefix / path
        try:
            folder = self.prefix.resolve() / file.relative_to(self.prefix).parent
            return ".." not in file.parts and file.parent.resolve() == folder
        except (OSError, RuntimeError, ValueError):  # also of names with NUL, and of links in a circle
            return False


def _sum(file: Path) -> str:
    """The SHA-256 of a file, or of where a link leads.

    Raises:
        OSError: it cannot be read, or is something else.
    """
    return hashlib.sha256(bytes(file.readlink()) if file.is_symlink() else read_limited(file)).hexdigest()
