"""What ends a call that never would, whoever made the call: no measure of how fast it is."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from types import FrameType
from typing import Any

THERE = hasattr(signal, "SIGPROF")
"""Whether the system has timers of POSIX."""


_ENDLESS = 600.0
"""Seconds of processor time that nothing takes on the busiest machine; the slowest good call takes
two, and plain Python a hundred. How much a call may ask for is bounded at its door, in counts."""


class Endless(BaseException):
    """What nothing that is called may catch."""


@contextmanager
def ending() -> Iterator[None]:
    """Raise `Endless` where a call does not end; to compile a kernel does not count."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise Endless(f"more than {_ENDLESS} s")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, _ENDLESS)
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
