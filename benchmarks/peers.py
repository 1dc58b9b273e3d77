"""How a benchmark compares: tvclin and its peer by turns, in one process, the best of each."""

from collections.abc import Callable
from time import perf_counter, process_time
from typing import Any

ROUNDS = 7
PROCESSOR = process_time


def ratio(
    benchmark: Any,
    ours: Callable[[], Any],
    peer: Callable[[], Any],
    *,
    peer_name: str,
    per: float = 1,
    peer_per: float = 1,
    floor: str = "",
    clock: Callable[[], float] = perf_counter,
) -> float:
    """Return how many times as long the peer takes, and note it with the benchmark.

    Parameters
    ----------
    benchmark
        The fixture of pytest-benchmark.
    ours, peer : callable
        What is timed, by turns.
    peer_name : str
        What the peer is.
    per, peer_per : float
        Cases in one call of each.
    floor : str
        What keeps ours from being faster.
    clock : callable
        Seconds so far: `PROCESSOR` where one thread works, whatever its neighbours do.
    """
    ours()  # loads and compiles
    best, best_peer = float("inf"), float("inf")
    for _ in range(ROUNDS):
        best_peer = min(best_peer, _seconds(peer, clock) / peer_per)
        best = min(best, _seconds(ours, clock) / per)
    found = best_peer / best
    benchmark.extra_info.update(
        peer=peer_name, ours_seconds=best, peer_seconds=best_peer, ratio=found, floor=floor
    )
    benchmark.pedantic(ours, rounds=3)
    return found


def _seconds(work: Callable[[], Any], clock: Callable[[], float]) -> float:
    """Return the seconds of one call, of many calls where one is short."""
    start = clock()
    work()
    once = clock() - start
    calls = int(0.01 / max(once, 1e-7))
    if calls < 2:
        return once
    start = clock()
    for _ in range(calls):
        work()
    return (clock() - start) / calls
