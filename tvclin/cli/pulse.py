"""The options of a pulse of wind, and the wind that they ask for."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tvclin.cli.inputs import peak_angle
from tvclin.cli.options import Duration, PeakDeg, PeakSpeed, Wind

if TYPE_CHECKING:
    from tvclin.vehicle.linear_vehicle import AnyVehicle


@dataclass(frozen=True)
class PulseOptions:
    """The options in one place; `grouped` gives them to a command."""

    wind: Wind = "triangular"
    duration: Duration = 7.5
    peak_deg: PeakDeg = None
    peak_speed: PeakSpeed = None

    def peak(self, vehicle: "AnyVehicle", plane: str) -> float:
        """Return the peak wind angle of attack [rad]."""
        return peak_angle(vehicle, plane, self.peak_deg, self.peak_speed)

    def blowing(self, vehicle: "AnyVehicle", plane: str) -> Any:
        """Return the wind; an unknown shape is refused, and so are numbers out of range."""
        from tvclin.winds.shaped import pulse

        return pulse("--wind", self.wind, self.peak(vehicle, plane), self.duration)
