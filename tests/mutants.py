"""Mutated files: valid ones, damaged at random places. A seed and a number repeat each of them."""

from __future__ import annotations

import random
import re
import struct

__all__ = ["mutant"]

NUMBERS = (
    b"0", b"-0", b"-1", b"1", b"255", b"65536", b"2147483648", b"-2147483649", b"99999999999999999999", b"1e-320",
    b"1e30", b"1e300", b"1e308", b"1e400", b"-1e400", b"nan", b"inf", b"-inf", b"0x10", b"1,5", b"", b" ", b"abc",
    b"\xc3\xa9", b"1 2 3 4 5 6 7",
)  # fmt: skip
WORDS = (
    b"x" * 300, b"../" * 200, b"~nobody/x", b"/dev/null", b"/", b".", b"", b"\xef\xbf\xbd", b"a\tb", b"&amp;", b"%s%n", b"model://",
    b"file://", b"http://example.org/x", b"canonical", b"default", b"__default__", b"::", b"world",
)  # fmt: skip
_NUMBER = re.compile(rb"(?<![\w.])-?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
_TEXT = re.compile(rb">([^<>]*)<")
_ELEMENT = re.compile(rb"<([\w:]+)[^<>]*(?:/>|>[^<>]*</\1>)")
_TAG = re.compile(rb"</?([\w:]+)")
_VALUE = re.compile(rb"=\s*[\"']([^\"']*)[\"']")


def _replaced(data: bytes, place: tuple[int, int], new: bytes) -> bytes:
    return data[: place[0]] + new + data[place[1] :]


def _bytes(rng: random.Random, data: bytes) -> bytes:
    """Change, remove, insert, repeat or exchange bytes."""
    if not data:
        return b"\0"
    start = rng.randrange(len(data))
    end = min(len(data), start + rng.choice((1, 1, 1, 2, 4, 8, 64, 1024)))
    kind = rng.randrange(8)
    if kind == 0:
        return _replaced(data, (start, start + 1), bytes([data[start] ^ (1 << rng.randrange(8))]))
    if kind == 1:
        return _replaced(data, (start, start + 1), bytes([rng.choice((0, 1, 127, 128, 255, rng.randrange(256)))]))
    if kind == 2:
        return _replaced(data, (start, end), b"")
    if kind == 3:
        return _replaced(data, (start, start), rng.randbytes(end - start))
    if kind == 4:
        return _replaced(data, (end, end), data[start:end])
    if kind == 5:
        return data[:start]
    if kind == 6:
        number = rng.choice((0, 1, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, rng.getrandbits(32)))
        return _replaced(data, (start, start + 4), struct.pack(rng.choice("<>") + "I", number))
    other = rng.randrange(len(data))
    return _replaced(data, (start, end), data[other : other + end - start])


def _text(rng: random.Random, data: bytes) -> bytes:
    """Change a number, a word, a tag or an attribute; remove, repeat or move an element."""
    kind = rng.randrange(8)
    pattern = (_NUMBER, _NUMBER, _TEXT, _VALUE, _TAG, _ELEMENT, _ELEMENT, _ELEMENT)[kind]
    found = list(pattern.finditer(data))
    if not found:
        return _bytes(rng, data)
    match = rng.choice(found)
    if pattern is _NUMBER:
        return _replaced(data, match.span(), rng.choice(NUMBERS))
    if pattern in (_TEXT, _VALUE):
        return _replaced(data, match.span(1), rng.choice(NUMBERS + WORDS))
    if pattern is _TAG:
        return (
            data.replace(match[1], rng.choice(found)[1]) if rng.random() < 0.5 else _other_tag(rng, data, match, found)
        )
    if kind == 5:
        return _replaced(data, match.span(), b"")
    if kind == 6:
        return _replaced(data, match.span(), match[0] * rng.choice((2, 2, 3, 20)))
    target = rng.choice(found)
    return _replaced(data, (target.start(), target.start()), match[0])


def _other_tag(rng: random.Random, data: bytes, match: re.Match[bytes], found: list[re.Match[bytes]]) -> bytes:
    return _replaced(data, match.span(1), rng.choice(found)[1])


def mutant(seed: int, number: int, data: bytes, text: bool) -> bytes:
    """The mutant of a number: one to four changes of the data.

    Args:
        seed, number: which one.
        data: a valid file.
        text: whether it is text with numbers and perhaps tags, or binary.
    """
    rng = random.Random(f"{seed} {number}")
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        data = _text(rng, data) if text and rng.random() < 0.8 else _bytes(rng, data)
    return data
