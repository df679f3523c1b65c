"""Whole numbers of texts from anywhere."""

from __future__ import annotations

__all__ = ["whole_number"]


def whole_number(text: str, most: int) -> int | None:
    """The whole number from 0 to `most` that a text is, in the digits 0 to 9; None if it is none.

    `int` alone raises ValueError for some of the digits of `str.isdecimal`'s cousins, such as '²', and for more than
    4300 of any.
    """
    if not (text.isascii() and text.isdecimal()):
        return None
    digits = text.lstrip("0") or "0"
    return int(digits) if len(digits) <= len(str(most)) and int(digits) <= most else None
