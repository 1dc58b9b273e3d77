"""Flown margins: the change of gain, effectiveness or delay at which a flight is lost.

Unlike the margins of the linear loop they hold for one wind and one deflection limit. The change at
which the loop becomes unstable in its linear range is computed as well (`sampled_stability`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from tvclin.base import lines
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.errors import InputError, limit_angle
from tvclin.base.fields import decibels, derived, spec
from tvclin.base.lines import Line, Table, significant
from tvclin.boundary.forecast_free import unstable_coordinates
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.control.margins.margins import margin
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.checks import MAX_DELAY_SAMPLES, check_flight
from tvclin.flights.closed_loop.fly_many import RINGS, SURVIVED, UNDECIDED, fly_many
from tvclin.flights.closed_loop.sampled_stability import (
    MIN_FREQUENCY_OVER_POLE,
    dominant_pole,
    linear_delay_margin,
    linear_gain_margins,
)
from tvclin.flights.closed_loop.survival_limit import (
    ALWAYS,
    OK,
    STEPS,
    SurvivalLimit,
    Words,
    closed_loop_boundary,
    limit_above_losses,
    status_in_all_winds,
    winds_with_stops,
)
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

NOTHING = "nothing"
_CHANGES = {
    "gain_fall": "gain falls",
    "gain_rise": "gain rises",
    "effectiveness_fall": "effectiveness falls",
    "effectiveness_rise": "effectiveness rises",
    "delay": "further delay",
}
CHANGES = tuple(_CHANGES)
_CAUSES = {"lost": "is lost", "rings": "rings near rest", UNDECIDED: "neither lost nor settled"}


class LostFlightError(InputError):
    """Error of a deflection limit [rad] with which the flight is lost before gain or delay changes.

    Its arguments are the limit, and what the unchanged flight needs in words, as "1.5 deg" or "more
    than 1.5 deg".
    """

    @property
    def sentence(self) -> str:
        """Sentence on the limit that the flight needs without a change of gain or delay."""
        _limit, needs = self.args  # [rad], and words such as "1.5 deg"
        return f"the unchanged flight needs {needs}"

    def __str__(self) -> str:
        """Return the message: the flight needs a larger limit, before gain or delay changes."""
        limit, needs = self.args  # of the constructor: [rad], and words such as "1.5 deg"
        return (
            "limit must be one with which the unchanged flight survives: this needs"
            f" {needs}; got {np.degrees(limit):.4g} deg"
        )


class LinearMargins(NamedTuple):
    """Margins of the loop in its linear range: gain factors above one, and a delay [s]."""

    fall: float
    rise: float
    delay: float


@dataclass(frozen=True, eq=False)
class FlownMargin(Shown):
    """Margin of one quantity: the smallest change with which a flight fails.

    Attributes
    ----------
    value : float
        Factor above one, or further delay [s]; infinite without a failure.
    cause : str
        First failure: "lost" (or "undecided", if a flight is neither lost nor settled), "rings"
        (the loop is unstable in its linear range; towards a smaller gain it need not oscillate), or
        "nothing".
    survives_beyond : bool
        Whether a larger change of the scan survives and does not ring.
    loss : float
        Smallest change with which a flight is lost; infinite if no change of the scan is.
    linear : float
        Smallest change with which the loop is unstable in its linear range, from its eigenvalues.
    scan : ndarray
        Changes of the flights, rising.
    survives : ndarray of bool
        Whether each of them survives, stable in its linear range or not.
    """

    value: float = field(metadata=spec())
    cause: str = field(metadata=spec())
    survives_beyond: bool = field(metadata=spec())
    loss: float = field(metadata=spec())
    linear: float = field(metadata=spec())
    scan: FloatArray
    survives: BoolArray

    @property
    def dB(self) -> float:
        """Factor in dB; without meaning for a delay."""
        return float(decibels(self.value))


@dataclass(frozen=True, eq=False)
class FlownMargins(Shown):
    """Margins of the flight of a law with a limit.

    Attributes
    ----------
    gain_fall, gain_rise : FlownMargin
        Factor on the demand of the law, before switch and limit.
    effectiveness_fall, effectiveness_rise : FlownMargin
        Factor on the control moment of the nozzle, which the law does not know.
    delay : FlownMargin
        Further delay between command and nozzle.
    limit : float
        Deflection limit, over ``|B alpha_w,max|``.
    boundary : float
        Smallest limit, of `closed_loop_boundary`, over ``|B alpha_w,max|``.
    status : str
        "ok", or a warning on the limit or its boundary.
    """

    gain_fall: FlownMargin = field(metadata=spec())
    gain_rise: FlownMargin = field(metadata=spec())
    effectiveness_fall: FlownMargin = field(metadata=spec())
    effectiveness_rise: FlownMargin = field(metadata=spec())
    delay: FlownMargin = field(metadata=spec())
    limit: float = field(metadata=spec(name="limit_of_full_trim"))
    boundary: float = field(metadata=spec(name="boundary_of_full_trim"))
    status: str = field(metadata=spec())

    @property
    @derived()
    def spare(self) -> float:
        """Ratio of the deflection limit to the boundary."""
        return self.limit / self.boundary

    @property
    def spare_line(self) -> Line:
        """Limit over boundary as text, a number to two decimals."""
        return lines.number("flown.spare", self.spare, 2)

    @property
    def linear(self) -> LinearMargins:
        """Margins of gain (factors above one) and delay [s] in the linear range of the loop."""
        return LinearMargins(
            *(getattr(self, n).linear for n in ("gain_fall", "gain_rise", "delay"))
        )

    @property
    @derived()
    def notes(self) -> tuple[str, ...]:
        """Sentences on the status, on margins without a failure, and on changes that survive."""
        notes = [] if self.status == OK else [self.status]
        for name in CHANGES:
            m: FlownMargin = getattr(self, name)  # the field has the name of the change
            label = name.replace("_", " ")
            # `scan`: the changes that were flown, rising
            if m.cause == NOTHING:
                notes.append(f"{label} inf: none up to {m.scan[-1]:.4g} is lost or rings")
            elif m.cause == UNDECIDED:
                notes.append(f"{label} {m.value:.4g}: beyond it flights stay undecided")
            if m.survives_beyond:
                notes.append(f"{label} {m.value:.4g}: some larger changes survive again")
        return tuple(notes)

    def _repr_html_(self) -> str:
        """Return the table of the margins in HTML, for a notebook."""
        spare = ("limit over boundary: ", *self.spare_line)
        return table(flown_table(self), [spare, (self.status,)])


def flown_table(margins: FlownMargins, caption: str = "Flown margins") -> Table:
    """Return the table of flown margins, their first failures, and the linear margins.

    `caption`: caption of the table.
    """
    rows: list[tuple[Line, ...]] = []
    for name in CHANGES:
        m: FlownMargin = getattr(margins, name)
        flown, linear = (
            _change_cell(f"flown.{name}.{key}", value, is_delay=name == "delay")
            for key, value in (("value", m.value), ("linear", m.linear))
        )
        rows.append(((_CHANGES[name],), flown, (_CAUSES.get(m.cause, m.cause),), linear))
    return Table(caption, ("change", "margin", "failure", "near rest"), tuple(rows))


def _change_cell(name: str, value: float, is_delay: bool) -> Line:
    """Return the cell of a further delay [s], in ms, or of a factor, in dB with the factor.

    `name`: key of the cell in JSON. `value`: the delay or the factor. `is_delay`: which of both.
    """
    if is_delay:
        return margin(name, 1000.0 * value, "ms")
    shown = margin(name, decibels(value), "dB")
    return (
        *shown,
        *(() if np.isinf(value) else (" (", *significant(f"{name}.factor", value), "x)")),
    )


_MAX_OVER_LINEAR = 1.15
"""Largest change of a scan, over the linear margin."""
_MAX_FACTOR = 1e4
"""Largest factor of a scan."""
_MAX_DELAY_TIMES_POLE = 2.0
"""Largest delay of a scan, times the fastest unstable pole: no linear loop is stable with it."""
_DEFAULT_HIGHEST = 2.0
"""Highest limit of the search for the boundary, over the largest trim deflection."""
_MAX_LIMIT = 1e6
"""Largest limit that this search includes, over the largest trim deflection."""
FIXED = "fixed-path"
_REMEDY = (
    " (it holds the nose to the path, which creeps away; design it on the fixed path, with"
    ' Plant.from_vehicle(vehicle, "fixed-path"), and it holds the attitude)'
)
_MIN_GROWTH_OVER_POLE = 1e-9
"""Smallest growth rate of an unstable mode, over the fastest pole; below it may be rounding."""


def flown_margins(
    plant: AnyPlant,
    law: Law,
    wind: History,
    *,
    limit: float,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float = 100.0,
    delay: float = 0.0,
    cuts: int = 0,
) -> FlownMargins:
    """Return the flown margins of a law with a deflection limit in a wind.

    A flown margin is the change of all gains, of the effectiveness or of the delay from which on
    the flight, by samples and with the limit, does not survive the wind.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        One plant with one or two real unstable poles.
    law : Law
        The law, without noise; it does not adapt to the changes.
    wind : History
        One wind that ends.
    limit : float
        Deflection limit [rad], positive, with which the nominal flight survives.
    rate_limit, actuator, sample_rate, delay, cuts
        Same as in `closed_loop_boundary`.

    Returns
    -------
    FlownMargins
        Margins from scans of 61 steps up to 1.15 times the linear margin, of equal ratio for
        factors, with the refinements of `closed_loop_boundary`: accurate to 1/4096 of a step.

    Raises
    ------
    InputError
        In the same cases as `closed_loop_boundary`; for a law with noise, and a nominal loop that
        is unstable in its linear range.
    LostFlightError
        An `InputError`, for a limit with which the nominal flight is lost.

    Notes
    -----
    An effectiveness e with the limit L is a gain e with the limit e L: the command c = sat(u, L)
    becomes the moment of e c = sat(e u, e L), and a nozzle is linear except for deflection and rate
    limits, which scale alike. So a flight of a law that does not know the limit survives if e L is
    above the boundary of the gain e. It is flown as a plant with e times the control moment, which
    is also right for laws that use the limit, because they use L.

    As the limit grows, or the wind vanishes, the margins tend to the linear margins. As the limit
    approaches the boundary, the margin of a falling effectiveness tends to one; the others need
    not.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=0.228, mu_delta=1.317))
    >>> law = tv.SaturatedLaw(tv.Autopilot(attitude_gain=1.88, rate_gain=1.59))
    >>> wind = tv.TriangularWind(peak=0.05, duration=8.0)
    >>> limit = 0.0083  # of 0.0087 for full trim
    >>> m = tv.flights.flown_margins(plant, law, wind, limit=limit, actuator=tv.Actuator())
    >>> round(m.spare, 2), round(m.effectiveness_fall.value, 2), m.effectiveness_fall.cause
    (1.23, 1.19, 'lost')
    >>> round(m.gain_fall.dB, 1), round(m.gain_fall.linear, 2)
    (7.3, 10.86)
    """
    check_flight(plant, law, wind)
    level = limit_angle(limit, "limit")
    if law.rate_noise[0]:
        raise InputError(
            "law must be without rate_noise: one random flight gives no margin; got"
            f" {law.rate_noise[0]:.6g} rad/s"
        )
    nozzle: dict[str, Any] = {"rate_limit": rate_limit, "actuator": actuator}
    options = nozzle | {"sample_rate": sample_rate, "delay": delay}
    scale = abs(float(plant.coefficients.B) * float(wind.peak))
    ratio = level / scale if scale > 0.0 else np.inf
    highest = min(max(_DEFAULT_HIGHEST, ratio), _MAX_LIMIT)
    boundary = closed_loop_boundary(plant, law, wind, cuts=cuts, highest=highest, **options)
    period = 1.0 / float(sample_rate)
    hardware = Hardware(period, float(delay), actuator=actuator, rate_limit=float(rate_limit))
    flight = one_flight(plant, law, wind, level, hardware)
    pole = float(unstable_coordinates(plant.rigid).poles[0])
    worst = dominant_pole(flight)
    if worst.real > _MIN_GROWTH_OVER_POLE * pole:
        design_plant = getattr(law, "plant", None)
        # such a law lets the path creep away, by a slow mode: the message names the remedy
        is_slow = (
            worst.imag < MIN_FREQUENCY_OVER_POLE * pole
            and getattr(design_plant, "model", FIXED) != FIXED
        )
        raise InputError(
            "law must hold the vehicle near rest before anything changes; there a mode of this"
            f" loop grows with {worst.real:+.3g} 1/s{_REMEDY if is_slow else ''}"
        )
    winds = winds_with_stops(wind, cuts, period)  # the wind, and with a sudden stop at each cut
    status = partial(_status_of_change, plant, law, winds, {"deflection_limit": level, **options})
    (unchanged,) = status("gain_rise", np.ones(1))  # with the gain times one
    if unchanged != SURVIVED:
        known = boundary.limit < np.inf
        required_deg = np.degrees(scale * (boundary.limit if known else highest))
        needs = f"{'' if known else 'more than '}{required_deg:.4g} deg"
        raise LostFlightError(level, needs)
    # changes at which the loop in its linear range becomes unstable: four factors, a delay [s]
    names = ("gain", "effectiveness")
    factors = [factor for name in names for factor in linear_gain_margins(flight, name, pole)]
    linear = dict(zip(CHANGES, (*factors, linear_delay_margin(flight, pole)), strict=True))
    ends = {name: min(_MAX_OVER_LINEAR * linear[name], _MAX_FACTOR) for name in CHANGES}
    longest = MAX_DELAY_SAMPLES / sample_rate - delay
    delay_end = _MAX_OVER_LINEAR * min(linear["delay"], _MAX_DELAY_TIMES_POLE / pole)
    ends["delay"] = min(delay_end, longest)
    margins = {
        name: _margin(partial(status, name), partial(_change, name == "delay", end), linear[name])
        for name, end in ends.items()
    }
    warnings = [] if boundary.status in (OK, ALWAYS) else [f"boundary: {boundary.status}"]
    if ratio < boundary.limit:
        warnings.append(
            f"limit {ratio:.4g} survives, but some up to {boundary.limit:.4g} of trim do not"
        )
    return FlownMargins(
        **margins, limit=ratio, boundary=boundary.limit, status="; ".join(warnings) or OK
    )


def _status_of_change(
    plant: AnyPlant,
    law: Law,
    winds: list[History],
    options: dict[str, Any],
    name: str,
    values: FloatArray,
) -> Words:
    """Return the status of flights over all winds for each value of a change, ``(n,)``.

    The status is the first other than "survived" in a wind. A rigid vehicle that "rings", in a
    limit cycle, counts as surviving: that its loop is unstable is in the linear margin. `options`:
    limits, actuator, sample rate and delay of the unchanged flight, as in `fly_many`. `name`: name
    of the change, see `CHANGES`. `values`: factors above one, by which a quantity that falls is
    divided, or further delays [s].
    """

    def status(wind: History, chosen: BoolArray) -> Words:
        """Return the status of flights in a wind with the `values` at which `chosen` is true."""
        by = 1.0 / values[chosen] if name.endswith("fall") else values[chosen]  # or a delay
        changed_plant, changes = plant, options
        if name == "delay":
            changes = options | {"delay": options["delay"] + by}
        elif name.startswith("gain"):
            changes = options | {"gain": by}
        else:
            changed_plant = plant.with_effectiveness(by)
        outcomes = fly_many(changed_plant, law, wind, **changes).status
        return outcomes if plant.has_modes else np.where(outcomes == RINGS, SURVIVED, outcomes)

    return status_in_all_winds(winds, status, values.size)


def _margin(
    status: Callable[[FloatArray], Words], change: Callable[[Any], Any], linear: float
) -> FlownMargin:
    """Return the flown margin of one quantity, by a scan from the largest change to none.

    The scan runs backwards, over the fraction of `_change`, because `limit_above_losses` finds the
    value above which all survive: here that is the change below which all do. The margin is the
    smaller of it and the linear margin. `status`: function from changes, factors or delays [s], to
    the status of their flights. `change`: function from fractions to changes. `linear`: linear
    margin.
    """
    # `back` by field: `scan`, all values, rising; `lost`, that nearest to no change of a flight
    # that does not survive, minus infinity if there is none; `limit`, a last step above `lost`
    back: SurvivalLimit = limit_above_losses(
        lambda fraction: status(change(fraction)), np.linspace(0.0, 1.0, STEPS + 1)
    )
    loss = np.inf if back.lost == -np.inf else float(change(back.limit))
    value = min(loss, linear)
    scan, survives = change(back.scan)[::-1], (back.outcomes == SURVIVED)[::-1]
    cause = RINGS if linear <= loss else str(back.outcomes[back.scan == back.lost][0])
    return FlownMargin(
        value=value,
        cause=NOTHING if value == np.inf else cause,
        survives_beyond=bool(np.any(survives & (scan > change(back.lost)) & (scan < linear))),
        loss=loss,
        linear=linear,
        scan=scan,
        survives=survives,
    )


def _change(delays: bool, end: float, back: Any) -> Any:
    """Return the change at a fraction `back` of the scan: 0 is its end, 1 is no change.

    Factors are of equal ratio, and 1 is no change; a delay [s] is zero then. `delays`: whether the
    change is a delay [s], else a factor. `end`: largest change.
    """
    return end * (1.0 - back) if delays else end ** (1.0 - back)
