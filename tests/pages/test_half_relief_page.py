"""The page of half relief: its numbers are what brute flights with many stops need."""

import re
from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual

LINES = (Path(__file__).parents[2] / "docs" / "half-relief.md").read_text().splitlines()
FIXED, EXACT = (
    tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), model)
    for model in ("fixed-path", "drift-exact")
)
COEFFICIENTS, PEAK = FIXED.coefficients, np.radians(5.0)
BETA, TRIM = COEFFICIENTS.beta, COEFFICIENTS.B * PEAK
SERVO = tv.Actuator(natural_frequency=8.0 * np.pi, damping=0.7)
HALF, TRIM_LAW = tv.control.half_relief_gains(COEFFICIENTS), tv.TrimLaw(FIXED)
LEAN = tv.RecoverableAttitudeLaw(EXACT, design_peak=PEAK)
ABOVE = np.array([0.001, 0.01, 0.03, 0.06, 0.1])
"""Limits above the one that is shown, which must survive: windows of losses begin there."""
DURATIONS = (2, 3, 4, 6, 8, 12, 20)


def numbers(label: str, count: int) -> list[float]:
    """Return the numbers of the only row with this label and so many of them."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in LINES]
    computed = [re.split(", ", ", ".join(row[1:])) for row in rows if row[0] == label]
    (one,) = [row for row in computed if len(row) == count]
    return [float(number) for number in one]


def flown(law, plant, tau_beta, limits, stops=28, behind=(), **options):
    """Return which limits, over trim, bring back the triangle and all that stops of it are left."""
    whole = tv.TriangularWind(peak=PEAK, duration=tau_beta / BETA)
    parts = np.concatenate([np.linspace(0.0, 1.0, stops + 2)[1:-1], behind])
    winds = whole.before(np.append(parts * whole.duration, np.inf)[:, np.newaxis])
    options = {"actuator": SERVO, "sample_rate": 60.0} | options
    flights = tv.fly_many(plant, law, winds, deflection_limit=np.array(limits) * TRIM, **options)
    return np.all(flights.status == "survived", axis=0)


def is_needed(shown, step, law, plant, tau_beta, **options):
    """The number is the first of a scan in such steps above which all survive."""
    tried = [shown - 1.1 * step, *(shown + ABOVE)]
    survives = flown(law, plant, tau_beta, tried, **options)
    assert survives.tolist() == [False] + [True] * len(ABOVE), (tau_beta, shown)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("label", "law"),
    usual([("half relief", HALF), ("recoverable attitude", LEAN), ("trim", TRIM_LAW)], 0),
)
def test_what_the_laws_need_whole_and_with_stops(label, law):
    for tau_beta, shown in zip(DURATIONS, numbers(label, 7), strict=True):
        is_needed(shown, 0.002, law, EXACT, tau_beta)


def test_the_bound_beside_them():
    winds = tv.TriangularWind(peak=PEAK, duration=np.array(DURATIONS) / BETA)
    bounds = [
        tv.forecast_free_limit(EXACT, winds.case(k, winds.batch)).limit
        for k in range(len(DURATIONS))
    ]
    assert numbers("any law (bound of the fast mode)", 7) == pytest.approx(bounds, abs=5.1e-4)


@pytest.mark.thorough
@pytest.mark.parametrize("believed", usual(["0.8", "0.9", "1.1", "1.2"], 2))
def test_an_effectiveness_that_is_believed_wrongly(believed):
    own = COEFFICIENTS.replace(mu_delta=float(believed) * COEFFICIENTS.mu_delta)
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    wrong = tv.Plant.from_coefficients(own, plant.model)
    laws = tv.control.half_relief_gains(own), tv.RecoverableAttitudeLaw(wrong, design_peak=PEAK)
    shown = np.reshape(numbers(believed, 6), (2, 3))
    for law, row in zip(laws, shown, strict=True):
        for tau_beta, limit in zip((4, 8, 20), row, strict=True):
            is_needed(limit, 0.004, law, EXACT, tau_beta)


@pytest.mark.thorough
@pytest.mark.parametrize("label", usual([".50", ".52"], 0))
def test_the_balance_of_a_slow_nozzle(label):
    behind = 0.5 + np.linspace(0.0, 0.08, 33)
    poles = {"natural_frequency": 2.4 * BETA, "damping": 1.2, "alpha_ratio": float(label)}
    law = tv.control.relief_gains(COEFFICIENTS, **poles)
    for tau_beta, shown in zip((4, 8, 12, 20, 40), numbers(label, 5), strict=True):
        is_needed(shown, 0.002, law, FIXED, tau_beta, behind=behind)


CLIFF = [line.strip("| ").split(" | ") for line in LINES if re.match(r"\| [23]\.\d+, ", line)]


@pytest.mark.thorough
@pytest.mark.parametrize("row", usual(CLIFF, 0), ids=[row[0] for row in CLIFF])
def test_the_cliff(row):
    gains, lead, shown, lost = row
    frequency, damping, ratio = (float(n) for n in re.sub(r" \(.*", "", gains).split(", "))
    assert float(lead) == pytest.approx(2.0 * damping / frequency, abs=5.1e-3)
    law = tv.control.relief_gains(
        COEFFICIENTS, natural_frequency=frequency * BETA, damping=damping, alpha_ratio=ratio
    )
    limits = float(shown) - 0.0022, *(float(shown) + ABOVE)
    behind = 0.5 + np.linspace(0.0, 0.25, 20)
    every = {x: flown(law, EXACT, x, limits, behind=behind) for x in DURATIONS}
    survives = np.all(list(every.values()), axis=0)
    assert survives.tolist() == [False] + [True] * len(ABOVE)
    which = int(lost.split(" ")[-1].removeprefix("$\\tau\\beta$ = "))
    assert not every[which][0]
    whole = flown(law, EXACT, which, limits[:1], stops=0)[0]
    assert whole == lost.startswith("stop")


ESTIMATED = [line for line in LINES if re.match(r"\| (a vane|20|10|5|3|2|1) \| ", line)]


@pytest.mark.thorough
@pytest.mark.parametrize(
    "label", usual([line.strip("| ").split(" | ")[0] for line in ESTIMATED], 0, 3)
)
def test_what_a_wind_estimator_costs(label):
    law = tv.SaturatedLaw(HALF)
    if label != "a vane":
        law = tv.control.EstimatedLaw(law, tv.control.WindEstimator(bandwidth=float(label)), FIXED)
    step = 0.002 if label == "a vane" else 0.004
    behind = 0.5 + np.linspace(0.0, 0.25, 10)
    for tau_beta, shown in zip((2, 4, 8, 20), numbers(label, 4), strict=True):
        is_needed(shown, step, law, EXACT, tau_beta, behind=behind)


PROSE = " ".join(" ".join(LINES).split())
WINDS = {
    r"needs (\S+) at .{1,20} = 4\$ and (\S+) at 8\. A jump": "full reversal",
    r"side needs (\S+) and (\S+) \(with": "flip to 0.3",
}


@pytest.mark.parametrize(("words", "name"), WINDS.items(), ids=WINDS.values())
def test_what_other_winds_ask_for(words, name):
    ((short, long),) = re.findall(words, PROSE)
    for shown, tau_beta in ((float(short), 4), (float(long), 8)):
        wind = tv.design.standard_winds(PEAK, tau_beta / BETA)[name]
        tried = (shown + np.array([-0.009, 0.006, 0.02, 0.05, 0.1])) * TRIM
        options = {"actuator": SERVO, "sample_rate": 60.0}
        flights = tv.fly_many(EXACT, HALF, wind, deflection_limit=tried, **options)
        assert (flights.status == "survived").tolist() == [False, True, True, True, True]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "durations", "options"),
    [
        (r"1 deg/s needs (\S+), (\S+), (\S+) \(", (4, 8, 20), {"rate_limit": np.radians(1.0)}),
        (r"200 ms (\S+) is needed at", (8,), {"delay": 0.2}),
    ],
)
def test_what_slow_hardware_asks_for(words, durations, options):
    (computed,) = re.findall(words, PROSE)
    stops = 9 if "rate_limit" in options else 28
    for shown, tau_beta in zip(np.atleast_1d(computed), durations, strict=True):
        is_needed(float(shown), 0.006, HALF, EXACT, tau_beta, stops=stops, **options)


@pytest.mark.thorough
def test_a_rate_limit_of_2_degrees_changes_nothing():
    needed = dict(zip(DURATIONS, numbers("half relief", 7), strict=True))
    for tau_beta in (4, 8, 20):
        shown = needed[tau_beta]
        is_needed(shown, 0.003, HALF, EXACT, tau_beta, rate_limit=np.radians(2.0))


@pytest.mark.thorough
def test_the_other_configuration():
    ((low, high),) = re.findall(r"Configuration II needs (\S+) to (\S+) \(", PROSE)
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-ii"), "drift-exact")
    law, c = tv.control.half_relief_gains(plant.coefficients), plant.coefficients
    for tau_beta, shown in ((2, low), (20, high)):
        whole = tv.TriangularWind(peak=PEAK, duration=tau_beta / c.beta)
        stops = np.append(np.linspace(0.0, whole.duration, 30)[1:-1], np.inf)[:, np.newaxis]
        tried = (float(shown) + np.array([-0.0022, *ABOVE])) * c.B * PEAK
        options = {"actuator": SERVO, "sample_rate": 60.0}
        flights = tv.fly_many(plant, law, whole.before(stops), deflection_limit=tried, **options)
        survives = np.all(flights.status == "survived", axis=0)
        assert survives.tolist() == [False] + [True] * len(ABOVE)


@pytest.mark.thorough
def test_long_winds_with_drift():
    is_needed(0.556, 0.003, HALF, EXACT, 40, actuator=None, sample_rate=100.0)
    is_needed(0.508, 0.003, HALF, EXACT, 20, actuator=None, sample_rate=100.0)
    assert ".508 at $\\tau\\beta = 20$, .556 at 40 (ideal nozzle, 100 Hz)" in PROSE
