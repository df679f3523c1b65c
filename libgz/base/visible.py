"""Visible: texts of files and peers as terminals and logs can show them."""

from __future__ import annotations

import re

__all__ = ["one_line", "visible", "visible_xml"]

# Controls other than tabs and line breaks, separators of lines, changes of the direction of writing, and surrogates.
# Not all that Python calls unprintable: texts of many languages have joiners and wide spaces.
_COMMANDS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def visible(text: str) -> str:
    """A text whose control characters are escaped, so that it cannot command a terminal; lines stay apart."""
    return _COMMANDS.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def one_line(text: str) -> str:
    """A visible text whose line breaks are escaped, too, so that no part of it looks like a message of its own."""
    return visible(text).replace("\n", "\\n")


def visible_xml(text: str) -> str:
    """A document whose control characters are references, so that it says the same and cannot command a terminal.

    Its lines end as a parser reads them: a reference to a carriage return is a character of its own.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n")
    return _COMMANDS.sub(lambda found: f"&#{ord(found[0])};", lines)
