"""Which documents have macros; files without any do without the modules that expand them."""

from __future__ import annotations

from pathlib import Path

from lxml import etree

from libgz.sdf.xml import tag_name

__all__ = ["PREFIX", "SUFFIX", "has_macros"]

PREFIX = "xacro:"
SUFFIX = ".xacro"  # of files that are expanded in any case


def has_macros(root: etree._Element, path: Path | None) -> bool:
    """Whether a document is expanded: it has an element of xacro, or its file is named so."""
    if path is not None and path.suffix == SUFFIX:
        return True
    return any(tag_name(element).startswith(PREFIX) for element in root.iter(etree.Element))
