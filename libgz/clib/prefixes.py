"""Prefixes below which libgz was installed for the user: where old programs and their plugins lie."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from libgz.base.files import write_whole

__all__ = ["installed_prefixes", "note_prefix"]

ALWAYS = Path("/usr/local")  # where builds of old programs install by default
MOST = 20  # that are remembered


def _record() -> Path:
    """The file that has a prefix a line, the latest first."""
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "libgz" / "prefixes"


def _recorded() -> list[Path]:
    try:
        lines = _record().read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    except OSError:
        return []
    return [Path(line) for line in lines[:MOST] if line.startswith("/")]


def note_prefix(prefix: Path) -> None:
    """Remember a prefix, absolute, as the latest one; nothing if the user's folder cannot be written."""
    known = [prefix, *(other for other in _recorded() if other != prefix)][:MOST]
    text = "".join(f"{path}\n" for path in known)
    try:
        _record().parent.mkdir(parents=True, exist_ok=True)
        write_whole(_record(), text.encode("utf-8", "surrogateescape"))
    except OSError:
        return


def installed_prefixes() -> list[Path]:
    """Prefixes of `libgz config --install`, the latest first, the interpreter's own, and /usr/local; each once."""
    return list(dict.fromkeys([*_recorded(), Path(sys.prefix), ALWAYS]))
