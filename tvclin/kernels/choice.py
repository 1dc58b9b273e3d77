"""Choice of how a kernel runs: as plain Python, or as machine code of the same source.

Machine code needs numba (extra `fast`), some ten seconds per kernel to compile for the first time
on a computer, and half a second to load from then on. It is chosen where the work of the call, or
of all similar calls, is worth that, independently of earlier calls; in a command also where numba
is imported already, and where the calls of all commands together are worth compiling. The callers
of kernels do not depend on the choice.

Machine code runs in threads, each with slices of the cases.
"""

import os
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha1
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any
from warnings import warn

import numpy as np

from tvclin.base.errors import install
from tvclin.base.package_warnings import MachineWarning
from tvclin.kernels.source import digest, machine_code

_MIN_SECONDS_PER_THREAD = 0.004
"""Work [s] below which a further thread does not pay."""
_SLICES_PER_THREAD = 4
"""Slices per thread: a delayed thread leaves its last ones to the others."""
_SLICE_ALIGNMENT = 64
"""Cases of which slices start at multiples."""
VARIABLE = "TVCLIN_NUM_THREADS"
"""Environment variable that bounds the number of threads."""


def thread_count() -> int:
    """Return the number of threads: processors of this process, at most TVCLIN_NUM_THREADS."""
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None
    available = processors or os.cpu_count() or 1
    requested = os.environ.get(VARIABLE, "")
    return max(min(int(requested), available), 1) if requested.isdecimal() else available


def in_slices(work: Callable[[int, int], None], cases: int, seconds: float) -> None:
    """Call `work(first, last)` for slices that make up the cases, in parallel.

    `work`: computes the cases from `first` up to `last`; it must release the interpreter's lock.
    `cases`: number of cases. `seconds`: approximate time of all cases in one thread, which gives
    the number of threads: one if it is zero. Slices begin at multiples of `_SLICE_ALIGNMENT` cases.
    """
    blocks = -(-cases // _SLICE_ALIGNMENT)
    threads = int(min(seconds / _MIN_SECONDS_PER_THREAD, blocks))
    threads = min(thread_count(), threads) if threads > 1 else 1
    if threads == 1:
        work(0, cases)
        return
    slices = min(_SLICES_PER_THREAD * threads, blocks)
    edges = np.minimum(
        np.linspace(0, blocks, slices + 1).round().astype(int) * _SLICE_ALIGNMENT, cases
    )
    with ThreadPoolExecutor(threads) as pool:
        for done in [pool.submit(work, int(a), int(b)) for a, b in pairwise(edges)]:
            done.result()


_MIN_LOADING_SECONDS, _MIN_COMPILING_SECONDS = 0.02, 2.0
"""Time of a call in plain Python [s] above which cached machine code is loaded, of all calls of a
command together; and above which it is compiled, also of all such calls in commands."""
_MIN_IMPORTING_SECONDS = 0.4
"""Time of a command in plain Python [s] from which numba is imported, which takes as long."""
_LONG = 5.0
"""Time of all calls of a process in plain Python [s] above which a warning names numba."""

DISABLING = "NUMBA_DISABLE_JIT"
"""Environment variable with which numba does not compile."""

_pinned: ContextVar[bool | None] = ContextVar("_pinned", default=None)
_may_wait: ContextVar[bool] = ContextVar("_may_wait", default=True)
"""Whether a call may wait for compilation."""
_similar_calls: ContextVar[int] = ContextVar("_similar_calls", default=1)
"""Approximate number of similar calls."""


@dataclass
class _PlainWork:
    """Work [s] given to plain Python, and whether that was warned of; kernels with machine code.

    `by_kernel`: work [s] given to plain Python in a command, by kernel.
    """

    seconds: float = 0.0
    by_kernel: dict[Callable[..., Any], float] = field(default_factory=dict)
    announced: bool = False
    loaded: set[Callable[..., Any]] = field(default_factory=set)


_plain_work = _PlainWork()
_cached: set[Callable[..., Any]] = set()
"""Kernels whose machine code was on disk."""

_command: ContextVar[_PlainWork | None] = ContextVar("_command", default=None)
"""Plain work of the command that runs, if one does."""


def fastest(function: Callable[..., Any], seconds: float) -> Callable[..., Any]:
    """Return a kernel itself, or its machine code where that pays.

    `function`: marked by `kernels.source.kernel`. `seconds`: approximate time of the call in plain
    Python. It is counted: for a process without numba, which warns once when its calls take `_LONG`
    seconds together, and for the command that runs, if the kernel itself is returned.
    """
    if not available():
        _count(seconds)
    selected, command = fastest_uncounted(function, seconds), _command.get()
    if command is not None and selected is function:
        command.seconds += seconds
        command.by_kernel[function] = command.by_kernel.get(function, 0.0) + seconds
    return selected


def fastest_uncounted(function: Callable[..., Any], seconds: float) -> Callable[..., Any]:
    """Return a kernel itself, or its machine code where that pays, without counting the work.

    `function`: marked by `kernels.source.kernel`. `seconds`: approximate time of the call in plain
    Python, which counts as often as the context `repeated` says. Machine code that is on disk is
    loaded where that pays; else it is compiled if the calls take longer than
    `_MIN_COMPILING_SECONDS`, in a command if calls of all commands do. A kernel that ran as machine
    code does so to the end of the command. The context `pinned` decides before all of that.
    """
    if not available():
        return function
    pinned_choice = _pinned.get()
    if pinned_choice is not None:
        return machine_code(function) if pinned_choice else function
    total, command = seconds * _similar_calls.get(), _command.get()
    compiled = _may_wait.get() and total > _MIN_COMPILING_SECONDS
    if command is None:
        compiled = compiled or (total > _MIN_LOADING_SECONDS and _is_cached(function))
        return machine_code(function) if compiled else function
    # plain work of the kernel in this command before
    earlier = command.by_kernel.get(function, 0.0)
    importing_pays = _is_imported() or command.seconds + total > _MIN_IMPORTING_SECONDS  # numba
    if not compiled and importing_pays and earlier + total > _MIN_LOADING_SECONDS:
        may_compile = total > _MIN_LOADING_SECONDS and _may_wait.get()
        compiled = _is_cached(function) or (may_compile and _repays(function, seconds))
    if compiled:
        command.loaded.add(function)
    return machine_code(function) if function in command.loaded else function


def _count(seconds: float) -> None:
    """Add a call to the plain work of this process; warn once that it takes long without numba.

    `seconds`: approximate time of the call in plain Python. The warning comes as soon as the sum,
    with all similar calls that `repeated` announces, exceeds `_LONG`.
    """
    expected = _plain_work.seconds + seconds * _similar_calls.get()
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
    """Call a kernel for all cases, in plain Python or in threads of machine code.

    `function`: marked by `kernels.source.kernel`; its last two arguments are the first case and the
    end of a slice. `arguments`: those before. `cases`: number of cases. `seconds`,
    `compiled_seconds`: approximate time of all cases in plain Python, and as machine code in one
    thread.
    """
    selected = fastest(function, seconds)
    if selected is function:
        with np.errstate(all="ignore"):  # as machine code, which does not warn
            function(*arguments, 0, cases)
    else:
        in_slices(lambda first, last: selected(*arguments, first, last), cases, compiled_seconds)


def _is_cached(function: Callable[..., Any]) -> bool:
    """Return whether machine code of a kernel is, or was in this process, cached on disk."""
    if function not in _cached:
        cached = _cache_file(function)
        if next(cached.parent.glob(f"{cached.name}*.nbc"), None) is None:  # numba's suffix
            return False
        _cached.add(function)
    return True


def _repays(function: Callable[..., Any], seconds: float) -> bool:
    """Return whether the calls of a kernel in all commands are together worth compiling.

    `seconds`: the time of this call in plain Python. It is added to the sum of all commands, a file
    beside the machine code; without a writable folder it counts alone.
    """
    cached = _cache_file(function)
    sum_file = cached.with_name(f"{cached.name}.seconds")
    with suppress(OSError, ValueError):
        seconds += float(sum_file.read_text("ascii"))
    with suppress(OSError):  # no place for it
        sum_file.parent.mkdir(parents=True, exist_ok=True)
        sum_file.write_text(f"{seconds:.3g}", "ascii")
    return seconds > _MIN_COMPILING_SECONDS


def _cache_file(function: Callable[..., Any]) -> Path:
    """Return the path with which the names of the cached files of a kernel begin.

    A name has the kernel's file and function, and a hash of its sources.
    """
    file = Path(function.__code__.co_filename)
    return cache_folder(file.parent) / f"{file.stem}.{function.__name__}_{digest(function)}"


def cache_folder(sources: Path) -> Path:
    """Return the folder in which numba caches machine code of a folder's files.

    numba is not imported. The rule is that of numba/core/caching.py: the first writable folder of
    ``NUMBA_CACHE_DIR``, that of the sources, and the user's cache.
    """
    subfolder = f"{sources.name}_{sha1(str(sources).encode()).hexdigest()}"
    configured = os.environ.get("NUMBA_CACHE_DIR")
    folders = [Path(configured) / subfolder] if configured else []
    folders += [sources / "__pycache__", _users_cache() / subfolder]
    return next((folder for folder in folders if _writable(folder)), folders[-1])


def _users_cache() -> Path:
    """Return numba's folder in the user's cache, as numba places it on this platform."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", "~")).expanduser() / "numba" / "Cache"
    if sys.platform == "darwin":
        return Path("~/Library/Caches/numba").expanduser()
    return Path(os.environ.get("XDG_CACHE_HOME", Path("~/.cache").expanduser())) / "numba"


def _writable(folder: Path) -> bool:
    """Return whether a folder is writable, or can be made."""
    existing = next((path for path in (folder, *folder.parents) if path.exists()), folder)
    return existing.is_dir() and os.access(existing, os.W_OK)


def available() -> bool:
    """Return whether numba is installed and may compile."""
    return _installed() and not compiling_disabled()


@cache
def _installed() -> bool:
    """Return whether numba is installed."""
    return find_spec("numba") is not None


def _is_imported() -> bool:
    """Return whether this process has imported numba, so that loading machine code is quick."""
    return "numba" in sys.modules


def compiling_disabled() -> bool:
    """Return whether ``NUMBA_DISABLE_JIT`` is set, with which numba does not compile."""
    try:
        return bool(int(os.environ.get(DISABLING, "0")))
    except ValueError:  # which numba ignores
        return False


def remedy() -> str:
    """Return how to make numba available: a variable to unset, or a command to install it."""
    return f"unset {DISABLING}" if compiling_disabled() else install("fast")


def pinned(compiled: bool) -> AbstractContextManager[None]:
    """Return a context in which all calls run as machine code (`compiled`), or as plain Python."""
    return _within(_pinned, compiled)


def repeated(calls: int) -> AbstractContextManager[None]:
    """Return a context whose calls count as the first of a number of similar ones, `calls`.

    They are run as machine code if that pays for all of them. Nested numbers multiply.
    """
    return _within(_similar_calls, _similar_calls.get() * calls)


def in_a_command() -> AbstractContextManager[None]:
    """Return the context of a command line's command, whose calls count together.

    numba is imported once they are together worth it, and a kernel compiled once its calls in all
    commands are, each too short by itself.
    """
    return _within(_command, _PlainWork())


def announce(seconds: float) -> None:
    """Count work that a command is going to do, so that numba is imported before it, not within.

    `seconds`: its approximate time in plain Python at least. Outside commands nothing is counted.
    """
    command = _command.get()
    if command is not None:
        command.seconds += seconds


def compiling_nothing() -> AbstractContextManager[None]:
    """Return a context that takes machine code only from disk: for results that must not wait."""
    return _within(_may_wait, False)


@contextmanager
def _within(variable: ContextVar[Any], value: Any) -> Iterator[None]:
    """Set a context variable to a value inside the context, and back at its end."""
    token = variable.set(value)
    try:
        yield
    finally:
        variable.reset(token)
