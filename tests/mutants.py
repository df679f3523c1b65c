"""Mutated files: valid ones, damaged at random places. A seed and a number repeat each of them."""

from __future__ import annotations

import copy
import random
import re
import struct
from collections.abc import Sequence

from lxml import etree

__all__ = ["OWN_NAME", "mutant"]

OWN_NAME = "self.world"  # a mutant of this name may include itself

NUMBERS = (
    b"0", b"-0", b"-1", b"1", b"255", b"65536", b"2147483648", b"-2147483649", b"99999999999999999999", b"1e-320",
    b"1e30", b"1e300", b"1e308", b"1e400", b"-1e400", b"nan", b"inf", b"-inf", b"0x10", b"1,5", b"", b" ", b"abc",
    b"\xc3\xa9", b"1 2 3 4 5 6 7",
)  # fmt: skip
WORDS = (
    b"x" * 300, b"../" * 200, b"~nobody/x", b"/dev/null", b"/", b".", b"", b"\xef\xbf\xbd", b"a\tb", b"&amp;", b"%s%n", b"model://",
    b"file://", b"http://example.org/x", b"canonical", b"default", b"__default__", b"::", b"world",
)  # fmt: skip
# What another version or dialect would have in a place.
TAGS = (
    "sdf", "world", "model", "link", "joint", "sensor", "plugin", "visual", "collision", "geometry", "inertial",
    "pose", "include", "uri", "frame", "actor", "light", "gazebo", "parent", "child", "axis", "xyz", "limit", "robot",
    "origin", "mass", "inertia", "mesh", "box", "transmission", "material", "script", "name", "state", "physics",
    "gripper", "road", "population", "wind", "joint_state",
)  # fmt: skip
VERSIONS = ("1.0", "1.2", "1.3", "1.4", "1.5", "1.6", "1.7", "1.12", "2.0", "-1", "1", "one", "", "1.6.0")
NAMES = (
    "\u00fc\u4e16\u754c", "\U0001f916", "a\u0301", "\u202eabc", "a::b", "::", "a b", "a/b", "..", "__model__",
    "x" * 5000,
)  # fmt: skip
EXPRESSIONS = (
    "${1/0}", "${9**9**9}", "${'a'*10**9}", "${[0]*10**9}", "${unknown}", "${", "$(", "$(arg none)", "$(find none)",
    "$(eval 1 +)", "${xacro}", "$(env NONE)", "$(optenv)", "${radians('x')}", "${[x for x in range(10**8)]}",
    "${(lambda: 0)()}", "${().__class__}", "$(dirname)", "${'%1000000000d' % 1}", "$$${1}", "${-1e400}",
    "${int('9'*5000)}", "${{}[0]}", "${load_yaml('/dev/zero')}", "${1 << 10**9}", "${xacro.load_yaml('self.world')}",
    "${True and}", "${sqrt(-1)}", "${' '.join(['a']*10)}", "${tau**0.5}",
)  # fmt: skip
INCLUDES = (
    f"<include><uri>{OWN_NAME}</uri></include>",
    f"<include merge='true'><name>own</name><uri>file://{OWN_NAME}</uri></include>",
    f"<xacro:include xmlns:xacro='http://www.ros.org/wiki/xacro' filename='{OWN_NAME}'/>",
    "<xacro:include xmlns:xacro='http://www.ros.org/wiki/xacro' filename='*.world' ns='own'/>",
    f"<xi:include xmlns:xi='http://www.w3.org/2001/XInclude' href='{OWN_NAME}'/>",
    "<include><uri>model://none</uri></include>",
)

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


def _tree(rng: random.Random, data: bytes, donors: Sequence[bytes]) -> bytes:
    """Exchange, nest, wrap, graft, rename, empty or remove elements; change attributes, versions, names, includes."""
    root = _parsed(data)
    other = root if not donors or rng.random() < 0.5 else _parsed(rng.choice(donors))
    if root is None or other is None:
        return _text(rng, data)
    elements = [element for element in root.iter() if isinstance(element.tag, str)]
    strangers = [element for element in other.iter() if isinstance(element.tag, str)]
    element, stranger = rng.choice(elements), rng.choice(strangers)
    inner = element is not root
    kind = rng.randrange(13)
    if kind == 0:
        _exchange(element, stranger)
    elif kind == 1:  # nested in itself, or an ancestor in it
        above = rng.choice([element, *element.iterancestors()])
        for _ in range(rng.choice((1, 1, 2, 5))):
            if sum(1 for _ in root.iter()) < 3000:  # each time: an ancestor doubles
                element.append(copy.deepcopy(above))
    elif kind == 2 and inner:
        wrapped, place = element, element.getparent()
        index, empty = place.index(element), copy.deepcopy(element)
        del empty[:]
        for _ in range(rng.choice((1, 2, 30, 300))):
            around = copy.deepcopy(empty)  # not made anew: the tag may have a prefix without xmlns
            around.append(wrapped)
            wrapped = around
        place.insert(index, wrapped)
    elif kind == 3:
        element.append(copy.deepcopy(stranger))
    elif kind == 4 and inner:
        element.addnext(copy.deepcopy(stranger))
    elif kind == 5:
        element.tag = rng.choice((*TAGS, stranger.tag if stranger.tag[0] == "{" else stranger.tag.replace(":", "")))
    elif kind == 6 and inner:
        element.getparent().remove(element)
    elif kind == 7:
        del element[:]
        element.text = rng.choice((None, " ", "\u00a0", "1", *NAMES))
    elif kind == 8:
        element.set(rng.choice(("name", "version", "type", *_settable(stranger))), rng.choice((*VERSIONS, *NAMES)))
    elif kind == 9 and len(element.attrib):
        del element.attrib[rng.choice(list(element.attrib))]
    elif kind == 10:
        root.set("version", rng.choice(VERSIONS))
    elif kind == 11:
        element.append(etree.fromstring(rng.choice(INCLUDES)))
    else:  # expressions
        with_attributes = [element for element in elements if _settable(element)]
        element = rng.choice(with_attributes or elements)
        name = rng.choice(_settable(element) or ["value"])
        element.set(
            name, rng.choice(EXPRESSIONS) if rng.random() < 0.7 else element.get(name, "") + rng.choice(EXPRESSIONS)
        )
    return etree.tostring(root, encoding="utf-8")


def _settable(element: etree._Element) -> list[str]:
    """Names of the attributes that lxml sets: not those with a prefix without xmlns, which it only reads."""
    return [str(name) for name in element.attrib if str(name)[0] == "{" or ":" not in str(name)]


def _parsed(data: bytes) -> etree._Element | None:
    try:
        return etree.fromstring(data, etree.XMLParser(recover=True, huge_tree=True, resolve_entities=False))
    except etree.XMLSyntaxError:
        return None


def _exchange(one: etree._Element, two: etree._Element) -> None:
    """Let two subtrees take each other's place, of one tree or of two."""
    places = [(element.getparent(), element) for element in (one, two)]
    if (
        any(place is None for place, _ in places)
        or one in two.iterancestors()
        or two in one.iterancestors()
        or one is two
    ):
        return
    copies = copy.deepcopy(two), copy.deepcopy(one)
    for (place, element), new in zip(places, copies, strict=True):
        place.replace(element, new)


def mutant(seed: int, number: int, data: bytes, text: bool, donors: Sequence[bytes] = ()) -> bytes:
    """The mutant of a number: one to four changes of the data.

    Args:
        seed, number: which one.
        data: a valid file.
        text: whether it is text with numbers and perhaps tags, or binary.
        donors: other valid files, whose elements it may take, if it is XML.
    """
    rng = random.Random(f"{seed} {number}")
    xml = text and data.lstrip().startswith(b"<")
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        kind = rng.random()
        if xml and kind < 0.4:
            data = _tree(rng, data, donors)
        else:
            data = _text(rng, data) if text and kind < 0.85 else _bytes(rng, data)
    return data
