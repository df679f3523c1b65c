"""Closing: the base of what a `with` block closes at its end."""

from __future__ import annotations

from typing import Self

__all__ = ["Closing"]


class Closing:
    """Has a `close`, which `with` calls at the end of its block."""

    def close(self) -> None:
        """Release what it holds. Can be called twice."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
