"""Parsing the text of SDF files: strictly, and else as leniently as Gazebo classic's parser did, with warnings."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from lxml import etree

from libgz.base.entities import Entities, check_attributes
from libgz.base.errors import Diagnostics, ParameterError, Place, WorldFileError
from libgz.base.files import xml_parser

__all__ = [
    "PLACE",
    "READABLE",
    "ROBOT",
    "ROOTS",
    "child_of",
    "copy_place",
    "document_text",
    "line_of",
    "local_name",
    "parse_document",
    "place_of",
    "set_place",
    "tag_name",
]

ROOTS = ("sdf", "gazebo")  # of documents; the second one until 1.2
ROBOT = "robot"  # of a robot description (URDF)
READABLE = (*ROOTS, ROBOT)
PLACE = "{urn:libgz}place"  # attribute of elements that were made of others: the line and file of those

_DECLARATION = re.compile(rb"<\?xml\s[^<>]*\?>")
_ENCODING = re.compile(rb"encoding\s*=\s*[\"']([\w.:-]+)")
_DECLARED, _NAME = re.compile(rb"<!ENTITY\s+([\w.:-]+)"), re.compile(rb"([\w.:-]+);")  # entities
# A comment, a CDATA section, or an ampersand that begins no reference. Those without an end reach up to that of the
# document: searching for it again and again would take quadratic time.
_SLIPS = re.compile(
    rb"<!--(.*?)(?:-->|\Z)|<!\[CDATA\[.*?(?:\]\]>|\Z)|&(?!(?:#\d+|#x[0-9a-fA-F]+|lt|gt|amp|quot|apos);)", re.DOTALL
)
# A comment, a CDATA section, or a start tag up to the last of its attributes; and such an attribute's value.
_TAGS = re.compile(
    rb"<!--.*?(?:-->|\Z)|<!\[CDATA\[.*?(?:\]\]>|\Z)"
    rb"|<[A-Za-z_][\w.:-]*(?P<attributes>(?:\s+[\w.:-]+\s*=\s*(?:\"[^\"]*\"|'[^']*'|[^\s\"'/>]*))+)",
    re.DOTALL,
)
_VALUE = re.compile(rb"(=\s*)(?:\"[^\"]*\"|'[^']*'|(?P<plain>[^\s\"'/>]*))")
# libxml2's names of what it recovers from without loss -> what is reported.
_TOLERATED = {
    "NS_ERR_UNDEFINED_NAMESPACE": "{message}; it is read without xmlns",
    "ERR_UNKNOWN_VERSION": "{message}; it is read as 1.0",
    "ERR_ATTRIBUTE_REDEFINED": "{message}; the first one counts",
    "ERR_DOCUMENT_END": "what follows the root element is ignored",
    "ERR_LT_IN_ATTRIBUTE": "'<' in the value of an attribute should be written &lt;",
    "ERR_INVALID_ENCODING": "there are bytes that are not of the document's encoding; they are replaced",
    "I18N_NO_INPUT": "there are bytes that are not of the document's encoding; they are replaced",
}

LAST_LINE = 65534  # that libxml2 keeps in an element that was not parsed; 65535 means that it is later
_PLACE = re.compile(r"(\d{1,9}) (.*)", re.DOTALL)

Report = Callable[[int, str], None]  # of a warning, with its line


def parse_document(data: bytes, label: str, diagnostics: Diagnostics) -> etree._Element:
    """The root element of a document, with the text of its own entities in their places.

    Args:
        data: the document's bytes.
        label: its name in messages.
        diagnostics: takes a warning for each thing that is not well-formed, and was passed by Gazebo classic's parser,
            and an error for each entity that is not text of the document.

    Raises:
        WorldFileError: it is not well-formed, and cannot be read all the same.
    """
    root = _parsed(data, label, diagnostics)
    check_attributes(root, label)
    _replace_entities(root, label, diagnostics)
    return root


def document_text(root: etree._Element) -> bytes:
    """A document that was made from others, without the places that its elements come from."""
    for element in root.iter(etree.Element):
        element.attrib.pop(PLACE, "")
    etree.cleanup_namespaces(root)
    etree.indent(root)
    return etree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _replace_entities(root: etree._Element, label: str, diagnostics: Diagnostics) -> None:
    entities = Entities(root)
    found: list[Any] = list(root.iter(etree.Entity))  # its stubs have elements only
    runs: list[tuple[Any, Any, list[str]]] = []  # parent, what stands before, texts of entities that follow each other
    for node in found:
        parent, before, text = node.getparent(), node.getprevious(), ""
        if parent is None:
            continue
        try:
            text = entities.text(str(node.name))
        except ParameterError as error:
            diagnostics.error(Place(label, line_of(parent), tag_name(parent)), str(error))
        if not runs or runs[-1][0] is not parent or runs[-1][1] is not before:
            runs.append((parent, before, []))
        runs[-1][2].extend((text, node.tail or ""))
        parent.remove(node)
    for parent, before, texts in runs:  # at once: each change of a text copies it
        if before is None:
            parent.text = "".join((parent.text or "", *texts))
        else:
            before.tail = "".join((before.tail or "", *texts))


def _parsed(data: bytes, label: str, diagnostics: Diagnostics) -> etree._Element:
    try:
        return etree.fromstring(data, xml_parser())
    except etree.XMLSyntaxError as error:
        refused = WorldFileError(f"{label}:{error.lineno or 1}: {str(error.msg).splitlines()[0]}")

    def report(line: int, message: str) -> None:
        found[Place(label, line, "xml"), message] = None

    found: dict[tuple[Place, str], None] = {}
    parser = xml_parser(recover=True)
    try:
        root = etree.fromstring(_repaired(data, report), parser)
    except etree.XMLSyntaxError:
        raise refused from None
    if root is None or any(entry.type_name not in _TOLERATED for entry in parser.error_log):
        raise refused
    prefixes = set()
    for entry in parser.error_log:
        prefix = entry.message.split(" ")[2] if entry.type_name == "NS_ERR_UNDEFINED_NAMESPACE" else None
        if prefix is None or prefix not in prefixes:
            prefixes.add(prefix)
            report(entry.line, _TOLERATED[entry.type_name].format(message=entry.message))
    for place, message in found:
        diagnostics.warn(place, message)
    return root


def _repaired(data: bytes, report: Report) -> bytes:
    """The document without what a strict parser stops at; lines keep their numbers."""
    declaration = _DECLARATION.search(data)
    if declaration is not None and data[: declaration.start()] not in (b"", b"\xef\xbb\xbf"):
        report(
            data.count(b"\n", 0, declaration.start()) + 1, "the XML declaration stands after the start of the document"
        )
        encoding = _ENCODING.search(declaration[0])
        blank = bytes(c if c == 10 else 32 for c in declaration[0])
        data = data[: declaration.start()] + blank + data[declaration.end() :]
        if encoding is not None and encoding[1].lower() not in (b"utf-8", b"us-ascii"):
            data = _decoded(data, encoding[1].decode()).encode()

    data = _quoted(data, report)
    declared, line = set(_DECLARED.findall(data)), _line_counter(data)

    def repair(match: re.Match[bytes]) -> bytes:
        name = _NAME.match(data, match.end()) if match[0] == b"&" else None
        if name is not None and name[1] in declared:
            return match[0]
        if match[0] == b"&":
            report(line(match.start()), "'&' should be written &amp;")
            return b"&amp;"
        inside = match[1]
        if inside is None or not match[0].endswith(b"-->") or (b"--" not in inside and not inside.endswith(b"-")):
            return match[0]
        report(line(match.start()), "'--' in a comment is not allowed in XML")
        return b"<!--" + inside.replace(b"-", b" ") + b"-->"

    return _SLIPS.sub(repair, data)


def _quoted(data: bytes, report: Report) -> bytes:
    """The document with quotes around all values of attributes."""
    line = _line_counter(data)

    def quote(tag: re.Match[bytes]) -> bytes:
        def value(match: re.Match[bytes]) -> bytes:
            if match["plain"] is None:
                return match[0]
            report(line(tag.start()), "the value of an attribute should stand in quotes")
            return match[1] + b'"' + match["plain"] + b'"'

        if tag["attributes"] is None:
            return tag[0]
        start = tag.start("attributes") - tag.start()
        return tag[0][:start] + _VALUE.sub(value, tag["attributes"])

    return _TAGS.sub(quote, data)


def _line_counter(data: bytes) -> Callable[[int], int]:
    """A function that returns the lines of places, of one after the other."""
    counted, lines = 0, 1

    def line(at: int) -> int:
        nonlocal counted, lines
        lines += data.count(b"\n", counted, at)
        counted = at
        return lines

    return line


def _decoded(data: bytes, encoding: str) -> str:
    try:
        return data.decode(encoding, "replace")
    except LookupError:
        return data.decode("utf-8", "replace")


def child_of(xml: etree._Element, name: str) -> etree._Element | None:
    """The first child of a name, whatever its namespace; None if there is none."""
    return next((child for child in xml if isinstance(child.tag, str) and local_name(child) == name), None)


def local_name(xml: etree._Element) -> str:
    """The tag without its namespace or prefix."""
    return str(xml.tag).rpartition("}")[2].rpartition(":")[2]


def tag_name(xml: etree._Element) -> str:
    """The tag as it is written, with its prefix; without that of the document's own namespace."""
    tag = str(xml.tag).rpartition("}")[2]
    return f"{xml.prefix}:{tag}" if xml.prefix else tag


def line_of(xml: etree._Element) -> int:
    """The line where an element starts, from 1; 0 if it has none."""
    return place_of(xml, "").line


def place_of(xml: etree._Element, label: str) -> Place:
    """The place of an element, or of the one that it was made of.

    Args:
        xml: the element.
        label: the document's name in messages, for what has no other file.
    """
    text = xml.get(PLACE)
    if text is not None and (given := _PLACE.fullmatch(text)) is not None:
        return Place(given[2] or label, int(given[1]), local_name(xml))
    line = xml.sourceline
    return Place(label, line if isinstance(line, int) else 0, local_name(xml))


def set_place(xml: etree._Element, line: int, file: str = "") -> None:
    """Give an element the place of what it was made of; without a file, one in the same document."""
    xml.set(PLACE, f"{line} {''.join(c if c.isprintable() else '?' for c in file)}")


def copy_place(xml: etree._Element, source: etree._Element) -> None:
    """Give an element the place of its source."""
    target: Any = xml  # its stubs do not know what sourceline is
    given, line = source.get(PLACE), line_of(source)
    if given is not None:
        xml.set(PLACE, given)
    elif line <= LAST_LINE:
        target.sourceline = line
    else:
        set_place(xml, line)
