"""Loops and their margins against python-control, the record, and the criteria that judge it."""

from dataclasses import replace

import control
import numpy as np
import pytest

from tests.margin_numbers import NUMBERS
from tests.turns import usual
from tvclin import Actuator, Autopilot, Coefficients, InputError, Plant
from tvclin.base import lines
from tvclin.control.margins.criteria import CRITERIA, Criteria, Criterion, margin_table
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.margins import loop_margins
from tvclin.linear.plant import MODELS

DRIFTING = Coefficients(
    mu_alpha=0.28, mu_delta=2.6, C1=0.025, C2=0.0036, b1=0.0284, b2=0.0169, q=1.7e-4
)
COURSE = Plant.from_coefficients(Coefficients(mu_alpha=0.228, mu_delta=1.317))


def course_loop(gain=1.0, delay=0.0):
    actuator = np.array([1, 35.14, 630.01])
    numerator = np.multiply(630.01 * 1.317, [1.59, 1.88])
    return Loop(gain * numerator, np.polymul([1, 0, -0.228], actuator), delay)


def bending_loop(delay=0.15):
    """Return the course booster with a bending mode that crosses |L| = 1 again."""
    numerator = np.polymul(1.317 * np.array([1.59, 1.88]), [1.6, 0.05, 25.0])
    denominator = np.polymul([1, 0, -0.228], [1, 0.05, 25.0])
    return Loop(3600 * numerator, np.polymul(denominator, [1, 84, 3600]), delay)


DRIFT = Loop(
    np.polymul([655, 491], [1, 0.0284]), np.polymul([1, 0.025, -0.28, 0.0036], [1, 35, 630])
)
LOOPS = {
    "course": course_loop(),
    "delayed": course_loop(delay=0.1),
    "drift": DRIFT,
    "bending": bending_loop(),
}
EACH = pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)


@pytest.mark.parametrize("loop", usual([course_loop(), DRIFT, bending_loop(0.0)], 2))
def test_python_control_gives_the_same_for_stable_loops(loop):
    system, m = control.tf(loop.numerator, loop.denominator), loop_margins(loop)
    assert m.stable
    factors, phases, _, at_phase, at_gain, _ = control.stability_margins(system, returnall=True)
    np.testing.assert_allclose(np.sort(at_gain), m.crossings.gain_frequencies, rtol=1e-6)
    np.testing.assert_allclose(
        np.sort(phases % 360), np.sort(np.degrees(m.crossings.phase_margins) % 360), rtol=1e-6
    )
    order = np.argsort(at_phase)
    np.testing.assert_allclose(at_phase[order], m.crossings.phase_frequencies, rtol=1e-6)
    np.testing.assert_allclose(factors[order], m.crossings.gain_factors, rtol=1e-6)
    alpha = control.disk_margins(system, np.geomspace(0.05, 100, 8_001), skew=0.0)[0]
    assert alpha * (1 - 1e-6) < m.disk_margin < alpha * (1 + 1e-9)
    for closed, expected in (
        (control.feedback(1, system), m.peak_sensitivity),
        (control.feedback(system, 1), m.peak_complementary_sensitivity),
    ):
        norm = control.system_norm(control.ss(closed), "inf", tol=1e-10)
        assert norm == pytest.approx(expected, rel=1e-8)


def test_an_unstable_loop_is_refused_where_python_control_shows_comfortable_margins():
    weak = Autopilot(attitude_gain=0.05, rate_gain=1.59, actuator=Actuator())  # a0 < B
    assert np.sum(weak.close(COURSE).poles().real > 0) == 1
    factor, phase_deg, *_ = control.margin(weak.loop(COURSE))
    assert factor > 2.0
    assert phase_deg > 45.0
    m = weak.margins(COURSE)
    assert np.all(np.isnan([getattr(m, name) for name in NUMBERS]))
    assert m.reason == (
        "the closed loop is unstable: 1 closed-loop pole lies in the right half plane"
    )


OPTIONS = {
    "gains alone": {},
    "alpha": {"alpha_gain": 0.07},
    "integral": {"integral_gain": 0.05},
    "first-order actuator": {"actuator": Actuator(natural_frequency=15.0, damping=None)},
    "everything": {"alpha_gain": 0.07, "integral_gain": 0.05, "actuator": Actuator()},
}


@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
@pytest.mark.parametrize("model", MODELS)
def test_the_polynomials_are_those_of_python_control(model, options):
    plant = Plant.from_coefficients(DRIFTING, model)
    autopilot = Autopilot(attitude_gain=0.3, rate_gain=0.4, **options)
    system, rational = autopilot.loop(plant), autopilot.rational_loop(plant)
    omega = np.array([[0.003, 0.1, 1.0], [4.0, 30.0, 200.0]])
    expected = system(1j * omega.ravel()).reshape(omega.shape)
    np.testing.assert_allclose(rational.response(omega), expected, rtol=1e-9)
    np.testing.assert_allclose(autopilot.frequency_response(plant, omega), expected, rtol=1e-9)
    poles = np.sort_complex(np.roots(rational.denominator))
    np.testing.assert_allclose(poles, np.sort_complex(system.poles()), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_systems_of_python_control_have_the_same_margins(model):
    plant = Plant.from_coefficients(DRIFTING, model)
    autopilot = Autopilot(attitude_gain=0.3, rate_gain=0.4, actuator=Actuator())
    system, expected = autopilot.loop(plant), autopilot.margins(plant)
    for loop in (Loop.from_system(system), Loop.from_system(control.tf(system))):
        margins = loop_margins(loop)
        for name in NUMBERS:
            assert getattr(margins, name) == pytest.approx(getattr(expected, name), rel=1e-6), name
    late = loop_margins(Loop.from_system(system, 0.05))
    assert late.delay_margin == pytest.approx(expected.delay_margin - 0.05, rel=1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Loop.from_system(control.frd([1, 2], [1, 2])), "a loop must be a control.State"),
        (lambda: Loop.from_system(1.0), "whose poles are known; got a float"),
        (lambda: Loop.from_system(control.ss(-np.eye(2), np.eye(2), np.eye(2), 0)), "one input"),
        (lambda: Loop.from_system(control.tf([1], [1, 1], 0.1)), "a pole at z = -1"),
        (lambda: Loop.from_system(control.tf([1, 0], [1, 1])), "an algebraic loop: .* actuator"),
        (lambda: Loop.from_system(control.tf([1], [1, 1]), -0.1), "delay must be zero or positive"),
        (lambda: Loop([1], [1, 1], -0.1), "delay must be zero or positive; got -0.1 s"),
        (lambda: Loop([1], [0, 1, 1]), "denominator must not begin with a zero"),
        (lambda: Loop([1], [[1, 1], [0, 1]]), "denominator must not begin with a zero"),
        (lambda: Loop([1, 2, 3], [1, 1]), r"\(numerator of degree 2 over 1\)"),
        (lambda: Loop([np.nan], [1, 1]), "numerator must be finite"),
        (lambda: Loop([[1], [2]], [[1, 1]] * 3), "broadcast together; got numerator"),
        (lambda: Loop([1], [1, 1]).response(np.inf), "omega must be finite"),
        (lambda: loop_margins(control.tf([1], [1, 1])), "loop must be a Loop .*from_system"),
    ],
)
def test_loops_that_cannot_be(make, message):
    with pytest.raises(InputError, match=message) as raised:
        make()
    assert "\n" not in str(raised.value)


def test_zeros_that_lead_the_numerator_do_not_count():
    for numerator in ([0, 0, 2.0, 3.0], [0, 2.0, 3.0], [2.0, 3.0]):
        loop = Loop(numerator, [1, 0, -0.5])
        np.testing.assert_array_equal(loop.numerator, [0, 2.0, 3.0])


def test_every_gain_crossover_is_found_and_the_least_phase_margin_decides():
    loop = bending_loop()
    m, above = loop_margins(loop), np.abs(loop.response(np.linspace(0.01, 80, 400_001))) > 1
    at, phases = m.crossings.gain_frequencies, m.crossings.phase_margins
    assert at.size == np.sum(above[1:] != above[:-1]) == 3
    assert np.all(np.diff(at) > 0)
    values = loop.response(at)
    np.testing.assert_allclose(np.abs(values), 1.0, rtol=1e-11)
    np.testing.assert_allclose(np.exp(1j * (np.pi + phases)), values, rtol=1e-11)
    decides = np.argmin(np.abs(phases))
    assert decides > 0  # not the first crossover, which is that of the rigid body
    assert (m.phase_margin, m.crossover_frequency) == (abs(phases[decides]), at[decides])


@EACH
def test_phase_crossovers_have_the_factors_that_make_the_loop_minus_one(loop):
    m = loop_margins(loop)
    at, factors = m.crossings.phase_frequencies, m.crossings.gain_factors
    assert np.all(np.diff(at) > 0)
    np.testing.assert_allclose(factors * loop.response(at), -1.0, rtol=1e-9)
    up, down = np.where(factors > 1, factors, np.inf), np.where(factors < 1, factors, 0)
    assert (m.gain_increase, m.gain_increase_frequency) == (up.min(), at[np.argmin(up)])
    assert (m.aero_margin, m.aero_frequency) == (1 / down.max(), at[np.argmax(down)])
    for factor in (m.gain_increase, 1 / m.aero_margin):
        edges = factor * np.array([[1 - 1e-9], [1 + 1e-9]])
        status = loop_margins(Loop(loop.numerator * edges, loop.denominator, loop.delay)).status
        assert sorted(status) == ["ok", "unstable"]


@pytest.mark.parametrize("loop", usual(LOOPS.values(), 2), ids=LOOPS)
def test_the_disk_is_the_largest_of_constant_factors_that_the_loop_bears(loop):
    m = loop_margins(loop)
    alpha, worst = m.disk_margin, -1 / loop.response(m.disk_frequency)
    e = 2 / alpha * (worst - 1) / (worst + 1)  # worst = (2 + alpha e)/(2 - alpha e)
    assert abs(e) == pytest.approx(1.0, rel=1e-9)
    rng = np.random.default_rng(5)
    inside = np.sqrt(rng.uniform(0, 0.998, 200)) * np.exp(2j * np.pi * rng.uniform(size=200))
    counts = unstable_with_factors(loop, alpha, np.append(inside, [0.999 * e, 1.001 * e]))
    np.testing.assert_array_equal(counts, [0] * 201 + [1])
    low, high = (2 - alpha) / (2 + alpha), (2 + alpha) / (2 - alpha)
    gains = np.linspace(low, high, 201)[1:-1, np.newaxis]
    assert loop_margins(Loop(loop.numerator * gains, loop.denominator, loop.delay)).stable.all()
    assert m.disk_margin_dB == pytest.approx(20 * np.log10(high), rel=1e-12)
    lag = np.exp(1j * np.radians(m.disk_phase_deg))
    assert 2 / alpha * abs((lag - 1) / (lag + 1)) == pytest.approx(1.0, rel=1e-12)


def unstable_with_factors(loop, alpha, e):
    """Return the unstable zeros of 1 + f L, f complex, by the argument over the whole axis."""
    near = loop_margins(loop).disk_frequency * np.linspace(0.98, 1.02, 4001)
    omega = np.sort(np.concatenate([np.geomspace(1e-4, 1e4, 20_000), near]))
    above, below = loop.form.parts(np.concatenate([-omega[::-1], [0.0], omega]))
    factor = (2 + alpha * e) / (2 - alpha * e)
    values = below + factor[:, np.newaxis] * above
    steps = np.angle(values[:, 1:] / values[:, :-1])
    assert np.abs(steps).max() < 2.0
    count = (loop.denominator.size - 1) / 2 - steps.sum(axis=1) / (2 * np.pi)
    assert np.abs(count - np.round(count)).max() < 0.1
    return np.round(count)


def assert_same(computed, expected, index, rtol=1e-11):
    """Margins of a batch at one index equal those of one loop, crossings too."""
    assert computed.status[index] == expected.status
    assert computed.unstable_poles[index] == expected.unstable_poles
    for name in NUMBERS:
        values = getattr(computed, name)[index], getattr(expected, name)
        np.testing.assert_allclose(*values, rtol=rtol, err_msg=name)
    for name in ("gain_frequencies", "phase_margins", "phase_frequencies", "gain_factors"):
        values, one = getattr(computed.crossings, name)[index], getattr(expected.crossings, name)
        # With a delay there are crossovers without end, and a batch may list more of them.
        np.testing.assert_allclose(values[: one.size], one, rtol=1e-9, err_msg=name)


def test_gains_and_plants_broadcast_and_every_element_is_that_of_a_single_call():
    coefficients = {"mu_alpha": np.array([0.1, 0.2, 0.28, 0.4]), "mu_delta": 2.6}
    gains = {"attitude_gain": np.array([[0.02], [0.3], [0.5]]), "rate_gain": 0.4}
    options = {"actuator": Actuator(), "delay": 0.03}
    plants = Plant.from_coefficients(Coefficients(**coefficients))
    many = Autopilot(**gains, **options).margins(plants)
    assert {np.shape(getattr(many, name)) for name in [*NUMBERS, "status"]} == {(3, 4)}
    assert many.crossings.phase_frequencies.shape[:2] == (3, 4)
    assert set(many.status.ravel()) == {"ok", "unstable"}
    for i, j in np.ndindex(3, 4):
        plant = Plant.from_coefficients(
            Coefficients(mu_alpha=coefficients["mu_alpha"][j], mu_delta=2.6)
        )
        autopilot = Autopilot(attitude_gain=gains["attitude_gain"][i, 0], rate_gain=0.4, **options)
        assert_same(many, autopilot.margins(plant), (i, j))


def test_numerators_of_different_degree_do_not_touch_each_other():
    numerators, denominator = [[0.0, 2.0, 1.2], [0.01, 2.0, 1.2], [0, 0, 0.1]], [1, 3, 3, 1, 0.5]
    many = loop_margins(Loop(numerators, denominator, 0.1))
    for k, numerator in enumerate(numerators):
        assert_same(many, loop_margins(Loop(numerator, denominator, 0.1)), k)


def test_a_batch_larger_than_what_is_worked_on_at_a_time():
    gains = np.geomspace(0.05, 30, 600)
    loop = course_loop(gains[:, np.newaxis], delay=np.where(np.arange(600) % 3, 0.05, 0.0))
    many = loop_margins(loop)
    assert many.status.shape == (600,)
    for k in (0, 255, 256, 257, 511, 512, 599):
        single = Loop(loop.numerator[k], loop.denominator[k], loop.delay[k])
        assert_same(many, loop_margins(single), k)
    good = many.status == "ok"
    assert good[300]
    assert not good[[0, 599]].any()
    np.testing.assert_allclose(many.aero_margin[good], 1.317 * 1.88 / 0.228 * gains[good])


def test_an_empty_batch_has_empty_margins():
    many = loop_margins(course_loop(np.zeros((0, 1))))
    assert many.status.shape == many.unstable_poles.shape == many.crossings.gain_factors.shape[:1]
    assert {getattr(many, name).shape for name in NUMBERS} == {(0,)}


def test_one_loop_gives_plain_python():
    m = loop_margins(course_loop())
    assert type(m.status) is str
    assert type(m.stable) is bool
    assert type(m.unstable_poles) is int
    names = ["aero_margin_dB", "gain_increase_dB", "phase_margin_deg", "disk_phase_deg"]
    names += [f"{name.removesuffix('_margin')}_frequency" for name in ("aero_margin", "disk")]
    assert {type(getattr(m, name)) for name in [*NUMBERS, *names]} == {float}
    assert (m.reason, m.notes) == ("", ())
    assert type(CRITERIA["classic"].are_satisfied(m)) is bool
    assert {type(one.satisfied) for one in CRITERIA["classic"].judge(m)} == {bool}


def test_decibels_and_degrees_are_those_of_the_factors():
    m = loop_margins(course_loop(np.array([[0.01], [1.0], [3.0]])))
    np.testing.assert_allclose(10 ** (m.aero_margin_dB / 20), m.aero_margin)
    np.testing.assert_allclose(10 ** (m.gain_increase_dB / 20), m.gain_increase)
    np.testing.assert_allclose(m.phase_margin_deg, m.phase_margin * 180 / np.pi)
    assert np.isnan([m.aero_margin_dB[0], m.gain_increase_dB[0], m.disk_margin_dB[0]]).all()
    assert m.stable.tolist() == [False, True, True]


@pytest.mark.parametrize(
    ("loop", "margin", "note"),
    [
        (Loop([0.5], [1, 1, 1]), "phase_margin", "the loop gain is one at no frequency"),
        (Loop([0.5], [1, 1, 1]), "delay_margin", "phase and delay margin inf"),
        (Loop([0.5], [1, 1, 1]), "aero_margin", "stable however far its gain falls"),
        (Loop([2.1, 2.5], [1, 0, -0.2]), "gain_increase", "stable however far its gain rises"),
    ],
)
def test_margins_that_do_not_exist_are_infinite_and_a_note_says_why(loop, margin, note):
    m = loop_margins(loop)
    assert m.stable
    assert getattr(m, margin) == np.inf
    assert note in " ".join(m.notes)
    assert sum("inf" in one for one in m.notes) == len(m.notes)


def test_an_unstable_loop_says_how_many_poles():
    m = loop_margins(course_loop(gain=30.0))
    assert m.reason.startswith("the closed loop is unstable: 2 closed-loop poles lie in the right")
    assert m.notes == (m.reason,)
    many = loop_margins(course_loop(np.array([[1.0], [30.0]])))
    with pytest.raises(InputError, match=r"of one loop; these are margins of a batch of shape"):
        _ = many.notes


def test_the_named_criteria_say_what_they_ask_for_and_where_it_comes_from():
    limits = {name: [r.limit for r in criterion.limits] for name, criterion in CRITERIA.items()}
    assert limits == {"classic": [6, 6, 30], "aircraft": [6, 6, 45]}
    for name, criteria in CRITERIA.items():
        assert criteria.name == name
        assert [r.unit for r in criteria.limits] == ["dB", "dB", "deg"]
        assert not any(r.is_upper_limit for r in criteria.limits)
        assert all(len(r.source) > 20 for r in criteria.limits)


def test_surplus_is_positive_where_a_requirement_is_met():
    m = loop_margins(course_loop())
    peak, phase = m.peak_sensitivity, m.phase_margin_deg
    for shift, satisfied in ((0.1, True), (0.0, True), (-0.1, False)):
        own = Criteria.custom(peak_sensitivity=peak + shift, phase_margin_deg=phase - shift)
        judged = own.judge(m)
        assert [one.value for one in judged] == [peak, phase]
        assert [one.surplus for one in judged] == pytest.approx([shift, shift], abs=1e-12)
        assert [one.satisfied for one in judged] == [satisfied, satisfied]
        assert own.are_satisfied(m) is satisfied
        assert [one.criterion.is_upper_limit for one in judged] == [True, False]
    assert not Criteria.custom(peak_sensitivity=peak + 1, phase_margin_deg=phase + 1).are_satisfied(
        m
    )


def test_criteria_of_a_batch_and_of_unstable_loops():
    m = loop_margins(course_loop(np.array([[0.01], [1.0], [10.0], [30.0]])))
    assert m.status.tolist() == ["unstable", "ok", "ok", "unstable"]
    expected = [False, True, False, False]
    assert CRITERIA["classic"].are_satisfied(m).tolist() == expected
    for one in CRITERIA["classic"].judge(m):
        assert np.isnan(one.surplus[[0, 3]]).all()
        assert not one.satisfied[[0, 3]].any()
    lenient = Criteria.custom(peak_sensitivity=1e9, disk_margin=0.0)
    assert lenient.are_satisfied(m).tolist() == [False, True, True, False]
    marginal = loop_margins(Loop([1], [1, 0, 1]))
    assert lenient.are_satisfied(marginal) is False
    assert CRITERIA["classic"].are_satisfied(loop_margins(Loop([2.1, 2.5], [1, 0, -0.2]))) is True


def test_criteria_of_ones_own():
    own = Criteria.custom("dispersed", "a memorandum", delay_margin=0.1, disk_margin=0.4)
    assert own.name == "dispersed"
    assert own.limits == (
        Criterion("delay_margin", 0.1, "a memorandum"),
        Criterion("disk_margin", 0.4, "a memorandum"),
    )
    assert [r.unit for r in own.limits] == ["s", ""]
    assert Criteria.custom(delay_margin=1).limits[0].source
    assert Criteria(own.name, list(own.limits)) == own


def test_criteria_are_changed_limit_by_limit_and_each_says_where_it_comes_from():
    own = Criteria.custom("own", "a memorandum", delay_margin=0.05, disk_margin=0.4)
    changed = own.with_limits("a letter", disk_margin=0.5, aero_margin_dB=6.0)
    assert changed.name == "own, with disk margin 0.5, aero margin 6 dB"
    assert changed.limits == (
        Criterion("delay_margin", 0.05, "a memorandum"),
        Criterion("disk_margin", 0.5, "a letter"),
        Criterion("aero_margin_dB", 6.0, "a letter"),
    )
    assert changed.description == "delay margin 50 ms, disk margin 0.5, aero margin 6 dB"
    assert own.with_limits("nobody") is own
    again = changed.with_limits("a call", disk_margin=0.6)
    assert again.name == "own, with disk margin 0.6, aero margin 6 dB"
    assert own.with_limits("a call", disk_margin=0.4).name == "own, with disk margin 0.4"


def test_what_is_asked_of_modes_can_be_set_apart():
    whole = Criteria.custom("both", aero_margin_dB=6.0)
    modes = {"mode_gain_margin_dB": 12.0, "mode_phase_margin_deg": 45.0}
    both = Criteria.custom("both", aero_margin_dB=6.0, **modes)
    assert (whole.has_mode_limits, both.has_mode_limits) == (False, True)
    assert both.without_mode_limits == whole.without_mode_limits == whole
    assert Criteria.custom(**modes).without_mode_limits is None
    classic = CRITERIA["classic"]
    assert classic.with_limits("a letter", **modes).without_mode_limits == classic
    changed = classic.with_limits("a letter", phase_margin_deg=35.0)
    assert changed.with_limits("a letter", **modes).without_mode_limits == changed


def test_a_judgement_is_told_with_its_source_and_of_the_whole_loop_without_a_band():
    (one,) = Criteria.custom("own", "a memorandum", disk_margin=0.4).judge(
        loop_margins(course_loop())
    )
    document = one.as_dict()
    assert [document[key] for key in ("margin", "limit", "source", "band")] == [
        *("disk_margin", 0.4, "a memorandum", None)
    ]
    assert (document["value"], document["surplus"], document["satisfied"]) == (
        one.value,
        one.surplus,
        True,
    )
    assert replace(one, band="slosh").as_dict()["band"] == "slosh"


def test_the_table_of_margins_has_gain_and_phase_below_the_disk_margin_and_limits_without_a_band():
    margins = loop_margins(course_loop())
    (judgement,) = Criteria.custom("own", disk_margin=0.4).judge(margins)
    in_band = replace(judgement, band="slosh", surplus=-1.0)
    rows = [
        [lines.text(cell) for cell in row]
        for row in margin_table(margins, (judgement, in_band)).rows
    ]
    labels = [row[0].strip() for row in rows]
    disk = labels.index("disk")
    assert labels.count("gain and phase") == 1
    assert labels[disk + 1] == "gain and phase"
    assert f"{margins.disk_margin_dB:.2f} dB" in rows[disk + 1][1]
    assert rows[disk][3:] == ["0.4", f"+{margins.disk_margin - 0.4:.3f} MET"]
    assert lines.text(judgement.shortfall).endswith(" short")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (Criteria.custom, "criteria need a limit: one or more of aero_margin_dB"),
        (lambda: Criteria.custom(phase_margin=30), "did you mean .*'phase_margin_deg'"),
        (
            lambda: Criteria.custom(phase_margin_deg=-30),
            "phase_margin_deg must be zero or positive",
        ),
        (lambda: Criteria.custom(delay_margin=np.nan), "delay_margin must be finite"),
        (lambda: Criteria.custom(delay_margin=[0.1, 0.2]), "delay_margin must be "),
        (lambda: Criterion("phase_margin", 30.0, "me"), "margin must be one of aero_margin_dB"),
        (lambda: Criterion("disk_margin", 0.4, 7), "source must be a text .*; got 7"),
        (lambda: Criteria(7, CRITERIA["classic"].limits), "name must be a text .*; got 7"),
        (lambda: Criteria("mine", ["disk_margin"]), "limits must be a tuple of Criterion"),
        (lambda: CRITERIA["classic"].with_limits(7, disk_margin=0.4), "source must be a text"),
        (lambda: CRITERIA["classic"].judge(6.0), "margins must be a Margins .*; got 6.0"),
    ],
)
def test_criteria_that_cannot_be(make, message):
    with pytest.raises(InputError, match=message):
        make()
