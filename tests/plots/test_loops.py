"""Figures of the loop and the closed loop: what is marked and drawn is what the library says."""

from functools import cache

import control
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import tvclin as tv
from tests.turns import by_turns, usual
from tvclin import plots
from tvclin.plots.frequency_response import box_sides
from tvclin.plots.root_locus import LocusPoles

mpl.use("Agg")

COURSE = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=0.228, mu_delta=1.317))
LAG = {"actuator": tv.Actuator(), "delay": 0.05}
WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
LOOPS = {
    "nichols": plots.nichols_chart,
    "bode": plots.bode_chart,
    "nyquist": plots.nyquist_chart,
    "root-locus": plots.root_locus_chart,
}
CHARTS = LOOPS | {
    "step": plots.step_chart,
    "autopilot-in-wind": lambda autopilot, plant: plots.wind_chart(autopilot, plant, WIND),
}
AERO, GAIN, PHASE = "aero: gain may fall ", "gain may rise ", "phase "


def course(**options):
    return tv.Autopilot(attitude_gain=1.88, rate_gain=1.59, **options), COURSE


def drifting():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift")
    return tv.control.canonical_gains(plant.coefficients, actuator=tv.Actuator(), delay=0.02), plant


def integrating():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    return tv.control.canonical_gains(plant.coefficients, integral_gain=0.02, **LAG), plant


def calm():
    plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=-0.3, mu_delta=1.3))
    return tv.Autopilot(attitude_gain=1.0, rate_gain=1.0, **LAG), plant


def weak():
    return tv.Autopilot(attitude_gain=0.1, rate_gain=0.3, **LAG), COURSE


def wild():
    return tv.Autopilot(attitude_gain=18.8, rate_gain=15.9, **LAG), COURSE


STABLE = {
    "course": course,
    "course with lags": lambda: course(**LAG),
    "drift": drifting,
    "integral": integrating,
    "stable vehicle": calm,
}
UNSTABLE = {"gains too low": weak, "gains too high": wild}
EVERY = STABLE | UNSTABLE


@pytest.fixture(autouse=True)
def no_figure_stays_open():
    yield
    plt.close("all")


@pytest.fixture(scope="module", autouse=True)
def no_figure_is_kept():
    yield
    chart.cache_clear()


@cache
def chart(name, make):
    """Return a figure that tests only look at: the one it opens, and it changes no settings."""
    plt.close("all")
    before = dict(mpl.rcParams)
    plot = CHARTS[name](*make())
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == [plot.figure.number]
    plt.close(plot.figure)
    return plot


def cases(table):
    """Return each loop, of which a usual run takes those that show what can be shown."""
    shown = ("course with lags", "integral", "stable vehicle", "gains too low")
    thorough = {name: pytest.mark.thorough for name in table if name not in shown}
    return [pytest.param(m, id=name, marks=thorough.get(name, ())) for name, m in table.items()]


def marked(plot, start, panel=0):
    """Return the coordinates and the legend's words of the mark whose words begin so."""
    for line in plot.lines.flat[panel]:
        if line.get_label().startswith(start):
            return (*(float(v[0]) for v in line.get_data()), line.get_label())
    return None


def texts(plot):
    return [text.get_text() for axes in plot.axes.flat for text in axes.texts]


def heading(plot):
    suptitle = plot.figure.get_suptitle()
    return suptitle or plot.axes[0, 0].get_title()


@pytest.mark.usefixtures("as_users_have_it")
@by_turns("name,make", CHARTS, [course, drifting, integrating, weak], each=6)
def test_every_figure_is_one_labelled_control_plot_and_changes_no_settings(name, make):
    _, plant = make()
    plot = chart(name, make)

    assert isinstance(plot, control.ControlPlot)
    assert plots.curves_of(plot).name == name
    first = plots.curves_of(plot).csv().splitlines()[0]
    vehicle = f"{plant.coefficients.name}, " if plant.coefficients.name else ""
    assert first.startswith(f"# {name}: {vehicle}model ")
    verdict = "unstable closed loop" if make in UNSTABLE.values() else "stable closed loop"
    assert f": {verdict}" in heading(plot)
    for axes in plot.axes[-1]:
        assert axes.get_xlabel().endswith("]")
    assert all(axes.get_ylabel().endswith("]") for axes in plot.axes.flat)
    if make is weak:
        assert all(marked(plot, one, k) is None for one in (AERO, GAIN, PHASE) for k in (0, -1))
    every_number_can_be_read(plot)


def every_number_can_be_read(plot):
    plot.figure.draw_without_rendering()
    for axes in plot.axes.flat:
        frame = axes.get_window_extent()
        seen = [note for note in axes.texts if note.get_visible()]
        boxes = [mpl.text.Text.get_window_extent(note) for note in seen]
        for k, box in enumerate(boxes):
            assert frame.x0 <= box.x0 <= box.x1 <= frame.x1
            assert frame.y0 <= box.y0 <= box.y1 <= frame.y1
            assert not any(box.overlaps(other) for other in boxes[:k])


@pytest.mark.parametrize("make", cases(STABLE))
def test_nichols_marks_the_margins_and_is_the_exact_frequency_response(make):
    autopilot, plant = make()
    m = autopilot.margins(plant)
    plot = chart("nichols", make)
    curve = plot.lines[0, 0][0]
    phase, size = curve.get_data()
    omega = plot.curves.abscissa

    expected = autopilot.frequency_response(plant, omega)
    np.testing.assert_allclose(
        10.0 ** (size / 20.0) * np.exp(1j * np.radians(phase)), expected, rtol=1e-9
    )
    np.testing.assert_array_equal(plot.curves.column("phase", "phase"), phase)
    np.testing.assert_allclose(plot.curves.column("magnitude", "magnitude"), size, rtol=1e-12)
    rows = [
        (AERO, m.aero_margin_dB, lambda x, y: (x, y), (-180.0, m.aero_margin_dB)),
        (GAIN, m.gain_increase_dB, lambda x, y: (x, y), (-180.0, -m.gain_increase_dB)),
        (PHASE, m.phase_margin_deg, lambda x, y: (abs(x + 180.0), y), (m.phase_margin_deg, 0.0)),
    ]
    for name, value, place, where in rows:
        x, y, words = marked(plot, name)
        if np.isinf(value):
            assert np.isnan(x)
            assert words.endswith("unlimited")
        else:
            assert place(x, y) == pytest.approx(where, abs=1e-8)
            assert f" {value:.2f} " in words
            assert any(text.startswith(f"{value:.2f}") for text in texts(plot))


@pytest.mark.parametrize("make", [course, drifting, weak])
def test_an_unstable_plant_is_drawn_near_180_degrees(make):
    plot = chart("nichols", make)
    phase, size = plot.lines[0, 0][0].get_data()

    low, high = plot.axes[0, 0].get_xlim()
    assert low < -180.0 < high
    at = np.argmin(np.abs(size)) if make is not weak else 0
    assert -180.0 - 1e-3 < phase[at] < 0.0
    if make is not drifting:
        assert phase[0] == pytest.approx(-180.0, abs=0.2)


def test_the_lines_of_equal_closed_loop_size_are_those_of_python_control():
    axes = chart("nichols", STABLE["course with lags"]).axes[0, 0]
    drawn = [line for line in axes.get_lines() if line.get_zorder() == 0.0]
    sizes = np.array([-12.0, -6.0, -3.0, 0.0, 3.0, 6.0, 12.0])
    _, grid = plt.subplots()
    theirs = control.nichols_grid(cl_mags=sizes, ax=grid)[0]

    assert len(drawn) == len(theirs)
    for ours, line, size in zip(drawn, theirs, sizes, strict=True):
        np.testing.assert_allclose(ours.get_xydata(), line.get_xydata(), rtol=0.0, atol=1e-9)
        phase, decibels = ours.get_data()
        loop = 10.0 ** (decibels / 20.0) * np.exp(1j * np.radians(phase))
        np.testing.assert_allclose(20.0 * np.log10(np.abs(loop / (1.0 + loop))), size, atol=1e-9)


@pytest.mark.parametrize("name", usual(["classic", "aircraft"], 1))
def test_the_box_has_the_sides_of_the_criteria(name):
    plot = plots.nichols_chart(*course(**LAG), tv.CRITERIA[name])
    box = plot.axes[0, 0].patches[0]

    aside = {"classic": 30.0, "aircraft": 45.0}[name]
    assert box.get_xy() == (-180.0 - aside, -6.0)
    assert (box.get_width(), box.get_height()) == (2.0 * aside, 12.0)
    assert f"criteria {name} MET" in heading(plot)


def test_the_box_of_own_criteria_may_be_lopsided_and_may_be_missing():
    own = tv.control.Criteria.custom(aero_margin_dB=3.0, gain_increase_dB=8.0, delay_margin=9.0)
    plot = plots.nichols_chart(*course(**LAG), own)
    box = plot.axes[0, 0].patches[0]
    without = plots.nichols_chart(*course(), tv.control.Criteria.custom(disk_margin=0.5))

    assert box_sides(own) == (3.0, 8.0, 0.0)
    assert (*box.get_xy(), box.get_width(), box.get_height()) == (-180.0, -8.0, 0.0, 11.0)
    assert "criteria own NOT MET" in heading(plot)
    assert not without.axes[0, 0].patches


@pytest.mark.parametrize("make", cases(STABLE))
def test_bode_marks_the_margins_at_their_frequencies(make):
    autopilot, plant = make()
    m = autopilot.margins(plant)
    plot = chart("bode", make)
    left = plot.axes[0, 0].get_xlim()[0]

    omega, size = plot.lines[0, 0][0].get_data()
    _, phase = plot.lines[1, 0][0].get_data()
    computed = 10.0 ** (size / 20.0) * np.exp(1j * np.radians(phase))
    np.testing.assert_allclose(computed, autopilot.frequency_response(plant, omega), rtol=1e-9)
    assert np.abs(np.diff(phase)).max() < 200.0  # a pole on the axis turns it by 180 degrees
    if np.isfinite(m.aero_margin):
        where = max(m.aero_frequency, left), m.aero_margin_dB
        assert marked(plot, AERO)[:2] == pytest.approx(where, rel=1e-8)
    if np.isfinite(m.gain_increase):
        where = m.gain_increase_frequency, -m.gain_increase_dB
        assert marked(plot, GAIN)[:2] == pytest.approx(where, rel=1e-8)
    x, y, _ = marked(plot, PHASE, panel=1)
    assert x == pytest.approx(m.crossover_frequency, rel=1e-9)
    assert abs(y + 180.0) == pytest.approx(m.phase_margin_deg, rel=1e-8)


@pytest.mark.parametrize("make", cases(EVERY))
def test_nyquist_counts_what_python_control_counts(make):
    autopilot, plant = make()
    m = autopilot.margins(plant)
    plot = chart("nyquist", make)
    loop = autopilot.loop(plant)
    count = control.nyquist_response(loop, warn_encirclements=False, warn_nyquist=False).count

    unstable = int(np.sum(loop.poles().real > 1e-9))
    assert count + unstable == m.unstable_poles
    way = "counterclockwise" if count <= 0 else "clockwise"
    assert f": {abs(count)} {way} encirclement" in heading(plot)
    assert f", {unstable} unstable open-loop pole" in heading(plot)


@pytest.mark.parametrize("make", cases(STABLE))
def test_nyquist_is_the_frequency_response_with_its_margins_and_touches_the_disk(make):
    autopilot, plant = make()
    m = autopilot.margins(plant)
    plot = chart("nyquist", make)
    omega = plot.curves.abscissa
    values = plot.curves.column("real part") + 1j * plot.curves.column("imaginary part")

    above = omega > 1e-3
    expected = autopilot.frequency_response(plant, omega[above])
    tame = np.abs(expected) < 1e3  # around a pole on the axis the contour is indented
    np.testing.assert_allclose(values[above][tame], expected[tame], rtol=1e-6)
    if np.isfinite(m.aero_margin):
        assert marked(plot, AERO)[:2] == pytest.approx((-m.aero_margin, 0.0), abs=1e-7)
    if np.isfinite(m.gain_increase):
        assert marked(plot, GAIN)[:2] == pytest.approx((-1.0 / m.gain_increase, 0.0), abs=1e-7)
    x, y, _ = marked(plot, PHASE)
    where = np.cos(np.pi - m.phase_margin), np.sin(m.phase_margin)
    assert (x, abs(y)) == pytest.approx(where, rel=1e-8)
    disk = next(p for p in plot.axes[0, 1].patches if p.get_label().startswith("disk margin"))
    distance = np.abs(values - complex(*disk.get_center()))
    assert distance.min() == pytest.approx(disk.get_radius(), rel=1e-4)


def test_no_pole_on_the_axis_is_counted_by_the_rounding_of_its_real_part():
    c = tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i")).replace(C2=0.0)
    plant = tv.Plant.from_coefficients(c, "drift-exact")
    plot = plots.nyquist_chart(tv.control.canonical_gains(c, **LAG), plant)

    assert "1 counterclockwise encirclement of -1, 1 unstable open-loop pole:" in heading(plot)


@pytest.mark.thorough
@pytest.mark.parametrize("make", cases(STABLE))
def test_root_locus_marks_the_closed_loop_poles_and_where_it_crosses_the_axis(make):
    autopilot, plant = make()
    m = autopilot.margins(plant)
    plot = chart("root-locus", make)
    closed = autopilot.close(plant).poles()
    factors, curves = plot.curves.abscissa, plot.curves
    locus = np.stack(
        [
            curves.column(f"pole {k} real part") + 1j * curves.column(f"pole {k} imaginary part")
            for k in range(1, closed.size + 1)
        ]
    )

    drawn = [line for line in plot.lines[0, 0] if line.get_marker() == "D"]
    points = np.array([complex(*(v[0] for v in line.get_data())) for line in drawn])
    for pole in closed:
        assert np.abs(points - pole).min() < 1e-6 * max(abs(pole), 1.0)
    at_one = locus[:, np.searchsorted(factors, 1.0)]
    for pole in points:
        assert np.abs(at_one - pole).min() < 1e-5 * max(abs(pole), 1.0)
    crossings = [
        (AERO, 1.0 / m.aero_margin, m.aero_frequency),
        (GAIN, m.gain_increase, m.gain_increase_frequency),
    ]
    for name, factor, frequency in crossings:
        if np.isfinite(frequency):
            assert marked(plot, name)[:2] == pytest.approx((0.0, frequency), abs=1e-9)
            assert f"factor {factor:.3g}" in texts(plot)
            row = locus[:, np.argmin(np.abs(factors - factor))]
            assert np.abs(row - 1j * frequency).min() < 1e-4 * max(frequency, 1.0)


def test_the_frame_of_the_root_locus_contains_all_poles_but_those_of_the_delay():
    for make in (course, drifting):
        autopilot, plant = make()
        plot = chart("root-locus", make)
        axes = plot.axes[0, 0]
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        marks = [line for line in plot.lines[0, 0] if line.get_marker() in {"D", "s", "^"}]
        places = [tuple(float(v[0]) for v in line.get_data()) for line in marks]
        inside = [(x, y) for x, y in places if left < x < right and low < y < high]

        order = autopilot.rational_loop(plant).denominator.size - 1
        delay = autopilot.close(plant).nstates - order
        endless = 1 if np.isinf(autopilot.margins(plant).gain_increase) else 0
        assert len(inside) == len(places) - delay - endless


def test_root_locus_takes_factors_of_ones_own_and_refuses_what_is_none():
    autopilot, plant = course()
    plot = plots.root_locus_chart(autopilot, plant, [2.0, 0.0, 1.0])

    np.testing.assert_array_equal(plot.curves.abscissa, [0.0, 1.0, 2.0])
    for wrong in (1.0, [[0.0, 1.0]], [-1.0, 1.0], ["a", "b"], [0.0, np.inf]):
        with pytest.raises(tv.InputError, match="gains"):
            plots.root_locus_chart(autopilot, plant, wrong)


@pytest.mark.parametrize("make", cases(STABLE))
def test_the_step_is_that_of_the_closed_loop(make):
    autopilot, plant = make()
    plot = chart("step", make)
    times = plot.curves.abscissa
    closed = autopilot.close(plant)

    for panel, name in enumerate(("attitude", "deflection")):
        expected = control.step_response(closed[name, "attitude_command"], times).outputs
        values = plot.lines[panel, 0][0].get_ydata()
        np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(plot.curves.column(name, name), values)
        final = np.real(closed[name, "attitude_command"].dcgain())
        shown = plot.lines[panel, 0][1].get_ydata()[0]
        assert shown == pytest.approx(final, abs=1e-9)
    assert any(text.startswith("in the end") for text in texts(plot))


@pytest.mark.parametrize("make", cases(STABLE))
def test_the_wind_chart_is_the_exact_answer_beside_trim(make):
    autopilot, plant = make()
    plot = chart("autopilot-in-wind", make)
    answer, curves = autopilot.wind_response(plant, WIND), plot.curves
    expected = dict(zip(answer.labels, np.degrees(answer(curves.abscissa)), strict=True))

    names = [name for name in expected if name not in {"attitude_rate", "deflection"}]
    for name in names:
        np.testing.assert_array_equal(curves.column(name, "angles"), expected[name])
    deflection = curves.column("deflection", "deflection")
    np.testing.assert_array_equal(deflection, expected["deflection"])
    trim = curves.column("trim -B alpha_w,max", "deflection")
    np.testing.assert_allclose(trim, -5.0 * plant.coefficients.B, rtol=1e-12)
    drawn = [line.get_ydata() for panel in plot.lines.flat for line in panel]
    for column, values in zip(curves.columns, drawn, strict=True):
        np.testing.assert_array_equal(column.values, values)
    value, when = answer.peak("deflection")
    peak = plot.axes[1, 0].get_lines()[-1]
    assert (*peak.get_xdata(), *peak.get_ydata()) == pytest.approx((when, np.degrees(value)))
    assert np.abs(deflection).max() == pytest.approx(abs(np.degrees(value)), rel=1e-9)
    part = abs(np.degrees(value) / trim[0])
    assert texts(plot) == [
        f"peak {np.degrees(value):.3g} deg at {when:.3g} s, {part:.2f} x trim",
    ]


def test_the_wind_chart_shows_the_wind_from_its_onset_and_the_vehicle_coming_to_rest():
    autopilot, plant = course(**LAG)
    early = plots.wind_chart(autopilot, plant, WIND.shift(-10.0)).curves
    late = plots.wind_chart(autopilot, plant, WIND.shift(10.0)).curves

    assert early.abscissa[0] == -10.0
    assert late.abscissa[0] == 0.0
    for curves in (early, late):
        assert curves.column("wind", "wind").max() == pytest.approx(5.0, rel=1e-9)
        attitude = np.abs(curves.column("attitude", "angles"))
        assert attitude[-1] < 0.02 * attitude.max()


def test_a_wind_that_never_ends_is_drawn():
    autopilot, plant = course(**LAG)
    step = WIND + tv.SampledWind(time=[0.0, 1.0], angle=[0.0, 0.01]).filter([1.0], [1.0, 0.0])
    curves = plots.wind_chart(autopilot, plant, step).curves

    assert 7.5 < curves.abscissa[-1] < 100.0


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("make", [wild])
def test_an_unstable_loop_is_drawn_without_margins(name, make):
    plot = chart(name, make)
    assert all(marked(plot, one, k) is None for one in (AERO, GAIN, PHASE) for k in (0, -1))
    assert not any(text.endswith((" dB", " deg")) for text in texts(plot))


@pytest.mark.parametrize("make", cases(UNSTABLE))
def test_an_unstable_loop_is_followed_until_it_shows(make):
    autopilot, plant = make()
    fastest = autopilot.close(plant).poles().real.max()
    for plot in (chart("step", make), chart("autopilot-in-wind", make)):
        assert fastest * plot.curves.abscissa[-1] == pytest.approx(3.0, rel=0.15)
        assert not any(text.startswith("in the end") for text in texts(plot))


def test_a_loop_on_the_stability_limit_is_called_so():
    plant = COURSE
    with pytest.warns(UserWarning, match="rate_gain is zero"):
        plot = plots.step_chart(tv.Autopilot(attitude_gain=1.0, rate_gain=0.0), plant)

    assert ": closed loop with a pole on the imaginary axis" in heading(plot)


@pytest.mark.parametrize("name", CHARTS)
def test_batches_and_other_kinds_are_refused_in_one_sentence(name):
    autopilot, plant = course()
    many = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=[0.1, 0.2], mu_delta=1.3))
    several = tv.Autopilot(attitude_gain=[1.0, 2.0, 3.0], rate_gain=1.0)

    with pytest.raises(tv.InputError, match=r"batches of shape plant \(2,\)"):
        CHARTS[name](autopilot, many)
    with pytest.raises(tv.InputError, match=r"batches of shape autopilot \(3,\)"):
        CHARTS[name](several, plant)
    with pytest.raises(tv.InputError, match="autopilot must be an Autopilot"):
        CHARTS[name](plant, autopilot)
    with pytest.raises(tv.InputError, match="plant must be a Plant"):
        CHARTS[name](autopilot, None)


def test_winds_and_criteria_of_another_kind_are_refused():
    autopilot, plant = course()
    winds = tv.TriangularWind(peak=[0.05, 0.1], duration=7.5)

    with pytest.raises(tv.InputError, match=r"batches of shape wind \(2,\)"):
        plots.wind_chart(autopilot, plant, winds)
    with pytest.raises(tv.InputError, match="wind must be a History"):
        plots.wind_chart(autopilot, plant, 0.05)
    with pytest.raises(tv.InputError, match="criteria must be a Criteria"):
        plots.nichols_chart(autopilot, plant, "classic")


def test_the_pade_loop_of_the_locus_is_that_of_the_autopilot():
    autopilot, plant = integrating()
    loop = autopilot.rational_loop(plant)
    system, locus = autopilot.loop(plant), LocusPoles.of(loop, autopilot.pade_order)
    factors = np.array([0.5, 2.0])

    for computed, factor in zip(locus.closed(factors), factors, strict=True):
        expected = np.sort_complex(control.feedback(factor * system, 1).poles())
        np.testing.assert_allclose(np.sort_complex(computed), expected, rtol=0, atol=1e-7 * 120.0)
    assert loop.denominator.shape[-1] - 1 + autopilot.pade_order == locus.poles.size


@pytest.mark.parametrize("make", [drifting, integrating])
def test_the_root_locus_turns_only_where_poles_meet_on_the_axis_and_there_by_a_right_angle(make):
    columns = iter(chart("root-locus", make).curves.columns)
    corners = []
    for real, imaginary in zip(columns, columns, strict=True):
        place = real.values + 1j * imaginary.values
        step = np.diff(place)
        seen = (np.abs(place[1:]) < 5.0) & (np.abs(step) > 1e-4)
        turn = np.abs(np.degrees(np.angle(step[seen][1:] / step[seen][:-1])))
        on_axis = np.abs(place[1:][seen][:-1].imag) < 1e-6
        assert np.all(turn[~on_axis] < 10.0)
        corners += turn[on_axis & (turn > 10.0)].tolist()

    assert corners  # a pole of the vehicle leaves the axis
    np.testing.assert_allclose(corners, 90.0, atol=3.0)


def test_the_root_locus_marks_where_it_ends_and_at_which_factor():
    plot = chart("root-locus", drifting)
    ends = [line for line in plot.lines[0, 0] if line.get_marker() == "|"]
    last = [c.values[-1] for c in plot.curves.columns]
    places = [complex(*pair) for pair in zip(last[::2], last[1::2], strict=True)]

    assert ends[0].get_label() == f"end of the locus (factor {plot.curves.abscissa[-1]:.3g})"
    for line in ends:
        end = complex(*(values[0] for values in line.get_data()))
        assert min(abs(end - place) for place in places) < 1e-12


@pytest.mark.parametrize("name", CHARTS)
def test_a_loop_is_drawn_with_the_name_of_its_vehicle(name):
    assert "Configuration I" in heading(chart(name, drifting)).replace("\u00a0", " ")


def test_legends_are_in_words():
    plot = chart("autopilot-in-wind", drifting)
    labels = [text.get_text() for text in plot.figure.legends[0].get_texts()]

    assert {"angle of attack", "flight path angle"} <= set(labels)
    assert "angle_of_attack" in {column.label for column in plot.curves.columns}  # as in the CSV
