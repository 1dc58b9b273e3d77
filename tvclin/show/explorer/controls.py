"""The controls: where each begins for a case, the plan that they ask for, and which of them rest.

Values are by field, as a list or a slider shows them: in the units of its label, zero for what is
not there.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from tvclin.answers.case import FROZEN, SIGNS
from tvclin.answers.least_gains.asked import autopilot_asked
from tvclin.answers.nozzle import USUAL_ACTUATOR, Nozzle
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.boundary.stops import STOPS
from tvclin.control.autopilot.design_rules import GIVEN_GAINS, LEAST_NOZZLE, AutopilotDesign
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.linear.plant import MODELS
from tvclin.show.explorer.choices import CONTROLS, REPORT, TRIM, Choices, loop_of
from tvclin.show.explorer.parts import LONGEST
from tvclin.show.explorer.picture import round_up
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.linear_vehicle import AnyVehicle, coefficients_of, complete_vehicle
from tvclin.winds.histories import History
from tvclin.winds.shaped import SHAPES, ShapedWind
from tvclin.winds.wind_file import gust_of

IN_PLANE, FROM_SIDE = "in the plane", "from a direction"
OWN, CANONICAL = "own gains", "canonical"
WORST = "worst"
_RULES = (OWN, CANONICAL, "half-relief", "lqr")
_DEG = np.pi / 180.0
_PEAK = 5.0

Values = dict[str, Any]


class Slider(NamedTuple):
    """A label, where it starts, its least and largest value, and its step."""

    label: str
    value: float
    least: float
    most: float
    step: float


def settled(plan: StudyPlan) -> StudyPlan:
    """Return a plan whose gains, where they are sought, are those that were found."""
    design = plan.design
    if plan.asked.design == LEAST_NOZZLE:
        found = autopilot_asked(plan, plan.history, plan.held_to)
        own: Any = {name: float(getattr(found, name)) for name in GIVEN_GAINS}
        design = replace(loop_of(plan.asked), **own)
    return replace(plan, design=design)


def lists(plan: StudyPlan, vehicles: list[str]) -> dict[str, tuple[str, list[str], str]]:
    """Return the lists, by field: label, what they offer, and where they begin for a plan."""
    wind, asked, stop = plan.wind, plan.asked, plan.nozzle.stop
    rule = _rule(asked)
    own_rules = [] if rule in _RULES else [rule]
    law = TRIM if plan.design is None else AUTOPILOT
    direction = IN_PLANE if plan.heading is None else FROM_SIDE
    offered = {
        "vehicle": ("vehicle", vehicles, vehicles[0]),
        "plane": ("plane", [*PLANES, BOTH], plan.planes),
        "stop": ("stop of both", list(STOPS), stop if isinstance(stop, str) else next(iter(STOPS))),
        "model": ("model", list(MODELS), plan.model),
        "shape": ("wind shape", list(SHAPES), plan.shape),
        "direction": ("wind blows", [IN_PLANE, FROM_SIDE], direction),
        "sign": ("sign that counts", [WORST, *SIGNS, FROZEN], plan.sign or WORST),
        "law": ("law", list(CONTROLS), law),
        "design": ("gains", [*_RULES, *own_rules], rule),
    }
    assert isinstance(wind, ShapedWind)
    return offered


def switches(plan: StudyPlan) -> dict[str, tuple[str, bool]]:
    """Return what is on or off, by field: label and start."""
    return {
        "structure": ("bending and slosh", plan.vehicle.structure is not None),
        "filters": ("filters of the file", any(plan.asked.chains.values())),
    }


def sliders(plan: StudyPlan, vehicles: list[AnyVehicle]) -> dict[str, Slider]:
    """Return the sliders, by field: where they begin for a plan, and room for all vehicles."""
    start, *others = (_sizes(one, plan.plane) for one in (plan.vehicle, *vehicles))
    B, per_rate = (max(both) for both in zip(*others, strict=True))
    wind, nozzle, asked = plan.wind, plan.nozzle, plan.asked
    assert isinstance(wind, ShapedWind)
    gust, rate = wind.gust, nozzle.rate_limit or 0.0
    servo = 0.0 if nozzle.actuator is None else float(nozzle.actuator.natural_frequency)
    gust_peak = 0.0 if gust is None else float(gust.peak) / _DEG
    lasts = 1.0 if gust is None else float(gust.end - gust.onset)
    heading = 45.0 if wind.heading is None else wind.heading / _DEG
    limit = None if nozzle.limit is None else nozzle.limit / _DEG
    every = {
        "duration": Slider("wind duration [s]", wind.duration, 0.5, LONGEST, 0.1),
        "peak": Slider("wind peak [deg]", wind.peak / _DEG, -4.0 * _PEAK, 4.0 * _PEAK, 0.1),
        "heading": Slider("wind from [deg]", heading, -180.0, 360.0, 1.0),
        "gust_peak": Slider("gust peak [deg]", gust_peak, -10.0, 10.0, 0.1),
        "gust_duration": Slider("gust length [s]", lasts, 0.1, 10.0, 0.1),
        "dead_band": Slider("dead band K [-]", plan.dead_band, 0.0, 1.0, 0.01),
        "limit": _fitted("limit [deg]", 0.75 * start[0] * _PEAK, 3.0 * B * _PEAK, 1, limit),
        "rate_limit": Slider("rate limit [deg/s]", rate / _DEG, 0.0, 20.0, 0.1),
        "actuator": Slider("actuator [rad/s]", servo, 0.0, 100.0, 0.1),
        "attitude_gain": _fitted("gain a0 [-]", 5.0 * start[0], 15.0 * B, 0, asked.attitude_gain),
        "rate_gain": _fitted("gain a1 [s]", 3.0 * start[1], 15.0 * per_rate, 0, asked.rate_gain),
        "alpha_gain": _signed("gain b0 [-]", 5.0 * B, asked.alpha_gain),
        "delay": Slider("delay [ms]", 1e3 * asked.delay, 0.0, 200.0, 1.0),
        "sample_rate": Slider("samples [Hz]", asked.sample_rate or 0.0, 0.0, 200.0, 1.0),
    }
    return {field: _with_room(one) for field, one in every.items()}


def choices_of(base: StudyPlan, vehicle: AnyVehicle, v: Values) -> Choices:
    """Return what the controls ask for; what none of them says is as in the plan of the file.

    `InputError` as `StudyPlan` and all that is in it.
    """
    both = v["plane"] == BOTH
    slanting = both or v["direction"] == FROM_SIDE
    file_wind, servo = base.wind, base.nozzle.actuator or USUAL_ACTUATOR
    assert isinstance(file_wind, ShapedWind)
    actuator = replace(servo, natural_frequency=v["actuator"]) if v["actuator"] else None
    wind = ShapedWind(
        v["shape"],
        v["peak"] * _DEG,
        v["duration"],
        v["heading"] * _DEG if slanting else None,
        _gust(v["gust_peak"], v["gust_duration"], plateau_of(file_wind.gust)),
        file_wind.gust_at if v["gust_peak"] else None,
        **_speeds(base, vehicle, v),
    )
    plan = replace(
        base,
        vehicle=vehicle if v["structure"] else vehicle.rigid,
        model=v["model"],
        plane=_shown_plane(base.plane, vehicle, wind) if both else v["plane"],
        wind=wind,
        nozzle=Nozzle(
            limit=v["limit"] * _DEG,
            stop=v["stop"] if both else None,
            rate_limit=v["rate_limit"] * _DEG or None,
            actuator=actuator,
        ),
        design=_design(base.asked, v),
        dead_band=v["dead_band"],
        criteria=None,
        sign=None if v["sign"] == WORST or "sign" in idle(base, vehicle, v) else v["sign"],
    )
    return Choices(plan=plan, law=v["law"])


def _speeds(base: StudyPlan, vehicle: AnyVehicle, v: Values) -> dict[str, float | None]:
    """Return the speeds [m/s] of the wind and its gust in the file, while their angles stay."""
    start: Values = {k: slider.value for k, slider in sliders(base, [base.vehicle]).items()}
    start |= {k: choice[2] for k, choice in lists(base, [""]).items()}
    wind = base.wind
    assert isinstance(wind, ShapedWind)
    stays = vehicle is base.vehicle and all(
        v[field] == start[field] for field in ("plane", "direction", "heading")
    )
    speeds = {"speed": ("peak", wind.speed), "gust_speed": ("gust_peak", wind.gust_speed)}
    return {
        field: speed if stays and v[angle] == start[angle] else None
        for field, (angle, speed) in speeds.items()
    }


def _shown_plane(plane: str, vehicle: AnyVehicle, wind: ShapedWind) -> str:
    """The plane whose flight is shown of both; the other one where the wind has no part in it."""
    whole = complete_vehicle(vehicle, "a wind with a direction")
    blows = [one for one, peak in wind.peaks(float(np.asarray(whole.attitude))).items() if peak]
    return plane if plane in blows else blows[0]


def idle(base: StudyPlan, vehicle: AnyVehicle, v: Values) -> dict[str, str]:
    """Return the controls that change nothing as the others stand, each with the reason."""
    both = v["plane"] == BOTH
    slanting = both or v["direction"] == FROM_SIDE
    ruled = f"the rule {v['design']} sets it: take {OWN}"
    reasons = {
        "structure": vehicle.structure is None and "the file of this vehicle has no structure",
        "filters": not any(base.asked.chains.values()) and "the file has no filters",
        "stop": not both and f"counts only in the plane {BOTH}",
        "direction": both and "both planes need a direction",
        "heading": not slanting and "counts only with a wind from a direction",
        "sign": v["sign"] != FROZEN
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
    """Return how long a gust stays at its peak [s]: it has four knots then, as of `gust_of`."""
    if gust is None or gust.knots.size < 4:
        return 0.0
    return float(gust.knots[2] - gust.knots[1])


@lru_cache(maxsize=256)
def _gust(peak: float, duration: float, plateau: float) -> History | None:
    """The same gust for the same numbers, so that what depends on it is known again."""
    return gust_of(peak * _DEG, duration, plateau if plateau < duration else 0.0) if peak else None


def _rule(asked: AutopilotDesign) -> str:
    if asked.attitude_gain is not None:
        return OWN
    return asked.design or (CANONICAL if asked.natural_frequency is None else "poles")


def _design(asked: AutopilotDesign, v: Values) -> AutopilotDesign:
    rule, chains = v["design"], asked.chains if v["filters"] else {}
    own: Any = {"design": rule}
    if rule == OWN:
        own = {name: v[name] for name in GIVEN_GAINS}
    elif rule == _rule(asked):
        own |= {name: getattr(asked, name) for name in ("natural_frequency", "damping")}
    return AutopilotDesign(
        integral_gain=asked.integral_gain,
        delay=1e-3 * v["delay"],
        sample_rate=v["sample_rate"] or None,
        **own | chains,
    )


def _fitted(label: str, start: float, most: float, least: int, given: float | None) -> Slider:
    """A slider to a round number, of some hundred steps, from so many steps on."""
    most = round_up(most)
    step = 10.0 ** (np.floor(np.log10(most)) - 2.0)
    value = step * round(start / step) if given is None else given
    return Slider(label, value, least * step, most, step)


def _signed(label: str, most: float, given: float | None) -> Slider:
    one = _fitted(label, 0.0, most, 0, given or 0.0)
    return one._replace(least=-one.most)


def _with_room(one: Slider) -> Slider:
    """A slider that holds where it begins."""
    most = one.most if one.value <= one.most else round_up(one.value)
    return one._replace(least=min(one.least, one.value), most=most)


def _sizes(vehicle: AnyVehicle, plane: str) -> tuple[float, float]:
    """|B|, and |B|/beta [s], of which canonical gains are made; 1 where there is no moment."""
    c = coefficients_of(vehicle, plane)
    B, beta = float(np.abs(c.B)) or 1.0, float(np.sqrt(np.abs(np.asarray(c.mu_alpha)))) or 1.0
    return B, B / beta
