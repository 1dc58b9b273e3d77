"""Load limit of a structure in a wind, and largest load in the flight of a law."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Self

import numpy as np

from tvclin.base.cards import Shown
from tvclin.base.errors import (
    InputError,
    between,
    flag,
    instance,
    nonzero,
    number,
    positive,
    small_angle,
)
from tvclin.base.fields import checked, derived, file_table, quantity, spec
from tvclin.boundary.limit_over_load import LoadTradeOff, load_trade_off
from tvclin.case.case import Case
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.fly import fly_nozzle
from tvclin.flights.closed_loop.fly_many import NOT_KNOWN, OUTCOME_WORDS, SURVIVED
from tvclin.winds.wind_angles import beyond_linear


@dataclass(frozen=True, kw_only=True)
class LoadBound:
    """Load limit of a structure: an angle of attack, q alpha, or a bending moment.

    Attributes
    ----------
    load : float, optional
        Largest angle of attack [rad] that the structure bears.
    q_alpha : float, optional
        Largest product of angle of attack and dynamic pressure [Pa rad]; needs `dynamic_pressure`.
    dynamic_pressure : float, optional
        Dynamic pressure [Pa].
    moment : float, optional
        Largest bending moment [N m] at a station; needs `alpha_moment`.
    alpha_moment : float, optional
        Slope of the bending moment over the angle of attack [N m/rad].
    deflection_moment : float, optional
        Slope of the bending moment over the deflection [N m/rad].

    Raises
    ------
    InputError
        For numbers out of range, more bounds than one, and a bound without its further values.
    """

    load: float | None = quantity("angle", None, small_angle("a load", positive))
    q_alpha: float | None = quantity("pressure angle", None, positive, option=None)
    dynamic_pressure: float | None = quantity("pressure", None, positive, option=None)
    moment: float | None = quantity("moment", None, positive, option=None)
    alpha_moment: float | None = quantity("moment slope", None, nonzero, option=None)
    deflection_moment: float | None = quantity("moment slope", None, option=None)

    def __post_init__(self) -> None:
        """Raise `InputError` unless one bound, with the values that belong to it, is in range.

        The bound is `load`, `q_alpha` with the dynamic pressure, or `moment` with its slopes.
        """
        checked(self)
        bounds = [name for name in ("load", "q_alpha", "moment") if getattr(self, name) is not None]
        if len(bounds) != 1:
            raise InputError(
                "[load] needs one bound: load, q_alpha or moment"
                f"{'; got ' + ' and '.join(bounds) if bounds else ''}"
            )
        for bound, companion in (("q_alpha", "dynamic_pressure"), ("moment", "alpha_moment")):
            if (bound in bounds) != (getattr(self, companion) is not None):
                raise InputError(f"[load] needs {bound} and {companion} together")
        if self.deflection_moment is not None and self.alpha_moment is None:
            raise InputError("[load] needs alpha_moment beside deflection_moment")

    @property
    def bound(self) -> float:
        """Bound as an angle of attack [rad].

        The largest angle itself, q alpha over the dynamic pressure q, or moment over its slope.
        """
        if self.load is not None:
            return self.load
        if self.q_alpha is not None and self.dynamic_pressure is not None:
            return self.q_alpha / self.dynamic_pressure
        assert self.moment is not None
        assert self.alpha_moment is not None
        return self.moment / abs(self.alpha_moment)

    @property
    def ratio(self) -> float:
        """Ratio M_delta/M_alpha of the slopes of the bending moment; zero for another bound.

        Slopes over deflection and angle of attack, so that the load as an angle is alpha + ratio
        times delta.
        """
        return (self.deflection_moment or 0.0) / (self.alpha_moment or 1.0)

    def at_pressure(self, ratio: float) -> Self:
        """Return the load limit at another dynamic pressure; an angle, `load`, stays as it is.

        The angle of `q_alpha`, and of a moment with the slope `alpha_moment`, falls with pressure.

        Parameters
        ----------
        ratio : float
            That dynamic pressure over the present one, positive.

        Raises
        ------
        InputError
            For a ratio that is not positive.
        """
        factor = number("ratio", ratio, positive)
        if self.q_alpha is not None and self.dynamic_pressure is not None:
            return replace(self, dynamic_pressure=factor * self.dynamic_pressure)
        if self.alpha_moment is not None:
            return replace(self, alpha_moment=factor * self.alpha_moment)
        return self

    def trade_off(
        self, case: Case, fraction: float = 1.0, *, only_bound: bool = False
    ) -> LoadTradeOff:
        """Return the trade-off curve of limit over load in the wind of a case.

        The load is the angle alpha + (M_delta/M_alpha) delta [rad], with the slopes of the bending
        moment; for a bound of the angle of attack or of q alpha it is alpha.

        Parameters
        ----------
        case : Case
            The vehicle, the wind and the nozzle.
        fraction : float
            Fraction of the deflection limit that is available in the plane, at most 1.
        only_bound : bool
            Whether the curve is only its point at the bound.

        Raises
        ------
        InputError
            For a fraction out of range, and as `load_trade_off`.
        """
        instance("case", case, Case, "of a wind and a nozzle")
        fraction = number("fraction", fraction, between(1e-9, 1.0))
        only_bound = flag("only_bound", only_bound)
        limit = case.nozzle.limit
        return load_trade_off(
            case.plant.rigid,
            case.history,
            loads=[self.bound] if only_bound else None,
            limit=None if limit is None else limit * fraction,
            load=self.bound,
            rate_limit=case.hardware["rate_limit"],
            moment_ratio=self.ratio,
        )


LOAD_TABLE = file_table("[load]", LoadBound)


@dataclass(frozen=True)
class FlownLoad(Shown):
    """The largest load in a law's flight, during the wind and after it.

    Attributes
    ----------
    law, status : str
        Name of the law, and outcome of its flight; see `fly_many`.
    load, time : float
        Largest load [rad] and its time [s]; infinite for a flight that diverges, NaN where it is
        not known.
    bound : float or None
        Load limit of the structure [rad].
    """

    law: str = field(metadata=spec())
    status: str = field(metadata=spec())
    load: float = field(metadata=spec("angle"))
    time: float = field(metadata=spec("time"))
    bound: float | None = field(metadata=spec("angle"))

    @classmethod
    def of(cls, case: Case, name: str, law: Law, bound: LoadBound | None = None) -> Self:
        """Return the load of a law in the wind of a case, with its nozzle, which has a limit.

        Parameters
        ----------
        case : Case
            The vehicle, the wind, and the nozzle with its deflection limit.
        name : str
            Name of the law.
        law : Law
            The law, which is flown with the deflection limit of the nozzle.
        bound : LoadBound, optional
            Load limit of the structure.

        Raises
        ------
        InputError
            For another kind of value, and a nozzle without a limit; also as `fly_many`.
        """
        instance("case", case, Case, "of a wind and a nozzle")
        instance("law", law, Law, "such as TrimLaw")
        instance("name", name, str, "of the law")
        if bound is not None:
            instance("bound", bound, LoadBound, "of what the structure bears")
        limit, max_load = case.nozzle.limit, None if bound is None else bound.bound
        if limit is None:
            raise InputError("case must have a deflection limit of its nozzle")
        flown = partial(cls, law=name, bound=max_load)
        if beyond_linear(float(case.history.peak)):
            return flown(status=NOT_KNOWN, load=np.nan, time=np.nan)
        flight = fly_nozzle(case.plant, law, case.history, deflection_limit=limit, **case.hardware)
        if not flight.times.size:  # the flight diverges
            return flown(status=flight.status, load=np.inf, time=np.nan)
        ratio = 0.0 if bound is None else bound.ratio  # of the moment's slopes, deflection to alpha
        loads = np.abs(flight.angle_of_attack + ratio * flight.deflection)
        worst = int(np.argmax(loads))
        time, unknown = float(flight.times[worst]), case.unknown_wind and flight.status == SURVIVED
        status = NOT_KNOWN if unknown else flight.status
        return flown(status=status, load=float(loads[worst]), time=time)

    @property
    @derived()
    def survives_within(self) -> bool | None:
        """Whether the law survives within the bound; None where that is not known."""
        if self.status == NOT_KNOWN:
            return None
        return self.status == SURVIVED and (self.bound is None or self.load <= self.bound)

    @property
    def words(self) -> str:
        """Outcome of the flight and its largest load, an angle of attack, in words.

        A bending moment counts as the angle of attack that causes it without deflection.
        """
        outcome = f"{self.law} {OUTCOME_WORDS[self.status]} with this limit"
        if not np.isfinite(self.load):
            return outcome
        load = f"{outcome}, with a load of {np.degrees(self.load):.3f} deg at {self.time:.2f} s"
        if self.bound is None:
            return load
        relation = "within" if self.load <= self.bound else "NOT within"
        return f"{load}, {relation} {np.degrees(self.bound):.3f} deg"
