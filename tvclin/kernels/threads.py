"""Threads of compiled kernels, each with slices of the cases."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

_MIN_SECONDS_PER_THREAD = 0.004
"""Work [s] below which a further thread does not pay."""
_SLICES_PER_THREAD = 4
"""Slices per thread: a delayed thread leaves its last ones to the others."""
_SLICE_ALIGNMENT = 64
"""Cases of which slices start at multiples."""
VARIABLE = "TVCLIN_NUM_THREADS"
"""Environment variable that bounds the number of threads."""


def thread_count() -> int:
    """Return the number of threads: processors of this process, at most `VARIABLE`."""
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None
    available = processors or os.cpu_count() or 1
    requested = os.environ.get(VARIABLE, "")
    return max(min(int(requested), available), 1) if requested.isdecimal() else available


def in_slices(work: Callable[[int, int], None], cases: int, seconds: float) -> None:
    """Call `work(first, last)` for slices that make up the cases, in parallel.

    `work`: computes the cases from `first` up to `last`; it must release the interpreter's lock.
    `cases`: number of cases. `seconds`: approximate time of all cases in one thread.
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
