"""Flown margins: the change of gain, effectiveness or delay at which a flight is lost.

Unlike the margins of the linear loop they hold for one wind and one deflection limit. The change at
which the loop becomes unstable in its linear range is computed as well (`sampled_stability`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tvclin.base import lines
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.documents import decibels, keyed
from tvclin.base.errors import InputError, number, positive, small_angle
from tvclin.base.lines import Line, Table, significant
from tvclin.boundary.recoverable import unstable_coordinates
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.control.margins.margins import margin
from tvclin.flights.closed_loop.batch import Batch, Hardware, one_flight
from tvclin.flights.closed_loop.checks import LATE, check_flight
from tvclin.flights.closed_loop.fly_many import RINGS, SURVIVED, UNDECIDED, fly_many
from tvclin.flights.closed_loop.sampled_stability import (
    SLOW,
    delay_at_growth,
    factors_at_growth,
    worst_near_rest,
)
from tvclin.flights.closed_loop.survival_limit import (
    ALWAYS,
    OK,
    STEPS,
    Edge,
    closed_loop_boundary,
    edge_above_losses,
    in_all,
    stopped_winds,
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


class NearRest(NamedTuple):
    """Changes with which the loop grows near rest: factors of the gain, and a delay [s]."""

    fall: float
    rise: float
    delay: float


@dataclass(frozen=True, eq=False)
class FlownMargin(Shown):
    """How far one quantity may change.

    Attributes
    ----------
    value : float
        A factor above one, or a further delay [s]; infinite if nothing fails.
    cause : str
        What comes first: "lost" (or "undecided", where a flight is neither lost nor settled),
        "rings" (the loop grows near rest; on the side of the aerodynamic moment it need not
        oscillate), or "nothing".
    again : bool
        Whether some larger change, of those that were tried, survives and does not ring.
    lost : float
        The change from which a flight is lost; infinite if none is that was tried.
    near_rest : float
        The change from which the loop grows near rest, from its eigenvalues.
    scan : ndarray
        The changes that were flown, rising.
    survives : ndarray of bool
        Which of them survive, whatever the loop does near rest.
    """

    value: float
    cause: str
    again: bool
    lost: float
    near_rest: float
    scan: FloatArray
    survives: BoolArray

    as_dict = keyed("value cause again lost near_rest")

    @property
    def dB(self) -> float:
        """The factor in dB; without meaning for a delay."""
        return float(decibels(self.value))


@dataclass(frozen=True, eq=False)
class FlownMargins(Shown):
    """What may change before the flight of a law with a limit is lost.

    Attributes
    ----------
    gain_fall, gain_rise : FlownMargin
        What the law asks for divided, or multiplied, ahead of switch and limit.
    effectiveness_fall, effectiveness_rise : FlownMargin
        What the nozzle does divided, or multiplied, behind its stop, of which the law knows
        nothing.
    delay : FlownMargin
        Further delay between command and nozzle.
    limit : float
        The limit, over ``|B alpha_w,max|``.
    boundary : float
        The least limit, of `closed_loop_boundary`, over the same.
    status : str
        "ok", or in words what is wrong with the limit or its boundary.
    """

    gain_fall: FlownMargin
    gain_rise: FlownMargin
    effectiveness_fall: FlownMargin
    effectiveness_rise: FlownMargin
    delay: FlownMargin
    limit: float
    boundary: float
    status: str

    as_dict = keyed(
        "limit_of_full_trim=limit boundary_of_full_trim=boundary spare status"
        f" {' '.join(CHANGES)} notes"
    )

    @property
    def spare(self) -> float:
        """The limit over the boundary."""
        return self.limit / self.boundary

    @property
    def near_rest(self) -> NearRest:
        """What gain and delay may be before the loop grows near rest."""
        return NearRest(*(getattr(self, n).near_rest for n in ("gain_fall", "gain_rise", "delay")))

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be known about these margins."""
        found = [] if self.status == OK else [self.status]
        for name in CHANGES:
            one = getattr(self, name)
            words = name.replace("_", " ")
            if one.cause == NOTHING:
                found.append(f"{words} inf: none up to {one.scan[-1]:.4g} is lost or rings")
            elif one.cause == UNDECIDED:
                found.append(f"{words} {one.value:.4g}: beyond it flights stay undecided")
            if one.again:
                found.append(f"{words} {one.value:.4g}: some larger changes survive again")
        return tuple(found)

    def _repr_html_(self) -> str:
        spare = lines.number("spare", self.spare, 2)
        return table(flown_table(self), [("limit over boundary: ", *spare), (self.status,)])


def flown_table(found: FlownMargins, caption: str = "Flown margins") -> Table:
    """Return how far each quantity may change, what fails then, and what near rest allows."""
    rows: list[tuple[Line, ...]] = []
    for name in CHANGES:
        one: FlownMargin = getattr(found, name)
        flown, near_rest = (
            _change_cell(f"flown.{name}.{key}", value, name == "delay")
            for key, value in (("value", one.value), ("near_rest", one.near_rest))
        )
        rows.append(((_CHANGES[name],), flown, (_CAUSES.get(one.cause, one.cause),), near_rest))
    return Table(caption, ("change", "margin", "failure", "near rest"), tuple(rows))


def _change_cell(name: str, value: float, is_delay: bool) -> Line:
    """A further delay in ms, or a factor in dB and as it is."""
    if is_delay:
        return margin(name, 1000.0 * value, "ms")
    shown = margin(name, decibels(value), "dB")
    return (
        *shown,
        *(() if np.isinf(value) else (" (", *significant(f"{name}.factor", value), "x)")),
    )


_BEYOND = 1.15
"""Changes are flown up to so many times the one with which the loop grows near rest."""
_MOST_FACTOR = 1e4
"""And factors up to this."""
_SLOWEST = 2.0
"""Delay over 1/s of the fastest unstable pole, which no linear loop bears."""
_HIGHEST, _MOST_LIMIT = 2.0, 1e6
"""Limits among which the boundary is sought, over the largest trim deflection."""
FIXED = "fixed-path"
_REMEDY = (
    " (it holds the nose to the path, which creeps away; design it on the fixed path, with"
    ' Plant.from_vehicle(vehicle, "fixed-path"), and it holds the attitude)'
)
_NEUTRAL = 1e-9
"""A mode that grows more slowly, over the fastest pole of the plant, does not grow."""


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
    """Return how much may change before a flight with this limit, in this wind, is lost.

    Parameters
    ----------
    plant : Plant or FlexiblePlant
        The plant that flies, with one or two real unstable poles.
    law : Law
        The law, without noise: it does not change with what changes.
    wind : History
        One wind that ends.
    limit : float
        Deflection limit [rad], positive, with which the unchanged flight survives.
    rate_limit, actuator, sample_rate, delay, cuts
        As of `closed_loop_boundary`.

    Returns
    -------
    FlownMargins
        Each change was flown in 61 steps up to 1.15 times the one with which the loop grows near
        rest, of even ratio for factors, and the steps before a loss again in finer ones, as
        `closed_loop_boundary` does. It is known to 1/4096 of a step.

    Raises
    ------
    InputError
        As `closed_loop_boundary`; for a law with noise, a limit with which the unchanged flight
        is lost, and an unchanged loop that grows near rest.

    Notes
    -----
    An effectiveness e with the stop L is a gain e with the stop e L: the command c = sat(u, L)
    becomes the moment of e c = sat(e u, e L), and a nozzle is linear but for stop and rate, which
    scale alike. So a flight of a law that does not know the limit survives where e L is above the
    boundary of the gain e. It is flown as a plant whose deflection does e times as much, which
    also serves laws that know the limit, for they believe in L.

    As the limit grows, or the wind vanishes, margins tend to those near rest. As it comes to the
    boundary the effectiveness that may be lost tends to one; the other margins need not.

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
    >>> round(m.gain_fall.dB, 1), round(m.gain_fall.near_rest, 2)
    (7.3, 10.86)
    """
    check_flight(plant, law, wind)
    level = number("limit", limit, small_angle("a deflection", positive), "rad")
    if law.rate_noise[0]:
        raise InputError(
            "law must be without rate_noise: one random flight gives no margin; got"
            f" {law.rate_noise[0]:.6g} rad/s"
        )
    nozzle: dict[str, Any] = {"rate_limit": rate_limit, "actuator": actuator}
    options = nozzle | {"sample_rate": sample_rate, "delay": delay}
    scale = abs(float(plant.coefficients.B) * float(wind.peak))
    part = level / scale if scale > 0.0 else np.inf
    highest = min(max(_HIGHEST, part), _MOST_LIMIT)
    found = closed_loop_boundary(plant, law, wind, cuts=cuts, highest=highest, **options)
    length = 1.0 / float(sample_rate)
    hardware = Hardware(length, float(delay), actuator, float(rate_limit))
    one = one_flight(plant, law, wind, level, hardware)
    pace = float(unstable_coordinates(plant.rigid).poles[0])
    worst = worst_near_rest(one)
    if worst.real > _NEUTRAL * pace:
        designed = getattr(law, "plant", None)
        creeps = worst.imag < SLOW * pace and getattr(designed, "model", FIXED) != FIXED
        raise InputError(
            "law must hold the vehicle near rest before anything changes; there a mode of this"
            f" loop grows with {worst.real:+.3g} 1/s{_REMEDY if creeps else ''}"
        )
    winds = stopped_winds(wind, cuts, length)
    flights = _Flights(plant, law, winds, {"deflection_limit": level, **options})
    if flights.survive("gain_rise", np.ones(1))[0] != SURVIVED:
        needs = f"{found.limit:.4g}" if found.limit < np.inf else f"more than {highest:.4g}"
        raise InputError(
            f"limit must be one with which the unchanged flight survives: it needs {needs} of trim,"
            f" has {part:.4g}"
        )
    edges = _near_rest(one, pace)
    margins = {name: _margin(flights, name, edges[name], pace) for name in CHANGES}
    words = [] if found.status in (OK, ALWAYS) else [f"boundary: {found.status}"]
    if part < found.limit:
        words.append(f"limit {part:.4g} survives, but some up to {found.limit:.4g} of trim do not")
    return FlownMargins(**margins, limit=part, boundary=found.limit, status="; ".join(words) or OK)


@dataclass(frozen=True)
class _Flights:
    """Flights of one law in some winds, with one thing changed."""

    plant: AnyPlant
    law: Law
    winds: list[History]
    options: dict[str, Any]

    def survive(self, name: str, values: FloatArray) -> NDArray[np.str_]:
        """The status over all winds with each value of a change."""

        def status(wind: History, some: BoolArray) -> NDArray[np.str_]:
            plant, options = self.plant, self.options
            by = 1.0 / values[some] if name.endswith("fall") else values[some]
            if name == "delay":
                options = options | {"delay": options["delay"] + by}
            elif name.startswith("gain"):
                options = options | {"gain": by}
            else:
                plant = plant.with_effectiveness(by)
            status = fly_many(plant, self.law, wind, **options).status
            if self.plant.structure is None:  # a rigid one rings near rest, which is known exactly
                status = np.where(status == RINGS, SURVIVED, status)
            return status

        return in_all(self.winds, status, values.size)


def _near_rest(one: Batch, pace: float) -> dict[str, float]:
    """With what change the loop of a flight grows near rest."""
    names = ("gain", "effectiveness")
    factors = [edge for name in names for edge in factors_at_growth(one, name, pace)]
    return dict(zip(CHANGES, (*factors, delay_at_growth(one, pace)), strict=True))


def _margin(flights: _Flights, name: str, near_rest: float, pace: float) -> FlownMargin:
    """The smallest change that fails: the edge of a scan that runs from the largest to none."""
    if name == "delay":
        room = LATE / flights.options["sample_rate"] - flights.options["delay"]
        end = min(_BEYOND * min(near_rest, _SLOWEST / pace), room)
    else:
        end = min(_BEYOND * near_rest, _MOST_FACTOR)
    change = partial(_change, name == "delay", end)
    edge: Edge = edge_above_losses(
        lambda back: flights.survive(name, change(back)), np.linspace(0.0, 1.0, STEPS + 1)
    )
    lost = np.inf if edge.lost == -np.inf else float(change(edge.limit))
    value = min(lost, near_rest)
    scan, survives = change(edge.scan)[::-1], (edge.found == SURVIVED)[::-1]
    cause = RINGS if near_rest <= lost else str(edge.found[edge.scan == edge.lost][0])
    return FlownMargin(
        value=value,
        cause=NOTHING if value == np.inf else cause,
        again=bool(np.any(survives & (scan > change(edge.lost)) & (scan < near_rest))),
        lost=lost,
        near_rest=near_rest,
        scan=scan,
        survives=survives,
    )


def _change(delays: bool, end: float, back: Any) -> Any:
    """A change by how far the scan has come back from its end: zero there, one for none."""
    return end * (1.0 - back) if delays else end ** (1.0 - back)
