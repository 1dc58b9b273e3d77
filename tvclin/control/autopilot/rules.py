"""Gains by the name of a rule, or gains of one's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

from tvclin.base.errors import (
    InputError,
    each,
    instance,
    nonnegative,
    number,
    one_of,
    positive,
    single,
)
from tvclin.base.tables import FileTable
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS, GAINS
from tvclin.control.autopilot.filter_tables import filter_chains
from tvclin.control.autopilot.gains import (
    canonical_gains,
    design_gains,
    drift_minimum_gains,
    half_relief_gains,
    load_minimum_gains,
)
from tvclin.control.autopilot.optimal import lqr_gains
from tvclin.linear.plant import Plant
from tvclin.vehicle.filters import Filter

LEAST_NOZZLE = "least-nozzle"
DESIGNS = (
    "canonical",
    "poles",
    "drift-minimum",
    "load-minimum",
    "half-relief",
    "lqr",
    LEAST_NOZZLE,
)
BY_POLES: dict[str, Callable[..., Autopilot]] = {
    "poles": design_gains,
    "drift-minimum": drift_minimum_gains,
    "load-minimum": load_minimum_gains,
}
_DAMPING = 0.7
_RULE = {"natural_frequency": "natural frequency", "damping": "number"}
RULE_KEYS = ("design", *_RULE, "crossover")
OWN_GAINS = ("attitude_gain", "rate_gain", "alpha_gain")
"""Gains that stand in place of a rule."""
AUTOPILOT_TABLE = FileTable(
    "[autopilot]",
    {
        **_RULE,
        **GAINS,
        "delay": "delay",
        "crossover": "natural frequency",
        "sample_rate": "sample rate",
    },
    words=("design",),
    lists=("filter",),
)


@dataclass(frozen=True, kw_only=True)
class AutopilotDesign:
    """An autopilot by its gains, or by a rule that designs them.

    Attributes
    ----------
    design : str, optional
        One of `DESIGNS`; "poles" where a frequency or a damping is given, else "canonical". Gains
        for the "least-nozzle" are found for a wind, see `least_deflection_gains`.
    natural_frequency, damping : float, optional
        Of the closed loop [rad/s], for the rules that ask for poles; the damping is 0.7 unless
        given.
    attitude_gain, rate_gain, alpha_gain : float, optional
        As of `Autopilot`, in place of a rule.
    integral_gain : float
        On the integrated attitude [1/s].
    delay : float
        Between sensors and actuator [s].
    crossover : float, optional
        The highest gain crossover [rad/s] of gains for the least nozzle.
    filters, attitude_filters, rate_filters : tuple of Filter
        As of `Autopilot`.
    sample_rate : float, optional
        Samples in a second [Hz] of an autopilot in steps; it is continuous without.
    """

    design: str | None = None
    natural_frequency: float | None = None
    damping: float | None = None
    attitude_gain: float | None = None
    rate_gain: float | None = None
    alpha_gain: float | None = None
    integral_gain: float = 0.0
    delay: float = 0.0
    crossover: float | None = None
    filters: tuple[Filter, ...] = ()
    attitude_filters: tuple[Filter, ...] = ()
    rate_filters: tuple[Filter, ...] = ()
    sample_rate: float | None = None

    def __post_init__(self) -> None:
        if self.design is not None:
            one_of("design", self.design, DESIGNS)
        object.__setattr__(self, "delay", number("delay", self.delay, nonnegative))
        for name in (*_RULE, *GAINS, "crossover"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, number(name, getattr(self, name)))
        if self.sample_rate is not None:
            rate = number("sample_rate", self.sample_rate, positive, "Hz")
            object.__setattr__(self, "sample_rate", rate)
        for name in CHAINS:
            chain = each(name, getattr(self, name), Filter, "Filter.notch(...)")
            object.__setattr__(self, name, chain)

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Self:
        """Return what the table [autopilot] of a file asks for, with its [[autopilot.filter]].

        Raises
        ------
        InputError
            For what the table may not hold, and as `AutopilotDesign` itself.
        """
        found = AUTOPILOT_TABLE.read(table)
        chains: dict[str, Any] = filter_chains(found.pop("filter", ()))
        return cls(**found, **chains)

    @property
    def chains(self) -> dict[str, tuple[Filter, ...]]:
        """The filters, by where they stand."""
        return {name: getattr(self, name) for name in CHAINS}

    @property
    def bare(self) -> Self:
        """The same without delay and filters."""
        return replace(self, delay=0.0, filters=(), attitude_filters=(), rate_filters=())

    def autopilot(self, plant: Plant, actuator: Actuator | None = None) -> Autopilot:
        """Return the autopilot for a plant, with the actuator of its nozzle.

        Raises
        ------
        InputError
            For a rule and gains together, one gain alone, a rule with too few numbers or too many,
            and as the rule itself.
        """
        instance("plant", plant, Plant, "see Plant.from_vehicle")
        single("plant", plant.batch)
        if self.crossover is not None and self.design != LEAST_NOZZLE:
            raise InputError(f"crossover is of gains for the least nozzle: design {LEAST_NOZZLE}")
        options: dict[str, Any] = {
            "actuator": actuator,
            "integral_gain": self.integral_gain,
            "delay": self.delay,
            "sample_rate": self.sample_rate,
            **self.chains,
        }
        rule = self.design, self.natural_frequency, self.damping
        if all(getattr(self, name) is None for name in OWN_GAINS):
            return _by_rule(plant, *rule, options)
        if any(part is not None for part in rule):
            raise InputError("give gains or a rule for them (design, natural_frequency), not both")
        if self.attitude_gain is None or self.rate_gain is None:
            raise InputError("gains of your own need attitude_gain and rate_gain, both")
        return Autopilot(
            attitude_gain=self.attitude_gain,
            rate_gain=self.rate_gain,
            alpha_gain=self.alpha_gain or 0.0,
            **options,
        )


def _by_rule(
    plant: Plant,
    design: str | None,
    natural_frequency: float | None,
    damping: float | None,
    options: dict[str, Any],
) -> Autopilot:
    asked = natural_frequency is not None or damping is not None
    rule = one_of("design", design or ("poles" if asked else "canonical"), DESIGNS)
    if rule == LEAST_NOZZLE:
        raise InputError(
            f"design {LEAST_NOZZLE} needs a wind: tvclin autopilot and study files have one; in"
            " Python see least_deflection_gains"
        )
    if rule not in BY_POLES and asked:
        raise InputError(f"design {rule} takes no natural_frequency and no damping")
    if rule == "lqr":
        return lqr_gains(plant, **options)
    if rule == "half-relief":
        return half_relief_gains(plant.coefficients, **options)
    if rule == "canonical":
        if plant.coefficients.mu_alpha <= 0.0:
            raise InputError(
                "design canonical needs an aerodynamically unstable vehicle, and this one has"
                f" mu_alpha = {plant.coefficients.mu_alpha:.6g} 1/s^2: give natural_frequency"
            )
        return canonical_gains(plant.coefficients, **options)
    if natural_frequency is None:
        raise InputError(f"design {rule} needs natural_frequency, in rad/s")
    return BY_POLES[rule](
        plant.coefficients,
        natural_frequency=natural_frequency,
        damping=_DAMPING if damping is None else damping,
        **options,
    )
