"""Required deflections of winds for a vehicle frozen at their flight time, with lower bounds.

Beside the requirement at each dead band stand the minimum peak of appendix C, the smallest limit
without a forecast, and eq (C8), which says where the slow mode of the flight path decides. Winds of
the same number of pieces are evaluated together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray, IndexArray
from tvclin.base.errors import InputError
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.limit import OK, PAIRED_POLES, STABLE
from tvclin.boundary.optimum.minimum_peak import minimum_peaks
from tvclin.control.laws.recoverable import RecoverableAttitudeLaw
from tvclin.flights.closed_loop.survival_limit import closed_loop_boundary
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.numerics.pieces import Pieces
from tvclin.requirement.nominal_requirement import FrozenRequirement, required_deflection
from tvclin.winds.histories import History, Piecewise

LAWS = ("bound", "flown")
"""Bases of the requirement without a forecast."""
_SAMPLE_RATE_HZ = 100.0
"""Sample rate [Hz] of flights of the recoverable-attitude law."""
_MAX_LIMIT_OVER_TRIM = 4.0
"""Largest limit of these flights over the largest trim deflection."""


def frozen_requirements(
    plants: Plant,
    winds: Sequence[History],
    dead_bands: FloatArray,
    law: str,
    two_sided: Sequence[History | None],
) -> Iterator[FrozenRequirement]:
    """Yield the requirements [rad] of winds that end, at dead bands ``(k,)``, by wind.

    Winds whose pieces have the same shape are computed together, and yielded in their order.
    `plants`: a plant, or one for each wind. With the law "bound" `no_forecast` is the bound of
    all laws without a forecast, with "flown" the smallest limit that the recoverable-attitude law
    survives with. `two_sided`: of a wind reduced to angles of one sign the entire wind, or None.
    """

    def required_together(cases: list[int]) -> dict[int, tuple[Any, list[str]]]:
        """Return required deflections [rad], ``(k,)``, and statuses of winds, by their index.

        `cases`: indices of winds with the same number of pieces, which have two signs in none or in
        all. NaN, and the message, where `InputError` is raised: a batch with a refused wind is
        computed again, wind by wind.
        """
        n, shape = len(cases), (len(cases), dead_bands.size)
        index = np.repeat(np.arange(n), dead_bands.size)  # each wind with each K, on one axis
        wind = _stacked([winds[i] for i in cases], index)
        entire = [history for i in cases if (history := two_sided[i]) is not None]
        both_signs = _stacked(entire, index) if entire else None
        plant = plants.cases(np.array(cases)[index], (len(winds),))
        try:
            limit = required_deflection(plant, wind, np.tile(dead_bands, n), two_sided=both_signs)
        except InputError as error:
            if n == 1:
                return {cases[0]: (np.nan, [str(error)])}
            return {i: required_together([i])[i] for i in cases}
        required = np.abs(np.reshape(limit.deflection, shape))
        statuses = np.reshape(limit.status, shape).tolist()
        return {i: (required[row], statuses[row]) for row, i in enumerate(cases)}

    groups: dict[Any, list[int]] = {}
    for i, (wind, both_signs) in enumerate(zip(winds, two_sided, strict=True)):
        shapes = [None if x is None else x.pieces.coefficients.shape for x in (wind, both_signs)]
        groups.setdefault(tuple(shapes), []).append(i)
    limits: dict[int, tuple[Any, list[str]]] = {}  # required deflections and statuses, by wind
    for cases in groups.values():
        limits |= required_together(cases)
    for i, wind in enumerate(winds):
        required, statuses = limits[i]
        plant = plants.case(i, (len(winds),))
        yield _with_bounds(plant, wind, dead_bands, law, required, statuses)


def _stacked(histories: Sequence[History], index: IndexArray) -> History:
    """Return the histories, with the same number of pieces, at positions `index` as a batch."""
    pieces = [history.pieces for history in histories]
    return Piecewise(
        Pieces(
            knots=np.stack([x.knots for x in pieces])[index],
            coefficients=np.stack([x.coefficients for x in pieces])[index],
            rates=np.stack([x.rates for x in pieces])[index],
        )
    )


def _with_bounds(
    plant: Plant,
    wind: History,
    dead_bands: FloatArray,
    law: str,
    limits: FloatArray | float,
    statuses: list[str],
) -> FrozenRequirement:
    """Return required deflections [rad] ``(k,)`` of a wind, with lower bounds and messages.

    `plant`: frozen at the time of the wind. `dead_bands`: K, ``(k,)``. `law`: without a forecast,
    "bound" for the lower bound of any, "flown" for the recoverable-attitude law. `limits`: required
    deflections [rad], ``(k,)``, with their `statuses`. A bound that is not defined is NaN; the
    messages hold its error, and statuses.
    """
    messages: list[str] = []

    def value_or_nan(function: Callable[[], float]) -> float:
        """Return the value of a function, or NaN and a message where it raises `InputError`."""
        try:
            return function()
        except InputError as error:
            messages.append(str(error))
            return np.nan

    minimum = value_or_nan(lambda: float(minimum_peaks(plant, wind)))
    messages.extend(status for status in statuses if status not in (OK, STABLE))
    no_forecast = np.nan
    if PAIRED_POLES in statuses:
        messages.append(
            "no lower bound without a forecast is known for two unstable poles that are a pair"
        )
    else:
        no_forecast = value_or_nan(lambda: _no_forecast(plant, wind, law))
    return FrozenRequirement(
        trim=abs(float(plant.coefficients.B * wind.peak)),
        required=np.maximum(limits, np.full(dead_bands.shape, np.nan_to_num(minimum))),
        no_forecast=no_forecast,
        minimum=minimum,
        slow_mode=slow_mode(plant, wind),
        messages=tuple(dict.fromkeys(messages)),
    )


def slow_mode(plant: Plant, wind: History) -> float:
    """Return y of eq (C8) of the report for any wind: the demand of the slow over the fast mode.

    The demand of a mode is the constant deflection that cancels the effect of the wind on it. The
    modes are those of the coefficients of `plant` with drift. The ratio is one at the edge of the
    single-pole theory, and negative where the wind drives the modes in opposite directions. NaN
    without two real unstable poles.
    """
    modes = unstable_modes(Plant.from_coefficients(plant.coefficients, "drift-exact"))
    if modes.poles.size < 2 or np.iscomplexobj(modes.poles) or not np.isfinite(wind.onset):
        return float("nan")
    from_onset = wind.shift(-wind.onset).laplace(modes.poles)
    # deflection from the onset on; in descending order of the poles
    demands = modes.poles * from_onset * modes.wind_residues / modes.deflection_residues
    fast, slow = demands[:2]
    return float(slow / fast)


def _no_forecast(plant: Plant, wind: History, law: str) -> float:
    """Return the required deflection [rad] without a forecast; zero for a stable plant.

    `law`: "bound" for the lower bound of such laws, else the limit of the law of recoverable
    attitude, flown in the wind.
    """
    if not unstable_modes(plant).poles.size:
        return 0.0
    if law == "bound":
        return abs(forecast_free_limit(plant, wind).deflection)
    flown = RecoverableAttitudeLaw(plant, design_peak=abs(float(wind.peak)))
    boundary = closed_loop_boundary(
        plant, flown, wind, sample_rate=_SAMPLE_RATE_HZ, highest=_MAX_LIMIT_OVER_TRIM
    )
    return abs(boundary.deflection)
