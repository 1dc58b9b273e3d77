"""One plane in JSBSim's steps: where it will be at the end of a step, and where it was then."""

from tvclin.control.laws.law import Measurement
from tvclin.flights.sixdof.sensors import Senses

Row = tuple[float, ...]


class Foresight:
    """One plane at the end of the next step.

    What acts at the end of a step is set before the step, so the state at its end is foreseen: the
    rate by the engine's own rule, the angles to second order.

    `senses`: readers of the plane, at the beginning of a flight. `step`: step [s]. `turn`: by which
    the flight path has turned in the step before the flight [rad].
    """

    __slots__ = (
        "_alpha", "_attitude", "_blown", "_deflection", "_path", "_path_before", "_push",
        "_push_before", "_rate", "_senses", "_step",
    )  # fmt: skip

    def __init__(self, senses: Senses, step: float, turn: float = 0.0) -> None:
        self._senses, self._step = senses, step
        self._attitude, self._path = senses.angles()
        self._rate, self._push = senses.rates()
        self._path_before, self._push_before = self._path - turn, self._push
        self._alpha = self._blown = self._deflection = 0.0

    def shown(self, angle: float, nominal: Row) -> Measurement:
        """Return what a law is shown: deviations from the outputs of the nominal flight there.

        `angle` is the wind angle [rad] at the end of the step.
        """
        h, rate = self._step, self._rate
        rate_ahead = rate + h * (1.5 * self._push - 0.5 * self._push_before)
        turn = 0.5 * h * (rate + rate_ahead)
        path_turn = self._path - self._path_before
        return Measurement(
            self._attitude + turn - nominal[0],
            rate_ahead - nominal[1],
            self._path + path_turn - nominal[2],
            self._alpha + turn - path_turn - (angle - self._blown) - nominal[3],
            self._deflection,
        )

    def moved(self, deflection: float, angle: float, nominal: Row) -> Row:
        """Read the plane after a step, and return its outputs as deviations from the nominal."""
        self._push_before, self._path_before = self._push, self._path
        self._deflection, self._blown = deflection, angle
        self._attitude, self._path = attitude, path = self._senses.angles()
        (self._rate, self._push), self._alpha = self._senses.rates(), self._senses.alpha()
        off = attitude - nominal[0], self._rate - nominal[1], path - nominal[2]
        return (*off, self._alpha - nominal[3], deflection)
