"""The controllability ratio: the deflection limit over the deflection that trim takes.

    ratio = limit/(nominal + trim + sqrt(gust^2 + thrust offset^2 + offset of centre of gravity^2))

Design rules keep it above 2 where possible, and above 1 always.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, instance, limit_angle, small_angle
from tvclin.base.fields import Field, derived, spec, specs
from tvclin.base.lines import Line, Table, degrees, significant
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.flight.total import (
    HEAD,
    SAME,
    SUMS,
    DeflectionTotal,
    at_time,
    flight_end,
    rows_of,
    total_deflection,
)
from tvclin.requirement.flight.total import Line as Part
from tvclin.requirement.required_quantity import TRIM
from tvclin.vehicle.coefficients import BOTH, PLANES, Coefficients

GOAL, LEAST = 2.0, 1.0
"""Values that the ratio should exceed, and that it must exceed."""


@dataclass(frozen=True)
class ControllabilityRatio(Shown):
    """The least controllability ratio over a flight.

    Attributes
    ----------
    takes : DeflectionTotal
        Contributions to the deflection at the worst flight time, with the trim of the wind in place
        of the deflection that the wind requires, and the flight times that are not known.
    limit : float
        Available deflection [rad].
    """

    takes: DeflectionTotal = field(
        metadata=specs(
            Field(kind="time", name="time", of="takes.time"), Field(kind="angle", of="takes.total")
        )
    )
    limit: float = field(metadata=spec("angle"))

    @property
    @derived()
    def ratio(self) -> float:
        """Available deflection over the total of trim in the wind and what adds to it (`takes`).

        Infinite for a total of zero.
        """
        return self.limit / self.takes.total if self.takes.total else np.inf

    @property
    @derived()
    def words(self) -> str:
        """The ratio of available deflection to trim with what adds to it, judged, in words.

        A ratio above a limit says so if winds are not known at some flight times (`takes`, the
        total of trim and what adds to it, has them in `not_sized`).
        """
        defined = " where the winds are known" if self.takes.not_sized else ""
        if self.ratio > GOAL:
            return f"above the goal of {GOAL:g}{defined}"
        if self.ratio > LEAST:
            return f"above the limit of {LEAST:g}, below the goal of {GOAL:g}{defined}"
        return f"below the limit of {LEAST:g}"

    @property
    def table(self) -> Table:
        """Table of the ratio: trim of the wind, contributions that add up, and the limit.

        `takes` is the total of all but the limit, at the worst flight time.
        """
        rows = rows_of(self.takes, "ratio", "trim of the wind")
        total = degrees("ratio.takes", self.takes.total)
        rows.append((("trim and all that adds up",), (SUMS,), total))
        rows.append((("available",), ("",), degrees("ratio.limit", self.limit)))
        return Table(f"Controllability ratio{at_time(self.takes, 'its')}", HEAD, tuple(rows))

    @property
    def verdict(self) -> Line:
        """Text of the controllability ratio, and its comparison with its goal and limit."""
        return (
            "Controllability ratio ",
            *significant("ratio.ratio", self.ratio),
            f": {self.words}",
        )

    @property
    def notes(self) -> Iterator[str]:
        """Reasons for which ratio and verdict differ."""
        yield (
            "the controllability ratio takes the whole of trim at the wind's peak for needed, as if"
            " the wind lasted, and adds a gust by squares; the boundary takes the time that the"
            " vehicle needs to fall, and adds a gust in full: a ratio below 1 may survive a short"
            " wind, and one above 1 is no proof, for it knows neither law nor rate"
        )


def controllability_ratio(
    sizing: Sizing,
    limit: float,
    *,
    gust: ArrayLike = 0.0,
    thrust_offset: float = 0.0,
    gravity_offset: float = 0.0,
) -> ControllabilityRatio:
    """Return the minimum controllability ratio over the flight times of a sizing.

    Parameters
    ----------
    sizing : Sizing
        The sizing, whose trim includes gusts.
    limit : float
        Available deflection [rad].
    gust : array_like
        Peak of the gust [rad] in them, one or of each flight time, ``(n,)``: its trim counts as
        random, and not with theirs.
    thrust_offset : float
        Angle [rad] of the thrust to the nozzle, random.
    gravity_offset : float
        Distance [m] of the centre of gravity from the axis, random.

    Raises
    ------
    InputError
        For numbers out of range, and a trim that is known nowhere.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> found = tv.size(tv.load_schedule("configuration-i"), wind, times=[60.0, 70.0])
    >>> ratio = tv.requirement.controllability_ratio(found, np.radians(1.0))
    >>> round(ratio.ratio, 2), ratio.words
    (1.67, 'above the limit of 1, below the goal of 2')
    """
    instance("sizing", sizing, Sizing, "see size")
    available = limit_angle(limit, "limit")
    gusts = np.abs(small_angle("a wind angle")("gust", gust, "rad"))
    if gusts.shape not in ((), sizing.times.shape):
        raise InputError(
            f"gust must be one number or {sizing.times.size}, as times; got {gusts.shape}"
        )
    if np.all(np.isnan(sizing.required[TRIM])):
        raise InputError("trim is not known at any flight time, and the ratio needs it")
    planes = PLANES if sizing.plane == BOTH else (sizing.plane,)
    ratios = []
    # flight time [s], trim [rad] and peak angle of the gust [rad] of each wind and time
    for time, trim, peak in _trims(sizing, np.broadcast_to(gusts, sizing.times.shape)):
        vehicle = sizing.schedule.at(time)
        slopes = (abs(float(Coefficients.from_vehicle(vehicle, name).B)) for name in planes)
        # B is trim deflection per angle of attack; the trim of the wind includes the gust's
        gust_trim = min(max(slopes) * peak, trim)
        total = total_deflection(
            vehicle,
            trim - gust_trim,
            nominal=float(sizing.schedule.nominal_at(time)),
            thrust_offset=thrust_offset,
            gravity_offset=gravity_offset,
            others=(Part("gust", gust_trim, kind="random"),),
        )
        ratios.append(ControllabilityRatio(takes=total, limit=available))
    worst = min(ratios, key=lambda r: r.ratio)
    # an end of the flight is named only where all other times have larger ratios
    others = min((r.ratio for r in ratios if r.takes.time != worst.takes.time), default=0.0)
    end = flight_end(sizing, worst.takes.time) if worst.ratio < (1.0 - SAME) * others else ""
    takes = replace(worst.takes, not_sized=sizing.not_sized(TRIM), end=end)
    return replace(worst, takes=takes)


def _trims(sizing: Sizing, gusts: FloatArray) -> Iterator[tuple[float, float, float]]:
    """Yield flight times [s], the trim [rad] of each wind then, and the gust's peak angle [rad].

    `sizing`: trims by flight time and wind. `gusts`: peak angle at each flight time, ``(n,)``. A
    wind that is fixed in flight time has the largest trim near each flight time, at its own time.
    """
    trim = sizing.required[TRIM]
    time, gust = (np.broadcast_to(x[:, np.newaxis], trim.shape) for x in (sizing.times, gusts))
    if sizing.concurrent is not None:
        fixed = np.isfinite(sizing.concurrent.deflection)
        trim = np.where(fixed, sizing.concurrent.deflection, trim)
        time = np.where(fixed, sizing.concurrent.time, time)
    defined = np.isfinite(trim)
    yield from zip(
        time[defined].tolist(), trim[defined].tolist(), gust[defined].tolist(), strict=True
    )
