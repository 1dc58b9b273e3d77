"""The autopilot: the loop, open and closed, against hand algebra; python-control on both."""

import warnings
from math import factorial
from pathlib import Path
from textwrap import indent

import control
import matplotlib as mpl
import numpy as np
import pytest

from tests.turns import usual
from tvclin import (
    Actuator,
    Autopilot,
    Coefficients,
    InputError,
    Plant,
    TriangularWind,
    design_gains,
)
from tvclin.control import canonical_gains
from tvclin.linear.plant import MODELS

mpl.use("Agg")

COEFFICIENTS = Coefficients(
    mu_alpha=0.28, mu_delta=2.6, C1=0.025, C2=0.0036, b1=0.0284, b2=0.0169, q=1.7e-4
)
COURSE = Coefficients(mu_alpha=0.228, mu_delta=1.317)
GAINS = {"attitude_gain": 0.3, "rate_gain": 0.4}
EVERYTHING = {"alpha_gain": 0.07, "integral_gain": 0.05, "actuator": Actuator(), "delay": 0.04}
TRIANGLE = TriangularWind(peak=0.1, duration=8.0)
OPTIONS = {
    "gains alone": {},
    "alpha": {"alpha_gain": 0.07},
    "integral": {"integral_gain": 0.05},
    "actuator": {"actuator": Actuator()},
    "first-order actuator": {"actuator": Actuator(natural_frequency=15.0, damping=None)},
    "delay": {"delay": 0.04},
    "long delay of odd order": {"delay": 0.3, "pade_order": 3},
    "everything": EVERYTHING,
    "everything at the highest order": EVERYTHING | {"pade_order": 10},
}
CASES = [
    pytest.param(m, OPTIONS[k], id=f"{m}-{k}", marks=[pytest.mark.thorough] * bool((i + j) % 4))
    for i, m in enumerate(MODELS)
    for j, k in enumerate(OPTIONS)
]
"""Each option with one of the models in a usual run, and with all in a thorough one."""


def plant_of(model="fixed-path", coefficients=COEFFICIENTS):
    return Plant.from_coefficients(coefficients, model)


def pade(x, order):
    """Return the diagonal Pade approximation of e^(-x), from its definition."""
    terms = [
        factorial(2 * order - k) / factorial(k) / factorial(order - k) * (-x) ** k
        for k in range(order + 1)
    ]
    below = [term * (-1) ** k for k, term in enumerate(terms)]
    return sum(terms) / sum(below)


def by_hand(plant, options, s, late=None):
    """Return L, and every closed transfer function as {(output, input): value}, at one s."""
    a0, a1 = GAINS["attitude_gain"], GAINS["rate_gain"]
    b0, aI = options.get("alpha_gain", 0.0), options.get("integral_gain", 0.0)
    engine, actuator = 1.0, options.get("actuator")
    if actuator is not None:
        w, zeta = actuator.natural_frequency, actuator.damping
        engine = w / (s + w) if zeta is None else w**2 / (s**2 + 2 * zeta * w * s + w**2)
    if late is None:
        late = pade(s * options.get("delay", 0.0), options.get("pade_order", 4))

    def G(output, input):
        return complex(plant.tf(output, input)(s))

    def response(input):
        return (a0 + a1 * s + aI / s) * G("attitude", input) + b0 * G("angle_of_attack", input)

    L = -engine * late * response("deflection")
    deflection = {
        "wind": engine * late * response("wind") / (1 + L),
        "attitude_command": -engine * late * (a0 + aI / s) / (1 + L),
        "deflection_disturbance": 1 / (1 + L),
    }
    closed = {("deflection", source): value for source, value in deflection.items()}
    for output in plant.outputs:
        for source, value in deflection.items():
            wind = G(output, "wind") if source == "wind" else 0.0
            closed[output, source] = G(output, "deflection") * value + wind
    return L, closed


@pytest.fixture(scope="module")
def points():
    rng = np.random.default_rng(3)
    return rng.normal(size=6) + 1j * rng.normal(size=6)


@pytest.mark.parametrize(("model", "options"), CASES)
def test_loop_and_closed_loop_are_those_of_hand_algebra(model, options, points):
    plant, autopilot = plant_of(model), Autopilot(**GAINS, **options)
    loop, closed = autopilot.loop(plant), autopilot.close(plant)
    for s in points:
        L, expected = by_hand(plant, options, s)
        np.testing.assert_allclose(loop(s), L, rtol=1e-9)
        result = closed(s)
        assert result.size == len(expected)
        for (output, source), value in expected.items():
            cell = result[closed.find_output(output), closed.find_input(source)]
            np.testing.assert_allclose(cell, value, rtol=1e-9, atol=1e-12, err_msg=output)


@pytest.mark.parametrize(("model", "options"), CASES)
def test_the_order_is_minimal_and_the_poles_are_where_one_plus_loop_vanishes(model, options):
    plant, autopilot = plant_of(model), Autopilot(**GAINS, **options)
    loop, closed = autopilot.loop(plant), autopilot.close(plant)
    actuator = options.get("actuator")
    expected = (
        len(plant.states)
        + (0 if actuator is None else 1 if actuator.damping is None else 2)
        + (options.get("pade_order", 4) if "delay" in options else 0)
        + ("integral_gain" in options)
    )
    assert loop.nstates == closed.nstates == expected
    assert np.abs(np.subtract.outer(loop.poles(), loop.zeros())).min() > 1e-3  # none cancels
    for pole in closed.poles():
        # A pole is known to rounding, and 1 + L changes by its slope over that.
        step = 1e-6 * max(abs(pole), 1.0)
        slope = abs(loop(pole + step) - loop(pole - step)) / (2 * step)
        assert abs(1 + loop(pole)) < 1e-7 + 1e-8 * max(abs(pole), 1.0) * slope


@pytest.mark.parametrize(("model", "options"), CASES)
def test_signals_and_states_have_names_and_time_is_continuous(model, options):
    plant, autopilot = plant_of(model), Autopilot(**GAINS, **options)
    loop, closed = autopilot.loop(plant), autopilot.close(plant)
    assert loop.input_labels == ["deflection_command"]
    assert loop.output_labels == ["returned_command"]
    assert closed.input_labels == ["wind", "attitude_command", "deflection_disturbance"]
    assert closed.output_labels == [*plant.outputs, "deflection"]
    assert loop.state_labels == closed.state_labels
    assert loop.state_labels[: len(plant.states)] == list(plant.states)
    assert ("attitude_error_integral" in loop.state_labels) == ("integral_gain" in options)
    assert loop.dt == closed.dt == 0
    assert loop.name == f"{model} loop"
    assert closed.name == f"{model} with autopilot"


@pytest.mark.parametrize("model", MODELS)
def test_no_plant_passes_its_deflection_on_at_once(model):
    """So there is never an algebraic loop, with any gain, without actuator and without delay."""
    assert not plant_of(model).matrices()[3][:, 0].any()
    assert Autopilot(**GAINS, alpha_gain=1e6).loop(plant_of(model)).D.item() == 0.0


def test_the_published_course_booster():
    plant = plant_of(coefficients=COURSE)
    poles = Autopilot(attitude_gain=1.88, rate_gain=1.59).close(plant).poles()
    np.testing.assert_allclose(poles, [-1.047 + 1.073j, -1.047 - 1.073j], atol=1e-3)


@pytest.mark.parametrize("mu_delta", [2.6, -2.6])
def test_canonical_gains_make_the_natural_frequency_beta(mu_delta):
    c = COEFFICIENTS.replace(mu_delta=mu_delta)
    autopilot = canonical_gains(c)
    assert autopilot.attitude_gain == pytest.approx(2 * c.B)
    assert autopilot.rate_gain == pytest.approx(c.B / c.beta)
    result = _natural(autopilot, c)
    np.testing.assert_allclose(result, [[c.beta] * 2, [0.5] * 2], rtol=1e-12)


def _natural(autopilot, coefficients):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a soft design on a stable vehicle feeds back positively
        poles = autopilot.close(plant_of(coefficients=coefficients)).poles()
    return np.abs(poles), -poles.real / np.abs(poles)


@pytest.mark.parametrize("mu_alpha", [0.28, 0.0, -0.4])
@pytest.mark.parametrize("mu_delta", [2.6, -2.6])
@pytest.mark.parametrize("damping", [0.3, 0.7])
def test_design_gains_give_the_poles_asked_for(mu_alpha, mu_delta, damping):
    c = Coefficients(mu_alpha=mu_alpha, mu_delta=mu_delta)
    frequency, ratio = _natural(design_gains(c, natural_frequency=1.3, damping=damping), c)
    np.testing.assert_allclose(frequency, 1.3, rtol=1e-12)
    np.testing.assert_allclose(ratio, damping, rtol=1e-12)


def test_designs_pass_the_other_arguments_on():
    made = canonical_gains(COURSE, delay=0.02, integral_gain=0.1)
    assert (made.delay, made.integral_gain) == (0.02, 0.1)
    actuator = Actuator(natural_frequency=30.0)
    made = design_gains(COURSE, natural_frequency=1.0, damping=0.7, actuator=actuator)
    assert made.actuator is actuator


@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_attitude_hold_in_a_steady_wind(options):
    """Fixed path: alpha/alpha_w = -a0/(a0 - B); with an integral the attitude returns to zero."""
    a0, B, b0 = GAINS["attitude_gain"], COEFFICIENTS.B, options.get("alpha_gain", 0.0)
    closed = Autopilot(**GAINS, **options).close(plant_of())
    angle = control.dcgain(closed)[closed.find_output("angle_of_attack"), 0]
    expected = -1.0 if "integral_gain" in options else -a0 / (a0 + b0 - B)
    np.testing.assert_allclose(angle, expected, rtol=1e-9)


def test_the_attitude_follows_its_command():
    """Without integral the command is overshot by a0/(a0 - B), with it there is no error."""
    a0, B = GAINS["attitude_gain"], COEFFICIENTS.B
    for gain, expected in ((0.0, a0 / (a0 - B)), (0.05, 1.0)):
        closed = Autopilot(**GAINS, integral_gain=gain).close(plant_of())
        computed = control.dcgain(closed)[0, closed.find_input("attitude_command")]
        assert computed == pytest.approx(expected)


@pytest.mark.parametrize("actuator", [Actuator(), Actuator(natural_frequency=4.0, damping=None)])
def test_an_actuator_is_the_same_as_transfer_function_and_in_state_space(actuator, points):
    result = control.ss(*actuator.matrices())(points)
    np.testing.assert_allclose(result, actuator.tf()(points), rtol=1e-12)
    assert actuator.tf()(0.0) == 1.0
    assert actuator.tf().dt == 0
    assert actuator.tf().input_labels == ["deflection_command"]


@pytest.mark.parametrize(("model", "options"), CASES)
def test_the_frequency_response_has_the_exact_delay(model, options):
    plant, autopilot = plant_of(model), Autopilot(**GAINS, **options)
    omega = np.array([[0.05, 0.3, 1.0], [4.0, 30.0, 200.0]])
    result = autopilot.frequency_response(plant, omega)
    delay = options.get("delay", 0.0)
    for w, value in zip(omega.flat, result.flat, strict=True):
        exact, _ = by_hand(plant, options, 1j * w, late=np.exp(-1j * w * delay))
        np.testing.assert_allclose(value, exact, rtol=1e-11)
    few = omega.ravel()[:3]
    loop = autopilot.loop(plant)(1j * few)
    np.testing.assert_allclose(loop, result.ravel()[:3], rtol=1e-7)
    if not delay:
        np.testing.assert_allclose(
            autopilot.loop(plant)(1j * omega.ravel()), result.ravel(), rtol=1e-9
        )


def test_a_pade_of_higher_order_holds_to_higher_frequencies():
    errors = []
    for order in (2, 4, 6):
        autopilot = Autopilot(**GAINS, delay=0.1, pade_order=order)
        exact = autopilot.frequency_response(plant_of(), 20.0)
        errors.append(abs(autopilot.loop(plant_of())(20j) / exact - 1))
    assert errors[0] > 1e-2 > errors[1] > 1e-6 > errors[2]


def test_frequency_response_at_zero_and_at_a_pole():
    assert Autopilot(**GAINS).frequency_response(plant_of(), 0.0) == pytest.approx(
        -0.3 / COEFFICIENTS.B
    )
    integrating = Autopilot(**GAINS, integral_gain=0.05)
    assert np.isinf(integrating.frequency_response(plant_of(), 0.0))
    assert np.isinf(Autopilot(**GAINS).frequency_response(plant_of("drift"), [0.0, 1.0])[0])


@pytest.mark.parametrize("model", usual(MODELS, 2))
def test_python_control_works_on_both_by_name(model):
    autopilot = Autopilot(**GAINS, **EVERYTHING)
    loop, closed = autopilot.loop(plant_of(model)), autopilot.close(plant_of(model))
    step = control.step_response(closed, np.linspace(0, 20, 41))
    assert step.outputs["angle_of_attack", "wind"].shape == (41,)
    assert step.outputs["angle_of_attack", "wind"][0] == -1.0
    times = np.linspace(0, 20, 401)
    wind = np.interp(times, [0, 5, 10], [0, 0.1, 0])
    forced = control.forced_response(closed, times, [wind, 0 * wind, 0 * wind])
    assert forced.outputs["deflection"].shape == times.shape
    assert forced.inputs["wind"].max() == pytest.approx(0.1)
    assert control.bode_plot(loop) is not None
    assert control.root_locus_map(loop, gains=[0.5, 1.0]).loci.shape == (2, loop.nstates)
    mpl.pyplot.close("all")


@pytest.mark.parametrize("model", MODELS)
def test_nyquist_counts_the_unstable_poles_of_the_closed_loop(model):
    plant = plant_of(model)
    for scale in (1.0, 0.2):  # the second falls short of the aerodynamic moment
        gains = {name: scale * value for name, value in GAINS.items()}
        autopilot = Autopilot(**gains, actuator=Actuator(), delay=0.02)
        loop, closed = autopilot.loop(plant), autopilot.close(plant)
        unstable = int(np.sum(loop.poles().real > 1e-12))
        grown = int(np.sum(closed.poles().real > 1e-12))
        assert control.nyquist_response(loop).count == grown - unstable


def test_positive_feedback_is_called_so():
    plant = plant_of(coefficients=COEFFICIENTS.replace(mu_delta=-2.6))
    autopilot = Autopilot(**GAINS, integral_gain=0.1)
    for method in (autopilot.loop, autopilot.close, autopilot.margins):
        with pytest.warns(UserWarning, match="feedback") as seen:
            method(plant)
        assert [str(one.message).split(" is ")[0] for one in seen] == [
            "attitude_gain = 0.3",
            "rate_gain = 0.4",
            "integral_gain = 0.1",
        ]
        assert all(
            "positive feedback on a plant with mu_delta = -2.6" in str(s.message) for s in seen
        )
        assert Path(seen[0].filename).name == Path(__file__).name
    Autopilot(attitude_gain=-0.3, rate_gain=-0.4).loop(plant)


def test_missing_gains_are_called_so():
    with pytest.warns(UserWarning, match="rate_gain is zero: nothing damps the attitude"):
        Autopilot(attitude_gain=0.3, rate_gain=0.0).loop(plant_of())
    with pytest.warns(UserWarning, match="attitude_gain is zero: nothing holds the attitude"):
        Autopilot(attitude_gain=0.0, rate_gain=0.4).margins(plant_of())
    Autopilot(attitude_gain=0.0, rate_gain=0.4, alpha_gain=0.3).loop(plant_of())
    with pytest.warns(UserWarning, match=r"rate_gain = -0\.1 is positive feedback"):
        Autopilot(attitude_gain=0.3, rate_gain=[0.4, -0.1]).margins(plant_of())


def test_a_slow_actuator_is_called_so():
    slow = Autopilot(**GAINS, actuator=Actuator(natural_frequency=0.5))
    with pytest.warns(UserWarning, match=r"actuator, natural_frequency = 0\.5 rad/s, is slower"):
        slow.close(plant_of())
    slow.close(plant_of(coefficients=Coefficients(mu_alpha=-0.28, mu_delta=2.6)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"attitude_gain": np.nan}, "attitude_gain must be finite"),
        ({"rate_gain": np.inf}, "rate_gain must be finite"),
        ({"alpha_gain": "much"}, "alpha_gain must be a number"),
        ({"integral_gain": [0.1, 0.0]}, "integral_gain must be zero for all of a batch or for no"),
        ({"attitude_gain": [0.1, 0.2], "rate_gain": [1.0, 2.0, 3.0]}, "broadcast together; got"),
        ({"attitude_gain": 0.0, "rate_gain": 0.0}, "needs a gain; attitude_gain, .* all zero"),
        ({"delay": -0.01}, "delay must be zero or positive"),
        ({"pade_order": 0}, "pade_order must be an integer from 1 to 10; got 0"),
        ({"pade_order": 2.5}, "pade_order must be an integer"),
        ({"pade_order": True}, "pade_order must be an integer"),
        ({"actuator": 25.1}, "actuator must be an Actuator or None; got 25.1"),
        ({"attitude_gain": 1e200}, r"attitude_gain must be zero or 1e-30 to 1e\+09 in size; got 1"),
        ({"rate_gain": [1.0, -1e10]}, r"rate_gain must be zero or .* got -1e\+10"),
        ({"integral_gain": 1e-300}, r"integral_gain must be zero or 1e-30 to .* got 1e-300"),
        ({"delay": 1e-200}, r"delay must be zero or 1e-09 to 1e\+09 s in size; got 1e-200"),
        ({"delay": 1e10}, r"delay must be zero or 1e-09 to 1e\+09 s in size"),
    ],
)
def test_autopilots_that_cannot_be(arguments, message):
    with pytest.raises(InputError, match=message):
        Autopilot(**GAINS | arguments)


@pytest.mark.parametrize("gain", [1e9, 1.0, 1e-30])
@pytest.mark.parametrize("frequency", [1e9, 1e-9])
@pytest.mark.parametrize("delay", [0.0, 1e-9, 1e9])
def test_the_largest_and_smallest_numbers_do_not_overflow(gain, frequency, delay):
    actuator = Actuator(natural_frequency=frequency)
    autopilot = Autopilot(attitude_gain=gain, rate_gain=gain, actuator=actuator, delay=delay)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the slow actuator, and Pade's order
        for model in MODELS:
            assert autopilot.margins(plant_of(model)).status in {"ok", "unstable", "marginal"}
            assert np.all(np.isfinite(autopilot.close(plant_of(model)).poles()))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"natural_frequency": 0.0}, "natural_frequency must be positive; got 0 rad/s"),
        ({"damping": -0.7}, "damping must be positive"),
        ({"natural_frequency": 1e200}, r"natural_frequency must be between 1e-09 and 1e\+09; got"),
        ({"damping": 1e-300}, "damping must be between 1e-09 and"),
        ({"damping": np.nan}, "damping must be finite"),
        ({"natural_frequency": [1.0, 2.0], "damping": [0.5, 0.6, 0.7]}, "broadcast together"),
    ],
)
def test_actuators_that_cannot_be(arguments, message):
    with pytest.raises(InputError, match=message):
        Actuator(**arguments)


def test_python_control_systems_are_for_one():
    batch = plant_of(coefficients=COEFFICIENTS.replace(mu_alpha=[0.2, 0.3]))
    many = Autopilot(attitude_gain=[0.2, 0.3, 0.4], rate_gain=0.4)
    for autopilot, plant in ((Autopilot(**GAINS), batch), (many, plant_of())):
        for method in (autopilot.loop, autopilot.close):
            what = rf"{method.__name__}\(\) is for one autopilot and one plant; got .*margins\(\)"
            with pytest.raises(InputError, match=what):
                method(plant)
        for name in ("wind_response", "respond"):
            with pytest.raises(InputError, match=rf"^{name}\(\) is for one autopilot and one pl"):
                getattr(autopilot, name)(plant, TRIANGLE, *[[0.0]][: name == "respond"])
    with pytest.raises(InputError, match=r"for one actuator; got a batch of shape \(2,\)"):
        Actuator(natural_frequency=[20.0, 30.0]).tf()


def test_other_things_are_refused_by_name():
    with pytest.raises(InputError, match=r"plant must be a Plant .*; got StateSpace"):
        Autopilot(**GAINS).loop(plant_of().ss())
    with pytest.raises(InputError, match=r"plant must be a Coefficients .*; got StateSpace"):
        canonical_gains(plant_of().ss())
    with pytest.raises(InputError, match="aerodynamically unstable"):
        canonical_gains(Coefficients(mu_alpha=-0.28, mu_delta=2.6))
    with pytest.raises(InputError, match="damping must be positive"):
        design_gains(COURSE, natural_frequency=1.0, damping=0.0)
    with pytest.raises(InputError, match="omega must be finite"):
        Autopilot(**GAINS).frequency_response(plant_of(), [1.0, np.inf])


def test_the_diagram_of_the_autopilot_is_that_of_the_conventions():
    page = (Path(__file__).parents[2] / "docs/conventions.md").read_text()
    diagram = page.split("## The autopilot")[1].split("```")[1].strip()
    assert indent(diagram, 8 * " ") in Autopilot.__doc__


@pytest.mark.parametrize(("model", "options"), CASES)
def test_the_closed_loop_poles_are_those_of_the_system_that_python_control_has(model, options):
    plant, autopilot = plant_of(model), Autopilot(**GAINS, **options)
    expected = np.sort_complex(autopilot.close(plant).poles())
    result = np.sort_complex(autopilot.closed_loop_poles(plant))
    np.testing.assert_array_equal(result, expected)
