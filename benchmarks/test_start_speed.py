"""Each command that flies nothing, beside the least that any of them could import.

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
    "study --disperse",
    "study --plot study.png",
    "report configuration-ii",
    "report",
    "boundary",
    "boundary --plot boundary.png",
    "optimum",
    "respond",
    "respond --plot respond.png",
    "poles",
    "autopilot",
    "margins",
    "margins --plot margins.png",
    "size",
    "campaign init cases.toml",
]
_TRIMS = "numba, for the flights of the trim law behind each curve"
FLOORS = {
    "study --plot study.png": f"{_TRIMS}; pyplot",
    "report configuration-ii": f"{_TRIMS}; pyplot, two figures",
    "report": "flights of five laws, 2,000 cases, five figures",
}


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


def seconds(command, folder):
    """Return the processor time of a process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode in (0, 1), done.stderr
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
