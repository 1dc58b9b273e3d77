"""How much may change before a flight with this limit, in this wind, is lost.

Linear margins know no stop and no wind, a boundary knows no error of the loop; a flown margin
knows both. A change fails when the flight is lost, or when the loop grows near rest: the nozzle
then rings from stop to stop, so fast perhaps that the vehicle hardly moves and is never lost. The
margin is the smallest change, from none outwards, that fails either way.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, number, positive, small_angle
from tvclin.boundary.recoverable import unstable_coordinates
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Batch, Hardware, one_flight
from tvclin.flights.closed_loop.boundary import closed_loop_boundary
from tvclin.flights.closed_loop.checks import LATE, check_flight
from tvclin.flights.closed_loop.edges import (
    ALWAYS,
    OK,
    STEPS,
    Edge,
    edge_above_losses,
    in_all,
    stopped_winds,
)
from tvclin.flights.closed_loop.flown_record import CHANGES, NOTHING, FlownMargin, FlownMargins
from tvclin.flights.closed_loop.growth import SLOW, worst_near_rest
from tvclin.flights.closed_loop.many import RINGS, SURVIVED, fly_many
from tvclin.flights.closed_loop.near_rest import delay_at_growth, factors_at_growth
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History

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
