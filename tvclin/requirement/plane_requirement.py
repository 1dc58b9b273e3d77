"""Required deflection of both planes with one limit shape: by planes, and of their vector.

A rectangle inside the stop gives each plane a part of its own, in which it may be flown as if the
other were not there: what each requires alone is then sufficient. The report's control in the
plane, whose dead band is left by the vector, may need more in a wind that turns; the larger counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.errors import InputError, plain
from tvclin.base.fields import derived, spec
from tvclin.boundary.limit_shapes import CircularShape, LimitShape
from tvclin.boundary.open_loop import ROUNDING, Reason
from tvclin.linear.plant import Plant
from tvclin.requirement.nominal_requirement import FrozenRequirement, required_deflection
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.shaped import ShapedWind, component_in

_MAX_FINITE_RAD = 1e99
"""Deflections [rad] below this are finite; others are infinite or NaN."""


def vector_requirements(
    pitch: Plant, yaw: Plant, wind: PlaneWind, limit_shape: LimitShape, dead_bands: FloatArray
) -> FrozenRequirement:
    """Return the requirements of a wind vector that ends; zeros and a note where none is defined.

    They are in the measure of the limit shape, the limit at whose edge a vector of deflections
    lies, its gauge: trim is the largest gauge of -B times the wind, B being the ratio of trim
    deflection to angle of attack, and the requirement at a dead band the limit of `plane_limit`.
    `pitch`, `yaw`: plant of each plane. `limit_shape`: limit in both planes. `dead_bands`: K,
    ``(k,)``.
    """
    from tvclin.boundary.plane_bounds import PlanePair, checked_batch
    from tvclin.boundary.plane_limits import two_plane_requirement

    pair = PlanePair((pitch, yaw), wind)
    try:
        checked_batch(pitch, wind, limit_shape, yaw)
        limits = two_plane_requirement(pair, limit_shape, dead_bands.tolist(), literal=True)
    except InputError as error:
        return replace(FrozenRequirement.of_calm(dead_bands), messages=(str(error),))
    if isinstance(limit_shape, CircularShape):
        trim = abs(float(pitch.coefficients.B)) * float(wind.peak)
    else:  # the gauge of static trim, -B times the wind angles of both planes, at all times
        trim = float(limit_shape.gauge(pair.moment_driver(pair.times())).max())
    return FrozenRequirement(
        trim=trim,
        required=np.array([limit.limit for limit in limits]),
        no_forecast=limits[0].bound,  # this and the minimum are the same for all K
        minimum=limits[0].minimum,
        messages=tuple(dict.fromkeys(note for limit in limits for note in limit.notes)),
    )


def rectangle(limit_shape: LimitShape, pitch: ArrayLike, yaw: ArrayLike) -> FloatArray:
    """Return the minimum limit whose shape contains -x to x in pitch and -y to y in yaw [rad].

    `pitch`, `yaw`: the deflections x and y [rad]. Infinite and NaN where one of them is. The gauge
    of the shape, the limit at whose edge a vector lies, is largest at a corner of the rectangle.
    """
    x, y = np.broadcast_arrays(np.asarray(pitch, dtype=float), np.asarray(yaw, dtype=float))
    finite = (np.abs(x) < _MAX_FINITE_RAD) & (np.abs(y) < _MAX_FINITE_RAD)
    a, b = np.where(finite, x, 0.0), np.where(finite, y, 0.0)
    corners = np.stack([a + 1j * b, a - 1j * b, -a + 1j * b, -a - 1j * b])
    return np.where(finite, limit_shape.gauge(corners).max(axis=0), x + y)  # inf or NaN as x and y


@dataclass(frozen=True, eq=False)
class TwoPlaneRequirement:
    """Requirement of both planes at one dead band, in a wind with a direction or a batch of them.

    `deflection` is the required deflection [rad], in the measure of the stop, `separate` that
    of each plane by itself.
    """

    limit_shape: LimitShape
    wind: PlaneWind
    deflection: Any = field(metadata=spec("angle", name="required_deflection"))
    separate: dict[str, Any] = field(metadata=spec("angle"))

    @property
    def vector_governs(self) -> BoolArray:
        """Whether the vector of both planes requires more than the planes by themselves."""
        by_planes = rectangle(self.limit_shape, **self.separate)
        return np.asarray(self.deflection > by_planes * (1.0 + ROUNDING))

    @property
    def governs(self) -> Reason:
        """Reason of the larger requirement, one plane or the vector of both; for one wind."""
        return Reason.BOTH_PLANES if self.vector_governs else Reason.ONE_PLANE

    def encountered(self, separate: Mapping[str, ArrayLike], size: float = 1.0) -> FloatArray:
        """Return the requirement of both planes [rad] at the dynamic pressure encountered.

        It is the limit that contains what each plane requires alone. Where the vector of both
        requires more, that is taken to rise from nominal to encountered pressure as the
        requirement of the plane that rises most. `separate`: required deflection [rad] by plane at
        the pressure encountered, of planes with wind. `size`: factor on the wind.
        """
        combined = rectangle(self.limit_shape, **(dict.fromkeys(PLANES, 0.0) | dict(separate)))
        with np.errstate(divide="ignore", invalid="ignore"):  # zero where nominal is zero too
            nominal = {plane: size * np.abs(self.separate[plane]) for plane in separate}
            ratios = [np.nan_to_num(np.divide(x, nominal[k])) for k, x in separate.items()]
        of_vector = size * self.deflection * np.max(ratios, axis=0)
        return np.where(self.vector_governs, np.maximum(combined, of_vector), combined)

    @property
    @derived("angle")
    def peak(self) -> float:
        """Largest size [rad] over time of the vector of wind angles in pitch and yaw."""
        return float(self.wind.peak)

    def ratio_to(self, plane: str) -> float:
        """Return the ratio of the limit of both planes to the limit of one `plane`, pitch or yaw.

        For a wind with a heading: the other plane is taken for the same loop in the same wind, so
        that the limits of both planes have the ratio of the peaks of the wind.
        """
        peaks = {name: abs(float(getattr(self.wind, name).peak)) for name in PLANES}
        # the limit whose shape contains the rectangle of both planes' limits
        return float(rectangle(self.limit_shape, peaks["pitch"], peaks["yaw"])) / peaks[plane]

    def omitted_fraction(self, plane: str) -> float:
        """Return the fraction of the requirement of both planes that `plane` alone omits.

        With 0.4 a limit for this plane alone is 40 percent too small.
        """
        return float(omitted_fraction(self.separate[plane], self.deflection))


def two_plane_requirement(
    plants: dict[str, Plant], wind: PlaneWind, limit_shape: LimitShape, dead_band: float
) -> TwoPlaneRequirement:
    """Return the requirement of both planes; `InputError` as `required_deflection`.

    `plants`: plant of each plane. `limit_shape`: limit in both planes. `dead_band`: K, from 0 to 1.
    Plants and winds broadcast; the vectors of a batch are solved case by case.
    """
    from tvclin.boundary.plane_bounds import PlanePair, checked_batch
    from tvclin.boundary.plane_limits import vector_requirement

    winds = {plane: getattr(wind, plane) for plane in PLANES}
    # whether no wind of the batch is a calm, whose onset is infinite
    has_wind = {plane: bool(np.all(np.isfinite(winds[plane].onset))) for plane in PLANES}
    separate = {  # required deflections [rad] of each plane by itself
        plane: np.abs(required_deflection(plants[plane], winds[plane], dead_band).deflection)
        if has_wind[plane]
        else np.zeros(())
        for plane in PLANES
    }
    by_planes = rectangle(limit_shape, separate["pitch"], separate["yaw"])
    shape, required = by_planes.shape, by_planes.ravel().tolist()
    if all(has_wind.values()):
        for case, sufficient in enumerate(required):
            pitch, yaw = (plants[plane].case(case, shape) for plane in PLANES)
            pair = PlanePair((pitch, yaw), wind.case(case, shape))
            # without a solution in both planes the rectangle of both requirements is sufficient
            with suppress(InputError):
                checked_batch(pitch, pair.wind, limit_shape, yaw)
                required[case] = vector_requirement(pair, limit_shape, dead_band, sufficient)
    return TwoPlaneRequirement(
        limit_shape=limit_shape,
        wind=wind,
        deflection=plain(np.reshape(required, shape)),
        separate={k: plain(np.asarray(v)) for k, v in separate.items()},
    )


def heading_requirement(
    vehicle: Vehicle,
    model: str,
    wind: ShapedWind,
    limit_shape: LimitShape | None,
    dead_band: float,
) -> TwoPlaneRequirement:
    """Return the requirement of both planes in a wind with a heading.

    `model`: linear model of the vehicle. `limit_shape`: limit in both planes, by default a circle.
    `dead_band`: K, from 0 to 1.
    """
    attitude = float(np.asarray(vehicle.attitude))  # nominal, above the horizontal [rad]
    peaks = wind.peaks(attitude)  # wind angle in each plane [rad]
    plants = {plane: Plant.from_vehicle(vehicle, model, plane) for plane in PLANES}
    plane_wind = PlaneWind(**{plane: component_in(wind, peaks, plane) for plane in PLANES})
    return two_plane_requirement(plants, plane_wind, limit_shape or CircularShape(), dead_band)


def direction_notes(
    planes: TwoPlaneRequirement | None, plane: str, both_judged: bool, at_nominal_pressure: bool
) -> Iterator[str]:
    """Yield notes on the effect of the direction of a wind; none without a direction.

    `planes`: requirement of both planes at nominal dynamic pressure; None without a direction.
    `both_judged`: whether the verdict is on both planes, or on `plane` alone.
    `at_nominal_pressure`: whether the verdict is at nominal dynamic pressure too.
    """
    if planes is None:
        return
    missing = 100.0 * planes.omitted_fraction(plane)
    if not both_judged:
        air = "" if at_nominal_pressure else " at nominal dynamic pressure"
        yield (
            f"this wind blows in both planes: with a round stop they need"
            f" {np.degrees(planes.deflection):.3f} deg{air}, {missing:.0f} % of which"
            f" the {plane} plane"
            " alone does not see (to judge both: limit_shape in [nozzle])"
        )
        return
    yield (
        f"the verdict is on both planes with one stop; boundaries, minima and laws are of the"
        f" {plane} plane alone, which does not see {missing:.0f} % of what both need"
    )


def omitted_fraction(separate: ArrayLike, both_planes: ArrayLike) -> FloatArray:
    """Return the fraction of the requirement of both planes that one plane alone omits.

    `separate`: requirement of the plane by itself [rad]. `both_planes`: in both [rad], in any
    shapes that broadcast. Zero where that is zero, NaN where it is NaN.
    """
    plane, planes = np.asarray(separate, dtype=float), np.asarray(both_planes, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(planes > 0.0, 1.0 - plane / planes, 0.0 * planes)  # 0 times NaN is NaN
