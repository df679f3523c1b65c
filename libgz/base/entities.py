"""Texts of XML: bytes, bounds, and a file's entities: `<!ENTITY width "0.5">` in its DOCTYPE, used as `&width;`."""

from __future__ import annotations

import re
from typing import Any

from lxml import etree

from libgz.base.errors import ParameterError, WorldFileError

__all__ = ["Entities", "check_attributes", "encoded"]

MOST_ATTRIBUTES = 1000  # of an element; lxml needs a time that is quadratic in their number
MOST = 100_000  # characters that a file's entities may have together, where they are used
DEEPEST = 40  # entities in entities
PREDEFINED = {"amp": "&", "lt": "<", "gt": ">", "quot": '"', "apos": "'"}
REFERENCE = re.compile(r"&([^;&\s]+);")
SURROGATE = re.compile("[\ud800-\udfff]")
DECLARATION = re.compile(r"\A[^<]*<\?xml\s.*?\?>|<\?xml\s[^<>]*\?>", re.DOTALL)
ENCODING = re.compile(r"encoding\s*=\s*(?:\"[^\"]*\"|'[^']*'|[^\s?]*)")


class Entities:
    """The texts of a document's own entities.

    The parser leaves them alone, for entities can hold other files and grow without limit. Here they are text only, of
    limited length.
    """

    def __init__(self, root: etree._Element) -> None:
        declared: Any = root.getroottree().docinfo.internalDTD  # its stubs lack entities()
        self._contents = {entity.name: entity.content for entity in declared.entities()} if declared is not None else {}
        self._left = MOST

    def text(self, name: str) -> str:
        """The text that replaces `&name;`.

        Raises:
            ParameterError: it is a file, holds elements, contains itself, or grows without limit.
        """
        return self._expanded(name, 0)

    def _expanded(self, name: str, depth: int) -> str:
        if name in PREDEFINED:
            return PREDEFINED[name]
        content = self._contents.get(name)
        if content is None:
            raise ParameterError(f"entity &{name}; is not text of this file; other files are not read")
        if "<" in content:
            raise ParameterError(f"entity &{name}; holds elements; only text is replaced")
        self._left -= len(content) + 1
        if depth > DEEPEST or self._left < 0:
            raise ParameterError(f"entity &{name}; contains itself, or is longer than {MOST} characters in all")
        return REFERENCE.sub(lambda match: self._expanded(match[1], depth + 1), content)


def check_attributes(root: etree._Element, label: str) -> None:
    """Check that no element of a document has too many attributes to be read.

    Raises:
        WorldFileError: one has.
    """
    for element in root.iter(etree.Element):
        count = len(element.attrib)
        if count > MOST_ATTRIBUTES:
            tag = str(element.tag).rpartition("}")[2]
            line = element.sourceline or 1
            raise WorldFileError(
                f"{label}:{line}: <{tag}>: it has {count} attributes; at most {MOST_ATTRIBUTES} are read"
            )


def encoded(text: str) -> bytes:
    """The bytes of a document's text, in UTF-8.

    The encoding that it declares is left out: it was that of other bytes, and a parser that believed it, or guessed
    one from zero bytes, would read another text than who checked this one. Null characters, with which texts of C end,
    become replacement characters.

    Raises:
        ParameterError: it has a surrogate, as names of files have that are no UTF-8.
    """
    if (wrong := SURROGATE.search(text)) is not None:
        line = text.count("\n", 0, wrong.start()) + 1
        raise ParameterError(f"<string>:{line}: {wrong[0]!a} is no character of XML")
    return DECLARATION.sub(lambda found: ENCODING.sub("", found[0]), text.replace("\0", "\ufffd")).encode()
