"""What an editor shows while a worldfile or an SDF file is typed: completions, and the meaning of what is there.

Texts that are being typed are seldom well-formed, so they are scanned for tags and not parsed.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from libgz.legacy.factory import ModelFactory
from libgz.legacy.settings import GlobalAttributes
from libgz.reference.catalogue import Entry, Row, common_rows, entries, rows_of
from libgz.reference.sdf_elements import without_effect
from libgz.sdf.description import NEWEST, UNSET, VERSIONS, AttributeDescription, Description, describe

__all__ = ["Completion", "completions", "meaning"]

# Comments, CDATA sections, declarations, or tags; what is not closed yet reaches to the end.
_MARKUP = re.compile(
    r"<!--.*?(?:-->|$)|<!\[CDATA\[.*?(?:\]\]>|$)|<[?!][^>]*(?:>|$)|</?([\w:.-]*)([^<>]*)(>|(?=<)|$)", re.S
)
_COMMENT = re.compile(r"<!--.*?(?:-->|\Z)", re.S)
_SDF_TAG = re.compile(r"<sdf[^>]*")
_VERSION = re.compile(r"\sversion\s*=\s*[\"']([\d.]+)")
_ROOT = re.compile(r"<(?:(\w+):)?(\w+)")
_WORD = re.compile(r"[\w:.@-]*$")
_VALUE = re.compile(r"(?<![\w:.-])([\w:.-]+)\s*=\s*[\"'][^\"']*$")
LONGEST_WORD = 100  # characters; no name has as many
BOOLS = ("true", "false")
# (element, attribute) of SDF -> the words that it may have.
WORDS: dict[tuple[str, str], tuple[str, ...]] = {
    ("joint", "type"): (
        *("revolute", "prismatic", "fixed", "ball", "continuous", "universal", "revolute2", "screw", "gearbox"),
    ),
    ("light", "type"): ("point", "directional", "spot"),
    ("sensor", "type"): (
        *("ray", "gpu_ray", "camera", "depth", "multicamera", "imu", "contact", "gps", "sonar", "altimeter"),
        *("force_torque", "magnetometer", "logical_camera", "rfid", "rfidtag"),
        *("wireless_receiver", "wireless_transmitter"),
    ),
    ("physics", "type"): ("ode",),
}


class Completion(NamedTuple):
    """Something that can be typed.

    Attributes:
        label: the text that replaces the word that was begun.
        kind: element, attribute or value.
        detail: its type, unit and default.
        help: its meaning.
    """

    label: str
    kind: str
    detail: str = ""
    help: str = ""


@dataclass
class _Place:
    """Where in a document something is typed.

    Attributes:
        path: the open elements, outermost first; within a tag, its own is the last.
        tag: whether it is within a tag, behind its name.
        naming: whether it is the name of a tag.
        attribute: whose value it is; empty for none.
        word: what was typed of it.
    """

    path: list[str]
    tag: bool = False
    naming: bool = False
    attribute: str = ""
    word: str = ""


def completions(text: str, offset: int) -> list[Completion]:
    """What can be typed at an offset of a text, without regard to what was begun there."""
    place = _place(text, offset)
    if place is None:
        return []
    return list(_sdf(text, place) if _is_sdf(text) else _legacy(place))


def meaning(text: str, offset: int) -> str:
    """The meaning of the element or attribute at an offset, in Markdown; empty if nothing is known."""
    end = offset
    while end < len(text) and re.match(r"[\w:.-]", text[end]):
        end += 1
    place = _place(text, end)
    if place is None or not place.word or not (place.naming or place.tag):
        return ""
    known = {one.label: one for one in (_sdf(text, place) if _is_sdf(text) else _legacy(place))}
    found = known.get(place.word)
    if found is None:
        return ""
    head = f"**{found.label}**: {found.detail}" if found.detail else f"**{found.label}**"
    return f"{head}\n\n{found.help}".strip()


def _is_sdf(text: str) -> bool:
    root = _ROOT.search(_COMMENT.sub("", text))
    return root is not None and root[1] is None and root[2] in ("sdf", "gazebo")


def _place(text: str, offset: int) -> _Place | None:
    """The place of an offset; None within comments and the like."""
    path: list[str] = []
    opened: Counter[str] = Counter()  # in the path
    for match in _MARKUP.finditer(text, 0, offset):
        whole, name, rest, closed = match[0], match[1], match[2], match[3]
        if name is None:
            if match.end() >= offset and not whole.endswith((">", "]]>")):
                return None
            continue
        if not closed and match.end() >= offset:
            if not rest and not whole.startswith("</"):
                return _Place(path, naming=True, word=name)
            if whole.startswith("</"):
                return None
            word = _word(rest, len(rest))
            quotes = re.split(r"[\"']", rest)
            value = _VALUE.search(rest) if len(quotes) % 2 == 0 else None
            return _Place([*path, name], True, False, value[1] if value else "", word)
        if whole.startswith("</"):
            closing = opened[name] > 0
            while closing:
                last = path.pop()
                opened[last] -= 1
                closing = last != name
        elif not rest.endswith("/"):
            path.append(name)
            opened[name] += 1
    return _Place(path, word=_word(text, offset))


def _word(text: str, end: int) -> str:
    """The word in front of an offset, or the end of one that is too long."""
    found = _WORD.search(text, max(end - LONGEST_WORD, 0), end)
    return found[0] if found else ""


# Worldfiles -----------------------------------------------------------------------------------------------------------


def _legacy(place: _Place) -> Iterable[Completion]:
    owner = next((name for name in reversed(place.path) if ":" in name), "")
    inner = place.path[-1] if place.path else ""
    rows = _rows(owner)
    if place.tag:
        return
    if not place.naming and inner in rows:
        yield from _words(rows[inner])
        return
    if ":" in inner or not place.path:
        if place.path:
            yield from (Completion(row.name, "element", _detail(row), row.meaning) for row in rows.values())
        if not owner.startswith("param"):
            yield from (Completion(f"model:{one.name}", "element", "model", one.summary) for one in _models().values())
        if owner.startswith("gz:"):
            yield Completion("param:Global", "element", "settings", "The world's own settings.")


def _models() -> Mapping[str, Entry]:
    return {one.name: one for one in entries(ModelFactory())}


def _rows(owner: str) -> dict[str, Row]:
    """The attributes of a model's element, or those of the settings."""
    prefix, _, name = owner.partition(":")
    if prefix in ("param", "params"):
        return {row.name: row for row in rows_of(GlobalAttributes)}
    if prefix != "model":
        return {}
    entry = _models().get(name)
    return {row.name: row for row in [*common_rows(), *(entry.rows if entry is not None else ())]}


def _detail(row: Row) -> str:
    default = f", default {row.default}" if row.default else ""
    return f"{row.type}{f' [{row.unit}]' if row.unit else ''}{default}"


def _words(row: Row) -> Iterable[Completion]:
    words: tuple[str, ...] = BOOLS if row.type == "bool" else ()
    if row.allowed.startswith("one of "):
        words = tuple(row.allowed.removeprefix("one of ").split(", "))
    return (Completion(word, "value", row.type, row.help) for word in words)


# SDF ------------------------------------------------------------------------------------------------------------------


def _sdf(text: str, place: _Place) -> Iterable[Completion]:
    found = next(filter(None, (_VERSION.search(tag[0]) for tag in _SDF_TAG.finditer(text))), None)
    version = found[1] if found is not None and found[1] in VERSIONS else NEWEST
    about: Description | None = describe(version)["sdf"]
    if not place.path:
        yield Completion("sdf", "element", f"SDF {version}")
        return
    for name in place.path[1:]:
        about = about.children.get(name) if about is not None and not about.open else None
    if about is None:
        return
    block = about.block or about.name
    if place.attribute:
        attribute = about.all_attributes.get(place.attribute)
        yield from _values(about.name, place.attribute, attribute.type if attribute is not None else "")
    elif place.tag:
        yield from (_attribute(block, one) for one in about.all_attributes.values())
    else:
        if not place.naming and about.type == "bool":
            yield from _values("", "", "bool")
        yield from (_child(block, one) for one in about.children.values())


def _values(element: str, attribute: str, kind: str) -> Iterable[Completion]:
    words = WORDS.get((element, attribute), BOOLS if kind == "bool" else ())
    return (Completion(word, "value", kind) for word in words)


def _child(block: str, about: Description) -> Completion:
    return _described(about.name, "element", about.type or "element", about.default, about.note, about.path)


def _attribute(block: str, about: AttributeDescription) -> Completion:
    return _described(
        about.name, "attribute", about.type, about.default, about.note, f"{block}@{about.name}", about.required
    )


def _described(
    label: str, kind: str, type: str, default: str, note: str, path: str, required: bool = False
) -> Completion:
    words = [type, f"default {default}" if default not in ("", UNSET) else "", "required" if required else ""]
    reason = without_effect(path)
    lines = [note, f"No effect in libgz: {reason}." if reason else ""]
    return Completion(label, kind, ", ".join(filter(None, words)), "\n\n".join(filter(None, lines)))
