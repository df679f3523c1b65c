"""Recognition of SDF, apart from its reader, which worlds of other formats do without."""

from __future__ import annotations

import os
from io import BytesIO
from typing import IO

from lxml import etree

from libgz.base.entities import encoded
from libgz.base.files import open_file
from libgz.sdf.xml import READABLE, ROBOT, local_name

__all__ = ["is_robot_text", "is_sdf", "is_sdf_text"]


def is_sdf(filename: str | os.PathLike[str]) -> bool:
    """Whether the root of a file is `<sdf>`, the older `<gazebo>`, or URDF's `<robot>`; false for what is not XML."""
    try:
        # lxml takes the name of a stream, if it has one, and none that is no Unicode: this stream has a number.
        with open_file(filename) as plain, open(plain.fileno(), "rb", closefd=False) as stream:
            return _root_of(stream) in READABLE
    except OSError:
        return False


def is_sdf_text(text: str | bytes) -> bool:
    """The same for a text."""
    return _root_of(BytesIO(encoded(text) if isinstance(text, str) else text)) in READABLE


def is_robot_text(text: str) -> bool:
    """Whether a text is a robot description (URDF)."""
    return _root_of(BytesIO(encoded(text))) == ROBOT


def _root_of(stream: IO[bytes]) -> str:
    """The name of a document's root element; empty for what is not XML."""
    try:
        events = etree.iterparse(stream, events=("start",), resolve_entities=False, no_network=True, recover=True)
        _, root = next(iter(events))
        return local_name(root)
    except (StopIteration, etree.XMLSyntaxError):
        return ""
