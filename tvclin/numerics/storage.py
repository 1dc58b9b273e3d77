"""Memory for large arrays that is used again, since new memory takes as long as filling it."""

from __future__ import annotations

from math import prod

import numpy as np

from tvclin.base.arrays import FloatArray


class Storage:
    """Arrays by name; a later array of a name has the memory of the earlier one."""

    def __init__(self) -> None:
        self._memory: dict[str, FloatArray] = {}

    def empty(self, name: str, shape: tuple[int, ...]) -> FloatArray:
        """Return an array of a name without values, in place of the earlier one."""
        size = prod(shape)
        if name not in self._memory or self._memory[name].size < size:
            self._memory[name] = np.empty(size)
        return self._memory[name][:size].reshape(shape)
