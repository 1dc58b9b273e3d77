"""The options that describe an autopilot, and the autopilot that they ask for."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from tvclin.answers.nozzle import Nozzle
    from tvclin.control.autopilot.rules import AutopilotDesign
    from tvclin.vehicle.filters import Filter


NotchHz = Annotated[
    list[str] | None,
    typer.Option(
        metavar="F,ZEROS,POLES",
        help="Notch filter of the deflection command: frequency in Hz, damping of its zeros and of"
        " its poles, as in 12,0.05,0.5. May be given several times. Study files also take lead-lag"
        " and rational filters, under autopilot.filter.",
    ),
]
LowPassHz = Annotated[
    list[str] | None,
    typer.Option(
        metavar="F[,DAMPING]",
        help="Low-pass filter of the deflection command: frequency in Hz; with a damping ratio it"
        " is of second order. May be given several times.",
    ),
]


@dataclass(frozen=True)
class LoopOptions:
    """What stands about any law: filters, actuator and delay; `grouped` gives them to a command."""

    actuator_frequency: Annotated[
        float | None,
        typer.Option(
            help="Natural frequency of the actuator, in rad/s; 0: no actuator.",
            show_default="25.1",
        ),
    ] = None
    actuator_hz: Annotated[float | None, typer.Option(help="The same in Hz.")] = None
    actuator_damping: Annotated[float, typer.Option(help="Damping ratio of the actuator.")] = 0.7
    delay_ms: Annotated[float, typer.Option(help="Delay between sensors and actuator, in ms.")] = (
        0.0
    )
    notch_hz: NotchHz = None
    low_pass_hz: LowPassHz = None

    def design(self, **gains: Any) -> "AutopilotDesign":
        """Return the design of an autopilot with these gains, and filters and delay about it."""
        from tvclin.base.errors import nonnegative, number
        from tvclin.control.autopilot.rules import AutopilotDesign

        delay = number("--delay-ms", self.delay_ms, nonnegative, "ms") / 1000.0
        filters = _filters(self.notch_hz or (), self.low_pass_hz or ())
        return AutopilotDesign(filters=filters, delay=delay, **gains)

    def nozzle(
        self,
        limit_deg: float | None = None,
        rate_limit_deg: float | None = None,
        actuator: float = 25.1,
    ) -> "Nozzle":
        """Return the nozzle, with an actuator of that frequency [rad/s] where none is given."""
        from math import pi, radians

        from tvclin.answers.nozzle import Nozzle, actuator_of
        from tvclin.base.errors import InputError, nonnegative, number, positive
        from tvclin.cli.inputs import limit_of

        if self.actuator_frequency is not None and self.actuator_hz is not None:
            raise InputError("give --actuator-frequency or --actuator-hz, not both")
        if self.actuator_hz is not None:
            actuator = 2.0 * pi * number("--actuator-hz", self.actuator_hz, nonnegative, "Hz")
        if self.actuator_frequency is not None:
            name = "--actuator-frequency"
            actuator = number(name, self.actuator_frequency, nonnegative, "rad/s")
        rate = rate_limit_deg
        if rate is not None:
            rate = radians(number("--rate-limit-deg", rate, positive, "deg/s"))
        return Nozzle(
            limit=limit_of(limit_deg),
            rate_limit=rate,
            actuator=actuator_of(actuator, self.actuator_damping),
        )


@dataclass(frozen=True)
class GainOptions:
    """The gains, or a rule for them; `grouped` gives them to a command."""

    design: Annotated[
        str | None,
        typer.Option(
            help="Rule for the gains: canonical, half-relief, poles, drift-minimum, load-minimum or"
            " lqr; for tvclin autopilot also least-nozzle.",
            show_default="canonical",
        ),
    ] = None
    natural_frequency: Annotated[
        float | None,
        typer.Option(
            help="Natural frequency of the closed loop, in rad/s; the rule is then poles."
        ),
    ] = None
    damping: Annotated[
        float | None,
        typer.Option(help="Damping ratio of the closed loop, for poles.", show_default="0.7"),
    ] = None
    attitude_gain: Annotated[float | None, typer.Option(help="Gain a0, in place of a rule.")] = None
    rate_gain: Annotated[float | None, typer.Option(help="Gain a1, in s, in place of a rule.")] = (
        None
    )
    alpha_gain: Annotated[float | None, typer.Option(help="Gain b0 on the angle of attack.")] = None
    integral_gain: Annotated[
        float, typer.Option(help="Gain aI on the integrated attitude, in 1/s.")
    ] = 0.0

    def asked(self, loop: LoopOptions, sample_rate: float | None = None) -> "AutopilotDesign":
        """Return the design of the autopilot that the options ask for."""
        from tvclin.base.errors import number, positive

        if sample_rate is not None:
            sample_rate = number("--sample-rate", sample_rate, positive, "Hz")
        return loop.design(**vars(self), sample_rate=sample_rate)


def given(options: Any) -> dict[str, Any]:
    """Return which of a group of options are not as they stand without being given."""
    usual = type(options)()
    return {name: v for name, v in vars(options).items() if v != getattr(usual, name)}


def _filters(notches: Sequence[str], passes: Sequence[str]) -> "tuple[Filter, ...]":
    """Return the filters of `NotchHz` and `LowPassHz`."""
    from tvclin.vehicle.filters import Filter

    made = [Filter.notch(*_numbers("--notch-hz", given, 3, 3)) for given in notches]
    made += [Filter.low_pass(*_numbers("--low-pass-hz", given, 1, 2)) for given in passes]
    return tuple(made)


def _numbers(option: str, given: str, least: int, most: int) -> list[float]:
    """Return numbers that commas part, the first of them a frequency, from Hz to rad/s."""
    from math import pi

    from tvclin.base.errors import InputError, number, positive

    parts = given.replace(",", " ").split()
    try:
        found = [float(part) for part in parts]
    except ValueError:
        found = []
    if not least <= len(found) <= most:
        count = f"{least}" if least == most else f"{least} or {most}"
        raise InputError(f"{option} must be {count} numbers with commas between; got {given!r}")
    return [2.0 * pi * number(option, found[0], positive, "Hz"), *found[1:]]
