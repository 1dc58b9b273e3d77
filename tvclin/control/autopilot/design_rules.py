"""Specification of an autopilot, as files give it: gains or the name of a design rule, and filters.

The table [autopilot] holds the fields of `AutopilotDesign`; each filter has a table of its own,
[[autopilot.filter]].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.fields import checked, count, file_table, quantity, word
from tvclin.base.files import exists
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import ACCELEROMETER, ACCELEROMETER_BANDWIDTH, CHAINS, GAINS
from tvclin.control.autopilot.gain_table import GainTable, load_gains, specified_filters
from tvclin.control.autopilot.gains import (
    canonical_gains,
    design_gains,
    drift_gains,
    drift_minimum_gains,
    half_relief_gains,
    load_minimum_gains,
    lqr_gains,
)
from tvclin.linear.plant import STATION_RANGE, Plant
from tvclin.vehicle.filters import Filter

LEAST_NOZZLE = "least-nozzle"
DRIFT_POLES = "drift-poles"
_RULES: dict[str, Callable[..., Autopilot]] = {
    "canonical": canonical_gains,
    "poles": design_gains,
    "drift-minimum": drift_minimum_gains,
    "load-minimum": load_minimum_gains,
    DRIFT_POLES: drift_gains,
    "half-relief": half_relief_gains,
    "lqr": lqr_gains,
}
"""Design rules of a plant alone, by name."""
POLE_PLACEMENT_RULES = ("poles", "drift-minimum", "load-minimum")
"""Names of the rules that place the poles of the attitude, and no others."""
DESIGNS = (*_RULES, LEAST_NOZZLE)
MINIMA = ("peak", "limit")
"""Deflections that gains may minimise."""
_DEFAULT_DAMPING = 0.7
"""Damping ratio of rules that place poles, if none is specified."""
_POLE_PAIR = ("natural_frequency", "damping")
"""Numbers of the pole pair of the closed loop."""
_DRIFT_PAIR = ("drift_frequency", "drift_damping")
_WEIGHTS = ("alpha_weight", "drift_rate_weight", "drift_weight")
_RULE_OF_NUMBER = {**dict.fromkeys(_DRIFT_PAIR, DRIFT_POLES), **dict.fromkeys(_WEIGHTS, "lqr")}
"""Rule of a number that a single rule has, by the name of the number."""
_PLACED_PAIRS = {
    **dict.fromkeys(POLE_PLACEMENT_RULES, _POLE_PAIR),
    DRIFT_POLES: (*_POLE_PAIR, *_DRIFT_PAIR),
}
"""Numbers of the pole pairs that a rule places, by its name."""
_FREQUENCIES = ("natural_frequency", "drift_frequency")
"""Numbers of pole pairs that have no default."""
RULE_PARAMETERS = ("design", *_POLE_PAIR, *_RULE_OF_NUMBER)
RULE_KEYS = (*RULE_PARAMETERS, "crossover")
GIVEN_GAINS = ("attitude_gain", "rate_gain", "alpha_gain")
"""Gains on attitude, its rate and the angle of attack, which replace a rule or follow from it."""
ADDED_GAINS = (*(name for name in GAINS if name not in GIVEN_GAINS), *ACCELEROMETER)
"""Gains that are added to a rule or to given gains, and the numbers of the accelerometer."""


@dataclass(frozen=True, kw_only=True)
class AutopilotDesign:
    """Specification of an autopilot: its gains, or a rule that designs them.

    Attributes
    ----------
    design : str, optional
        Rule for the gains; that for the least nozzle needs a wind.
    natural_frequency : float, optional
        Natural frequency of the closed loop [rad/s]; the rule is then poles.
    damping : float, optional
        Damping ratio of the closed loop, for rules that place poles.
    drift_frequency : float, optional
        Natural frequency of the drift [rad/s], of the rule drift-poles.
    drift_damping : float, optional
        Damping ratio of the drift, of that rule.
    alpha_weight : float, optional
        Weight of the squared angle of attack over the attitude's, of the rule lqr.
    drift_rate_weight : float, optional
        Weight of the squared drift rate [m/s], likewise.
    drift_weight : float, optional
        Weight of the squared drift [m], likewise.
    attitude_gain : float, optional
        Gain a0 on the attitude, in place of a rule.
    rate_gain : float, optional
        Gain a1 on the attitude rate [s].
    alpha_gain : float, optional
        Gain b0 on the angle of attack.
    integral_gain : float
        Gain aI on the integrated attitude [1/s].
    drift_rate_gain : float
        Gain d1 on the lateral drift rate [rad s/m].
    drift_gain : float
        Gain d0 on the lateral drift [rad/m].
    acceleration_gain : float
        Gain g on the measured lateral acceleration [rad s2/m].
    acceleration_station : float
        Position of the accelerometer ahead of the centre of gravity [m].
    accelerometer_bandwidth : float
        Bandwidth of the accelerometer, a first-order lag [rad/s].
    delay : float
        Delay between sensors and actuator [s].
    crossover : float, optional
        Highest gain crossover [rad/s] of gains for the minimum deflection.
    minimum : str
        Deflection that least-nozzle minimises: the peak of the linear loop, or the limit with which
        flights survive.
    sudden_ends : int
        Number of sudden ends of each wind that the minimum limit survives as well.
    filters, attitude_filters, rate_filters : tuple of Filter
        Filters of the command, of the attitude and of the rate, see `Autopilot`.
    sample_rate : float, optional
        Sample rate of the autopilot or law [Hz]. Without it margins are of a continuous one, and
        flights sample it at 100.
    schedule : GainTable, optional
        Gains over the flight, in place of a rule, filters over the flight, and notches that
        follow a mode.
    """

    design: str | None = word(DESIGNS, None, shown="canonical")
    natural_frequency: float | None = quantity("natural frequency", None, errors.positive)
    damping: float | None = quantity("number", None, errors.positive, shown=f"{_DEFAULT_DAMPING:g}")
    drift_frequency: float | None = quantity("natural frequency", None, errors.positive)
    drift_damping: float | None = quantity(
        "number", None, errors.positive, shown=f"{_DEFAULT_DAMPING:g}"
    )
    alpha_weight: float | None = quantity("number", None, errors.nonnegative)
    drift_rate_weight: float | None = quantity("number", None, errors.nonnegative)
    drift_weight: float | None = quantity("number", None, errors.nonnegative)
    attitude_gain: float | None = quantity(GAINS["attitude_gain"], None)
    rate_gain: float | None = quantity(GAINS["rate_gain"], None)
    alpha_gain: float | None = quantity(GAINS["alpha_gain"], None)
    integral_gain: float = quantity(GAINS["integral_gain"], 0.0)
    drift_rate_gain: float = quantity(GAINS["drift_rate_gain"], 0.0)
    drift_gain: float = quantity(GAINS["drift_gain"], 0.0)
    acceleration_gain: float = quantity(GAINS["acceleration_gain"], 0.0)
    acceleration_station: float = quantity("length", 0.0, STATION_RANGE)
    accelerometer_bandwidth: float = quantity(
        "natural frequency", ACCELEROMETER_BANDWIDTH, errors.positive
    )
    delay: float = quantity("delay", 0.0, errors.nonnegative)
    crossover: float | None = quantity("natural frequency", None, errors.positive)
    minimum: str = word(MINIMA, "peak")
    sudden_ends: int = count(0)
    filters: tuple[Filter, ...] = ()
    attitude_filters: tuple[Filter, ...] = ()
    rate_filters: tuple[Filter, ...] = ()
    sample_rate: float | None = quantity("sample rate", None, errors.positive)
    schedule: GainTable | None = None

    def __post_init__(self) -> None:
        """Check every field, the type of the schedule, and that chains contain filters."""
        checked(self)
        if self.schedule is not None:
            errors.instance("schedule", self.schedule, GainTable, "see load_gains")
        for name in CHAINS:
            chain = errors.each(name, getattr(self, name), Filter, "Filter.notch(...)")
            object.__setattr__(self, name, chain)

    @classmethod
    def from_table(cls, table: Mapping[str, Any], folder: Path = Path()) -> Self:
        """Return the specification in a file's table [autopilot], with its [[autopilot.filter]].

        `table`: keys and values of the table, as TOML gives them. `folder`: folder in which the
        table of gains that `schedule` names is looked for first. `InputError` for unknown keys, and
        in the same cases as `AutopilotDesign` and `load_gains`.
        """
        keys = AUTOPILOT_TABLE.read(table)
        name, rows = keys.pop("schedule", None), keys.pop("filter", ())
        gains, columns = GainTable(), dict[str, FloatArray]()  # columns: numbers of filters
        if name is not None:
            path = errors.path("folder", folder) / errors.text("schedule", name)
            gains, columns = load_gains(path if exists(path) else Path(name))
        filters = specified_filters(rows, columns)
        # over the flight: gains, filters with columns of numbers, and notches at a mode
        if name is not None or filters.notches:
            keys["schedule"] = replace(gains, chains=filters.scheduled, notches=filters.notches)
        return cls(**keys, **filters.constant)

    @property
    def unspecified(self) -> bool:
        """Whether no rule, and no gain on attitude, rate or angle of attack, is specified.

        The gains are then by the rule "canonical".
        """
        if self.schedule is not None and self.schedule.gains:
            return False
        rule = (getattr(self, name) for name in RULE_PARAMETERS)
        gains = (getattr(self, name) for name in GIVEN_GAINS)
        return all(number is None for number in (*rule, *gains))

    @property
    def has_gains(self) -> bool:
        """Whether a rule or any gain is specified, also a gain added to the gains of a rule."""
        return not self.unspecified or any(getattr(self, n) for n in GAINS if n in ADDED_GAINS)

    @property
    def chains(self) -> dict[str, tuple[Filter, ...]]:
        """Filters of command, attitude and rate by the names of their fields, `CHAINS`."""
        return {name: getattr(self, name) for name in CHAINS}

    @property
    def without_filters_and_delay(self) -> Self:
        """Specification with its delay and filters removed."""
        return replace(self, delay=0.0, filters=(), attitude_filters=(), rate_filters=())

    def options(self, actuator: Actuator | None) -> dict[str, Any]:
        """Return the arguments of an `Autopilot` other than gains on attitude, rate and alpha.

        `actuator`: actuator of the nozzle, or None; `InputError` for another type.
        """
        if actuator is not None:
            errors.instance("actuator", actuator, Actuator, "of a bandwidth")
        added = {name: getattr(self, name) for name in ADDED_GAINS}  # also of the accelerometer
        return {
            "actuator": actuator,
            **added,
            "delay": self.delay,
            "sample_rate": self.sample_rate,
            **self.chains,
        }

    def check_gains(self) -> None:
        """Raise `InputError` for gains or a rule that are not complete, or exclude each other.

        They are gains on attitude, rate and angle of attack; without any of them a rule, with its
        numbers.
        """
        if self.crossover is not None and self.design != LEAST_NOZZLE:
            raise errors.InputError(
                f"crossover is of gains for the minimum deflection: design {LEAST_NOZZLE}"
            )
        if all(getattr(self, name) is None for name in GIVEN_GAINS):
            _rule_numbers(self)
            return
        gains, rule = (
            [name for name in names if getattr(self, name) is not None]
            for names in (GIVEN_GAINS, RULE_PARAMETERS)
        )
        if rule:
            names = ", ".join((*gains, *rule))
            raise errors.InputError(f"give gains or a rule for them, not both; got {names}")
        if self.attitude_gain is None or self.rate_gain is None:
            raise errors.InputError("gains of your own need attitude_gain and rate_gain, both")

    def autopilot(self, plant: Plant, actuator: Actuator | None = None) -> Autopilot:
        """Return the autopilot for a plant, with the actuator of its nozzle.

        Its gains are the given ones; without them the rule `design` sets them.

        `InputError` for a rule and gains together, a single gain, a rule with too few numbers or
        too many, a schedule over the flight, and in the same cases as the rule.
        """
        errors.instance("plant", plant, Plant, "see Plant.from_vehicle")
        errors.single("plant", plant.batch)
        if self.schedule is not None:
            raise errors.InputError("a schedule of gains and a notch at a mode need a flight")
        options = self.options(actuator)
        self.check_gains()
        if self.attitude_gain is not None and self.rate_gain is not None:
            return Autopilot(
                attitude_gain=self.attitude_gain,
                rate_gain=self.rate_gain,
                alpha_gain=self.alpha_gain or 0.0,
                **options,
            )
        rule, numbers = _rule_numbers(self)
        if rule == LEAST_NOZZLE:
            raise errors.InputError(
                f"design {LEAST_NOZZLE} needs a wind: tvclin design and study files have one; in"
                " Python see minimum_deflection_gains"
            )
        for name in _designed_drift_gains(rule, numbers):
            del options[name]  # zero: the rule sets this gain
        return _RULES[rule](plant, **numbers, **options)


AUTOPILOT_TABLE = file_table("[autopilot]", AutopilotDesign, words=("schedule",), lists=("filter",))


def _rule_numbers(design: AutopilotDesign) -> tuple[str, dict[str, float]]:
    """Return the name of the rule of a design, and its numbers by the names of its arguments.

    Without a name the rule is "poles" if a frequency or damping is specified, else "canonical". Its
    numbers are natural frequencies [rad/s], damping ratios, and weights. `InputError` for a rule
    with too few numbers or too many, and for a gain of the design that the rule determines.
    """
    values = {name: getattr(design, name) for name in (*_POLE_PAIR, *_RULE_OF_NUMBER)}
    numbers = {name: value for name, value in values.items() if value is not None}
    has_poles = any(name in numbers for name in _POLE_PAIR)
    default = "poles" if has_poles else "canonical"
    rule = errors.one_of("design", design.design or default, DESIGNS)
    for name in numbers:
        if _RULE_OF_NUMBER.get(name, rule) != rule:  # a number of one rule alone
            raise errors.InputError(
                f"{name} is of gains by design {_RULE_OF_NUMBER[name]}; got design {rule}"
            )
    for name in _designed_drift_gains(rule, numbers):
        if getattr(design, name):
            raise errors.InputError(f"{name} follows from design {rule}; leave it out")
    if has_poles and rule in _RULES and rule not in _PLACED_PAIRS:
        raise errors.InputError(f"design {rule} takes no natural_frequency and no damping")
    for name in _PLACED_PAIRS.get(rule, ()):  # numbers of the pole pairs that the rule places
        if name not in numbers and name in _FREQUENCIES:
            raise errors.InputError(f"design {rule} needs {name}, in rad/s")
        numbers.setdefault(name, _DEFAULT_DAMPING)
    return rule, numbers


def _designed_drift_gains(rule: str, numbers: Mapping[str, float]) -> tuple[str, ...]:
    """Return the names of the gains of the drift that a rule with these numbers determines.

    They are both gains, of drift-poles, and of lqr with a weight on the drift; else none.
    """
    weighted = numbers.get("drift_rate_weight") or numbers.get("drift_weight")
    return ("drift_rate_gain", "drift_gain") if rule == DRIFT_POLES or weighted else ()
