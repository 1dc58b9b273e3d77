"""Controllers from a state space: as those of the package, and as numpy alone has them."""

from dataclasses import replace

import control
import numpy as np
import pytest

import tvclin as tv
from tvclin.control import SystemLaw, loop_margins

WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
GAINS = {"attitude_gain": 0.3, "rate_gain": 0.5, "alpha_gain": 0.02, "integral_gain": 0.03}
HARDWARE = {"actuator": tv.Actuator(), "delay": 0.02}
READ = ["attitude", "attitude_rate", "angle_of_attack"]


def _controller(period=None):
    """Return the gains as a state space, continuous or in steps."""
    A, B = (0.0, 1.0) if period is None else (1.0, period)
    matrices = [[A]], [[B, 0.0, 0.0]], [[0.03]], [[0.3, 0.5, 0.02]]
    return control.StateSpace(
        *matrices, 0 if period is None else period, inputs=READ, outputs=["deflection_command"]
    )


def _autopilots():
    gains = tv.Autopilot(**GAINS, **HARDWARE)
    return gains, tv.control.SystemAutopilot(_controller(), **HARDWARE)


@pytest.fixture(scope="module")
def plant():
    """Return the plant of configuration I."""
    return tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))


def _same_margins(one, other):
    for name in ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg", "delay_margin"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-9)
    assert other.status == one.status == "ok"


def test_gains_as_a_state_space_have_the_same_margins_poles_and_responses(plant):
    gains, system = _autopilots()
    _same_margins(gains.margins(plant), system.margins(plant))
    np.testing.assert_allclose(
        np.sort_complex(system.closed_loop_poles(plant)),
        np.sort_complex(gains.closed_loop_poles(plant)),
        rtol=1e-9,
    )
    times = np.linspace(0.0, 30.0, 31)
    one, other = (a.wind_response(plant, WIND)(times) for a in (gains, system))
    np.testing.assert_allclose(other, one, rtol=0.0, atol=1e-12)
    compared = [tv.compare_with_trim(plant, a, WIND) for a in (gains, system)]
    for name in ("peak_deflection", "peak_deflection_rate", "minimum", "wind_gain"):
        assert getattr(compared[1], name) == pytest.approx(getattr(compared[0], name), rel=1e-9)


def test_difference_equations_have_the_margins_and_flights_of_the_sampled_gains(plant):
    gains, system = _autopilots()
    sampled = replace(gains, sample_rate=50.0)
    steps = tv.control.SystemAutopilot(_controller(0.02), **HARDWARE)
    for other in (steps, replace(system, sample_rate=50.0)):
        _same_margins(sampled.margins(plant), other.margins(plant))
    limits = {"deflection_limit": np.radians([0.3, 0.5, 2.0]), "gain": 1.1}
    nozzle = limits | HARDWARE | {"sample_rate": 50.0}
    one, *others = (
        tv.fly_many(plant, law, WIND, **nozzle)
        for law in (tv.SaturatedLaw.of(gains), SystemLaw(steps), SystemLaw(system), steps)
    )
    for other in others:
        assert other.status.tolist() == one.status.tolist()
        np.testing.assert_allclose(other.peak_attitude, one.peak_attitude, rtol=1e-9)


def test_filters_around_a_controller_are_those_around_gains(plant):
    notch = tv.vehicle.Filter.notch(12.0, zero_damping=0.05, pole_damping=0.5)
    chains = {"filters": (notch,), "rate_filters": (tv.vehicle.Filter.low_pass(40.0),)}
    for rate in (None, 50.0):
        one, other = (replace(a, sample_rate=rate, **chains).margins(plant) for a in _autopilots())
        _same_margins(one, other)


@pytest.mark.thorough
def test_a_continuous_flight_of_a_controller_is_that_of_the_gains(plant):
    gains, system = _autopilots()
    flight = {"deflection_limit": 0.02, "actuator": tv.Actuator()}
    times = np.linspace(0.0, 20.0, 11)
    one, other = (
        tv.fly(plant, law, WIND, times, **flight).outputs
        for law in (tv.SaturatedLaw.of(gains), SystemLaw(system))
    )
    np.testing.assert_allclose(np.asarray(other), np.asarray(one), rtol=0.0, atol=1e-9)


@pytest.mark.thorough
def test_flown_margins_of_difference_equations_are_those_of_the_gains(plant):
    gains, _ = _autopilots()
    law = SystemLaw(tv.control.SystemAutopilot(_controller(0.02)))
    flight = {"limit": np.radians(2.0), "sample_rate": 50.0, **HARDWARE}
    one, other = (
        tv.flights.flown_margins(plant, flown, WIND, **flight)
        for flown in (tv.SaturatedLaw.of(gains), law)
    )
    for name in ("gain_fall", "gain_rise", "effectiveness_fall", "delay"):
        assert getattr(other, name).value == pytest.approx(getattr(one, name).value, rel=1e-9)


def _transfer(matrices, s):
    """Return C (s I - A)^-1 B + D."""
    A, B, C, D = matrices
    return C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D


def _random_matrices(rng, states, inputs, outputs, scale):
    A = scale * rng.normal(size=(states, states))
    B, C = rng.normal(size=(states, inputs)), rng.normal(size=(outputs, states))
    return A, B, C, np.zeros((outputs, inputs))


def _random_case(rng):
    """Return a random plant and controller, with their matrices, actuator and delay."""
    plant = _random_matrices(rng, int(rng.integers(2, 9)), 2, 4, 2.0)
    plant[3][3, 0] = rng.normal()  # an accelerometer follows the deflection at once
    outputs = ["attitude", "attitude_rate", "angle_of_attack", "imu acceleration"]
    order = int(rng.integers(0, 5))
    K = _random_matrices(rng, order, 3, 1, 3.0)
    K = (*K[:3], rng.normal(size=(1, 3)))
    read = [outputs[k] for k in rng.choice(4, 3, replace=False)]
    rows = [outputs.index(name) for name in read]
    nozzle = tv.Actuator(natural_frequency=rng.uniform(5, 40), damping=rng.uniform(0.3, 1.2))
    names = {"inputs": ["deflection", "wind"], "outputs": outputs}
    return plant, control.StateSpace(*plant, **names), K, read, rows, nozzle, rng.uniform(0, 0.1)


def _check_continuous(rng):
    G, plant, K, read, rows, nozzle, delay = _random_case(rng)
    controller = control.StateSpace(*K, inputs=read, outputs=["u"])
    autopilot = tv.control.SystemAutopilot(controller, actuator=nozzle, delay=delay)
    omega = np.geomspace(0.05, 60.0, 7)
    w, d = nozzle.natural_frequency, nozzle.damping
    for frequency, value in zip(
        omega, autopilot.frequency_response(tv.linear.SystemPlant(plant), omega), strict=True
    ):
        s = 1j * frequency
        lag = np.exp(-s * delay) * w**2 / (s**2 + 2 * d * w * s + w**2)
        terms = _transfer(K, s)[0] * _transfer(G, s)[rows, 0] * lag
        assert abs(value + terms.sum()) <= 1e-6 * np.abs(terms).sum()


def _check_sampled(rng):
    """Compare with partial fractions of plant and actuator, held over each sample."""
    G, plant, K, read, rows, nozzle, delay = _random_case(rng)
    h = rng.uniform(0.01, 0.05)
    K = (np.linalg.qr(K[0])[0] * rng.uniform(0.2, 0.9) if len(K[0]) else K[0], *K[1:])
    controller = control.StateSpace(*K, h, inputs=read, outputs=["u"])
    autopilot = tv.control.SystemAutopilot(controller, actuator=nozzle, delay=delay)
    w, d = nozzle.natural_frequency, nozzle.damping
    A, B, C, D = G
    n = len(A)
    joint = np.zeros((n + 2, n + 2))
    joint[:n, :n], joint[:n, n] = A, B[:, 0]
    joint[n, n + 1], joint[n + 1, n:] = 1.0, [-(w**2), -2 * d * w]
    output = np.hstack([C, D[:, :1], np.zeros((4, 1))])[rows]
    p, V = np.linalg.eig(joint)
    R = (output @ V) * np.linalg.solve(V, np.eye(n + 2)[:, -1] * w**2)
    whole = np.floor(delay / h)
    f = delay - whole * h
    omega = np.linspace(0.02, 0.98, 5) * np.pi / h
    for frequency, value in zip(
        omega, autopilot.frequency_response(tv.linear.SystemPlant(plant), omega), strict=True
    ):
        z = np.exp(1j * frequency * h)
        held = np.expm1(p * (h - f)) + np.exp(p * (h - f)) * np.expm1(p * f) / z
        steps = R * (z**-whole * held / (p * (z - np.exp(p * h))))
        terms = _transfer(K, z)[0][:, np.newaxis] * steps
        assert abs(value + terms.sum()) <= 1e-6 * np.abs(terms).sum()


@pytest.mark.parametrize("check", [_check_continuous, _check_sampled])
def test_random_loops_are_those_of_numpy(check):
    for seed in range(25):
        check(np.random.default_rng([58, seed]))


@pytest.mark.thorough
@pytest.mark.parametrize("check", [_check_continuous, _check_sampled])
def test_a_thousand_random_loops_are_those_of_numpy(check):
    for seed in range(25, 525):
        check(np.random.default_rng([58, seed]))


def test_a_loop_in_steps_has_the_margins_of_the_autopilot(plant):
    autopilot = tv.Autopilot(
        attitude_gain=0.3, rate_gain=0.5, actuator=tv.Actuator(), delay=0.02, sample_rate=50.0
    )
    vehicle = plant.ss()[:2, 0] * control.ss(tv.Actuator().tf())
    gains = control.ss([], [], [], [[-0.3, -0.5]], 0.02)
    steps = gains * control.sample_system(vehicle, 0.02)
    exact = autopilot.exact_loop(plant)
    shifted = tv.Loop.from_system(steps * control.tf([1.0], [1.0, 0.0], 0.02))
    for loop in (tv.Loop.from_system(steps, 0.02), shifted):
        one, other = loop_margins(exact), loop_margins(loop)
        for name in ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg"):
            assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-9)
        # a delay that is no whole number of samples changes the gain by a little as well
        assert other.delay_margin == pytest.approx(one.delay_margin, rel=1e-3)
        omega = np.array([0.1, 1.0, 20.0])
        np.testing.assert_allclose(loop.response(omega), exact.response(omega), rtol=1e-9)


def test_whole_samples_of_delay_below_the_margin_of_a_loop_in_steps_keep_it_stable(plant):
    autopilot = tv.Autopilot(
        attitude_gain=0.6, rate_gain=0.9, actuator=tv.Actuator(), delay=0.02, sample_rate=50.0
    )
    loop = autopilot.loop(plant)
    margin = loop_margins(tv.Loop.from_system(loop)).delay_margin
    last = int(margin / 0.02)
    assert last >= 2
    for samples in range(last + 2):
        delayed = loop * control.tf([1.0], [1.0, *[0.0] * samples], 0.02)
        n = delayed.nstates
        closed = np.linalg.eigvals(delayed.A - delayed.B @ delayed.C)
        assert n == loop.nstates + samples
        assert (np.abs(closed).max() < 1.0) == (samples <= last)


def _system(D, period=0, inputs=("attitude", "attitude_rate"), outputs=("u",)):
    return control.StateSpace([], [], [], D, period, inputs=list(inputs), outputs=list(outputs))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda p: tv.control.SystemAutopilot(
                _system([[1, 1]], inputs=("attitude", "attitude_rte"))
            ).margins(p),
            "has no output attitude_rte.*attitude_rate meant",
        ),
        (
            lambda p: tv.control.SystemAutopilot(_system([[1, 1]], 0.1, ("attitude", "z"))).margins(
                p
            ),
            "has no output z",
        ),
        (lambda p: tv.control.SystemAutopilot(_system([[1, 1]], True)), "sample time in seconds"),
        (
            lambda p: tv.control.SystemAutopilot(_system([[1, 1], [1, 1]], outputs=("u", "v"))),
            "one output",
        ),
        (lambda p: tv.control.SystemAutopilot(_system([[1, 1]]), inputs=("a",)), "must be 2 names"),
        (lambda p: tv.control.SystemAutopilot(control.tf([1, 0], [1])), "must be proper"),
        (
            lambda p: tv.control.SystemAutopilot(_system([[1, 1]], 0.1), sample_rate=50.0),
            "that of the controller, 10 Hz",
        ),
        (
            lambda p: tv.control.SystemAutopilot(_system([[1, 1]]), attitude_gain=1.0),
            "attitude_gain is of an Autopilot",
        ),
        (
            lambda p: tv.control.SystemAutopilot(
                control.ss(np.diag([0.5, -1]), [[0], [1]], [[1, 1]], 0)
            ),
            "unstable mode at 0.5 1/s that no input reaches",
        ),
        (
            lambda p: tv.control.SystemAutopilot(
                control.ss(np.diag([1.5, 0.1]), [[1], [1]], [[0, 1]], 0, 0.1)
            ),
            "unstable mode at 1.5 in z that its output does not show",
        ),
        (
            lambda p: tv.control.SystemAutopilot(
                _system([[1, 0.1]], inputs=("attitude", "deflection"))
            ).margins(p),
            "algebraic loop",
        ),
        (
            lambda p: SystemLaw(
                tv.control.SystemAutopilot(_system([[1, 1]], inputs=("attitude", "imu")))
            ),
            "does not measure imu",
        ),
        (
            lambda p: tv.fly(
                p,
                SystemLaw(tv.control.SystemAutopilot(_system([[1, 1]], 0.1))),
                WIND,
                [1.0],
                deflection_limit=0.02,
            ),
            "give sample_rate = 10 Hz",
        ),
        (
            lambda p: tv.fly(
                p,
                SystemLaw(tv.control.SystemAutopilot(_system([[1, 1]], 0.1))),
                WIND,
                [1.0],
                deflection_limit=0.02,
                sample_rate=50.0,
            ),
            "sample time of 0.1 s",
        ),
        (lambda p: tv.SaturatedLaw(_autopilots()[1]), "SystemLaw"),
        (
            lambda p: tv.Loop.from_system(control.tf([1], [1, 0.5], 0.1), 0.03),
            "whole number of samples",
        ),
        (lambda p: tv.Loop.from_system(control.tf([1, 0], [1, 0.5], 0.1)), "algebraic loop"),
        (lambda p: tv.Loop.from_system(control.tf([1], [1, 1], 0.1)), "pole at z = -1"),
    ],
)
def test_a_bad_controller_is_refused_in_one_sentence(plant, call, message):
    with pytest.raises(tv.InputError, match=message):
        call(plant)


def test_a_sampled_controller_in_turbulence_reads_each_output_that_it_names():
    vehicle = tv.load_vehicle("configuration-i")
    plant = tv.Plant.from_vehicle(vehicle, "drift-exact")
    air = tv.winds.Turbulence(intensity=6.0)
    read = ["flight_path_angle", "attitude", "attitude_rate", "deflection"]
    law = control.StateSpace([], [], [], [[-0.2, 0.3, 0.5, 0.1]], inputs=read, outputs=["u"])
    autopilot = tv.control.SystemAutopilot(law, actuator=tv.Actuator())
    rms = [
        tv.control.turbulence_covariance(a, plant, air, vehicle.velocity).rms()
        for a in (autopilot, replace(autopilot, sample_rate=400.0))
    ]
    assert rms[1] == pytest.approx(rms[0], rel=5e-3)  # half a sample is 1.25 ms of lag


def test_a_controller_takes_no_estimator_of_a_law(plant):
    law = SystemLaw(tv.control.SystemAutopilot(_controller()))
    with pytest.raises(tv.InputError, match="takes no estimator"):
        tv.control.EstimatedLaw(law, tv.control.WindEstimator(bandwidth=10.0), plant)


def test_in_six_degrees_of_freedom_a_controller_that_reads_drift_is_its_gains():
    pytest.importorskip("jsbsim")
    reads = _system([[0.3, 0.5, 1e-4]], inputs=("attitude", "attitude_rate", "drift_rate"))
    gains = tv.Autopilot(attitude_gain=0.3, rate_gain=0.5, drift_rate_gain=1e-4)
    flown = [
        tv.fly_sixdof(
            tv.load_vehicle("configuration-i"), law, WIND, [0.0, 2.0, 6.0], deflection_limit=0.02
        ).outputs
        for law in (SystemLaw(tv.control.SystemAutopilot(reads)), tv.SaturatedLaw(gains))
    ]
    np.testing.assert_allclose(*flown, rtol=1e-12, atol=1e-15)
