"""Commands beside the least that any of them could import: how many starts of it each takes.

Processor time of whole processes, which the neighbours of a shared machine disturb least. Where
Python may not keep its bytecode (PYTHONDONTWRITEBYTECODE) both take three times as long.
"""

import resource
import subprocess
import sys

import pytest
from peers import ROUNDS

COMMANDS = [
    "--help",
    "vehicles",
    "init new.toml",
    "doctor",
    "study",
    "disperse",
    "study --plot study.png",
    "study --gust 2 2",
    "report configuration-ii",
    "report",
    "boundary",
    "boundary --plot boundary.png",
    "boundary configuration-i",
    "respond",
    "respond --plot respond.png",
    "poles",
    "design",
    "margins",
    "margins --plot margins.png",
    "ascent",
    "fly",
    "fly --law all",
    "init --campaign cases.toml",
]
MOST_STARTS = {
    "study": 1.6,
    "study --plot study.png": 4.0,
    "study --gust 2 2": 2.5,
    "ascent": 3.0,
    "fly": 3.0,
    "report configuration-ii": 6.5,
    "report": 14.0,
    "fly --law all": 9.5,
}
"""Starts of numpy with scipy.optimize that a command is to take at most, as measured."""
FLOORS = {
    "study --plot study.png": "imports 2.1 (pyplot 0.6), answers 0.65, layout and drawing 0.7",
    "report configuration-ii": "pyplot, numba, two figures, layouts of 0.2 each",
    "report": "8 figures 2, autopilot along the flight 1.5, sizing of the flight 1.3, margins and"
    " 14 boundaries of laws 2, 2,000 cases 1, pyplot, numba and 20 kernels 1.7",
    "study --gust 2 2": "numba, for 84 times of the gust",
    "ascent": "numba and 11 kernels, 48 winds along the flight and 16 frozen ones",
    "fly": "scipy.integrate",
    "fly --law all": "some 12,000 flights: 45 boundaries with a scan of limits each",
}
"""What a command takes its time for, in starts."""


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command(benchmark, tmp_path, command):
    ours = [sys.executable, "-m", "tvclin", *command.split()]
    peer = [sys.executable, "-c", "import numpy, scipy.optimize"]
    best, best_peer = float("inf"), float("inf")
    for _ in range(ROUNDS):
        for left in tmp_path.iterdir():
            left.unlink()
        best_peer = min(best_peer, seconds(peer, tmp_path))
        best = min(best, seconds(ours, tmp_path))
    benchmark.extra_info.update(
        peer="python -c 'import numpy, scipy.optimize'",
        ours_seconds=best,
        peer_seconds=best_peer,
        ratio=best_peer / best,
        floor=FLOORS.get(command, "imports, and what is drawn"),
    )
    benchmark.pedantic(lambda: None)
    assert best <= MOST_STARTS.get(command, float("inf")) * best_peer


def seconds(command, folder):
    """Return the processor time of a process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode in (0, 1), done.stderr
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
