"""A flight from the pad to burnout: every flight time has an answer, or a reason."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eig

import tvclin as tv
from tests.small_launcher import sounding, write
from tests.turns import usual
from tvclin.ascent.measured_wind import FlightWind
from tvclin.requirement.flight import flight_requirement as flight_mode
from tvclin.requirement.flight.flight_requirement import FlightMode
from tvclin.studyfile.parse import parse_study
from tvclin.time_varying.requirements import FLIGHT_SUBSTEPS, SteppedWinds
from tvclin.time_varying.steps import encountered_at_steps

EAST = np.radians(90.0)


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    return tv.load_schedule(write(tmp_path_factory.mktemp("pad") / "pad.csv"))


@pytest.mark.thorough
def test_a_row_that_stands_still_is_left_out_and_said(flight) -> None:
    assert flight.span == (0.5, 122.0)
    assert flight.notes == ("the vehicle does not move before line 2, after which it begins",)


def costates(flight, model, times):
    """Return costate of length one and control reach at falling times [s], by LSODA."""
    t = flight.span[1]
    y = FlightMode(flight, model, "pitch", flight.span).costates_and_reaches(t)[:-1]

    def rates(t, y):
        A, inputs = (x.squeeze() for x in flight.plants(t, model, "pitch").matrices()[:2])
        return np.append(-y[:-1] @ A, -y[:-1] @ inputs[:, 0])

    for time in times:
        for knot in [*flight.times[(flight.times > time) & (flight.times < t)][::-1], time]:
            y = solve_ivp(rates, (t, knot), y, "LSODA", rtol=1e-9, atol=1e-12).y[:, -1]
            y, t = y / np.linalg.norm(y[:-1]), knot
        yield y


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact", "drift-and-speed"], 1))
def test_costate_and_reach_are_those_of_the_adjoint_equation(flight, model) -> None:
    """Also through the first seconds, in which two modes oscillate together."""
    part = tv.FlightSchedule(flight.at([4.0, 8.0, 15.0, 30.0, 45.0, 60.0]))
    mode = FlightMode(part, model, "pitch", part.span)
    times = (30.0, 8.0, 4.0)
    for time, exact in zip(times, costates(part, model, times), strict=True):
        *costate, reach, _absolute = mode.costates_and_reaches(time)
        assert costate == pytest.approx(exact[:-1], abs=1e-6)
        assert reach == pytest.approx(exact[-1], rel=1e-6)


@pytest.mark.thorough
def test_the_march_along_a_flight_is_of_fourth_order(flight, monkeypatch) -> None:
    """Half the step, a sixteenth of the error, within the third that the next order adds."""
    part = tv.FlightSchedule(flight.at([20.0, 40.0]))
    (exact,) = costates(part, "drift-exact", (20.25,))
    errors = []
    for step in (0.4, 0.2, 0.1):
        monkeypatch.setattr(flight_mode, "_STEP_OVER_TIME_CONSTANT", step)
        mode = FlightMode(part, "drift-exact", "pitch", part.span)
        errors.append(np.abs(mode.costates_and_reaches(20.25)[:-1] / exact - 1.0).max())
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 16.0, rtol=1 / 3)


@pytest.mark.thorough
def test_constant_parameters_have_the_left_eigenvector_at_all_times(configuration_i) -> None:
    """Over six hundred time constants, in which the costate falls by more than all numbers."""
    constant = tv.FlightSchedule(configuration_i.replace(time=[0.0, 1500.0]))
    mode = FlightMode(constant, "drift-exact", "pitch", constant.span)
    A, inputs, *_ = constant.plants(0.0, "drift-exact", "pitch").matrices()
    values, rows = eig(A, left=True, right=False)
    row = np.real(rows[:, np.argmax(values)])
    row = row * np.sign(row[1]) / np.linalg.norm(row)
    for time in (0.0, 700.3, 1500.0):
        *costate, reach, _absolute = mode.costates_and_reaches(time)
        np.testing.assert_allclose(costate, row, rtol=1e-12, atol=1e-12)
        assert reach == pytest.approx(row @ inputs[:, 0] / values.real.max(), rel=2e-6)


@pytest.mark.thorough
def test_steep_winds_are_not_known_and_every_other_time_is_sized(flight) -> None:
    encountered = tv.fly_through(sounding(), flight, azimuth=EAST)
    sizing = tv.size(flight, encountered, times=[0.5, 20.0, 60.0, 122.0], varying=True)

    first = encountered.known[0]
    speed = np.interp(first, flight.times, flight.speed)
    wind = sounding().in_plane(EAST)
    blows = np.interp(np.interp(first, flight.times, flight.height), sounding().height, wind)
    assert 0.3 < abs(blows) / speed <= 0.5  # not above 30 deg, and just below it
    assert "of which linear aerodynamics says nothing" in sizing.notes[0]
    for name in ("K = 1", "K = 1, varying"):
        assert np.isnan(sizing.required[name][0, 0])
        assert np.all(sizing.required[name][1:, 0] > 0.0)


def diverge(flight, wind, limits):
    """Return whether the trim law diverges with limits [rad], by an own integration."""
    step = 5e-3
    times = np.arange(*flight.span, step)
    plant = tv.Plant.from_vehicle(flight.clamped_at(times), "drift-exact")
    A, inputs, _, _ = plant.matrices()
    angle = wind(times)
    stiff = np.sqrt(np.abs(A[:, 1, 0]))
    x = np.zeros((limits.size, A.shape[-1]))
    back = 10.0 * np.abs(A[:, 1, 0]) / inputs[:, 1, 0]
    for k in range(times.size - 1):
        trim = -(x @ A[k, 1] + inputs[k, 1, 1] * angle[k]) / inputs[k, 1, 0]
        command = trim - back[k] * (x[:, 0] + x[:, 1] / stiff[k])
        delta = np.clip(command, -limits, limits)
        rates = x @ A[k].T + np.outer(delta, inputs[k, :, 0]) + angle[k] * inputs[k, :, 1]
        x = x + step * rates
    mode = FlightMode(flight, "drift-exact", "pitch", flight.span)
    *row, reach, _absolute = mode.costates_and_reaches(times[-1])
    return (np.abs(x @ row) > limits * abs(reach)).tolist()


@pytest.mark.thorough
def test_the_whole_flight_needs_what_flights_along_it_need(flight) -> None:
    """The trim law is flown by an own integration, at 0.95 and 1.02 of what is said."""
    encountered = tv.fly_through(sounding(), flight, azimuth=EAST)
    need = tv.size(flight, encountered, times=[60.0], varying=True).required["K = 1, varying"][0, 0]
    assert diverge(flight, encountered.wind, need * np.array([0.95, 1.02])) == [True, False]


@pytest.mark.thorough
def test_flights_decide_after_a_while_in_which_two_modes_are_a_pair(flight) -> None:
    """They are a pair until 19 s; then a limited flight drifts further than one in trim."""
    wind = tv.RectangularWind(peak=np.radians(4.0), duration=20.0)
    need = tv.size(flight, wind, times=[20.0], varying=True).required["K = 1, varying"][0, 0]
    placed = wind.shift(10.0)
    assert diverge(flight, placed, need * np.array([0.995, 1.005])) == [True, False]


def archive(*strengths):
    days = np.datetime64("2024-02-01T00") + 24 * np.arange(len(strengths))
    return tv.winds.Soundings.from_profiles([sounding(s) for s in strengths], days)


PITCH = {"limit": np.radians(4.0), "azimuth": EAST, "plane": "pitch"}


@pytest.mark.thorough
def test_each_sounding_is_judged_from_where_its_wind_is_not_too_steep(flight) -> None:
    result = tv.availability(flight, archive(1.0, 0.6, 1.3), **PITCH)
    assert result.fraction().flown == 3
    assert result.judged[1, 0] < result.judged[0, 0] < result.judged[2, 0]
    (note,) = (one for one in result.notes if "30 deg" in one)
    assert "3 of 3 soundings" in note
    encountered = tv.fly_through(sounding(), flight, azimuth=EAST)
    assert encountered.known[0] == pytest.approx(
        result.judged[0, 0], abs=0.51
    )  # a row of the schedule
    single = tv.size(flight, encountered, times=[60.0], varying=True).required["K = 1, varying"][
        0, 0
    ]
    assert result.lower[0] == pytest.approx(single, rel=1e-3)


ARMS = {
    "stable at first": ([0, 25, 35, 122], [-0.5, 0.0, 4.0, 3.0]),
    "nearly no moment between": ([0, 40, 50, 60, 70, 122], [3.0, 3.0, 0.005, 0.005, 3.0, 3.0]),
    "stable between": ([0, 40, 50, 60, 70, 122], [3.0, 3.0, -1.0, -1.0, 3.0, 3.0]),
    "stable at the end": ([0, 70, 80, 122], [3.0, 3.0, -1.0, -1.0]),
}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "middle"),
    usual([("stable at first", t) for t in (22.0, 23.4, 24.0, 25.5)], 1)
    + usual([("nearly no moment between", t) for t in (50.0, 52.0, 53.0, 57.0)], 1),
)
def test_trim_long_after_a_wind_of_which_the_vehicle_feels_little_counts(
    flight, name, middle
) -> None:
    """The path that the wind turned needs more trim where the arm has grown than in the wind."""
    arm = np.interp(flight.times, *ARMS[name])
    turned = tv.FlightSchedule(flight.vehicle.replace(aerodynamic_arm=arm), altitude=flight.height)
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    need = tv.size(turned, wind, times=[middle], varying=True).required["K = 1, varying"][0, 0]
    placed = wind.shift(middle - 3.75)
    assert diverge(turned, placed, need * np.array([0.99, 1.01])) == [True, False]


@pytest.mark.parametrize("name", usual([name for name in ARMS if "stable" in name], 2))
def test_stable_parts_of_a_flight_are_flown_through(flight, name) -> None:
    """With a little more than is needed the trim law survives the whole of it."""
    arm = np.interp(flight.times, *ARMS[name])
    turned = tv.FlightSchedule(flight.vehicle.replace(aerodynamic_arm=arm), altitude=flight.height)
    for interval in turned.one_sign_intervals:
        assert np.all(np.diff(np.sign(interval.vehicle.aerodynamic_arm[1:-1])) == 0)
    height, coarse = np.arange(0.0, 49e3, 1e3), sounding()  # without gaps of more than two km
    east, north = (np.interp(height, coarse.height, x) for x in (coarse.east, coarse.north))
    profile = tv.WindProfile(height=height, east=east, north=north)
    soundings = tv.winds.Soundings.from_profiles([profile], ["2024-02-01"])
    encountered = tv.fly_through(profile, turned, azimuth=EAST)
    sized = tv.size(turned, encountered, times=[60.0], varying=True).required["K = 1, varying"]
    for ratio in (0.99, 1.01):
        result = tv.availability(turned, soundings, **PITCH | {"limit": ratio * sized.item()})
        assert result.flies[0] == (ratio > 1.0)
        assert "aerodynamic moment changes its sign" in " ".join(result.notes)
    mode = FlightMode(turned, "drift-exact", "pitch", turned.span)
    motion, wind = mode, FlightWind(encountered.wind, "pitch", encountered.speeds)
    steps = encountered_at_steps(motion, wind, FLIGHT_SUBSTEPS)
    flights = SteppedWinds(motion.at_steps(steps[0]), *steps)
    assert not flights.diverge(sized * np.array([[1.02, 1.2, 2.0]])).any()


def test_a_flight_in_which_nothing_grows_needs_nothing(flight) -> None:
    stable = tv.FlightSchedule(flight.vehicle.replace(aerodynamic_arm=-1.0), altitude=flight.height)
    result = tv.availability(stable, archive(1.0), model="fixed-path", **PITCH)
    assert result.lower.tolist() == [0.0]
    assert "no mode is unstable" in result.notes[0]


@pytest.mark.thorough
def test_a_flight_without_any_moment_for_a_while_is_followed(flight) -> None:
    """As with a hundredth of a millimetre in its place."""
    needs = []
    for minimum in (0.0, 1e-5):
        arm = np.where(flight.times < 30.0, minimum, 3.0)
        some = tv.FlightSchedule(
            flight.vehicle.replace(aerodynamic_arm=arm), altitude=flight.height
        )
        encountered = tv.fly_through(sounding(), some, azimuth=EAST)
        sized = tv.size(some, encountered, times=[20.0, 60.0], varying=True)
        assert np.all(sized.required["K = 1"] >= 0.0)
        needs.append(
            [
                sized.required["K = 1, varying"][1, 0],
                tv.availability(some, archive(1.0), **PITCH).lower[0],
            ]
        )
    assert needs[0] == pytest.approx(needs[1], rel=1e-4)
    assert needs[0][0] == pytest.approx(needs[0][1], rel=1e-3)


def test_part_of_a_schedule_is_the_schedule_between_two_times(flight) -> None:
    part = flight.between(10.25, 60.0)
    assert part.span == (10.25, 60.0)
    times = np.array([10.25, 33.3, 60.0])
    assert part.at(times).velocity == pytest.approx(flight.at(times).velocity, rel=1e-12)
    assert np.interp(times, part.times, part.height) == pytest.approx(
        np.interp(times, flight.times, flight.height)
    )
    with pytest.raises(tv.InputError, match="start must lie before stop"):
        flight.between(60.0, 10.0)


def test_files_without_a_date_can_be_taken_in_their_order(tmp_path) -> None:
    for name in "abc":
        (tmp_path / f"{name}.csv").write_text(
            "height_m,speed_m_per_s,direction_deg\n0,5,270\n1000,9,270\n30000,20,270\n"
        )
    with pytest.raises(tv.InputError, match="--set availability.in_order true"):
        tv.read_soundings(tmp_path)
    soundings = tv.read_soundings(tmp_path, in_order=True)
    assert [str(time)[:10] for time in soundings.times] == [
        "2000-01-01",
        "2000-01-02",
        "2000-01-03",
    ]
    assert "3 files without a date" in soundings.notes[0]
    dates = tmp_path / "dates.csv"
    dates.write_text("file,time\na.csv,2024-02-03T12\nb.csv,2024-02-01T00\nc.csv,2024-02-02\n")
    listed = tv.read_soundings(tmp_path, dates=dates)
    assert [str(time)[:10] for time in listed.times] == ["2024-02-01", "2024-02-02", "2024-02-03"]
    dates.write_text("name,day\na.csv,2024-02-03\n")
    with pytest.raises(tv.InputError, match="no line of names file,time"):
        tv.read_soundings(tmp_path, dates=dates)
    dates.unlink()
    document = {
        "study": {"vehicle": "configuration-i"},
        "wind": {"peak_deg": 5.0, "duration_s": 7.5},
        "availability": {"archive": ".", "azimuth_deg": 90, "in_order": True},
    }
    request = parse_study(document, tmp_path).availability
    assert np.array_equal(request.soundings.times, soundings.times)
