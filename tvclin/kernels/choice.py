"""Which twin of a kernel runs: numpy, or the compiled one where that pays.

Compiled twins need numba (extra `fast`) and some tenths of a second to load. They are taken when
the work is worth that, and for any work once they are there. Both give the same numbers within
the rounding each kernel states; nobody above the kernels knows which one ran.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

_WORTH = 0.1
"""Seconds of work for which the compiler, which takes some tenths to load, is loaded."""

_pinned: ContextVar[bool | None] = ContextVar("_pinned", default=None)


def compiled_twin(name: str, seconds: float) -> ModuleType | None:
    """Return the module ``kernels.compiled.<name>``, or None where numpy shall run.

    Parameters
    ----------
    name : str
        Of the module.
    seconds : float
        About what the numpy twin would take.
    """
    wanted = _pinned.get()
    path = f"tvclin.kernels.compiled.{name}"
    if wanted is None:
        wanted = seconds > _WORTH or path in sys.modules
    return import_module(path) if wanted and available() else None


@cache
def available() -> bool:
    """Whether there is a compiler."""
    return find_spec("numba") is not None


@contextmanager
def pinned(compiled: bool) -> Iterator[None]:
    """Take one twin whatever the size: for campaigns, whose chunks must agree, and for tests."""
    token = _pinned.set(compiled)
    try:
        yield
    finally:
        _pinned.reset(token)
