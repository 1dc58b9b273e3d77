"""Required deflection limit at nominal dynamic pressure: the largest requirement of a control.

The report's boundary is one requirement, and not always the largest. A limit is sufficient when it
is none of these too low for

- the boundary of the control, with the dead band left by trim itself, as in a flight;
- the minimum over all unstable poles, appendix C, which nothing undercuts, from the onset of the
  wind on, and for 0 < K < 1 from the state on that trim up to K times the limit has left;
- for K = 1, which claims to need no forecast, the bound without one, and the ideal trim law with
  limits, which (4b) describes where the wind rises and falls once and the path is slow.

The minimum peak of a wind that is known, with trim and the boundary at K = 0, is `KnownWind`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, instance, nonzero, plain, small_angle, within
from tvclin.base.fields import Field, derived, document, rows, spec, specs
from tvclin.base.lines import (
    NONE_SUFFICIENT,
    Line,
    Row,
    Table,
    degrees,
    minimum_limit,
    number,
    quantities,
    significant,
)
from tvclin.base.quantities import STATIC_TRIM, WIND_KNOWN
from tvclin.boundary.limit import boundary_limit, leading_pole
from tvclin.boundary.open_loop import ROUNDING, Reason, open_loop_requirements
from tvclin.boundary.optimum.minimum_peak import Optimum, minimum_peaks, optimum_deflection
from tvclin.boundary.optimum.rate_limit import RateLimitedOptimum, optimum_with_rate_limit
from tvclin.linear.deflections import trim_deflection
from tvclin.linear.plant import Plant
from tvclin.time_varying.equations import Equations, has_quick_path
from tvclin.time_varying.requirements import batch_requirements
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import MAX_LINEAR_ANGLE, NominalWind, beyond_linear

_MARCH_ERROR = 1e-6
"""Error of `time_varying` over static trim: closed forms stand where it requires no more."""
_AFTER_TRIM_ERROR = 0.01
"""Relative error of the march where the minimum after trim decides, which has an exact solution."""


@dataclass(frozen=True, eq=False)
class RequiredDeflection(Shown):
    """The deflection limit that is required, of one case or a batch ``(...)``.

    Attributes
    ----------
    limit : float or ndarray
        Required limit normalised by static trim B alpha_w,max.
    deflection : float or ndarray
        Required deflection [rad], -limit B alpha_w,max; its sign opposes the wind.
    governs : Reason or ndarray of str
        Which of `needs` is the largest; "nothing" where no deflection is needed.
    needs : dict of Reason to float or ndarray
        All requirements, as sizes [rad]; zero where one does not apply.
    status : str or ndarray of str
        Status of the boundary whose dead band ends where trim, not the wind, exceeds K times the
        limit (the "literal" switch); see `BoundaryLimit`.
    """

    limit: Any = field(metadata=spec(label="limit over trim"))
    deflection: Any = field(metadata=spec("angle"))
    governs: Any = field(metadata=spec())
    needs: dict[Reason, Any] = field(metadata=spec("angle"))
    status: Any


def required_deflection(
    plant: Plant,
    wind: History,
    dead_band: ArrayLike = 1.0,
    *,
    two_sided: History | None = None,
) -> RequiredDeflection:
    """Return the required deflection [rad] of linear theory in a wind of one sign.

    It is at nominal dynamic pressure; the verdict on a vehicle, in the wind's own angle and dynamic
    pressure, is in a `Study`.

    Parameters
    ----------
    plant : Plant
        One plant or a batch, of any model.
    wind : History
        Wind angle of attack that does not change its sign; batches broadcast.
    dead_band : array_like
        K, the part of the limit up to which the vehicle is trimmed, in [0, 1].
    two_sided : History, optional
        The same wind with both signs, where `wind` is its part of one sign. The minimum and the
        trim law encounter it; a drift towards the other sign first may cost deflection.

    Returns
    -------
    RequiredDeflection
        The largest of all requirements, and which one it is.

    Raises
    ------
    InputError
        For a wind that changes sign, never ends or is zero, and a dead band outside [0, 1].

    Notes
    -----
    Eqs (4b), (17) and (C1). For K = 1 the requirement of the ideal trim law is computed by
    `time_varying`, as along flights and at the dynamic pressure encountered: the largest of
    min(trim, demand), the demand being the limit sufficient when held from then on. That does not
    decide where the flight path is quick, unstable or about as fast as the attitude, where trim
    meets the limit more than once, or where a flight with half a percent more diverges. There the
    limited law is flown with limits two percent apart, near the highest one that diverges 0.2
    percent apart, and the requirement is the smallest limit above all that diverge. For 0 < K < 1
    `time_varying` counts on a quick path too, where drift may turn trim over, so that the dead band
    is entered again. A wind too long to be followed, or a pair of unstable poles, requires the
    largest trim over K, infinite for K = 0.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    >>> long = tv.TriangularWind(peak=np.radians(5), duration=60.0)
    >>> found = tv.required_deflection(plant, long, dead_band=0.5)
    >>> found.governs, round(found.limit, 3), round(tv.boundary_limit(plant, long, 0.5).limit, 3)
    ('the minimum over all unstable poles after trim', 0.198, 0.124)
    """
    K = within("dead_band", dead_band, 0.0, 1.0)
    boundary = boundary_limit(plant, wind, K, "literal")
    needs = open_loop_requirements(plant, wind, K, boundary)
    law_wind = wind  # wind through which the limited trim law is flown
    if two_sided is not None:
        instance("two_sided", two_sided, History, "the wind with both signs")
        if two_sided.batch != wind.batch:
            raise InputError(
                f"two_sided must be the same winds as wind, of shape {wind.batch}; got"
                f" {two_sided.batch}"
            )
        law_wind = two_sided
        needs[Reason.MINIMUM] = np.maximum(needs[Reason.MINIMUM], minimum_peaks(plant, two_sided))
    open_loop = np.max(list(needs.values()), axis=0)
    rate, paired = leading_pole(plant)  # fastest unstable pole [1/s], NaN without; whether a pair
    single_pole = ~paired & ~np.isnan(rate) & np.isfinite(open_loop)
    # cases in which the trim law may require more than the open-loop requirements: with K = 1,
    # on a fixed path only where the wind rises a second time; with K < 1 on a quick path
    trims_always = (K == 1.0) & single_pole
    if plant.model == "fixed-path" and two_sided is None:
        trims_always = trims_always & _has_second_rise(wind)
    holds_limit = (0.0 < K) & (K < 1.0) & single_pole & has_quick_path(plant)
    cases = np.broadcast_to(trims_always | holds_limit, open_loop.shape)
    law = np.zeros(open_loop.shape)  # requirement of the trim law [rad], zero in other cases
    for value in np.unique(K).tolist():
        winds = law_wind if value == 1.0 else wind
        law += _trim_law(plant, winds, cases & (value == K), value)
    # static trim [rad]: B is the ratio of trim deflection to angle of attack
    static = np.abs(np.asarray(plant.coefficients.B) * wind.peak)
    error = _MARCH_ERROR * static + np.where(K == 1.0, 0.0, _AFTER_TRIM_ERROR * open_loop)
    needs[Reason.TRIM_LAW] = np.where(law > open_loop + error, law, 0.0)
    governs = np.full(needs[Reason.BOUNDARY].shape, Reason.BOUNDARY, dtype=object)
    required = np.array(needs[Reason.BOUNDARY])
    for name in (Reason.MINIMUM, Reason.NO_FORECAST, Reason.AFTER_TRIM, Reason.TRIM_LAW):
        larger = needs[name] > required * (1.0 + ROUNDING)
        governs = np.where(larger, name, governs)
        required = np.where(larger, needs[name], required)
    governs = np.where(required == 0.0, Reason.NOTHING, governs)
    full = -np.asarray(plant.coefficients.B) * wind.peak  # static trim with its sign [rad]
    with np.errstate(divide="ignore", invalid="ignore"):  # no moment, no wind angle to trim
        limit = np.where(required == 0.0, 0.0, required / np.abs(full))
    return RequiredDeflection(
        limit=plain(limit),
        deflection=plain(np.asarray(np.copysign(required, full))),
        governs=governs.astype(str) if governs.ndim else Reason(governs.item()),
        needs={name: plain(np.asarray(need)) for name, need in needs.items()},
        status=boundary.status,
    )


@dataclass(frozen=True, eq=False)
class FrozenRequirement:
    """Required deflections [rad] of a frozen vehicle in one wind; NaN where one is not defined.

    `trim` is the static trim |B alpha_w,max|; `required` for each dead band, ``(k,)``;
    `no_forecast` the lower bound of laws without a forecast; `minimum` the minimum peak of appendix
    C. `messages` say why a requirement is not defined, or not satisfied exactly. `slow_mode` is the
    ratio y of eq (C8), of the deflections that the slow and the fast mode demand in a plane: from
    one on the slow mode of the flight path decides.
    """

    trim: float
    required: FloatArray
    no_forecast: float
    minimum: float
    messages: tuple[str, ...] = ()
    slow_mode: float = np.nan

    @classmethod
    def of_calm(cls, dead_bands: FloatArray, size: float = 0.0) -> Self:
        """Return the requirements in a calm, all of one `size` [rad]; NaN if it is not known."""
        return cls(size, np.full(dead_bands.shape, size), no_forecast=size, minimum=size)


def may_be_zero_or_infinite(plant: Plant, wind: History, dead_band: float) -> BoolArray:
    """Return whether `required_deflection` may be zero or infinite, ``(...)``, without flights.

    `plant` and `wind` are a batch or one each. `dead_band`: K, from 0 to 1. Flights of the limited
    trim law can diverge with any limit only where the flight path turns about as fast as the
    attitude (`has_quick_path`); else the largest trim, or what holds the vehicle as the wind ends,
    is sufficient.
    """
    boundary = boundary_limit(plant, wind, dead_band, "literal")
    # K = 0 omits the minimum peak after trim, of 0 < K < 1, which takes a search and is finite
    counted = 1.0 if dead_band == 1.0 else 0.0
    needs = open_loop_requirements(plant, wind, counted, boundary)
    largest = np.max(list(needs.values()), axis=0)
    return np.asarray((largest == 0.0) | ~np.isfinite(largest) | has_quick_path(plant))


def _trim_law(plant: Plant, wind: History, cases: BoolArray, dead_band: float) -> FloatArray:
    """Return the required deflections [rad] of the trim law with a dead band, else zero.

    `plant`, `wind`: of the batch. `cases`: whether a case is computed, of the shape of the batch.
    `dead_band`: K, above zero. A wind too long to be followed requires the largest trim over K.
    """
    which = np.flatnonzero(cases)
    if not which.size:
        return np.zeros(cases.shape)
    plants, winds = plant.cases(which, cases.shape), wind.cases(which, cases.shape)
    limits = batch_requirements(Equations.of_plant(plants), NominalWind(winds), dead_band)
    if np.any(too_long := np.isnan(limits)):  # a wind too long to be followed
        trim = np.abs(trim_deflection(plants, winds).peak)
        limits = np.where(too_long, trim / dead_band, limits)
    required = np.zeros(cases.size)
    required[which] = limits
    return required.reshape(cases.shape)


def _has_second_rise(wind: History) -> BoolArray:
    """Return whether winds rise again after they have fallen, so that trim may be limited twice.

    Sizes of the wind angle count, at samples that show its shape; changes within rounding do not.
    """
    size = np.abs(wind.peak)[..., np.newaxis]
    change = np.diff(np.abs(wind.shape_samples), axis=-1)
    fallen = np.logical_or.accumulate(change < -ROUNDING * size, axis=-1)
    return np.asarray(np.any(fallen & (change > ROUNDING * size), axis=-1))


def is_sufficient(plant: Plant, wind: History, limit: ArrayLike, dead_band: ArrayLike = 1.0) -> Any:
    """Return whether a limit is at least the required deflection of linear theory.

    It is at nominal dynamic pressure; a `Study` has the verdict on a vehicle.

    Parameters
    ----------
    plant, wind, dead_band
        Plant, wind angle of one sign [rad], and dead band K in [0, 1]; one each, or batches.
    limit : array_like
        Capability delta_max [rad]; its sign is ignored.

    Returns
    -------
    bool or ndarray of bool
        Whether it is at or above `required_deflection`. A real autopilot lets go of deflection it
        no longer needs, so every capability above that is sufficient. (A history that *holds*
        more than the boundary for ever is not stable by (4b); that is the question of `judge`.)

    Raises
    ------
    InputError
        As `required_deflection`, and for a limit of zero.
    """
    capability = np.abs(small_angle("a deflection", nonzero)("limit", limit))  # [rad]
    needed = np.abs(required_deflection(plant, wind, dead_band).deflection)
    if beyond := beyond_linear(float(np.max(np.abs(wind.peak)))):
        warnings.warn(beyond, stacklevel=2)
    sufficient = np.asarray(covers(capability, needed))
    return sufficient if sufficient.ndim else bool(sufficient)


def covers(limit: ArrayLike, needed: ArrayLike) -> Any:
    """Return whether a limit is at least the required one, but for rounding.

    `limit`, `needed`: sizes [rad] of any shapes that broadcast.
    """
    return np.asarray(limit) >= np.asarray(needed) * (1.0 - 4.0 * np.finfo(float).eps)


def survivable_peak(
    plant: Plant, wind: History, limit: ArrayLike, dead_band: ArrayLike = 1.0
) -> Any:
    """Return the largest peak [rad] of a wind of this shape that a limit survives in linear theory.

    It is at nominal dynamic pressure; a `Study` has the verdict on a vehicle.
    The inverse of `required_deflection`: ``|limit|/(y |B|)``, y being the required limit over the
    trim ``|B alpha_w,max|``, B trim deflection per wind angle. The peak has the sign of the wind,
    and is at most 30 deg: above that linear aerodynamics says nothing, and a limit that survives a
    peak of 30 deg may survive more, or not.

    Parameters
    ----------
    plant, wind, dead_band
        Plant, wind, of which only the shape counts, and dead band K in [0, 1]; or batches.
    limit : array_like
        Capability delta_max [rad]; its sign is ignored.

    Raises
    ------
    InputError
        As `required_deflection`, and for a limit of zero.
    """
    capability = np.abs(small_angle("a deflection", nonzero)("limit", limit))  # [rad]
    needed = np.abs(required_deflection(plant, wind, dead_band).deflection)
    with np.errstate(divide="ignore", invalid="ignore"):
        peak = np.abs(wind.peak) * (capability / needed)
    peak = np.where(needed == 0.0, MAX_LINEAR_ANGLE, np.minimum(peak, MAX_LINEAR_ANGLE))
    return plain(np.copysign(peak, wind.peak))


_MAX_SHOWN_SWITCHES = 6
"""Number of switch times that are shown."""


@dataclass(frozen=True, eq=False)
class KnownWind(Shown):
    """Minimum peak deflection in a known wind, with the numbers it is compared with.

    `start` is the first time [s] of the deflection, `horizon` that from which it is zero, or None.
    `best` is the deflection of minimum peak, `limited` that with a rate limit; None without one.
    """

    plant: Plant
    wind: History
    start: float
    horizon: float | None
    best: Optimum = field(
        metadata=specs(
            Field("peak", "angle", of="best.peak"),
            Field("switch_times", "time", of="best.switch_times"),
            Field("status", of="best.status"),
            Field("certificate", of="best.certificate"),
        )
    )
    limited: RateLimitedOptimum | None = None

    @classmethod
    def of(
        cls,
        plant: Plant,
        wind: History,
        start: float,
        horizon: float | None = None,
        rate_limit: float | None = None,
    ) -> Self:
        """Return the minimum peak of a plant in a wind that is known.

        `start`: first time [s] of the deflection. `horizon`: time [s] from which it is zero, by
        default never. `rate_limit` [rad/s]: also with this limit. `InputError` as
        `optimum_deflection` and `optimum_with_rate_limit`.
        """
        best = optimum_deflection(plant, wind, start, horizon)
        limited = None
        if rate_limit is not None:
            limited = optimum_with_rate_limit(plant, wind, rate_limit, start, horizon)
        return cls(plant, wind, start, horizon, best, limited)

    @property
    def deflection(self) -> History:
        """Deflection [rad] of minimum peak, with the rate limit where there is one."""
        return (self.limited or self.best).deflection

    @property
    @derived("angle", label=STATIC_TRIM)
    def trim(self) -> float:
        """Static trim [rad]: the largest deflection of ideal trim."""
        return abs(float(self.plant.coefficients.B * self.wind.peak))

    @property
    @derived()
    def fraction_of_trim(self) -> float | None:
        """Minimum peak over static trim; None without trim."""
        return self.best.peak / self.trim if self.trim else None

    @property
    @derived("angle", label="fast pole alone (K = 0)", infinite=NONE_SUFFICIENT)
    def constant(self) -> float:
        """Boundary limit [rad] at K = 0, a deflection that is constant from the onset on.

        It holds the fastest unstable mode alone.
        """
        return abs(float(boundary_limit(self.plant, self.wind, 0.0).deflection))

    @property
    @derived()
    def first_segment(self) -> str:
        """Direction of the deflection of minimum peak in its first segment, in words.

        That deflection, `best`, is constant in segments, with both signs in turn. It opposes the
        wind where it has the sign of trim, which is -B times the wind's angle, B being trim
        deflection per angle of attack.
        """
        deflection = self.best.deflection
        if np.isinf(deflection.onset):
            return "none"
        first = np.sign(deflection(np.nextafter(deflection.onset, np.inf)))  # just after the onset
        against = -np.sign(self.plant.coefficients.B * self.wind.peak)  # sign of trim
        return "opposes the wind" if first == against else "goes with the wind"

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        more = {} if self.limited is None else {"with_rate_limit": self.limited}
        return document(self) | more

    def dead_band_table(
        self, caption: str, dead_bands: FloatArray, required: RequiredDeflection | None
    ) -> Table:
        """Return the table of the required deflection by dead band, ``(n,)``, and of the minimum.

        `required`: requirement of the wind at these dead bands, or None.
        The last column, what sets it, is dropped where that is always the boundary of the control.
        """
        head: tuple[str, ...] = ("dead band", "required [deg]", "over trim", "set by")
        rows: list[tuple[Line, ...]] = []
        if required is not None:
            columns = np.abs(required.deflection), required.limit, required.governs
            for K, size, ratio, governs in zip(dead_bands, *columns, strict=True):
                cells = degrees(f"K.{K:g}.deflection", size), number(f"K.{K:g}.limit", ratio)
                finite_or_text = map(minimum_limit, cells)  # "none is sufficient" if infinite
                rows.append(((f"K = {K:g}",), *finite_or_text, (str(governs),)))
        fraction = np.nan if self.fraction_of_trim is None else self.fraction_of_trim
        minimum = degrees("optimum.peak", self.best.peak), number("optimum.fraction", fraction)
        rows.append(((WIND_KNOWN,), *minimum, (str(Reason.MINIMUM),)))
        *requirements, _minimum = rows
        if all(set_by == (str(Reason.BOUNDARY),) for *_, set_by in requirements):
            head, rows = head[:-1], [row[:-1] for row in rows]
        return Table(caption, head, tuple(rows))

    def verdict(self, wind: str = "this wind") -> str:
        """Return the minimum peak in words, a lower bound of every control with its start.

        `wind`: the wind in words.
        """
        start, onset = self.start + 0.0, float(self.wind.onset)  # + 0.0: -0.0 is shown as 0
        times = [f"begins at {start:g} s"] if start != onset and np.isfinite(onset) else []
        times += [] if self.horizon is None else [f"ends at {self.horizon:g} s"]
        control = f"no control{' that ' if times else ''}{' and '.join(times)}"
        of_trim = "" if self.fraction_of_trim is None else f", {self.fraction_of_trim:.3f} of trim"
        peak = f"{np.degrees(self.best.peak):.3f} deg{of_trim}"
        return f"{WIND_KNOWN}: {peak}; {control} survives {wind} with less"

    def table(self, caption: str) -> Table:
        """Return the table of the peak `best`, its certificate, and numbers to compare with it.

        These are the peak with the rate limit (`limited`), trim, and a constant deflection.
        """
        best, proof = self.best, self.best.certificate
        peak = degrees("optimum.peak", best.peak, unit="deg")
        if self.fraction_of_trim is not None:
            fraction = number("optimum.fraction_of_trim", self.fraction_of_trim)
            peak = (*peak, " (", *fraction, " of trim)")
        shown: list[Row] = [(WIND_KNOWN, peak)]
        if self.limited is not None:
            rate = f"with {np.degrees(self.limited.rate):.4g} deg/s"
            limited = degrees("optimum.limited", self.limited.peak, unit="deg")
            shown.append((rate, (*limited, f", {self.limited.status}")))
        switches = (
            ", ".join(f"{t:.4g} s" for t in best.switch_times[:_MAX_SHOWN_SWITCHES]) or "none"
        )
        more = best.switch_times.size - _MAX_SHOWN_SWITCHES
        gap = significant("optimum.gap", proof.gap, 2)
        shown += [
            *rows(self, "optimum", "first_segment"),
            ("switches", (switches + (f" and {more} more" if more > 0 else ""),)),
            *rows(self, "optimum", "trim", "constant"),
            *rows(proof, "optimum", "dual"),
            ("certificate", ("gap ", *gap, f", {best.status}")),
        ]
        return quantities(caption, shown)
