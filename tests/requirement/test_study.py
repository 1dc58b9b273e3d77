"""The study: the same numbers as the rooms it is made of."""

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.ascent.nominal_flight import load_flight_condition
from tvclin.boundary.closed_forms import triangular_limit
from tvclin.flights.flown_boundary import flown_boundary


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact", "drift-and-speed"])
def test_the_required_deflection_is_the_boundary_of_the_chosen_model(
    configuration_i: tv.Vehicle, model: str
) -> None:
    result = tv.Study.from_vehicle(
        configuration_i, duration=7.5, peak=0.08, dead_band=0.6, model=model, sign="frozen"
    )
    plant = tv.Plant.from_vehicle(configuration_i, model)
    wind = tv.TriangularWind(peak=0.08, duration=7.5)
    expected = tv.boundary_limit(plant, wind, 0.6, switch="literal")

    assert abs(expected.deflection) == result.required_deflection
    assert 0.6 in result.dead_bands


def test_the_limit_is_sufficient_exactly_from_the_required_deflection_on(
    configuration_ii: tv.Vehicle,
) -> None:
    wind = {"duration": 9.0, "peak": -0.05, "model": "fixed-path", "sign": "frozen"}
    need = tv.Study.from_vehicle(configuration_ii, **wind).required_deflection

    for factor, expected in ((1.0, True), (1.0001, True), (0.9999, False)):
        result = tv.Study.from_vehicle(configuration_ii, **wind, limit=need * factor)
        assert result.sufficient is expected
        assert result.survivable_peak == pytest.approx(-0.05 * factor, rel=1e-13)


def test_a_stable_vehicle_needs_no_deflection(configuration_i: tv.Vehicle) -> None:
    stable = configuration_i.replace(aerodynamic_arm=-2.0)
    result = tv.Study.from_vehicle(stable, duration=7.5, peak=0.08, limit=1e-6, model="fixed-path")

    assert result.sufficient is True
    assert result.required_deflection == 0.0
    assert result.survivable_peak == result.peak_bound == pytest.approx(np.radians(30.0))


@pytest.mark.parametrize("arm", usual([0.0, -1e-9, 1e-9], 0))
def test_a_vehicle_with_hardly_an_aerodynamic_moment_is_studied(
    configuration_i: tv.Vehicle, arm: float
) -> None:
    result = tv.Study.from_vehicle(
        configuration_i.replace(aerodynamic_arm=arm), duration=7.5, peak=0.08, model="fixed-path"
    )

    assert 0.0 <= result.required_deflection < 1e-9
    assert np.isfinite(result.trim_deflection)


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        ({"wind": "square"}, "wind must be one of"),
        ({"duration": 0.0}, "duration of the wind must be positive"),
        ({"peak": 0.0}, "peak must be other than zero"),
        ({"peak": 2.0}, "within 90 degrees"),
        ({"dead_band": 1.2}, "dead_band must be between 0 and 1"),
        ({"limit": -0.1}, "limit must be positive"),
        ({"limit": [0.1, 0.2]}, "limit must be one number"),
        ({"dead_band": [0.5, 1.0]}, "dead_band must be one number"),
        ({"model": "Drift"}, "did you mean 'drift'"),
        ({"plane": "roll"}, "plane must be one of"),
    ],
)
def test_bad_input_is_one_sentence(
    configuration_i: tv.Vehicle, changes: dict[str, object], names: str
) -> None:
    arguments = {"duration": 7.5, "peak": 0.08} | changes
    with pytest.raises(tv.InputError, match=names):
        tv.Study.from_vehicle(configuration_i, **arguments)


def test_a_batch_of_vehicles_is_refused(configuration_i: tv.Vehicle) -> None:
    with pytest.raises(tv.InputError, match="one vehicle"):
        tv.Study.from_vehicle(
            configuration_i.replace(thrust=np.array([2e6, 3e6])),
            duration=7.5,
            peak=0.08,
            model="fixed-path",
        )


def test_what_is_doubtful_about_vehicle_and_plane_is_noted() -> None:
    vehicle = tv.load_vehicle("configuration-i")

    def notes(peak_deg: float, plane: str = "pitch", **change: float) -> str:
        peak = np.radians(peak_deg)
        changed = vehicle.replace(**change)
        study = tv.Study.from_vehicle(
            changed, duration=7.5, peak=peak, plane=plane, model="fixed-path"
        )
        return " ".join(study.notes)

    unknown = "the requirement in a head wind is not known"
    assert unknown in notes(5.0, attitude=np.radians(4.0))
    assert unknown not in notes(5.0) + notes(-5.0) + notes(1.0) + notes(5.0, "yaw")
    assert "T/W 0.18" in notes(1.0, thrust=0.18 * vehicle.weight)
    assert "T/W" not in notes(1.0)


def _notes(vehicle: tv.Vehicle, duration: float, dead_band: float, model: str) -> str:
    study = tv.Study.from_vehicle(
        vehicle, duration=duration, peak=np.radians(5), dead_band=dead_band, model=model
    )
    return " ".join(study.notes)


def test_a_limit_that_only_a_forecast_makes_enough_is_noted_with_the_bound_without_one(
    configuration_i: tv.Vehicle,
) -> None:
    wind = tv.TriangularWind(peak=np.radians(5), duration=60.0)
    plant = tv.Plant.from_vehicle(configuration_i, "drift-exact")
    bound = np.degrees(abs(tv.forecast_free_limit(plant, wind).deflection))

    said = _notes(configuration_i, 60.0, 0.5, "drift-exact")
    assert "K = 0.5 trusts a forecast: any law without a forecast that must" in said
    assert f"at least {bound:.3f} deg" in said
    for dead_band, duration in ((1.0, 60.0), (0.5, 7.5), (0.0, 7.5)):
        assert "forecast" not in _notes(configuration_i, duration, dead_band, "drift-exact")


def test_one_pole_is_doubted_in_a_long_wind_unless_both_were_flown(
    configuration_i: tv.Vehicle,
) -> None:
    doubt = "is too long for the single-pole theory"
    assert doubt in _notes(configuration_i, 60.0, 1.0, "fixed-path")
    assert doubt in _notes(configuration_i, 60.0, 0.75, "drift-exact")
    assert doubt not in _notes(configuration_i, 60.0, 1.0, "drift-exact")


@pytest.mark.thorough
@pytest.mark.parametrize(
    "changes", usual([{"velocity": 45.0, "attitude": 1.5}, {"aerodynamic_arm": -2}], 1)
)
def test_a_model_that_leaves_out_what_the_exact_one_needs_says_so(
    configuration_i: tv.Vehicle, changes: dict[str, float]
) -> None:
    vehicle = configuration_i.replace(**changes)
    needs = [
        tv.Study.from_vehicle(vehicle, duration=7.5, peak=0.08, model=model).required_deflection
        for model in ("fixed-path", "drift", "drift-exact")
    ]
    assert needs[2] > max(needs[:2])
    for model in ("fixed-path", "drift"):
        said = _notes(vehicle, 7.5, 1.0, model)
        assert f"unstable modes that {model} leaves out" in said
    assert "leaves out, and" not in _notes(vehicle, 7.5, 1.0, "drift-exact")
    assert "leaves out, and" not in _notes(configuration_i, 7.5, 1.0, "fixed-path")


@pytest.mark.parametrize(
    ("duration", "dead_band", "damping", "noted"),
    [
        (20.0, 0.5, 0.0, True),
        (20.0, 0.5, 0.024, False),  # it has one
        (20.0, 1.0, 0.0, False),  # a slower pole asks for less
        (4.5, 0.5, 0.0, False),  # tau*beta = 2.4
        (7.0, 0.5, 0.0, False),  # 3.7: below 4.09 a slower pole asks for less
        (9.0, 0.5, 0.0, True),  # 4.8
        (7.0, 0.0, 0.0, True),
    ],
)
def test_a_study_tells_where_leaving_damping_out_promises_too_much(
    configuration_i, duration, dead_band, damping, noted
) -> None:
    """Where what is required with a pole four percent slower is more, and by how much."""
    vehicle = configuration_i.replace(pitch_damping=damping * configuration_i.moment_of_inertia)
    said = _notes(vehicle, duration, dead_band, "fixed-path")
    assert ("no pitch_damping is given" in said) == noted
    if noted:
        x = duration * float(tv.Coefficients.from_vehicle(vehicle).beta)
        more = 100 * (triangular_limit(0.96 * x, dead_band) / triangular_limit(x, dead_band) - 1)
        assert f"would need {more:.1f} percent more" in said


def test_a_stable_vehicle_is_told_nothing_of_damping(configuration_i) -> None:
    stable = configuration_i.replace(aerodynamic_arm=-1.0)
    assert "damping" not in _notes(stable, 20.0, 0.5, "fixed-path")


def excess_of_flights(name: str, peak: float, duration: float) -> tuple[float, tv.Study]:
    """Return by how much nonlinear flights in a head wind require more than a study, and the study.

    They encounter the dynamic pressure of the path that the wind turns. `peak`: in deg.
    """
    vehicle, condition = tv.load_vehicle(name), load_flight_condition(name)
    study = tv.Study.from_vehicle(vehicle, duration=duration, peak=np.radians(peak))
    wind = tv.TriangularWind(peak=-np.radians(peak), duration=duration)
    flown = flown_boundary(
        vehicle,
        wind.shift(float(vehicle.time) - duration / 2.0),
        engine="planar",
        frozen=False,
        condition=condition,
        dead_band=1.0,
        tolerance=1e-3,
    )
    return abs(float(flown.deflection)) / study.required_deflection - 1.0, study


@pytest.mark.parametrize(
    ("name", "peak", "duration"),
    [("configuration-i", 5.0, 7.5), ("configuration-ii", 7.0, 15.0)],
)
@pytest.mark.thorough
def test_a_head_wind_that_nonlinear_flights_survive_with_more_alone_is_noted(name, peak, duration):
    excess, study = excess_of_flights(name, peak, duration)
    noted = any("whose path turns" in note for note in study.notes)
    assert noted == (excess > 0.01)
    assert excess < 0.04


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "peak", "percent"),
    [
        ("configuration-i", 6.0, 0.9),
        ("configuration-i", 10.0, 2.6),
        ("configuration-ii", 6.0, 1.7),
        ("configuration-ii", 10.0, 4.1),
    ],
)
def test_the_excess_of_nonlinear_flights_is_that_of_the_page_on_limits(name, peak, percent):
    assert 100.0 * excess_of_flights(name, peak, 15.0)[0] == pytest.approx(percent, abs=0.15)


@pytest.mark.parametrize("wind", [tv.RectangularWind, tv.TriangularWind])
def test_a_wind_that_stays_near_its_peak_is_noted_where_it_requires_more_along_a_flight(wind):
    vehicle, flight = tv.load_vehicle("configuration-i"), tv.load_schedule("configuration-i")
    shape = {tv.RectangularWind: "rectangular", tv.TriangularWind: "triangular"}[wind]
    study = tv.Study.from_vehicle(vehicle, duration=12.0, peak=0.05, wind=shape)
    winds = {"wind": wind(peak=0.05, duration=12.0)}
    sizing = tv.size(flight, winds, times=[float(vehicle.time)], dead_bands=1.0)
    required = (sizing.required[name][0, 0] for name in ("K = 1, varying", "K = 1"))
    excess = next(required) / next(required) - 1.0
    noted = any(note.startswith("the vehicle is frozen: ") for note in study.notes)
    assert noted == (excess > 0.02) == (shape == "rectangular")
    assert excess < 0.01 * 12.0


@pytest.mark.thorough
@pytest.mark.parametrize(("duration", "percent"), [(7.5, 4.4), (12.0, 8.5), (20.0, 14.4)])
def test_the_excess_of_a_varying_vehicle_is_that_of_the_page_on_limits(duration, percent):
    vehicle, flight = tv.load_vehicle("configuration-i"), tv.load_schedule("configuration-i")
    winds = {"wind": tv.RectangularWind(peak=np.radians(3.0), duration=duration)}
    sizing = tv.size(flight, winds, times=[float(vehicle.time)], dead_bands=1.0)
    varying, frozen = (sizing.required[name][0, 0] for name in ("K = 1, varying", "K = 1"))
    assert 100.0 * (varying / frozen - 1.0) == pytest.approx(percent, abs=0.1)
