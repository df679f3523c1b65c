"""The comments of an SDF file, in a copy of what was read from it."""

from __future__ import annotations

from pathlib import Path

from lxml import etree

from libgz.base.files import read_limited, xml_parser
from libgz.sdf.element import Element
from libgz.sdf.xml import line_of, local_name

__all__ = ["copy_comments"]


def copy_comments(copy: Element, include: etree._Element) -> None:
    """Put the comments of an include, and of the file that it includes, in front of the elements that they are about.

    Args:
        copy: of the included element; its elements know their lines.
        include: the element that it takes the place of.
    """
    copy.comments = tuple(comment.text or "" for comment in include.iter(etree.Comment))
    try:
        root = etree.fromstring(read_limited(Path(copy.file)), xml_parser())
    except (OSError, etree.XMLSyntaxError):
        return  # such as a description that a program makes
    places: dict[tuple[int, str], Element] = {}
    waiting = [copy]
    while waiting:
        element = waiting.pop()
        if element.file == copy.file:
            places.setdefault((element.line, element.name), element)
        waiting += element.children[::-1]
    for comment in root.iter(etree.Comment):
        keys = ((line_of(owner), local_name(owner)) for owner in _owners(comment))
        found = next((places[key] for key in keys if key in places), None)
        if found is not None:
            found.comments += (comment.text or "",)


def _owners(comment: etree._Element) -> list[etree._Element]:
    """What a comment may be about: what is before it on its line, behind it, before it, or around it."""
    before = [one for one in comment.itersiblings(preceding=True) if isinstance(one.tag, str)][:1]
    behind = [one for one in comment.itersiblings() if isinstance(one.tag, str)][:1]
    beside = [one for one in before if one.sourceline == comment.sourceline]
    return [*beside, *behind, *before, *comment.iterancestors()]
