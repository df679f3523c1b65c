"""The text form of messages, as protocol buffers print it: `x: 1`, `position { x: 1 }`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from libgz.classic.msgs.fields import AnyMessage, Field
from libgz.errors import ParameterError

__all__ = ["Parse", "write"]

_TOKEN = re.compile(
    r"""\s+ | \#[^\n]* |
    (?P<token> "(?:[^"\\\n]|\\.)*" | '(?:[^'\\\n]|\\.)*' | [{}<>\[\]:,;] | [^\s{}<>\[\]:,;"'\#]+ )""",
    re.VERBOSE | re.DOTALL,
)
_ESCAPES = {"n": "\n", "t": "\t", "r": "\r", '"': '"', "'": "'", "\\": "\\"}
_BOOLS = {"true": True, "t": True, "1": True, "false": False, "f": False, "0": False}
_ESCAPE = re.compile(rb"\\([0-7]{1,3}|x[0-9a-fA-F]{1,2}|.)", re.DOTALL)


def write(message: AnyMessage) -> str:
    """Return the set fields, one per line, nested ones indented by two spaces; each line ends with a newline."""
    return "".join(line + "\n" for line in _lines(message, ""))


def _lines(message: AnyMessage, indent: str) -> Iterator[str]:
    for field, value in message.ListFields():
        for item in value if field.repeated else (value,):
            if field.kind is None:
                yield f"{indent}{field.name} {{"
                yield from _lines(item, indent + "  ")
                yield indent + "}"
            else:
                yield f"{indent}{field.name}: {_scalar(field, item)}"


def _scalar(field: Field, value: Any) -> str:
    values = field.kind.values if field.kind is not None else None
    if values is not None:
        return next(name for name, number in values.items() if number == value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        if field.kind is not None and field.kind.name == "float":
            return _single(field, value)
        return repr(int(value)) if value.is_integer() and abs(value) < 1e16 else repr(value)
    if isinstance(value, (str, bytes)):
        return _quoted(value)
    return str(value)


def _single(field: Field, value: float) -> str:
    """Return the shortest text that reads as this number in single precision."""
    texts = [f"{value:.{digits}g}" for digits in (7, 8, 9)]
    return next((text for text in texts if field.check(float(text)) == value), texts[-1])


def _quoted(value: str | bytes) -> str:
    if isinstance(value, bytes):
        return '"' + "".join(chr(b) if 32 <= b < 127 and b not in b'"\\' else f"\\{b:03o}" for b in value) + '"'
    plain = {character: f"\\{letter}" for letter, character in _ESCAPES.items() if character != "'"}
    return '"' + "".join(plain.get(c, c if c >= " " else f"\\{ord(c):03o}") for c in value) + '"'


def Parse(message: AnyMessage, text: str) -> None:
    """Set fields of a message from its text form; a repeated field may also be given as a list.

    Raises:
        ParameterError: the text is invalid, names an unknown field, or has an invalid value.
    """
    reader = _Reader(text)
    reader.fields(message, "")


class _Reader:
    """Reads the tokens of a text from the front."""

    def __init__(self, text: str) -> None:
        self.tokens = []
        at = 0
        while at < len(text):
            match = _TOKEN.match(text, at)
            if match is None:
                raise ParameterError(f"message text: cannot read {text[at : at + 20]!r}")
            if match["token"] is not None:
                self.tokens.append(match["token"])
            at = match.end()
        self.tokens.reverse()

    def peek(self) -> str:
        return self.tokens[-1] if self.tokens else ""

    def take(self) -> str:
        if not self.tokens:
            raise ParameterError("message text: it ends within a field")
        return self.tokens.pop()

    def taken(self, token: str) -> bool:
        if self.peek() == token:
            self.tokens.pop()
            return True
        return False

    def fields(self, message: AnyMessage, closing: str) -> None:
        """Read fields up to the closing bracket, or to the end."""
        while self.peek() != closing:
            self.field(message)
            if not self.taken(","):
                self.taken(";")
        if closing:
            self.take()

    def field(self, message: AnyMessage) -> None:
        field = message._field(self.take())
        colon = self.taken(":")
        if field.repeated and self.taken("["):
            while not self.taken("]"):
                self.value(message, field)
                if self.peek() != "]" and not self.taken(","):
                    raise ParameterError(f"message text: {field.owner}.{field.name} has no , between its values")
        elif colon or field.message is not None:
            self.value(message, field)
        else:
            raise ParameterError(f"message text: {field.owner}.{field.name} must be followed by a colon and a value")

    def value(self, message: AnyMessage, field: Field) -> None:
        if field.message is None:
            value = self.scalar(field)
            if field.repeated:
                getattr(message, field.name).append(value)
            else:
                setattr(message, field.name, value)
            return
        opening = self.take()
        if opening not in ("{", "<"):
            raise ParameterError(f"message text: {field.owner}.{field.name} is a message: give it as {{ ... }}")
        part = getattr(message, field.name)
        if field.repeated:
            part = part.add()
        part.SetInParent()
        self.fields(part, "}" if opening == "{" else ">")

    def scalar(self, field: Field) -> Any:
        token = self.take()
        kind = field.kind.name if field.kind is not None else ""
        if token[0] in "\"'":
            data = _unquoted(token)
            while self.peek()[:1] in ("'", '"'):
                data += _unquoted(self.take())
            return data if kind == "bytes" else data.decode(errors="replace")
        if field.kind is not None and field.kind.values is not None:
            return int(token) if token.lstrip("-").isdigit() else token
        try:
            if kind in ("double", "float"):
                return float(token)
            if kind == "bool":
                return _BOOLS[token.lower()]
            return int(token, 0)
        except (ValueError, KeyError):
            raise ParameterError(f"message text: {field.owner}.{field.name} cannot be {token}") from None


def _unquoted(token: str) -> bytes:
    def plain(match: re.Match[bytes]) -> bytes:
        word = match[1].decode("latin-1")
        if word[0] in "01234567":
            return bytes((int(word, 8) & 0xFF,))
        if word[0] == "x" and len(word) > 1:
            return bytes((int(word[1:], 16),))
        return _ESCAPES.get(word, word).encode("latin-1")

    return _ESCAPE.sub(plain, token[1:-1].encode())
