"""Winds whose angle depends on the vehicle that encounters them, and on the plane."""

from abc import ABC, abstractmethod
from typing import Any

from tvclin.winds.histories import History


class VehicleWind(ABC):
    """A wind of a case, whose angle follows from the vehicle, as that of a measured wind speed."""

    @property
    @abstractmethod
    def shape(self) -> str:
        """Name of the wind."""

    @abstractmethod
    def history(self, vehicle: Any, plane: str) -> History:
        """Return the wind angle of attack [rad] of a vehicle in a plane."""
