"""What a long command shows on a terminal while it works: a bar with the time left."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

Progress = Callable[[int, int], None]
"""Is told how much is done, and how much there is."""
_SPAN = 3600.0
"""Seconds over which a rate is taken: slow work may tell of nothing for minutes."""


@contextmanager
def bar(what: str) -> Iterator[Progress | None]:
    """Lend what shows a bar with rate and time left; None where standard error is no terminal.

    Parameters
    ----------
    what : str
        What is counted: "cases".
    """
    from rich import progress as rich
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    counted = rich.TextColumn(f"{{task.completed:.0f}} of {{task.total:.0f}} {what}")
    rate, left = rich.TextColumn("{task.fields[rate]}"), rich.TimeRemainingColumn()
    columns = (rich.BarColumn(), counted, rate, left)
    with rich.Progress(*columns, console=console, speed_estimate_period=_SPAN) as progress:
        task = progress.add_task(what, total=None, rate="", visible=False)

        def tell(done: int, total: int) -> None:
            speed = progress.tasks[0].speed
            text = f"{speed:.3g}/s" if speed else ""
            progress.update(task, completed=done, total=total, rate=text, visible=True)

        yield tell


def share(progress: Progress | None, part: int, parts: int) -> Progress | None:
    """Return what one of several equal parts of the work is to tell; parts count from zero."""
    if progress is None:
        return None
    return lambda done, total: progress(part * total + done, parts * total)


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """Show what is done and for how long, where nothing can be counted; only on a terminal."""
    from rich import progress as rich
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield
        return
    shown = (rich.SpinnerColumn(), rich.TextColumn("{task.description}"), rich.TimeElapsedColumn())
    with rich.Progress(*shown, console=console, transient=True) as progress:
        progress.add_task(what, total=None)
        yield
