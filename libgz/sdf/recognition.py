"""Recognition of SDF, apart from its reader, which worlds of other formats do without."""

from __future__ import annotations

import os
from io import BytesIO
from pathlib import Path
from typing import IO

from lxml import etree

from libgz.sdf.xml import ROOTS, local_name

__all__ = ["is_sdf", "is_sdf_text"]


def is_sdf(filename: str | os.PathLike[str]) -> bool:
    """Whether the root of a file is `<sdf>`, or the older `<gazebo>`; false for what cannot be read or is not XML."""
    try:
        with Path(filename).open("rb") as stream:
            return _root_is_sdf(stream)
    except OSError:
        return False


def is_sdf_text(text: str) -> bool:
    """The same for a text."""
    return _root_is_sdf(BytesIO(text.encode()))


def _root_is_sdf(stream: IO[bytes]) -> bool:
    try:
        events = etree.iterparse(stream, events=("start",), resolve_entities=False, no_network=True, recover=True)
        _, root = next(iter(events))
        return local_name(root) in ROOTS
    except (StopIteration, etree.XMLSyntaxError):
        return False
