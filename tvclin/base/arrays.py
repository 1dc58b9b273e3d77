"""Arrays: their types in annotations, by their elements, and memory that is used again."""

from __future__ import annotations

from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

AnyArray = NDArray[Any]
FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
IndexArray = NDArray[np.intp]
Real = float | FloatArray
"""A number of one vehicle, or the numbers of a batch."""


class Storage:
    """Float arrays by name; a later one has the memory of the earlier, as new memory is slow."""

    def __init__(self) -> None:
        """Start without memory."""
        self._memory: dict[str, FloatArray] = {}

    def empty(self, name: str, shape: tuple[int, ...]) -> FloatArray:
        """Return an uninitialised array of a `shape`, in the memory of the last of this `name`.

        The last array of the name is lost. New memory is taken where it was smaller.
        """
        size = prod(shape)
        if name not in self._memory or self._memory[name].size < size:
            self._memory[name] = np.empty(size)
        return self._memory[name][:size].reshape(shape)
