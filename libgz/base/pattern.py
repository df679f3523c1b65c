"""Patterns: regular expressions that files and messages name, matched in a time that grows with their length only.

Python's `re` tries one way after another, so that a short pattern such as ``(a+)+b`` can hold a server for hours. A
`Pattern` follows all ways at once, character by character (Thompson's construction).
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from libgz.base.errors import ParameterError

__all__ = ["Pattern"]

LONGEST = 1000  # characters of a pattern
MOST_STATES = 5000
DEEPEST = 50  # groups in each other
# [:name:] within a class, of which `re` knows none.
_CLASSES = {
    "alnum": "a-zA-Z0-9",
    "alpha": "a-zA-Z",
    "blank": r" \t",
    "digit": "0-9",
    "lower": "a-z",
    "punct": r"!-/:-@\[-`{-~",
    "space": r"\s",
    "upper": "A-Z",
    "xdigit": "0-9A-Fa-f",
}
_REPETITION = re.compile(r"\{(\d{1,4})(?:(,)(\d{1,4})?)?\}")
_CLASS = re.compile(r"\[\^?\]?(?:\[:[a-z]+:\]|\\.|[^\]\\])*\]", re.DOTALL)
_ESCAPE = re.compile(r"\\(?:x[0-9a-fA-F]{2}|u[0-9a-fA-F]{4}|[dDsSwWtnrfv]|[^\w\s])")


@dataclass(eq=False)
class _State:
    """Where a match may be: it continues at `after`, once a character or a place in the text has passed `test`."""

    test: Callable[[str], object] | None = None
    place: Callable[[str, int], bool] | None = None
    after: list[_State] = field(default_factory=list)


@dataclass
class _Atom:
    """One character, or a place between two."""

    test: Callable[[str], object] | None = None
    place: Callable[[str, int], bool] | None = None


@dataclass
class _Repeat:
    what: _Node
    least: int
    most: int | None


@dataclass
class _Choice:
    """Sequences, one of which matches."""

    ways: list[list[_Node]]


_Node = _Atom | _Repeat | _Choice
_NOTHING = _Atom()  # which passes without a character


class Pattern:
    """A regular expression as of ECMAScript and Python, without look-ahead and references to groups.

    Args:
        text: the expression, of at most 1000 characters.

    Raises:
        ParameterError: it is invalid, has what is not supported, or is too large.
    """

    def __init__(self, text: str) -> None:
        if len(text) > LONGEST:
            raise ParameterError(f"a pattern has {len(text)} characters; at most {LONGEST} are allowed")
        self.text, self._at, self._count = text, 0, 0
        tree = self._choice(0)
        if self._at < len(text):
            raise self._error("has a ) that nothing opens")
        self._end = _State()
        self._start = self._build(tree, self._end)

    def __repr__(self) -> str:
        return f"Pattern({self.text!r})"

    def matches(self, text: str) -> bool:
        """Whether the whole of a text matches."""
        now = _reached([self._start], text, 0)
        for i, character in enumerate(text):
            passed = [
                after for state in now if state.test is not None and state.test(character) for after in state.after
            ]
            now = _reached(passed, text, i + 1)
            if not now:
                return False
        return self._end in now

    # Parsing ---------------------------------------------------------------------------------------------------------

    def _choice(self, depth: int) -> _Choice:
        if depth > DEEPEST:
            raise self._error(f"has groups more than {DEEPEST} deep")
        ways: list[list[_Node]] = [[]]
        while self._at < len(self.text) and self.text[self._at] != ")":
            if self.text[self._at] == "|":
                self._at += 1
                ways.append([])
            else:
                ways[-1].append(self._repeated(self._atom(depth)))
        return _Choice(ways)

    def _atom(self, depth: int) -> _Node:
        character = self.text[self._at]
        if character == "(":
            if self.text.startswith("(?", self._at) and not self.text.startswith("(?:", self._at):
                raise self._error("has a group of a kind that is not supported; ( ) and (?: ) are")
            self._at += 3 if self.text.startswith("(?:", self._at) else 1
            group = self._choice(depth + 1)
            if self._at >= len(self.text):
                raise self._error("has a ( without )")
            self._at += 1
            return group
        if character in "*+?":
            raise self._error(f"has a {character} after nothing")
        if character == "[":
            return _Atom(self._one_of(self._take(_CLASS, "has a [ without ]")))
        if character == "\\":
            if self.text[self._at + 1 : self._at + 2] in ("b", "B"):
                at_end, self._at = self.text[self._at + 1] == "b", self._at + 2
                return _Atom(place=lambda text, i: _is_boundary(text, i) == at_end)
            return _Atom(self._one_of(self._take(_ESCAPE, "has an escape that is not supported")))
        self._at += 1
        if character == "^":
            return _Atom(place=lambda text, i: i == 0)
        if character == "$":
            return _Atom(place=lambda text, i: i == len(text))
        return _Atom((lambda one: one not in "\r\n") if character == "." else lambda one: one == character)

    def _take(self, kind: re.Pattern[str], what: str) -> str:
        found = kind.match(self.text, self._at)
        if found is None:
            raise self._error(what)
        self._at = found.end()
        return found[0]

    def _one_of(self, text: str) -> Callable[[str], object]:
        """The test of a class or an escape, which is `re`'s for a single character."""
        text = re.sub(r"\[:([a-z]+):\]", lambda found: _CLASSES.get(found[1], found[0]), text)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of sets within sets, which `re` may have one day
                return re.compile(text).fullmatch
        except (re.error, OverflowError) as error:
            raise self._error(f"has a wrong {text}: {error}") from None

    def _repeated(self, what: _Node) -> _Node:
        while self._at < len(self.text):
            character = self.text[self._at]
            counted = _REPETITION.match(self.text, self._at)
            if character in "*+?":
                least, most = {"*": (0, None), "+": (1, None), "?": (0, 1)}[character]
                self._at += 1
            elif counted is not None:
                least = int(counted[1])
                most = least if counted[2] is None else None if counted[3] is None else int(counted[3])
                self._at = counted.end()
            else:
                return what
            if most is not None and most < least:
                raise self._error("has a repetition whose most is below its least")
            if self.text.startswith("?", self._at):  # a match of the whole text is the same
                self._at += 1
            return _Repeat(what, least, most)
        return what

    def _error(self, what: str) -> ParameterError:
        return ParameterError(f"pattern {self.text[:100]!r} {what}")

    # States ----------------------------------------------------------------------------------------------------------

    def _state(self, after: Iterable[_State], atom: _Atom = _NOTHING) -> _State:
        self._count += 1
        if self._count > MOST_STATES:
            raise self._error(f"has more than {MOST_STATES} parts, repeated ones counted")
        return _State(atom.test, atom.place, list(after))

    def _build(self, node: _Node, after: _State) -> _State:
        """The state in which a match of a node begins that continues at `after`."""
        if isinstance(node, _Atom):
            return self._state([after], node)
        if isinstance(node, _Choice):
            starts = []
            for way in node.ways:
                start = after
                for part in reversed(way):
                    start = self._build(part, start)
                starts.append(start)
            return self._state(starts)
        if node.most is None:
            loop = self._state([after])
            loop.after.append(self._build(node.what, loop))
            start = loop
        else:
            start = after
            for _ in range(node.most - node.least):
                start = self._state([self._build(node.what, start), after])
        for _ in range(node.least):
            start = self._build(node.what, start)
        return start


def _reached(states: list[_State], text: str, i: int) -> set[_State]:
    """States, and all that follow without a character."""
    found: set[_State] = set()
    while states:
        state = states.pop()
        if state in found:
            continue
        found.add(state)
        if state.test is None and (state.place is None or state.place(text, i)):
            states += state.after
    return found


def _is_boundary(text: str, i: int) -> bool:
    """Whether a word begins or ends."""
    before, behind = (re.fullmatch(r"\w", one) is not None for one in (text[max(i - 1, 0) : i], text[i : i + 1]))
    return before != behind
