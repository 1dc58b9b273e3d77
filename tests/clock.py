"""A bound of processor time for one call, whoever made the call."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from types import FrameType
from typing import Any

THERE = hasattr(signal, "SIGPROF")
"""Whether the system has timers of POSIX."""


class TooSlow(BaseException):
    """What nothing that is called may catch."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Raise `TooSlow` when a call takes longer; to compile a kernel does not count."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise TooSlow(f"more than {seconds} s")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        with _compiling_apart():
            yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@contextmanager
def _compiling_apart() -> Iterator[None]:
    """Let the clock stand while numba compiles, which it tells."""
    if find_spec("numba") is None:
        yield
        return
    from numba.core import event

    class Pause(event.Listener):
        depth, left = 0, 0.0

        def on_start(self, event: Any) -> None:
            if not self.depth:
                self.left, _ = signal.setitimer(signal.ITIMER_PROF, 0.0)
            self.depth += 1

        def on_end(self, event: Any) -> None:
            self.depth -= 1
            if not self.depth:
                signal.setitimer(signal.ITIMER_PROF, self.left)

    with event.install_listener("numba:compile", Pause()):
        yield
