"""One door to all rules for gains: a rule by its name, or gains of one's own."""

from collections.abc import Callable
from typing import Any

from tvclin.base.errors import (
    InputError,
    instance,
    nonnegative,
    number,
    one_of,
    single,
)
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.gains import (
    canonical_gains,
    design_gains,
    drift_minimum_gains,
    load_minimum_gains,
)
from tvclin.control.autopilot.optimal import lqr_gains
from tvclin.linear.plant import Plant

DESIGNS = ("canonical", "poles", "drift-minimum", "load-minimum", "lqr")
_BY_POLES: dict[str, Callable[..., Autopilot]] = {
    "poles": design_gains,
    "drift-minimum": drift_minimum_gains,
    "load-minimum": load_minimum_gains,
}
_DAMPING = 0.7


def designed_autopilot(
    plant: Plant,
    *,
    design: str | None = None,
    natural_frequency: float | None = None,
    damping: float | None = None,
    attitude_gain: float | None = None,
    rate_gain: float | None = None,
    alpha_gain: float | None = None,
    actuator_frequency: float = 25.1,
    actuator_damping: float = 0.7,
    **options: Any,
) -> Autopilot:
    """Return the autopilot with gains by a rule, or with those that are given.

    Parameters
    ----------
    plant : Plant
        The plant that the rule is for.
    design : str, optional
        One of `DESIGNS`; "poles" where a frequency or a damping is given, else "canonical".
    natural_frequency, damping : float, optional
        Of the closed loop [rad/s], for the rules that ask for poles; the damping is 0.7 unless
        given.
    attitude_gain, rate_gain, alpha_gain : float, optional
        As of `Autopilot`, in place of a rule.
    actuator_frequency, actuator_damping : float
        Natural frequency [rad/s] and damping ratio of the actuator; no actuator at zero.
    **options
        The other arguments of `Autopilot`: delay, integral_gain.

    Raises
    ------
    InputError
        For a rule and gains together, one gain alone, an unknown rule, a rule with too few numbers
        or too many, and as the rule itself.
    """
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    single("plant", plant.batch)
    options["actuator"] = _actuator(actuator_frequency, actuator_damping)
    rule = design, natural_frequency, damping
    if all(gain is None for gain in (attitude_gain, rate_gain, alpha_gain)):
        return _by_rule(plant, *rule, options)
    if any(part is not None for part in rule):
        raise InputError("give gains or a rule for them (design, natural_frequency), not both")
    if attitude_gain is None or rate_gain is None:
        raise InputError("gains of your own need attitude_gain and rate_gain, both")
    return Autopilot(
        attitude_gain=attitude_gain, rate_gain=rate_gain, alpha_gain=alpha_gain or 0.0, **options
    )


def _actuator(frequency: float, damping: float) -> Actuator | None:
    if number("actuator_frequency", frequency, nonnegative, "rad/s") == 0.0:
        return None
    return Actuator(natural_frequency=frequency, damping=damping)


def _by_rule(
    plant: Plant,
    design: str | None,
    natural_frequency: float | None,
    damping: float | None,
    options: dict[str, Any],
) -> Autopilot:
    asked = natural_frequency is not None or damping is not None
    rule = one_of("design", design or ("poles" if asked else "canonical"), DESIGNS)
    if rule not in _BY_POLES and asked:
        raise InputError(f"design {rule} takes no natural_frequency and no damping")
    if rule == "lqr":
        return lqr_gains(plant, **options)
    if rule == "canonical":
        if plant.coefficients.mu_alpha <= 0.0:
            raise InputError(
                "design canonical needs an aerodynamically unstable vehicle, and this one has"
                f" mu_alpha = {plant.coefficients.mu_alpha:.6g} 1/s^2: give natural_frequency"
            )
        return canonical_gains(plant.coefficients, **options)
    if natural_frequency is None:
        raise InputError(f"design {rule} needs natural_frequency, in rad/s")
    return _BY_POLES[rule](
        plant.coefficients,
        natural_frequency=natural_frequency,
        damping=_DAMPING if damping is None else damping,
        **options,
    )
