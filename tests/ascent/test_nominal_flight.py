"""The nominal flight and the air it goes through."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tvclin import InputError
from tvclin.ascent.atmosphere import air_at, density_at, standard_atmosphere
from tvclin.ascent.nominal_flight import FlightCondition, load_flight_condition, nominal_flight

G = 9.80665
NAMES = ("configuration-i", "configuration-ii")


@pytest.fixture(params=NAMES)
def flight(request):
    """Return the nominal flight from ten seconds before to ten seconds after Table I."""
    vehicle = tv.load_vehicle(request.param)
    condition = load_flight_condition(request.param)
    return nominal_flight(vehicle, condition, start=vehicle.time - 10, stop=vehicle.time + 10)


@pytest.mark.parametrize(
    ("altitude", "temperature", "density"),
    [  # U.S. Standard Atmosphere 1976, table I, to its five digits
        (0.0, 288.150, 1.2250),
        (5_000.0, 255.676, 7.3643e-1),
        (10_000.0, 223.252, 4.1351e-1),
        (20_000.0, 216.650, 8.8910e-2),
        (50_000.0, 270.650, 1.0269e-3),
        (80_000.0, 198.639, 1.8458e-5),
    ],
)
def test_the_air_is_the_published_one(altitude, temperature, density):
    air = standard_atmosphere(altitude)
    assert air.temperature == pytest.approx(temperature, abs=6e-4)
    assert air.density == pytest.approx(density, rel=5e-5)


@pytest.mark.parametrize(
    ("height", "pressure"),
    [  # the same, table 4: pressures at the bases of the layers, by geopotential height
        (11e3, 22_632.06),
        (20e3, 5_474.889),
        (32e3, 868.0187),
        (47e3, 110.9063),
        (51e3, 66.93887),
        (71e3, 3.956420),
    ],
)
def test_the_layers_begin_at_the_published_pressures(height, pressure):
    altitude = 6_356_766.0 * height / (6_356_766.0 - height)
    assert standard_atmosphere(altitude).pressure == pytest.approx(pressure, rel=3e-6)


def test_the_density_alone_is_that_of_the_air():
    heights = np.array([0.0, 11e3, 20e3, 32e3, 47e3, 51e3, 71e3])
    bases = 6_356_766.0 * heights / (6_356_766.0 - heights)
    altitudes = np.concatenate([bases, bases - 1e-6, np.linspace(-7e3, 90e3, 500)])
    computed = [density_at(float(altitude)) for altitude in altitudes]
    np.testing.assert_allclose(computed, air_at(altitudes).density, rtol=1e-13)


def test_the_air_is_in_hydrostatic_balance():
    z = np.linspace(1_000.0, 80_000.0, 400)
    step = 1.0
    slope = (standard_atmosphere(z + step).pressure - standard_atmosphere(z - step).pressure) / 2
    local = G * (6_356_766.0 / (6_356_766.0 + z)) ** 2
    np.testing.assert_allclose(slope, -standard_atmosphere(z).density * local, rtol=2e-4)


@pytest.mark.parametrize("altitude", [-6e3, 9e4, np.nan])
def test_air_outside_its_range_is_refused(altitude):
    with pytest.raises(InputError, match="altitude must be"):
        standard_atmosphere(altitude)


@pytest.mark.parametrize("name", NAMES)
def test_the_assumed_altitude_is_where_the_report_bounds_the_pressure(name):
    pressure = load_flight_condition(name).dynamic_pressure(tv.load_vehicle(name))
    assert pressure / 47.880259 == pytest.approx(950.0, rel=0.01)  # psf


def test_it_passes_through_table_i(flight):
    v = flight.vehicle
    result = flight.states(v.time)
    assert tuple(result) == (v.velocity, v.attitude, flight.condition.altitude)
    assert flight.mass(v.time) == v.mass
    assert flight.vehicle_at(v.time).replace(name=v.name) == v


def test_flown_forward_from_its_beginning_it_is_the_same(flight):
    v, c = flight.vehicle, flight.condition
    flow = v.thrust / (G * c.specific_impulse)
    own = standard_atmosphere(c.altitude).density

    def rates(t, x):
        speed, path, altitude = x
        density = standard_atmosphere(altitude).density
        drag = v.axial_force * density / own * (speed / v.velocity) ** 2
        mass = v.mass - flow * (t - v.time)
        return [
            (v.thrust - drag) / mass - G * np.sin(path),
            -G * np.cos(path) / speed,
            speed * np.sin(path),
        ]

    begin = flight.states(flight.start)
    span = (flight.start, flight.stop)
    end = solve_ivp(rates, span, begin, method="LSODA", rtol=1e-10, atol=1e-8).y[:, -1]
    np.testing.assert_allclose(end, flight.states(flight.stop), rtol=1e-7)


def test_the_nominal_deflection_turns_the_nose_with_the_path(flight):
    t, h = flight.vehicle.time + 2.0, 0.05
    path = flight.states(np.array([t - h, t, t + h]))[1]
    bend = (path[0] - 2.0 * path[1] + path[2]) / h**2
    v = flight.vehicle
    expected = -v.moment_of_inertia * bend / (v.thrust * v.control_arm)
    assert flight.deflection(t) == pytest.approx(expected, rel=1e-3)
    assert 0.0 < np.degrees(np.abs(flight.deflection(flight.time)).max()) < 0.01


def test_aerodynamic_forces_go_with_the_dynamic_pressure(flight):
    t = flight.vehicle.time + np.array([-5.0, 0.0, 5.0])
    there, pressure = flight.vehicle_at(t), flight.dynamic_pressure(t)
    for name in ("normal_force_slope", "axial_force"):
        force = getattr(there, name)
        np.testing.assert_allclose(force / force[1], pressure / pressure[1], rtol=1e-14)


def test_a_common_factor_on_the_table_changes_no_flight():
    vehicle = tv.load_vehicle(NAMES[0])
    condition = load_flight_condition(NAMES[0])
    scaled = condition.scaled(vehicle)
    assert scaled.thrust == 10.0 * vehicle.thrust
    flights = [nominal_flight(v, condition, start=60.0, stop=70.0) for v in (vehicle, scaled)]
    np.testing.assert_allclose(flights[0].states(70.0), flights[1].states(70.0), rtol=1e-13)
    area, q = condition.reference_area, condition.dynamic_pressure(vehicle)
    assert scaled.normal_force_slope / (q * area) == pytest.approx(4.3, abs=0.05)
    assert scaled.axial_force / (q * area) == pytest.approx(0.52, abs=0.01)


@pytest.mark.parametrize(
    ("span", "words"),
    [
        ((0.0, 70.0), "does not reach t = 0 s.*shorter wind.*--set sounding.window_s 20"),
        ((67.0, 70.0), "around the vehicle's time, 66 s"),
        ((66.0, 66.0), "around the vehicle's time"),
        ((60.0, 1e3), "mass is used up.*shorter wind.*--set sounding.window_s 20"),
        ((np.nan, 70.0), "start must be finite"),
    ],
)
def test_a_span_that_cannot_be_flown_is_refused(span, words):
    vehicle, condition = tv.load_vehicle(NAMES[0]), load_flight_condition(NAMES[0])
    with pytest.raises(InputError, match=words):
        nominal_flight(vehicle, condition, start=span[0], stop=span[1])


@pytest.mark.parametrize("name", ["thrust", "axial_force", "time"])
def test_a_batch_has_no_nominal_flight(name):
    vehicle, condition = tv.load_vehicle(NAMES[0]), load_flight_condition(NAMES[0])
    many = vehicle.replace(**{name: [getattr(vehicle, name)] * 2})
    with pytest.raises(InputError, match="one vehicle; got a batch"):
        nominal_flight(many, condition, start=62.0, stop=70.0)


def test_times_outside_the_span_are_refused(flight):
    with pytest.raises(InputError, match="t must be between"):
        flight.states(flight.stop + 1.0)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("", r"no table \[flight\]"),
        ("[[flight]]\naltitude_m = 1e4", r"\[flight\] must be a table; got \[\{'alt"),
        ("[flight]\naltitude_m = 1e4", "a key is missing .*: specific_impulse_s"),
        ("[flight]\naltitude = 1e4", "altitude has no known unit .*; write altitude_m or"),
        ("[flight]\naltitud_m = 1e4", "did you mean altitude_m"),
        ("[flight]\naltitude_m = 1e9\nspecific_impulse_s = 260", "altitude must be between"),
        (
            "[flight]\naltitude_m = 1e4\nspecific_impulse_s = -1",
            "specific_impulse_s in .flight. must be pos",
        ),
    ],
)
def test_a_condition_that_cannot_be_read_is_refused(tmp_path, table, words):
    path = tmp_path / "mine.toml"
    path.write_text(f'[vehicle]\nname = "mine"\n{table}\n', encoding="utf-8")
    with pytest.raises(InputError, match=words):
        load_flight_condition(path)


def test_a_condition_is_read_in_other_units(tmp_path):
    path = tmp_path / "mine.toml"
    text = "[vehicle]\n[flight]\naltitude_ft = 10000\nspecific_impulse_s = 300\n"
    path.write_text(text, encoding="utf-8")
    result = load_flight_condition(path)
    assert result == FlightCondition(altitude=3048.0, specific_impulse=300.0)
