"""Figures of flexible and sampled loops: the curves are the loop, and its modes are on them."""

from dataclasses import replace
from functools import cache

import matplotlib as mpl
import numpy as np
import pytest

import tvclin as tv
from tests.control.test_flexible_loops import AUTOPILOT, booster
from tests.turns import usual
from tvclin import plots
from tvclin.plots.root_locus import LocusPoles

mpl.use("Agg")

PLANT = booster()
SAMPLED = replace(AUTOPILOT, sample_rate=25.0)
HALF = 25.0 * np.pi
RIGID = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
HELD = tv.Autopilot(attitude_gain=0.5, rate_gain=0.5, actuator=tv.Actuator(), delay=0.05)
CASES = {
    "flexible": (AUTOPILOT, PLANT),
    "sampled": (SAMPLED, PLANT),
    "rigid, sampled": (replace(HELD, sample_rate=10.0), RIGID),
}
MODES = ("bending 1", "bending 2", "bending 3", "slosh 1", "slosh 2")


@pytest.fixture(autouse=True)
def no_figure_stays_open():
    yield
    import matplotlib.pyplot as plt

    plt.close("all")


@pytest.fixture(scope="module", autouse=True)
def no_figure_is_kept():
    yield
    chart_of.cache_clear()


@cache
def chart_of(name, chart):
    """Return a figure of a case that tests only look at."""
    return chart(*CASES[name])


def marks(plot, panel=0):
    """Return the words and places of all marks of one panel."""
    computed = [line for line in plot.lines.flat[panel] if line.get_marker() not in {"None", ""}]
    return {line.get_label(): tuple(float(v[0]) for v in line.get_data()) for line in computed}


def marked(plot, start, panel=0):
    return next(place for words, place in marks(plot, panel).items() if words.startswith(start))


@pytest.mark.thorough
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("chart", [plots.nichols_chart, plots.bode_chart])
def test_the_curve_is_the_loop_with_its_modes(name, chart):
    autopilot, plant = CASES[name]
    loop, curves = autopilot.exact_loop(plant), chart_of(name, chart).curves
    omega = curves.abscissa
    size, phase = curves.column("magnitude", "magnitude"), curves.column("phase", "phase")

    drawn = 10.0 ** (size / 20.0) * np.exp(1j * np.radians(phase))
    np.testing.assert_allclose(drawn, loop.response(omega), rtol=1e-9)
    turns = np.angle(drawn[1:] / drawn[:-1])
    assert np.abs(turns[np.abs(drawn[1:]) > 1e-3]).max() < np.radians(10.0)  # also at modes
    if autopilot.sample_rate is not None:
        assert omega[-1] <= np.pi * autopilot.sample_rate
        assert omega[-1] > 0.9 * np.pi * autopilot.sample_rate


@pytest.mark.thorough
@pytest.mark.parametrize("name", usual(["flexible", "sampled"], 0))
def test_each_mode_is_marked_where_it_peaks_with_its_margin(name):
    autopilot, _ = CASES[name]
    bands = autopilot.band_margins(PLANT)
    bode, nyquist = (chart_of(name, draw) for draw in (plots.bode_chart, plots.nyquist_chart))
    texts = [text.get_text() for text in bode.axes[0, 0].texts]

    for mode in bands.modes:
        frequency, size = marked(bode, f"{mode.name} at ")
        value = complex(autopilot.frequency_response(PLANT, frequency))
        assert size == pytest.approx(20.0 * np.log10(abs(value)), abs=1e-9)
        assert complex(*marked(nyquist, f"{mode.name} at ")) == pytest.approx(value, rel=1e-9)
        if mode.stabilised == "gain":
            assert (frequency, size) == pytest.approx((mode.peak_frequency, mode.peak_dB))
            assert f"{mode.name}, {-mode.peak_dB:.2f} dB" in texts
        elif mode.stabilised == "phase":
            assert frequency == pytest.approx(mode.peak_frequency)
            assert f"{mode.name}, {mode.phase_margin_deg:.2f} deg" in texts
        else:
            assert frequency == pytest.approx(abs(np.imag(mode.pole)))
            assert mode.name in texts
    peak = bode.curves.column("magnitude", "magnitude").max()
    assert peak == pytest.approx(bands.mode("bending 1").peak_dB, abs=1e-9)
    at = bands.margins.gain_increase_frequency, -bands.margins.gain_increase_dB
    assert marked(bode, "gain may rise") == pytest.approx(at)


@pytest.mark.thorough
def test_an_unstable_loop_shows_the_names_of_its_modes_and_no_margins():
    plot = plots.bode_chart(replace(AUTOPILOT, filters=()), PLANT)
    upper, lower = ([text.get_text() for text in axes.texts] for axes in plot.axes[:, 0])

    assert (sorted(upper), lower) == (sorted(MODES), [])
    assert any(words.endswith("rad/s: unstable") for words in marks(plot))


@pytest.mark.thorough
@pytest.mark.parametrize("name", CASES)
def test_nyquist_turns_as_often_as_the_poles_say(name):
    autopilot, plant = CASES[name]
    loop = autopilot.exact_loop(plant)
    plot = chart_of(name, plots.nyquist_chart)
    curves = plot.curves
    values = curves.column("real part") + 1j * curves.column("imaginary part")

    above = curves.abscissa > 0.0
    np.testing.assert_allclose(values[above], loop.response(curves.abscissa[above]), rtol=1e-6)
    if autopilot.sample_rate is None:
        unstable = int(np.sum(loop.poles.real > 0.0))
    else:
        unstable = int(np.sum(np.abs(loop.poles) > 1.0))
    assert autopilot.margins(plant).stable
    heading = plot.figure.get_suptitle()
    assert f": {unstable} counterclockwise encirclement" in heading
    assert f", {unstable} unstable open-loop pole" in heading


@pytest.mark.thorough
def test_criteria_of_modes_are_judged_in_the_title():
    for limit, words in ((10.0, "criteria bands MET"), (18.0, "criteria bands NOT MET")):
        criteria = tv.control.Criteria.custom(
            "bands", mode_gain_margin_dB=limit, phase_margin_deg=30.0
        )
        plot = plots.nichols_chart(AUTOPILOT, PLANT, criteria)
        assert words in plot.axes[0, 0].get_title()


@pytest.mark.parametrize(
    "chart",
    usual([plots.nichols_chart, plots.bode_chart, plots.nyquist_chart, plots.root_locus_chart], 0),
)
def test_a_loop_is_drawn_without_its_plant(chart):
    loop = HELD.exact_loop(RIGID)
    single, beside = chart(loop).curves, chart(HELD, RIGID).curves

    np.testing.assert_allclose(single.abscissa[[0, -1]], beside.abscissa[[0, -1]], rtol=1e-6)
    assert single.parameters.startswith("loop of order ")
    with pytest.raises(tv.InputError, match="plant must be left out"):
        chart(loop, RIGID)
    with pytest.raises(tv.InputError, match=r"draws one loop; got a batch of shape \(2,\)"):
        chart(tv.Loop([1.0], [[1.0, 1.0], [1.0, 2.0]]))


@pytest.mark.thorough
def test_the_root_locus_of_a_sampled_loop_follows_its_discrete_poles():
    """S = ln(z)/h: at factor one the poles of the closed loop, at the margin one on the axis."""
    loop, margins = SAMPLED.exact_loop(PLANT), SAMPLED.margins(PLANT)
    plot = plots.root_locus_chart(SAMPLED, PLANT, [0.0, 1.0, margins.gain_increase])
    locus, h = columns(plot), float(loop.period)
    close = loop.closed_loop_poles
    known = close[np.abs(close) > 1e-3]  # an old command may be nothing, far to the left
    apart = np.abs(np.exp(locus[1] * h)[:, np.newaxis] - known)
    np.testing.assert_allclose(apart.min(axis=0), 0.0, atol=1e-9)
    at = 1j * margins.gain_increase_frequency
    assert np.abs(locus[2] - at).min() < 1e-6 * abs(at)
    assert locus.imag.max() <= np.pi / h * (1.0 + 1e-12)
    assert "s = ln(z)/h" in plot.figure.get_suptitle()


@pytest.mark.thorough
@pytest.mark.parametrize("rate_gain", [2.5, 4.5])
def test_the_root_locus_numbers_the_pole_of_a_real_negative_z_without_a_conjugate(rate_gain):
    ideal = tv.Autopilot(attitude_gain=0.6, rate_gain=rate_gain, sample_rate=5.0)
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    plot = plots.root_locus_chart(ideal, plant, [0.0, 1.0])
    z = ideal.exact_loop(plant).closed_loop_poles
    (single,) = z[z.real < 0.0].real
    words = {drawn.get_text() for drawn in plot.axes[0, 0].texts}
    assert f"{5.0 * np.log(-single):.3g} + {5.0 * np.pi:.3g}j" in words


@pytest.mark.thorough
def test_steps_and_winds_of_a_flexible_loop_are_drawn():
    wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    drawn = plots.wind_chart(AUTOPILOT, PLANT, wind).curves
    value, _ = AUTOPILOT.wind_response(PLANT, wind).peak("deflection")
    values = drawn.column("deflection", "deflection")
    assert np.abs(values).max() == pytest.approx(abs(np.degrees(value)), rel=1e-9)
    step = plots.step_chart(AUTOPILOT, PLANT).curves
    fastest = np.abs(PLANT.poles).max()
    assert np.diff(step.abscissa).max() * fastest < 2.0 * np.pi / 4.0
    with pytest.raises(tv.InputError, match="sample"):
        plots.step_chart(SAMPLED, PLANT)


@pytest.mark.thorough
def test_the_root_locus_follows_each_mode_to_its_closed_pole():
    plot = plots.root_locus_chart(AUTOPILOT, PLANT)
    curves, bands = plot.curves, AUTOPILOT.band_margins(PLANT)
    one = np.searchsorted(curves.abscissa, 1.0)

    assert curves.abscissa[one] == 1.0
    for mode in bands.modes:
        branch = curves.column(f"{mode.name} real part")
        branch = branch + 1j * curves.column(f"{mode.name} imaginary part")
        assert branch[0] == pytest.approx(mode.pole, abs=1e-9 * 120.0)
        # a Pade approximation of order 4 errs by 4!^2/(8! 9!) (w T)^9 = 4e-7 of L at 65 rad/s
        assert branch[one] == pytest.approx(mode.closed_pole, abs=1e-6 * abs(mode.pole))
        assert np.abs(np.diff(branch)).max() < 0.05 * abs(mode.pole)
        assert marked(plot, "modes in the vehicle", panel=-1)
    names = [text.get_text() for text in plot.axes[0, -1].texts]
    assert set(MODES) <= set(names)


def test_poles_that_meet_are_drawn_through_the_point_where_they_meet():
    # k (s + 2)/(s (s + 1)): a circle of radius sqrt 2 around the zero, crossed at -2 +- sqrt 2
    loop = tv.Loop([1.0, 2.0], [1.0, 1.0, 0.0])
    plot = plots.root_locus_chart(loop, gains=None)
    locus = columns(plot)

    for meeting, gain in ((-2.0 + 2.0**0.5, 3.0 - 8.0**0.5), (-2.0 - 2.0**0.5, 3.0 + 8.0**0.5)):
        row = np.argmin(np.abs(plot.curves.abscissa - gain))
        assert plot.curves.abscissa[row] == pytest.approx(gain, rel=1e-12)
        # the poles of a double root move with the root of the rounding
        np.testing.assert_allclose(locus[row], meeting, atol=1e-6)
    complex_ones = locus[np.abs(locus.imag) > 0.0]
    np.testing.assert_allclose(np.abs(complex_ones + 2.0), 2.0**0.5, rtol=1e-9)
    middles = 0.5 * (locus[1:] + locus[:-1])[np.abs(locus[1:].imag) > 0.0]
    assert np.abs(np.abs(middles + 2.0) - 2.0**0.5).max() < 2e-3  # no corner is cut


def test_the_matrices_of_a_loop_have_the_locus_of_its_polynomials():
    poles, zeros = [-1.0, -3.0 + 20.0j, -3.0 - 20.0j, 0.4], [-2.0]
    below, above = np.poly(poles).real, 300.0 * np.poly(zeros).real
    rational = tv.Loop(above, below, delay=0.03)
    A = np.eye(4, k=1)
    A[-1] = -below[:0:-1]
    C = np.pad(above, (2, 0))[np.newaxis, ::-1]
    state = tv.Loop.from_matrices(A, np.eye(4)[:, -1:], C, delay=0.03)
    computed = [LocusPoles.of(loop, 4) for loop in (rational, state)]

    for name in ("poles", "zeros"):
        one, other = (np.sort_complex(getattr(locus, name)) for locus in computed)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-8 * 120.0)
    one, other = (np.sort_complex(locus.closed(np.array([0.7]))[0]) for locus in computed)
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-8 * 120.0)


def columns(plot):
    numbers = [column.values for column in plot.curves.columns]
    return np.stack([re + 1j * im for re, im in zip(numbers[::2], numbers[1::2], strict=True)], -1)
