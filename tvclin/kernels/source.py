"""Kernels from one source: scalar loops, run as plain Python or compiled to machine code.

A function that is marked with `kernel` is unchanged. `machine_code` compiles it with numba (extra
`fast`), together with the marked functions that it calls, which are found by their names and
registered with numba then: its decorators at the definition would import it, half a second, also
where plain Python runs. Products and sums are not fused, so that both give the same bits except
for the last digit of exponentials, on any processor. A kernel is written for both: numbers, tuples
of numbers and arrays; loops and branches; no arrays allocated in a loop; bounded exponents, since
Python's `math` raises where machine code overflows to infinity.
"""

from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from types import FunctionType
from typing import Any, TypeVar

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

_marked: dict[Callable[..., Any], dict[str, Any]] = {}
"""Options of numba of each kernel, besides the options of all."""
_CONSTANTS = (float, int, str, tuple, np.generic)
_OPTIONS: Any = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
"""Options of numba: no interpreter lock; division by zero as in numpy; no entry for C."""
_INNER_OPTIONS: Any = {"no_cpython_wrapper": True}
"""Options of kernels that only kernels call, without the costly entry for Python."""


def kernel(function: F) -> F:
    """Mark a function that `machine_code` can compile, and return it unchanged."""
    _marked[function] = {}
    return function


def allocation_free(function: F) -> F:
    """Mark a kernel that allocates no array, and return it unchanged.

    It is compiled without counting references to its arguments, which would take half the time
    where arrays are passed to many small functions (`_nrt`: numba's runtime, which counts them).
    """
    _marked[function] = {"_nrt": False}
    return function


def inlined(function: F) -> F:
    """Mark a kernel that allocates no array to be compiled into its callers; return it unchanged.

    It serves functions that are called in an inner loop with many arrays, whose passing takes
    longer than the function.
    """
    _marked[function] = {"_nrt": False, "forceinline": True}
    return function


@cache
def machine_code(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel `function` compiled, with all kernels that it calls.

    The machine code is cached beside the source, or in the user's cache, under a name that depends
    on its sources, and with its hash; damaged code is compiled anew, and without a writable folder
    each process compiles for itself.
    """
    import numba  # late: it takes half a second to import

    from tvclin.kernels.code_cache import VerifiedCache

    for callee in _reached(function)[1:]:
        _register(callee)
    compiled: Any = numba.njit(**_OPTIONS, **_marked[function])(function)
    with suppress(RuntimeError):  # no place for it
        compiled._cache = VerifiedCache(function, digest(function))
    return compiled


@cache
def _register(function: Callable[..., Any]) -> None:
    """Register a kernel with numba as a function that machine code of other kernels can call.

    It has the kernel's options, and no entry for Python.
    """
    from numba.extending import register_jitable

    register_jitable(**_OPTIONS, **_INNER_OPTIONS, **_marked[function])(function)


def _reached(function: Any) -> list[Any]:
    """Return a function and all marked functions that it calls, directly or through others."""
    functions, queue = [function], [function]
    while queue:
        new = [callee for callee in _called(queue.pop()) if callee not in functions]
        functions, queue = functions + new, queue + new
    return functions


def _called(function: Any) -> list[Any]:
    """Return the marked functions that a function calls by their names in its module."""
    values = [function.__globals__.get(name) for name in function.__code__.co_names]
    return [value for value in values if isinstance(value, FunctionType) and value in _marked]


@cache
def digest(function: Any) -> str:
    """Return a hash of a function and all kernels that it calls: code, names and constants.

    Docstrings are constants.
    """
    kernels = _reached(function)
    codes = [kernel.__code__ for kernel in kernels]
    sources = [(code.co_code, code.co_consts, code.co_names) for code in codes]
    constants = [_constants(kernel) for kernel in kernels]
    return sha256(repr((sources, constants)).encode()).hexdigest()[:12]


def _constants(function: Any) -> list[tuple[str, str]]:
    """Return names and values of the constants that a function reads from its module."""
    names = function.__code__.co_names
    pairs = ((name, function.__globals__.get(name)) for name in names)
    return [(name, repr(value)) for name, value in pairs if isinstance(value, _CONSTANTS)]
