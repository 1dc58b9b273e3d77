"""Figures: what is drawn is what the library says, and what the CSV holds."""

import subprocess
import sys
from functools import cache

import control
import matplotlib as mpl
import numpy as np
import pytest

import tvclin as tv
from tests.report_responses import triangular_attitude, triangular_attitude_with_drift
from tests.turns import usual
from tvclin import plots
from tvclin.boundary.closed_forms import rectangular_limit, triangular_limit
from tvclin.plots.curves import Column, Curves, curves_of
from tvclin.plots.style import Look, draw
from tvclin.show.reproduce import FIGURES

mpl.use("Agg")
pytestmark = pytest.mark.usefixtures("no_flights")


@pytest.fixture(autouse=True)
def no_figure_stays_open():
    yield
    import matplotlib.pyplot as plt

    plt.close("all")


@pytest.fixture(scope="module", autouse=True)
def no_figure_is_kept(no_flights):
    yield
    figure.cache_clear()


@cache
def figure(name):
    """Return a figure of the report that tests only look at."""
    return FIGURES[name]()


def numbers(text):
    """Return the headings and the rows of a CSV."""
    import csv

    comment, *rows = text.splitlines()
    assert comment.startswith("# ")
    headings, *values = csv.reader(rows)
    return headings, np.array(values, dtype=float)


def all_lines(plot):
    return [line for panel in plot.lines.flat for line in panel]


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_a_control_plot_of_its_numbers(name):
    plot = figure(name)
    computed = plot.curves

    assert isinstance(plot, control.ControlPlot)
    assert name == computed.name
    if name == "figure-1":  # its lines have both their coordinates in columns
        drawn = [values for line in all_lines(plot) for values in line.get_data()]
    else:
        drawn = [line.get_ydata() for line in all_lines(plot)]
        assert all(np.array_equal(computed.abscissa, line.get_xdata()) for line in all_lines(plot))
    assert len(computed.columns) == len(drawn)
    for column, values in zip(computed.columns, drawn, strict=True):
        np.testing.assert_array_equal(column.values, values)


@pytest.mark.parametrize("name", FIGURES)
def test_the_csv_reads_back_as_the_same_numbers_but_for_what_rounding_leaves_of_a_zero(name):
    result = curves_of(figure(name))
    headings, rows = numbers(result.csv())

    assert len(set(headings)) == len(headings) == 1 + len(result.columns)
    assert all(heading.endswith("]") for heading in headings)
    np.testing.assert_array_equal(result.abscissa, rows[:, 0])
    for column, values in zip(result.columns, rows[:, 1:].T, strict=True):
        there, rounding = values != 0.0, 16.0 * np.finfo(float).eps
        np.testing.assert_array_equal(column.values[there], values[there])
        left = np.abs(column.values[~there])
        assert np.all(left <= rounding * np.nanmax(np.abs(column.values)))


@pytest.mark.parametrize("name", [name for name in FIGURES if name != "figure-1"])
def test_every_axis_has_a_label_with_its_unit(name):
    plot = figure(name)

    for axes in plot.axes.flat:
        assert axes.get_xlabel().endswith("[-]")
        assert axes.get_ylabel().endswith("[-]")


def test_figure_2_is_equations_7_and_12():
    computed = plots.figure_2().curves
    at_4 = int(np.argmin(np.abs(computed.abscissa - 4.0)))

    assert computed.column("rectangular")[at_4] == pytest.approx(0.98168, abs=5e-6)
    assert computed.column("triangular, K = 1")[at_4] == pytest.approx(0.6884593698, abs=5e-11)
    assert computed.column("triangular, K = 0.5")[at_4] == pytest.approx(0.5587576750, abs=5e-11)
    assert computed.column("triangular, K = 0")[at_4] == pytest.approx(0.3738225362, abs=5e-11)


def test_figure_5_is_equations_12_and_18():
    computed = plots.figure_5(tau_beta=[4.0, 20.0]).curves
    expected = {
        ("without drift, eq (12)", "(a) K = 1"): [0.68846, 0.93069],
        ("Configuration I, eq (18)", "(a) K = 1"): [0.66484, 0.7939],
        ("Configuration II, eq (18)", "(a) K = 1"): [0.66186, 0.7837],
        ("without drift, eq (12)", "(b) K = 0.5"): [0.55876, 0.2],
        ("Configuration I, eq (18)", "(b) K = 0.5"): [0.54080, 0.1901],
        ("Configuration II, eq (18)", "(b) K = 0.5"): [0.53844, 0.1888],
    }

    assert set(expected) == {(column.label, column.panel) for column in computed.columns}
    for key, values in expected.items():
        assert computed.column(*key) == pytest.approx(values, abs=6e-5)


def test_boundary_chart_of_a_vehicle_includes_its_drift(configuration_i):
    c = tv.Coefficients.from_vehicle(configuration_i)
    computed = plots.boundary_chart([2.0, 4.0], [1.0], c).curves

    np.testing.assert_array_equal(
        rectangular_limit([2.0, 4.0], c.K1), computed.column("rectangular")
    )
    assert computed.column("triangular, K = 1")[1] == pytest.approx(0.66484, abs=5e-6)


def test_with_damping_durations_are_in_times_of_the_pole_and_say_so(configuration_i):
    """On the axis, in the legend and in the numbers; without it nothing is called otherwise."""
    damped = configuration_i.replace(pitch_damping=0.3 * configuration_i.moment_of_inertia)
    c, plain = (tv.Coefficients.from_vehicle(one) for one in (damped, configuration_i))
    plant, x, peak = tv.Plant(c, "drift"), np.array([2.0, 4.0]), 0.08
    expected = [
        tv.boundary_limit(plant, tv.TriangularWind(peak=peak, duration=b / c.pole), 0.5).limit
        for b in x
    ]
    chart = plots.boundary_chart(x, [0.5], c).curves
    np.testing.assert_allclose(chart.column("triangular, K = 0.5"), expected, rtol=1e-12)
    figure = plots.figure_5(x, [0.5], [damped]).curves
    np.testing.assert_allclose(figure.columns[1].values, expected, rtol=1e-12)
    laws = plots.laws_chart(plant, {}, peak, x).curves
    wind = tv.TriangularWind(peak=peak, duration=4.0 / c.pole)
    needed = tv.required_deflection(plant, wind).limit
    assert laws.column("required, K = 1")[1] == pytest.approx(needed, rel=1e-12)
    for computed in (chart, figure, laws):
        assert "tau*p" in computed.abscissa_label
        assert "beta" not in computed.parameters
    assert "tau*beta" in plots.boundary_chart(x, [0.5], plain).curves.abscissa_label
    figures = plots.figure_6(damped, tau_beta=[4.0], points=11)
    assert set(figures.curves.panels) == {"tau*p = 4"}
    assert "(B9)" not in "".join(text.get_text() for text in figures.figure.texts)


@pytest.mark.parametrize(("draw", "K"), [(plots.figure_3, 1.0), (plots.figure_4, 0.5)])
@pytest.mark.parametrize("factor", [0.8, 0.9, 1.1, 1.2])
def test_figures_3_and_4_are_equation_13(draw, K, factor):
    computed = draw(tau_beta=[2.0, 4.0], factors=[factor], points=101).curves

    for b in (2.0, 4.0):
        y = factor * triangular_limit(b, K)
        expected = triangular_attitude(computed.abscissa, b, y, K)
        row = computed.column(f"{factor:g} y_BR", f"tau*beta = {b:g}")
        np.testing.assert_allclose(row, expected, rtol=1e-9, atol=1e-12)


def test_figure_3_has_the_attitude_that_the_report_quotes():
    computed = plots.figure_3(points=2001).curves
    row = computed.column("1.1 y_BR", "tau*beta = 4")
    first = computed.abscissa <= 1.2
    peak = int(np.argmax(np.where(first, row, -1.0)))

    assert row[peak] == pytest.approx(0.1642, abs=5e-5)
    assert computed.abscissa[peak] == pytest.approx(0.877, abs=1e-3)
    assert np.interp(0.0, -row[peak:], computed.abscissa[peak:]) == pytest.approx(1.080, abs=1e-3)


@pytest.mark.parametrize(
    ("draw", "vehicle", "K"),
    [
        (plots.figure_6, "configuration-i", 1.0),
        (plots.figure_7, "configuration-i", 0.5),
        (plots.figure_8, "configuration-ii", 1.0),
        (plots.figure_9, "configuration-ii", 0.5),
    ],
)
def test_figures_6_to_9_are_equation_b9(draw, vehicle, K):
    computed = draw(tau_beta=[4.0], points=101).curves
    c = tv.Coefficients.from_vehicle(tv.load_vehicle(vehicle))
    limit = tv.boundary.triangular_limit_with_drift(4.0, K, c.beta, c.b1, c.b2)

    for factor in (0.9, 1.1):
        expected = triangular_attitude_with_drift(
            computed.abscissa, 4.0, factor * limit, K, c.beta, c.b1, c.b2
        )
        row = computed.column(f"{factor:g} y_BR", "tau*beta = 4")
        np.testing.assert_allclose(row, expected, rtol=1e-8, atol=1e-11)


def test_a_limit_above_trim_is_marked_and_leaves_the_attitude_alone():
    computed = plots.figure_3(tau_beta=[20.0]).curves
    notes = {column.label: column.note for column in computed.columns}

    assert notes == {
        "0.8 y_BR": "",
        "0.9 y_BR": "",
        "y_BR (boundary)": "",
        "1.1 y_BR": "trim never saturates",
        "1.2 y_BR": "trim never saturates",
    }
    assert np.abs(computed.column("1.2 y_BR", "tau*beta = 20")).max() < 1e-12
    assert "1.2 y_BR (trim never saturates) [-]" in computed.headings


def test_divergent_curves_leave_the_frame_and_the_boundary_stays_in_it():
    plot = figure("figure-6")

    for axes, columns in zip(plot.axes.flat, plot.curves.panels.values(), strict=True):
        low, high = axes.get_ylim()
        assert low < columns[2].values.min() <= columns[2].values.max() < high
        assert columns[0].values.max() > high
        assert columns[4].values.min() < low


def test_on_the_boundary_nothing_is_lost_however_long_the_wind():
    computed = plots.figure_3(tau_beta=[200.0], factors=[1.0], until=5.0).curves

    limit = triangular_limit(200.0, 1.0)
    assert computed.columns[0].values[-1] == pytest.approx(limit, rel=1e-12)


@pytest.mark.parametrize(
    "draw", usual([plots.figure_2, plots.figure_3, plots.figure_5, plots.sketch_c], 1)
)
def test_no_two_curves_of_a_panel_look_alike(draw):
    for panel in draw().lines.flat:
        colours = [line.get_color() for line in panel]
        dashes = [str(line._unscaled_dash_pattern) + str(line.get_linewidth()) for line in panel]

        assert len(set(colours)) == len(colours)
        assert len(set(dashes)) == len(dashes)


def test_figure_1_shows_the_angles_it_says():
    computed = plots.figure_1(50.0, 20.0, 15.0, 8.0).curves

    def direction(name):
        x, y = computed.column(f"{name} x"), computed.column(f"{name} y")
        return np.degrees(np.arctan2(y[-1] - y[0], x[-1] - x[0]))

    assert direction("axis") == pytest.approx(50.0)
    assert direction("velocity") == pytest.approx(20.0)
    assert direction("relative velocity") == pytest.approx(35.0)
    assert direction("wind") == pytest.approx(0.0)  # a tail wind
    assert direction("thrust") == pytest.approx(58.0)  # at the tail it lifts it: nose down
    assert direction("normal force") == pytest.approx(140.0)
    assert direction("axial force") == pytest.approx(-130.0)
    assert direction("weight") == pytest.approx(-90.0)


def test_sketch_a_holds_the_limit_of_equation_7():
    computed = plots.sketch_a(tau_beta=2.0).curves
    held = computed.column("control", "control")

    assert held[computed.abscissa < -1e-6] == pytest.approx(0.0)
    assert held[computed.abscissa >= 0.0] == pytest.approx(1.0 - np.exp(-2.0), rel=1e-14)


def test_sketch_b_switches_where_equation_11_says():
    computed = plots.sketch_b(tau_beta=4.0, dead_band=0.5).curves
    x, held = computed.abscissa, computed.column("control", "control")
    y = triangular_limit(4.0, 0.5)
    jump = int(np.argmax(np.diff(held)))

    assert x[jump + 1] == pytest.approx(y * 0.5 / 2.0, rel=1e-12)
    assert held[jump] == pytest.approx(0.5 * y, rel=1e-7)
    assert held[jump + 1] == pytest.approx(y, rel=1e-12)


@pytest.mark.thorough
def test_sketch_c_solves_equation_c6():
    computed = plots.sketch_c(ratios=(0.1, 0.5)).curves
    y = computed.abscissa

    for r in (0.1, 0.5):
        x = computed.column(f"exact, r = {r:g}")
        residual = 2.0 * x**r - 2.0 * x * y - (1.0 - y)
        assert np.nanmax(np.abs(residual)) < 1e-7  # steep next to y = 1
        assert np.all(np.isnan(x) == (y == 1.0))
    assert computed.column("exact, r = 0.1")[-1] == pytest.approx(0.54410, abs=5e-6)


def test_a_response_is_drawn_in_degrees_whoever_computed_it(configuration_i):
    plant, wind = tv.Plant.from_vehicle(configuration_i), tv.TriangularWind(peak=0.08, duration=7.5)
    held = tv.linear.ConstantDeflection(limit=tv.boundary_limit(plant, wind, 0.0).deflection)
    times, level = np.linspace(0.0, 7.5, 61), abs(held.limit)
    exact = tv.attitude_response(plant, held, wind, times)
    inputs = np.stack([held(times), wind(times)])
    simulated = control.forced_response(plant.ss(), times, inputs)
    drawn = plots.response_chart(exact, limit=level).curves
    other = plots.response_chart(simulated, limit=level).curves

    assert [c.label for c in drawn.columns] == [c.label for c in other.columns]
    computed = {column.label: column.values for column in drawn.columns}
    for signals in (exact.outputs, exact.inputs):
        for label, row in zip(signals.signal_labels, signals, strict=True):
            np.testing.assert_allclose(computed[label], np.degrees(row), rtol=1e-12, atol=1e-13)
    assert drawn.column("lower limit", "deflection")[0] == -np.degrees(level)
    size = np.degrees(wind.peak)
    for one, two in zip(drawn.columns, other.columns, strict=True):
        np.testing.assert_allclose(one.values, two.values, rtol=1e-9, atol=1e-9 * size)


def test_a_flight_that_meets_both_stops_is_drawn_with_both(configuration_i):
    plant = tv.Plant.from_vehicle(configuration_i, "fixed-path")
    wind, limit = tv.TriangularWind(peak=0.08, duration=7.5), 0.0045
    law = tv.RecoverableAttitudeLaw(plant, design_peak=0.08)
    flown = tv.fly(plant, law, wind, np.linspace(0.0, 18.0, 91), deflection_limit=limit)
    drawn = plots.response_chart(flown, limit=limit).curves

    values = drawn.column("deflection", "deflection")
    assert values.max() == pytest.approx(np.degrees(limit), rel=1e-9)
    assert values.min() == pytest.approx(-np.degrees(limit), rel=1e-9)
    for label, sign in (("upper limit", 1.0), ("lower limit", -1.0)):
        assert np.all(drawn.column(label, "deflection") == sign * np.degrees(limit))


@pytest.mark.thorough
def test_importing_the_figures_loads_neither_control_nor_matplotlib():
    code = (
        "import sys, tvclin.plots, tvclin.show.reproduce;"
        "print([m for m in ('control', 'matplotlib', 'scipy') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert out.stdout.strip() == "[]"


@pytest.mark.thorough
def test_a_figure_drawn_before_control_is_imported_is_still_its_plot():
    code = (
        "import sys, tvclin.plots as plots\n"
        "plot = plots.sketch_c()\n"
        "assert 'control' not in sys.modules\n"
        "plot.set_plot_title('all of it')\n"
        "import control\n"
        "assert isinstance(plot, control.ControlPlot)\n"
        "whole = plots.sketch_c()\n"
        "assert type(whole) is control.ControlPlot\n"
        "assert plot.lines.shape == whole.lines.shape == plot.shape\n"
        "assert plot.curves.columns[0].label == whole.curves.columns[0].label\n"
        "print(*[text.get_text() for text in plot.figure.texts])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert "all of it" in out.stdout


def test_the_chart_of_laws_measures_them_by_equation_12_and_the_minimum(configuration_i):
    plant = tv.Plant.from_vehicle(configuration_i, "fixed-path")
    computed = plots.laws_chart(plant, {}, 0.08, np.array([2.0, 4.0])).curves

    for K in (1.0, 0.5):
        expected = triangular_limit([2.0, 4.0], K)
        np.testing.assert_allclose(computed.column(f"required, K = {K:g}"), expected, rtol=1e-12)
    # the minimum of one pole is K = 0, and in one triangle a forecast is worth nothing
    for label in ("lower bound, wind known", "lower bound, no forecast"):
        expected = triangular_limit([2.0, 4.0], 0.0)
        np.testing.assert_allclose(computed.column(label), expected, rtol=1e-9)


def test_between_its_marks_the_chart_of_laws_is_near_equation_12(configuration_i):
    plant = tv.Plant.from_vehicle(configuration_i, "fixed-path")
    plot = plots.laws_chart(plant, {}, 0.08)
    line = next(one for one in plot.lines[0, 0] if one.get_label() == "required, K = 1")
    x, y = line.get_data()

    assert x.size > 400
    # a monotone cubic between points that are a factor 1.5 apart on a curve that bends slowly
    np.testing.assert_allclose(y, triangular_limit(x, 1.0), rtol=0.01)
    assert np.all(np.isin(plot.curves.abscissa, x))


def test_charts_are_titled_with_the_name_of_the_vehicle(configuration_i):
    c = tv.Coefficients.from_vehicle(configuration_i)

    assert configuration_i.name in plots.boundary_chart(coefficients=c).axes[0, 0].get_title()
    assert plots.pole_map(c).figure.get_suptitle() == configuration_i.name


def test_study_chart_and_pole_map_are_control_plots(configuration_i):
    study = tv.Study.from_vehicle(
        configuration_i, duration=7.5, peak=0.08, limit=0.006, model="fixed-path", sign="frozen"
    )
    drawn = plots.study_chart(study)
    poles = plots.pole_map(study.coefficients)

    assert isinstance(drawn, control.ControlPlot)
    assert len(all_lines(drawn)) == 6
    numbers = curves_of(plots.study_chart(study, [7.5, 15.0])).column("K = 1, fixed-path")
    assert numbers[0] == pytest.approx(np.degrees(study.required_deflection), rel=1e-12)
    assert (1, 2) == poles.axes.shape
    assert sorted(all_lines(poles)[0].get_xdata()) == pytest.approx([-0.52928, 0.52928], abs=5e-6)


@pytest.mark.thorough
def test_a_study_with_a_gust_draws_few_durations(configuration_i):
    """For each of them the trim law is flown."""
    wind = tv.ShapedWind(
        "triangular", 0.08, 7.5, gust=tv.OneMinusCosineGust(peak=0.02, duration=2.0), gust_at=3.0
    )
    study = tv.Study.of(tv.Case(vehicle=configuration_i, wind=wind, model="fixed-path"))
    assert curves_of(plots.study_chart(study)).abscissa.size <= 40


def test_curves_say_what_is_wrong():
    column = Column("one", np.zeros(3))

    with pytest.raises(tv.InputError, match="shape of the abscissa"):
        Curves("name", "nothing", "x [-]", np.zeros(2), (column,))
    result = Curves("name", "nothing", "x [-]", np.zeros(3), (column,))
    with pytest.raises(tv.InputError, match="'one'"):
        result.column("two")
    with pytest.raises(tv.InputError, match="drawn from curves"):
        curves_of(object())
    look = Look("title", "y [-]", {"one": {}})
    with pytest.raises(tv.InputError, match="x .* two different values or more"):
        draw(result, look)


@pytest.mark.parametrize(
    "options",
    [{"tau_beta": [0.0]}, {"factors": [-1.0]}, {"until": 0.0}, {"points": 1}, {"dead_band": 2.0}],
)
def test_bad_parameters_are_one_sentence(options):
    with pytest.raises(tv.InputError):
        plots.figure_3(**options)


def test_a_figure_needs_a_file_name_with_a_format(tmp_path):
    with pytest.raises(tv.InputError, match="file name such as"):
        plots.save_figure(plots.sketch_a(), tmp_path / "figure.xyz")
    assert not list(tmp_path.iterdir())
