"""The first answer: how much deflection covers a dispersed vehicle, in seconds, without a file."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.boundary import boundary_limit
from tvclin.campaign.dispersions import DEFAULT_DISPERSIONS, WIND, Dispersions
from tvclin.campaign.draws import draw
from tvclin.campaign.statistics import (
    Quantile,
    Success,
    quantile_bound,
    sensitivities,
    success_probability,
)
from tvclin.errors import InputError, whole_number
from tvclin.plant import Plant
from tvclin.study import SHAPES, Study

FloatArray = NDArray[np.float64]

OK, IMPOSSIBLE, STABLE = "ok", "impossible vehicle", "no unstable pole"


@dataclass(frozen=True, eq=False)
class DispersedStudy:
    """A study with its vehicle and wind dispersed.

    Attributes
    ----------
    nominal : Study
        The study itself.
    dispersions : Dispersions
        What was uncertain.
    seed : int
        Case i is drawn from the seed and i alone.
    values : dict of str to ndarray
        Dispersed parameters [SI], ``(n,)`` each.
    deflection : ndarray
        Required deflection [rad] of each case at the model and dead band of the study, ``(n,)``;
        NaN where there is none.
    status : ndarray of str
        Of each case: "ok", "no unstable pole" (nothing is needed) or "impossible vehicle".
    required : Quantile
        The deflection [rad] that covers the probability asked for.
    success : Success or None
        How probable the limit of the study is enough.
    drivers : dict of str to float
        Rank correlation of each parameter with the required deflection, the strongest first.
    """

    nominal: Study
    dispersions: Dispersions
    seed: int
    values: dict[str, FloatArray]
    deflection: FloatArray
    status: NDArray[Any]
    required: Quantile
    success: Success | None
    drivers: dict[str, float]


def disperse_study(
    study: Study,
    dispersions: Dispersions = DEFAULT_DISPERSIONS,
    *,
    cases: int = 2000,
    seed: int = 0,
    probability: float = 0.99865,
    confidence: float = 0.9,
    method: str = "plain",
) -> DispersedStudy:
    """Return the deflection that covers a dispersed vehicle in a dispersed wind.

    Parameters
    ----------
    study : Study
        The nominal vehicle, wind, model and dead band, and the limit in question.
    dispersions : Dispersions
        What is uncertain; the default ones are assumed, not any programme's.
    cases : int
        How many.
    seed : int
        Of the random numbers.
    probability, confidence : float
        Of the deflection asked for, as of `quantile_bound`.
    method : {"plain", "sobol", "latin"}
        As of `draw`. Order statistics hold for plain numbers; the others converge faster, and
        their bounds are on the safe side.

    Raises
    ------
    InputError
        For numbers out of range, and when no case is possible.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> nominal = tv.Study.from_vehicle(
    ...     tv.load_vehicle("configuration-i"), duration=7.5, peak=np.radians(5)
    ... )
    >>> found = tv.disperse_study(nominal, cases=2000, seed=1)
    >>> bool(found.required.upper > nominal.required_deflection)
    True
    """
    if whole_number("cases", cases) == 0:
        raise InputError("cases must be one or more; got 0")
    numbers = draw(seed, 0, cases, len(dispersions.each), method=method, size=cases)
    vehicle, wind = study.vehicle, study.wind
    nominal = {**vars(vehicle), "wind_peak": wind.peak, "wind_duration": wind.duration}
    nominal["control_force_slope"] = vehicle.control_force
    dispersed = dispersions.apply(nominal, numbers)
    good = dispersed.possible
    if not np.any(good):
        raise InputError("no case is possible: the dispersions turn the sign of a parameter")
    deflection = np.full(cases, np.nan)
    deflection[good], unstable = _required(study, dispersed.values, good)
    status = np.where(good, OK, IMPOSSIBLE)
    status[np.flatnonzero(good)[~unstable]] = STABLE
    counted = deflection[good]
    limit = study.limit
    return DispersedStudy(
        nominal=study,
        dispersions=dispersions,
        seed=int(seed),
        values=dispersed.values,
        deflection=deflection,
        status=status,
        required=quantile_bound(counted, probability, confidence),
        success=None
        if limit is None
        else success_probability(int(np.sum(counted <= limit)), counted.size, confidence),
        drivers=sensitivities({k: v[good] for k, v in dispersed.values.items()}, counted),
    )


def _required(
    study: Study, values: dict[str, FloatArray], good: NDArray[np.bool_]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The required deflections [rad], and which cases have an unstable pole."""
    changes = {name: value[good] for name, value in values.items() if name not in WIND}
    vehicle = study.vehicle.replace(**changes) if changes else study.vehicle
    plant = Plant.from_vehicle(vehicle, study.model, study.plane)
    shape = next(kind for kind in SHAPES.values() if isinstance(study.wind, kind))  # type: ignore[arg-type]
    wind = shape(
        peak=values["wind_peak"][good] if "wind_peak" in values else study.wind.peak,
        duration=values["wind_duration"][good]
        if "wind_duration" in values
        else study.wind.duration,
    )
    found = boundary_limit(plant, wind, study.dead_band)
    count = int(good.sum())
    deflection = np.broadcast_to(np.abs(found.deflection), (count,))
    unstable = np.broadcast_to(np.asarray(plant.coefficients.mu_alpha) > 0.0, (count,))
    return np.nan_to_num(deflection, nan=0.0), unstable
