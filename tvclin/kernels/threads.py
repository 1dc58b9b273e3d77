"""Threads for compiled kernels, which let each other run: one slice of the cases for each."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

_WORTH = 0.004
"""Work of fewer seconds is not worth a thread."""
_EACH = 4
"""Slices for each thread: one that is held up leaves its last ones to the others."""
_ALIGN = 64
"""Slices begin at multiples of so many cases."""
VARIABLE = "TVCLIN_NUM_THREADS"
"""Environment variable that bounds the number of threads."""


def thread_count() -> int:
    """Return how many threads may run: the processors of this process, or fewer by `VARIABLE`."""
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None
    most = processors or os.cpu_count() or 1
    asked = os.environ.get(VARIABLE, "")
    return max(min(int(asked), most), 1) if asked.isdecimal() else most


def in_slices(work: Callable[[int, int], None], cases: int, seconds: float) -> None:
    """Call `work(first, last)` for slices that make up the cases, side by side.

    `work`: does the cases from `first` up to `last`; it must release the interpreter's lock.
    `cases`: how many cases there are. `seconds`: about what all of them take in one thread.
    """
    blocks = -(-cases // _ALIGN)
    threads = int(min(seconds / _WORTH, blocks))
    threads = min(thread_count(), threads) if threads > 1 else 1
    if threads == 1:
        work(0, cases)
        return
    slices = min(_EACH * threads, blocks)
    edges = np.minimum(np.linspace(0, blocks, slices + 1).round().astype(int) * _ALIGN, cases)
    with ThreadPoolExecutor(threads) as pool:
        for done in [pool.submit(work, int(a), int(b)) for a, b in pairwise(edges)]:
            done.result()
