"""Required limit of each law in flight over the rate limit, with the lower bound of theory.

The required rate of one law with a given limit is the other coordinate of a point of this curve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import derived, spec
from tvclin.base.lines import Line, Table, degrees
from tvclin.boundary.limit_over_rate import RateTradeOff, rate_trade_off
from tvclin.case.case import Case
from tvclin.case.flexible_autopilot import specified_law
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import LAWS
from tvclin.flights.closed_loop.fly_many import SURVIVED, fly_many
from tvclin.flights.closed_loop.survival_limit import (
    ABOVE,
    LEVELS,
    PARTS,
    STEPS,
    ClosedLoopBoundary,
    closed_loop_boundary,
    limits_above_losses,
)

_STOP_WORDS = ("no sudden stop of it", "a sudden stop in its middle")
"""Words for the sudden stops of a wind, for none and one."""
_MAX_LIMIT_TRIM_RATIO = 3.0
"""Largest limit that is tried, over the largest trim deflection."""
_MAX_SAMPLES = 2e9
"""Largest number of samples of all flights of a call; some minutes as machine code."""
_MINIMUM_RATE_RATIOS = np.array([1.25, 2.0, 3.0, 5.0, 10.0, 20.0])
"""Default rate limits over the minimum rate of theory."""


@dataclass(frozen=True, eq=False)
class FlownTradeOff(Shown):
    """Required limits of laws in one case over the rate limit, flown with `cuts` sudden stops.

    `minimum` is that of theory at the same rates, with the nozzle's point. `limits` are the
    minimum deflection limits [rad] of each law at each rate limit, ``(n,)``, infinite where none
    survives up to three times the largest trim deflection; `monotone` is whether every limit that
    was tried above one that survives survives as well. `unknown_wind`: why parts of the wind are
    not known, in words; empty where it is known.
    """

    minimum: RateTradeOff = field(
        metadata=spec("angular rate", name="rates", of="minimum.rates", card=False)
    )
    limits: dict[str, FloatArray] = field(metadata=spec("angle", card=False))
    monotone: dict[str, BoolArray] = field(metadata=spec(card=False))
    cuts: int = field(metadata=spec())
    unknown_wind: str = ""

    @property
    @derived("angle")
    def required(self) -> dict[str, float] | None:
        """Limit [rad] of each law at the rate limit of the nozzle; None if not among `rates`.

        `minimum` has the rates [rad/s], and the nozzle's rate limit; `limits` is by law and rate.
        """
        at_rate = np.flatnonzero(self.minimum.rates == self.minimum.rate_limit)
        if not at_rate.size:
            return None
        return {name: float(values[at_rate[0]]) for name, values in self.limits.items()}

    @property
    @derived()
    def survives(self) -> dict[str, bool] | None:
        """Whether each law survives with the nozzle; None without its limits, or if not known."""
        required, limit = self.required, self.minimum.limit
        if required is None or limit is None or self.minimum.beyond_linear:
            return None
        survived = {name: limit >= value for name, value in required.items()}
        # a law that survives the known part of the wind may be lost in the rest
        return None if self.unknown_wind and any(survived.values()) else survived

    def tables(self) -> tuple[Table, ...]:
        """Return the limit of each law at each rate, with the bound without a forecast."""
        bounds, rates = self.minimum.no_forecast_bounds, self.minimum.rates
        lower = {} if bounds is None else {"any law, at least": bounds}
        rows: list[tuple[Line, ...]] = []
        for k, rate in enumerate(rates):
            cells = [degrees(f"laws.{k}.rate", rate)]
            for name, values in (self.limits | lower).items():
                shown = degrees(f"laws.{k}.{name}", values[k])
                # a star where some lower limits survive as well
                odd = name in self.monotone and not self.monotone[name][k]
                star = ("*",) if odd else ()
                cells.append((*shown, *star) if np.isfinite(values[k]) else ("none",))
            rows.append(tuple(cells))
        caption = "Required deflection limit of each law in flight [deg]"
        head = ("rate limit [deg/s]", *self.limits, *lower)
        return (Table(caption, head, tuple(rows)),)

    @property
    def notes(self) -> Iterator[str]:
        """Notes on the flights of the table.

        `cuts`: number of sudden ends of the wind at which a law is flown as well. `survives`:
        whether each law does with the nozzle, None if not known. `monotone`: whether every limit
        tried below a boundary is lost.
        """
        stops = f"{self.cuts} sudden stops of it" if self.cuts > 1 else _STOP_WORDS[self.cuts]
        yield (
            f"laws fly the whole wind, and {stops}; trim and recoverable-attitude are designed anew"
            " for each rate limit; none: with no limit a flight survives up to three times the"
            " largest trim deflection"
        )
        if self.unknown_wind and self.survives is None:
            yield f"survival is not known: {self.unknown_wind}"
        if not all(np.all(monotone) for monotone in self.monotone.values()):
            yield "*: some lower limits survive as well; above this one all that were tried survive"


def flown_trade_offs(
    cases: Mapping[str, Case],
    rates: ArrayLike | None = None,
    *,
    laws: tuple[str, ...] = tuple(LAWS),
    cuts: int = 1,
    progress: Callable[[float, float], None] | None = None,
) -> dict[str, FlownTradeOff]:
    """Return the required deflection limit of laws over the rate limit, by case.

    Parameters
    ----------
    cases : mapping of str to Case
        Cases by name, such as a vehicle at several times of its flight, or in several winds.
        Actuator, sample rate, delay, gains and filters are from the case; the rate limit of its
        nozzle is flown as well.
    rates : array_like, optional
        Rate limits [rad/s], ``(n,)``; by default 1.25 to 20 times the minimum rate of each case.
    laws : tuple of str
        Names of the registry, all by default. Each is designed for the rate limit.
    cuts : int
        Number of sudden ends of the wind that are flown as well, see `closed_loop_boundary`; a
        single one is at the peak of a triangle.
    progress : callable, optional
        Called with the number of finished boundaries, in fractions too, and of all boundaries.

    Raises
    ------
    InputError
        For unknown names, and flights of more than 2e9 samples in all; also the exceptions of
        `rate_trade_off` and `closed_loop_boundary`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> nozzle = tv.Nozzle(limit=np.radians(0.36), rate_limit=np.radians(0.5))
    >>> case = tv.Case(vehicle=tv.load_vehicle("configuration-i"), nozzle=nozzle)
    >>> laws = ("half-relief", "trim", "recoverable-attitude")
    >>> found = tv.nozzle.flown_trade_offs({"a triangle": case}, [nozzle.rate_limit], laws=laws)
    >>> found["a triangle"].survives
    {'half-relief': False, 'trim': True, 'recoverable-attitude': True}
    """
    if progress is not None:
        errors.callable_for("progress", progress, "of how many are done and how many there are")
    errors.instance("cases", cases, Mapping, "by name")
    errors.each("cases", tuple(cases.values()), Case, "by name")
    names = tuple(errors.one_of("laws", name, LAWS) for name in errors.different("laws", laws))
    errors.within("cuts", errors.whole_number("cuts", cuts), 0, 1000)
    minima = {key: _minimum(case, rates) for key, case in cases.items()}
    _check_samples(cases, minima, len(names) * (cuts + 1))
    flights = [(key, name, float(r)) for key in cases for name in names for r in minima[key].rates]

    def report(finished: int, winds: int, total_winds: int) -> None:
        """Report progress: `finished` boundaries, and `winds` of `total_winds` of the next one."""
        if progress is not None:
            progress(finished + winds / total_winds, len(flights))

    boundaries: dict[str, dict[str, list[ClosedLoopBoundary]]]
    boundaries = {key: {name: [] for name in names} for key in cases}
    for finished, (key, name, rate) in enumerate(flights):
        case = cases[key]
        boundary = closed_loop_boundary(
            case.plant,
            specified_law(case, name, rate),
            case.history,
            **case.hardware | {"rate_limit": rate},
            cuts=cuts,
            highest=_MAX_LIMIT_TRIM_RATIO,
            progress=partial(report, finished),
        )
        boundaries[key][name].append(boundary)
        report(finished, 1, 1)
    return {
        key: FlownTradeOff(
            minimum=minima[key],
            limits={name: np.abs([x.deflection for x in row]) for name, row in by_law.items()},
            monotone={name: np.array([x.monotone for x in row]) for name, row in by_law.items()},
            cuts=cuts,
            unknown_wind=cases[key].unknown_wind,
        )
        for key, by_law in boundaries.items()
    }


def _check_samples(
    cases: Mapping[str, Case], minima: Mapping[str, RateTradeOff], winds: int
) -> None:
    """Raise `InputError` for too many samples of all flights.

    `cases`, `minima`: cases and their trade-off curves of theory by name. `winds`: number of laws
    times winds, complete and with sudden ends, of a case at each rate limit; each is flown with all
    deflection limits of `closed_loop_boundary`, and for its whole duration.
    """
    # Limits of the scan, and of the finer steps above an edge of losses.
    limits = STEPS + 1 + LEVELS * ABOVE * PARTS
    samples = 0.0
    for key, case in cases.items():
        span = float(case.history.end) - float(case.history.onset)
        samples += winds * minima[key].rates.size * limits * span * case.hardware["sample_rate"]
    if samples > _MAX_SAMPLES:
        raise errors.InputError(
            f"flights of laws may have at most {_MAX_SAMPLES:.3g} samples in all, and these may"
            f" have {samples:.3g}: take a lower sample rate, a shorter wind, fewer laws or fewer"
            " rates"
        )


def _minimum(case: Case, rates: ArrayLike | None) -> RateTradeOff:
    """Return the trade-off of limit over rate limit of a case by theory, at `rates` [rad/s].

    It is the deflection limit that a control which knows the wind requires at each rate limit. The
    rate limit of the case's nozzle is added. Without `rates` they are 1.25 to 20 times the rate
    that must be exceeded with any deflection limit, or else the required rate.
    """
    nozzle, plant, wind = case.nozzle, case.plant.rigid, case.history
    theory = partial(rate_trade_off, plant, wind, limit=nozzle.limit, rate_limit=nozzle.rate_limit)
    if rates is None:
        usual = theory()
        minimum_rate = usual.minimum_rate or usual.required_rate
        rates = _MINIMUM_RATE_RATIOS * minimum_rate if minimum_rate > 0.0 else usual.rates
    if nozzle.rate_limit is not None:
        rates = np.unique(np.append(rates, nozzle.rate_limit))
    return theory(rates)


_RATE_RANGE = (1e-3, 2.0)
"""Smallest and largest rate limit that is tried, over the peak rate without a rate limit."""


def flown_required_rate(case: Case, law: Law) -> float:
    """Return the smallest rate limit [rad/s] from which on a law survives with every one, flown.

    The deflection limit is that of the case. Rate limits are tried from a thousandth to twice the
    peak rate of the nozzle without a rate limit, in steps of 2 percent, and of 0.02 percent at the
    highest loss.

    Parameters
    ----------
    case : Case
        Vehicle, wind and nozzle with a deflection limit; also actuator, sample rate and delay of
        the flights, which are at nominal dynamic pressure. Its rate limit does not count.
    law : Law
        Law as designed; it is not designed anew for each rate limit.

    Returns
    -------
    float
        The required rate; infinite where the law does not survive without a rate limit, or the
        nozzle then keeps oscillating.

    Raises
    ------
    InputError
        For a nozzle without a deflection limit; also the exceptions of `fly_many`.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> nozzle = tv.Nozzle(limit=np.radians(0.8))
    >>> case = tv.Case(vehicle=tv.load_vehicle("configuration-i"), nozzle=nozzle)
    >>> law = tv.SaturatedLaw.of(case.autopilot)
    >>> f"{np.degrees(tv.nozzle.flown_required_rate(case, law)):.2f} deg/s"
    '0.31 deg/s'
    """
    errors.instance("case", case, Case, "of a vehicle, a wind and a nozzle")
    errors.instance("law", law, Law, "such as SaturatedLaw")
    if case.nozzle.limit is None:
        raise errors.InputError("the required rate of a law needs a nozzle with a limit; got none")
    hardware = {**case.hardware, "deflection_limit": case.nozzle.limit}

    def lost(rates: ArrayLike) -> BoolArray:
        """Return whether flights of the `law` with rate limits [rad/s] are not survived."""
        flights = fly_many(case.plant, law, case.history, **{**hardware, "rate_limit": rates})
        return flights.status != SURVIVED

    free = fly_many(case.plant, law, case.history, **{**hardware, "rate_limit": np.inf})
    if free.status != SURVIVED:
        return np.inf
    low, high = (ratio * np.atleast_1d(free.peak_deflection_rate) for ratio in _RATE_RANGE)
    rates, never = limits_above_losses(lost, low, high)
    return float(np.inf if never[0] else rates[0])
