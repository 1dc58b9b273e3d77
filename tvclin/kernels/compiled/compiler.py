"""The compiler: numba, with its cache of machine code and without."""

from collections.abc import Callable
from typing import Any

import numba


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that needs nothing of Python, and lets other threads run.

    The machine code is kept beside the source, or in the user's cache; where neither can be
    written it is compiled anew in each process.
    """
    try:
        return numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # no place for a cache
        return numba.njit(nogil=True, error_model="numpy")(function)
