"""One source for every kernel: scalar loops, run as plain Python or as machine code of the same.

A function that is marked with `kernel` stays what it is. `machine_code` compiles it with numba
(extra `fast`), and with it the marked functions that it calls, which it finds by their names.
Products and sums are not fused, so both give the same bits but for the last digit of
exponentials, on any processor. A kernel is written so that both can run it: numbers, tuples of
numbers and arrays; loops and branches; no arrays made in a loop; exponents kept in bounds, since
Python's `math` raises where machine code goes to infinity.
"""

from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from types import FunctionType
from typing import Any, TypeVar

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

_marked: set[Callable[..., Any]] = set()
_bare: set[Callable[..., Any]] = set()
_inlined: set[Callable[..., Any]] = set()
_CONSTANTS = (float, int, str, tuple, np.generic)
_OPTIONS: Any = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
"""Other threads run beside; a division by zero is numpy's; nobody calls from C."""
_WITHIN: Any = {"no_cpython_wrapper": True}
"""Python calls the outermost alone: to take forty arrays from it costs as much to be compiled as
what is done with them."""


def kernel(function: F) -> F:
    """Mark a function that `machine_code` can compile; it is left as it is."""
    _marked.add(function)
    return function


def bare(function: F) -> F:
    """Mark a kernel that makes no array: nobody counts who uses those given.

    Counting takes half the time where arrays are handed on to many small functions.
    """
    _bare.add(function)
    return kernel(function)


def inlined(function: F) -> F:
    """Mark a bare kernel to be compiled into each that calls it.

    For what is called in an inner loop with many arrays, which take longer to hand over than what
    is done with them.
    """
    _inlined.add(function)
    return bare(function)


@cache
def machine_code(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel compiled, with all that it calls.

    The machine code is kept beside the source, or in the user's cache, under a name that tells
    what it was made of, and with its hash; what is damaged is compiled anew, and where nothing can
    be written each process compiles for itself.
    """
    import numba  # late: it takes half a second to import

    from tvclin.kernels.kept import Kept

    whole = _linked(function, f"{function.__name__}_{digest(function)}", machine_code_within)
    compiled: Any = numba.njit(**_options(function))(whole)
    with suppress(RuntimeError):  # no place for it
        compiled._cache = Kept(whole)
    return compiled


@cache
def machine_code_within(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel compiled for others to call; its code is kept with theirs."""
    import numba

    return numba.njit(**_options(function), **_WITHIN, forceinline=function in _inlined)(
        _linked(function, function.__name__, machine_code_within)
    )


def _options(function: Callable[..., Any]) -> Any:
    return _OPTIONS | ({"_nrt": False} if function in _bare else {})


def _linked(
    function: Any, name: str, compiled: Callable[[Callable[..., Any]], Callable[..., Any]]
) -> FunctionType:
    """Return a copy of a function that calls compiled ones in place of those that are marked."""
    names = dict(function.__globals__)
    names |= {key: compiled(one) for key, one in _called(function).items()}
    copy = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    copy.__qualname__ = name
    copy.__module__ = function.__module__
    return copy


def _called(function: Any) -> dict[str, Callable[..., Any]]:
    """Return the marked functions that a function calls, by the names it has for them."""
    names = {name: function.__globals__.get(name) for name in function.__code__.co_names}
    return {
        key: one for key, one in names.items() if isinstance(one, FunctionType) and one in _marked
    }


@cache
def digest(function: Any) -> str:
    """Return a name for the source of a function, its constants, and all that it calls."""
    every, left = [function], [function]
    while left:
        new = [one for one in _called(left.pop()).values() if one not in every]
        every, left = every + new, left + new
    codes = [one.__code__ for one in every]
    made = [(code.co_code, code.co_consts, code.co_names) for code in codes]
    return sha256(repr((made, [_constants(one) for one in every])).encode()).hexdigest()[:12]


def _constants(function: Any) -> list[tuple[str, str]]:
    """Return the numbers and names that a function finds in its module."""
    names = function.__code__.co_names
    found = ((name, function.__globals__.get(name)) for name in names)
    return [(name, repr(one)) for name, one in found if isinstance(one, _CONSTANTS)]
