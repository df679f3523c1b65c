"""The text form of messages, as protocol buffers print it in C++: `x: 1`, `position { x: 1 }`."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from typing import Any

from google.protobuf import text_format

from libgz.base.errors import ParameterError
from libgz.base.visible import visible

__all__ = ["Parse", "write"]

_ESCAPES = {"\n": "\\n", "\t": "\\t", "\r": "\\r", '"': '\\"', "\\": "\\\\"}


def write(message: Any) -> str:
    """Return the set fields, one per line, nested ones indented by two spaces; each line ends with a newline."""
    return "".join(line + "\n" for line in _lines(message, ""))


def _lines(message: Any, indent: str) -> Iterator[str]:
    for field, value in message.ListFields():
        for item in value if field.is_repeated else (value,):
            if field.message_type is not None:
                yield f"{indent}{field.name} {{"
                yield from _lines(item, indent + "  ")
                yield indent + "}"
            else:
                yield f"{indent}{field.name}: {_scalar(field, item)}"


def _scalar(field: Any, value: Any) -> str:
    if field.enum_type is not None:
        return str(field.enum_type.values_by_number[value].name)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        if field.type == field.TYPE_FLOAT:
            return _single(value)
        return repr(int(value)) if value.is_integer() and abs(value) < 1e16 else repr(value)
    if isinstance(value, str):
        return '"' + "".join(_ESCAPES.get(c, c if visible(c) == c else _octal(c.encode())) for c in value) + '"'
    if isinstance(value, bytes):
        return '"' + "".join(chr(b) if 32 <= b < 127 and b not in b'"\\' else _octal((b,)) for b in value) + '"'
    return str(value)


def _octal(content: Iterable[int]) -> str:
    return "".join(f"\\{byte:03o}" for byte in content)


def _single(value: float) -> str:
    """Return the shortest text that reads as this number in single precision."""
    texts = [f"{value:.{digits}g}" for digits in (7, 8, 9)]
    return next((text for text in texts if struct.unpack("f", struct.pack("f", float(text)))[0] == value), texts[-1])


def Parse(message: Any, text: str) -> None:
    """Set fields of a message from its text form; a repeated field may also be given as a list.

    Raises:
        ParameterError: the text is invalid, names an unknown field, or has an invalid value.
    """
    try:
        text_format.Merge(text, message, descriptor_pool=message.DESCRIPTOR.file.pool)
    except (text_format.ParseError, UnicodeDecodeError) as error:
        raise ParameterError(f"message text: {error}") from None
