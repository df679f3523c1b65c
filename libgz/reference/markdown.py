"""Markdown that the reference pages have in common."""

from __future__ import annotations

__all__ = ["NOTE", "cell"]

NOTE = "<!-- Made by scripts/make_docs.py; do not edit. -->\n"


def cell(text: str) -> str:
    """A text in a cell of a table; tags outside code are no markup."""
    parts = " ".join(text.split()).replace("|", "\\|").split("`")
    return "`".join(part if i % 2 else part.replace("<", "&lt;") for i, part in enumerate(parts))
