"""Matching: which bodies, geoms, joints and spaces of an engine are those of a state, by names, kinds and numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from libgz.base.errors import StateError

__all__ = ["codes_of", "match"]

MOST_NAMED = 5  # missing objects in a message


def match(engine: Any, saved: dict[str, Any]) -> tuple[list[Any], list[Any], list[Any], list[Any], list[Any]]:
    """The objects that are in the state: bodies, dummies, geoms, joints, spaces; nothing is changed yet."""
    tables = engine.tables
    censuses = dict(zip(("bodies", "joints", "geoms"), saved["rows"], strict=True))
    # By numbers from 0 on, and from -1 on downwards, as `codes_of`.
    names = [label for label, _ in (*saved["bodies"], *reversed(saved["dummies"]))]
    missing: list[str] = []

    def find(kind: str, wanted: list[Any], things: Iterable[Any], trait: Callable[[Any], Any], least: int) -> list[Any]:
        """Things of these traits, else of their first parts: those of the same numbers first, then any."""
        table, present = getattr(tables, kind, None), list(things)
        numbers = dict(zip(table.census()[1], present, strict=True)) if table is not None else {}
        found = [numbers.get(number) for number in censuses[kind][1]] if table is not None else []
        for parts in (None, least):
            for candidates in (found, _chosen(present, wanted, trait, parts)):
                traits = [trait(thing)[:parts] if thing is not None else None for thing in candidates]
                if traits == [want[:parts] for want in wanted]:
                    return candidates
        chosen = _chosen(present, wanted, trait, least)
        missing.extend(_text(kind, want, names) for want, one in zip(wanted, chosen, strict=True) if one is None)
        return chosen

    bodies, dummies = (
        find(kind, [(values[0], label) for label, values in saved[kind]], things, _body_trait, 1)
        for kind, things in (("bodies", engine.bodies.values()), ("dummies", engine.dummies))
    )
    codes = codes_of(bodies, dummies)
    wanted = [tuple(row[:2]) for row in saved["geoms"]]
    geoms = find("geoms", wanted, engine.geoms.values(), lambda g: (type(g).__name__, codes.get(g.body)), 2)
    joints = find(
        "joints",
        [(kind, values[0], *pair) for kind, pair, values in saved["joints"]],
        engine.joints.values(),
        lambda joint: (type(joint).__name__, joint.name, *map(codes.get, joint.bodies)),
        2,
    )
    spaces = _match_spaces(engine, saved, geoms)
    if None in spaces:
        missing.append(f"{spaces.count(None)} spaces of geoms")
    if missing:
        more = len(missing) - MOST_NAMED
        listed = ", ".join(missing[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
        raise StateError(f"this state has what the world has not (any more): {listed}")
    return bodies, dummies, geoms, joints, spaces


def _match_spaces(engine: Any, saved: dict[str, Any], geoms: list[Any]) -> list[Any]:
    """The spaces in the order of the state: known by their geoms, and by their parts; of empty ones any."""
    parents = saved["spaces"]
    found: dict[int, Any] = {0: engine.top}
    for geom, place in zip(geoms, saved["inside"], strict=True):
        if place is not None and geom is not None and geom.space is not None:
            found.setdefault(place, geom.space)
    for i in range(len(parents), 0, -1):
        if i in found:
            found.setdefault(parents[i - 1], found[i].parent)
    left = [space for space in engine.spaces if space not in found.values()]
    for i, parent in enumerate(parents, 1):
        if i not in found:
            found[i] = next((space for space in left if space.parent is found.get(parent)), None)
            left = [space for space in left if space is not found[i]]
    return [found[i] for i in range(1, len(parents) + 1)]


def _body_trait(body: Any) -> tuple[Any, ...]:
    return body.bodyName, body.label


def _text(kind: str, trait: Sequence[Any], names: Sequence[str]) -> str:
    """What is missing, in words."""
    if kind in ("bodies", "dummies"):
        return f"body {trait[0] or 'unnamed'!r}"
    return f"{trait[0]} of body {names[trait[1]]!r}" if kind == "geoms" else f"{trait[0]} {trait[1] or 'unnamed'!r}"


def _chosen(
    things: Iterable[Any], wanted: Sequence[Any], trait: Callable[[Any], Any], least: int | None
) -> list[Any | None]:
    """A thing for each of the wanted traits: by all of it, else by its first parts; None where there is none."""
    left, found = list(things), [None] * len(wanted)
    for parts in dict.fromkeys((None, least)):
        by_trait: dict[Any, list[Any]] = {}
        for thing in reversed(left):
            by_trait.setdefault(trait(thing)[:parts], []).append(thing)
        for i, want in enumerate(wanted):
            if found[i] is None and by_trait.get(want[:parts]):
                found[i] = by_trait[want[:parts]].pop()
        left = [thing for others in by_trait.values() for thing in reversed(others)]
    return found


def codes_of(bodies: Sequence[Any], dummies: Sequence[Any]) -> dict[Any, int]:
    """Bodies by numbers from 0 on, dummies by -1 and less."""
    return {body: i for i, body in enumerate(bodies)} | {body: ~i for i, body in enumerate(dummies)}
