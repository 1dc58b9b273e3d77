"""What the package warns of, each sentence once, and no warning of the packages below it."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class MachineWarning(UserWarning):
    """A warning of the machine that computes: a kernel is compiled, or numba is missing.

    It concerns the time of an answer and not its numbers, so that no page and no notes have it.
    """


@contextmanager
def warned(
    say: Callable[[str], object], machine: Callable[[str], object] | None = None
) -> Iterator[None]:
    """Hand each sentence that is warned of meanwhile to `say`, once.

    `machine`: receives the sentences of `MachineWarning`; without it they are passed to whoever
    handles warnings outside. Other warnings of this package are plain `UserWarning`; those of all
    other kinds, deprecations above all, are of what other packages do, and for their authors.
    """
    said: set[str] = set()
    outside = warnings.showwarning
    receivers = {UserWarning: say, MachineWarning: machine}

    def show(
        message: Warning | str, category: type[Warning], *rest: object, **more: object
    ) -> None:
        if category not in receivers or str(message) in said:
            return
        said.add(str(message))
        receiver = receivers[category]
        if receiver is None:
            outside(message, category, *rest, **more)  # type: ignore[arg-type]
        else:
            receiver(str(message))

    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = show
        yield
