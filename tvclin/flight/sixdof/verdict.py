"""Whether a flight of the report's control survives in JSBSim."""

from collections.abc import Callable

from tvclin.errors import InputError
from tvclin.flight.falls import has_survived, watched_until
from tvclin.flight.sixdof.case import SixDof
from tvclin.flight.sixdof.earth import Earth
from tvclin.flight.sixdof.steering import TrimThenHold
from tvclin.histories import History
from tvclin.vehicle import Vehicle


def sixdof_verdict(
    vehicle: Vehicle,
    wind: History,
    dead_band: float,
    *,
    plane: str = "pitch",
    frozen: bool = True,
    drift: bool = True,
    step: float = 0.01,
    earth: Earth | None = None,
) -> Callable[[float], bool]:
    """Return what says of a deflection limit [rad] whether its flight survives.

    Parameters
    ----------
    vehicle, wind, plane, drift, step, earth
        As of `fly_sixdof`; the wind ends.
    dead_band : float
        K.
    frozen : bool
        Only frozen parameters are flown.

    Raises
    ------
    InputError
        As `fly_sixdof`, for parameters that are not frozen, and for an aerodynamically stable
        vehicle.
    """
    if not frozen:
        raise InputError('engine "sixdof" flies frozen parameters only')
    case = SixDof(vehicle, plane, drift, step, earth)
    beta, B = float(case.coefficients.beta), float(case.coefficients.B)
    air = case.air(wind, min(0.0, float(wind.onset)), watched_until(wind, beta))

    def survives(limit: float) -> bool:
        steering = TrimThenHold(B, limit, dead_band, wind, air.times, step)
        return has_survived(float(case.flown(steering, air)[-1, 1]), wind, beta)

    return survives
