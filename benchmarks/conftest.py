"""Benchmarks run in one thread unless they say otherwise, and end with a table of ratios."""

import os
from collections.abc import Iterator

import pytest

from tvclin.kernels.choice import available, pinned

os.environ["TVCLIN_NUM_THREADS"] = "1"


@pytest.fixture(autouse=True)
def _compiled() -> Iterator[None]:
    """Measure the compiled twins, however little they are worth to this process."""
    with pinned(available()):
        yield


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Write the table: what, how long, its peer, and how many times as fast."""
    session = getattr(terminalreporter.config, "_benchmarksession", None)
    rows = [b for b in getattr(session, "benchmarks", []) if "ratio" in b.extra_info]
    if not rows:
        return
    write = terminalreporter.write_line
    write("")
    write("| work | tvclin | peer | takes | ratio | what keeps it from being faster |")
    write("|---|---|---|---|---|---|")
    for row in rows:
        info = row.extra_info
        name = row.name.removeprefix("test_").replace("_", " ")
        write(
            f"| {name} | {_time(info['ours_seconds'])} | {info['peer']}"
            f" | {_time(info['peer_seconds'])} | {info['ratio']:,.3g} | {info['floor']} |"
        )


def _time(seconds: float) -> str:
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"
