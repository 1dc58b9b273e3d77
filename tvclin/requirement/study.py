"""Study: the answer for one vehicle in one wind, with the notes on its validity."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from math import radians
from typing import Any, Self

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, instance, one_of
from tvclin.base.fields import Field, document, spec, specs
from tvclin.base.quantities import FORECAST_FREE, NOMINAL
from tvclin.boundary.forecast_free import ForecastFreeLimit, forecast_free_limit
from tvclin.boundary.limit import PAIRED_POLES, BoundaryLimit, boundary_limit
from tvclin.boundary.limit_shapes import LimitShape
from tvclin.boundary.open_loop import ROUNDING, Reason, with_larger_requirements
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.case.case import Case
from tvclin.case.nozzle import Nozzle
from tvclin.linear.deflections import SWITCHES
from tvclin.linear.modes import Modes, unstable_modes
from tvclin.linear.plant import DEFAULT_MODEL, ONE_POLE, Plant, models_of
from tvclin.requirement.case_requirement import CaseRequirement, case_requirement, pulse_of
from tvclin.requirement.nominal_requirement import RequiredDeflection, required_deflection
from tvclin.requirement.plane_requirement import direction_notes
from tvclin.requirement.required_quantity import deflection_warnings
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.linear_vehicle import AnyVehicle, LinearVehicle, coefficients_of
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle import vehicle_warnings as warnings_by_number
from tvclin.winds.histories import History
from tvclin.winds.shaped import SHAPES, ShapedWind
from tvclin.winds.wind_angles import (
    CROSS,
    FROZEN,
    MAX_LINEAR_ANGLE,
    SIGNS,
    linear_notes,
    pressure_ratio,
)

_MAX_NOMINAL_PRESSURE_ANGLE_RAD = radians(1.5)
"""Wind angle [rad] above which the change of dynamic pressure exceeds the error of the boundary."""

_MAX_STRAIGHT_PATH_RAD2_S = 300.0 * radians(1.0) ** 2
"""Squared wind angle times duration [rad^2 s], about 5 deg for 12 s, above which nonlinear flights
may require a percent more in a head wind."""
_MAX_FROZEN_PLATEAU_S = 5.0
"""Time [s] near the peak of a wind above which parameters vary enough for a few percent."""
_SAMPLES = 200
"""Number of times at which a wind is compared with its peak."""
_POLE_REDUCTION = 0.04
"""Relative reduction of the pole of a booster by the damping of air and jet, about."""
_MAX_DURATION_TIME_CONSTANTS = 2.5
"""Duration over the time constant of the pole, above which a slower pole may require more."""
OUTLASTS = "is too long for the single-pole theory"
"""Words on a wind in the notes of a study."""
TRUSTS = "trusts a forecast"
"""Words on a dead band in the notes of a study."""


def vehicle_warnings(vehicle: AnyVehicle) -> Iterator[str]:
    """Yield warnings on implausible or unknown numbers of a vehicle."""
    if not isinstance(vehicle, LinearVehicle):
        yield from warnings_by_number(vehicle)
    elif not vehicle.path_known:
        yield (
            "the flight path is fixed: the drift with the wind is not known from mu_alpha and"
            " mu_delta, and a long wind may require more"
        )


def uncounted_sign(sign: str | None) -> str:
    """Return the note on a sign of a wind in the yaw plane."""
    return f"sign {sign} is not counted: a wind in the yaw plane blows across the path"


def along_the_path(need: CaseRequirement) -> Iterator[str]:
    """Yield notes on the direction of a wind, and on its change of the dynamic pressure.

    Large head winds turn the path, on which the pressure encountered rests; a sign is not counted
    in a cross wind; in the pitch plane the change of the pressure may not have been computed: not
    with the sign `FROZEN`. `need`: requirement of the wind of the study.
    """
    wind, peak = need.history, abs(float(need.history.peak))
    size = peak**2 * float(wind.end - wind.onset)  # [rad^2 s]
    if need.direction == "head" and size > _MAX_STRAIGHT_PATH_RAD2_S:
        yield (
            "in a head wind of this size and duration nonlinear flights, whose path turns, require"
            " more, in triangles by 1 to 4 percent for the report's vehicles (tvclin fly --engine"
            " planar-varying)"
        )
    if need.sign in SIGNS and need.direction == CROSS:
        yield uncounted_sign(need.sign)
    if need.plane != "pitch" or peak <= _MAX_NOMINAL_PRESSURE_ANGLE_RAD:
        return
    changes = "this wind along the path also changes the dynamic pressure, which is frozen here"
    if need.sign == FROZEN:
        yield f"{changes}, as requested: a head wind requires more"
    elif need.encountered_unknown:
        yield f"{changes}; the requirement in a head wind is not known: {need.encountered_unknown}"


def frozen_parameters(wind: History) -> Iterator[str]:
    """Yield a note where parameters that vary along a flight change what a wind requires.

    That is a wind which stays near its peak for long. `wind`: wind angle of attack [rad].
    """
    duration = float(wind.end - wind.onset)
    times = float(wind.onset) + duration * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    near_peak = np.mean(np.abs(wind(times)) >= 0.9 * abs(float(wind.peak)))
    plateau = duration * float(near_peak)  # [s]
    if plateau > _MAX_FROZEN_PLATEAU_S:
        yield (
            f"the vehicle is frozen: a wind that stays near its peak for {plateau:.3g} s may"
            " require more along a flight, by about 1 percent for each second (tvclin ascent)"
        )


def nominal_pressure(case: Case) -> Iterator[str]:
    """Yield a note on the rise of the dynamic pressure in a head wind over the nominal one.

    `case`: with a wind in the pitch plane; no note for other planes.
    """
    peak = abs(float(getattr(case.wind, "peak", 0.0)))
    if (
        case.plane != "pitch"
        or not _MAX_NOMINAL_PRESSURE_ANGLE_RAD < peak <= MAX_LINEAR_ANGLE
        or not isinstance(case.vehicle, Vehicle)
    ):
        return
    ratio = float(pressure_ratio(case.vehicle.attitude, np.asarray(-peak)))
    if ratio > 1.0:
        yield (
            f"computed {NOMINAL}; a head wind of this size raises the pressure by up to"
            f" {float(f'{100.0 * (ratio - 1.0):.2g}'):g} percent and requires more"
        )


def gust_placed(specified: ShapedWind, need: CaseRequirement) -> Iterator[str]:
    """Yield a note on the time of a gust that was placed where it requires most.

    A gust against the wind is in its middle. `specified`: wind of the case. `need`: its
    requirement, with the gust at that time.
    """
    time, gust = need.wind_in_plane.gust_at, specified.gust
    if specified.gust_at is not None or gust is None:
        return
    if float(gust.peak) * specified.peak < 0.0:
        yield (
            "the gust blows against the wind, in its middle, where it lowers the requirement; at"
            " other times more may be required (peak_time_s in [gust] gives one)"
        )
    if time is None:
        return
    pressure = f" {NOMINAL}" if need.at_nominal_pressure else ""
    yield (
        f"the gust is at the worst time{pressure}, {time:.4g} s (peak_time_s in [gust] gives"
        " another)"
    )


def slow_or_paired(
    plant: Plant, wind: Any, required: RequiredDeflection, dead_band: float
) -> Iterator[str]:
    """Yield a note on a pair of unstable modes, or a wind too long for the single-pole theory.

    `required`: requirement of the wind `wind` on `plant`. `dead_band`: K, from 0 to 1.
    """
    if required.status == PAIRED_POLES:
        yield (
            "two unstable poles are a pair or equal here, and no limit satisfies condition (4b) of"
            " both: required is the largest trim deflection over K, so that the dead band is never"
            " left (tvclin boundary shows the minimum)"
        )
        return
    longest = float(single_pole_validity(plant.coefficients))  # duration [s]
    # with K = 1 the limited trim law was flown, which has all modes of the model
    flown = dead_band == 1.0 and plant.model not in ONE_POLE
    if wind.end - wind.onset > longest and required.governs == Reason.BOUNDARY and not flown:
        yield (
            f"a wind of more than {longest:.1f} s {OUTLASTS}: the slow mode of the flight path may"
            " then require more (tvclin boundary)"
        )


def unstable_modes_omitted(plant: Plant, modes: dict[str, Modes]) -> Iterator[str]:
    """Yield a note where the exact model has unstable modes that the model of `plant` omits.

    `modes`: unstable modes by model.
    """
    exact = DEFAULT_MODEL
    if plant.model not in ONE_POLE or exact not in modes:
        return
    more = modes[exact].poles.size > modes[plant.model].poles.size
    # where the longest wind that the single-pole theory covers is known, the note of
    # `slow_or_paired` says whether this wind is longer
    if more and np.isnan(single_pole_validity(plant.coefficients)):
        yield (
            f"the exact model has unstable modes that {plant.model} leaves out, and may need more"
            f" (--model {exact})"
        )


def forecast_trusted(
    required: RequiredDeflection, dead_band: float, free: ForecastFreeLimit | None
) -> Iterator[str]:
    """Yield a note where the required limit is below the bound of laws without a forecast.

    `dead_band`: K, from 0 to 1. `free`: that bound; None where it is not defined.
    """
    if free is None or dead_band == 1.0:
        return
    bound = abs(float(free.deflection))
    if bound > abs(float(required.deflection)) * (1.0 + ROUNDING):
        yield (
            f"K = {dead_band:g} {TRUSTS}: any {FORECAST_FREE} requires at least"
            f" {np.degrees(bound):.3f} deg"
        )


def undamped(
    plant: Plant, wind: Any, required: RequiredDeflection, dead_band: float
) -> Iterator[str]:
    """Yield a note where a vehicle without damping requires less, because its pole is faster.

    `required`: requirement of the wind `wind` on `plant`, without damping. `dead_band`: K, from 0
    to 1.
    """
    c = plant.coefficients
    mu_alpha = float(c.mu_alpha)  # [1/s^2]
    if dead_band == 1.0 or np.any(c.damping) or mu_alpha <= 0.0:
        return
    pole = float(c.pole)  # [1/s]
    if float(wind.end - wind.onset) * pole <= _MAX_DURATION_TIME_CONSTANTS:
        return
    slower = (1.0 - _POLE_REDUCTION) * pole
    # the pole p of a vehicle with the damping d has p (p + d) = mu_alpha
    damped = c.replace(damping=mu_alpha / slower - slower)
    needed = required_deflection(Plant(damped, plant.model), wind, dead_band)
    damped_limit, undamped_limit = (abs(float(r.deflection)) for r in (needed, required))
    if damped_limit > undamped_limit * (1.0 + ROUNDING):
        excess = damped_limit / undamped_limit - 1.0
        yield (
            "no pitch_damping is given, and leaving it out is not conservative here: a pole"
            f" {100 * _POLE_REDUCTION:.0f} percent slower would need {100 * excess:.1f}"
            " percent more"
        )


_SURVIVES = "the limit survives peaks of up to"
DEAD_BANDS = (1.0, 0.75, 0.5, 0.25, 0.0)


@dataclass(frozen=True, eq=False)
class Study(CaseRequirement, Shown):
    """Required deflection of a booster in a wind, and the verdict on a limit.

    It has all of `CaseRequirement`, on which the verdict rests.

    Attributes
    ----------
    coefficients : Coefficients
        The vehicle's linear coefficients in the plane.
    wind : RectangularWind or TriangularWind
        The wind in the plane, without its gust.
    switch : str
        What leaves the dead band of the boundaries shown, as in `trim_then_hold`. The verdict is
        always for a flight, whose trim itself leaves it.
    modes : dict of str to Modes
        Unstable poles of every model.
    trim_deflection : float
        ``|B alpha_w,max|`` [rad], the largest deflection that ideal trim without drift takes.
    boundaries : dict of str to BoundaryLimit
        For "fixed-path" and for a model with drift, y(K) of eq (4b) at each of `dead_bands`.
    dead_bands : ndarray
        K, falling; the dead band of the verdict is among them.
    sufficient : bool or None
        Whether the limit is at or above what is required; None without a limit, in a wind
        of angles above 30 deg (`beyond_linear`), and where it covers the requirement at nominal
        dynamic pressure and that encountered is `unknown`.
    survivable_peak : float or None
        The largest peak [rad] of such a wind that the limit survives; of what, says `peak_of`. Up
        to `peak_bound`, at which the wind angle is 30 deg: what survives that may survive more.
        None without a limit, and where the dynamic pressure encountered is `unknown`.
    survivable_factor : float or None
        The survivable wind over this wind: of a wind by its speed the ratio of speeds.
    forecast_free : dict of str to ForecastFreeLimit
        For the models of `boundaries` that have one, the lower bound without a forecast.
    minima : dict of str to float
        For the same models the least peak [rad] when the whole wind is known, appendix C.
    notes : tuple of str
        What the reader should know before believing the numbers; often nothing.
    """

    coefficients: Coefficients
    wind: Any = field(
        metadata=specs(
            Field("wind", of="shape", document=False),
            Field("peak", "angle", of="wind.peak", document=False),
            Field("duration", "time", of="wind.duration", document=False),
        )
    )
    switch: str = field(metadata=spec(card=False))
    modes: dict[str, Modes]
    trim_deflection: float = field(metadata=spec("angle", document=False))
    boundaries: dict[str, BoundaryLimit]
    dead_bands: FloatArray
    sufficient: bool | None = field(metadata=spec())
    survivable_peak: float | None = field(
        metadata=specs(
            Field(kind="angle", of=lambda study: study.survivable_size),
            Field("survivable_peak_of", of="peak_of", card=False),
            Field("survivable_peak_is_bound", of="survives_bound", card=False),
        )
    )
    survivable_factor: float | None
    forecast_free: dict[str, ForecastFreeLimit]
    minima: dict[str, float]
    notes: tuple[str, ...] = ()

    @classmethod
    def from_vehicle(
        cls,
        vehicle: AnyVehicle,
        *,
        wind: str = "triangular",
        duration: float,
        peak: float,
        limit: float | None = None,
        dead_band: float = 1.0,
        model: str | None = None,
        plane: str = "pitch",
        switch: str = "literal",
        sign: str | None = None,
        gust: History | None = None,
        gust_at: float | None = None,
        heading: float | None = None,
        limit_shape: LimitShape | str | None = None,
    ) -> Self:
        """Return the study of a vehicle in a wind, and the verdict on a limit.

        Parameters
        ----------
        vehicle : Vehicle, LinearVehicle or Coefficients
            The vehicle at one time of its flight.
        wind : str
            Shape of the wind: "triangular", "rectangular" or "one-minus-cosine".
        duration : float
            Duration [s] of the wind.
        peak : float
            Peak [rad] of the wind angle of attack; head and tail wind count.
        limit : float, optional
            Deflection limit of the nozzle [rad], on which the verdict is.
        dead_band : float
            Dead band K of the verdict, in [0, 1].
        model, plane, sign
            Model, plane and direction of the wind, as in `Case`.
        switch : {"literal", "report"}
            Condition for the exit of the dead band, as in `of`.
        heading, gust, gust_at
            Direction, gust and time of the gust, as in `ShapedWind`.
        limit_shape
            Limit shape of both planes, as in `Nozzle`.

        Raises
        ------
        InputError
            As `Case`, `Nozzle` and `of`, and for an unknown shape and numbers out of range.

        Examples
        --------
        >>> import numpy as np, tvclin as tv
        >>> vehicle = tv.load_vehicle("configuration-i")
        >>> result = tv.Study.from_vehicle(vehicle, duration=7.5, peak=np.radians(5))
        >>> round(float(np.degrees(result.requirement.deflection)), 3)
        -0.351
        >>> round(float(np.degrees(result.required_deflection)), 3), result.governs
        (0.412, 'the dynamic pressure in a head wind')
        """
        one_of("wind", wind, SHAPES)
        shaped_wind = ShapedWind(wind, peak, duration, heading, gust, gust_at)
        nozzle, model = Nozzle(limit=limit, limit_shape=limit_shape), "" if model is None else model
        options: Any = {"model": model, "plane": plane, "wind": shaped_wind, "nozzle": nozzle}
        return cls.of(Case(vehicle=vehicle, sign=sign, **options), dead_band, switch)

    @classmethod
    def of(
        cls,
        case: Case,
        dead_band: float = 1.0,
        switch: str = "literal",
    ) -> Self:
        """Return the boundaries of a case, and the verdict on the limit of its nozzle.

        With a limit shape of both planes the verdict is on both. For a wind with a direction the
        boundaries are for its component in the plane.

        Parameters
        ----------
        case : Case
            A single vehicle in a wind of a shape.
        dead_band : float
            Dead band K of the verdict, in [0, 1].
        switch : {"literal", "report"}
            Switching at the exit of the dead band, on trim or on wind, of the boundaries shown; see
            `trim_then_hold`.

        Raises
        ------
        InputError
            For a sign whose effect is not known, a limit shape without a heading, a wind without a
            component in the plane, and for a batch of vehicles or gusts, a wind and gust whose
            sum changes its sign, a wind of another shape, and a dead band out of range.
        """
        instance("case", case, Case, "of a vehicle, a wind and a nozzle")
        one_of("switch", switch, SWITCHES)
        need = case_requirement(case, dead_band)
        model, history = case.model, need.history
        coefficients = coefficients_of(case.vehicle, case.plane)
        plants = {name: Plant(coefficients, name) for name in models_of(case.vehicle)}
        dead_bands = np.array(sorted({*DEAD_BANDS, need.dead_band}, reverse=True))
        with_drift = model if model != "fixed-path" else DEFAULT_MODEL
        shown = {name: plants[name] for name in ("fixed-path", with_drift) if name in plants}
        plant = plants.get(model) or Plant.from_vehicle(case.vehicle, model, case.plane)
        modes = {name: unstable_modes(plant_of_model) for name, plant_of_model in plants.items()}
        bounds = _bounds_by_model(shown, history, dead_bands, switch)
        required, K, judged = need.requirement, need.dead_band, need.judged
        # wind angle [rad] at the survivable peak, with a heading that of the vector of both planes
        survives = (judged["survivable_peak"] or 0.0) / need.judged_peak * need.wind_angle
        free, nominal = bounds["forecast_free"].get(plant.model), need.at_nominal_pressure
        theory_notes = forecast_trusted(required, K, free), undamped(plant, history, required, K)
        path_notes = (
            along_the_path(need),
            frozen_parameters(need.history),
            direction_notes(need.planes, case.plane, need.judges_both_planes, nominal),
        )
        notes = [
            deflection_warnings(need.required_deflection),
            linear_notes(need.wind_angle) or linear_notes(survives, _SURVIVES),
            slow_or_paired(plant, history, required, K),
            unstable_modes_omitted(plant, modes),
            *(() if need.beyond_linear else theory_notes),
            vehicle_warnings(case.vehicle),
            gust_placed(pulse_of(case), need),
            *(() if need.beyond_linear else path_notes),
        ]
        trim = abs(float(coefficients.B * history.peak))
        if need.beyond_linear:
            bounds, trim = _unknown(bounds), np.nan
        return cls(
            **vars(need),
            **judged,
            **bounds,
            coefficients=coefficients,
            wind=replace(need.wind_in_plane, gust=None).history({}),
            switch=switch,
            modes=modes,
            trim_deflection=trim,
            dead_bands=dead_bands,
            notes=tuple(chain.from_iterable(notes)),
        )

    @property
    def shape(self) -> str:
        """Shape of the wind, a key of `winds.shaped.SHAPES`."""
        return self.wind_in_plane.shape

    @property
    def gust(self) -> History | None:
        """Gust on top of the wind, in its time; its component in the plane."""
        return self.wind_in_plane.placed_gust

    @property
    def peak_of(self) -> str:
        """Text that names the wind of the survivable peak; empty for an angle alone.

        A wind by its speed is named by the survivable speed too, since the angle encountered is not
        in proportion to the speed. `slanting` is the wind if it has a heading, else None.
        """
        words, speed = "", self.placed.speed
        if self.slanting is not None:
            plane = f"part in the {self.plane} plane"
            words += f"'s {'vector in both planes' if self.judges_both_planes else plane}"
        if speed is not None and self.survivable_factor is not None:
            words += f" at {abs(speed * self.survivable_factor):.4g} m/s"
        if self.wind_in_plane.gust is not None:
            words += ", its gust included"
        return words and f"of the wind{words}"

    @property
    def survivable_size(self) -> float | None:
        """Size of the survivable peak [rad]; None where that is not known."""
        return None if self.survivable_peak is None else abs(self.survivable_peak)

    @property
    def survives_bound(self) -> bool | None:
        """Whether the survivable peak is only a lower bound; None without one.

        It is, at `peak_bound` [rad], the end of linear aerodynamics at a wind angle of 30 deg.
        """
        if self.survivable_peak is None:
            return None
        return abs(self.survivable_peak) >= abs(self.peak_bound) * (1.0 - ROUNDING)

    @cached_property
    def nominal_requirements(self) -> dict[str, FloatArray]:
        """Required deflections [rad] at nominal dynamic pressure at each of `dead_bands`, by model.

        They are sizes without sign, ``(k,)`` for each name of a linear model, the keys of
        `boundaries`; NaN in a wind beyond linear aerodynamics.
        """
        factor = np.nan if self.beyond_linear else 1.0
        requirements = {
            name: required_deflection(Plant(self.coefficients, name), self.history, self.dead_bands)
            for name in self.boundaries
        }
        return {name: factor * np.abs(x.deflection) for name, x in requirements.items()}

    @property
    def needs(self) -> dict[str, dict[str, float]]:
        """Lower bounds [rad] by model, of laws without a forecast and of every control."""
        free = {name: abs(float(limit.deflection)) for name, limit in self.forecast_free.items()}
        return {"forecast_free": free, "minimum": self.minima}

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        v, slanting, planes = self.vehicle, self.slanting, {}  # `slanting`: a wind with a heading
        if self.planes is not None and slanting is not None:
            planes["planes"] = {
                "heading_deg": np.degrees(slanting.heading or 0.0),
                **document(self.planes),
                "limit_shape": repr(self.planes.limit_shape),
                "pitch_omitted_fraction": self.planes.omitted_fraction("pitch"),
                "judged": self.judges_both_planes,
            }
        gust = None
        if self.gust is not None:
            gust = {
                **document(self.gust, "peak"),
                "begins_s": self.gust.onset,
                "ends_s": self.gust.end,
            }
        return {
            "vehicle": v if isinstance(v, Vehicle) else {"name": v.name},
            "plane": self.plane,
            "coefficients": self.coefficients,
            "wind": {"shape": self.shape, **document(self, "peak", "duration")},
            "gust": gust,
            **planes,
            "unstable_poles_per_s": {name: modes.poles for name, modes in self.modes.items()},
            **document(self, "trim_deflection"),
            "boundaries": {
                name: {
                    "dead_band": self.dead_bands,
                    **boundary.as_dict(),
                    "required_deflection_deg": np.degrees(self.nominal_requirements[name]),
                }
                for name, boundary in self.boundaries.items()
            },
            "forecast_free": self.forecast_free,
            "minimum_deg": {name: np.degrees(peak) for name, peak in self.minima.items()},
            "notes": self.notes,
            "verdict": document(self),  # all fields that the record specifies
        }


def _bounds_by_model(
    plants: dict[str, Plant], wind: History, dead_bands: FloatArray, switch: str
) -> dict[str, Any]:
    """Return boundary limits, bounds without a forecast and minimum peaks [rad], each by model.

    `plants`: plant of each model. `dead_bands`: K, ``(k,)``. `switch`: when the dead band is left,
    "literal" or "report". Models for which a bound is not defined are omitted from it.
    """
    boundaries, forecast_free, minima = {}, {}, {}
    start = min(0.0, float(wind.onset))  # first time [s] at which a control acts
    for name, plant in plants.items():
        # its status names the open-loop requirement where a slower mode makes that larger
        boundary = boundary_limit(plant, wind, dead_bands, switch)
        boundaries[name] = with_larger_requirements(plant, wind, dead_bands, boundary)
        with suppress(InputError):
            forecast_free[name] = forecast_free_limit(plant, wind)
        with suppress(InputError):
            minima[name] = optimum_deflection(plant, wind, start).peak
    return {"boundaries": boundaries, "forecast_free": forecast_free, "minima": minima}


def _unknown(bounds: dict[str, Any]) -> dict[str, Any]:
    """Return boundaries and bounds with NaN [rad], for winds beyond linear aerodynamics.

    `bounds`: boundary limits, bounds without a forecast and minimum peaks, each by model.
    """
    unknown = {
        key: {k: replace(x, deflection=x.deflection * np.nan) for k, x in bounds[key].items()}
        for key in ("boundaries", "forecast_free")
    }
    return unknown | {"minima": dict.fromkeys(bounds["minima"], np.nan)}
