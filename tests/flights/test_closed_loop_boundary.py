"""Boundaries of laws: the report's limits, the table of the lean law, bounds, exact flights."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import cont2discrete

import tvclin as tv
from tests.recoverable import are_recoverable
from tests.turns import usual
from tvclin import (
    Coefficients,
    InputError,
    Plant,
    RecoverableAttitudeLaw,
    SampledWind,
    TriangularWind,
    TrimLaw,
    closed_loop_boundary,
    fly,
)
from tvclin.boundary.forecast_free import unstable_coordinates
from tvclin.control import WindEstimator
from tvclin.control.laws.law import Measurement
from tvclin.flights.closed_loop.survival_limit import NEVER, OPEN, limit_above_losses

PEAK = np.radians(5.0)
NAME = "configuration-i"
NONE = np.zeros((0,))
SLOW = tv.Actuator(natural_frequency=20.0)
SERVO = tv.Actuator(natural_frequency=20.0, damping=0.7)
EACH_MODEL = pytest.mark.parametrize("model", ["fixed-path", "drift-exact"])
TAUS = (2.0, 4.0, 8.0, 20.0)
EACH_TAU = pytest.mark.parametrize("tau_beta", TAUS)


def plant_of(model="fixed-path", name=NAME):
    return Plant.from_vehicle(tv.load_vehicle(name), model)


def triangle(plant, tau_beta, peak=PEAK):
    return TriangularWind(peak=peak, duration=tau_beta / plant.coefficients.beta)


def lean(plant, reach=0.95, **options):
    return RecoverableAttitudeLaw(plant, **{"reach": reach, "design_peak": PEAK} | options)


def limit_of(plant, law, wind, **options):
    """Return the limit at 50 Hz, which is plenty without hardware; `wind` may be tau beta."""
    wind = triangle(plant, wind) if isinstance(wind, float) else wind
    return closed_loop_boundary(plant, law, wind, **{"sample_rate": 50.0} | options).limit


@EACH_TAU
def test_trim_as_a_feedback_has_the_boundary_of_eq_12(tau_beta):
    plant = plant_of()
    expected = tv.boundary_limit(plant, triangle(plant, tau_beta)).limit
    limit = limit_of(plant, TrimLaw(plant), tau_beta, sample_rate=25.0)
    assert limit == pytest.approx(expected, abs=0.002)


@EACH_TAU
def test_trim_that_holds_the_attitude_meets_the_literal_dead_band_with_drift(tau_beta):
    plant = plant_of("drift-exact")
    expected = tv.boundary_limit(plant, triangle(plant, tau_beta), 1.0, "literal").limit
    limit = limit_of(plant, TrimLaw(plant_of()), tau_beta, sample_rate=25.0)
    assert limit == pytest.approx(expected, abs=0.002)


@pytest.mark.parametrize("tau_beta", [2.0, 4.0])
def test_the_dead_band_law_comes_near_the_reports_limit_in_a_short_wind(tau_beta):
    plant = plant_of()
    expected = tv.boundary_limit(plant, triangle(plant, tau_beta), 0.5).limit
    assert expected <= limit_of(plant, tv.control.DeadBandLaw(plant), tau_beta) <= expected + 0.004


# Of another program, with steps of 5 ms; vehicle I, 5 degrees.
TABLE = {
    ("lean", "fixed-path"): (0.409, 0.394, 0.425, 0.478),
    ("lean", "drift-exact"): (0.397, 0.389, 0.414, 0.466),
    ("trim", "drift-exact"): (0.491, 0.666, 0.806, 0.909),
}


@pytest.mark.parametrize(
    ("law", "model", "tau_beta", "expected"),
    usual(
        [(*case, *pair) for case, row in TABLE.items() for pair in zip(TAUS, row, strict=True)],
        *(0, 5, 10),
    ),
)
def test_laws_without_hardware_need_what_the_table_says(law, model, tau_beta, expected):
    plant = plant_of(model)
    law = lean(plant) if law == "lean" else TrimLaw(plant)
    assert limit_of(plant, law, tau_beta) == pytest.approx(expected, abs=0.005)


@pytest.mark.parametrize(("tau_beta", "expected"), [(4.0, 0.399), (20.0, 0.478)])
def test_a_slow_nozzle_costs_little(tau_beta, expected):
    plant = plant_of("drift-exact")
    hardware = {"actuator": SERVO, "rate_limit": np.radians(5.0), "sample_rate": 50.0}
    limit = limit_of(plant, lean(plant, reach=0.9), tau_beta, **hardware)
    assert limit == pytest.approx(expected, abs=0.02)


def test_a_noisy_estimator_costs_a_little_more():
    plant = plant_of("drift-exact")
    estimator = WindEstimator(bandwidth=10.0, rate_noise=np.radians(0.02), seed=1)
    hardware = {"actuator": SERVO, "rate_limit": np.radians(10.0), "sample_rate": 200.0}
    limit = limit_of(plant, lean(plant, reach=0.8, estimator=estimator), 4.0, **hardware)
    assert limit == pytest.approx(0.424, abs=0.02)


@pytest.mark.thorough
@EACH_MODEL
@pytest.mark.parametrize("tau_beta", [4.0, 8.0])
def test_sudden_stops_cost_nothing_in_a_triangle(model, tau_beta):
    plant = plant_of(model)
    law = lean(plant, reach=0.9)
    whole, stopped = (limit_of(plant, law, tau_beta, sample_rate=10.0, cuts=n) for n in (0, 12))
    assert whole <= stopped <= whole + 0.002


def test_a_sudden_stop_is_the_wind_cut_dead():
    """One cut in the middle counts like the two winds flown one by one."""
    plant = plant_of()
    wind = SampledWind(time=[0.0, 3.0, 6.0, 9.0], angle=PEAK * np.array([0.0, 1.0, 1.0, 0.1]))
    law = RecoverableAttitudeLaw(plant, reach=1.0, gain=6.0)
    single = [limit_of(plant, law, one) for one in (wind, wind.before(4.5))]
    assert abs(single[0] - single[1]) > 0.01
    assert limit_of(plant, law, wind, cuts=1) == pytest.approx(max(single), abs=1e-4)


@pytest.mark.parametrize(("model", "tau_beta"), [("fixed-path", 4.0), ("drift-exact", 8.0)])
def test_configuration_ii_needs_little_more_than_the_least_too(model, tau_beta):
    plant = plant_of(model, "configuration-ii")
    minimum = tv.forecast_free_limit(plant, triangle(plant, tau_beta)).limit
    assert minimum <= limit_of(plant, lean(plant), tau_beta) <= minimum + 0.03


TWO_HUMPS = SampledWind(
    time=[0.0, 2.0, 5.0, 8.0, 14.0], angle=PEAK * np.array([0.0, 0.8, 0.2, 1.0, 0.0])
)


def test_no_law_needs_less_than_the_two_minima():
    plant, wind = plant_of(), TWO_HUMPS
    c = plant.coefficients
    minimum = tv.forecast_free_limit(plant, wind).limit
    assert tv.optimum_deflection(plant, wind).peak / (c.B * PEAK) <= minimum * (1.0 + 1e-9)
    stiff = tv.design_gains(c, natural_frequency=4.0 * c.beta, damping=0.7)
    laws = [TrimLaw(plant), tv.control.DeadBandLaw(plant), tv.SaturatedLaw(stiff), lean(plant)]
    limits = [limit_of(plant, law, wind) for law in laws]
    assert minimum <= limits[-1] == min(limits) <= minimum + 0.03
    drifting = plant_of("drift-exact")
    bound = tv.forecast_free_limit(drifting, wind).limit
    known = tv.optimum_deflection(drifting, wind).peak / (c.B * PEAK)
    assert max(bound, known) <= limit_of(drifting, lean(drifting), wind) <= bound + 0.03


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("tau_beta", "B", "peak"), usual([(8.0, 0.8, 1.0), (8.0, 1.0, 0.8), (20.0, 0.9, 1.0)], 2)
)
def test_a_nozzle_or_a_wind_taken_for_better_than_it_is_costs_little(tau_beta, B, peak):
    """B believed too low is a limit believed too high; without reserve nearly trim is needed."""
    plant = plant_of()
    c = plant.coefficients
    weak = Plant.from_coefficients(c.replace(mu_delta=c.mu_delta / B))
    options = {"reach": 0.9, "design_peak": peak * PEAK}
    trim = tv.boundary_limit(plant, triangle(plant, tau_beta)).limit
    with_reserve, without = (
        limit_of(plant, lean(weak, trust=trust, **options), tau_beta, sample_rate=25.0, cuts=6)
        for trust in (0.8, 1.0)
    )
    assert with_reserve < 0.65 * trim
    assert without > 0.95 * trim


@EACH_MODEL
@EACH_TAU
def test_the_least_is_below_the_table_and_not_far_below(model, tau_beta):
    """What the table says, against the minimum that is computed without any flight."""
    plant = plant_of(model)
    minimum = tv.forecast_free_limit(plant, triangle(plant, tau_beta)).limit
    assert minimum <= TABLE["lean", model][TAUS.index(tau_beta)] <= minimum + 0.03


def test_signs_and_peaks_do_not_matter():
    beta, limits = float(plant_of().coefficients.beta), []
    for B, peak in ((0.1, 0.05), (-0.1, 0.05), (0.1, -0.05), (0.1, 0.15)):
        plant = Plant.from_coefficients(Coefficients.from_beta(beta=beta, B=B))
        law = lean(plant, design_peak=peak)
        one = closed_loop_boundary(plant, law, triangle(plant, 4.0, peak), sample_rate=50.0)
        assert one.deflection == pytest.approx(-one.limit * B * peak, rel=1e-12)
        limits.append(one.limit)
    np.testing.assert_allclose(limits, limits[0], rtol=1e-9)


def test_in_the_yaw_plane_the_speed_changes_nothing():
    booster = tv.load_vehicle(NAME)
    limits = []
    for model in ("drift-exact", "drift-and-speed"):
        plant = Plant.from_vehicle(booster, model, "yaw")
        limits.append(limit_of(plant, lean(plant), 4.0, sample_rate=20.0))
    assert limits[0] == pytest.approx(limits[1], rel=1e-6)


@pytest.mark.parametrize("seed", usual(range(4), 0))
def test_a_wind_that_is_larger_throughout_never_needs_less(seed):
    rng, plant = np.random.default_rng(seed), plant_of()
    time, angle = np.cumsum(rng.uniform(0.5, 4.0, 6)), rng.uniform(0.1, 0.8, 6) * PEAK
    angle[2] = 0.8 * PEAK
    more = np.minimum(angle + rng.uniform(0.0, 0.3, 6) * PEAK, PEAK)
    less, larger = (
        closed_loop_boundary(plant, lean(plant), SampledWind(time=time, angle=a), sample_rate=50.0)
        for a in (angle, more)
    )
    assert abs(less.deflection) <= abs(larger.deflection) * 1.001
    assert abs(less.deflection) < 0.9 * PEAK * plant.coefficients.B


@pytest.mark.parametrize(
    ("model", "kind", "tau_beta"),
    usual(
        [
            ("fixed-path", TrimLaw, 4.0),
            ("fixed-path", lean, 4.0),
            ("drift-exact", lean, 4.0),
            ("drift-exact", lean, 12.0),
        ],
        2,
    ),
)
def test_the_edge_is_confirmed_by_flights_that_hit_every_event(model, kind, tau_beta):
    plant = plant_of(model)
    law, wind = kind(plant), triangle(plant, tau_beta)
    edge = closed_loop_boundary(plant, law, wind, sample_rate=50.0)
    modes, times = unstable_coordinates(plant), wind.duration + np.linspace(0.0, 25.0, 51)
    for part in (0.99, 1.01):
        limit = part * abs(edge.deflection)
        flown = fly(plant, law, wind, times, deflection_limit=limit)
        z, D = (
            flown.outputs[: len(plant.states)].T @ modes.left_eigenvectors.T,
            limit / plant.coefficients.B,
        )
        inside = are_recoverable(modes, z, np.full(times.size, D))
        assert np.all(inside) == (part > 1.0)
        if part > 1.0:
            assert np.all(np.abs(z[-1]) < 0.3 * D)
        else:  # once out it is out for ever
            assert np.all(np.diff(inside.astype(int)) <= 0)
            assert np.abs(z[-1, 0]) > 10.0 * D


def test_where_survival_falls_again_the_limit_is_above_the_highest_that_is_lost():
    """A wind that turns to its opposite: who leans as far as he can is caught on the wrong side."""
    plant = plant_of()
    tau = 4.0 / plant.coefficients.beta
    turning = SampledWind(
        time=[0.0, tau / 2, tau / 2, tau], angle=PEAK * np.array([0.0, 1.0, -1.0, 0.0])
    )
    law = lean(plant, reach=0.9, design_peak=None)
    edge = closed_loop_boundary(plant, law, turning, sample_rate=50.0)
    assert not edge.monotone
    assert edge.status == "ok"
    lost = edge.scan[~edge.survives]
    assert np.any(edge.survives & (edge.scan < lost.max()))
    assert lost.max() < edge.limit < lost.max() + 1e-4
    for part in (edge.scan[edge.survives][1], 0.99 * lost.max(), 1.0, 1.02 * edge.limit):
        limit = part * plant.coefficients.B * PEAK
        flown = fly(plant, law, turning, [tau + 15.0], deflection_limit=limit)
        survives = np.abs(flown.outputs["attitude"][0]) < 0.1 * PEAK
        assert survives == (part > edge.limit or part < 0.5)
    capped = closed_loop_boundary(plant, lean(plant, reach=0.9), turning, sample_rate=50.0)
    assert not capped.monotone
    assert capped.limit < 0.6 * edge.limit


@pytest.mark.parametrize(("nozzle", "window"), [(SLOW, (0.517, 0.536)), (None, (0.5112, 0.5129))])
def test_an_edge_is_above_every_loss_that_lies_a_little_above_the_scanned_one(nozzle, window):
    """Windows of loss narrower than a step of the scan, flown at 50 Hz."""
    plant = plant_of("drift-exact")
    law = tv.control.DeadBandLaw(plant_of(), dead_band=0.5)
    wind = triangle(plant, 8.0)
    hardware = {"actuator": nozzle, "sample_rate": 50.0}
    edge = closed_loop_boundary(plant, law, wind, **hardware)
    assert edge.limit > window[1]
    assert not edge.monotone
    step, end = edge.refinements[0]
    limits = np.append(np.linspace(*window, 9), np.arange(edge.limit, end, step))
    limits *= abs(plant.coefficients.B * wind.peak)
    flown = tv.fly_many(plant, law, wind, deflection_limit=limits, **hardware).status
    assert np.any(flown[:9] == "lost")
    assert np.all(flown[9:] == "survived")


def test_the_scan_and_the_ends_of_its_range():
    plant = plant_of()
    wind, law = triangle(plant, 4.0), TrimLaw(plant)
    inner = closed_loop_boundary(plant, law, wind, sample_rate=50.0, lowest=0.3, highest=0.9)
    assert (inner.scan[0], inner.scan[-1]) == (0.3, 0.9)
    assert set(np.linspace(0.3, 0.9, 61).round(9)) <= set(inner.scan.round(9))
    for k, (step, end) in enumerate(inner.refinements, start=1):
        assert step == pytest.approx(0.01 / 16**k)
        assert end >= inner.limit + 60 * step
        above = inner.scan[(inner.scan >= inner.limit) & (inner.scan <= end)]
        assert np.diff(above).max() <= step * (1.0 + 1e-9)
    np.testing.assert_array_equal(inner.survives, inner.scan >= inner.limit)
    assert inner.monotone
    low = closed_loop_boundary(plant, law, wind, sample_rate=50.0, highest=0.65)
    assert (low.limit, low.deflection) == (np.inf, -np.inf)
    assert low.status == "no limit in the range survives"
    assert not low.survives.any()
    high = closed_loop_boundary(plant, law, wind, sample_rate=50.0, lowest=0.75)
    assert high.limit == 0.75
    assert high.deflection == pytest.approx(-0.75 * plant.coefficients.B * PEAK)
    assert high.status == "every limit in the range survives"


@pytest.mark.parametrize("design", ["fixed-path", "drift", "drift-exact"])
@pytest.mark.parametrize("kind", [TrimLaw, tv.control.DeadBandLaw])
def test_a_mode_that_the_law_lets_creep_away_is_told(design, kind):
    """The step of the sampled loop from scipy: the command is held from sample to sample."""
    plant, law, rate = plant_of("drift-exact"), kind(plant_of(design)), 20.0
    edge = closed_loop_boundary(plant, law, triangle(plant, 4.0), sample_rate=rate)
    A, inputs, _, _ = plant.matrices()
    free, held, *_ = cont2discrete((A, inputs[:, :1], np.eye(3), np.zeros((3, 1))), 1.0 / rate)
    row = [float(law.demand(Measurement(*x, x[0] - x[2], 0.0), NONE, 1.0)) for x in np.eye(3)]
    radius = np.abs(np.linalg.eigvals(free + held @ [row])).max()
    assert edge.growth == pytest.approx(rate * np.log(radius), abs=1e-8)
    assert (edge.growth > 0.0) == (design != "fixed-path")
    creeps = f"near rest a real mode grows with {edge.growth:+.3g} 1/s"
    assert edge.status == (creeps if edge.growth > 0.0 else "ok")
    assert np.isfinite(edge.limit)
    times = np.array([100.0, 200.0])
    flown = fly(plant, law, triangle(plant, 4.0), times, deflection_limit=0.01, sample_rate=rate)
    grown = np.log(np.divide(*np.abs(flown.outputs[0, ::-1]))) / 100.0
    assert grown == pytest.approx(edge.growth, rel=0.02)


@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact"], 1))
def test_with_a_nozzle_the_growth_is_that_of_the_linear_loop(model):
    """A note names a sample rate that is too low for the gains as well."""
    plant = plant_of(model)
    gains = tv.design_gains(plant.coefficients, natural_frequency=1.5, damping=0.7)
    poles = replace(gains, actuator=SERVO).close(plant).poles()
    law, wind = tv.SaturatedLaw(gains), triangle(plant, 4.0)
    options = {"actuator": SERVO, "sample_rate": 800.0, "lowest": 1.5}
    edge = closed_loop_boundary(plant, law, wind, **options)
    assert edge.growth == pytest.approx(poles.real.max(), rel=0.01, abs=1e-5)
    assert edge.status == "every limit in the range survives"
    shaken = closed_loop_boundary(plant, TrimLaw(plant_of(), gain=500.0), wind, sample_rate=10.0)
    assert shaken.growth > 1.0
    assert shaken.limit == np.inf  # what is brought back, and then shaken, has not survived
    assert "near rest an oscillation of 31.4 rad/s grows with" in shaken.status


def test_noise_is_no_growth():
    plant = plant_of()
    law, noisy = (
        lean(plant, estimator=WindEstimator(bandwidth=5.0, rate_noise=noise, seed=1))
        for noise in (0.0, 1e-3)
    )
    wind, options = triangle(plant, 4.0), {"sample_rate": 50.0, "lowest": 1.5}
    growths = [closed_loop_boundary(plant, one, wind, **options).growth for one in (law, noisy)]
    assert growths[0] == pytest.approx(growths[1], rel=1e-6)
    assert growths[0] < -0.1


class Halfway(tv.control.Law):
    """In still air it rests at half of what can be brought back, neither lost nor settled."""

    def demand(self, seen, states, limit):
        c = plant_of().coefficients
        z = seen.attitude + seen.attitude_rate / c.beta
        lean = np.sign(z) * 0.5 * limit / c.B
        return c.B * (seen.angle_of_attack + 10.0 * (z - lean))


@pytest.mark.thorough
def test_what_is_neither_lost_nor_saved_is_called_undecided():
    plant = plant_of()
    edge = closed_loop_boundary(plant, Halfway(), triangle(plant, 4.0), sample_rate=10.0)
    assert edge.limit == np.inf
    assert edge.status.startswith(f"no limit in the range survives; {OPEN}")
    assert OPEN.startswith("undecided")


def test_a_very_slow_pole_costs_no_memory():
    limits = []
    for C2 in (1e-5, 1e-10):
        c = plant_of().coefficients.replace(C2=C2)
        plant = Plant.from_coefficients(c, "drift-exact")
        edge = closed_loop_boundary(plant, lean(plant), triangle(plant, 4.0), sample_rate=20.0)
        limits.append(edge.limit)
    assert unstable_coordinates(plant).poles[1] < 1e-9
    assert limits[0] == pytest.approx(limits[1], abs=1e-3)


MANY = Plant.from_coefficients(Coefficients(mu_alpha=[0.2, 0.3], mu_delta=2.6))
STABLE = Plant.from_coefficients(Coefficients(mu_alpha=-0.2, mu_delta=2.6))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sample_rate": 0.0}, "sample_rate must be positive"),
        ({"sample_rate": 0.1, "actuator": SERVO}, "sample_rate must be at least 0.16 Hz"),
        ({"actuator": 20.0}, "actuator must be an Actuator"),
        ({"actuator": tv.Actuator(natural_frequency=[20.0, 30.0])}, "must be one actuator; got"),
        ({"rate_limit": 0.0}, "rate_limit must be positive"),
        ({"rate_limit": -0.1}, "rate_limit must be positive"),
        ({"rate_limit": np.nan}, "rate_limit must be finite"),
        ({"cuts": -1}, "cuts must be an integer, zero or positive"),
        ({"cuts": 1.5}, "cuts must be an integer"),
        ({"lowest": 0.0}, "lowest must be positive"),
        ({"lowest": 2.0, "highest": 1.0}, "highest must be above lowest"),
        ({"highest": np.inf}, "highest must be finite"),
        ({"law": tv.Autopilot(attitude_gain=0.3, rate_gain=0.4)}, "law must be a Law"),
        ({"plant": MANY}, r"got batches of shape \(2,\) and \(\)"),
        ({"plant": STABLE}, "real unstable poles"),
        ({"plant": plant_of("drift-and-speed")}, "real unstable poles"),
        ({"wind": TriangularWind(peak=[0.1, 0.2], duration=5.0)}, "one plant in one wind"),
        ({"wind": tv.linear.ConstantDeflection(limit=0.1)}, "wind must end"),
        ({"wind": 0.1}, "wind must be a History"),
    ],
)
def test_what_cannot_be_asked(arguments, message):
    usual = {"plant": plant_of(), "law": TrimLaw(plant_of()), "wind": triangle(plant_of(), 4.0)}
    with pytest.raises(InputError, match=message):
        closed_loop_boundary(**usual | arguments)


def test_no_limit_above_a_lost_top_is_flown() -> None:
    flown = []

    def survives(limits):
        flown.append(limits.size)
        return np.full(limits.shape, "lost")

    scan = limit_above_losses(survives, np.linspace(1.0, 2.0, 61))
    assert flown == [61]
    assert (scan.limit, scan.lost, scan.status) == (np.inf, 2.0, NEVER)
