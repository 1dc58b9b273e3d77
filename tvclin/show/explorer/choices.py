"""Choices of the panel: a case with its control, the controls that specify it, its study file.

Values of controls are by field, as a list or a slider shows them: in the units of its label, zero
for an absent part.
"""

import json
import re
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.errors import InputError, one_of
from tvclin.base.fields import parameters
from tvclin.base.files import exists, write_new
from tvclin.boundary.limit_shapes import LIMIT_SHAPES
from tvclin.case.nozzle import USUAL_ACTUATOR, Nozzle
from tvclin.case.turbulence import TurbulenceRequest
from tvclin.control.autopilot.design_rules import (
    ADDED_GAINS,
    GIVEN_GAINS,
    LEAST_NOZZLE,
    RULE_PARAMETERS,
    AutopilotDesign,
)
from tvclin.control.autopilot.gain_table import CHAIN_OF_POSITION
from tvclin.control.laws.registry import AUTOPILOT, DEAD_BAND, LAWS
from tvclin.control.margins.criteria import CRITERIA, Criteria
from tvclin.design.gain_designs import specified_autopilot
from tvclin.linear.plant import MODELS
from tvclin.requirement.case_requirement import pulse_of
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.linear_vehicle import AnyVehicle, coefficients_of, complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import vehicle_table
from tvclin.winds.histories import History
from tvclin.winds.shaped import SHAPES, ShapedWind
from tvclin.winds.wind_angles import FROZEN, SIGNS
from tvclin.winds.wind_file import gust_of

REPORT, TRIM = "report (open loop)", "trim"
CONTROLS = (REPORT, *LAWS)
IN_PLANE, FROM_SIDE = "in the plane", "from a direction"
OWN, CANONICAL = "own gains", "canonical"
WORST = "worst"
_RULES = (OWN, CANONICAL, "half-relief", "lqr")
_DEG = np.pi / 180.0
_PEAK = 5.0
"""Peak of a usual wind [deg], the scale of the sliders of peak and limit."""
LONGEST = 30.0
"""Longest wind [s] of the curve."""
_ROUND_MANTISSAS = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0])
"""Mantissas of round numbers."""

Values = dict[str, Any]
Table = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Choices:
    """A case as a study file has it, with a limit, and its control: one of `CONTROLS`."""

    plan: StudyPlan
    law: str = TRIM

    @property
    def wind(self) -> ShapedWind:
        """The wind, with its gust and its direction."""
        return pulse_of(self.plan)

    @property
    def limit(self) -> float:
        """The deflection limit [rad]."""
        assert self.plan.nozzle.limit is not None  # a slider has it
        return self.plan.nozzle.limit

    @property
    def margin_inputs(self) -> StudyPlan:
        """Plan of the values on which the margins of the autopilot and their verdict depend."""
        p, nozzle = self.plan, Nozzle(actuator=self.plan.nozzle.actuator)
        return _bare(p, vehicle=p.vehicle, nozzle=nozzle, criteria=p.criteria)

    @property
    def requirement_inputs(self) -> StudyPlan:
        """Plan of the values on which the required deflection depends, all others at defaults.

        Plans that differ in other values, such as the limit or the gains, are equal here.
        """
        p = self.plan
        nozzle, inputs = Nozzle(limit_shape=p.nozzle.limit_shape), {"wind": p.wind, "sign": p.sign}
        return _bare(p, dead_band=p.dead_band, nozzle=nozzle, design=None, **inputs)

    @property
    def gust_inputs(self) -> StudyPlan:
        """Plan of the values on which the worst time of a gust depends, for the shown motion.

        The dead band counts for the report's control alone; for a law it is 1. The autopilot never
        counts: equal plans give an equal time.
        """
        p = self.plan
        K = p.dead_band if self.law == REPORT else 1.0
        return _bare(p, wind=p.wind, dead_band=K, design=None)

    @property
    def motion_inputs(self) -> StudyPlan:
        """Plan of the values on which response or flight depend, except the time of the gust.

        The report's control takes the rigid vehicle, the limit and the dead band alone; a law flies
        with structure, nozzle, delay, samples and filters, and the autopilot with its gains too.
        """
        p, flown = self.plan, self.law != REPORT
        hardware = replace(p.nozzle, limit_shape=None) if flown else Nozzle(limit=p.nozzle.limit)
        # of a law but the autopilot the loop without gains: delay, samples and filters
        design = p.design if self.law == AUTOPILOT else loop_of(p.autopilot_design)
        return _bare(
            p,
            vehicle=p.vehicle if flown else p.vehicle.rigid,
            wind=p.wind,
            nozzle=hardware,
            design=design if flown else None,
            dead_band=p.dead_band if self.law in (REPORT, DEAD_BAND) else 1.0,
        )


def _bare(plan: StudyPlan, **fields: Any) -> StudyPlan:
    """Return a plan with rigid vehicle, model, plane and autopilot of `plan`, else with defaults.

    `fields`: further fields of the plan, or other values of vehicle and design.
    """
    values: dict[str, Any] = {"vehicle": plan.vehicle.rigid, "design": plan.design} | fields
    return StudyPlan(model=plan.model, plane=plan.plane, **values)


def loop_of(design: AutopilotDesign) -> AutopilotDesign:
    """Return the delay, the samples and the filters of an autopilot design, without its gains."""
    chains: Any = design.chains
    return AutopilotDesign(delay=design.delay, sample_rate=design.sample_rate, **chains)


class Slider(NamedTuple):
    """A slider: label, start value, minimum, maximum and step."""

    label: str
    value: float
    minimum: float
    maximum: float
    step: float


def with_numerical_gains(plan: StudyPlan) -> StudyPlan:
    """Return a plan with numerical gains; gains for the minimum deflection are searched for.

    The delay, sample rate and filters of such a design stay (`loop_of`).
    """
    design = plan.design
    if plan.autopilot_design.design == LEAST_NOZZLE:
        autopilot = specified_autopilot(plan, plan.history, criteria=plan.margin_criteria)
        gains: Any = {name: float(getattr(autopilot, name)) for name in GIVEN_GAINS}
        design = replace(loop_of(plan.autopilot_design), **gains)
    return replace(plan, design=design)


def lists(plan: StudyPlan, vehicles: list[str]) -> dict[str, tuple[str, list[str], str]]:
    """Return the lists of the panel, by field: label, options, and start value for a plan.

    `vehicles`: names of the vehicles that can be chosen.
    """
    rule, limit_shape = _rule(plan.autopilot_design), plan.nozzle.limit_shape
    shape = limit_shape if isinstance(limit_shape, str) else next(iter(LIMIT_SHAPES))
    further_rules = [] if rule in _RULES else [rule]
    law = TRIM if plan.design is None else AUTOPILOT
    direction = IN_PLANE if plan.heading is None else FROM_SIDE
    return {
        "vehicle": ("vehicle", vehicles, vehicles[0]),
        "plane": ("plane", [*PLANES, BOTH], plan.planes),
        "stop": ("limit of both", list(LIMIT_SHAPES), shape),
        "model": ("model", list(MODELS), plan.model),
        "shape": ("wind shape", list(SHAPES), plan.shape),
        "direction": ("wind blows", [IN_PLANE, FROM_SIDE], direction),
        "sign": ("sign that counts", [WORST, *SIGNS, FROZEN], plan.sign or WORST),
        "law": ("law", list(CONTROLS), law),
        "design": ("gains", [*_RULES, *further_rules], rule),
    }


def switches(plan: StudyPlan) -> dict[str, tuple[str, bool]]:
    """Return the switches of the panel, by field: label, and start value for a plan."""
    return {
        "structure": ("bending and slosh", plan.vehicle.structure is not None),
        "filters": ("filters of the file", any(plan.autopilot_design.chains.values())),
    }


def sliders(plan: StudyPlan, vehicles: list[AnyVehicle]) -> dict[str, Slider]:
    """Return the sliders, by field, with start values of a plan and ranges for all vehicles.

    Limits and gains have the scale of ``|B|``, trim deflection per angle of attack, and a rate gain
    of ``|B|/beta`` [s], beta being sqrt(mu_alpha).
    """
    (start_B, start_rate_scale), *others = (
        _sizes(vehicle, plan.plane) for vehicle in (plan.vehicle, *vehicles)
    )
    B, rate_scale = (max(sizes) for sizes in zip(*others, strict=True))
    wind, nozzle, design = plan.wind, plan.nozzle, plan.autopilot_design
    assert isinstance(wind, ShapedWind)
    gust, rate = wind.gust, nozzle.rate_limit or 0.0
    servo = 0.0 if nozzle.actuator is None else float(nozzle.actuator.natural_frequency)
    gust_peak = 0.0 if gust is None else float(gust.peak) / _DEG
    gust_duration = 1.0 if gust is None else float(gust.end - gust.onset)
    heading = 45.0 if wind.heading is None else wind.heading / _DEG
    limit = None if nozzle.limit is None else nozzle.limit / _DEG
    alpha_gain = _fitted("gain b0 [-]", 0.0, upper=5.0 * B, start_value=design.alpha_gain or 0.0)
    all_sliders = {  # label, start value, minimum, maximum and step of each
        "duration": Slider("wind duration [s]", wind.duration, 0.5, LONGEST, 0.1),
        "peak": Slider("wind peak [deg]", wind.peak / _DEG, -4.0 * _PEAK, 4.0 * _PEAK, 0.1),
        "heading": Slider("wind from [deg]", heading, -180.0, 360.0, 1.0),
        "gust_peak": Slider("gust peak [deg]", gust_peak, -10.0, 10.0, 0.1),
        "gust_duration": Slider("gust length [s]", gust_duration, 0.1, 10.0, 0.1),
        "dead_band": Slider("dead band K [-]", plan.dead_band, 0.0, 1.0, 0.01),
        "limit": _fitted(
            "limit [deg]",
            0.75 * start_B * _PEAK,
            upper=3.0 * B * _PEAK,
            min_steps=1,
            start_value=limit,
        ),
        "rate_limit": Slider("rate limit [deg/s]", rate / _DEG, 0.0, 20.0, 0.1),
        "actuator": Slider("actuator [rad/s]", servo, 0.0, 100.0, 0.1),
        "attitude_gain": _fitted(
            "gain a0 [-]", 5.0 * start_B, upper=15.0 * B, start_value=design.attitude_gain
        ),
        "rate_gain": _fitted(
            "gain a1 [s]",
            3.0 * start_rate_scale,
            upper=15.0 * rate_scale,
            start_value=design.rate_gain,
        ),
        "alpha_gain": alpha_gain._replace(minimum=-alpha_gain.maximum),
        "delay": Slider("delay [ms]", 1e3 * design.delay, 0.0, 200.0, 1.0),
        "sample_rate": Slider("samples [Hz]", design.sample_rate or 0.0, 0.0, 200.0, 1.0),
    }
    # the start value of the file may lie outside of the usual range
    return {
        field: slider._replace(
            minimum=min(slider.minimum, slider.value),
            maximum=slider.maximum if slider.value <= slider.maximum else round_up(slider.value),
        )
        for field, slider in all_sliders.items()
    }


def choices_of(base: StudyPlan, vehicle: AnyVehicle, v: Values) -> Choices:
    """Return the choices that the controls specify; all else comes from the plan of the file.

    Of its criteria those of modes need the structure. `base`: that plan, whose wind keeps its
    speeds while their angles are unchanged (`_speeds`), and its gust the time that it stays at its
    peak. `vehicle`: the chosen vehicle. `v`: values of the controls, by field; "stop" is the limit
    shape. `InputError` for values that the plan refuses.
    """
    chosen = vehicle if v["structure"] else vehicle.rigid
    criteria = base.criteria
    if criteria is not None and chosen.structure is None:
        criteria = criteria.without_mode_limits
    both_planes = v["plane"] == BOTH
    slanting = both_planes or v["direction"] == FROM_SIDE
    # frequencies of the actuator are chosen, its damping is the file's, or usual
    file_wind, servo = base.wind, base.nozzle.actuator or USUAL_ACTUATOR
    assert isinstance(file_wind, ShapedWind)
    actuator = replace(servo, natural_frequency=v["actuator"]) if v["actuator"] else None
    wind = ShapedWind(
        shape=v["shape"],
        peak=v["peak"] * _DEG,
        duration=v["duration"],
        heading=v["heading"] * _DEG if slanting else None,
        gust=_gust(v["gust_peak"], v["gust_duration"], plateau_of(file_wind.gust)),
        gust_at=file_wind.gust_at if v["gust_peak"] else None,
        **_speeds(base, vehicle, v),
    )
    plane = v["plane"]
    if both_planes:  # the plane whose flight is shown: the file's, or the other without wind in it
        complete = complete_vehicle(vehicle, "a wind with a direction")
        peaks = wind.peaks(float(np.asarray(complete.attitude)))
        plane = base.plane if peaks[base.plane] else next(k for k, peak in peaks.items() if peak)
    plan = replace(
        base,
        vehicle=chosen,
        model=v["model"],
        plane=plane,
        wind=wind,
        nozzle=Nozzle(
            limit=v["limit"] * _DEG,
            limit_shape=v["stop"] if both_planes else None,
            rate_limit=v["rate_limit"] * _DEG or None,
            actuator=actuator,
        ),
        design=_design(base.autopilot_design, v),
        dead_band=v["dead_band"],
        criteria=criteria,
        # None is the worse of head and tail wind; a control without effect does not count
        sign=None if v["sign"] == WORST or "sign" in idle_controls(base, vehicle, v) else v["sign"],
    )
    return Choices(plan=plan, law=v["law"])


def _speeds(base: StudyPlan, vehicle: AnyVehicle, v: Values) -> dict[str, float | None]:
    """Return the speeds [m/s] of the wind and its gust in the file, while their angles stay.

    `base`: plan of the file. `vehicle`: the chosen vehicle. `v`: values of the controls, by field.
    None for a wind or gust without a speed, and once its angle, its vehicle or direction changed.
    """
    # values with which sliders and lists begin, those of the file
    start: Values = {k: slider.value for k, slider in sliders(base, [base.vehicle]).items()}
    start |= {k: begin for k, (_, _, begin) in lists(base, vehicles=[""]).items()}
    wind = base.wind
    assert isinstance(wind, ShapedWind)
    unchanged = vehicle is base.vehicle and all(
        v[field] == start[field] for field in ("plane", "direction", "heading")
    )
    speeds = {"speed": ("peak", wind.speed), "gust_speed": ("gust_peak", wind.gust_speed)}
    return {
        field: speed if unchanged and v[angle] == start[angle] else None
        for field, (angle, speed) in speeds.items()
    }


def idle_controls(base: StudyPlan, vehicle: AnyVehicle, v: Values) -> dict[str, str]:
    """Return the controls without effect at the values of the others, each with the reason.

    `base`: plan of the file. `vehicle`: the chosen vehicle. `v`: values of the controls, by field.
    A control with an effect has False for its reason, and is left out.
    """
    both_planes = v["plane"] == BOTH
    slanting = both_planes or v["direction"] == FROM_SIDE
    ruled = f"the rule {v['design']} sets it: take {OWN}"
    reasons = {
        "structure": vehicle.structure is None and "the file of this vehicle has no structure",
        "filters": not any(base.autopilot_design.chains.values()) and "the file has no filters",
        "stop": not both_planes and f"counts only in the plane {BOTH}",
        "direction": both_planes and "both planes need a direction",
        "heading": not slanting and "counts only with a wind from a direction",
        "sign": v["sign"] != FROZEN  # the nominal dynamic pressure has an effect in any wind
        and (
            (slanting and "the wind's direction says it")
            or (v["plane"] == "yaw" and "a wind in yaw blows across the path")
        ),
        "gust_duration": not v["gust_peak"] and "there is no gust: its peak is 0",
        "rate_limit": v["law"] == REPORT and f"counts only in flights of a law, not with {REPORT}",
        **dict.fromkeys(GIVEN_GAINS, v["design"] != OWN and ruled),
    }
    return {field: why for field, why in reasons.items() if why}


def plateau_of(gust: History | None) -> float:
    """Return the time of a gust at its peak [s]; zero unless it has the four knots of `gust_of`."""
    if gust is None or gust.knots.size < 4:
        return 0.0
    return float(gust.knots[2] - gust.knots[1])


@lru_cache(maxsize=256)
def _gust(peak: float, duration: float, plateau: float) -> History | None:
    """Return a gust, the same object for the same numbers, so that cached results stay valid.

    `peak`: angle [deg]; None is returned for zero. `duration`, `plateau`: [s]; a plateau as long as
    the gust is none.
    """
    return gust_of(peak * _DEG, duration, plateau if plateau < duration else 0.0) if peak else None


def _rule(design: AutopilotDesign) -> str:
    """Return the name of the rule for the gains of a design, or `OWN` where they are numbers."""
    if design.attitude_gain is not None:
        return OWN
    return design.design or (CANONICAL if design.natural_frequency is None else "poles")


def _design(design: AutopilotDesign, v: Values) -> AutopilotDesign:
    """Return the autopilot design of the values `v` of the controls; `design`: of the file.

    Its gains are numbers of controls (`OWN`), or follow from a rule, with the parameters of the
    file if the file has this rule. `ADDED_GAINS` stay always, filters where their switch is on.
    """
    rule, chains = v["design"], design.chains if v["filters"] else {}
    gains: Any = {"design": rule}
    if rule == OWN:
        gains = {name: v[name] for name in GIVEN_GAINS}
    elif rule == _rule(design):
        gains |= {name: getattr(design, name) for name in RULE_PARAMETERS}
    return AutopilotDesign(
        **{name: getattr(design, name) for name in ADDED_GAINS},
        delay=1e-3 * v["delay"],
        sample_rate=v["sample_rate"] or None,
        **gains | chains,
    )


def _fitted(
    label: str, usual: float, *, upper: float, start_value: float | None, min_steps: int = 0
) -> Slider:
    """Return a slider from `min_steps` steps to a round number, of some hundred steps.

    `label`: its label. `upper`: largest value, rounded up. `start_value`: value at which it begins;
    where it is None, the `usual` one, rounded to a step.
    """
    upper = round_up(upper)
    step = 10.0 ** (np.floor(np.log10(upper)) - 2.0)
    value = step * round(usual / step) if start_value is None else start_value
    return Slider(label, value, minimum=min_steps * step, maximum=upper, step=step)


def _sizes(vehicle: AnyVehicle, plane: str) -> tuple[float, float]:
    """Return ``|B|`` and ``|B|/beta`` [s] of a vehicle in a plane; 1 without a moment.

    They are the scales of gains: B is the trim deflection per angle of attack, beta sqrt(mu_alpha).
    """
    c = coefficients_of(vehicle, plane)
    B, beta = float(np.abs(c.B)) or 1.0, float(np.sqrt(np.abs(np.asarray(c.mu_alpha)))) or 1.0
    return B, B / beta


def round_up(size: float) -> float:
    """Return the smallest round number that is not below `size`, a mantissa times a power of ten.

    Rounding of 1e-12 does not make a round number the next one.
    """
    ten = 10.0 ** np.floor(np.log10(size))
    index = np.searchsorted(_ROUND_MANTISSAS, size / ten * (1.0 - 1e-12))
    return float(ten * _ROUND_MANTISSAS[index])


def study_text(choices: Choices, source: str | None = None) -> str:
    """Return the text of a study file with all choices but the law.

    A rigid vehicle is written with all its numbers; a flexible one, or one defined by its
    coefficients, is named by its source: `InputError` where it has none.
    """
    plan, vehicle = choices.plan, choices.plan.vehicle
    rigid = vehicle if isinstance(vehicle, Vehicle) and vehicle.structure is None else None
    named = rigid is None
    if named and source is None:
        raise InputError(
            "a vehicle that was made in Python stands in a study file without its structure:"
            " switch bending and slosh off, or explore a vehicle file"
        )
    question = {"model": plan.model, "plane": plan.plane, "dead_band": plan.dead_band}
    head = ({"vehicle": source} if named else {}) | question
    tables: list[tuple[str, Table]] = [
        ("[study]", head | ({"sign": plan.sign} if plan.sign else {})),
        *([] if rigid is None else [("[study.vehicle]", vehicle_table(rigid))]),
        *_wind(plan.wind),
        ("[nozzle]", _nozzle(choices)),
        *_autopilot(choices),
        *_criteria(plan.criteria),
        *_turbulence(plan.turbulence),
    ]
    return f"# Written by tvclin explore, where the law {choices.law} was flown.\n" + "".join(
        f"\n{heading}\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items())
        for heading, table in tables
    )


def write_study(choices: Choices, name: str, source: str | None = None) -> Path:
    """Write choices as ``study-NAME.toml``, numbered where that exists, and return its path.

    `source`: file that defines the vehicle, which the study names; None to write its numbers.
    """
    text = study_text(choices, source)
    stem = re.sub(r"[^\w.-]+", "-", f"study-{Path(name).stem.removeprefix('study-')}")
    numbered = (f"{stem}{f'-{k}' if k > 1 else ''}.toml" for k in count(1))
    path = next(path for path in map(Path, numbered) if not exists(path))
    write_new(path, text)
    return path.resolve()


def _wind(wind: Any) -> list[tuple[str, Table]]:
    """Return the tables of a study file for a wind and its gust.

    A direction is written relative to the flight, north: `azimuth_deg` is zero.
    """
    assert isinstance(wind, ShapedWind)
    peak = _peak(float(wind.peak), wind.speed)
    table: Table = {"shape": wind.shape, **peak, "duration_s": wind.duration}
    if wind.heading is not None:
        table |= {"direction_deg": _deg(wind.heading), "azimuth_deg": 0.0}
    gust = wind.gust
    if gust is None:
        return [("[wind]", table)]
    gust_table = {
        **_peak(float(gust.peak), wind.gust_speed),
        "duration_s": _short(float(gust.end - gust.onset)),
        "plateau_s": _short(plateau_of(gust)),
        "peak_time_s": wind.gust_at,
    }
    return [("[wind]", table), ("[gust]", _without_none(gust_table))]


def _peak(angle: float, speed: float | None) -> Table:
    """Return the key of the peak of a wind or gust for a study file, with its value.

    `angle`: the peak [rad]. `speed`: its speed [m/s], which is written instead; None without.
    """
    return {"peak_deg": _deg(angle)} if speed is None else {"peak_speed_m_per_s": speed}


def _nozzle(choices: Choices) -> Table:
    """Return the tables of a study file for the nozzle of the choices."""
    nozzle = choices.plan.nozzle
    servo = nozzle.actuator
    return _without_none(
        {
            "limit_deg": _deg(nozzle.limit),
            "limit_shape": nozzle.limit_shape,
            "rate_limit_deg_per_s": _deg(nozzle.rate_limit),
            "actuator_frequency_rad_per_s": servo.natural_frequency if servo else 0.0,
            "actuator_damping": servo.damping if servo else None,
        }
    )


def _autopilot(choices: Choices) -> list[tuple[str, Table]]:
    """Return the tables of a study file for the autopilot of the choices.

    Rule and gains are written where they are not the default. Filters are written as fractions of
    polynomials, highest power first.
    """
    design, specified = choices.plan.autopilot_design, parameters(AutopilotDesign)
    # design, natural frequency, damping and the gains first
    names = (*RULE_PARAMETERS[:3], *GIVEN_GAINS, *RULE_PARAMETERS[3:], *ADDED_GAINS)
    table = {
        specified[name].document_key: getattr(design, name)
        for name in names
        if getattr(design, name) != specified[name].default
    }
    table |= {"delay_ms": _short(1e3 * design.delay), "sample_rate_Hz": design.sample_rate}
    filters = [
        {
            "kind": "rational",
            "numerator": filter_table.numerator.tolist(),
            "denominator": filter_table.denominator.tolist(),
            "on": position,
        }
        for position, chain in CHAIN_OF_POSITION.items()
        for filter_table in design.chains[chain]
    ]
    named = [("[[autopilot.filter]]", filter_table) for filter_table in filters]
    return [("[autopilot]", _without_none(table)), *named]


def _criteria(criteria: Criteria | None) -> list[tuple[str, Table]]:
    """Return the table of a study file for criteria: a standard set, and its changed limits.

    An empty list for None. `InputError` for a set of Python, which no file has.
    """
    if criteria is None:
        return []
    standard = criteria.base or criteria
    name = one_of("criteria of a study file", standard.name, CRITERIA)
    changed = {  # with the unit of the delay in its key
        f"{r.margin}{'_s' if r.margin == 'delay_margin' else ''}": r.limit
        for r in criteria.limits
        if r not in standard.limits
    }
    return [("[criteria]", {"name": name} | changed)]


def _turbulence(request: TurbulenceRequest | None) -> list[tuple[str, Table]]:
    """Return the tables of a study file for turbulence, with its levels over altitude.

    `request`: the turbulence; an empty list for None.
    """
    if request is None:
        return []
    items = [item for item in parameters(TurbulenceRequest).values() if item.name != "table"]
    values = {item.document_key: (getattr(request, item.name), item.default) for item in items}
    keys = {key: value for key, (value, usual) in values.items() if value not in (None, usual)}
    air = request.table  # intensity and length over altitude
    if air is None or air.altitude is None:
        return [("[turbulence]", keys)]
    columns = {"altitude_m": air.altitude, "intensity_m_per_s": air.intensity}
    columns |= {} if air.length is None else {"length_m": air.length}
    rows = [np.broadcast_to(column, air.altitude.shape).tolist() for column in columns.values()]
    levels = [dict(zip(columns, level, strict=True)) for level in zip(*rows, strict=True)]
    form = {"spectrum": air.spectrum, "component": air.component}
    return [
        ("[turbulence]", keys | form),
        *(("[[turbulence.level]]", level) for level in levels),
    ]


def _without_none(table: Table) -> Table:
    """Return a table without the keys whose value is None."""
    return {key: value for key, value in table.items() if value is not None}


def _deg(angle: float | None) -> float | None:
    """Return an angle [rad] in degrees, to twelve digits; None stays None."""
    return None if angle is None else _short(float(np.degrees(angle)))


def _short(value: float) -> float:
    """Return a value to twelve digits, as the panel shows it, without the rounding of its unit."""
    return float(f"{value:.12g}")
