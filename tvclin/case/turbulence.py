"""Turbulence of a study: its request in a file, and what it takes of an autopilot and its nozzle.

The loop is linear and frozen at its time, about its response to the wind of the study, and the
turbulence has acted for long before that wind. The largest of ``|mean|`` plus some standard
deviations is a criterion, not a verdict on survival: where the deflection meets its limit often,
the loop is no longer linear, and flights in sampled turbulence say the rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from tvclin.base import errors
from tvclin.base.cards import Shown
from tvclin.base.fields import checked, derived, file_table, quantity, rows, spec, word
from tvclin.base.lines import Row, Table, quantities
from tvclin.case.load import LoadBound
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.turbulence.covariance_history import CovarianceHistory, turbulence_history
from tvclin.control.turbulence.driven_loop import (
    ANGLE_OF_ATTACK,
    BENDING_MOMENT,
    DEFLECTION_RATE,
    LoadSlopes,
)
from tvclin.control.turbulence.loop_covariance import LoopCovariance, turbulence_covariance
from tvclin.vehicle.linear_vehicle import AnyVehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.turbulence import COMPONENTS, SEVERITIES, SPECTRA, Turbulence
from tvclin.winds.turbulence_table import read_turbulence, turbulence_of_levels

if TYPE_CHECKING:
    from tvclin.linear.flexible import AnyPlant

LEVELS = "level"
"""Key of the rows of turbulence over altitude."""
_FORMS = {"spectrum": SPECTRA, "component": COMPONENTS}
"""Names of the form of turbulence, the usual one first."""
_USUAL_SIGMAS, _MAX_SIGMAS = 3.0, 10.0
"""Standard deviations that count if none are specified, and the most that may."""
AFTER_WIND_S = 10.0
"""Time after the wind during which the largest deflection is searched [s]."""


@dataclass(frozen=True, kw_only=True)
class TurbulenceRequest:
    """Turbulence on top of the wind of a study, for its autopilot.

    Attributes
    ----------
    intensity : float, optional
        Standard deviation of the wind across the path [m/s].
    severity : str, optional
        Severity of MIL-F-8785C in place of the intensity: light, moderate or severe.
    exceedance : float, optional
        Probability with which the intensity of MIL-F-8785C is exceeded, in place of the intensity
        or a severity.
    altitude : float, optional
        Altitude [m] of a single time, for the intensities of MIL-F-8785C; along a flight its own
        altitudes count.
    length : float, optional
        Scale length [m]; by default MIL-F-8785C's.
    spectrum : str
        Form of the spectrum: dryden or von-karman.
    component : str
        Component across the path (transverse) or along it.
    cutoff_wavelength : float, optional
        Wavelength along the path [m] above which the turbulence is omitted, as a sounding holds it.
    table : Turbulence, optional
        In place of an intensity, turbulence over altitude with its spectrum and component: of the
        file in [turbulence], or of its levels.
    sigmas : float, optional
        Standard deviations that count on top of the response to the wind.
    probability : float, optional
        Probability with which the response stays within the standard deviations at a time, in
        place of their number.

    Raises
    ------
    InputError
        For numbers out of range, other than one of intensity, severity, exceedance and table, and
        both sigmas and a probability.
    """

    intensity: float | None = quantity("speed", None, errors.nonnegative)
    severity: str | None = word(SEVERITIES, None)
    exceedance: float | None = quantity("number", None, errors.positive)
    altitude: float | None = quantity("length", None)
    length: float | None = quantity("length", None, errors.positive)
    spectrum: str = word(SPECTRA, SPECTRA[0])
    component: str = word(COMPONENTS, COMPONENTS[0])
    cutoff_wavelength: float | None = quantity("length", None, errors.positive)
    sigmas: float | None = quantity(
        "number", None, errors.between(0.0, _MAX_SIGMAS), shown=f"{_USUAL_SIGMAS:g}"
    )
    probability: float | None = quantity("number", None, errors.fraction)
    table: Turbulence | None = None

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers out of range, and for none or several intensities.

        At most one of sigmas and probability may be given: each defines `factor`, the number of
        standard deviations that count.
        """
        checked(self)
        # `table` is what the keys or options file and level are read into; messages name these
        names = ("intensity", "severity", "exceedance", "table")
        requested = [name for name in names if getattr(self, name) is not None]
        if len(requested) != 1:
            raise errors.InputError(
                "turbulence needs one of intensity, severity, exceedance, file and level"
                f"{'; got ' + ' and '.join(requested) if requested else ''}"
            )
        if self.sigmas is not None and self.probability is not None:
            raise errors.InputError("turbulence takes sigmas or a probability, not both")
        if self.factor > _MAX_SIGMAS:
            raise errors.InputError("probability is too close to 1")
        _ = self.over_altitude  # refuses numbers out of range

    @property
    def factor(self) -> float:
        """Number of standard deviations that count on top of the response to the wind.

        Of a probability P it is the normal quantile of (1 + P)/2, for both sides of the response.
        """
        if self.probability is None:
            return _USUAL_SIGMAS if self.sigmas is None else self.sigmas
        from scipy.special import ndtri  # late: scipy takes long to import

        return float(ndtri(0.5 + 0.5 * self.probability))

    @property
    def label(self) -> str:
        """Number of standard deviations that count, in words, with the probability if specified."""
        if self.probability is None:
            return f"{self.factor:g} sigma"
        return f"{self.factor:.4g} sigma ({100.0 * self.probability:.6g} % of the time)"

    @property
    def needs_altitude(self) -> bool:
        """Whether the intensity depends on the altitude, and the request has none."""
        return self.intensity is None and self.altitude is None

    @property
    def over_altitude(self) -> Turbulence:
        """Turbulence along a flight: a table over altitude, or of one intensity and length."""
        form: dict[str, Any] = {"spectrum": self.spectrum, "component": self.component}
        if self.table is not None:
            errors.instance("table", self.table, Turbulence, "see read_turbulence")
            air = self.table
        elif self.intensity is not None:
            air = Turbulence(self.intensity, **form)
        else:
            exceedance = self.severity if self.exceedance is None else self.exceedance
            assert exceedance is not None
            air = Turbulence.mil_f_8785c(exceedance, **form)
        values = {name: getattr(self, name) for name in ("length", "cutoff_wavelength")}
        return replace(air, **{name: x for name, x in values.items() if x is not None})

    def at(self, altitude: float | None = None) -> Turbulence:
        """Return the turbulence at one altitude.

        Parameters
        ----------
        altitude : float, optional
            Altitude [m], by default the one of the request.

        Raises
        ------
        InputError
            For an intensity that depends on an altitude that is not known.
        """
        height = self.altitude if altitude is None else altitude
        if self.intensity is None and height is None:
            names = ("severity", "exceedance", "table")
            key = next(name for name in names if getattr(self, name) is not None)
            key = "levels over altitude" if key == "table" else key
            raise errors.InputError(
                f"turbulence needs an altitude with {key}, on which its intensity depends: give"
                " altitude_m in [turbulence], or a table [flight] in the vehicle file"
            )
        if height is None:  # one intensity and length at all altitudes
            return self.over_altitude
        return self.over_altitude.at(height)


TURBULENCE_TABLE = file_table("[turbulence]", TurbulenceRequest, words=("file",), lists=(LEVELS,))


def turbulence_of(document: Mapping[str, Any], folder: Path) -> TurbulenceRequest | None:
    """Return the request of [turbulence] of a document, None without it.

    `document`: tables of a file. `folder`: where a file of turbulence over altitude is searched.
    """

    def request(keys: dict[str, Any]) -> TurbulenceRequest:
        """Return the request of the keys of [turbulence].

        Numbers over altitude are from a file in `folder`, or from the rows of the key level.
        """
        values = TURBULENCE_TABLE.read(keys)
        path, levels = values.pop("file", None), values.pop(LEVELS, None)
        if path is not None and levels is not None:
            raise errors.InputError(
                "turbulence over altitude is that of file or of level; keep one"
            )
        form = {  # spectrum and component
            name: errors.one_of(name, values.get(name, names[0]), names)
            for name, names in _FORMS.items()
        }
        if path is not None:
            values["table"] = read_turbulence(folder / errors.text("file", path), **form)
        elif levels is not None:
            values["table"] = turbulence_of_levels(levels, **form)
        return TurbulenceRequest(**values)

    return TURBULENCE_TABLE.made(document, request)


@dataclass(frozen=True, eq=False)
class LoopInTurbulence(Shown):
    """Motion of a loop in a known wind and turbulence, linear and without limits.

    Attributes
    ----------
    turbulence : Turbulence
        The turbulence.
    sigmas : float
        Standard deviations that count on top of the mean.
    label : str
        These in words, with the probability where that is specified.
    deflection, time : float
        Largest of ``|mean|`` plus those standard deviations of the deflection [rad], and its time
        [s].
    deflection_rate : float or None
        The same of the deflection rate [rad/s]; None where it has no variance.
    angle_of_attack : float
        The same of the angle of attack [rad].
    load, load_bound : float or None
        The same of the load of the structure, as an angle [rad], and its bound, see
        `LoadBound.bound`; None without a bound.
    deflection_rms, deflection_rate_rms : float
        Standard deviation of the deflection [rad] and of its rate [rad/s].
    duration : float
        Time for which the travel counts [s].
    limit : float or None
        Deflection limit [rad].
    probability_of_none : float or None
        Probability that the deflection does not meet the limit in that time; None without a limit,
        or without a rate of finite variance.
    covariance : LoopCovariance
        The stationary covariance, for spectra.
    history : CovarianceHistory
        Mean and spread over time.
    """

    turbulence: Turbulence = field(metadata=spec())
    sigmas: float = field(metadata=spec())
    label: str = field(metadata=spec(card=False))
    deflection: float = field(metadata=spec("angle"))
    time: float = field(metadata=spec("time"))
    deflection_rate: float | None = field(metadata=spec("angular rate"))
    angle_of_attack: float = field(metadata=spec("angle"))
    load: float | None = field(metadata=spec("angle", "load as an angle"))
    load_bound: float | None = field(metadata=spec("angle"))
    deflection_rms: float = field(metadata=spec("angle"))
    deflection_rate_rms: float | None = field(metadata=spec("angular rate"))
    duration: float = field(metadata=spec("time"))
    limit: float | None = field(metadata=spec("angle"))
    probability_of_none: float | None = field(
        metadata=spec(label="probability that the limit is not reached", significant=5)
    )
    covariance: LoopCovariance
    history: CovarianceHistory

    @classmethod
    def of(
        cls,
        request: TurbulenceRequest,
        vehicle: AnyVehicle,
        plant: AnyPlant,
        autopilot: Autopilot,
        wind: History,
        limit: float | None = None,
        altitude: float | None = None,
        load: LoadBound | None = None,
    ) -> Self:
        """Return the motion of an autopilot in a wind and turbulence, of one vehicle.

        Parameters
        ----------
        request : TurbulenceRequest
            The turbulence, and the standard deviations that count.
        vehicle : Vehicle or LinearVehicle
            The vehicle, whose speed counts.
        plant : Plant or FlexiblePlant
            Its plant.
        autopilot : Autopilot
            Its autopilot.
        wind : History
            The known wind [rad], which ends.
        limit : float, optional
            Deflection limit [rad].
        altitude : float, optional
            Altitude [m], by default the request's.
        load : LoadBound, optional
            Load limit of the structure.

        Raises
        ------
        InputError
            For a vehicle without a speed, and as `turbulence_covariance`.
        """
        errors.instance("request", request, TurbulenceRequest, "of an intensity or a severity")
        errors.instance("wind", wind, History, "such as TriangularWind")
        errors.single("wind", wind.batch)
        errors.ending("wind", wind.end)
        limit = None if limit is None else errors.limit_angle(limit, "limit")
        if not isinstance(vehicle, Vehicle):
            raise errors.InputError(
                "turbulence needs the speed of the vehicle, which coefficients lack"
            )
        speed = errors.number("velocity", vehicle.velocity, errors.positive, "m/s")
        air, k = request.at(altitude), request.factor
        stationary = turbulence_covariance(autopilot, plant, air, speed)
        from_onset = wind.shift(-float(wind.onset))
        duration = float(from_onset.end) + AFTER_WIND_S
        slopes = None
        if load is not None:
            errors.instance("load", load, LoadBound, "of one bound")
            # the load alpha + M delta [rad], M = `ratio`, takes the place of a bending moment
            slopes = LoadSlopes(alpha_moment=1.0, deflection_moment=load.ratio)
        history = turbulence_history(
            autopilot, plant, air, speed, duration, wind=from_onset, settled=True, loads=slopes
        )
        # the largest |mean| + k standard deviations of an output, and its time
        deflection, time = history.largest(k)
        angle_of_attack, _ = history.largest(k, ANGLE_OF_ATTACK)
        smooth = DEFLECTION_RATE in history.outputs  # a rate has a variance
        return cls(
            turbulence=air,
            sigmas=k,
            label=request.label,
            deflection=deflection,
            time=time,
            deflection_rate=history.largest(k, DEFLECTION_RATE)[0] if smooth else None,
            angle_of_attack=angle_of_attack,
            load=None if load is None else history.largest(k, BENDING_MOMENT)[0],
            load_bound=None if load is None else load.bound,
            deflection_rms=stationary.deflection_rms,
            deflection_rate_rms=stationary.deflection_rate_rms,
            duration=duration,
            limit=limit,
            probability_of_none=(
                history.probability_of_none(limit) if limit is not None and smooth else None
            ),
            covariance=stationary,
            history=history,
        )

    @cached_property
    @derived("angle")
    def travel(self) -> float | None:
        """Expected travel of the nozzle in `duration` [rad]; None for a rate without a variance."""
        return self.history.travel() if self.deflection_rate is not None else None

    @cached_property
    @derived("angle")
    def travel_deviation(self) -> float | None:
        """Standard deviation of `travel` [rad]; None for a rate without a variance."""
        return self.history.travel_deviation() if self.deflection_rate is not None else None

    def tables(self) -> list[Table]:
        """Return the tables of the motion and of the stationary covariance."""
        key, sizes = "turbulence", ("deflection", "deflection_rate", "angle_of_attack", "load")
        shown: list[Row] = [
            ("spectrum", (f"{self.turbulence.spectrum}, {self.turbulence.component}",)),
            *rows(self.turbulence, key, "intensity", "length"),
            *((f"{name}, wind + {self.label}", line) for name, line in rows(self, key, *sizes)),
        ]
        if travel := rows(self, key, "travel", "travel_deviation"):
            (_, expected), (_, deviation) = travel
            shown.append((f"travel in {self.duration:.4g} s", (*expected, " +- ", *deviation)))
        shown += rows(self, key, "probability_of_none")
        title = "The autopilot in the wind and turbulence, linear, without limits"
        return [quantities(title, shown), *self.covariance.tables()]
