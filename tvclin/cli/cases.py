"""One plant, one wind and one deflection limit, as the command line names them."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tvclin.cli.pulse import PulseOptions
    from tvclin.linear.plant import Plant
    from tvclin.winds.histories import History

_LARGEST = 700.0
"""Floating-point numbers end a little above e^709."""


@dataclass(frozen=True, eq=False)
class Case:
    """One plant, one wind, and the deflection that meets it.

    Attributes
    ----------
    vehicle : str
        Name of the vehicle.
    shape : str
        Shape of the wind.
    plant : Plant
        The plant.
    wind, deflection : History
        Its inputs [rad].
    dead_band : float
        K.
    required, limit : float
        Deflection that is required, and the limit in question [rad], both without sign.
    governs : str
        What requires it, as of `RequiredDeflection`.
    """

    vehicle: str
    shape: str
    plant: "Plant"
    wind: Any
    deflection: "History"
    dead_band: float
    required: float
    limit: float
    governs: str

    @property
    def sufficient(self) -> bool:
        """Whether the limit is at or above what is required."""
        from tvclin.answers.requirement import covers

        return bool(covers(self.limit, self.required))


def make_case(
    vehicle: Any,
    blows: "PulseOptions",
    dead_band: float,
    capability: float | None,
    limit_deg: float | None,
    model: str | None,
    plane: str,
    length: float,
) -> Case:
    """Return the case that the options ask for, to be followed for a length [s]."""
    import numpy as np

    from tvclin.answers.requirement import required_deflection
    from tvclin.base.errors import InputError, within
    from tvclin.linear.deflections import trim_then_hold
    from tvclin.linear.plant import Plant

    if capability is not None and limit_deg is not None:
        raise InputError("give --capability or --limit-deg, not both")
    history = blows.blowing(vehicle, plane)
    K = float(within("--dead-band", dead_band, 0.0, 1.0))
    plant = Plant.from_vehicle(vehicle, model, plane)
    _check_length(plant, length)
    needed = required_deflection(plant, history, K)
    required = abs(float(needed.deflection))
    if limit_deg is not None:
        limit = float(np.radians(within("--limit-deg", limit_deg, 1e-6, 90.0)))
    else:
        limit = required * float(
            within("--capability", 1.0 if capability is None else capability, 1e-3, 1e3)
        )
        if np.isinf(limit):
            raise InputError(f"no limit is enough with K = {K:g} here; give --limit-deg")
        if limit == 0.0:
            raise InputError("this vehicle needs no deflection in any wind; give --limit-deg")
    opposing = -float(np.sign(plant.coefficients.B * history.peak)) or 1.0
    deflection = trim_then_hold(plant, history, opposing * limit, K, "literal")
    return Case(
        vehicle.name,
        blows.wind,
        plant,
        history,
        deflection,
        K,
        required,
        limit,
        str(needed.governs),
    )


def _check_length(plant: "Plant", length: float) -> None:
    """Raise `InputError` for a length [s] in which what is left over outgrows every number."""
    import numpy as np

    from tvclin.base.errors import InputError
    from tvclin.linear.modes import unstable_modes

    fastest = float(np.real(unstable_modes(plant).poles).max(initial=0.0))
    if fastest * length > _LARGEST:
        raise InputError(
            f"--duration, and --duration times --until, must be at most {_LARGEST / fastest:.4g} s:"
            f" the attitude grows as e^({fastest:.4g} t), and floating-point numbers end near"
            f" e^{_LARGEST:g}; got {length:g} s"
        )
