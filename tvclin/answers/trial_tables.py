"""Tables of trials of laws: required limit of each law in each wind, and bounds of every law."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tvclin.answers.trials import LawTrial
from tvclin.base.errors import InputError
from tvclin.base.lines import Line, Table, number
from tvclin.base.quantities import WIND_KNOWN
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.flights.closed_loop.survival_limit import ABOVE, ALWAYS, NEVER, OK, PARTS, STEPS
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

LEGEND = (
    "Any law: lower bound for all laws without a forecast that also survive if the wind stops for"
    " good at any instant; - where the wind changes its sign."
)


class Bounds(NamedTuple):
    """Bounds of all laws in a wind: its trim [deg], and two lower bounds normalised by that.

    NaN where one is not defined.
    """

    trim_deg: float
    no_forecast: float
    minimum: float


def bounds(plant: Plant, winds: Mapping[str, History]) -> dict[str, Bounds]:
    """Return the bounds of every law in each wind, without a forecast and with the wind known."""

    def of(wind: History) -> Bounds:
        trim = abs(float(plant.coefficients.B * wind.peak))
        peak = _defined(lambda: optimum_deflection(plant, wind, min(0.0, float(wind.onset))).peak)
        free = _defined(lambda: float(forecast_free_limit(plant, wind).limit))
        return Bounds(float(np.degrees(trim)), free, peak / trim if trim else np.nan)

    return {name: of(wind) for name, wind in winds.items()}


def needed(found: Sequence[LawTrial], beside: Mapping[str, Bounds]) -> tuple[Table, ...]:
    """Return the required limit of each law in each wind, and the bounds of every law."""
    laws = tuple(dict.fromkeys(one.law for one in found))
    trials = {(one.wind, one.law): one for one in found}
    head = ("wind", *(law.replace("-", " ") for law in laws), "any law")

    def rows(unit: str, scales: Mapping[str, float]) -> Iterator[tuple[Line, ...]]:
        for j, (wind, one) in enumerate(beside.items()):
            scale, key = scales[wind], f"laws.{j}"
            cells = [_limit(f"{key}.{law}{unit}", trials[wind, law], scale) for law in laws]
            yield ((wind,), *cells, number(f"{key}.any{unit}", scale * one.no_forecast))

    def bounded() -> Iterator[tuple[Line, ...]]:
        for j, (wind, (trim, _, minimum)) in enumerate(beside.items()):
            known = number(f"laws.{j}.minimum_deg", trim * minimum)
            over = number(f"laws.{j}.minimum", minimum)
            yield (wind,), number(f"laws.{j}.ideal_deg", trim), known, over

    trims = {wind: one.trim_deg for wind, one in beside.items()}
    beyond = ("wind", "trim in that wind [deg]", f"{WIND_KNOWN} [deg]", "over trim")
    return (
        Table("Deflection limit that each law needs [deg]", head, tuple(rows("_deg", trims))),
        Table("The same over trim in that wind", head, tuple(rows("", dict.fromkeys(trims, 1.0)))),
        Table("Trim in each wind, and the minimum of any control", beyond, tuple(bounded())),
    )


def loads(found: Sequence[LawTrial]) -> Table:
    """Return the largest angle of attack and attitude of each law in each wind."""
    laws = tuple(dict.fromkeys(one.law for one in found))
    winds = dict.fromkeys(one.wind for one in found)
    trials = {(one.wind, one.law): one for one in found}
    rows = tuple(((wind,), *(_loads(trials[wind, law]) for law in laws)) for wind in winds)
    caption = "Largest angle of attack / attitude over the wind, with 1.2 times that limit"
    return Table(caption, ("wind", *(law.replace("-", " ") for law in laws)), rows)


def tried(found: Sequence[LawTrial]) -> str:
    """Return which limits were tried, in sentences."""
    one = found[0]
    step = (one.highest - one.lowest) / STEPS
    return (
        f"Tried: limits from {one.lowest:g} to {one.highest:g} of ideal trim in steps of"
        f" {step:.2g}, and for {ABOVE * step:.2g} above each edge in steps of {step / PARTS:.2g},"
        " finer still near the edge. A narrower range of lost limits would not be seen."
    )


def doubts(found: Sequence[LawTrial]) -> list[str]:
    """Return the meaning of the marks of limits, with their laws and winds."""
    odd = [f'!: "{one.law}" in "{one.wind}": {one.status}' for one in found if _doubtful(one)]
    again = ", ".join(f'"{one.law}" in "{one.wind}"' for one in found if not one.monotone)
    said = "some lower limits survive as well; above this one all that were tried survive"
    return [*odd, f"*: {said}: {again}"] if again else odd


def _limit(key: str, one: LawTrial, scale: float) -> Line:
    """Return the boundary times a scale, or the end of the range of limits that it is beyond."""
    shown = number(key, scale * one.limit)
    if one.limit > one.highest:
        shown = (f">{scale * one.highest:.4g}",)
    elif one.limit <= one.lowest:
        shown = (f"<{scale * one.lowest:.4g}",)
    mark = ("" if one.monotone else "*") + ("!" if _doubtful(one) else "")
    return (*shown, mark) if mark else shown


def _loads(one: LawTrial) -> Line:
    if one.limit > one.highest:
        return ("-",)
    key = f"loads.{one.wind}.{one.law}"
    angle = number(f"{key}.angle_of_attack", one.peak_angle_of_attack, 2)
    return (*angle, "/", *number(f"{key}.attitude", one.peak_attitude, 2))


def _doubtful(one: LawTrial) -> bool:
    """Return whether the status of a boundary needs a note below the table."""
    return one.status not in (OK, NEVER, ALWAYS)


def _defined(value: Callable[[], float]) -> float:
    try:
        return value()
    except InputError:
        return float("nan")
