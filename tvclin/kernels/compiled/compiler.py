"""The compiler: numba, with its cache of machine code and without."""

from collections.abc import Callable
from typing import Any

import numba

_OPTIONS: Any = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
"""Other threads run beside; a division by zero is numpy's; a product and a sum round once."""
_LEAN: Any = {**_OPTIONS, "_nrt": False}


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that needs nothing of Python.

    The machine code is kept beside the source, or in the user's cache; where neither can be
    written it is compiled anew in each process.
    """
    try:
        return numba.njit(cache=True, **_OPTIONS)(function)
    except RuntimeError:  # no place for a cache
        return numba.njit(**_OPTIONS)(function)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function into those that call it, so that their loops run on several elements."""
    return numba.njit(forceinline=True, **_OPTIONS)(function)


def lean(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function for others to call, which makes no arrays.

    Nobody counts the views it takes of arrays, which would take longer than what is done with
    them; and its machine code is kept with that of its callers.
    """
    return numba.njit(**_LEAN)(function)


def merged(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile like `lean`, and into the caller: for what takes many arrays, and is called once."""
    return numba.njit(forceinline=True, **_LEAN)(function)
