"""RowMatrix: what matrices of rows have in common."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Self

import numpy as np
from numpy.typing import NDArray

from libgz.classic.math.number import text_of

__all__ = ["RowMatrix"]


class RowMatrix:
    """A square matrix whose numbers are in a list of rows, `m`."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]
    __array_priority__ = 1000.0  # numpy's numbers leave `number * matrix` to these classes

    m: list[list[float]]

    def __call__(self, row: int, column: int) -> float:
        """The number in a row and a column."""
        return self.m[row][column]

    def __getitem__(self, row: int) -> list[float]:
        return self.m[row]

    def __iter__(self) -> Iterator[list[float]]:
        return iter(self.m)

    def __len__(self) -> int:
        return len(self.m)

    def __array__(self, dtype: object = None, copy: bool | None = None) -> NDArray[np.float64]:
        return np.array(self.m, dtype=np.float64)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.m!r})"

    def __str__(self) -> str:
        return text_of(*(value for row in self.m for value in row))

    def Transposed(self) -> Self:
        """Rows as columns."""
        return type(self)(list(zip(*self.m, strict=True)))  # type: ignore[call-arg]

    def Transpose(self) -> None:
        """Swap rows and columns."""
        self.m = self.Transposed().m  # type: ignore[misc]  # a slot of the subclass
