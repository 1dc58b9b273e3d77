"""What both planes ask of one stop: each by itself in its part of it, and the vector of both.

A rectangle inside the stop gives each plane a part of its own, in which it may be flown as if the
other were not there: what each requires alone is then sufficient. The report's control in the
plane, whose dead band is left by the vector, may need more in a wind that turns; the larger counts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.answers.requirement import required_deflection
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, plain
from tvclin.boundary.open_loop import ROUNDING, Reason
from tvclin.boundary.stops import CircularStop, Stop
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.shaped import ShapedWind, component_in

_LARGEST = 1e99


@dataclass(frozen=True, eq=False)
class VectorNeed:
    """What the vector of a wind asks for [rad], in the measure of the stop.

    `trim` is the largest gauge of -B times the wind, `required` the limit of `plane_limit` at each
    dead band, ``(k,)``, `no_forecast` what no law without a forecast undercuts, and `minimum` what
    nothing does; `said` is why something is not defined, or is more than (4b) says.
    """

    trim: float
    required: FloatArray
    no_forecast: float
    minimum: float
    said: tuple[str, ...]


def vector_need(
    pitch: Plant, yaw: Plant, wind: PlaneWind, stop: Stop, dead_bands: FloatArray
) -> VectorNeed:
    """Return what a wind that ends asks of two planes; zeros where (4b) has no vector for them."""
    from tvclin.boundary.planes.needed import needed
    from tvclin.boundary.planes.pair import Pair, checked

    pair = Pair((pitch, yaw), wind)
    try:
        checked(pitch, wind, stop, yaw)
        found = needed(pair, stop, dead_bands.tolist(), literal=True)
    except InputError as error:
        return VectorNeed(0.0, np.zeros(dead_bands.shape), 0.0, 0.0, (str(error),))
    if isinstance(stop, CircularStop):
        trim = abs(float(pitch.coefficients.B)) * float(wind.peak)
    else:
        trim = float(stop.gauge(pair.moment_driver(pair.times())).max())
    return VectorNeed(
        trim=trim,
        required=np.array([one.limit for one in found]),
        no_forecast=found[0].bound,
        minimum=found[0].minimum,
        said=tuple(dict.fromkeys(note for one in found for note in one.notes)),
    )


def rectangle(stop: Stop, pitch: ArrayLike, yaw: ArrayLike) -> FloatArray:
    """Return the least limit whose shape holds -x to x in pitch and -y to y in yaw [rad].

    Infinite and NaN where one of them is.
    """
    x, y = np.broadcast_arrays(np.asarray(pitch, dtype=float), np.asarray(yaw, dtype=float))
    known = (np.abs(x) < _LARGEST) & (np.abs(y) < _LARGEST)
    a, b = np.where(known, x, 0.0), np.where(known, y, 0.0)
    corners = np.stack([a + 1j * b, a - 1j * b, -a + 1j * b, -a - 1j * b])
    return np.where(known, stop.gauge(corners).max(axis=0), x + y)


@dataclass(frozen=True, eq=False)
class PlanesNeeded:
    """What one wind with a direction, or each of a batch, asks of both planes at one dead band.

    `deflection` is what is required [rad], in the measure of the stop, `alone` what each plane by
    itself requires.
    """

    stop: Stop
    wind: PlaneWind
    deflection: Any
    alone: dict[str, Any]

    @property
    def governs(self) -> Reason:
        """Which of the two is larger; of one wind."""
        held = rectangle(self.stop, self.alone["pitch"], self.alone["yaw"])
        vector = self.deflection > held * (1.0 + ROUNDING)
        return Reason.BOTH_PLANES if vector else Reason.ONE_PLANE

    @property
    def peak(self) -> float:
        """Size [rad] of the largest wind vector."""
        return float(self.wind.peak)

    def over(self, plane: str) -> float:
        """Return how much of the stop a wind of one direction takes, over what one plane takes.

        The other plane is the same loop in the same wind, and its deflections have that ratio.
        """
        parts = {name: abs(float(getattr(self.wind, name).peak)) for name in PLANES}
        return float(rectangle(self.stop, parts["pitch"], parts["yaw"])) / parts[plane]

    def misses(self, plane: str) -> float:
        """Return by which part of what both need one plane alone asks for too little."""
        return float(missing_part(self.alone[plane], self.deflection))


def planes_needed(
    plants: dict[str, Plant], wind: PlaneWind, stop: Stop, dead_band: float
) -> PlanesNeeded:
    """Return what winds ask of both planes; `InputError` as `required_deflection`.

    Plants and winds broadcast; the vectors of a batch are solved case by case.
    """
    alone = alone_needed(plants, wind, dead_band)
    needs = rectangle(stop, alone["pitch"], alone["yaw"])
    if all(_blows(getattr(wind, plane)) for plane in PLANES):
        least = needs.ravel().tolist()
        vector = [
            _vector(plants, wind, stop, dead_band, one, case, needs.shape)
            for case, one in enumerate(least)
        ]
        needs = np.reshape(vector, needs.shape)
    return PlanesNeeded(
        stop, wind, plain(needs), {k: plain(np.asarray(v)) for k, v in alone.items()}
    )


def alone_needed(
    plants: dict[str, Plant], wind: PlaneWind, dead_band: float
) -> dict[str, FloatArray]:
    """Return what winds ask of each plane by itself [rad]; nothing where they do not blow."""
    winds = {plane: getattr(wind, plane) for plane in PLANES}
    return {
        plane: np.abs(required_deflection(plants[plane], one, dead_band).deflection)
        if _blows(one)
        else np.zeros(())
        for plane, one in winds.items()
    }


def _blows(wind: History) -> bool:
    return bool(np.all(np.isfinite(wind.onset)))


def _vector(
    plants: dict[str, Plant],
    wind: PlaneWind,
    stop: Stop,
    dead_band: float,
    least: float,
    case: int,
    shape: tuple[int, ...],
) -> float:
    """What the vector of one wind of a batch asks for [rad]; `least` where that is no less."""
    from tvclin.boundary.planes.needed import in_vectors
    from tvclin.boundary.planes.pair import Pair, checked

    pitch, yaw = (plants[plane].case(case, shape) for plane in PLANES)
    pair = Pair((pitch, yaw), wind.case(case, shape))
    try:
        checked(pitch, pair.wind, stop, yaw)
        return in_vectors(pair, stop, dead_band, least)
    except InputError:  # (4b) has no vector for them
        return least


def of_heading(
    vehicle: Vehicle,
    model: str,
    wind: ShapedWind,
    stop: Stop | None,
    dead_band: float,
) -> PlanesNeeded:
    """Return what a wind with a heading asks of both planes; the stop is round without one."""
    peaks = wind.peaks(float(np.asarray(vehicle.attitude)))
    plants = {plane: Plant.from_vehicle(vehicle, model, plane) for plane in PLANES}
    both = PlaneWind(**{plane: component_in(wind, peaks, plane) for plane in PLANES})
    return planes_needed(plants, both, stop or CircularStop(), dead_band)


def words_of(planes: PlanesNeeded | None, plane: str, judged: bool, calm: bool) -> Iterator[str]:
    """Yield what the direction of a wind changes, in words; nothing without one.

    `calm`: whether the nominal dynamic pressure counts, at which `planes` are.
    """
    if planes is None:
        return
    missing = 100.0 * planes.misses(plane)
    if not judged:
        air = "" if calm else " at nominal dynamic pressure"
        yield (
            f"this wind blows in both planes: with a round stop they need"
            f" {np.degrees(planes.deflection):.3f} deg{air}, {missing:.0f} % of which"
            f" the {plane} plane"
            " alone does not see (to judge both: --stop, or stop in [nozzle])"
        )
        return
    yield (
        f"the verdict is on both planes with one stop; boundaries, minima and laws are of the"
        f" {plane} plane alone, which does not see {missing:.0f} % of what both need"
    )


def missing_part(alone: ArrayLike, both: ArrayLike) -> FloatArray:
    """Return by which part of what both planes need one alone falls short; zero of nothing."""
    one, all_ = np.asarray(alone, dtype=float), np.asarray(both, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(all_ > 0.0, 1.0 - one / all_, 0.0 * all_)
