"""SdfText: the text of an SDF file with values changed in it; comments, order and layout stay."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.parsers import expat

from lxml import etree

from libgz.base.errors import ParameterError, WorldFileError
from libgz.base.files import xml_attribute, xml_parser, xml_text
from libgz.sdf.element import Element
from libgz.sdf.frames import MODEL
from libgz.sdf.xml import line_of, local_name
from libgz.worldfile.source import (
    Edit,
    Span,
    apply_edits,
    attribute_spans,
    element_spans,
    fill,
    indent_of,
    put_first,
    tag_of,
)

__all__ = ["SdfText", "Step"]

Step = tuple[str, str]  # tag, and the attribute `name`; empty for any


class SdfText:
    """The text of a document, and its elements.

    Args:
        source: the text.
        label: its name in messages.

    Raises:
        WorldFileError: it is not well-formed, or in UTF-16 or UTF-32.
    """

    def __init__(self, source: bytes, label: str) -> None:
        self.source, self.label = source, label
        parser = xml_parser(recover=True)  # prefixes need no xmlns, as in Gazebo
        try:
            self.root = etree.fromstring(source, parser)
            slips = [
                (entry.line, entry.message)
                for entry in parser.error_log
                if entry.level > etree.ErrorLevels.WARNING and entry.type_name != "NS_ERR_UNDEFINED_NAMESPACE"
            ]
            self._spans = [] if slips else element_spans(source)
        except etree.XMLSyntaxError as error:
            slips = [(error.lineno, error.msg)]
        except expat.ExpatError as error:
            slips = [(error.lineno, str(error))]
        if slips:
            line, message = slips[0]
            raise WorldFileError(f"{label}:{line or 1}: {message}; a file with this cannot be edited")
        self.elements = [element for element in self.root.iter() if isinstance(element.tag, str)]
        self._numbers = {element: number for number, element in enumerate(self.elements)}

    @property
    def holder(self) -> etree._Element:
        """The element that holds the models: the first `<world>`, or the root."""
        return next(children(self.root, "world"), self.root)

    def indent_in(self, element: etree._Element | None = None) -> str:
        """The blanks in front of what is in an element; by default in the world."""
        span = self._span(self.holder if element is None else element)
        return (indent_of(self.source, span) or b"\n  ").decode(errors="replace").rpartition("\n")[2]

    def find(self, path: Sequence[Step], start: etree._Element | None = None) -> etree._Element | None:
        """The first element at the end of a path; None if there is none."""
        found: etree._Element | None = self.holder if start is None else start
        for tag, name in path:
            if found is not None:
                found = next((one for one in children(found, tag) if not name or one.get("name") == name), None)
        return found

    def include(self, built: Element, holder: etree._Element | None = None) -> etree._Element | None:
        """The `<include>` in a world or model that an element was read of; None if that is not clear.

        Args:
            built: the included model, light or actor.
            holder: the world's element by default.
        """
        found = list(children(self.holder if holder is None else holder, "include"))
        place = built.include
        if place is None or place.file != self.label:
            return None
        there, name = [one for one in found if line_of(one) == place.line], built.Get(str, "name")
        named = [one for one in there if _name_of(one) == name]
        if named or len(there) == 1:
            return (named or there)[0]
        # Several in one line, which give no names: most models are called as their folders.
        called = [one for one in there if not _name_of(one) and _folder_of(one) == name]
        return called[0] if len(called) == 1 else None

    # Each of these returns a change, or several, for `changed`.

    def value(self, start: etree._Element, steps: Sequence[str], text: str) -> Edit:
        """The change of a value of an element below `start`; what is missing on the way is added.

        Args:
            start: an element.
            steps: tags, such as ``inertial``, ``mass``; the last one may be an attribute, such as ``@type``.
            text: the value.

        Raises:
            ParameterError: there are elements in the place of the value.
        """
        element, left = start, list(steps)
        while left and not left[0].startswith("@"):
            below = next(children(element, left[0]), None)
            if below is None:
                break
            element = below
            del left[0]
        if left and left[0].startswith("@"):
            return self._attribute(element, left[0][1:], text)
        span = self._span(element)
        if not left:
            if any(isinstance(child.tag, str) for child in element):
                raise ParameterError(f"{self.label}:{element.sourceline}: <{local_name(element)}> holds elements")
            return fill(self.source, span, _encoded(xml_text(text)))
        inner = xml_text(text)
        if left[-1].startswith("@"):
            inner = f"<{left[-2]} {left[-1][1:]}='{xml_attribute(text)}'/>"
            del left[-2:]
        for tag in reversed(left):
            inner = f"<{tag}>{inner}</{tag}>"
        return put_first(self.source, span, indent_of(self.source, span) + _encoded(inner))

    def pose(self, element: etree._Element, text: str, placed: bool) -> list[Edit]:
        """The changes of the pose of an element in the frame around it, in radians.

        Args:
            element: a model, light, actor or include.
            text: the pose of its own frame.
            placed: whether its pose was that of a frame in it.
        """
        old = next(children(element, "pose"), None)
        changes = list(self._own_frame(element)) if placed else []
        if old is None or not old.attrib:
            return [self.value(element, ["pose"], text), *changes]
        span = self._span(old)
        return [(span.start, span.after, f"<pose>{text}</pose>".encode()), *changes]

    def _own_frame(self, element: etree._Element) -> Iterator[Edit]:
        """The changes that let a pose be that of the model's own frame."""
        if local_name(element) != "include":
            yield self._attribute(element, "placement_frame", MODEL)
            return
        given, span = list(children(element, "placement_frame")), self._span(element)
        for one in given:
            yield fill(self.source, self._span(one), _encoded(MODEL))
        if not given:
            added = _encoded(f"<placement_frame>{MODEL}</placement_frame>")
            yield put_first(self.source, span, indent_of(self.source, span) + added)

    def removal(self, element: etree._Element) -> Edit:
        """The removal of an element, with the blanks in front of it."""
        span = self._span(element)
        return len(self.source[: span.start].rstrip(b" \t\r\n")), span.after, b""

    def exchange(self, element: etree._Element, built: Element) -> Edit:
        """The exchange of an element for another one."""
        around, span = element.getparent(), self._span(element)
        return span.start, span.after, _encoded(built.ToString(self.indent_in(around)).strip())

    def addition(self, elements: Sequence[str]) -> Edit:
        """The addition of elements at the end of the world."""
        span = self._span(self.holder)
        indent = indent_of(self.source, span) or b"\n  "
        added = b"".join(indent + _encoded(one.strip()) for one in elements)
        if span.empty:
            return fill(self.source, span, added + b"\n")
        last = span.content + len(self.source[span.content : span.end].rstrip())
        return last, last, added if last < span.end else added + b"\n"

    def changed(self, *edits: Edit) -> bytes:
        """The text after changes, which do not overlap."""
        return apply_edits(self.source, sorted(edits))

    def _span(self, element: etree._Element) -> Span:
        return self._spans[self._numbers[element]]

    def _attribute(self, element: etree._Element, key: str, text: str) -> Edit:
        span = self._span(element)
        given = attribute_spans(self.source, span).get(key.encode())
        if given is not None:
            return (*given, _encoded(xml_attribute(text)))
        after = span.start + 1 + len(tag_of(self.source, span))
        return after, after, _encoded(f" {key}='{xml_attribute(text)}'")


def _encoded(text: str) -> bytes:
    """A text in any encoding that begins with ASCII."""
    return text.encode("ascii", "xmlcharrefreplace")


def _name_of(include: etree._Element) -> str:
    """The name that an include gives to what it includes; empty if it gives none."""
    given = next(children(include, "name"), None)
    return (given.text or "").strip() if given is not None else ""


def _folder_of(include: etree._Element) -> str:
    """The last part of an include's URI, such as ``sun`` of ``model://sun``."""
    given = next(children(include, "uri"), None)
    return (given.text or "").strip().rstrip("/").rpartition("/")[2] if given is not None else ""


def children(element: etree._Element, tag: str) -> Iterator[etree._Element]:
    """The children of a tag, whatever their prefix."""
    return (child for child in element if isinstance(child.tag, str) and local_name(child) == tag)
