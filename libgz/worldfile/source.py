"""The worldfile's own bytes: new values are spliced in, so that comments and layout survive saving."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from xml.parsers import expat
from xml.sax.saxutils import escape

from libgz.errors import WorldFileError

__all__ = ["Span", "attribute_spans", "element_spans", "splice"]

_ATTRIBUTE = re.compile(rb"""\s([^\s=]+)\s*=\s*("[^"]*"|'[^']*')""")
_WIDE = (b"\xff\xfe", b"\xfe\xff", b"\0<", b"<\0")  # how documents begin whose characters have two bytes or more


@dataclass
class Span:
    """Where an element stands: byte offsets of its tags and its content."""

    start: int
    content: int
    end: int = -1  # of the content
    after: int = -1  # of the closing tag
    empty: bool = False  # <tag/>


def element_spans(source: bytes) -> list[Span]:
    """The spans of all elements in document order.

    Raises:
        WorldFileError: the document's encoding has no bytes of ASCII to look for.
    """
    if source.startswith(_WIDE):
        raise WorldFileError("a worldfile in UTF-16 or UTF-32 can be read, but not changed; make it UTF-8")
    spans: list[Span] = []
    open_spans: list[Span] = []
    parser = expat.ParserCreate()

    def start(_name: str, _attributes: dict[str, str]) -> None:
        # A '>' may stand inside a quoted attribute value: skip those.
        index, quote = parser.CurrentByteIndex, 0
        while quote or source[index] != ord(">"):
            byte = source[index]
            if quote:
                quote = 0 if byte == quote else quote
            elif byte in b"\"'":
                quote = byte
            index += 1
        span = Span(parser.CurrentByteIndex, index + 1, empty=source[index - 1] == ord("/"))
        spans.append(span)
        open_spans.append(span)

    def end(_name: str) -> None:
        span = open_spans.pop()
        span.end = span.content if span.empty else parser.CurrentByteIndex
        span.after = span.content if span.empty else source.index(b">", span.end) + 1

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.Parse(source, True)
    return spans


def attribute_spans(source: bytes, span: Span) -> dict[bytes, tuple[int, int]]:
    """Name -> byte offsets of the value, without its quotes, of the attributes of an element."""
    found = _ATTRIBUTE.finditer(source, span.start, span.content)
    return {match[1]: (match.start(2) + 1, match.end(2) - 1) for match in found}


def splice(
    source: bytes,
    texts: Mapping[int, str],
    attributes: Mapping[tuple[int, str], str],
    children: Mapping[int, list[tuple[str, str]]],
    encoding: str,
) -> bytes:
    """New bytes with changed and added values.

    Args:
        source: the document.
        texts: number of an element in document order -> its new text.
        attributes: (number of an element, name of an attribute it has) -> the attribute's new value.
        children: number of an element -> (tag, text) of children to add at its beginning.
        encoding: of the document.

    Raises:
        WorldFileError: the document's encoding has no bytes of ASCII to look for.
    """
    spans = element_spans(source)
    edits: list[tuple[int, int, bytes]] = []
    for (number, name), value in attributes.items():
        place = attribute_spans(source, spans[number])[name.encode(encoding)]
        edits.append((*place, escape(value, {'"': "&quot;", "'": "&apos;"}).encode(encoding)))
    for number, text in texts.items():
        span = spans[number]
        new = escape(text).encode(encoding)
        if span.empty:
            tag = source[span.start + 1 : span.content].split(None, 1)[0].rstrip(b"/>")
            edits.append((span.content - 2, span.content, b">" + new + b"</" + tag + b">"))
        else:
            edits.append((span.content, span.end, new))
    for number, added in children.items():
        span = spans[number]
        indent = _indent(source, span)
        lines = "".join(f"{indent}<{tag}>{escape(text)}</{tag}>" for tag, text in added).encode(encoding)
        if span.empty:
            tag = source[span.start + 1 : span.content].split(None, 1)[0].rstrip(b"/>")
            edits.append((span.content - 2, span.content, b">" + lines + b"</" + tag + b">"))
        else:
            edits.append((span.content, span.content, lines))
    for first, last, new in sorted(edits, reverse=True):
        source = source[:first] + new + source[last:]
    return source


def _indent(source: bytes, span: Span) -> str:
    """The blanks that set off the first thing inside an element."""
    inside = source[span.content : span.end]
    blanks = inside[: len(inside) - len(inside.lstrip())]
    return blanks.decode("ascii", "replace") if blanks.strip(b" \t\r\n") == b"" else ""
