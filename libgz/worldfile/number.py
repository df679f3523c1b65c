"""Numbers as C's atof and atoi read them: leading blanks, the longest valid prefix, else zero."""

from __future__ import annotations

import re

__all__ = ["atof", "atoi", "malformed"]

_FLOAT = re.compile(r"\s*([+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf(?:inity)?|nan))", re.IGNORECASE)
_INT = re.compile(r"\s*([+-]?)0*(\d+)", re.ASCII)
_MOST_DIGITS = 20  # beyond those of any integer of C


def atof(text: str) -> float:
    """The number at the start of `text`, or 0."""
    match = _FLOAT.match(text)
    return float(match.group(1)) if match else 0.0


def atoi(text: str) -> int:
    """The whole number at the start of `text`, or 0."""
    match = _INT.match(text)
    return int(match[1] + match[2][:_MOST_DIGITS]) if match else 0


def malformed(text: str) -> bool:
    """Whether `text` is anything but one number."""
    match = _FLOAT.match(text)
    return match is None or bool(text[match.end() :].strip())
