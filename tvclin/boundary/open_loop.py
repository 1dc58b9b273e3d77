"""Requirements of a deflection limit that follow from open-loop controls, without a flight.

The boundary limit y_BR of eq (4b) is one of them, and not always the largest:

- the boundary of the control with the exit on trim, as in a flight;
- the minimum peak over all unstable poles, appendix C, from the onset of the wind on;
- for K = 1 the bound of all laws without a forecast of the wind;
- for 0 < K < 1 the minimum peak from the state on that trim up to K times the limit has left.
"""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.boundary.after_trim import limit_after_trim
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.limit import OK, BoundaryLimit, boundary_limit, leading_pole
from tvclin.boundary.optimum.least_peaks import least_peaks
from tvclin.boundary.switching import Problem
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

ROUNDING = 1e-9
"""Relative difference up to which two requirements count as equal."""


class Reason(StrEnum):
    """Requirement that sets the required deflection at nominal dynamic pressure, as text."""

    BOUNDARY = "the boundary of the control with the exit on trim"
    MINIMUM = "the minimum over all unstable poles"
    AFTER_TRIM = "the minimum over all unstable poles after trim"
    NO_FORECAST = "the bound without a forecast"
    TRIM_LAW = "the trim law flown"
    ONE_PLANE = "the plane that needs the larger part of the stop"
    BOTH_PLANES = "the boundary of both planes together"
    NOTHING = "nothing"

    def __repr__(self) -> str:
        return repr(self.value)

    @property
    def larger(self) -> str:
        """Sentence that this requirement is larger than the boundary limit."""
        if self is Reason.BOUNDARY:
            return "in flight, where the dead band is left by trim itself, more is needed"
        return f"{self} is larger"


def open_loop_requirements(
    plant: Plant,
    wind: History,
    dead_band: ArrayLike,
    boundary: BoundaryLimit,
    sufficient: FloatArray | None = None,
) -> dict[Reason, FloatArray]:
    """Return the requirements of a deflection limit by name, sizes [rad] of shape ``(...)``.

    Parameters
    ----------
    plant, wind, dead_band
        Same parameters as `boundary_limit`.
    boundary : BoundaryLimit
        The boundary limit of these with the literal switch, as in a flight.
    sufficient : ndarray, optional
        Peaks [rad] in place of the minimum where they are proved to be no less, see `least_peaks`.

    Returns
    -------
    dict of Reason to ndarray
        The boundary, the minimum, the bound without a forecast (for K = 1) and the minimum after
        trim (for 0 < K < 1); zero where one does not apply.
    """
    K = np.asarray(dead_band)
    size = np.abs(np.asarray(boundary.deflection))
    free = (
        np.abs(np.asarray(forecast_free_limit(plant, wind).deflection))
        if np.any(K == 1.0) and _has_bound(plant)
        else 0.0
    )
    required = {
        Reason.BOUNDARY: size,
        Reason.MINIMUM: np.broadcast_to(least_peaks(plant, wind, sufficient), size.shape),
        Reason.NO_FORECAST: np.broadcast_to(
            np.where(K == 1.0, np.nan_to_num(free), 0.0), size.shape
        ),
    }
    largest = np.max(list(required.values()), axis=0)
    return required | {Reason.AFTER_TRIM: _after_trim(plant, wind, K, largest)}


def with_larger_requirements(
    plant: Plant, wind: History, dead_band: ArrayLike, boundary: BoundaryLimit
) -> BoundaryLimit:
    """Return boundary limits ``(...)`` whose status names the open-loop requirement above them.

    Parameters
    ----------
    plant, wind, dead_band
        Same parameters as `boundary_limit`.
    boundary : BoundaryLimit
        The boundary limit of these, with either switch.
    """
    literal = boundary_limit(plant, wind, dead_band, "literal")
    size, status = np.abs(np.asarray(boundary.deflection)), np.asarray(boundary.status)
    required = open_loop_requirements(plant, wind, dead_band, literal, size)
    largest = np.max(list(required.values()), axis=0)
    larger = largest > size * (1.0 + ROUNDING)
    if not np.any(larger):
        return boundary
    governs = [(sizes >= largest)[larger] for sizes in required.values()]
    words, reasons = np.select(governs, [reason.larger for reason in required], ""), status[larger]
    combined = np.where(reasons == OK, words, np.char.add(np.char.add(reasons, "; "), words))
    status = status.astype(np.result_type(status, combined))
    status[larger] = combined
    return replace(boundary, status=status if status.ndim else str(status))


def _after_trim(plant: Plant, wind: History, K: FloatArray, smallest: FloatArray) -> FloatArray:
    """Return the largest limit [rad] that diverges after trim up to K times it, else 0.

    Limits up to `smallest` [rad] count as zero.
    """
    poles = unstable_poles(plant)
    if poles.shape[-1] < 2 or not np.any((K > 0.0) & (K < 1.0)):
        return np.zeros(smallest.shape)
    pole, paired = leading_pole(plant)
    problem = Problem(plant, wind, pole, np.where(paired, 1.0, K), smallest.shape)
    full = np.abs(np.asarray(plant.coefficients.B) * wind.peak)
    with np.errstate(divide="ignore", invalid="ignore"):  # no moment, nothing to trim
        lower = smallest / full
    limit = limit_after_trim(problem, poles, lower)
    return np.where(limit > lower, limit * full, 0.0)


def _has_bound(plant: Plant) -> bool:
    """Return whether there is a bound without a forecast: the fastest pole of a plant is real."""
    poles = unstable_poles(plant)
    return bool(plant.batch) or (poles.size > 0 and np.imag(poles[0]) == 0.0)
