"""What every flight is refused for, whichever engine flies it."""

from tvclin.base.errors import (
    InputError,
    flag,
    instance,
    single,
)
from tvclin.winds.histories import History


def check_one(name: str, history: object, start: float) -> None:
    """Raise `InputError` unless this is one history that begins with the flight [s] or later."""
    instance(name, history, History, "such as TriangularWind")
    assert isinstance(history, History)
    single(name, history.batch)
    if history.onset < start:
        raise InputError(
            f"{name} must not begin before the flight, at {start:.6g} s; got {name} from"
            f" {float(history.onset):.6g} s on"
        )


def check_frozen(frozen: bool, condition: object) -> None:
    """Raise `InputError` unless parameters are frozen, or vary in a condition."""
    if flag("frozen", frozen) == (condition is not None):
        raise InputError(
            "condition must be given exactly when parameters are not frozen (frozen=False)"
        )
