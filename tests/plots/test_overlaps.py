"""Figures can be read: no two texts of one on top of each other, and none beyond its edge."""

from dataclasses import replace
from itertools import combinations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.text import Text

import tvclin as tv
from tests.archives import Balloon, days, jet, write
from tests.turns import usual
from tvclin import plots
from tvclin.linear.plant import Plant
from tvclin.show.report.page import narrow
from tvclin.show.reproduce import FIGURES

mpl.use("Agg")

WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
TOUCH = 1.0
"""Boxes of letters hold a little air: so many points of two may be in common."""
VEHICLES = ("configuration-i", "made-up-launcher")
FILTERS = (tv.vehicle.Filter.low_pass(13.0, 0.95), tv.vehicle.Filter.notch(32.0, 0.06, 0.6))
PAGE, WHOLE = "on the page", "alone"
ON_THE_PAGE = ("study", "response on the boundary", "comparison", "nichols", "bode", "sizing")
WIDE, HIGH = 1024.0, 10.0
"""A figure so many pixels wide has letters of so many at least."""


@pytest.fixture(autouse=True)
def no_figure_stays_open(as_users_have_it):
    yield
    plt.close("all")


def rigid(vehicle):
    return Plant.from_vehicle(vehicle, "drift-exact").rigid


def autopilot(vehicle):
    if vehicle.structure is not None and vehicle.structure.bending:
        servo = tv.Actuator(natural_frequency=22.0, damping=0.8)
        gains = tv.Autopilot(attitude_gain=0.36, rate_gain=0.56, delay=0.02, actuator=servo)
        return replace(gains, filters=FILTERS)
    return tv.design_gains(
        rigid(vehicle).coefficients, natural_frequency=1.5, damping=0.7, actuator=tv.Actuator()
    )


def loop(draw):
    return lambda vehicle: draw(
        autopilot(vehicle), tv.linear.plant_of(vehicle, "drift-exact", "pitch")
    )


def study(vehicle, **options):
    return tv.Study.from_vehicle(
        vehicle, duration=7.5, peak=WIND.peak, limit=np.radians(0.8), **options
    )


def response(vehicle, factor):
    plant, K = rigid(vehicle), 0.5
    limit = factor * tv.boundary_limit(plant, WIND, K).deflection
    constant = tv.trim_then_hold(plant, WIND, limit, K)
    result = tv.attitude_response(plant, constant, WIND, np.linspace(0.0, 15.0, 301))
    return plots.response_chart(result, f"{vehicle.name}: response", limit=abs(limit))


def flight(vehicle):
    planar = tv.flights.ReportControl()
    times = np.linspace(0.0, 12.0, 61)
    flown = tv.flights.compare_flight(vehicle, planar, WIND, times, deflection_limit=0.03)
    curves = plots.flight_curves(flown, 0.03, "fly", vehicle.name)
    return plots.flight_chart(curves, f"{vehicle.name}\nflown")


def sizing(vehicle):
    name = next(name for name in VEHICLES if tv.load_vehicle(name).name == vehicle.name)
    flown = tv.load_schedule(name, start=50.0, stop=90.0, step=10.0)
    return plots.sizing_chart(tv.size(flown, WIND), limit=np.radians(1.0))


def attitude_and_rate(vehicle):
    return tv.SaturatedLaw(replace(autopilot(vehicle), actuator=None, delay=0.0, filters=()))


def flown_margins(vehicle):
    law, flown = attitude_and_rate(vehicle), []
    for limit in (0.03, 0.045):
        rate = {"sample_rate": 50.0, "actuator": tv.Actuator()}
        flown.append(tv.flights.flown_margins(rigid(vehicle), law, WIND, limit=limit, **rate))
    return plots.flown_margins_chart(flown)


def boundary_map(vehicle):
    law, gains = attitude_and_rate(vehicle), np.geomspace(0.5, 2.0, 7)
    delays = np.linspace(0.0, 0.4, 5)
    result = tv.flights.boundary_map(rigid(vehicle), law, WIND, gains, delays, sample_rate=20.0)
    return plots.boundary_map_chart(result, limit=0.02)


def least_gains(vehicle):
    design = tv.minimum_deflection_gains(rigid(vehicle), WIND, actuator=tv.Actuator(), delay=0.02)
    return plots.gain_trade_off_chart([tv.design.gain_trade_off(design, [0.6, 0.8, 1.0])])


CHARTS = {
    "study": lambda vehicle: plots.study_chart(study(vehicle)),
    "boundary": lambda vehicle: plots.boundary_chart(coefficients=rigid(vehicle).coefficients),
    "poles": lambda vehicle: plots.pole_map(rigid(vehicle).coefficients),
    "response on the boundary": lambda vehicle: response(vehicle, 1.0),
    "response of a lost vehicle": lambda vehicle: response(vehicle, 0.9),
    "comparison": lambda vehicle: plots.comparison_chart(
        tv.compare_with_trim(rigid(vehicle), autopilot(vehicle), WIND)
    ),
    "laws": lambda vehicle: plots.laws_chart(rigid(vehicle), {}, WIND.peak, np.array([2.0, 4.0])),
    "nichols": loop(plots.nichols_chart),
    "bode": loop(plots.bode_chart),
    "nyquist": loop(plots.nyquist_chart),
    "root locus": loop(plots.root_locus_chart),
    "step": loop(plots.step_chart),
    "wind": loop(lambda one, plant: plots.wind_chart(one, plant, WIND)),
    "sizing": sizing,
    "vehicle": lambda vehicle: plots.vehicle_chart(vehicle, np.radians(5.0)),
    "flight": flight,
    "loads": lambda vehicle: plots.load_chart(
        tv.boundary.load_trade_off(
            rigid(vehicle), WIND, limit=np.radians(0.8), load=np.radians(3.0)
        )
    ),
    "rates": lambda vehicle: plots.rate_chart(
        tv.boundary.rate_trade_off(rigid(vehicle), WIND, limit=np.radians(0.8), rate_limit=0.05)
    ),
    "planes": lambda vehicle: plots.plane_chart(
        rigid(vehicle), tv.winds.PlaneWind.veering(WIND, angle=0.4, rate=0.2), "round"
    ),
    "planes of a study": lambda vehicle: plots.study_planes_chart(
        study(vehicle, heading=1.0, limit_shape="square")
    ),
    "flown margins": flown_margins,
    "boundary map": boundary_map,
    "least gains": least_gains,
    "spectra": loop(
        lambda one, plant: plots.spectrum_chart(
            tv.control.turbulence_covariance(one, plant, tv.winds.Turbulence(6.0), 540.0)
        )
    ),
}


def seen_texts(figure):
    """Return the texts that are drawn, with the boxes of their letters in points."""
    figure.draw_without_rendering()
    apart = [
        label
        for axes in figure.axes
        for axis in (axes.xaxis, axes.yaxis)
        for tick in (*axis.majorTicks, *axis.minorTicks)
        for label in (tick.label1, tick.label2)
        if not (tick.get_visible() and inside(axis, tick))
    ]
    computed = []
    for text in figure.findobj(Text):
        drawn = text.get_visible() and text.get_text().strip() and text not in apart
        if drawn and (text.axes is None or text.axes.axison):
            box = Text.get_window_extent(text)  # of an annotation without its line
            computed.append((text.get_text(), box.transformed(figure.dpi_scale_trans.inverted())))
    return computed


def inside(axis, tick):
    low, high = sorted(axis.get_view_interval())
    room = 1e-9 * (high - low)
    return low - room <= tick.get_loc() <= high + room


def overlaps(figure):
    """Return the pairs of texts on top of each other, and what is beyond the edge."""
    touch, (width, height) = TOUCH / 72.0, figure.get_size_inches()
    texts = seen_texts(figure)
    computed = [
        (one, other)
        for (one, a), (other, b) in combinations(texts, 2)
        if min(a.x1, b.x1) - max(a.x0, b.x0) > touch and min(a.y1, b.y1) - max(a.y0, b.y0) > touch
    ]
    beyond = [
        one for one, box in texts if min(box.x0, box.y0, width - box.x1, height - box.y1) < -touch
    ]
    return computed, beyond


def legible(plot, size):
    if size == PAGE:
        narrow(plot)
    computed, beyond = overlaps(plot.figure)
    assert not computed
    assert not beyond
    minimum = min(text.get_fontsize() for text in plot.figure.findobj(Text) if text.get_text())
    assert minimum / 72.0 * WIDE / plot.figure.get_figwidth() >= HIGH


CASES = [(name, vehicle, WHOLE) for vehicle in VEHICLES for name in CHARTS]
CASES += [(name, vehicle, PAGE) for vehicle in VEHICLES for name in ON_THE_PAGE]


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "vehicle", "size"), usual(CASES, 5, 57))
def test_no_two_texts_of_a_chart_are_on_top_of_each_other(name, vehicle, size):
    legible(CHARTS[name](tv.load_vehicle(vehicle)), size)


@pytest.mark.thorough
@pytest.mark.parametrize("azimuth", [1.5, [1.0, 1.5]], ids=["one azimuth", "two azimuths"])
@pytest.mark.parametrize("size", [WHOLE, PAGE])
def test_no_two_texts_of_an_availability_are_on_top_of_each_other(azimuth, size, tmp_path):
    every = days("2023-02-24T00", 20)
    balloons = [Balloon(time, jet(5.0 * (i + 1))) for i, time in enumerate(every)]
    soundings = tv.read_soundings(write(tmp_path / "s-data.txt", balloons))
    flight = tv.load_schedule("configuration-i")
    result = tv.availability(flight, soundings, limit=0.006, azimuth=azimuth)
    legible(plots.availability_chart(result), size)


@pytest.mark.parametrize("name", usual(FIGURES, 0))
def test_no_two_texts_of_a_figure_of_the_report_are_on_top_of_each_other(name):
    legible(FIGURES[name](), WHOLE)


def test_texts_on_top_of_each_other_are_found():
    figure, axes = plt.subplots()
    axes.text(0.5, 0.5, "one")
    axes.text(0.51, 0.5, "other")
    axes.text(0.99, 0.2, "beyond the edge of the figure")
    assert overlaps(figure) == ([("one", "other")], ["beyond the edge of the figure"])
