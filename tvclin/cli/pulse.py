"""The options of a pulse of wind, and the wind that they ask for."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tvclin.cli.inputs import peak_angle
from tvclin.cli.options import Duration, PeakDeg, PeakSpeed, Wind

if TYPE_CHECKING:
    from tvclin.answers.case import Case
    from tvclin.answers.nozzle import Nozzle
    from tvclin.control.autopilot.rules import AutopilotDesign
    from tvclin.vehicle.linear_vehicle import AnyVehicle
    from tvclin.winds.shaped import ShapedWind


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

    def blowing(self, vehicle: "AnyVehicle", plane: str) -> "ShapedWind":
        """Return the wind; an unknown shape is refused, and so are numbers out of range."""
        from tvclin.base.errors import one_of, positive
        from tvclin.winds.shaped import PULSES, ShapedWind

        shape = one_of("--wind", self.wind, PULSES)
        duration = float(positive("--duration", self.duration, "s"))
        return ShapedWind(shape, self.peak(vehicle, plane), duration)

    def case(
        self,
        vehicle: "AnyVehicle",
        model: str | None,
        plane: str,
        nozzle: "Nozzle | None" = None,
        design: "AutopilotDesign | None" = None,
    ) -> "Case":
        """Return the case of a vehicle in the wind, with a nozzle and an autopilot if given."""
        from tvclin.answers.case import Case
        from tvclin.answers.nozzle import Nozzle

        return Case(
            vehicle=vehicle,
            model=model or "",
            plane=plane,
            wind=self.blowing(vehicle, plane),
            nozzle=nozzle or Nozzle(),
            design=design,
        )
