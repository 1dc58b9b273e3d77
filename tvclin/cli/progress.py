"""What a long command tells while it works: a bar with the time left, or lines in a pipe."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

Progress = Callable[[float, float], None]
"""Is told how much is done, and how much there is."""
_SPAN = 3600.0
"""Seconds over which a rate is taken: slow work may tell of nothing for minutes."""
_SURE = 0.1
"""Of what is left at first, so much is done before a time left is shown: wild guesses are none."""
_LINES = 20.0
"""Seconds between two lines where there is no terminal, and before the first."""


@contextmanager
def bar(what: str) -> Iterator[Progress]:
    """Lend what shows a bar with rate and time left; a line now and then without a terminal."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lines(what)
        return
    from rich import progress as rich  # late: a terminal alone needs it

    counted = rich.TextColumn(f"{{task.completed:.0f}} of {{task.total:.0f}} {what}")
    columns = (rich.BarColumn(), counted, rich.TextColumn("{task.fields[rate]}"))
    with rich.Progress(*columns, console=console, speed_estimate_period=_SPAN) as progress:
        task = progress.add_task(what, total=None, rate="", visible=False)
        first: tuple[float, float] | None = None

        def tell(done: float, total: float) -> None:
            nonlocal first
            now, speed = monotonic(), progress.tasks[0].speed
            first = first or (now, done)
            left = _left(now - first[0], done - first[1], total - done)
            text = f"{speed:.3g}/s" if speed else ""
            rate = f"{text}  {left and f'{left} left'}"
            progress.update(task, completed=done, total=total, rate=rate, visible=True)

        yield tell


def lines(what: str) -> Progress:
    """Return what writes on stderr how far the work is, a line in twenty seconds at most.

    The time left is counted from the first word on: what was done before, and how long kernels were
    compiled until then, says nothing of the rate.
    """
    import typer

    last = monotonic()
    first: tuple[float, float] | None = None

    def tell(done: float, total: float) -> None:
        nonlocal first, last
        now = monotonic()
        first = first or (now, done)
        if now - last < _LINES or not 0.0 < done < total:
            return
        last = now
        left = _left(now - first[0], done - first[1], total - done)
        typer.echo(f"{done:.0f} of {total:.0f} {what}{left and f', about {left} left'}", err=True)

    return tell


def _left(passed: float, done: float, rest: float) -> str:
    """The seconds that the rest takes; nothing until a part of all is done since the first word."""
    return f"{passed * rest / done:.0f} s" if done >= _SURE * (done + rest) else ""


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """Show what is done and for how long, where nothing can be counted; only on a terminal."""
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
