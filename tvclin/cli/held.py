"""The deflection of `tvclin respond`: trim up to the dead band, and then a limit held."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tvclin.base.errors import InputError, within
from tvclin.base.quantities import NOMINAL
from tvclin.case.case import Case
from tvclin.cli.wind import wind_words
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import Extremes, Loads, ResponseEnd, extremes, response_end, wind_loads
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.linear.verdict import Verdict, judge
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.requirement.nominal_requirement import covers, required_deflection
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import beyond_linear, linear_notes

_MAX_EXPONENT = 700.0
"""Largest exponent of the fastest mode over a response: doubles overflow above e^709."""


@dataclass(frozen=True, eq=False)
class Held:
    """A case, the deflection in its wind, K, and the limit; at nominal dynamic pressure.

    `nominal` is the required deflection [rad] there, governed by `governs`, `required` that of a
    study.
    """

    case: Case
    name: str
    wind: History
    deflection: History
    dead_band: float
    nominal: float
    limit: float
    governs: str
    required: CaseRequirement | None

    @property
    def plant(self) -> Plant:
        """The rigid plant."""
        return self.case.plant.rigid

    @cached_property
    def verdict(self) -> Verdict:
        """Verdict of condition (4b) where this deflection is constant for ever."""
        return judge(self.plant, self.deflection, self.wind)

    @property
    def loads(self) -> Loads:
        """The loads of the wind."""
        return wind_loads(self.plant, self.deflection, self.wind)

    @property
    def words(self) -> str:
        """Description of the wind, model, dead band, limit and nominal dynamic pressure."""
        limit = f"K = {self.dead_band:g}, limit {np.degrees(self.limit):.3f} deg, {NOMINAL}"
        return f"{wind_words(self.name, self.case)}, model {self.plant.model}, {limit}"

    def followed(self, length: float) -> tuple[Extremes, ResponseEnd]:
        """Return the extremes of the attitude in a length [s], and how much of it is shown."""
        motion, lets_go = (self.plant, self.deflection, self.wind), not self.verdict.stable
        survives = bool(covers(self.limit, self.nominal))
        shown = response_end(*motion, length, lets_go=survives and lets_go)
        largest = extremes(*motion, shown.time)
        if shown.back_at_zero is not None:
            largest = replace(largest, back_at_zero=shown.back_at_zero)
        return largest, shown

    @property
    def survived(self) -> bool | None:
        """Whether the limit survives at this pressure; None beyond linear aerodynamics."""
        return None if self.beyond else bool(covers(self.limit, self.nominal))

    @property
    def beyond(self) -> str:
        """Reason of `beyond_linear` why the answer is not known in this wind; empty if it is."""
        return beyond_linear(float(self.wind.peak))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the wind angle."""
        return linear_notes(float(self.wind.peak))


def held(case: Case, name: str, dead_band: float, capability: float | None, until: float) -> Held:
    """Return the case of the options; `until`: length of the response in durations of the wind.

    `name`: that of the wind, which begins at t = 0.
    """
    if capability is not None and case.nozzle.limit is not None:
        raise InputError("give --capability or --limit-deg, not both")
    wind, plant = case.history, case.plant.rigid
    history = wind.shift(-float(wind.onset)) if wind.onset else wind
    K = float(within("--dead-band", dead_band, 0.0, 1.0))
    _check_length(plant, max(until, 1.0) * float(history.end))
    needed = required_deflection(plant, history, K)
    nominal = abs(float(needed.deflection))
    if case.nozzle.limit is not None:
        limit = case.nozzle.limit
    else:
        limit = nominal * float(
            within("--capability", 1.0 if capability is None else capability, 1e-3, 1e3)
        )
        if np.isinf(limit):
            raise InputError(f"no limit is sufficient with K = {K:g} here; give --limit-deg")
        if limit == 0.0:
            raise InputError("this vehicle needs no deflection in any wind; give --limit-deg")
    opposing = -float(np.sign(plant.coefficients.B * history.peak)) or 1.0
    deflection = trim_then_hold(plant, history, opposing * limit, K, "literal")
    required = study_requirement(case, K)
    return Held(case, name, history, deflection, K, nominal, limit, str(needed.governs), required)


def _check_length(plant: Plant, length: float) -> None:
    """Raise `InputError` for a length [s] over which the fastest mode overflows."""
    fastest = float(np.real(unstable_modes(plant).poles).max(initial=0.0))
    if fastest * length > _MAX_EXPONENT:
        raise InputError(
            "--duration, and --duration times --until, must be at most"
            f" {_MAX_EXPONENT / fastest:.4g} s: the attitude grows as e^({fastest:.4g} t), and"
            f" floating-point numbers end near e^{_MAX_EXPONENT:g}; got {length:g} s"
        )
