"""Whether flights survive a wind: flown through it, then in still air until each is decided.

A flight is lost for good when its state leaves the recoverable set of the unstable modes, and
saved when it has settled well inside. In the wind it is lost when even the whole limit and the
strongest wind together could not turn it any more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tvclin.closed_loop.airframe import Nozzle, Steps
from tvclin.closed_loop.fates import CALM, PATIENCE
from tvclin.closed_loop.law_rows import law_rows
from tvclin.closed_loop.many import fly_many
from tvclin.closed_loop.sampled import Flights, Sampler, at_rest
from tvclin.errors import InputError
from tvclin.histories import History
from tvclin.kernels.flight_table import SETTLED
from tvclin.kernels.sampled_flights import pays
from tvclin.laws import Law
from tvclin.plant import Plant
from tvclin.recoverable import UnstableCoordinates

FloatArray = NDArray[np.float64]

LOST, UNDECIDED, SAVED = -1, 0, 1
_MOST = 1_000_000
"""A flight that is neither lost nor saved after so many steps in still air stays undecided."""
_EVERY = 8
"""Steps between two looks."""
_SMALL = 1e-7
"""A state so small, over the reach, is far below every limit and dead band."""


@dataclass(frozen=True, eq=False)
class Trial:
    """A law and a nozzle on a plant in one wind, to be flown with many limits.

    Attributes
    ----------
    plant, law, wind : Plant, Law, History
        What flies.
    nozzle, steps : Nozzle, Steps
        How it is stepped.
    modes : UnstableCoordinates
        Of the plant.
    effectiveness : float
        |B|, so that limit/|B| is the reach of the modes.
    gust : float
        Largest wind angle [rad].
    """

    plant: Plant
    law: Law
    wind: History
    nozzle: Nozzle
    steps: Steps
    modes: UnstableCoordinates
    effectiveness: float
    gust: float

    def verdicts(self, limit: FloatArray) -> NDArray[np.int_]:
        """Return SAVED, LOST or UNDECIDED for each limit [rad], ``(n,)``."""
        plain = self._is_plain and pays(len(self.steps.gusts) + self._calm)
        return self._together(limit) if plain else self._step_by_step(limit)

    @cached_property
    def _is_plain(self) -> bool:
        """Whether kernels can fly the law: it is one of this package's, and hears no noise."""
        if self.law.rate_noise[0]:
            return False
        try:
            law_rows(self.law, ())
        except InputError:
            return False
        return True

    def _together(self, limit: FloatArray) -> NDArray[np.int_]:
        flown = fly_many(
            self.plant,
            self.law,
            self.wind,
            deflection_limit=limit,
            rate_limit=self.nozzle.rate_limit,
            actuator=self.nozzle.actuator,
            sample_rate=1.0 / self.nozzle.length,
        )
        return np.select([flown.status == "survived", flown.status == "lost"], [SAVED, LOST])

    def _step_by_step(self, limit: FloatArray) -> NDArray[np.int_]:
        found = np.full(limit.size, LOST)
        where, flights = self._through(limit)
        after = Sampler(self.law, self._still, self.nozzle, still=True)
        quiet, done = np.zeros(where.size, dtype=int), 0
        while where.size and done < self._patience:
            flights = after.flown(flights, done, done + _EVERY)
            done += _EVERY
            z, D = self._where(flights)
            inside = self.modes.inside(z, D)
            settled = np.all(np.abs(z) < SETTLED * D[:, np.newaxis], axis=-1)
            quiet = np.where(settled, quiet + _EVERY, 0)
            saved = inside & (quiet >= self._calm)
            found[where[saved]] = SAVED
            still_open = inside & ~saved
            where, quiet = where[still_open], quiet[still_open]
            flights = flights.take(still_open)
        found[where] = UNDECIDED
        return found

    def growth(self, limit: float) -> float:
        """Return the growth rate [1/s] of the loop in still air, far below the limit [rad].

        The step of the sampled loop, law and nozzle included, is a matrix there; its spectral
        radius says how fast the worst mode grows (positive) or decays.
        """
        order, servo = self.steps.first.size, self.nozzle.order
        size = order + servo + len(self.law.states[0])
        small = _SMALL * limit / self.effectiveness
        states = small * np.eye(size, size + 1)  # the last flight is at rest: what noise does
        flights = Flights(
            states[:order],
            states[order : order + servo],
            states[order + servo :],
            np.zeros(size + 1),
            np.full(size + 1, limit),
        )
        flown = Sampler(self.law, self._still, self.nozzle, still=True).flown(flights, 0, 1)
        moved = np.concatenate([flown.airframe, flown.servo, flown.memory])
        step = (moved[:, :-1] - moved[:, -1:]) / small
        radius = np.abs(np.linalg.eigvals(step)).max()
        return float(np.log(max(radius, np.finfo(float).tiny)) / self.nozzle.length)

    def _through(self, limit: FloatArray) -> tuple[NDArray[np.intp], Flights]:
        """The flights that may still be saved at the end of the wind, and which they are."""
        where = np.arange(limit.size)
        sampler, count = Sampler(self.law, self.steps, self.nozzle), len(self.steps.gusts)
        flights = at_rest(self.law, self.steps, self.nozzle, limit)
        for first in range(0, count, _EVERY):
            if not where.size:
                break
            flights = sampler.flown(flights, first, min(first + _EVERY, count))
            z, D = self._where(flights)
            most = D[:, np.newaxis] + np.abs(self.modes.wind) * self.gust
            alive = np.all(np.abs(z) <= most, axis=-1)
            if not np.all(alive):
                where, flights = where[alive], flights.take(alive)
        return where, flights

    def _where(self, flights: Flights) -> tuple[FloatArray, FloatArray]:
        """The coordinates ``(flights, N)`` and the reach ``(flights,)`` [rad]."""
        return (self.modes.rows @ flights.airframe).T, flights.limit / self.effectiveness

    @property
    def _patience(self) -> int:
        return int(min(np.ceil(PATIENCE / self.modes.poles[-1] / self.nozzle.length), _MOST))

    @cached_property
    def _calm(self) -> int:
        """Steps for which a flight must be calm to be saved, and about what a survivor takes."""
        return int(np.ceil(CALM / self.modes.poles[0] / self.nozzle.length))

    @cached_property
    def _still(self) -> Steps:
        """The same plant in still air, for as long as patience lasts."""
        s, count = self.steps, self._patience + _EVERY
        times = s.times[-1] + self.nozzle.length * np.arange(count + 1.0)
        gusts = np.broadcast_to(np.zeros(s.first.size), (count, s.first.size))
        still = np.broadcast_to(np.zeros(1), (count + 1,))
        return Steps(times, s.free, s.first, s.last, gusts, still)
