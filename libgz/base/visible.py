"""Visible: texts of files and peers as terminals and logs can show them."""

from __future__ import annotations

__all__ = ["one_line", "visible"]

KEPT = "\n\t"


def visible(text: str) -> str:
    """A text whose control characters are escaped, so that it cannot command a terminal; lines stay apart."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in KEPT else c.encode("unicode_escape").decode() for c in text)


def one_line(text: str) -> str:
    """A visible text whose line breaks are escaped, too, so that no part of it looks like a message of its own."""
    return visible(text).replace("\n", "\\n")
