"""Margins and flights are of one loop: the same step, by what either says and by another way."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from scipy.linalg import expm

import tvclin as tv
from tests.turns import drawn
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.sampled_stability import equilibrium_step

VEHICLE = tv.load_vehicle("made-up-booster")
STRUCTURE = VEHICLE.structure
WIND = tv.TriangularWind(peak=0.05, duration=8.0)
MODELS = ("fixed-path", "drift-exact", "drift-and-speed")
RIGID = [tv.Plant.from_vehicle(VEHICLE, model) for model in (*MODELS, "drift")]
FLEXIBLE = [tv.FlexiblePlant.from_vehicle(VEHICLE, STRUCTURE, model) for model in MODELS]


@st.composite
def loops(draw):
    """A plant and a sampled autopilot with gains, filters, delay and nozzle of all kinds."""
    flexible = draw(st.booleans())
    plant = draw(st.sampled_from(FLEXIBLE if flexible else RIGID))
    rate = draw(st.floats(4.0, 60.0))
    periods = draw(st.one_of(st.integers(0, 3).map(float), st.floats(0.001, 3.0)))
    frequency = draw(st.floats(3.0, 130.0))
    damping = draw(st.floats(0.3, 1.5)) if flexible else draw(st.none() | st.floats(0.3, 1.5))
    # rounded, so that no own frequency of a filter is above half the rate
    own = st.floats(0.05, 0.9).map(lambda part: part * np.pi * rate)
    filters = {
        "filters": draw(
            st.lists(own.map(lambda w: tv.vehicle.Filter.low_pass(w, 0.7)), max_size=1)
        ),
        "attitude_filters": draw(
            st.lists(own.map(lambda w: tv.vehicle.Filter.notch(w, 0.1, 0.6)), max_size=1)
        ),
        "rate_filters": draw(st.lists(own.map(tv.vehicle.Filter.low_pass), max_size=1)),
    }
    autopilot = tv.Autopilot(
        attitude_gain=draw(st.floats(0.05, 2.0)),
        rate_gain=draw(st.floats(0.05, 2.0)),
        alpha_gain=draw(st.sampled_from([0.0, 0.1, -0.1])),
        integral_gain=draw(st.just(0.0) | st.floats(0.001, 2.0)),
        actuator=draw(
            (st.nothing() if flexible else st.none())
            | st.just(tv.Actuator(natural_frequency=frequency, damping=damping))
        ),
        delay=periods / rate,
        sample_rate=rate,
        **{name: tuple(chain) for name, chain in filters.items()},
    )
    return plant, autopilot


def flown_step(plant, autopilot):
    """The step of a flight near rest."""
    law = tv.SaturatedLaw(replace(autopilot, actuator=None, delay=0.0, sample_rate=None))
    length = 1.0 / autopilot.sample_rate
    return equilibrium_step(
        one_flight(plant, law, WIND, 0.1, Hardware(length, autopilot.delay, autopilot.actuator))
    )


def rates_of(plant, engine):
    """Of the states of plant and nozzle, and last of the command, which is held."""
    A, B, _, _ = plant.matrices()
    n = len(A)
    whole, turned = np.zeros((n + 3, n + 3)), np.zeros(n + 3)
    whole[:n, :n] = A
    order = 0 if engine is None else 1 if engine.damping is None else 2
    turned[n if order else n + 2] = 1.0
    if order:
        w, row = engine.natural_frequency, np.zeros(n + 3)
        if order == 1:
            row[[n, n + 2]] = -w, w
        else:
            whole[n, n + 1] = 1.0
            row[[n, n + 1, n + 2]] = -(w**2), -2.0 * engine.damping * w, w**2
        whole[n + order - 1] = row
        if B.shape[1] > 2:
            whole[:n] += np.outer(B[:, 2], row)
    whole[:n] += np.outer(B[:, 0], turned)
    kept = [*range(n + order), n + 2]
    return whole[np.ix_(kept, kept)]


def independent_step(plant, autopilot):
    """The step by exponentials of all that moves between two commands, written out by hand.

    The states are those of the plant, of the nozzle, of the filters, the integral, and the last
    commands.
    """
    C, h = plant.matrices()[2], 1.0 / autopilot.sample_rate
    whole = rates_of(plant, autopilot.actuator)
    n, hardware = C.shape[1], len(whole) - 1
    names = ("attitude", "attitude_rate", "angle_of_attack")
    rows = [
        plant.outputs.index(f"sensed_{k}" if f"sensed_{k}" in plant.outputs else k) for k in names
    ]
    sensed = C[rows]
    chains = []
    for name in ("attitude_filters", "rate_filters", "filters"):
        for one in getattr(autopilot, name):
            own = abs(one.denominator[-1]) ** (1.0 / one.order)
            c, (a, b, cc, d) = own / np.tan(0.5 * own * h), one.matrices()
            inverse = np.linalg.inv(c * np.eye(len(a)) - a)
            # x[k+1] from s = c (z - 1)/(z + 1), with states that jump by half a step
            chains.append(
                (
                    name,
                    inverse @ (c * np.eye(len(a)) + a),
                    2 * c * inverse @ b,
                    cc @ inverse,
                    d + cc @ inverse @ b,
                )
            )
    count = int(np.floor(autopilot.delay / h + 1e-9))
    rest = max(autopilot.delay - count * h, 0.0)
    rest = rest if rest > 1e-9 * h else 0.0
    filter_order = sum(len(chain[1]) for chain in chains)
    integral = int(autopilot.integral_gain != 0.0)
    size = hardware + filter_order + integral + count + 1  # commands c[k-1], c[k-2], ..
    unit = np.eye(size)
    x, place = unit[:hardware], hardware
    signal = {"attitude_filters": sensed[:1] @ x[:n], "rate_filters": sensed[1:2] @ x[:n]}
    memory = np.zeros((filter_order + integral, size))
    done = 0

    def passed(name, given):
        nonlocal place, done
        for kind, a, b, c, d in chains:
            if kind == name:
                own = unit[place : place + len(a)]
                memory[done : done + len(a)] = a @ own + b @ given
                given = c @ own + d @ given
                place, done = place + len(a), done + len(a)
        return given

    attitude = passed("attitude_filters", signal["attitude_filters"])
    rate = passed("rate_filters", signal["rate_filters"])
    request = (
        autopilot.attitude_gain * attitude
        + autopilot.rate_gain * rate
        + autopilot.alpha_gain * sensed[2:] @ x[:n]
    )
    if integral:
        held = unit[hardware + filter_order : hardware + filter_order + 1]
        request = request + autopilot.integral_gain * held
        memory[-1:] = held + h * attitude
    command = passed("filters", request)
    commands = np.vstack([command, unit[hardware + filter_order + integral :]])
    moved = x
    for late, length in ((count + 1, rest), (count, h - rest)):
        step = expm(whole * length)[:-1]
        moved = step[:, :-1] @ moved + step[:, -1:] @ commands[late : late + 1]
    return np.vstack([moved, memory, commands[:-1]])


def same_spectrum(one, other, tolerance):
    """Whether characteristic polynomials agree on a circle, of one degree or with poles at zero."""
    at = 1.3 * np.abs(one).max() * np.exp(1j * np.linspace(0.1, 3.0, 7))
    values = [
        np.prod(1.0 - np.append(poles, np.zeros(1))[np.newaxis] / at[:, np.newaxis], axis=1)
        for poles in (one, other)
    ]
    return np.abs(values[0] / values[1] - 1.0).max() < tolerance


def agreed(plant, autopilot):
    """Hold margins, flight and the independent step to each other."""
    margins = autopilot.exact_loop(plant).closed_loop_poles
    flight = np.linalg.eigvals(flown_step(plant, autopilot))
    other = np.linalg.eigvals(independent_step(plant, autopilot))
    assert same_spectrum(margins, flight, 1e-11)
    assert same_spectrum(margins, other, 1e-9)
    sizes = [np.abs(one).max() for one in (margins, flight, other)]
    # A multiple root at the edge moves by the root of the rounding.
    assert np.ptp(sizes) < 1e-6 * max(sizes)
    return sizes


@drawn(25, 1000, loops())
def test_margins_and_flights_are_of_one_loop(loop):
    agreed(*loop)


def test_a_loop_with_a_strong_integral_stands_or_falls_alike():
    """By the trapezoidal rule the margins would call it stable; flown it grows."""
    autopilot = tv.Autopilot(
        attitude_gain=0.594,
        rate_gain=1.59,
        integral_gain=1.929,
        actuator=tv.Actuator(natural_frequency=8.016),
        delay=0.098,
        sample_rate=11.17,
    )
    plant = RIGID[1]
    radius = agreed(plant, autopilot)[0]
    assert radius > 1.002
    trapezoid = replace(autopilot, attitude_gain=0.594 + 0.5 * 1.929 / 11.17)
    assert np.abs(trapezoid.exact_loop(plant).closed_loop_poles).max() < 1.0
