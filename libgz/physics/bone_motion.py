"""Motions of skeletons in BVH files, as motion capture writes them.

A file has a tree of joints, each with an offset from its parent and the channels that move it, and a row of numbers for
each frame: one for each channel, in the order of the joints. Angles are in degrees; y is up, and z ahead. What is read
has z up and x ahead.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError
from libgz.base.files import read_text
from libgz.physics.skeletons import Figure, SkeletonAnimation, matrix_turns, turn_matrices

__all__ = ["fitted", "read_motion"]

Array = NDArray[np.float64]

AXES = {"X": 1, "Y": 2, "Z": 0}  # of the file: ours
ENDS_EARLY = "it ends too early"
MOST_JOINTS = 1000
MOST_NUMBERS = 20_000_000
LARGEST_FILE = 500_000_000  # [bytes]


@dataclass(eq=False)
class _Joint:
    name: str
    parent: _Joint | None
    offset: Array = field(default_factory=lambda: np.zeros(3))
    channels: tuple[str, ...] = ()
    first: int = 0  # column of its first channel


def read_motion(path: Path) -> Figure:
    """The skeleton of a BVH file with its animation, without a skin.

    Raises:
        GazeboError: it cannot be read, or is damaged.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise GazeboError(f"motion {path} has {path.stat().st_size} bytes; {LARGEST_FILE} are allowed")
        words = iter(read_text(path).split())
    except OSError as error:
        raise GazeboError(f"motion {path} cannot be read: {error.strerror}") from None
    try:
        return _figure(words)
    except ValueError as error:
        raise GazeboError(f"motion {path} cannot be read: {error}") from None


def fitted(motion: Figure, skin: Figure) -> SkeletonAnimation:
    """The animation of a motion for the bones of another skeleton, which `fits` it.

    Bones of a motion are not turned while it rests, those of a skin may be; both rest in the same attitude. So a bone
    of the skin turns, from its own attitude, as that of the motion does; distances between bones are the motion's.
    """
    animation = motion.animations[0]
    frames, count = animation.turns.shape[:2]
    rest = turn_matrices(skin.world(np.zeros(3), skin.turns[0], skin.positions, skin.turns)[1])
    local = turn_matrices(animation.turns)
    local[..., :3, 3] = animation.positions
    moved, result = np.empty((frames, count, 4, 4)), np.empty((frames, count, 4, 4))
    for bone, up in enumerate(motion.parents):
        moved[:, bone] = local[:, bone] if up < 0 else moved[:, up] @ local[:, bone]
        world = moved[:, bone] @ rest[bone]
        result[:, bone] = world if up < 0 else np.linalg.inv(moved[:, up] @ rest[up]) @ world
    return SkeletonAnimation(animation.name, animation.times, result[..., :3, 3], matrix_turns(result))


def _figure(words: Iterator[str]) -> Figure:
    _expect(words, "HIERARCHY")
    written = _joints(words)
    _expect(words, "Frames:")
    frames = int(_next(words))
    _expect(words, "Frame")
    _expect(words, "Time:")
    period = float(_next(words))
    width = sum(len(joint.channels) for joint in written)
    if not 0 < frames * max(width, 1) <= MOST_NUMBERS or not 0.0 < period < 1e6:
        raise ValueError(f"{frames} frames of {width} numbers, one every {period:g} s, are not allowed")
    rows = np.array([float(word) for word in words], dtype=np.float64)
    if rows.size != frames * width or not np.isfinite(rows).all():
        raise ValueError(f"its frames have {rows.size} numbers; {frames} frames of {width} are stated")
    rows = rows.reshape(frames, width)

    joints = _by_depth(written)
    offsets = np.stack([np.roll(joint.offset, 1) for joint in joints])
    if not np.isfinite(offsets).all():
        raise ValueError("an offset is not finite")
    moved = [_moved(joint, rows) for joint in joints]
    animation = SkeletonAnimation(
        "animation1",
        period * np.arange(frames, dtype=np.float64),
        np.stack([positions for positions, _ in moved], axis=1),
        np.stack([turns for _, turns in moved], axis=1),
    )
    parents = tuple(-1 if joint.parent is None else joints.index(joint.parent) for joint in joints)
    still = np.tile((1.0, 0.0, 0.0, 0.0), (len(joints), 1))
    return Figure(tuple(joint.name for joint in joints), parents, offsets, still, (), (animation,))


def _expect(words: Iterator[str], wanted: str) -> None:
    found = _next(words)
    if found.lower() != wanted.lower():
        raise ValueError(f"{found[:40]!r} stands where {wanted!r} is expected")


def _joints(words: Iterator[str]) -> list[_Joint]:
    """All joints up to the word MOTION, in the order of the file; the ends of limbs are none."""
    found: list[_Joint] = []
    open_joints: list[_Joint | None] = []  # None: the end of a limb
    columns = 0
    for word in words:
        here = open_joints[-1] if open_joints else None
        if word in ("ROOT", "JOINT"):
            if (word == "ROOT") != (not found):
                raise ValueError(f"{word} is not allowed here: a file has one ROOT, and JOINTs in it")
            found.append(_Joint(_name(words), here))
            open_joints.append(found[-1])
            if len(found) > MOST_JOINTS:
                raise ValueError(f"it has more than {MOST_JOINTS} joints")
        elif word == "End":
            _expect(words, "Site")
            _expect(words, "{")
            open_joints.append(None)
        elif word == "OFFSET":
            offset = np.array([float(_next(words)) for _ in range(3)])
            if here is not None:
                here.offset = offset
        elif word == "CHANNELS" and here is not None and not here.channels:
            here.channels = tuple(_next(words) for _ in range(int(_next(words))))
            here.first = columns
            columns += len(here.channels)
        elif word == "}" and open_joints:
            open_joints.pop()
        elif word == "MOTION" and found and not open_joints:
            return found
        else:
            raise ValueError(f"{word[:40]!r} is not expected")
    raise ValueError(ENDS_EARLY)


def _next(words: Iterator[str]) -> str:
    word = next(words, None)
    if word is None:
        raise ValueError(ENDS_EARLY)
    return word


def _name(words: Iterator[str]) -> str:
    """The words up to the brace."""
    parts = []
    while (word := _next(words)) != "{":
        parts.append(word)
    return " ".join(parts)


def _by_depth(joints: list[_Joint]) -> list[_Joint]:
    """The joints in the order of skeletons: the root, its children, then theirs."""
    found = joints[:1]
    for joint in found:
        found += [child for child in joints if child.parent is joint]
    return found


def _moved(joint: _Joint, rows: Array) -> tuple[Array, Array]:
    """(positions, turns) of a joint in all frames; its rotations are applied in the order of its channels."""
    positions = np.tile(np.roll(joint.offset, 1), (len(rows), 1))
    turns = np.tile(np.eye(4), (len(rows), 1, 1))
    for column, channel in enumerate(joint.channels, start=joint.first):
        axis, kind = AXES.get(channel[:1].upper()), channel[1:].lower()
        if axis is None or kind not in ("position", "rotation"):
            raise ValueError(f"channel {channel[:40]!r} is not known")
        if kind == "position":
            positions[:, axis] = rows[:, column]
            continue
        half = np.radians(rows[:, column]) / 2.0
        quaternions = np.zeros((len(rows), 4))
        quaternions[:, 0], quaternions[:, 1 + axis] = np.cos(half), np.sin(half)
        turns = turns @ turn_matrices(quaternions)
    return positions, matrix_turns(turns)
