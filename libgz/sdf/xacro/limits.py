"""Bounds of an expansion: one place counts work, and measures values before anything walks through them."""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import Any

from libgz.base.errors import GazeboError

__all__ = [
    "DEEPEST_BRACKET",
    "DEEPEST_ELEMENT",
    "DEEPEST_EXPRESSION",
    "DEEPEST_TAG",
    "LARGEST_YAML",
    "LONGEST_EXPRESSION",
    "LONGEST_TEXT",
    "MOST_ALIKE",
    "MOST_ATTRIBUTES",
    "MOST_BITS",
    "MOST_BYTES",
    "MOST_ELEMENTS",
    "MOST_FILES",
    "MOST_ITEMS",
    "MOST_WORK",
    "Budget",
    "ExpansionError",
    "LimitError",
    "small",
]

MOST_WORK = (
    2_000_000  # steps of expressions, elements, attributes and items that are made, together; 16 characters are one
)
MOST_ELEMENTS = 200_000  # that are made
MOST_ATTRIBUTES = 1000  # of one of them
DEEPEST_ELEMENT = 250  # in the result; libxml2 reads no deeper documents
DEEPEST_TAG = 1000  # macros, conditions and includes in each other
DEEPEST_EXPRESSION = 200  # operations in each other, those of properties and functions that an expression uses included
DEEPEST_BRACKET = 40  # in the text of an expression
LONGEST_EXPRESSION = 100_000  # characters
LONGEST_TEXT = 1_000_000  # characters of a value
MOST_ITEMS = 100_000  # of a value, those of the values in it included
DEEPEST_VALUE = 40  # lists in lists
MOST_BITS = 1024  # of an integer, as many as the largest float has
MOST_ALIKE = 100  # keys of one hash: each of them is compared with those before it
MOST_FILES = 1000  # included or read
MOST_BYTES = 16 * 1024 * 1024  # of them together
LARGEST_YAML = 512 * 1024  # bytes
WORK_OF_TEXT = 16  # characters that cost one step
WORK_OF_SEARCH = 256  # comparisons of characters that cost one step


class ExpansionError(GazeboError):
    """A macro, property or expression is wrong; whoever knows the element adds file and line."""


class LimitError(ExpansionError):
    """It would grow beyond a bound."""


def small(number: Any) -> Any:
    """The same number.

    Raises:
        LimitError: it is an integer of too many digits.
    """
    if isinstance(number, int) and number.bit_length() > MOST_BITS:
        raise LimitError(f"an integer has more than {MOST_BITS} bits")
    return number


class Budget:
    """What an expansion has used so far."""

    def __init__(self) -> None:
        self.work = self.elements = self.files = self.bytes = 0
        self._alike: dict[int, set[str]] = {}  # hash -> the keys of it, as they are printed

    def spend(self, steps: int) -> None:
        """Count work.

        Raises:
            LimitError: it is used up.
        """
        self.work += steps
        if self.work > MOST_WORK:
            raise LimitError(f"the expansion takes more than {MOST_WORK} steps; is there a loop?")

    def add_element(self, depth: int) -> None:
        """Count an element of the result, `depth` elements below the root.

        Raises:
            LimitError: there are too many, or they are nested too deeply.
        """
        self.elements += 1
        if self.elements > MOST_ELEMENTS:
            raise LimitError(f"the result has more than {MOST_ELEMENTS} elements")
        if depth > DEEPEST_ELEMENT:
            raise LimitError(f"elements are nested more than {DEEPEST_ELEMENT} deep")
        self.spend(1)

    def add_file(self, size: int) -> None:
        """Count a file that is read [bytes].

        Raises:
            LimitError: there are too many.
        """
        self.files += 1
        self.bytes += size
        if self.files > MOST_FILES:
            raise LimitError(f"more than {MOST_FILES} files are included")
        if self.bytes > MOST_BYTES:
            raise LimitError(f"the included files have more than {MOST_BYTES >> 20} MiB")

    def length(self, characters: int) -> None:
        """Count a text before it is made.

        Raises:
            LimitError: it is too long.
        """
        if characters > LONGEST_TEXT:
            raise LimitError(f"a text has more than {LONGEST_TEXT} characters")
        self.spend(1 + characters // WORK_OF_TEXT)

    def search(self, text: str, *parts: object) -> None:
        """Count a search for texts in a text: the slowest one compares each of its characters with each of theirs.

        Raises:
            LimitError: it would take too long.
        """
        longest = max((len(part) for part in parts if isinstance(part, str)), default=0)
        self.length(len(text))
        self.spend(len(text) * longest // WORK_OF_SEARCH)

    def key(self, value: object) -> None:
        """Count a key of a dictionary or set whose hash can be chosen.

        Raises:
            LimitError: too many different keys have this hash.
        """
        alike = self._alike.setdefault(hash(value), set())
        alike.add(repr(value))
        if len(alike) > MOST_ALIKE:
            raise LimitError(f"more than {MOST_ALIKE} keys have the same hash")

    def items(self, count: int) -> None:
        """Count the items of a list before it is made.

        Raises:
            LimitError: there are too many.
        """
        if count > MOST_ITEMS:
            raise LimitError(f"a value has more than {MOST_ITEMS} items")
        self.spend(count)

    def measure(self, *values: object) -> int:
        """The characters and items of values, counted each time they occur: what it costs to print or compare them.

        Raises:
            LimitError: they are too many, or nested too deeply.
        """
        total, pending = 0, [(value, 0) for value in values]
        while pending:
            value, depth = pending.pop()
            if isinstance(value, str):
                total += len(value)
                continue
            total += 8
            inside = _inside(value)
            if not inside:
                continue
            if depth == DEEPEST_VALUE:
                raise LimitError(f"lists are nested more than {DEEPEST_VALUE} deep")
            if len(inside) + len(pending) > MOST_ITEMS or total > LONGEST_TEXT:
                raise LimitError(f"a value has more than {MOST_ITEMS} items, or {LONGEST_TEXT} characters")
            pending.extend((item, depth + 1) for item in inside)
        self.spend(1 + total // WORK_OF_TEXT)
        return total


def _inside(value: object) -> list[object]:
    if isinstance(value, list | tuple | Set):
        return list(value)
    return [*value, *value.values()] if isinstance(value, Mapping) else []
