"""The square of dark and light modules."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol.tables import version_of

BoolArray = NDArray[np.bool_]


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The same array, closed for writing."""
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class Matrix:
    """Modules of a symbol without its quiet zone: `dark` (n, n) bool, row 0 at the top, True = dark.

    n = 17 + 4·version. (The paper writes dark as 0; nothing here does.)
    """

    dark: BoolArray

    def __post_init__(self) -> None:
        dark = np.array(self.dark, dtype=np.bool_, order="C")
        if dark.ndim != 2 or dark.shape[0] != dark.shape[1]:
            raise SymbolError(f"a matrix of shape {dark.shape} is not square: crop it to the symbol")
        version_of(dark.shape[0])
        object.__setattr__(self, "dark", read_only(dark))

    @classmethod
    def from_array(cls, dark: ArrayLike) -> Matrix:
        """Matrix of anything that numpy reads as an (n, n) array of truth values; True = dark."""
        return cls(np.asarray(dark).astype(np.bool_))

    @property
    def size(self) -> int:
        """Modules on one side."""
        return int(self.dark.shape[0])

    @property
    def version(self) -> int:
        return version_of(self.size)

    def __getitem__(self, module: tuple[int, int]) -> bool:
        return bool(self.dark[module])

    def flipped(self, modules: ArrayLike) -> Matrix:
        """A copy with the given modules, (k, 2) rows and columns, turned from dark to light or back."""
        dark = self.dark.copy()
        rows, columns = np.asarray(modules, dtype=np.intp).reshape(-1, 2).T
        dark[rows, columns] ^= True
        return Matrix(dark)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Matrix):
            return NotImplemented
        return np.array_equal(self.dark, other.dark)

    def __hash__(self) -> int:
        return hash(self.dark.tobytes())
