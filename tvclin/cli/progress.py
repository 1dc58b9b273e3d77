"""Progress of a long command: a bar with the remaining time, or lines in a pipe."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

Progress = Callable[[float, float], None]
"""Function called with the amount of work done, and with its total."""
_RATE_PERIOD_S = 3600.0
"""Period of the estimate of a rate [s]: slow work may report nothing for minutes."""
_MIN_DONE_FRACTION = 0.1
"""Fraction of the work done, since the first report, before a remaining time is shown."""
_LINE_INTERVAL_S = 20.0
"""Time [s] between two lines without a terminal, and before the first."""


@contextmanager
def bar(what: str) -> Iterator[Progress]:
    """Yield the function that shows a bar with the remaining time, or lines in a pipe."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lines(what)
        return
    from rich import progress as rich  # late: a terminal alone needs it

    counted = rich.TextColumn(f"{{task.completed:.0f}} of {{task.total:.0f}} {what}")
    columns = (rich.BarColumn(), counted, rich.TimeRemainingColumn())
    with rich.Progress(*columns, console=console, speed_estimate_period=_RATE_PERIOD_S) as progress:
        task = progress.add_task(what, total=None, visible=False)
        yield lambda done, total: progress.update(task, completed=done, total=total, visible=True)


def lines(what: str) -> Progress:
    """Return the function that writes progress on stderr, a line in twenty seconds at most.

    The rate counts from the first report on: earlier work, and the compilation of kernels until
    then, do not enter it.
    """
    import typer

    last = monotonic()
    first: tuple[float, float] | None = None

    def tell(done: float, total: float) -> None:
        """Show the fraction of the work that is done."""
        nonlocal first, last
        now = monotonic()
        first = first or (now, done)
        if now - last < _LINE_INTERVAL_S or not 0.0 < done < total:
            return
        last = now
        remaining = _remaining_text(now - first[0], done - first[1], total - done)
        typer.echo(
            f"{done:.0f} of {total:.0f} {what}{remaining and f', about {remaining} left'}", err=True
        )

    return tell


def _remaining_text(passed: float, done: float, rest: float) -> str:
    """Return the remaining time in words; empty before `_MIN_DONE_FRACTION` of the work is done."""
    return f"{passed * rest / done:.0f} s" if done >= _MIN_DONE_FRACTION * (done + rest) else ""


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """Show the current work and its elapsed time, where nothing can be counted; on a terminal."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield
        return
    from rich import progress as rich  # late: a terminal alone needs it

    shown = (rich.SpinnerColumn(), rich.TextColumn("{task.description}"), rich.TimeElapsedColumn())
    with rich.Progress(*shown, console=console, transient=True) as progress:
        progress.add_task(what, total=None)
        yield
