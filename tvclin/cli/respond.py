"""`tvclin respond`: the exact response of one vehicle's attitude to a wind."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, within
from tvclin.base.fields import document
from tvclin.base.quantities import NOMINAL, survival
from tvclin.case.case import Case
from tvclin.cli.inputs import case_of, note_nominal_pressure
from tvclin.cli.options import (
    GROUP,
    LIMIT,
    MODEL_AND_PLANE,
    STUDY,
    At,
    More,
    Options,
    Points,
    ShownCurves,
    Source,
    Until,
    option,
)
from tvclin.cli.output import answer, print_answer
from tvclin.cli.wind import WindOptions, note_one_sign, wind_words, with_gust_for
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import (
    COMPLETE,
    OVERTURNED,
    OVERTURNED_NOTE,
    RELEASED,
    Extremes,
    Loads,
    ResponseEnd,
    extremes,
    response_end,
    response_table,
    wind_loads,
)
from tvclin.linear.modes import Verdict, judge, unstable_modes
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.requirement.nominal_requirement import covers, required_deflection
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import beyond_linear, linear_notes

if TYPE_CHECKING:
    from tvclin.plots.curves import Curves


_MAX_EXPONENT = 700.0
"""Largest exponent of the fastest mode over a response: doubles overflow above e^709."""


@dataclass(frozen=True, eq=False)
class BoundedTrim:
    """A case, the deflection in its wind, K, and the limit; at nominal dynamic pressure.

    `nominal` is the required deflection [rad] at that pressure, set by `governs`, in words;
    `required` the requirement of a study, which counts the pressure encountered. `wind` begins at
    t = 0. `deflection` and `limit` are in rad.
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
        """The rigid plant of the case, by its coefficients and model."""
        return self.case.plant.rigid

    @cached_property
    def verdict(self) -> Verdict:
        """Verdict of the report's eq (4b): stability with the deflection constant for ever."""
        return judge(self.plant, self.deflection, self.wind)

    @property
    def loads(self) -> Loads:
        """The peaks of angle of attack and attitude error during the wind [rad], with times [s]."""
        return wind_loads(self.plant, self.deflection, self.wind)

    @property
    def words(self) -> str:
        """Description of the wind, model, dead band, limit and nominal dynamic pressure."""
        limit = f"K = {self.dead_band:g}, limit {np.degrees(self.limit):.3f} deg, {NOMINAL}"
        return f"{wind_words(self.name, self.case)}, model {self.plant.model}, {limit}"

    def followed(self, length: float) -> tuple[Extremes, ResponseEnd]:
        """Return the extremes of the attitude in a length [s], and how much of it is shown.

        A surviving limit that is not stable when held for ever is shown until the attitude is back
        at zero, where an autopilot lets go of it; that time is then an extreme too.
        """
        motion, lets_go = (self.plant, self.deflection, self.wind), not self.verdict.stable
        survives = bool(covers(self.limit, self.nominal))
        shown = response_end(*motion, length, lets_go=survives and lets_go)
        largest = extremes(*motion, shown.time)
        if shown.back_at_zero is not None:
            largest = replace(largest, back_at_zero=shown.back_at_zero)
        return largest, shown

    @property
    def survived(self) -> bool | None:
        """Whether the limit survives at this pressure; None where that is not known."""
        survived = bool(covers(self.limit, self.nominal))
        return None if self.beyond_linear or (survived and self.case.unknown_wind) else survived

    @property
    def outcome(self) -> str:
        """Whether the limit survives, with the required deflection, in words."""
        ratio = f", {self.limit / self.nominal:.4g} times that" if self.nominal else ""
        required = f"{np.degrees(self.nominal):.3f} deg required {NOMINAL} by {self.governs}"
        limit = f"limit {np.degrees(self.limit):.3f} deg{ratio}"
        unknown = f"; {self.case.unknown_wind}" if self.case.unknown_wind else ""
        return f"{survival(self.survived)}: {required}; {limit}{unknown}"

    @property
    def beyond_linear(self) -> str:
        """Reason why the answer is not known in a wind of this angle; empty if it is known."""
        return beyond_linear(float(self.wind.peak))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the wind angle."""
        return linear_notes(float(self.wind.peak))


def bounded_trim(
    case: Case, name: str, dead_band: float, capability: float | None, until: float
) -> BoundedTrim:
    """Return the deflection of trim up to K times the limit [rad], then the limit, in a wind.

    `name`: title of the wind, which begins at t = 0. `dead_band`: K. `capability`: the limit over
    the requirement at nominal dynamic pressure. `until`: length in durations of the wind.
    """
    if capability is not None and case.nozzle.limit is not None:
        raise InputError("give --capability or --limit-deg, not both")
    wind, plant = case.one_sign_history, case.plant.rigid
    history = wind.shift(-float(wind.onset)) if wind.onset else wind
    _check_length(plant, max(until, 1.0) * float(history.end))
    needed = required_deflection(plant, history, dead_band)
    nominal = abs(float(needed.deflection))
    if case.nozzle.limit is not None:
        limit = case.nozzle.limit
    else:
        ratio = 1.0 if capability is None else capability
        limit = nominal * float(within("--capability", ratio, 1e-3, 1e3))
        if np.isinf(limit):
            none = f"no limit is sufficient with K = {dead_band:g} here"
            raise InputError(f"{none}; give --limit-deg")
        if limit == 0.0:
            raise InputError("this vehicle needs no deflection in any wind; give --limit-deg")
    # that of trim, -B alpha_w, opposite to the wind for B > 0; in a wind of zero any
    sign = -float(np.sign(plant.coefficients.B * history.peak)) or 1.0
    return BoundedTrim(
        case=case,
        name=name,
        wind=history,
        deflection=trim_then_hold(plant, history, sign * limit, dead_band, switch="literal"),
        dead_band=dead_band,
        nominal=nominal,
        limit=limit,
        governs=str(needed.governs),
        required=study_requirement(case, dead_band),
    )


def _check_length(plant: Plant, length: float) -> None:
    """Raise `InputError` for a length [s] over which the fastest mode overflows."""
    fastest = float(np.real(unstable_modes(plant).poles).max(initial=0.0))
    if fastest * length > _MAX_EXPONENT:
        raise InputError(
            "--duration, and --duration times --until, must be at most"
            f" {_MAX_EXPONENT / fastest:.4g} s: the attitude grows as e^({fastest:.4g} t), and"
            f" floating-point numbers end near e^{_MAX_EXPONENT:g}; got {length:g} s"
        )


_MAX_UNTIL = 1000.0
"""Largest --until, in durations of the wind."""


def respond(
    vehicle: Source = "configuration-i",
    time: At = None,
    winds: WindOptions = GROUP,
    dead_band: Options = Options(STUDY, ("dead_band",)),
    capability: float | None = option(
        "Deflection limit over what is required: 1 is the boundary.", shown="1"
    ),
    limit: Options = LIMIT,
    model: Options = MODEL_AND_PLANE,
    until: Until = 3.0,  # durations of the wind
    points: Points = 301,
    more: More = False,
    files: ShownCurves = GROUP,
) -> None:
    """Print the attitude response to a wind, with ideal trim up to the dead band, then the limit.

    It is exact, and at nominal dynamic pressure; tvclin study is the verdict on a limit, and tvclin
    fly has the control laws that can be built. With --law report it holds the limit until the wind
    ends; here that is let go as soon as the attitude is back at zero, so that the largest attitude
    is less.

    Exit code 0: answered; 2: bad input.
    """
    from tvclin import plots

    within("--until", until, 1e-3, _MAX_UNTIL)
    within("--points", points, 2, 1_000_000)
    changes = (limit.applied_to, model.applied_to, dead_band.applied_to)
    plan = case_of(vehicle, *changes, wind=winds.applied_to, questions=("respond",), time=time)
    if capability is not None and not limit.values:
        plan = replace(plan, nozzle=replace(plan.nozzle, limit=None))
    plan = with_gust_for(plan, plan.dead_band)
    trim = bounded_trim(plan, winds.name(plan), plan.dead_band, capability, until)
    # extremes of the attitude, and the time up to which the response is shown
    largest, shown = trim.followed(until * float(trim.wind.end))
    name = plan.vehicle.name or "Response"
    files.write(
        lambda: _curves(trim, np.linspace(0.0, shown.time, points)),
        lambda curves: plots.response_chart(curves, f"{name}: exact response\n{trim.words}"),
    )
    note_nominal_pressure(plan)
    note_one_sign(plan.wind, plan, "the boundary and its control")
    answer(
        files.as_json,
        lambda: _document(trim, largest, shown),
        lambda: _print(trim, largest, shown, more),
    )


def _curves(trim: BoundedTrim, times: FloatArray) -> "Curves":
    """Return the curves of the response of a plant to wind and deflection at `times` [s].

    `trim`: the plant, its wind, the deflection within its limit, and their description.
    """
    from tvclin.plots import response_curves

    deflection, wind = trim.deflection, trim.wind
    response = attitude_responses(trim.plant, deflection, wind, times)
    what = f"{trim.case.vehicle.name}: {trim.words}"
    return response_curves(
        response, "respond", what, limit=trim.limit, deflection=deflection, wind=wind
    )


def _print(trim: BoundedTrim, largest: Extremes, shown: ResponseEnd, more: bool) -> None:
    """Print the outcome with the limit, and the largest motions; with `more`, all notes.

    `shown`: end of the shown response, and its reason. `see_study`: required deflection of the
    study in a clause.
    """
    wind_covered = _covers_the_wind(trim, shown)
    caption = f"{trim.case.vehicle.name}: exact response\n{trim.words}"
    see = [] if trim.required is None else [trim.required.see_study]
    print_answer(
        "; ".join([trim.outcome, *see]),
        response_table(caption, largest, trim.loads if wind_covered else None),
        notes=(*trim.notes, *_end_notes(trim, shown), *_constant_notes(trim)),
        more=more,
    )


def _end_notes(trim: BoundedTrim, shown: ResponseEnd) -> Iterator[str]:
    """Yield notes on the time at which the shown response ends, and on its reason.

    `trim`: the response, whose deflection is trim up to K times the limit, then the limit.
    """
    if shown.why == RELEASED:
        yield (
            "an autopilot lets go of the limit when the attitude is back at zero, or beyond; the"
            f" response is shown until then, {shown.time:.3f} s"
        )
    elif shown.why == OVERTURNED:
        yield f"the response is shown until it exceeds 90 deg, {shown.time:.3f} s"
        if trim.survived:
            yield OVERTURNED_NOTE


def _constant_notes(trim: BoundedTrim) -> Iterator[str]:
    """Yield notes on the deflection that stays constant for ever, by eq (4b) of the report.

    It is stable by eq (4b) if deflection and wind together excite no unstable mode. A NaN time
    constant of the final motion belongs to a fast mode that is not excited: the slow mode alone
    remains.
    """
    verdict = trim.verdict
    stable = "stable by condition (4b)" if verdict.stable else "not stable by condition (4b)"
    times = verdict.final_motion.e_folding_times  # of each unstable pole [s], the fast one first
    if not verdict.stable and np.isnan(times[0]):
        stable = "by condition (4b) only the slow mode of the flight path is not stable"
    yield f"held for ever, the deflection leaves {verdict.final_motion}: {stable}"
    if trim.survived and not verdict.stable:
        yield "SURVIVED means with a control that lets go of the limit in time"


def _covers_the_wind(trim: BoundedTrim, shown: ResponseEnd) -> bool:
    """Return whether the shown response lasts until the end of the wind."""
    return shown.why == COMPLETE or shown.time >= float(trim.wind.end)


def _document(trim: BoundedTrim, largest: Extremes, shown: ResponseEnd) -> dict[str, Any]:
    """Return a response, its verdict and the required deflection, for JSON.

    `largest`: extremes of the attitude. `shown`: end of the shown response, and its reason.
    """
    verdict, wind_covered = trim.verdict, _covers_the_wind(trim, shown)
    needed = None if trim.required is None else np.degrees(trim.required.known_deflection)
    peak = {
        "deg": np.degrees(trim.loads.peak_angle_of_attack),
        "time_s": trim.loads.peak_time,
        "relative_to_wind": trim.loads.relative,
    }
    return {
        "vehicle": trim.case.vehicle.name,
        "model": trim.plant.model,
        "plane": trim.case.plane,
        "wind": {"shape": trim.name, **document(trim.wind, "peak"), "duration_s": trim.wind.end},
        "required_deflection_deg": needed,
        "dead_band": trim.dead_band,
        "nominal_deflection_deg": np.degrees(trim.nominal),
        "governed_by": trim.governs,
        "limit_deg": np.degrees(trim.limit),
        "survived": trim.survived,
        "notes": trim.notes,
        "shown_until": {"time_s": shown.time, "why": shown.why},
        "attitude": largest,
        "peak_angle_of_attack": peak if wind_covered else None,
        "verdict": {
            "stable": verdict.stable,
            "residues_rad": verdict.residues,
            "final_motion": str(verdict.final_motion),
            "offset_deg": np.degrees(verdict.final_motion.offset),
            "rate_deg_per_s": np.degrees(verdict.final_motion.rate),
        },
    }
