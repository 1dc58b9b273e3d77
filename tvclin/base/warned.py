"""What the package warns of, each sentence once, and no warning of the packages below it."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

COMPILED = "a kernel was compiled"
"""How the warning of a long compilation begins: it is of the machine, and not of an answer."""


@contextmanager
def warned(say: Callable[[str], object]) -> Iterator[None]:
    """Hand each sentence that is warned of meanwhile to `say`, once.

    The warnings of this package are plain `UserWarning`. Those of other kinds, deprecations above
    all, are of what other packages do, and for their authors.
    """
    said: set[str] = set()

    def show(message: Warning | str, category: type[Warning], *_: object, **__: object) -> None:
        if category is UserWarning and str(message) not in said:
            said.add(str(message))
            say(str(message))

    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = show
        yield
