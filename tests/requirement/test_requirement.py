"""What is required is never less than a flight needs, nor than anything that nothing undercuts."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import eig
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import drawn, usual
from tvclin.boundary.limit import PAIRED_POLES
from tvclin.boundary.open_loop import Reason, with_larger_requirements
from tvclin.cli.app import app
from tvclin.flights.flown_boundary import planar_verdict
from tvclin.requirement.nominal_requirement import may_be_zero_or_infinite
from tvclin.time_varying.equations import Equations
from tvclin.time_varying.requirements import batch_requirements
from tvclin.winds.wind_angles import NominalWind

PEAK = np.radians(5.0)


def slow(vehicle: tv.Vehicle, velocity: float, attitude_deg: float = 85.0) -> tv.Vehicle:
    """Return a vehicle early in its flight: its forces go with the square of its speed."""
    part = 4.0 * (velocity / vehicle.velocity) ** 2
    return vehicle.replace(
        velocity=velocity,
        attitude=np.radians(attitude_deg),
        normal_force_slope=part * vehicle.normal_force_slope,
        axial_force=part * vehicle.axial_force,
        time=None,
    )


def triangle(duration: float, peak: float = PEAK) -> tv.TriangularWind:
    return tv.TriangularWind(peak=peak, duration=duration)


def trim_law(plant: tv.Plant) -> tv.Autopilot:
    """Return delta = B alpha + b 10 (theta + theta'/beta), b = B for what is unstable, of each."""
    c = plant.coefficients
    gain, pace = 10.0 * np.abs(c.B) * np.sign(c.mu_delta), np.sqrt(np.abs(c.mu_alpha))
    return tv.Autopilot(attitude_gain=gain, rate_gain=gain / pace, alpha_gain=np.asarray(c.B))


@pytest.mark.parametrize("dead_band", [1.0, 0.5, 0.0])
def test_on_a_fixed_path_it_is_the_report_s_boundary_to_the_last_bit(configuration_i, dead_band):
    plant = tv.Plant.from_vehicle(configuration_i, "fixed-path")
    requirement = tv.required_deflection(plant, triangle(7.5), dead_band)
    boundary = tv.boundary_limit(plant, triangle(7.5), dead_band)
    assert (requirement.limit, requirement.deflection) == (boundary.limit, boundary.deflection)
    assert (requirement.governs, boundary.status) == (Reason.BOUNDARY, "ok")


def test_a_long_wind_needs_the_minimum_over_both_poles_and_more_after_trim(configuration_i):
    plant, wind = tv.Plant.from_vehicle(configuration_i, "drift-exact"), triangle(60.0)
    minimum = tv.optimum_deflection(plant, wind).peak
    boundary = tv.boundary_limit(plant, wind, [0.5, 0.0])
    assert np.all(np.abs(boundary.deflection) < 0.7 * minimum)
    assert boundary.status.tolist() == ["ok", "ok"]  # it is y(K), and says no more than that
    compared = with_larger_requirements(plant, wind, [0.5, 0.0], boundary)
    assert compared.status.tolist() == [
        f"{Reason.AFTER_TRIM} is larger",
        f"{Reason.MINIMUM} is larger",
    ]
    np.testing.assert_array_equal(compared.limit, boundary.limit)
    requirement = tv.required_deflection(plant, wind, [0.5, 0.0])
    assert requirement.governs.tolist() == [Reason.AFTER_TRIM, Reason.MINIMUM]
    after, onset = np.abs(requirement.deflection)
    assert onset == pytest.approx(minimum, rel=1e-9)
    assert 1.01 * minimum < after < 1.05 * minimum
    for need, dead_band in ((after, 0.5), (onset, 0.0)):
        assert not tv.is_sufficient(plant, wind, 0.999 * need, dead_band)
        assert tv.is_sufficient(plant, wind, 1.001 * need, dead_band)
        assert tv.survivable_peak(plant, wind, 0.5 * need, dead_band) == pytest.approx(0.5 * PEAK)


@pytest.mark.thorough
@pytest.mark.parametrize("aerodynamic_arm", usual([None, -7.0], 1))
def test_an_effector_ahead_of_the_centre_of_gravity_needs_about_as_much(
    configuration_i, aerodynamic_arm
):
    """A stable vehicle and an unstable one; the law's feedback brings the attitude back in both."""
    vehicle = configuration_i
    if aerodynamic_arm is not None:
        vehicle = vehicle.replace(aerodynamic_arm=aerodynamic_arm)
    ahead = vehicle.replace(control_arm=-vehicle.control_arm)
    behind, before = (
        abs(tv.required_deflection(tv.Plant.from_vehicle(v, "drift-exact"), triangle(7.5)).limit)
        for v in (vehicle, ahead)
    )
    assert before == pytest.approx(behind, rel=0.12)  # the side force has the other sign
    plant = tv.Plant.from_vehicle(ahead, "drift-exact")
    c = plant.coefficients
    law = trim_law(plant)
    limits = before * abs(c.B) * PEAK * np.array([1.01, 1.05, 1.3])
    flown = tv.fly_many(plant, law, triangle(7.5), deflection_limit=limits, sample_rate=200.0)
    assert flown.status.tolist() == ["survived"] * 3


@pytest.mark.thorough
def test_a_band_of_losses_above_a_limit_that_survives_is_not_stepped_over():
    vehicle = tv.Vehicle(
        weight=2.5183e6,
        thrust=9.99809e6,
        moment_of_inertia=6.72992e7,
        normal_force_slope=9.69659e5,
        aerodynamic_arm=8.38191,
        control_arm=25.7814,
        axial_force=6.11259e5,
        velocity=379.741,
        attitude=0.314442,
    )
    time = [0.0, 6.2493, 12.0342, 13.4668, 16.0594, 18.2317, 19.7114, 25.6745, 28.3449, 33.8971,
            37.8076, 38.4849]  # fmt: skip
    angle = [0.0, 0.041386, 0.016922, 0.015532, 0.004963, 0.025151, 0.05, 0.000993, 0.047048,
             0.031818, 0.014873, 0.0]  # fmt: skip
    wind = tv.SampledWind(time=time, angle=angle)
    needs = [
        tv.required_deflection(tv.Plant.from_vehicle(vehicle, model), wind)
        for model in ("drift-exact", "drift-and-speed")
    ]
    limits = np.multiply.outer([0.998, 1.002], [abs(need.deflection) for need in needs])
    for model, some in zip(("drift-exact", "drift-and-speed"), limits.T, strict=True):
        law_diverges = [diverges(tv.Plant.from_vehicle(vehicle, model), wind, x) for x in some]
        assert law_diverges == [True, False]
    plant = tv.Plant.from_vehicle(vehicle, "drift-exact")
    # The least that no control undercuts survives, and above it a band of limits is lost.
    above = np.array([1.01, 1.02, 1.03, 1.04, 1.049, 1.06, 1.1, 1.2])
    limits = above * needs[0].needs[Reason.BOUNDARY]
    options = {"deflection_limit": limits, "sample_rate": 100.0}
    flown = tv.fly_many(plant, trim_law(plant), wind, **options)
    assert "lost" in flown.status[:4]
    sufficient = limits > abs(needs[0].deflection)
    assert sufficient.sum() > 1
    assert np.all(flown.status[sufficient] == "survived")


def diverges(plant: tv.Plant, wind: tv.SampledWind, limit: float) -> bool:
    """Return whether the ideal trim law with a limit diverges, by LSODA, ten e-folds after."""
    A, inputs, _, _ = plant.matrices()
    stiff = abs(A[1, 0])
    back = 10.0 * stiff * (np.arange(len(A)) == 0) + 10.0 * np.sqrt(stiff) * (
        np.arange(len(A)) == 1
    )

    def rates(t, x):
        angle = float(wind(min(t, wind.time[-1]))) if t < wind.time[-1] else 0.0
        felt = (A[1] + back) @ x + inputs[1, 1] * angle
        return A @ x + inputs @ [np.clip(-felt / inputs[1, 0], -limit, limit), angle]

    values, rows = eig(A, left=True, right=False)
    k = int(np.argmax(np.where(values.imag == 0.0, values.real, -np.inf)))
    state = np.zeros(len(A))
    for span in pairwise([*wind.time, wind.time[-1] + 10.0 / values[k].real]):
        state = solve_ivp(rates, span, state, "LSODA", rtol=1e-8, atol=1e-12).y[:, -1]
    row = rows[:, k].real
    return bool(abs(row @ state) > limit * abs(row @ inputs[:, 0]) / values[k].real)


def test_a_slow_real_pole_of_drift_and_speed_is_flown_itself():
    """Without the change of its speed the vehicle has a pair, whose flights nobody can judge."""
    c = tv.Coefficients(
        mu_alpha=0.0366, mu_delta=3.2277, C1=0.32144, C2=0.0018342, b1=0.32663, b2=0.29266,
        q=0.012518,
    )  # fmt: skip
    exact, whole = tv.Plant(c, "drift-exact"), tv.Plant(c, "drift-and-speed")
    assert np.iscomplexobj(tv.unstable_modes(exact).poles)
    assert tv.unstable_modes(whole).poles == pytest.approx([0.108], rel=1e-2)
    requirement = tv.required_deflection(whole, triangle(15.0))
    assert requirement.limit < 1.05 * requirement.needs[Reason.BOUNDARY] / (c.B * PEAK)
    limits = abs(requirement.deflection) * np.array([0.95, 1.01, 1.1, 1.5])
    options = {"deflection_limit": limits, "sample_rate": 50.0}
    flown = tv.fly_many(whole, trim_law(whole), triangle(15.0), **options)
    assert flown.status.tolist() == ["lost", "survived", "survived", "survived"]


def test_a_dead_band_of_one_needs_the_bound_without_a_forecast_and_the_law_flown(configuration_i):
    """A wind that jumps to its peak and falls off for long: with drift (4b) asks for too little."""
    plant = tv.Plant.from_vehicle(configuration_i, "drift-exact")
    wind = tv.winds.AsymmetricTriangularWind(peak=PEAK, duration=80.0, peak_time=0.0)
    requirement = tv.required_deflection(plant, wind, [1.0, 0.5])
    bound = abs(tv.forecast_free_limit(plant, wind).deflection)
    assert requirement.needs[Reason.NO_FORECAST].tolist() == [pytest.approx(bound), 0.0]
    assert abs(requirement.deflection[0]) >= bound * (1.0 - 1e-12)
    limits = abs(requirement.deflection[0]) * np.array([1.01, 1.1, 1.5])
    flown = tv.fly_many(plant, trim_law(plant), wind, deflection_limit=limits, sample_rate=200.0)
    assert flown.status.tolist() == ["survived"] * 3


def test_a_complex_pair_needs_trim_without_a_limit_and_never_nothing(configuration_i):
    plant = tv.Plant.from_vehicle(slow(configuration_i, 80.0), "drift-exact")
    wind = triangle(15.0)
    poles = tv.unstable_modes(plant).poles
    assert poles == pytest.approx([0.0767 + 0.0811j, 0.0767 - 0.0811j], abs=1e-4)
    most = abs(float(tv.trim_deflection(plant, wind).peak))
    boundary = tv.boundary_limit(plant, wind, [1.0, 0.5, 0.0])
    assert np.abs(boundary.deflection) == pytest.approx([most, 2.0 * most, np.inf])
    assert set(boundary.status) == {PAIRED_POLES}
    assert tv.is_sufficient(plant, wind, 1e-6) is False
    assert tv.is_sufficient(plant, wind, 1.01 * most) is True
    assert tv.is_sufficient(plant, wind, 100.0 * most, 0.0) is False
    assert tv.survivable_peak(plant, wind, 0.5 * most) == pytest.approx(0.5 * PEAK)
    assert most > tv.optimum_deflection(plant, wind).peak > 0.0
    with pytest.raises(tv.InputError, match=r"the complex pair 0.0767 \+- 0.08106j 1/s"):
        tv.closed_loop_boundary(plant, tv.TrimLaw(tv.Plant(plant.coefficients, "fixed-path")), wind)


@pytest.mark.thorough
def test_a_pair_that_flies_survives_with_what_is_required(configuration_i):
    """The nonlinear equations, in winds so weak that they are linear, and not much below it."""
    for velocity in (80.0, 110.0):
        vehicle, wind = slow(configuration_i, velocity), triangle(5.0, np.radians(0.01))
        plant = tv.Plant.from_vehicle(vehicle, "drift-exact")
        flown = tv.flown_boundary(vehicle, wind, tolerance=2e-3)
        required = tv.required_deflection(plant, wind)
        assert flown.limit <= required.limit + 2e-3
    assert flown.limit > 0.95 * required.limit


def test_two_poles_that_are_together_count_as_a_pair(configuration_i):
    c = tv.Coefficients.from_vehicle(slow(configuration_i, 125.0))
    # s^3 + C1 s^2 - mu s + C2 has a double root r where its slope is zero.
    r = (-2.0 * c.C1 + np.sqrt(4.0 * c.C1**2 + 12.0 * c.mu_alpha)) / 6.0
    double = tv.Plant(c.replace(C2=-(r**3 + c.C1 * r**2 - c.mu_alpha * r)), "drift-exact")
    requirement = tv.required_deflection(double, triangle(15.0))
    assert requirement.status == PAIRED_POLES
    assert requirement.limit == pytest.approx(abs(tv.trim_deflection(double, triangle(15.0)).peak)
                                        / abs(c.B * PEAK))  # fmt: skip


def test_a_slow_real_pole_does_not_hide_a_faster_pair(configuration_i):
    plant = tv.Plant.from_vehicle(slow(configuration_i, 100.0), "drift-and-speed")
    assert np.iscomplexobj(tv.unstable_modes(plant).poles)
    assert tv.boundary_limit(plant, triangle(15.0)).status == PAIRED_POLES


def test_a_stable_vehicle_needs_nothing():
    stable = tv.Plant(tv.Coefficients(mu_alpha=[-0.3, 0.3], mu_delta=2.0), "fixed-path")
    requirement = tv.required_deflection(stable, triangle(7.5))
    assert requirement.governs.tolist() == [Reason.NOTHING, Reason.BOUNDARY]
    assert (requirement.deflection[0], requirement.limit[0]) == (0.0, 0.0)


@pytest.mark.thorough
def test_a_stable_vehicle_whose_path_grows_needs_what_the_trim_law_does(configuration_i):
    plant = tv.Plant.from_vehicle(configuration_i.replace(aerodynamic_arm=-7.0), "drift-exact")
    law = trim_law(plant)
    for wind in (triangle(7.5), triangle(15.0), tv.RectangularWind(peak=PEAK, duration=3.0)):
        requirement = tv.required_deflection(plant, wind)
        limits = abs(requirement.deflection) * np.array([1.005, 1.3, 2.0])
        flown = tv.fly_many(plant, law, wind, deflection_limit=limits, sample_rate=200.0)
        assert flown.status.tolist() == ["survived"] * 3
    assert not tv.is_sufficient(plant, triangle(7.5), np.radians(0.02))


def test_where_trim_itself_grows_without_end_flights_decide():
    c = tv.Coefficients(mu_alpha=0.2, mu_delta=2.0, C1=0.03, C2=0.001, b1=-0.02, b2=-0.03)
    for b1 in (-0.02, -0.3):
        plant = tv.Plant(c.replace(b1=b1), "drift")
        requirement = tv.required_deflection(plant, triangle(20.0))
        if np.isfinite(requirement.limit):
            limits = abs(requirement.deflection) * np.array([1.005, 1.3, 2.0])
            law = trim_law(plant)
            flown = tv.fly_many(
                plant, law, triangle(20.0), deflection_limit=limits, sample_rate=200.0
            )
            assert "lost" not in flown.status.tolist()


@pytest.mark.thorough
def test_with_varying_parameters_a_pair_needs_trim_too(configuration_i):
    speeds = slow(configuration_i, np.array([70.0, 80.0, 90.0]))
    schedule = tv.FlightSchedule(speeds.replace(time=[10.0, 25.0, 40.0]))
    options = {"times": [20.0, 30.0], "dead_bands": (1.0, 0.5, 0.0), "varying": True}
    sizing = tv.size(schedule, triangle(15.0), model="drift-and-speed", **options)
    for K in (1.0, 0.5):
        frozen, along = (sizing.required[f"K = {K:g}{end}"] for end in ("", ", varying"))
        assert np.all(along > 0.8 * frozen)
    assert np.all(np.isinf(sizing.required["K = 0, varying"]))


def test_a_pole_that_the_deflection_does_not_reach_lets_no_limit_be_enough():
    c = tv.Coefficients(mu_alpha=0.2, mu_delta=2.0, C1=0.03, C2=0.001, b1=0.02, b2=0.03)
    slow_pole = tv.unstable_modes(tv.Plant(c, "drift-exact")).poles[1]
    lost = tv.Plant(c.replace(b1=-slow_pole), "drift-exact")
    poles = tv.unstable_modes(lost).poles
    assert np.any(np.abs(poles + lost.coefficients.b1) < 1e-12)
    assert tv.required_deflection(lost, triangle(7.5)).limit == np.inf


@pytest.mark.thorough
def test_every_room_says_no_where_the_pair_needs_more(configuration_i, tmp_path):
    vehicle = slow(configuration_i, 80.0)
    study = tv.Study.from_vehicle(
        vehicle, duration=15.0, peak=PEAK, limit=1e-4, model="drift-exact"
    )
    assert study.sufficient is False
    assert any("two unstable poles are a pair or equal" in note for note in study.notes)
    schedule = tv.FlightSchedule(slow(configuration_i, np.array([70.0, 80.0, 90.0])).replace(
        time=[15.0, 20.0, 25.0]))  # fmt: skip
    sized = tv.size(schedule, triangle(15.0), times=[15.0, 20.0, 25.0])
    assert np.all(sized.required["K = 1"] > 0.0)
    campaign = tv.Campaign(
        vehicle=slow(configuration_i, 128.0), wind=tv.ShapedWind("triangular", PEAK, 15.0),
        cases=200, model="drift-exact", nozzle=tv.Nozzle(limit=1e-4), chunk=200,
    )  # fmt: skip
    results = tv.run_campaign(campaign, tmp_path / "c")
    assert results.success().estimate == 0.0
    assert any("are a pair or equal" in status for status in results.statuses())


def test_the_command_exits_by_what_is_required():
    given = ["study", "configuration-i", "--model", "drift-exact", "--duration", "60",
             "--dead-band", "0.5", "--sign", "frozen", "--json"]  # fmt: skip
    for limit, code in (("0.105", 1), ("0.12", 0)):
        result = CliRunner().invoke(app, [*given, "--limit-deg", limit])
        verdict = json.loads(result.stdout)["verdict"]
        assert result.exit_code == code
        assert verdict["governed_by"] == Reason.AFTER_TRIM
        assert verdict["sufficient"] is (code == 0)


def fleet(rng: np.random.Generator, count: int) -> tv.Vehicle:
    """Return vehicles from a sounding rocket's pace to far beyond a booster's, all unstable."""
    mass = np.exp(rng.uniform(-1.0, 1.0, count))
    thrust = 1.48e6 * mass * rng.uniform(1.05, 4.0, count)
    return tv.Vehicle(
        weight=1.48e6 * mass,
        thrust=thrust,
        moment_of_inertia=2.25e7 * mass * np.exp(rng.uniform(-1.0, 1.0, count)),
        normal_force_slope=6.67e5 * np.exp(rng.uniform(-4.0, 2.0, count)),
        aerodynamic_arm=rng.uniform(0.3, 15.0, count),
        control_arm=rng.uniform(8.0, 30.0, count) * rng.choice([1.0, 1.0, -1.0], count),
        axial_force=rng.uniform(0.0, 0.3, count) * thrust,
        velocity=np.exp(rng.uniform(np.log(40.0), np.log(1500.0), count)),
        attitude=np.radians(rng.uniform(5.0, 90.0, count)),
    )


def blowing(rng: np.random.Generator, count: int) -> tv.winds.History:
    """Return winds of one sign, of one kind."""
    tau = np.exp(rng.uniform(np.log(0.5), np.log(80.0), count))
    kind = rng.integers(4)
    if kind == 0:
        return tv.TriangularWind(peak=PEAK, duration=tau)
    if kind == 1:
        return tv.RectangularWind(peak=-PEAK, duration=tau)
    if kind == 2:
        top = tau * rng.uniform(0.0, 1.0, count)
        return tv.winds.AsymmetricTriangularWind(peak=PEAK, duration=tau, peak_time=top)
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, 5))]) * tau[0]
    angle = rng.uniform(0.0, PEAK, (count, 6)) * np.array([0.0, 1.0, 1.0, 1.0, 1.0, 0.0])
    return tv.SampledWind(time=time, angle=angle)


@drawn(
    2,
    25,
    st.integers(0, 2**32 - 1),
    st.sampled_from(["fixed-path", "drift", "drift-exact"]),
    st.sampled_from([1.0, 1.0, 0.75, 0.5, 0.1, 0.0]),
)
def test_no_verdict_is_too_good(seed, model, dead_band):
    """A hundred vehicles in as many winds, for each model and dead band that is drawn."""
    rng, count = np.random.default_rng(seed), 100
    plant, wind = tv.Plant.from_vehicle(fleet(rng, count), model), blowing(rng, count)
    needed = np.abs(tv.required_deflection(plant, wind, dead_band).deflection)
    assert np.all(needed > 0.0)
    finite = needed < 1.5  # limits are judged up to 90 degrees
    given = np.where(finite, needed, 1.5)
    assert np.all(tv.is_sufficient(plant, wind, 1.0001 * given, dead_band) == finite)
    assert not np.any(tv.is_sufficient(plant, wind, 0.9999 * given, dead_band))
    for case in rng.choice(count, 3, replace=False).tolist():
        single = plant.case(case, (count,)), wind.case(case, (count,))
        minimum = tv.optimum_deflection(*single, float(single[1].onset))
        assert needed[case] >= minimum.certificate.dual * (1.0 - 1e-9)
    if dead_band < 1.0:
        return
    bound = np.abs(tv.forecast_free_limit(plant, wind).deflection)
    assert np.all(needed >= np.nan_to_num(bound) * (1.0 - 1e-9))
    # Flights at what is required are on the edge: one percent above it decides.
    rate = np.clip(400.0 * tv.unstable_modes(plant).poles.real.max(axis=-1), 0.01, 1e6)
    for above in (1.01, 1.02, 1.05, 1.1, 1.3):
        options = {"deflection_limit": above * given, "sample_rate": rate}
        flown = tv.fly_many(plant, trim_law(plant), wind, **options)
        lost = np.flatnonzero((flown.status == "lost") & finite)
        assert not lost.size, lost


@settings(max_examples=10, deadline=None, print_blob=True)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 0.5, 0.0]))
def test_the_report_s_control_flown_survives_with_what_is_required(seed, dead_band):
    """The nonlinear equations in weak winds, in yaw, where no speed moves the path."""
    rng = np.random.default_rng(seed)
    one = fleet(rng, 1)
    names = (n for n in tv.Vehicle.__dataclass_fields__ if np.ndim(getattr(one, n)))
    vehicle = one.replace(**{n: float(getattr(one, n)[0]) for n in names})
    plant = tv.Plant.from_vehicle(vehicle, "drift-exact", "yaw")
    beta = plant.coefficients.beta
    wind = tv.TriangularWind(peak=1e-4, duration=float(rng.uniform(2.0, 12.0)) / beta)
    requirement = tv.required_deflection(plant, wind, dead_band)
    if not np.isfinite(requirement.limit):
        return
    control = tv.flights.ReportControl(dead_band)
    survives = planar_verdict(vehicle, wind, control, plane="yaw")
    assert survives(1.01 * abs(requirement.deflection)), requirement


def test_what_blows_to_the_other_side_first_counts_in_the_minimum(configuration_i):
    plant = tv.Plant.from_vehicle(configuration_i, "drift-exact")
    time = [0.0, 30.0, 60.0, 75.0, 90.0]
    whole, part = (
        tv.SampledWind(time=time, angle=angle)
        for angle in ([0.0, -0.05, 0.0, 0.05, 0.0], [0.0, 0.0, 0.0, 0.05, 0.0])
    )
    single = tv.required_deflection(plant, part, 0.5)
    requirement = tv.required_deflection(plant, part, 0.5, two_sided=whole)
    both = [tv.optimum_deflection(plant, w, float(w.onset)).peak for w in (part, whole)]
    assert single.needs[Reason.MINIMUM] == pytest.approx(both[0], rel=1e-9)
    assert requirement.needs[Reason.MINIMUM] == pytest.approx(max(both), rel=1e-9)
    assert both[1] > both[0]
    for other, says in (
        (0.05, "must be a History"),
        (whole * [1.0, 2.0], "two_sided must be the same"),
    ):
        with pytest.raises(tv.InputError, match=says):
            tv.required_deflection(plant, part, 0.5, two_sided=other)


def test_without_a_dead_band_the_trim_law_counts_in_the_wind_with_both_signs(configuration_i):
    """With K = 1, against the limit of the trim law by flights at 200 Hz."""
    plant = tv.Plant.from_vehicle(configuration_i, "fixed-path")
    part = triangle(7.5).shift(6.0)
    whole = part + triangle(6.0, -0.95 * PEAK)
    single, both = (tv.required_deflection(plant, part, two_sided=w) for w in (None, whole))
    flown = tv.closed_loop_boundary(plant, tv.TrimLaw(plant), whole, sample_rate=200)
    assert both.limit == pytest.approx(flown.limit, abs=2e-5)
    assert both.governs == Reason.TRIM_LAW
    assert both.limit > 1.003 * single.limit


def agreement(seed, model, dead_band, count=12):
    """Return requirements by the march and by the closed forms, over static trim, ``(count,)``."""
    rng = np.random.default_rng(seed)
    plant, wind = tv.Plant.from_vehicle(fleet(rng, count), model), blowing(rng, count)
    requirement = tv.required_deflection(plant, wind, dead_band)
    march = batch_requirements(Equations.of_plant(plant), NominalWind(wind), dead_band)
    return march / np.abs(plant.coefficients.B * wind.peak), requirement


MODELS = ["fixed-path", "drift", "drift-exact", "drift-and-speed"]


@pytest.mark.thorough
@drawn(3, 40, st.integers(0, 2**32 - 1), st.sampled_from(MODELS))
def test_frozen_and_varying_requirements_are_the_same(seed, model):
    """With K = 1 of all models, winds and both arms; the bound without a forecast stands alone."""
    march, computed = agreement(seed, model, 1.0)
    march = np.where(
        computed.governs == Reason.NO_FORECAST, np.maximum(march, computed.limit), march
    )
    pair = (
        computed.status == PAIRED_POLES
    )  # which requires the largest trim, the summit of a parabola
    known = pair & np.isfinite(computed.limit)  # trim of some grows without end after the wind
    np.testing.assert_allclose(march[known], computed.limit[known], rtol=1e-5)
    assert march[~pair] == pytest.approx(computed.limit[~pair], abs=1e-6, rel=1e-6)


@drawn(3, 40, st.integers(0, 2**32 - 1), st.sampled_from(MODELS[:2]), st.sampled_from([0.75, 0.5]))
@example(157, "drift", 0.75)  # drift turns trim over
def test_with_a_dead_band_the_march_meets_the_exact_switching(seed, model, dead_band):
    """Winds of one peak; on a quick path trim may change its sign, and exit again."""
    rng, count = np.random.default_rng(seed), 12
    plant = tv.Plant.from_vehicle(fleet(rng, count), model)
    tau = np.exp(rng.uniform(np.log(0.5), np.log(80.0), count))
    wind = tv.winds.AsymmetricTriangularWind(
        peak=PEAK, duration=tau, peak_time=tau * rng.uniform(0.0, 1.0, count)
    )
    requirement = tv.required_deflection(plant, wind, dead_band)
    equations = Equations.of_plant(plant)
    march = batch_requirements(equations, NominalWind(wind), dead_band)
    march, slow = march / np.abs(plant.coefficients.B * wind.peak), ~equations.quick_path
    assert np.all(march >= requirement.limit - 1e-6)
    assert np.all(march <= 1.01 * requirement.limit + 1e-6)
    assert march[slow] == pytest.approx(requirement.limit[slow], abs=1e-6)


def test_where_there_is_no_moment_and_nothing_grows_nothing_is_needed():
    calm = tv.Coefficients(mu_alpha=0.0, mu_delta=2.0, C1=0.1, q=0.01)
    requirement = tv.required_deflection(
        tv.Plant.from_coefficients(calm, "drift-exact"), triangle(7.5)
    )
    assert (requirement.limit, requirement.deflection, requirement.governs) == (
        0.0,
        0.0,
        Reason.NOTHING,
    )


def test_a_wind_too_long_to_be_flown_needs_the_whole_of_trim(configuration_i):
    plant = tv.Plant.from_vehicle(configuration_i, "drift-exact")
    wind = tv.TriangularWind(peak=np.radians(5), duration=1e5)
    trim = abs(float(tv.trim_deflection(plant, wind).peak))
    assert abs(tv.required_deflection(plant, wind).deflection) == pytest.approx(trim, rel=1e-5)


def test_in_long_winds_the_boundary_that_governs_is_named_by_its_exit_and_flights_need_it() -> None:
    """A trim law that holds the attitude is lost one percent below, and survives one above."""
    vehicle = tv.Vehicle(
        weight=6.0e6,
        moment_of_inertia=6.0e7,
        normal_force_slope=1.6e6,
        thrust=8.5e6,
        aerodynamic_arm=6.5,
        control_arm=14.0,
        axial_force=1.8e5,
        velocity=470.0,
        attitude=np.radians(52.0),
    )
    plant = tv.Plant.from_vehicle(vehicle)
    law = tv.TrimLaw(tv.Plant.from_vehicle(vehicle, "fixed-path"))
    for duration, part, on_wind in ((50.0, 0.842, 0.804), (100.0, 0.815, 0.491)):
        wind = tv.TriangularWind(peak=np.radians(4.0), duration=duration)
        requirement = tv.required_deflection(plant, wind, 1.0)
        limits = abs(requirement.deflection) * np.array([0.99, 1.01])
        flown = tv.fly_many(plant, law, wind, deflection_limit=limits, sample_rate=100.0)
        assert flown.status.tolist() == ["lost", "survived"]
        assert requirement.limit == pytest.approx(part, abs=5e-4)
        report = tv.boundary_limit(plant, wind, 1.0)
        literal = tv.boundary_limit(plant, wind, 1.0, "literal")
        assert report.limit == pytest.approx(on_wind, abs=5e-4)
        assert requirement.limit == pytest.approx(literal.limit, rel=1e-12)
        assert requirement.governs == "the boundary of the control with the exit on trim"


@pytest.mark.parametrize("dead_band", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
def test_zero_and_infinite_requirements_are_among_those_announced(model, dead_band):
    """Of stable vehicles, of an unstable path, and of pairs of poles."""
    random = np.random.default_rng(11)
    low, high = [-0.1, 1.0, -0.01, -0.01, -0.01, -0.01], [0.3, 4.0, 0.05, 0.02, 0.04, 0.02]
    numbers = random.uniform(low, high, (150, 6)).T
    names = ("mu_alpha", "mu_delta", "C1", "C2", "b1", "b2")
    plants = tv.Plant(tv.Coefficients(**dict(zip(names, numbers, strict=True))), model)
    winds = tv.TriangularWind(peak=0.05, duration=random.uniform(1.0, 20.0, 150))
    size = np.abs(tv.required_deflection(plants, winds, dead_band).deflection)
    ordinary = ~np.broadcast_to(may_be_zero_or_infinite(plants, winds, dead_band), size.shape)
    assert 20 < ordinary.sum() < 150
    assert np.all(np.isfinite(size[ordinary]) & (size[ordinary] > 0.0))
