"""Damping of the attitude rate: poles, plants, laws and gains; none of it where there is none."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import tvclin as tv
from tests.damped import damped, fast_pole, plant_of
from tests.turns import usual
from tvclin import InputError
from tvclin.boundary.forecast_free import unstable_coordinates
from tvclin.kernels.choice import pinned
from tvclin.linear.plant import INPUTS, MODELS, Plant

EACH_MODEL = pytest.mark.parametrize("model", MODELS)
PEAK = np.radians(5.0)
STUDENT = {"mu_alpha": 1.5e5 / 21846, "damping": 4710 / 21846}


@pytest.mark.parametrize("ratio", [1e-9, 1e-3, 0.05, 1.5, 30.0, 1e8])
def test_the_pole_keeps_its_digits_however_large_the_damping(ratio):
    c = tv.Coefficients(mu_alpha=0.28, mu_delta=2.6, damping=ratio * np.sqrt(0.28))
    with mp.workdps(40):
        d, mu = mp.mpf(float(c.damping)), mp.mpf(0.28)
        exact = float(-d / 2 + mp.sqrt(d**2 / 4 + mu))
    assert c.pole == pytest.approx(exact, rel=4 * np.finfo(float).eps)
    assert c.pole * (c.pole + c.damping) == pytest.approx(c.mu_alpha, rel=1e-15)


def test_a_student_rocket_falls_four_percent_more_slowly():
    c = tv.Coefficients(mu_delta=1.0, **STUDENT)
    assert (round(c.beta, 6), round(c.pole, 6)) == (2.620352, 2.514769)
    assert c.K1 == 1.0
    assert c.replace(b1=0.2, b2=0.1).K1 == pytest.approx((c.pole + 0.1) / (c.pole + 0.2))
    assert [c.replace(damping=d).pole_symbol for d in (0.0, 0.1, [0.0, 0.1])] == ["beta", "p", "p"]


@pytest.mark.parametrize(
    ("name", "damping", "cubic", "quartic"),
    [
        ("configuration-i", 0.0241, (0.49784, 0.01290), (0.49785, 0.00644, 0.01123)),
        ("configuration-ii", 0.0320, (0.35736, 0.00984), (0.35739, 0.00490, 0.01176)),
    ],
)
def test_the_unstable_poles_of_the_exact_models_with_a_jet(name, damping, cubic, quartic):
    poles = tv.unstable_modes(Plant.from_vehicle(damped(name, damping), "drift-exact")).poles
    np.testing.assert_allclose(poles, cubic, atol=6e-6)
    fast, upper, _ = tv.unstable_modes(
        Plant.from_vehicle(damped(name, damping), "drift-and-speed")
    ).poles
    np.testing.assert_allclose([fast.real, upper.real, upper.imag], quartic, atol=6e-6)


def test_the_yaw_plane_has_the_same_damping():
    pitch, yaw = (tv.Coefficients.from_vehicle(damped(), plane) for plane in ("pitch", "yaw"))
    assert pitch.damping == yaw.damping == pytest.approx(0.03, rel=1e-15)


@EACH_MODEL
def test_transfer_functions_and_state_space_are_one_plant(model):
    plant = plant_of(model=model)
    s = np.array([0.3 + 0.2j, 1.1j, -0.4 + 0.7j])
    A, B, C, D = plant.matrices()
    for point in s:
        whole = C @ np.linalg.solve(point * np.eye(len(A)) - A, B) + D
        for i, output in enumerate(plant.outputs):
            for j, name in enumerate(INPUTS):
                above = np.polyval(plant.numerator(output, name), point)
                computed = above / np.polyval(plant.denominator, point)
                assert computed == pytest.approx(whole[i, j], rel=1e-12)


@EACH_MODEL
def test_the_response_is_that_of_the_equations_integrated(model):
    plant = plant_of(model=model)
    wind = tv.TriangularWind(peak=PEAK, duration=6.0)
    push = tv.linear.ConstantDeflection(limit=-0.004)
    times = np.linspace(0.0, 9.0, 19)
    result = tv.attitude_responses(plant, push, wind, times)
    c, order = plant.coefficients, len(plant.states)
    lean = c.C2 / c.mu_alpha

    def rates(t, x):
        path = x[2] if order > 2 else 0.0
        w, delta = float(wind(t)), -0.004
        turn = c.mu_alpha * (x[0] - path - w) - c.mu_delta * delta - 0.25 * x[1]
        drifts = c.b1 / c.B * delta + c.b2 * w
        if model != "drift":
            drifts = (c.C1 + lean) * x[0] - c.C1 * path + (c.b1 - c.C1) / c.B * delta
            drifts -= (c.C1 - c.b2) * w
        if order > 3:
            drifts += np.sqrt(c.q) * x[3]
        return np.array([x[1], turn, drifts, -np.sqrt(c.q) * path])[:order]

    state, rows = np.zeros(order), []
    for a, b in zip([0.0, 3.0, 6.0], [3.0, 6.0, 9.0], strict=True):
        inside = times[(times >= a) & (times < b)] if b < 9.0 else times[times >= a]
        flown = solve_ivp(
            rates, (a, b), state, method="DOP853", rtol=1e-12, atol=1e-15, dense_output=True
        )
        rows.append(flown.sol(inside))
        state = flown.y[:, -1]
    rows = np.hstack(rows)
    for name, row in zip(plant.states, rows, strict=False):
        if name in result.labels:
            np.testing.assert_allclose(result[name], row, rtol=1e-8, atol=1e-12)


def test_the_growing_coordinate_has_the_other_pole_below_the_rate():
    """Z = theta + theta'/(p + d) moves by itself; theta + theta'/p does not."""
    plant = Plant.from_vehicle(damped(), "fixed-path")
    computed, c = unstable_coordinates(plant), plant.coefficients
    assert c.pole == pytest.approx(0.514495, abs=5e-7)
    np.testing.assert_allclose(computed.left_eigenvectors, [[1.0, 1.836564]], rtol=5e-7)
    np.testing.assert_allclose(
        computed.left_eigenvectors, [[1.0, 1.0 / (c.pole + c.damping)]], rtol=1e-12
    )
    motion, start = expm(plant.matrices()[0] * 2.0), np.array([0.01, -0.003])
    for row, single in (
        (computed.left_eigenvectors[0], True),
        (np.array([1.0, 1.0 / c.pole]), False),
    ):
        grown = row @ motion @ start / (row @ start) / np.exp(2.0 * c.pole)
        assert (abs(grown - 1.0) < 1e-12) == single


def test_without_a_moment_nothing_grows():
    plant = plant_of(mu_alpha=0.0, damping=0.3)
    np.testing.assert_allclose(np.sort(plant.poles), [-0.3, 0.0], atol=1e-15)
    assert not tv.unstable_modes(plant).poles.size
    for name in ("beta", "pole", "K1"):
        with pytest.raises(InputError, match="beta needs an aerodynamically unstable vehicle"):
            getattr(plant.coefficients, name)


def test_a_stable_vehicle_needs_no_deflection_with_any_damping():
    wind = tv.TriangularWind(peak=PEAK, duration=6.0)
    for damping in (0.0, 0.2, 5.0):
        plant = plant_of(mu_alpha=-0.3, damping=damping)
        assert np.all(np.real(plant.poles) <= 0.0)
        assert tv.boundary_limit(plant, wind).limit == 0.0


@pytest.mark.parametrize("make", [tv.Vehicle.replace, tv.Coefficients.replace])
def test_a_damping_that_drives_is_refused(make):
    name = "pitch_damping" if make is tv.Vehicle.replace else "damping"
    value = damped() if make is tv.Vehicle.replace else plant_of().coefficients
    with pytest.raises(InputError, match=f"{name} must be zero or positive"):
        make(value, **{name: -1.0})


def test_a_batch_holds_vehicles_with_damping_and_without():
    plant = plant_of(damping=[0.0, 0.25, 0.6])
    np.testing.assert_allclose(
        plant.coefficients.pole, [fast_pole(0.28, d) for d in (0.0, 0.25, 0.6)], rtol=1e-14
    )
    assert plant.coefficients.pole[0] == np.sqrt(0.28)
    wind = tv.TriangularWind(peak=PEAK, duration=9.0)
    single = [tv.boundary_limit(plant_of(damping=d), wind, 0.5).limit for d in (0.0, 0.25, 0.6)]
    np.testing.assert_allclose(tv.boundary_limit(plant, wind, 0.5).limit, single, rtol=1e-14)


def test_gains_place_the_poles_that_they_promise():
    c = plant_of().coefficients
    A, inputs, _, _ = plant_of().matrices()

    def closed(autopilot):
        gains = [autopilot.attitude_gain, autopilot.rate_gain]
        return np.poly(A + np.outer(inputs[:, 0], gains))

    request = tv.design_gains(c, natural_frequency=1.2, damping=0.6)
    np.testing.assert_allclose(closed(request), [1.0, 2 * 0.6 * 1.2, 1.44], rtol=1e-13)
    canonical = closed(tv.control.canonical_gains(c))
    np.testing.assert_allclose(canonical, [1.0, c.beta + 0.25, c.mu_alpha], rtol=1e-13)


def test_less_damping_than_the_vehicle_has_is_refused():
    with pytest.raises(InputError, match=r"own damping M_q/I = 0\.25 1/s.*got 0\.2 1/s"):
        tv.design_gains(plant_of().coefficients, natural_frequency=1.0, damping=0.1)


def test_the_wind_estimator_knows_the_damping():
    """Shown a steady turn in no wind it finds none; without the term it finds d theta'/mu_alpha."""
    plant, rate = plant_of(), 0.02
    c, estimator = plant.coefficients, tv.control.WindEstimator(bandwidth=8.0)
    F, G = estimator.states(plant)
    assert np.poly(F) == pytest.approx([1.0, 2 * 0.7 * 8.0, 64.0])  # its own poles, as promised
    for believed, error in ((plant, 0.0), (plant_of(damping=0.0), 0.25 * rate / c.mu_alpha)):
        F, G = estimator.states(believed)
        held = (c.mu_alpha * 0.1 - 0.25 * rate) / c.mu_delta  # theta'' = 0 at theta = 0.1
        seen = np.array([0.1, rate, 0.0, 0.0, held])
        result = np.linalg.solve(F, -G @ seen)
        assert result[0] == pytest.approx(rate, rel=1e-12)
        assert result[1] == pytest.approx(error, abs=1e-12)


@pytest.mark.parametrize("model", ["fixed-path", "drift-exact", "drift-and-speed"])
def test_a_flexible_plant_without_structure_is_the_rigid_one(model):
    vehicle = damped("configuration-ii", 0.04)
    flexible = tv.FlexiblePlant.from_vehicle(vehicle, tv.Structure(), model)
    A, B, _, _ = flexible.matrices()
    stiff = Plant.from_vehicle(vehicle, model)
    np.testing.assert_allclose(A, stiff.matrices()[0], rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(B, stiff.matrices()[1], rtol=1e-12, atol=1e-16)


AS_PRINTED = {
    "fixed-path": lambda c: (1.0, 0.0, -c.mu_alpha),
    "drift": lambda c: (1.0, 0.0, -c.mu_alpha, 0.0),
    "drift-exact": lambda c: (1.0, c.C1, -c.mu_alpha, c.C2),
    "drift-and-speed": lambda c: (1.0, c.C1, c.q - c.mu_alpha, c.C2, -c.q * c.mu_alpha),
}
"""Denominators of the report, which has no damping."""


def leave_damping_out(monkeypatch):
    """Take every damping out of the equations of the plants, as if there were no such term."""
    whole = Plant.matrices

    def matrices(self):
        A, *others = whole(self)
        A[..., 1, 1] = 0.0
        return (A, *others)

    def denominator(self):
        return self._stack(AS_PRINTED[self.model](self.coefficients))

    def K1(self):
        return (self.beta + self.b2) / (self.beta + self.b1)

    monkeypatch.setattr(Plant, "matrices", matrices)
    monkeypatch.setattr(Plant, "denominator", property(denominator))
    monkeypatch.setattr(tv.Coefficients, "pole", property(lambda self: self.beta))
    monkeypatch.setattr(tv.Coefficients, "K1", property(K1))


def _answers(model):
    """Numbers of everything that a plant goes through, of a vehicle and of a batch."""
    vehicle = tv.load_vehicle("configuration-ii")
    computed = []
    for one in (vehicle, vehicle.replace(normal_force_slope=[4e6, 5e6])):
        plant = Plant.from_vehicle(one, model)
        wind = tv.TriangularWind(peak=PEAK, duration=12.0)
        boundary = tv.boundary_limit(plant, wind, np.array([[1.0], [0.5], [0.0]]), "literal")
        needed = tv.required_deflection(plant, wind, 0.5)
        trim = tv.TriangularWind(peak=-0.3 * PEAK, duration=11.0)
        motion = tv.attitude_responses(plant, trim, wind, np.linspace(0.0, 20.0, 11))
        modes = tv.linear.all_modes(plant)
        c = plant.coefficients
        computed += [
            boundary.limit,
            boundary.switch_time,
            needed.deflection,
            *(motion[name] for name in motion.labels),
        ]
        computed += [modes.poles, modes.deflection_residues, c.pole, c.K1, plant.matrices()[0]]
        computed += [plant.numerator(o, i) for o in plant.outputs for i in INPUTS]
    fixed = Plant.from_vehicle(vehicle, "fixed-path")
    law = tv.TrimLaw(fixed)
    flown = tv.fly_many(
        Plant.from_vehicle(vehicle, model),
        law,
        wind,
        deflection_limit=np.array([0.008, 0.02]),
        sample_rate=10.0,
    )
    return [*computed, flown.peak_attitude, flown.peak_angle_of_attack]


@pytest.mark.parametrize("model", usual(MODELS, 2))
def test_without_damping_every_number_is_the_reports_to_the_last_bit(model, monkeypatch):
    with pinned(False):  # machine code that is loaded in between would round otherwise
        now = _answers(model)
        leave_damping_out(monkeypatch)
        before = _answers(model)
    assert len(now) == len(before) > 30
    for one, other in zip(now, before, strict=True):
        np.testing.assert_array_equal(one, other)
