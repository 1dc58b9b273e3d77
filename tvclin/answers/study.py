"""One vehicle, one wind: the whole answer as one value."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.case import Case
from tvclin.answers.nozzle import Nozzle
from tvclin.answers.planes import PlanesNeeded, of_heading, words_of
from tvclin.answers.requirement import RequiredDeflection, covers, required_deflection
from tvclin.answers.sizing.wind_sign import FROZEN, SIGNS, sign_factors, survived_size
from tvclin.answers.study_notes import (
    along_the_path,
    doubts,
    forecast_trusted,
    gust_placed,
    left_out,
    slow_or_paired,
    undamped,
)
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import picked
from tvclin.base.errors import (
    InputError,
    between,
    instance,
    nonnegative,
    number,
    one_of,
    single,
    within,
)
from tvclin.base.tables import FileTable
from tvclin.boundary.forecast_free import ForecastFreeLimit, forecast_free_limit
from tvclin.boundary.limit import BoundaryLimit, boundary_limit
from tvclin.boundary.optimum.minimum_peak import Optimum, optimum_deflection
from tvclin.boundary.optimum.two_poles import single_pole_validity
from tvclin.boundary.stops import Stop, stop_of
from tvclin.linear.deflections import SWITCHES
from tvclin.linear.models import USUAL_MODEL, models_of
from tvclin.linear.modes import Modes, unstable_modes
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.linear_vehicle import AnyVehicle, coefficients_of, whole_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.shaped import PULSES, ShapedWind

_LEAST_SIZE, _LARGEST_SIZE = 0.01, 1e9
_SIZES = 5
"""Sizes of a wind at which what its sign changes is computed for dispersed winds."""
DEAD_BANDS = (1.0, 0.75, 0.5, 0.25, 0.0)
STUDY_TABLE = FileTable(
    "[study]", words=("vehicle", "model", "plane", "dead_band", "switch", "sign")
)


@dataclass(frozen=True, eq=False)
class Study(Shown):
    """What a booster needs to survive a wind, and whether a given limit is enough.

    Attributes
    ----------
    case : Case
        The vehicle, one, in its wind, with its nozzle; the verdict rests on its model.
    coefficients : Coefficients
        Its linear coefficients in that plane.
    wind : RectangularWind or TriangularWind
        The wind in the plane, without its gust.
    switch : str
        What leaves the dead band of the boundaries shown, as in `trim_then_hold`. The verdict is
        always that of a flight, whose trim itself leaves it.
    sign : {"head", "tail", "frozen"} or None
        The sign of the wind along the path that counts; frozen: the dynamic pressure of calm air;
        None: the worst of these.
    modes : dict of str to Modes
        Unstable poles of every model.
    trim_deflection : float
        ``|B alpha_w,max|`` [rad], the largest deflection that ideal trim without drift takes.
    boundaries : dict of str to BoundaryLimit
        For "fixed-path" and for a model with drift, the boundary at each of `dead_bands`.
    dead_bands : ndarray
        K, falling; the dead band of the verdict is among them.
    dead_band : float
        K of the verdict.
    requirement : RequiredDeflection
        What a limit must be at `model` and `dead_band`, and what governs it, in the dynamic
        pressure of calm air.
    sign_factors : dict of str to float
        What is required of a head and of a tail wind, over that; empty where the wind blows across
        the path, or what its sign changes is not known.
    sufficient : bool or None
        Whether the limit is at or above what is required.
    survivable_peak : float or None
        The largest peak [rad] of such a wind that the limit survives; of what, says `peak_of`.
    forecast_free : dict of str to ForecastFreeLimit
        For the models of `boundaries` that have one, the least deflection of any law that does
        not know when the wind will stop.
    minima : dict of str to float
        For the same models the least peak [rad] when the whole wind is known, appendix C.
    notes : tuple of str
        What the reader should know before believing the numbers; often nothing.
    blows : ShapedWind
        The wind in the plane, with its gust.
    planes : PlanesNeeded or None
        What a wind with a direction asks of both planes at the dead band and model of the verdict.
    """

    case: Case
    coefficients: Coefficients
    wind: Any
    switch: str
    sign: str | None
    modes: dict[str, Modes]
    trim_deflection: float
    boundaries: dict[str, BoundaryLimit]
    dead_bands: FloatArray
    dead_band: float
    requirement: RequiredDeflection
    sign_factors: dict[str, float]
    sufficient: bool | None
    survivable_peak: float | None
    forecast_free: dict[str, ForecastFreeLimit]
    minima: dict[str, float]
    blows: ShapedWind
    notes: tuple[str, ...] = ()
    planes: PlanesNeeded | None = None

    _keys = (
        "vehicle=vehicle.name model plane wind=shape peak_deg=wind.peak duration_s=wind.duration"
        " dead_band required_deflection_deg governed_by=governs trim_deflection_deg limit_deg"
        " sufficient survivable_peak_deg=|survivable_peak|"
    )

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
        stop: Stop | str | None = None,
    ) -> Self:
        """Return the study of a vehicle in a wind, and the verdict on a limit.

        Parameters
        ----------
        vehicle, model, plane
            As of `Case`.
        wind : {"triangular", "rectangular"}
            Shape of the wind.
        duration, peak, heading, gust, gust_at
            Of the wind [s, rad], as of `ShapedWind`.
        limit, stop
            As of `Nozzle`.
        dead_band, switch, sign
            As of `of`.

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
        one_of("wind", wind, PULSES)
        blows = ShapedWind(wind, peak, duration, heading, gust, gust_at)
        nozzle, model = Nozzle(limit=limit, stop=stop), "" if model is None else model
        case = Case(vehicle=vehicle, model=model, plane=plane, wind=blows, nozzle=nozzle)
        return cls.of(case, dead_band, switch, sign)

    @classmethod
    def of(
        cls,
        case: Case,
        dead_band: float = 1.0,
        switch: str = "literal",
        sign: str | None = None,
    ) -> Self:
        """Return the boundaries of a case, and the verdict on the limit of its nozzle.

        With a stop of both planes the verdict is on both. Of a wind with a direction the boundaries
        are those of its part in the plane.

        Parameters
        ----------
        case : Case
            One vehicle in a wind of straight lines.
        dead_band : float
            K of the verdict, in [0, 1].
        switch : {"literal", "report"}
            What leaves the dead band of the boundaries shown, as in `trim_then_hold`.
        sign : {"head", "tail", "frozen"}, optional
            Which sign of a wind along the path the verdict counts, with the dynamic pressure that
            the vehicle meets in it; frozen: that of calm air, as in the report. Without it the
            worst of these; a wind with a direction has its own.

        Raises
        ------
        InputError
            For a sign where what it changes is not known, a stop without a heading, a wind that
            does nothing in the plane, and for a batch of vehicles or gusts, a wind and gust whose
            sum changes its sign, a wind of another shape, and a dead band out of range.
        """
        instance("case", case, Case, "of a vehicle, a wind and a nozzle")
        one_of("switch", switch, SWITCHES)
        if sign is not None:
            one_of("sign", sign, (*SIGNS, FROZEN))
        dead_band = number("dead_band", dead_band, between(0.0, 1.0))
        model, plane, wind = case.model, case.plane, pulse_of(case)
        coefficients = coefficients_of(case.vehicle, plane)
        single("vehicle", coefficients.batch)
        stop = None if case.nozzle.stop is None else stop_of(case.nozzle.stop)
        blows, planes = case.blows_at(dead_band), None
        assert isinstance(blows, ShapedWind)
        if wind.heading is not None:
            whole = whole_vehicle(case.vehicle, "a wind with a direction")
            placed = replace(wind, gust_at=blows.gust_at)
            planes = of_heading(whole, model, placed, stop, dead_band)
        elif stop is not None:
            raise InputError(
                "a stop of both planes needs a wind with a direction: give where it blows from,"
                " and the azimuth of the flight"
            )
        plants = {name: Plant(coefficients, name) for name in models_of(case.vehicle)}
        alone, history = replace(blows, gust=None).history({}), blows.history({})
        dead_bands = np.array(sorted({*DEAD_BANDS, dead_band}, reverse=True))
        with_drift = model if model != "fixed-path" else USUAL_MODEL
        shown = {name: plants[name] for name in ("fixed-path", with_drift) if name in plants}
        plant = plants.get(model) or Plant.from_vehicle(case.vehicle, model, plane)
        required = required_deflection(plant, history, dead_band)
        modes = {name: unstable_modes(each) for name, each in plants.items()}
        needed = _needed(shown, history, dead_bands, switch)
        free = needed["forecast_free"].get(plant.model)
        needs = float(required.deflection)
        factors, unknown = _factors(case, history, needs, dead_band, sign)
        notes = (
            *slow_or_paired(plant, history, required, dead_band),
            *left_out(plant, modes),
            *forecast_trusted(required, dead_band, free),
            *undamped(plant, history, required, dead_band),
            *doubts(case.vehicle),
            *gust_placed(wind, blows),
            *along_the_path(case, history, sign, unknown),
            *words_of(planes, plane, stop is not None),
        )
        found = cls(
            case=case,
            coefficients=coefficients,
            wind=alone,
            switch=switch,
            sign=sign,
            modes=modes,
            trim_deflection=abs(float(coefficients.B * history.peak)),
            dead_bands=dead_bands,
            dead_band=dead_band,
            requirement=required,
            sign_factors=factors,
            sufficient=None,
            survivable_peak=None,
            notes=notes,
            blows=blows,
            planes=planes,
            **needed,
        )
        return found if found.limit is None else replace(found, **found._judged(found.limit))

    @property
    def vehicle(self) -> AnyVehicle:
        """The vehicle."""
        return self.case.vehicle

    @property
    def plane(self) -> str:
        """The plane of the boundaries, and of the verdict where that is not on both."""
        return self.case.plane

    @property
    def model(self) -> str:
        """The model on which the verdict rests."""
        return self.case.model

    @property
    def limit(self) -> float | None:
        """The capability [rad] in question."""
        return self.case.nozzle.limit

    @property
    def shape(self) -> str:
        """Shape of the wind, a key of `winds.shaped.PULSES`."""
        return self.blows.shape

    @property
    def slanting(self) -> ShapedWind | None:
        """The wind with its direction, where that is known, its gust at its time."""
        wind = self.case.wind
        if not isinstance(wind, ShapedWind) or wind.heading is None:
            return None
        return replace(wind, gust_at=self.blows.gust_at)

    @property
    def in_both(self) -> bool:
        """Whether the verdict is on both planes."""
        return self.case.nozzle.stop is not None

    @property
    def required_deflection(self) -> float:
        """The deflection [rad] that is required at the verdict's model and dead band, a size."""
        return self.frozen_deflection * self.counts[1]

    @property
    def frozen_deflection(self) -> float:
        """The same [rad] in the dynamic pressure of calm air."""
        if self.planes is not None and self.in_both:
            return self.planes.deflection
        return abs(float(self.requirement.deflection))

    @property
    def sign_needs(self) -> dict[str, float]:
        """What is required [rad] of a head and of a tail wind, by `sign_factors`."""
        return {name: self.frozen_deflection * one for name, one in self.sign_factors.items()}

    @property
    def counts(self) -> tuple[str, float]:
        """Which sign of the wind counts, and its factor on `frozen_deflection`."""
        if self.sign in self.sign_factors:
            return str(self.sign), self.sign_factors[str(self.sign)]
        every = {FROZEN: 1.0} | self.sign_factors
        name = max(every, key=lambda one: every[one])
        return name, every[name]

    def factors_at(self, sizes: ArrayLike) -> FloatArray:
        """Return the factor of the sign that counts in winds of so many times this size.

        Between a few sizes it is interpolated; infinite for a wind that turns the path too far.

        Raises
        ------
        InputError
            For sizes that are negative, or no numbers.
        """
        wanted = within("sizes", nonnegative("sizes", sizes), 0.0, _LARGEST_SIZE)
        name, factor = self.counts
        if name == FROZEN or np.all(wanted == 1.0):
            return np.full(wanted.shape, factor)
        wanted = np.maximum(wanted, _LEAST_SIZE)
        nodes = np.linspace(wanted.min(), wanted.max(), _SIZES)
        found = [self._factor_at(float(size)) for size in nodes]
        between = np.interp(wanted, nodes, found)
        return np.where(np.isnan(between), np.inf, between)

    def _factor_at(self, size: float) -> float:
        """The same of one size."""
        name = self.counts[0]
        if name == FROZEN:
            return 1.0
        asked = None if self.slanting is not None else name
        try:
            return sign_factors(self.case, self.history, self.dead_band, asked, size)[name]
        except InputError:
            return np.inf

    def _judged(self, limit: float) -> dict[str, Any]:
        """Whether a limit is enough, and what peak it survives."""
        needed = self.required_deflection
        peak = self.planes.peak if self.planes is not None and self.in_both else self.history.peak
        size = limit / needed if needed else np.inf
        if self.counts[0] != FROZEN and 0.0 < size < np.inf:
            size = survived_size(
                limit, lambda size: size * self.frozen_deflection * self._factor_at(size)
            )
        return {"sufficient": bool(covers(limit, needed)), "survivable_peak": float(peak) * size}

    @property
    def gust(self) -> History | None:
        """What blows on top of the wind, in its time; its part in the plane."""
        return self.blows.placed_gust

    @property
    def history(self) -> History:
        """The wind in the plane with its gust."""
        return self.blows.history({})

    @property
    def of_both(self) -> float:
        """What both planes take of the stop over what this one takes; one if it is judged alone."""
        return self.planes.over(self.plane) if self.planes is not None and self.in_both else 1.0

    @property
    def governs(self) -> str:
        """What the required deflection is governed by, in words."""
        name = self.counts[0]
        if name != FROZEN:
            return f"the dynamic pressure in a {name} wind"
        if self.planes is not None and self.in_both:
            return self.planes.governs
        return self.requirement.governs

    @property
    def peak_of(self) -> str:
        """Of what the peak is that the limit survives, where the wind has a direction."""
        if self.slanting is None:
            return ""
        if self.in_both:
            return "of the wind's vector in both planes"
        return f"of the wind's part in the {self.plane} plane"

    @property
    def needs(self) -> dict[str, dict[str, float]]:
        """Sizes [rad] by model: what no law without a forecast undercuts, and what no control."""
        free = {name: abs(float(one.deflection)) for name, one in self.forecast_free.items()}
        return {"forecast_free": free, "minimum": self.minima}

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        v, slanting, planes = self.vehicle, self.slanting, {}
        if self.planes is not None and slanting is not None:
            planes["planes"] = {
                **picked(slanting, "heading_deg"),
                **picked(self.planes, "peak_deg"),
                "stop": repr(self.planes.stop),
                **picked(self.planes, "required_deflection_deg=deflection alone_deg"),
                "pitch_alone_misses": self.planes.misses("pitch"),
                "judged": self.in_both,
            }
        gust = (
            None if self.gust is None else picked(self.gust, "peak_deg begins_s=onset ends_s=end")
        )
        return {
            "vehicle": v if isinstance(v, Vehicle) else {"name": v.name},
            **picked(self, "plane coefficients"),
            "wind": {"shape": self.shape, **picked(self.wind, "peak_deg duration_s")},
            "gust": gust,
            **planes,
            "unstable_poles_per_s": {name: modes.poles for name, modes in self.modes.items()},
            **picked(self, "trim_deflection_deg"),
            "boundaries": {
                name: {"dead_band": self.dead_bands, **found.as_dict()}
                for name, found in self.boundaries.items()
            },
            **picked(self, "forecast_free minimum_deg=minima notes"),
            "verdict": picked(
                self,
                "model dead_band switch sign required_deflection_deg governed_by=governs"
                " requirements_deg=requirement.needs frozen_deflection_deg sign_factors limit_deg"
                " sufficient"
                " survivable_peak_deg=|survivable_peak| survivable_peak_of=peak_of",
            ),
        }


def pulse_of(case: Case) -> ShapedWind:
    """Return the wind of a case; `InputError` for one that is not of one shape."""
    if not isinstance(case.wind, ShapedWind):
        raise InputError(
            "a study needs a wind of one shape: give shape, peak and duration in [wind]"
        )
    one_of("shape of the wind of a study", case.wind.shape, PULSES)
    return case.wind


def _needed(
    plants: dict[str, Plant], wind: History, dead_bands: FloatArray, switch: str
) -> dict[str, Any]:
    """What each model needs: with dead bands, without a forecast, and with a complete one."""
    best = _where_defined(_optimum, plants, wind)
    return {
        "boundaries": {k: boundary_limit(p, wind, dead_bands, switch) for k, p in plants.items()},
        "forecast_free": _where_defined(forecast_free_limit, plants, wind),
        "minima": {name: optimum.peak for name, optimum in best.items()},
    }


def _factors(
    case: Case, history: History, needed: float, dead_band: float, sign: str | None
) -> tuple[dict[str, float], str]:
    """What the sign of a wind changes, and why it is not known; what is asked for must be."""
    if not np.isfinite(needed):
        return {}, ""
    try:
        return sign_factors(case, history, dead_band, sign), ""
    except InputError as error:
        if sign is not None:
            raise
        return {}, str(error)


def _optimum(plant: Plant, wind: History) -> Optimum:
    """The least peak of a control from t = 0 on, or from the onset of a gust before that."""
    return optimum_deflection(plant, wind, min(0.0, float(wind.onset)))


def _where_defined(
    function: Callable[..., Any], plants: dict[str, Plant], wind: History
) -> dict[str, Any]:
    """What a function of plant and wind says of each model for which it is defined."""
    found = {}
    for name, plant in plants.items():
        with suppress(InputError):
            found[name] = function(plant, wind)
    return found


def outlasts_one_pole(study: Study) -> bool:
    """Return whether the wind lasts longer than `single_pole_validity` allows."""
    return bool(study.wind.duration > single_pole_validity(study.coefficients))
