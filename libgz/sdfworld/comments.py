"""The comments of an SDF file, in a copy of what was read from it."""

from __future__ import annotations

from collections.abc import Iterator
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
    found: dict[int, tuple[Element, list[str]]] = {}
    for comment, owners in _owners(root):
        keys = ((line_of(owner), local_name(owner)) for owner in owners)
        about = next((places[key] for key in keys if key in places), None)
        if about is not None:
            found.setdefault(id(about), (about, []))[1].append(comment)
    for about, comments in found.values():
        about.comments += tuple(comments)


def _owners(root: etree._Element) -> Iterator[tuple[str, list[etree._Element]]]:
    """All comments, in order, with what each may be about: what is before on its line, behind, before, around it."""
    around: list[etree._Element] = []
    last: list[etree._Element | None] = [None]  # the element before, at each depth
    waiting: list[tuple[str, bool]] = []  # comments of which it is not known yet what is behind them
    for event, node in etree.iterwalk(root, events=("start", "end", "comment")):
        element = last[-1]
        before: list[etree._Element] = [] if element is None else [element]
        if event == "comment":
            waiting.append((node.text or "", bool(before) and before[0].sourceline == node.sourceline))
            continue
        behind = [node] if event == "start" else []
        for comment, beside in waiting:
            yield comment, [*(before if beside else ()), *behind, *before, *around[::-1]]
        waiting.clear()
        if event == "start":
            around.append(node)
            last.append(None)
        else:
            last.pop()
            last[-1] = around.pop()
