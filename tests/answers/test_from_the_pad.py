"""A flight from the pad to burnout: every flight time has an answer, or a reason."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.small_launcher import sounding, write
from tvclin.answers.sizing.growing import GrowingMode

EAST = np.radians(90.0)


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    return tv.load_schedule(write(tmp_path_factory.mktemp("pad") / "pad.csv"))


def test_a_row_that_stands_still_is_left_out_and_said(flight) -> None:
    assert flight.span == (0.5, 122.0)
    assert flight.notes == ("the vehicle does not move before line 2, after which it begins",)


def test_the_growing_direction_is_that_of_the_adjoint_equation(flight) -> None:
    """Also through the first seconds, in which two modes swing together."""
    mode = GrowingMode(flight, "drift-exact", "pitch", flight.span)
    start, stop = 4.0, 60.0
    end, reach = mode.at(stop)
    order = end.size

    def rates(t, y):
        A, inputs = mode.matrices(t)
        p, _ = y[:-1], y[-1]
        return np.append(-p @ A, -p @ inputs[:, 0])

    found = solve_ivp(
        rates, (stop, start), [*end, reach], "Radau", rtol=1e-9, atol=1e-12, t_eval=[30, 8, start]
    ).y
    for k, t in enumerate((30.0, 8.0, start)):
        row, held = mode.at(t)
        length = np.linalg.norm(found[:order, k])
        assert found[:order, k] / length == pytest.approx(row, abs=1e-6)
        assert found[order, k] / length == pytest.approx(held, rel=1e-6)


def test_steep_winds_are_not_known_and_every_other_time_is_sized(flight) -> None:
    met = tv.fly_through(sounding(), flight, azimuth=EAST)
    found = tv.size(flight, met, times=[0.5, 20.0, 60.0, 122.0], varying=True)

    first = met.known[0]
    speed = np.interp(first, flight.times, flight.speed)
    wind = sounding().in_plane(EAST)
    blows = np.interp(np.interp(first, flight.times, flight.height), sounding().height, wind)
    assert 0.3 < abs(blows) / speed <= 0.5  # not above 30 deg, and just below it
    assert "of which linear aerodynamics says nothing" in found.notes[0]
    for name in ("K = 1", "K = 1, varying"):
        assert np.isnan(found.required[name][0, 0])
        assert np.all(found.required[name][1:, 0] > 0.0)


def test_the_whole_flight_needs_what_flights_along_it_need(flight) -> None:
    """The trim law is flown by an own integration, at 0.95 and 1.02 of what is said."""
    met = tv.fly_through(sounding(), flight, azimuth=EAST)
    need = tv.size(flight, met, times=[60.0], varying=True).required["K = 1, varying"][0, 0]
    step = 5e-3
    times = np.arange(*flight.span, step)
    plant = tv.Plant.from_vehicle(flight.held(times), "drift-exact")
    A, inputs, _, _ = plant.matrices()
    wind = met.wind(times)
    stiff = np.sqrt(A[:, 1, 0])
    limits = need * np.array([0.95, 1.02])
    x = np.zeros((limits.size, A.shape[-1]))
    back = 10.0 * A[:, 1, 0] / inputs[:, 1, 0]
    for k in range(times.size - 1):
        trim = -(x @ A[k, 1] + inputs[k, 1, 1] * wind[k]) / inputs[k, 1, 0]
        command = trim - back[k] * (x[:, 0] + x[:, 1] / stiff[k])
        delta = np.clip(command, -limits, limits)
        rates = x @ A[k].T + np.outer(delta, inputs[k, :, 0]) + wind[k] * inputs[k, :, 1]
        x = x + step * rates
    row, reach = GrowingMode(flight, "drift-exact", "pitch", flight.span).at(times[-1])
    lost = np.abs(x @ row) > limits * abs(reach)
    assert lost.tolist() == [True, False]


def test_availability_says_from_when_on_all_winds_can_be_judged(flight) -> None:
    days = np.datetime64("2024-02-01T00") + 24 * np.arange(3)
    winds = tv.winds.Soundings.from_profiles([sounding(s) for s in (1.0, 0.6, 1.3)], days)
    asked = {"limit": np.radians(4.0), "azimuth": EAST, "plane": "pitch"}
    (note,) = (one for one in tv.availability(flight, winds, **asked).notes if "--from" in one)
    begin = float(note.split("--from ")[1].rstrip(")"))
    found = tv.availability(flight.between(begin), winds, **asked)
    assert found.part().flown == 3
    met = tv.fly_through(sounding(), flight.between(begin), azimuth=EAST)
    alone = tv.size(flight, met, times=[60.0], varying=True).required["K = 1, varying"][0, 0]
    assert found.need[0] == pytest.approx(alone, rel=1e-3)


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
    with pytest.raises(tv.InputError, match="--in-order"):
        tv.read_soundings(tmp_path)
    found = tv.read_soundings(tmp_path, in_order=True)
    assert [str(one)[:10] for one in found.times] == ["2000-01-01", "2000-01-02", "2000-01-03"]
    assert "3 files without a date" in found.notes[0]
