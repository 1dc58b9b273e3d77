"""Warnings of this package: of its computations, each once, and on implausible input."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class MachineWarning(UserWarning):
    """Warning about the computer: a kernel is compiled, or numba is missing.

    It concerns the time of an answer and not its numbers, so that pages and notes omit it.
    """


class ImplausibleInput(str):
    """Note on an implausible number of the input, which answers print before all other notes."""


@contextmanager
def pass_warnings(
    say: Callable[[str], object], machine: Callable[[str], object] | None = None
) -> Iterator[None]:
    """Pass each warning of this package that is raised inside to `say`, each sentence once.

    `machine`: receives the sentences of `MachineWarning`; by default they go to the outer handler
    of warnings. Other warnings of this package are plain `UserWarning`; other categories,
    deprecations above all, concern other packages.
    """
    said: set[str] = set()
    outside = warnings.showwarning
    receivers = {UserWarning: say, MachineWarning: machine}

    def show(
        message: Warning | str, category: type[Warning], *rest: object, **more: object
    ) -> None:
        """Pass a warning of the package to the receiver of its `category`, each message once.

        `rest`, `more`: file and line, which only the outer handler of warnings gets.
        """
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
