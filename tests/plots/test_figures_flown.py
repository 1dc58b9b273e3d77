"""Flights beside the theory in figures 6 to 11, against the linear model that they obey."""

from importlib.util import find_spec

import matplotlib as mpl
import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin import plots
from tvclin.ascent.nominal_flight import load_flight_condition
from tvclin.flights import flown_boundary as engines
from tvclin.linear.response import attitude_responses
from tvclin.plots import boundaries as flown_room
from tvclin.plots.boundaries import PEAK, centred_wind, chosen_engine, flown_limit

mpl.use("Agg")

ENGINES = [
    pytest.param("sixdof", marks=pytest.mark.skipif(not find_spec("jsbsim"), reason="no JSBSim")),
    "planar",
]
FIGURES = [
    (plots.figure_6, "configuration-i", 1.0),
    (plots.figure_7, "configuration-i", 0.5),
    (plots.figure_8, "configuration-ii", 1.0),
    (plots.figure_9, "configuration-ii", 0.5),
]


@pytest.fixture(autouse=True)
def no_figure_stays_open():
    yield
    import matplotlib.pyplot as plt

    plt.close("all")


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("draw", "name", "K"), FIGURES)
def test_marks_of_figures_6_to_9_are_flights_at_the_same_limits(draw, name, K, engine):
    """The exact cubic with the dead band left by trim itself, at multiples of eq (18)."""
    computed = draw(tau_beta=[4.0], factors=[0.9, 1.1], points=41, engine=engine).curves
    vehicle = tv.load_vehicle(name)
    c = tv.Coefficients.from_vehicle(vehicle)
    y = tv.boundary.triangular_limit_with_drift(4.0, K, c.beta, c.b1, c.b2)
    exact = tv.Plant(c, "drift-exact")
    wind = tv.TriangularWind(peak=1.0, duration=4.0 / c.beta)
    x = computed.abscissa

    for factor in (0.9, 1.1):
        constant = tv.trim_then_hold(exact, wind, -factor * y * c.B, K, switch="literal")
        expected = -attitude_responses(exact, constant, wind, x * wind.duration)["attitude"]
        row = computed.column(f"{factor:g} y_BR, flown", "tau*beta = 4")
        small = np.abs(expected) < 3.0  # of a wind of 1 degree
        assert small.sum() > 25
        # A horizontal wind on a path that turns moves the boundary by 0.0004, which has grown to
        # 0.005 where the attitude crosses zero.
        np.testing.assert_allclose(row[small], expected[small], rtol=0.01, atol=6e-3)


def test_a_flight_that_leaves_its_model_ends_without_a_word():
    computed = plots.figure_6(tau_beta=[8.0], factors=[0.8], points=21, engine="planar").curves
    row = computed.column("0.8 y_BR, flown", "tau*beta = 8")

    assert np.isnan(row[-1])
    assert np.nanmax(row) > 5.0
    assert np.all(np.isfinite(row[:10]))


def test_a_flight_of_trim_alone_is_marked():
    computed = plots.figure_6(
        tau_beta=[20.0], factors=[1.0, 1.2], points=21, engine="planar"
    ).curves
    notes = {column.label: column.note for column in computed.columns}

    assert notes["1.2 y_BR, flown"] == "trim never saturates"
    assert not notes["y_BR (boundary), flown"]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("draw", "name", "K", "tau_beta"),
    usual(
        [
            (plots.figure_10, "configuration-i", 0.5, 4.0),
            (plots.figure_11, "configuration-ii", 1.0, 2.0),
        ],
        1,
    ),
)
def test_points_of_figures_10_and_11_are_boundaries_of_the_exact_cubic(draw, name, K, tau_beta):
    engine = chosen_engine(None)
    computed = draw(dead_bands=[K], tau_beta=[tau_beta], along=[]).curves
    exact = tv.Plant.from_vehicle(tv.load_vehicle(name), "drift-exact")
    wind = tv.TriangularWind(peak=PEAK, duration=tau_beta / exact.coefficients.beta)
    expected = tv.boundary_limit(exact, wind, K, switch="literal").limit

    flown = computed.column(f"flown, {engines.ENGINES[engine].words}", f"(a) K = {K:g}")
    assert computed.abscissa[np.isfinite(flown)] == pytest.approx([tau_beta])
    assert flown[np.isfinite(flown)] == pytest.approx(expected, abs=2e-3)


def test_figure_10_is_equations_12_and_18_and_draws_what_is_flown_where_it_belongs(monkeypatch):
    calls = []

    def flown(name, tau_beta, K, **options):
        calls.append((name, tau_beta, K, tuple(sorted(options.items()))))
        return 0.1 * len(calls)

    monkeypatch.setattr(plots.boundaries, "flown_limit", flown)
    computed = plots.figure_10(
        dead_bands=[0.5], tau_beta=[2.0], along=[3.0], engine="planar"
    ).curves
    at = {b: int(np.flatnonzero(computed.abscissa == b)[0]) for b in (2.0, 3.0)}
    values = {column.label: column.values for column in computed.columns}
    c = tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))

    assert [call[3] for call in calls] == [
        (("engine", "planar"),),
        (("along", True), ("peak", PEAK), ("plane", "pitch")),
        (("along", True), ("peak", -PEAK), ("plane", "pitch")),
        (("along", True), ("peak", PEAK), ("plane", "yaw")),
    ]
    assert values["flown, planar equations (B1)"][at[2.0]] == pytest.approx(0.1)
    assert values["along the trajectory, tail wind"][at[3.0]] == pytest.approx(0.2)
    assert values["along the trajectory, yaw"][at[3.0]] == pytest.approx(0.4)
    assert values["without drift, eq (12)"] == pytest.approx(
        tv.boundary.triangular_limit(computed.abscissa, 0.5), abs=1e-14
    )
    assert values["with drift, eq (18)"] == pytest.approx(
        tv.boundary.triangular_limit_with_drift(computed.abscissa, 0.5, c.beta, c.b1, c.b2),
        abs=1e-14,
    )


def test_the_wind_along_a_trajectory_has_its_peak_at_the_time_of_table_i():
    vehicle = tv.load_vehicle("configuration-ii")
    wind = centred_wind(vehicle, PEAK, 4.0)

    assert wind(85.0) == pytest.approx(PEAK)
    assert float(wind.end - wind.onset) == pytest.approx(
        4.0 / tv.Coefficients.from_vehicle(vehicle).beta
    )


def test_along_the_trajectory_the_condition_of_the_vehicle_is_flown(monkeypatch):
    request, flown = {}, engines.flown_boundary

    def boundary(vehicle, wind, dead_band, **options):
        request.update(options)
        return flown(vehicle, wind, dead_band, engine=lambda *_, **__: lambda y: True)

    monkeypatch.setattr(engines, "flown_boundary", boundary)
    flown_limit.__wrapped__("configuration-ii", 4.0, 1.0, plane="yaw", along=True)

    assert request["frozen"] is False
    assert request["condition"] == load_flight_condition("configuration-ii")
    assert request["plane"] == "yaw"


def test_jsbsim_flies_where_it_is_installed(monkeypatch):
    monkeypatch.setattr(flown_room, "find_spec", lambda name: object())
    assert chosen_engine(None) == "sixdof"
    monkeypatch.setattr(flown_room, "find_spec", lambda name: None)
    assert chosen_engine(None) == chosen_engine("planar") == "planar"
    with pytest.raises(tv.InputError, match="engine must be one of"):
        plots.figure_6(engine="kite")
