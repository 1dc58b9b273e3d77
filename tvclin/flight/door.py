"""What every flight is refused for, whichever engine flies it."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.errors import InputError, finite, instance
from tvclin.histories import History

FloatArray = NDArray[np.float64]


def flight_times(timepts: ArrayLike) -> FloatArray:
    """Return one row of times [s]; `InputError` for anything else."""
    times = finite("timepts", timepts, "s")
    if times.ndim != 1 or not times.size:
        raise InputError(f"timepts must be one row of times; got an array of shape {times.shape}")
    return times


def check_one(name: str, history: object, start: float) -> None:
    """Raise `InputError` unless this is one history that begins with the flight [s] or later."""
    instance(name, history, History, "such as TriangularWind")
    assert isinstance(history, History)
    if history.batch:
        raise InputError(f"{name} must be one history; got a batch of shape {history.batch}")
    if history.onset < start:
        raise InputError(
            f"{name} must not begin before the flight, at {start:.6g} s; got {name} from"
            f" {float(history.onset):.6g} s on"
        )


def check_frozen(frozen: bool, condition: object) -> None:
    """Raise `InputError` unless parameters are frozen, or vary in a condition."""
    if bool(frozen) == (condition is not None):
        raise InputError(
            "condition must be given exactly when parameters are not frozen (frozen=False)"
        )
