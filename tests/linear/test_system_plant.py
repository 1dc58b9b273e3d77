"""Plants from a state space: the same as those of the package, and as numpy alone."""

import control
import numpy as np
import pytest

import tvclin as tv
from tvclin.linear.modes import all_modes
from tvclin.numerics import polynomials

MODELS = ("fixed-path", "drift", "drift-exact", "drift-and-speed")
WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
NAMES = {
    "inputs": ["deflection", "wind"],
    "outputs": ["attitude", "attitude_rate", "angle_of_attack"],
}


def _pair(model="drift-exact", name="configuration-i"):
    plant = tv.Plant.from_vehicle(tv.load_vehicle(name), model)
    return plant, tv.linear.SystemPlant(plant.ss(), plant.coefficients)


@pytest.fixture(scope="module")
def launcher():
    """Return the flexible plant of a small booster, with and without its names."""
    plant = tv.linear.plant_of(tv.load_vehicle("made-up-booster"))
    return plant, tv.linear.SystemPlant(plant.ss(), plant.coefficients)


@pytest.mark.parametrize("model", MODELS)
def test_a_plant_handed_over_as_its_state_space_gives_the_same_digits(model):
    plant, handed = _pair(model)
    np.testing.assert_allclose(handed.poles, plant.poles, rtol=1e-12, atol=1e-14)
    for name in ("deflection_residues", "wind_residues"):
        one, other = (getattr(tv.unstable_modes(p), name) for p in (plant, handed))
        np.testing.assert_allclose(other, one, rtol=1e-12)
    minimum = [tv.optimum_deflection(p, WIND) for p in (plant, handed)]
    assert minimum[1].peak == pytest.approx(minimum[0].peak, rel=1e-12)
    assert minimum[1].status == "ok"
    for bound in (tv.boundary_limit, tv.required_deflection):
        limits = [np.asarray(bound(p, WIND).deflection) for p in (plant, handed)]
        np.testing.assert_allclose(limits[1], limits[0], rtol=1e-12)
    times = np.array([0.0, 1.0, 3.0, 6.5, *np.linspace(25.0, 200.0, 8)])  # in the wind, and after
    responses = [
        tv.attitude_responses(p, o.deflection, WIND, times).outputs
        for p, o in zip((plant, handed), minimum, strict=True)
    ]
    size = np.abs(responses[0]).max(axis=-1, keepdims=True)
    # the switching time of the optimum is known to 1e-12 of the span of the wind
    np.testing.assert_allclose(responses[1] / size, responses[0] / size, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_the_verdict_of_a_plant_handed_over_is_the_same(model):
    plant, handed = _pair(model, "configuration-ii")
    trims = tv.trim_deflection(plant, WIND)
    constant = tv.linear.ConstantDeflection(limit=-0.004)
    for deflection in (trims, constant, tv.optimum_deflection(handed, WIND).deflection):
        one, other = (tv.linear.judge(p, deflection, WIND) for p in (plant, handed))
        assert one.stable == other.stable
        np.testing.assert_allclose(other.residues, one.residues, rtol=1e-10, atol=1e-12)
        for name in ("offset", "rate"):
            np.testing.assert_allclose(
                getattr(other.final_motion, name),
                getattr(one.final_motion, name),
                rtol=1e-9,
                atol=1e-12,
            )
        np.testing.assert_allclose(
            tv.trim_deflection(handed, WIND)(np.linspace(0, 9, 19)),
            trims(np.linspace(0, 9, 19)),
            rtol=1e-11,
            atol=1e-15,
        )


def test_margins_bands_and_flights_of_a_flexible_plant_handed_over_are_the_same(launcher):
    plant, handed = launcher
    autopilot = tv.Autopilot(
        attitude_gain=0.2, rate_gain=0.1, actuator=tv.Actuator(), delay=0.01, sample_rate=50.0
    )
    bands = [autopilot.band_margins(p) for p in (plant, handed)]
    for one, other in zip(
        sorted(bands[0].modes, key=lambda mode: mode.frequency), bands[1].modes, strict=True
    ):
        assert other.peak == pytest.approx(one.peak, rel=1e-9, nan_ok=True)
        assert other.distance == pytest.approx(one.distance, rel=1e-9, nan_ok=True)
    law = tv.SaturatedLaw.of(autopilot)
    nozzle = {"actuator": tv.Actuator(), "delay": 0.01, "sample_rate": 50.0}
    limits = np.radians([0.2, 0.5, 2.0])
    flown = [
        tv.fly_many(p, law, WIND, deflection_limit=limits, **nozzle)
        for p in (plant, handed, tv.linear.SystemPlant(plant.ss()))
    ]
    for other in flown[1:]:
        assert other.status.tolist() == flown[0].status.tolist()
        np.testing.assert_allclose(other.peak_attitude, flown[0].peak_attitude, rtol=1e-9)


def test_numerators_are_those_of_the_transfer_functions():
    for model in MODELS:
        plant, handed = _pair(model)
        for output in plant.outputs:
            for source in ("deflection", "wind"):
                expected = plant.numerator(output, source)
                result = polynomials.add(handed.numerator(output, source), -expected)
                np.testing.assert_allclose(result, 0.0, atol=1e-14)


def test_transfer_functions_with_one_denominator_are_a_plant():
    plant, _ = _pair()
    outputs = ["attitude", "attitude_rate", "flight_path_angle"]
    inputs = ["deflection", "wind"]
    above = [[np.trim_zeros(plant.numerator(o, i), "f") for i in inputs] for o in outputs]
    below = [[plant.denominator] * 2] * 3
    system = control.TransferFunction(above, below, inputs=inputs, outputs=outputs)
    handed = tv.linear.SystemPlant(system)
    assert len(handed.states) == 3
    omega = np.array([0.01, 0.5, 3.0])
    for o, output in enumerate(plant.outputs):
        for i, source in enumerate(inputs):
            A, B, C, D = handed.matrices()
            computed = [(C @ np.linalg.solve(1j * w * np.eye(3) - A, B) + D)[o, i] for w in omega]
            expected = polynomials.value(
                plant.numerator(output, source), 1j * omega
            ) / polynomials.value(plant.denominator, 1j * omega)
            np.testing.assert_allclose(computed, expected, rtol=1e-10)


def test_a_plant_with_two_integrators_responds_as_its_steps():
    A = np.zeros((4, 4))
    A[0, 1], A[2, 3], A[3, 2], A[3, 3] = 1.0, 1.0, -400.0, -0.4
    B = np.array([[0.0, 0.0], [-1.3, -0.2], [0.0, 0.0], [5.0, 0.0]])
    C = np.array([[1.0, 0.0, 0.01, 0.0], [0.0, 1.0, 0.0, 0.01], [1.0, 0.0, 0.0, 0.0]])
    D = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, -1.0]])
    plant = tv.linear.SystemPlant(control.StateSpace(A, B, C, D, **NAMES))
    times = np.array([0.0, 1.0, 4.0])
    constant = tv.linear.ConstantDeflection(limit=0.01)
    bending = np.array([[0.0, 1.0], [-400.0, -0.4]])
    states = [
        np.linalg.solve(bending, (_exponential(bending * t) - np.eye(2)) @ [0.0, 0.05])
        for t in times
    ]
    calm = tv.TriangularWind(peak=1e-12, duration=1.0)
    computed = tv.attitude_responses(plant, constant, calm, times)["attitude"]
    expected = -0.5 * 1.3 * 0.01 * times**2 + 0.01 * np.array([state[0] for state in states])
    np.testing.assert_allclose(computed, expected, rtol=1e-12, atol=1e-12)


def _exponential(matrix):
    """Return e^matrix from its eigenvalues."""
    values, columns = np.linalg.eig(matrix)
    return np.real(columns @ np.diag(np.exp(values)) @ np.linalg.inv(columns))


def test_a_moment_among_the_outputs_gives_the_coefficients():
    plant, _ = _pair("fixed-path")
    A, B, C, D = plant.matrices()
    C, D = np.vstack([C, A[1]]), np.vstack([D, B[1]])
    system = control.StateSpace(
        A, B, C, D, inputs=NAMES["inputs"], outputs=[*NAMES["outputs"], "moment"]
    )
    handed = tv.linear.SystemPlant(system)
    assert handed.coefficients.B == plant.coefficients.B
    assert tv.boundary_limit(handed, WIND).limit == pytest.approx(
        tv.boundary_limit(plant, WIND).limit, rel=1e-12
    )


def test_residues_of_a_repeatedly_rotated_system_stay():
    plant, _ = _pair()
    rng = np.random.default_rng(5)
    T = rng.normal(size=(3, 3)) + 3.0 * np.eye(3)
    A, B, C, D = plant.matrices()
    system = control.StateSpace(
        T @ A @ np.linalg.inv(T),
        T @ B,
        C @ np.linalg.inv(T),
        D,
        inputs=plant.inputs,
        outputs=plant.outputs,
    )
    one, other = all_modes(plant), all_modes(tv.linear.SystemPlant(system))
    np.testing.assert_allclose(other.poles, one.poles, rtol=1e-11)
    np.testing.assert_allclose(other.wind_residues, one.wind_residues, rtol=1e-10)


def _system(**changes):
    plant, _ = _pair("fixed-path")
    given = dict(zip("ABCD", (m.copy() for m in plant.matrices()), strict=True)) | {"dt": 0} | NAMES
    given |= changes
    order = [given.pop(key) for key in ("A", "B", "C", "D", "dt")]
    return control.StateSpace(*order, **given)


@pytest.mark.parametrize(
    ("system", "message"),
    [
        (lambda: _system(inputs=["deflektion", "wind"]), "no input deflection.*deflektion meant"),
        (lambda: _system(outputs=["atitude", "attitude_rate", "x"]), "atitude meant"),
        (lambda: _system(outputs=["attitude", "attitude_rate", "x"]), "nor angle_of_attack"),
        (lambda: _system(dt=0.02), "must be continuous.*0.02 s"),
        (lambda: _system(dt=True), "sample time in seconds"),
        (lambda: _system(D=np.ones((3, 2))), "algebraic loop"),
        (
            lambda: _system(
                A=np.diag([0.3, 0.2]), B=np.eye(2), C=np.array([[1.0, 1.0], [0, 0], [0, 0]])
            ),
            "unstable mode at 0.2 1/s that the deflection does not reach",
        ),
        (
            lambda: _system(
                A=np.diag([0.3, 0.2]), B=np.ones((2, 2)), C=np.array([[1.0, 0.0], [0, 0], [0, 0]])
            ),
            "unstable mode at 0.2 1/s that the attitude does not show",
        ),
        (
            lambda: control.TransferFunction(
                [[[1, 0, 0], [1]]] * 2,
                [[[1, 2], [1, 2]]] * 2,
                inputs=["deflection", "wind"],
                outputs=["attitude", "attitude_rate"],
            ),
            "must be proper",
        ),
        (lambda: 3, "must be a control.StateSpace or control.TransferFunction; got 3"),
    ],
)
def test_a_bad_plant_is_refused_in_one_sentence(system, message):
    with pytest.raises(tv.InputError, match=message):
        tv.linear.SystemPlant(system())


def test_what_needs_trim_says_so_where_the_moment_is_not_known():
    plant = tv.linear.SystemPlant(_pair()[0].ss())
    for function in (tv.boundary_limit, tv.required_deflection):
        with pytest.raises(tv.InputError, match="depends on the trim of the wind"):
            function(plant, WIND)


@pytest.mark.thorough
def test_flown_margins_of_a_plant_handed_over_are_the_same():
    plant, handed = _pair("fixed-path")
    law = tv.SaturatedLaw(tv.control.canonical_gains(plant.coefficients))
    nozzle = {"limit": np.radians(0.8), "actuator": tv.Actuator(), "sample_rate": 25.0}
    one, other = (tv.flights.flown_margins(p, law, WIND, **nozzle) for p in (plant, handed))
    for change in ("gain_fall", "gain_rise", "effectiveness_fall", "delay"):
        for name in ("value", "linear"):
            values = (getattr(getattr(m, change), name) for m in (other, one))
            assert next(values) == pytest.approx(next(values), rel=1e-9)
