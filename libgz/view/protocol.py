"""The protocol between the viewer and its pages: one WebSocket, and addresses of assets.

The viewer sends binary messages, whose first four bytes are their kind; numbers are little-endian.

1, a state
    uint32: kind, revision of the scene that belongs to it, whether the world is paused, rows and columns of bodies,
    rows and columns of joints, 0. float64: steps, sim time, pause time, real time [s]. float32: the tables of
    docs/observer.md.
2, an image
    uint32: kind, length of the name. The name in UTF-8: the id of a legacy camera, or ``model::link::sensor``. A JPEG.
3, a scene
    uint32: kind. JSON, packed by zlib: the scene of docs/observer.md, with ``assets``: the addresses of the files that
    it names, relative to the page. An asset is an array file of the scene as it is, a mesh as GLB, or a texture.

It sends JSON, too, an object with some of these keys: ``hello`` (title, abilities, skins, and ``reason`` if the
page only watches), ``control`` (here, other, canAsk, asked), ``robots`` (list, robot, speeds), ``status`` (text, level)
with ``log`` (begin, end, time) or null, ``contacts``, ``ranges``, ``rings``, ``series``, ``messages``, ``overlays``,
``problem`` (text, level), ``answer`` (a number) with ``value`` or ``error``.

A page sends JSON, an object with one of these keys: ``want`` (a channel) with ``names``, ``alive``, ``visible``,
``ask`` (a verb) with ``number``, ``argument``, ``content``; and if it controls the world, ``drive``, ``robot``,
``speeds``, ``key``. Other messages are dropped; so are those with numbers out of range.
"""

from __future__ import annotations

import json
import struct
import zlib
from typing import Any

import numpy as np

from libgz.base.budget import ELEMENT
from libgz.transport.observer import ObservedState

__all__ = [
    "CHANNELS",
    "LARGEST_MESSAGE",
    "LARGEST_OF_WATCHERS",
    "MOST_OF_WATCHERS",
    "MOST_VALUES",
    "VERBS",
    "held_size",
    "image_message",
    "read_message",
    "scene_message",
    "state_message",
]

STATE, IMAGE, SCENE = 1, 2, 3
CHANNELS = ("images", "ranges", "contacts", "fields", "console", "overlays")
MOST_NAMES, LONGEST_NAME = 500, 300  # that a page can want of a channel
LARGEST_MESSAGE = 36 << 20  # [byte] of a page that may control: a mesh that is dropped into it
LARGEST_OF_WATCHERS = 1 << 20  # [byte]
MOST_VALUES, MOST_OF_WATCHERS = 100_000, 4000  # of a message; without the token: those of the names it can want
LARGEST_NUMBER = 1e9  # of a message: metres, seconds
DEEPEST = 8
# What a page can ask of the server. Code, topics and files by name are not among it, whatever the server would answer.
VERBS = frozenset(
    {
        "pause",
        "step",
        "reset",
        "speed",
        "keep",
        "rewind",
        "seek",
        "move",
        "delete",
        "insert",
        "catalogue",
        "write",
        "describe",
        "light",
        "joint",
        "release",
        "hold",
        "undo",
        "redo",
        "history",
        "duplicate",
        "align",
        "attributes",
        "edit",
        "embed",
        "diff",
        "mesh",
        "probes",
    }
)


def state_message(state: ObservedState) -> bytes:
    """The message of a state."""
    bodies, joints = state.bodies, state.joints
    counts = (*bodies.shape, *joints.shape, 0)
    head = struct.pack("<3I5I", STATE, state.revision & 0xFFFFFFFF, state.paused, *counts)
    times = struct.pack("<4d", state.steps, state.sim_time, state.pause_time, state.real_time)
    return b"".join((head, times, bodies.astype("<f4").tobytes(), joints.astype("<f4").tobytes()))


def image_message(name: str, jpeg: bytes) -> bytes:
    """The message of a camera's image."""
    text = name.encode()
    return struct.pack("<2I", IMAGE, len(text)) + text + jpeg


def scene_message(scene: dict[str, Any], assets: dict[str, str]) -> bytes:
    """The message of a scene."""
    text = json.dumps({**scene, "assets": assets}, separators=(",", ":"), allow_nan=False)
    return struct.pack("<I", SCENE) + zlib.compress(text.encode(), 1)


def held_size(raw: str) -> int:
    """Bytes that a message takes with what its parser makes of it."""
    return len(raw) + ELEMENT * _values(raw)


def _values(raw: str) -> int:
    return raw.count(",") + raw.count("[") + raw.count("{")


def read_message(raw: str, most: int = MOST_VALUES) -> dict[str, Any] | None:
    """A message of a page; None for one that no page of ours sends.

    Args:
        most: values that it may have. One that has more is not parsed: it would take much memory, and others wait.
    """
    if _values(raw) > most:
        return None
    try:
        message = json.loads(raw, parse_constant=_refuse)
    except (ValueError, RecursionError):
        return None
    return message if isinstance(message, dict) and _is_sane(message) else None


def _refuse(text: str) -> float:
    raise ValueError(text)


def _is_sane(value: Any, depth: int = DEEPEST) -> bool:
    """Whether all numbers of a message are within +-`LARGEST_NUMBER`, and it is not nested deeper than pages send."""
    if isinstance(value, int | float):
        return abs(value) <= LARGEST_NUMBER
    if isinstance(value, dict | list):
        inside = value.values() if isinstance(value, dict) else value
        return depth > 0 and all(_is_sane(item, depth - 1) for item in inside)
    return True


def wanted_names(message: dict[str, Any]) -> list[str]:
    """The names of a message that wants something of a channel."""
    names = message.get("names")
    if not isinstance(names, list):
        return []
    return [name for name in names[:MOST_NAMES] if isinstance(name, str) and len(name) <= LONGEST_NAME]


def as_float32(values: Any) -> list[float]:
    """Finite numbers for JSON, shortened to what a page can show; infinite ones as -1."""
    array = np.asarray(values, dtype=np.float64).ravel()
    return np.where(np.isfinite(array), np.round(array, 4), -1.0).tolist()  # type: ignore[no-any-return]
