"""Both planes at once in JSBSim, as a judge of the boundary of two planes with one stop."""

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.flights.sixdof.fly_sixdof import planes_verdict

pytest.importorskip("jsbsim")

VEHICLE = tv.load_vehicle("configuration-i")
FIXED = tv.Plant.from_vehicle(VEHICLE, "fixed-path")
GUST = tv.TriangularWind(peak=np.radians(1), duration=4.0 / FIXED.coefficients.beta)
TRIM = FIXED.coefficients.B * GUST.peak
EXACT = {plane: tv.Plant.from_vehicle(VEHICLE, "drift-exact", plane) for plane in ("pitch", "yaw")}


@pytest.mark.thorough
@pytest.mark.parametrize("drift", usual([False, True], 1))
@pytest.mark.parametrize("stop", usual(["round", "square"], 0))
def test_a_slanting_wind_has_the_linear_boundary_within_a_percent(drift, stop) -> None:
    wind = tv.winds.PlaneWind.towards(GUST, np.radians(35))
    plants = (EXACT["pitch"], EXACT["yaw"]) if drift else (FIXED, FIXED)
    shape = tv.boundary.CircularShape() if stop == "round" else tv.boundary.SquareShape()
    # a square stop lets go of one plane first: what it takes is a law of each plane by itself
    linear = tv.plane_limit(plants[0], wind, shape, switch="literal", yaw_plant=plants[1])
    saturate = "radial" if stop == "round" else "each plane"
    survives = planes_verdict(
        VEHICLE,
        wind,
        tv.TrimLaw(FIXED),
        drift=drift,
        limit_shape=stop,
        saturate=saturate,
        step=0.02,
    )
    assert not survives(0.99 * linear.limit * TRIM)
    assert survives(1.01 * linear.limit * TRIM)


@pytest.mark.thorough
def test_a_turning_wind_asks_for_what_the_linear_flight_says() -> None:
    """More than the boundary of both planes; within a percent of the flight of the linear model."""
    wind = tv.winds.PlaneWind.veering(GUST, angle=0.3, rate=np.radians(180) / GUST.duration)
    law, edge = tv.TrimLaw(FIXED), 0.6757
    limits = TRIM * edge * np.array([0.99, 1.01])
    flown = tv.flights.fly_planes(FIXED, law, wind, deflection_limit=limits, sample_rate=50.0)
    assert flown.status.tolist() == ["lost", "survived"]
    survives = planes_verdict(VEHICLE, wind, law, drift=False, step=0.02)
    assert [survives(limit) for limit in limits] == [False, True]
    assert tv.plane_limit(FIXED, wind).limit < 0.95 * edge


LATERAL = tv.Autopilot(attitude_gain=0.6, rate_gain=0.8, drift_rate_gain=8e-4)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "law", [tv.TrimLaw(FIXED), tv.SaturatedLaw(LATERAL)], ids=["trim", "drift"]
)
def test_along_one_plane_it_is_the_flight_of_that_plane(law: tv.control.Law) -> None:
    options = {"law": law, "engine": "sixdof", "step": 0.02, "tolerance": 0.01}
    for plane, angle in (("pitch", 0.0), ("yaw", np.pi / 2)):
        one = tv.flown_boundary(VEHICLE, GUST, plane=plane, **options)
        both = tv.flown_boundary(VEHICLE, tv.winds.PlaneWind.towards(GUST, angle), **options)
        assert both.limit == one.limit
        assert abs(both.deflection) == pytest.approx(abs(one.deflection), rel=1e-12)


def test_what_is_not_flown_in_both_planes_is_refused() -> None:
    wind = tv.winds.PlaneWind.towards(GUST, 0.5)
    options = {"law": tv.TrimLaw(FIXED), "engine": "sixdof"}
    with pytest.raises(tv.InputError, match='flown with engine="sixdof"'):
        tv.flown_boundary(VEHICLE, wind, law=tv.TrimLaw(FIXED))
    with pytest.raises(tv.InputError, match="both planes are flown by a law"):
        tv.flown_boundary(VEHICLE, wind, engine="sixdof")
    with pytest.raises(tv.InputError, match="frozen parameters"):
        tv.flown_boundary(VEHICLE, wind, frozen=False, **options)
