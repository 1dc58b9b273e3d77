"""Systems put together by names: beside python-control, scipy, and equations written out."""

import control
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import cont2discrete

import tvclin as tv
from tests.flexible import transfer
from tvclin.linear.system import LinearSystem, connect, gain

RNG = np.random.default_rng(4)


def system(order, inputs, outputs, name, through=True):
    """A random stable system."""
    A = RNG.normal(size=(order, order)) - 2.0 * np.eye(order)
    B, C = RNG.normal(size=(order, len(inputs))), RNG.normal(size=(len(outputs), order))
    D = RNG.normal(size=(len(outputs), len(inputs))) * through
    states = tuple(f"{name}_{k}" for k in range(order))
    return LinearSystem(A, B, C, D, inputs, outputs, states)


PLANT = system(3, ("u", "w"), ("y", "z"), "plant", through=False)
LAW = system(2, ("error",), ("demand",), "law")
ERROR = gain("error", {"command": 1.0, "y": -1.0})
NAMES = (("command", "w", "u"), ("y", "z", "demand", "u"))
POINTS = np.array([0.3 + 0.2j, 4j, 1.0])


def test_a_diagram_is_that_of_python_control():
    """Its sums by name, and an input from outside that is added to a signal of the same name."""
    blocks = [PLANT, LAW, ERROR, gain("u", {"demand": 1.0})]
    result = connect(blocks, *NAMES)
    theirs = control.interconnect(
        [
            PLANT.to_control("plant"),
            LAW.to_control("law"),
            control.summing_junction(["command", "-y"], "error"),
            control.summing_junction(["demand", "push"], "u"),
        ],
        inputs=["command", "w", "push"],
        outputs=["y", "z", "demand", "u"],
    )
    assert result.states == (*PLANT.states, *LAW.states)
    for s in POINTS:
        np.testing.assert_allclose(transfer(result.matrices(), s), theirs(s), rtol=1e-10)
    np.testing.assert_allclose(np.sort_complex(result.poles), np.sort_complex(theirs.poles()))


def test_a_loop_may_be_closed_by_feedback():
    broken = connect([PLANT, LAW, ERROR], ("command", "w", "u"), ("y", "demand"))
    whole = connect([PLANT, LAW, ERROR, gain("u", {"demand": 1.0})], *NAMES)
    closed = broken.feedback("demand", "u")
    assert closed.inputs == ("command", "w", "u")
    expected = whole.select(closed.inputs, ("y", "demand"))
    for s in POINTS:
        there = transfer(expected.matrices(), s)
        np.testing.assert_allclose(transfer(closed.matrices(), s), there, rtol=1e-10)


def test_a_series_is_the_product():
    first, second = (system(2, ("a",), ("b",), name) for name in ("one", "two"))
    for s in POINTS:
        one, two = (transfer(part.matrices(), s) for part in (first, second))
        transfer_function = transfer(first.series(second).matrices(), s)
        np.testing.assert_allclose(transfer_function, two @ one, rtol=1e-12)


def test_a_signal_that_follows_itself_at_once_is_refused():
    with pytest.raises(tv.InputError, match="algebraic loop"):
        connect([LAW, gain("error", {"demand": 0.5})], (), ("demand",))
    with pytest.raises(tv.InputError, match="one system"):
        LinearSystem(
            np.zeros((2, 1, 1)), *(np.ones((1, 1)),) * 3, ("u",), ("y",), ("x",)
        ).to_control("many")


@pytest.mark.parametrize("samples", [0.0, 0.3, 1.0, 2.0, 2.75])
def test_steps_are_exact_and_a_delay_splits_a_sample(samples):
    """Against scipy where the delay is whole, and else the command followed from part to part."""
    h, one = 0.2, PLANT.select(("u",), ("y",))
    steps = one.to_steps(h, samples * h)
    A, B, C, D, _ = cont2discrete(one.matrices(), h)
    commands = RNG.normal(size=9)
    whole = np.zeros((4, 4))
    whole[:3] = np.column_stack([one.A, one.B])
    x, state = np.zeros(3), np.zeros(len(steps.states))
    count, rest = int(samples), (samples - int(samples)) * h
    for k in range(9):
        np.testing.assert_allclose(steps.C @ state, C @ x, rtol=1e-9, atol=1e-12)
        sent = [commands[j] if j >= 0 else 0.0 for j in (k - count - 1, k - count)]
        if rest:
            for part, command in zip((rest, h - rest), sent, strict=True):
                x = (expm(whole * part) @ np.append(x, command))[:3]
        else:
            x = A @ x + B[:, 0] * sent[1]
        state = steps.A @ state + steps.B[:, 0] * commands[k]
    assert not np.any(D)


def test_a_batch_is_each_of_it():
    periods, delays = np.array([[0.1], [0.2]]), np.array([0.0, 0.25, 0.1])
    one = PLANT.select(("u",), ("y",))
    every = one.to_steps(periods, delays)
    assert every.batch == (2, 3)
    z = np.exp(0.4j)
    for place in np.ndindex(2, 3):
        single = one.to_steps(periods[place[0], 0], delays[place[1]])
        computed = transfer(every.matrices(), z)[place]
        assert computed == pytest.approx(transfer(single.matrices(), z), rel=1e-9)
    few = every.cases(np.array([4, 1]), (2, 3))
    np.testing.assert_array_equal(few.A, every.A.reshape(6, *every.A.shape[-2:])[[4, 1]])
