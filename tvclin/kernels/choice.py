"""How a kernel runs: as plain Python, or as machine code of the same where that pays.

Machine code needs numba (extra `fast`), some ten seconds a kernel to be compiled for the first time
on a machine, and half a second to load from then on. It is taken where the work of the call, or of
all that are alike, is worth that, whatever was called before; in a command, whose calls are the
same in each run, where all calls together are worth it. Nobody above the kernels knows.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from hashlib import sha1
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from warnings import warn

import numpy as np

from tvclin.base.errors import install
from tvclin.base.warned import MachineWarning
from tvclin.kernels.source import digest, machine_code
from tvclin.kernels.threads import in_slices

_LOADING, _COMPILING = 0.02, 2.0
"""Seconds of plain Python in one call for which machine code is loaded, and compiled where it is
not kept."""
_IMPORTING = 0.4
"""Seconds of plain Python in a command from which numba is imported, which takes as long."""
_LONG = 5.0
"""Seconds of plain Python, of all calls of a process together, from which numba is missed."""

DISABLING = "NUMBA_DISABLE_JIT"
"""Environment variable that tells numba to compile nothing."""

_pinned: ContextVar[bool | None] = ContextVar("_pinned", default=None)
_waits: ContextVar[bool] = ContextVar("_waits", default=True)
"""Whether somebody waits until a kernel is compiled."""
_alike: ContextVar[int] = ContextVar("_alike", default=1)
"""How many calls there are of each, about."""


@dataclass
class _PlainWork:
    """Work [s] that this process has given to plain Python, and whether that was warned of."""

    seconds: float = 0.0
    announced: bool = False


_plain_work = _PlainWork()

_command: ContextVar[_PlainWork | None] = ContextVar("_command", default=None)
"""Plain work of the command that runs, if one does."""


def swiftest(function: Callable[..., Any], seconds: float) -> Callable[..., Any]:
    """Return a kernel as it is, or as machine code where that pays.

    `function`: marked by `kernels.source.kernel`. `seconds`: about what it would take in plain
    Python. Without numba the process warns once, when its calls come to `_LONG` seconds together.
    """
    if not available():
        _count(seconds)
    taken, command = chosen(function, seconds), _command.get()
    if command is not None and taken is function:
        command.seconds += seconds
    return taken


def chosen(function: Callable[..., Any], seconds: float) -> Callable[..., Any]:
    """Return the same as `swiftest`, for work that is counted already."""
    wanted = _pinned.get()
    if wanted is None:
        every, command = seconds * _alike.get(), _command.get()
        compiles = _waits.get() and every > _COMPILING
        loads = command is None or command.seconds + every > _IMPORTING
        wanted = compiles or (loads and every > _LOADING and _is_kept(function))
    return machine_code(function) if wanted and available() else function


def _count(seconds: float) -> None:
    """Add a call to the plain work of this process, and warn as soon as it will be long."""
    expected = _plain_work.seconds + seconds * _alike.get()
    _plain_work.seconds += seconds
    if expected > _LONG and not _plain_work.announced:
        _plain_work.announced = True
        warn(
            f"this takes about {expected:.0f} s or more without numba, and a small part of that"
            f" with it: {remedy()}",
            MachineWarning,
            stacklevel=3,
        )


def run(
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    cases: int,
    seconds: float,
    compiled_seconds: float,
) -> None:
    """Call a kernel that does the cases from a first up to a last one, its last two arguments.

    `function`: marked by `kernels.source.kernel`. `cases`: how many there are. `seconds`,
    `compiled_seconds`: about what all of them take in plain Python, and as machine code in one
    thread.
    """
    taken = swiftest(function, seconds)
    if taken is function:
        with np.errstate(all="ignore"):  # as machine code, which does not warn
            function(*arguments, 0, cases)
    else:
        in_slices(lambda first, last: taken(*arguments, first, last), cases, compiled_seconds)


def _is_kept(function: Callable[..., Any]) -> bool:
    """Whether machine code of a kernel is kept."""
    file = Path(function.__code__.co_filename)
    kept = cache_folder(file.parent).glob(
        f"{file.stem}.{function.__name__}_{digest(function)}*.nbc"
    )
    return next(kept, None) is not None


def cache_folder(sources: Path) -> Path:
    """Return where numba keeps machine code of the files of a folder, without importing it.

    As in numba/core/caching.py: where ``NUMBA_CACHE_DIR`` says, beside the sources, or in the
    user's cache, whichever is the first that can be written.
    """
    apart = f"{sources.name}_{sha1(str(sources).encode()).hexdigest()}"
    asked = os.environ.get("NUMBA_CACHE_DIR")
    places = [Path(asked) / apart] if asked else []
    places += [sources / "__pycache__", _users_cache() / apart]
    return next((place for place in places if _writable(place)), places[-1])


def _users_cache() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", "~")).expanduser() / "numba" / "Cache"
    if sys.platform == "darwin":
        return Path("~/Library/Caches/numba").expanduser()
    return Path(os.environ.get("XDG_CACHE_HOME", Path("~/.cache").expanduser())) / "numba"


def _writable(folder: Path) -> bool:
    """Whether a folder can be written, or made."""
    there = next((one for one in (folder, *folder.parents) if one.exists()), folder)
    return there.is_dir() and os.access(there, os.W_OK)


def available() -> bool:
    """Whether numba is installed, and may compile."""
    return _installed() and not compiling_disabled()


@cache
def _installed() -> bool:
    return find_spec("numba") is not None


def compiling_disabled() -> bool:
    """Whether ``NUMBA_DISABLE_JIT`` is set, with which numba returns functions as they are."""
    try:
        return bool(int(os.environ.get(DISABLING, "0")))
    except ValueError:  # which numba ignores
        return False


def remedy() -> str:
    """Return what makes numba available: a variable to unset, or the command that installs it."""
    return f"unset {DISABLING}" if compiling_disabled() else install("fast")


def pinned(compiled: bool) -> AbstractContextManager[None]:
    """Take the one or the other whatever the size: for campaigns, and for tests."""
    return _within(_pinned, compiled)


def repeated(calls: int) -> AbstractContextManager[None]:
    """Choose for so many calls alike, which together are worth what one is not.

    Within others that are repeated it is so many times as many.
    """
    return _within(_alike, _alike.get() * calls)


def in_a_command() -> AbstractContextManager[None]:
    """Import numba only once the calls of a command together are worth it."""
    return _within(_command, _PlainWork())


def compiling_nothing() -> AbstractContextManager[None]:
    """Take machine code only where it is there already: for whom nobody waits until it is."""
    return _within(_waits, False)


@contextmanager
def _within(variable: ContextVar[Any], value: Any) -> Iterator[None]:
    token = variable.set(value)
    try:
        yield
    finally:
        variable.reset(token)
