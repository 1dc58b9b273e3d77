"""Flights of vehicles that bend, slosh and swing their engine, beside integrations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.turns import usual
from tvclin import Actuator, Autopilot, InputError
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.sampled_stability import dominant_pole

VEHICLE = tv.load_vehicle("configuration-i")
MODE = tv.vehicle.BendingMode(
    frequency=13.0,
    damping=0.01,
    modal_mass=5e4,
    gimbal_displacement=1.0,
    gimbal_slope=-0.07,
    attitude_slope=0.02,
    rate_slope=0.03,
    pressure_displacement=-0.4,
    tank_displacements=(0.3,),
    tank_slopes=(0.1,),
)
TANK = tv.vehicle.SloshTank(mass=2000.0, station=12.0, damping=0.01, pendulum_length=2.0)
ENGINE = tv.vehicle.Engine(mass=2000.0, arm=1.4, moment_of_inertia=2e3)
STRUCTURE = tv.Structure(
    bending=(MODE,), slosh=(TANK,), engine=ENGINE, rate_gyro=tv.vehicle.Filter.low_pass(60.0, 0.7)
)
PLANT = tv.FlexiblePlant.from_vehicle(VEHICLE, STRUCTURE, "drift-exact")
SERVO = Actuator(natural_frequency=20.0, damping=0.7)
GAINS = Autopilot(attitude_gain=0.6, rate_gain=0.7)
LAW = tv.SaturatedLaw(GAINS)
WIND = tv.TriangularWind(peak=np.radians(5), duration=6.0)
SUDDEN = tv.RectangularWind(peak=np.radians(5), duration=2.0)
RATE = 50.0


def stepped(plant, commands_of, times, *, steps, rate_limit=np.inf, stop=np.inf):
    """Return attitude and sensed rate at samples, by Runge and Kutta in small steps.

    The nozzle is a mass of its own here: its acceleration is that of the servo, zero while a limit
    holds it, and a jump of its rate at the stop is an impulse.
    """
    A, B, C, _ = plant.matrices()
    w, zeta = SERVO.natural_frequency, SERVO.damping
    x, deflection, rate, shown = np.zeros(len(A)), 0.0, 0.0, []
    h = (times[1] - times[0]) / steps
    for t in times:
        seen = C @ x
        shown.append((x[0], seen[-1]))
        command = commands_of(seen[-2], seen[-1])
        for k in range(steps):
            now = t + k * h
            speed = w**2 * (command - deflection) - 2 * zeta * w * rate
            if abs(rate + h * speed) > rate_limit:
                speed = (np.sign(rate + h * speed) * rate_limit - rate) / h
            if abs(deflection) >= stop and (rate + h * speed) * deflection > 0:
                speed = -rate / h

            def moving(u, y, speed=speed, now=now, start=(deflection, rate)):
                bent = start[0] + start[1] * u + 0.5 * speed * u * u
                return A @ y + B @ np.array([bent, float(SUDDEN(now + u)), speed])

            k1 = moving(0, x)
            k2 = moving(h / 2, x + h / 2 * k1)
            k3 = moving(h / 2, x + h / 2 * k2)
            k4 = moving(h, x + h * k3)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            deflection += rate * h + 0.5 * speed * h * h
            rate += speed * h
            deflection = float(np.clip(deflection, -stop, stop))
    return np.array(shown).T


@pytest.mark.thorough
def test_without_limits_a_flight_is_the_integral_of_its_equations():
    """One system: vehicle, servo and sensors; the command is held over each sample."""
    A, B, C, _ = PLANT.matrices()
    w, zeta = SERVO.natural_frequency, SERVO.damping
    times = np.arange(0, 5, 1 / RATE)
    y, shown = np.zeros(len(A) + 2), []

    def moving(t, y, command):
        speed = w**2 * (command - y[-2]) - 2 * zeta * w * y[-1]
        return [*(A @ y[:-2] + B @ np.array([y[-2], float(WIND(t)), speed])), y[-1], speed]

    for t in times:
        shown.append(y[:2])
        seen = C @ y[:-2]
        command = GAINS.attitude_gain * seen[-2] + GAINS.rate_gain * seen[-1]
        span = (t, t + 1 / RATE)
        y = solve_ivp(moving, span, y, method="DOP853", rtol=1e-12, atol=1e-16, args=(command,))
        y = y.y[:, -1]
    flown = tv.fly(PLANT, LAW, WIND, times, deflection_limit=1.0, actuator=SERVO, sample_rate=RATE)
    wanted = np.array(shown).T
    for row, name in enumerate(("attitude", "attitude_rate")):
        scale = np.abs(wanted[row]).max()
        # 250 solutions of 1e-12 each, of a loop that damps them.
        np.testing.assert_allclose(flown.outputs[name], wanted[row], rtol=0, atol=1e-9 * scale)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("limit", "rate_limit"),
    usual([(0.0075, np.inf), (0.05, 0.008), (0.0075, 0.008)], 2),
    ids=str,
)
def test_a_heavy_engine_moves_the_vehicle_where_limits_hold_it(limit, rate_limit):
    """A nozzle that is stopped is an impulse on the vehicle; without it 2e-3 would be missing.

    The integration is good for 4e-4 (2e-4 with twice its steps); a step that a limit holds in part
    is taken for straight.
    """
    rate = 100.0
    times = np.arange(0, 4, 1 / rate)

    def command(attitude, turning):
        wanted = GAINS.attitude_gain * attitude + GAINS.rate_gain * turning
        return float(np.clip(wanted, -limit, limit))

    wanted = stepped(PLANT, command, times, steps=40, rate_limit=rate_limit, stop=limit)
    nozzle = {"deflection_limit": limit, "rate_limit": rate_limit, "actuator": SERVO}
    flown = tv.fly(PLANT, LAW, SUDDEN, times, **nozzle, sample_rate=rate)
    result = np.array([flown.outputs["attitude"], flown.outputs["sensed_attitude_rate"]])
    scale = np.abs(wanted).max(axis=1, keepdims=True)
    np.testing.assert_array_less(np.abs(result - wanted) / scale, 1e-3)


def test_a_stiff_structure_flies_as_the_rigid_vehicle():
    stiff = tv.Structure(
        bending=(replace(MODE, frequency=1300.0, tank_displacements=(), tank_slopes=()),)
    )
    plant = tv.FlexiblePlant.from_vehicle(VEHICLE, stiff, "drift-exact")
    nozzle = {"deflection_limit": 0.02, "actuator": SERVO, "sample_rate": 200.0}
    flown = [tv.fly_many(one, LAW, WIND, **nozzle) for one in (plant, plant.rigid)]
    for name in ("peak_attitude", "peak_deflection", "final_attitude"):
        flexible, rigid = (getattr(one, name) for one in flown)
        # Static bending is 1e-4 of what it is at 13 rad/s, where it is a tenth.
        assert flexible == pytest.approx(rigid, rel=1e-4)


def test_each_of_a_batch_of_structures_flies_as_by_itself():
    frequencies = np.array([9.0, 13.0, 20.0])
    many = replace(STRUCTURE, bending=(replace(MODE, frequency=frequencies),))
    nozzle = {"deflection_limit": 0.03, "actuator": SERVO, "sample_rate": RATE}
    plant = tv.FlexiblePlant.from_vehicle(VEHICLE, many, "drift-exact")
    together = tv.fly_many(plant, LAW, WIND, **nozzle)
    for k, frequency in enumerate(frequencies):
        one = replace(STRUCTURE, bending=(replace(MODE, frequency=frequency),))
        single = tv.fly_many(
            tv.FlexiblePlant.from_vehicle(VEHICLE, one, "drift-exact"), LAW, WIND, **nozzle
        )
        assert together.status[k] == str(single.status)
        assert together.peak_attitude[k] == pytest.approx(float(single.peak_attitude), rel=1e-12)


def test_the_boundary_moves_about_as_the_price_of_trim():
    """A structure moves the least limit of a law by a few percent, in the direction of `shift`."""
    law = tv.TrimLaw(PLANT.rigid, gain=1.0)
    nozzle = {"actuator": SERVO, "sample_rate": 100.0}
    flexible, rigid = (
        tv.closed_loop_boundary(one, law, WIND, **nozzle).limit for one in (PLANT, PLANT.rigid)
    )
    moved = 100.0 * (flexible / rigid - 1.0)
    assert moved * PLANT.shift().trim_price > 0.0
    assert abs(moved) < 5.0


@pytest.mark.thorough
def test_a_map_of_boundaries_is_of_the_flexible_vehicle_too():
    """Each of its boundaries by flights of the plant with that gain and delay, filters and all."""
    law = tv.control.FilteredLaw(
        tv.TrimLaw(PLANT.rigid, gain=1.0), filters=(tv.vehicle.Filter.low_pass(30.0, 0.7),)
    )
    nozzle = {"actuator": SERVO, "sample_rate": RATE}
    chart = tv.flights.boundary_map(PLANT, law, WIND, [0.9, 1.2], [0.0, 0.05], **nozzle)
    moment = float(PLANT.coefficients.B) * WIND.peak
    for gain, row in zip(chart.gains, chart.limit, strict=True):
        for delay, limit in zip(chart.delays, row, strict=True):
            tried = np.array([0.998, 1.002, 1.1]) * limit * moment
            options = {"gain": gain, "delay": delay, "deflection_limit": tried, **nozzle}
            flown = tv.fly_many(PLANT, law, WIND, **options)
            assert (flown.status == "survived").tolist() == [False, True, True]


BOOSTER = tv.linear.plant_of(tv.load_vehicle("made-up-booster"))
SHAPED = Autopilot(
    attitude_gain=0.36,
    rate_gain=0.56,
    filters=(tv.vehicle.Filter.low_pass(13.0, 0.95), tv.vehicle.Filter.notch(32.0, 0.06, 0.6)),
)
STIFF = Actuator(natural_frequency=22.0, damping=0.8)


@pytest.mark.parametrize(("rate", "delay"), [(25.0, 0.02), (12.5, 0.08), (100.0, 0.013)])
def test_near_rest_a_flight_is_the_loop_whose_margins_are_exact(rate, delay):
    """The worst mode of a flight with filters, and that of the sampled loop closed."""
    law = tv.SaturatedLaw(SHAPED)
    flight = one_flight(BOOSTER, law, WIND, 0.1, Hardware(1 / rate, delay, STIFF))
    grown = np.exp(dominant_pole(flight).real / rate)
    sampled = replace(SHAPED, actuator=STIFF, delay=delay, sample_rate=rate)
    w = sampled.exact_loop(BOOSTER).form.closed_poles()[0]
    radius = np.abs((1 + w / (2 * rate)) / (1 - w / (2 * rate))).max()
    # Differences of states of 1e-7 that are good to 1e-16.
    assert grown == pytest.approx(radius, abs=1e-8)


def test_a_filter_of_a_law_is_that_of_an_autopilot():
    """Around the gains: of the sum, or of attitude and rate alike; and what they do differs."""
    bare = tv.SaturatedLaw(replace(SHAPED, filters=()))
    chain = SHAPED.filters
    nozzle = {"deflection_limit": 0.05, "actuator": STIFF, "sample_rate": 100.0}
    laws = [
        tv.SaturatedLaw(SHAPED),
        tv.control.FilteredLaw(bare, filters=chain),
        tv.control.FilteredLaw(bare, attitude_filters=chain, rate_filters=chain),
        bare,
    ]
    peaks = [float(tv.fly_many(BOOSTER, law, WIND, **nozzle).peak_attitude) for law in laws]
    assert peaks[1] == peaks[0]
    assert peaks[2] == pytest.approx(peaks[0], rel=1e-9)  # the same sum in another order
    assert abs(peaks[3] / peaks[0] - 1.0) > 1e-2
    together = tv.fly_many(BOOSTER, np.array(laws, dtype=object), WIND, **nozzle)
    np.testing.assert_array_equal(together.peak_attitude, peaks)


class Plain(tv.control.Law):
    """Gains, written by a user in Python."""

    def demand(self, measured, states, limit):
        return SHAPED.attitude_gain * measured.attitude + SHAPED.rate_gain * measured.attitude_rate


def test_filters_of_a_law_in_python_are_those_of_the_package():
    nozzle = {"deflection_limit": 0.05, "actuator": STIFF, "sample_rate": 100.0}
    computed = [
        tv.fly_many(BOOSTER, tv.control.FilteredLaw(law, filters=SHAPED.filters), WIND, **nozzle)
        for law in (Plain(), tv.SaturatedLaw(replace(SHAPED, filters=())))
    ]
    assert float(computed[0].peak_attitude) == pytest.approx(
        float(computed[1].peak_attitude), rel=1e-12
    )


@pytest.mark.thorough
def test_the_notch_decides_whether_the_booster_flies():
    """Without filters bending grows and no limit is enough; with them some 1.4 % more is needed."""
    options = {"actuator": STIFF, "sample_rate": 100.0, "delay": 0.02}
    law, bare = (tv.SaturatedLaw(one) for one in (SHAPED, replace(SHAPED, filters=())))
    flexible, rigid = (
        tv.closed_loop_boundary(one, law, WIND, **options) for one in (BOOSTER, BOOSTER.rigid)
    )
    assert flexible.status == "ok"
    assert 1.0 < flexible.limit / rigid.limit < 1.03
    assert not np.isfinite(tv.closed_loop_boundary(BOOSTER, bare, WIND, **options).limit)


def test_a_vehicle_that_is_brought_back_while_bending_grows_rings():
    """A gyro that sees the first mode turned round: whatever the limit is, the nozzle swings."""
    structure = BOOSTER.structure
    first = structure.bending[0]
    turned = replace(first, attitude_slope=-first.attitude_slope, rate_slope=-first.rate_slope)
    several = replace(
        first,
        attitude_slope=np.array([first.attitude_slope, turned.attitude_slope]),
        rate_slope=np.array([first.rate_slope, turned.rate_slope]),
    )
    plant = replace(
        BOOSTER, structure=replace(structure, bending=(several, *structure.bending[1:]))
    )
    limits = np.radians([[0.3], [5.0]])
    nozzle = {"actuator": STIFF, "sample_rate": 50.0, "delay": 0.02}
    flights = tv.fly_many(plant, tv.SaturatedLaw(SHAPED), WIND, deflection_limit=limits, **nozzle)
    assert flights.status.tolist() == [["lost", "lost"], ["survived", "rings"]]
    assert flights.saturated_time_fraction[1, 0] == 0.0
    assert flights.saturated_time_fraction[1, 1] > 0.3
    sampled = replace(SHAPED, actuator=STIFF, delay=0.02, sample_rate=50.0)
    unstable = [sampled.margins(plant.cases(np.array([k]), (2,))).status[0] for k in (0, 1)]
    assert unstable == ["ok", "unstable"]


def test_what_cannot_be_flown_is_refused():
    filtered = tv.SaturatedLaw(SHAPED)
    with pytest.raises(InputError, match="filters are flown by samples"):
        tv.fly(PLANT.rigid, filtered, WIND, [1.0], deflection_limit=0.03)
    fast = tv.control.FilteredLaw(LAW, filters=(tv.vehicle.Filter.low_pass(1000.0),))
    with pytest.raises(InputError, match="below half the sample rate"):
        tv.fly_many(PLANT.rigid, fast, WIND, deflection_limit=0.03, sample_rate=RATE)
    with pytest.raises(InputError, match="filters already"):
        tv.control.FilteredLaw(filtered)
    with pytest.raises(InputError, match="single filters"):
        tv.control.FilteredLaw(LAW, filters=(tv.vehicle.Filter.low_pass([10.0, 20.0]),))
    with pytest.raises(InputError, match="actuator of second order"):
        tv.fly_many(PLANT, LAW, WIND, deflection_limit=0.03, sample_rate=RATE)
    with pytest.raises(InputError, match="give a sample_rate"):
        tv.fly(PLANT, LAW, WIND, [1.0], deflection_limit=0.03, actuator=SERVO)
    with pytest.raises(InputError, match="rigid"):
        tv.TrimLaw(PLANT)


def test_an_oscillation_that_lives_on_between_the_limits_has_not_survived():
    """The loop is damped near rest; at its rate limit the nozzle lags, and the mode is not held.

    Flown on for a minute the nozzle then swings as far as ever, or has come to rest.
    """
    mode = replace(
        MODE,
        frequency=20.0,
        damping=0.005,
        pressure_displacement=1.0,
        attitude_slope=-0.4,
        rate_slope=-0.4,
        tank_displacements=(),
        tank_slopes=(),
    )
    structure = tv.Structure(bending=(mode,), slosh=(TANK,))
    plant = tv.FlexiblePlant.from_vehicle(VEHICLE, structure, "drift-exact")
    gains = tv.design_gains(plant.coefficients, natural_frequency=1.5, damping=0.7)
    quick = Actuator(natural_frequency=40.0)
    assert replace(gains, actuator=quick, sample_rate=100.0).margins(plant).stable
    wind = tv.winds.AsymmetricTriangularWind(peak=np.radians(5), duration=7.5, peak_time=7.5)
    nozzle = {"deflection_limit": np.radians(0.8), "actuator": quick, "sample_rate": 100.0}
    rates = np.radians([1.0, 3.0, 12.0])
    many = tv.fly_many(plant, tv.SaturatedLaw(gains), wind, rate_limit=rates, **nozzle)
    assert many.status.tolist() == ["rings", "rings", "survived"]
    for rate, status in zip(rates, many.status, strict=True):
        times = np.linspace(70.0, 80.0, 1001)
        flown = tv.fly(plant, tv.SaturatedLaw(gains), wind, times, rate_limit=float(rate), **nozzle)
        swing = np.ptp(flown.outputs["deflection"])
        assert (swing > np.radians(0.5)) == (status == "rings")
        assert status == "rings" or swing < np.radians(0.02)
