"""The bytes of a worldfile: new values are spliced in, so that saving keeps comments and layout."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias
from xml.parsers import expat

from libgz.base.errors import WorldFileError
from libgz.base.files import xml_attribute, xml_text

__all__ = [
    "Edit",
    "Span",
    "apply_edits",
    "attribute_spans",
    "element_spans",
    "fill",
    "indent_of",
    "put_first",
    "splice",
    "tag_of",
]

Edit: TypeAlias = tuple[int, int, bytes]  # start and end of what is replaced, new bytes

_ATTRIBUTE = re.compile(rb"""\s([^\s=]+)\s*=\s*("[^"]*"|'[^']*')""")
_TAG = re.compile(rb"<([^\s/>]+)")
_WIDE = (b"\xff\xfe", b"\xfe\xff", b"\0<", b"<\0")  # first bytes of UTF-16 and UTF-32


@dataclass
class Span:
    """The place of an element: byte offsets of its tags and its content."""

    start: int
    content: int
    end: int = -1  # of the content
    after: int = -1  # of the closing tag
    empty: bool = False  # <tag/>


def element_spans(source: bytes) -> list[Span]:
    """The spans of all elements in document order.

    Raises:
        WorldFileError: the document is in UTF-16 or UTF-32.
    """
    if source.startswith(_WIDE):
        raise WorldFileError("a worldfile in UTF-16 or UTF-32 can be read, but not changed; make it UTF-8")
    spans: list[Span] = []
    open_spans: list[Span] = []
    parser = expat.ParserCreate()

    def start(_name: str, _attributes: dict[str, str]) -> None:
        # A quoted attribute value may contain '>': skip those.
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


def tag_of(source: bytes, span: Span) -> bytes:
    """The tag of an element, with its prefix."""
    match = _TAG.match(source, span.start)
    return match[1] if match else b""


def fill(source: bytes, span: Span, content: bytes, tag: bytes = b"") -> Edit:
    """The edit that replaces the content of an element; `<tag/>` becomes `<tag>...</tag>`.

    Args:
        source: the document.
        span: of the element.
        content: what replaces its content.
        tag: the element's tag after all edits; empty if it stays.
    """
    if span.empty:
        return span.content - 2, span.content, b">" + content + b"</" + (tag or tag_of(source, span)) + b">"
    return span.content, span.end, content


def put_first(source: bytes, span: Span, content: bytes) -> Edit:
    """The edit that puts something at the beginning of an element's content."""
    return fill(source, span, content) if span.empty else (span.content, span.content, content)


def indent_of(source: bytes, span: Span) -> bytes:
    """The blanks in front of the first thing inside an element."""
    inside = source[span.content : span.end]
    return inside[: len(inside) - len(inside.lstrip())]


def apply_edits(source: bytes, edits: Sequence[Edit]) -> bytes:
    """The document after edits, which are in order of their starts and do not overlap."""
    for start, end, new in reversed(edits):
        source = source[:start] + new + source[end:]
    return source


def splice(
    source: bytes,
    texts: Mapping[int, str],
    attributes: Mapping[tuple[int, str], str],
    children: Mapping[int, list[tuple[str, str]]],
    encoding: str,
    *,
    removed: Collection[int] = (),
    appended: Sequence[bytes] = (),
    only: int = 0,
) -> bytes:
    """The document with changed and added values, or one element of it.

    Args:
        source: the document.
        texts: number of an element in document order -> its new text.
        attributes: (number of an element, name of an attribute it has) -> the attribute's new value.
        children: number of an element -> (tag, text) of children to add at its beginning.
        encoding: of the document.
        removed: numbers of elements that are left out.
        appended: elements to add at the end of the root, encoded.
        only: the number of the element; 0 is the root, and stands for the whole document.

    Raises:
        WorldFileError: the document is in UTF-16 or UTF-32.
    """
    spans = element_spans(source)
    edits: list[Edit] = []
    for (number, name), value in attributes.items():
        place = attribute_spans(source, spans[number])[name.encode(encoding)]
        edits.append((*place, xml_attribute(value).encode(encoding)))
    for number, text in texts.items():
        edits.append(fill(source, spans[number], xml_text(text).encode(encoding)))
    for number, added in children.items():
        indent = indent_of(source, spans[number])
        lines = b"".join(indent + f"<{tag}>{xml_text(text)}</{tag}>".encode(encoding) for tag, text in added)
        edits.append(put_first(source, spans[number], lines))
    gone = [(_line_start(source, spans[number]), spans[number].after) for number in removed]
    edits = [edit for edit in edits if not any(begin <= edit[0] < end for begin, end in gone)]
    edits += [
        (begin, end, b"")
        for begin, end in gone
        if not any(other < begin and end < after for other, after in gone)  # it goes with what it is in
    ]
    if appended:
        edits.append(_append(source, spans[0], appended))
    begin, end = (spans[only].start, spans[only].after) if only else (0, len(source))
    kept = [(first - begin, last - begin, new) for first, last, new in edits if begin <= first and last <= end]
    return apply_edits(source[begin:end], sorted(kept))


def _line_start(source: bytes, span: Span) -> int:
    """Where an element begins, with the blanks in front of it and the line break."""
    return len(source[: span.start].rstrip(b" \t\r\n"))


def _append(source: bytes, root: Span, elements: Sequence[bytes]) -> Edit:
    """The edit that adds elements at the end of the root, each on a line of its own."""
    indent = indent_of(source, root) or b"\n"
    added = b"".join(indent + _moved_in(element, indent.rpartition(b"\n")[2]) for element in elements)
    if root.empty:
        return fill(source, root, added + b"\n")
    last = root.content + len(source[root.content : root.end].rstrip())
    return last, last, added if last < root.end else added + b"\n"


def _moved_in(element: bytes, margin: bytes) -> bytes:
    """An element whose lines begin as those around it do; as it is if a line is in a text, such as a program."""
    first, *others = element.split(b"\n")
    lines = [line for line in others if line.strip()]
    own = lines[-1][: len(lines[-1]) - len(lines[-1].lstrip())] if lines else b""
    if b"<![CDATA[" in element or not all(line.startswith(own) and line.lstrip()[:1] == b"<" for line in lines):
        return element
    return b"\n".join([first, *(margin + line.removeprefix(own) if line.strip() else line for line in others)])
