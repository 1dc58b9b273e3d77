"""Filters of an autopilot as files and the command line name them."""

import json
import re
import tomllib

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.control.autopilot.design_rules import AutopilotDesign
from tvclin.studyfile.parse import parse_study
from tvclin.vehicle.filters import filter_cells

TABLES = """
[autopilot]
attitude_gain = 0.36
rate_gain_s = 0.56

[[autopilot.filter]]
kind = "notch"
frequency_Hz = 12
zero_damping = 0.05
pole_damping = 0.5

[[autopilot.filter]]
kind = "low-pass"
frequency_rad_per_s = 60
damping = 0.7
on = "rate"

[[autopilot.filter]]
kind = "lead-lag"
zero_rad_per_s = -8
pole_Hz = 2
on = "attitude"

[[autopilot.filter]]
kind = "rational"
numerator = [1, 2]
denominator = [1, 3, 9]
"""
STUDY = """
[study]
vehicle = "configuration-i"

[wind]
shape = "triangular"
peak_deg = 5
duration_s = 7.5
"""


def table(text=TABLES):
    return tomllib.loads(text)["autopilot"]


def test_a_file_names_the_filters_of_each_place():
    request = AutopilotDesign.from_table(table())
    s = 1j * np.array([0.3, 5.0, 75.0])
    w = 24.0 * np.pi
    notch = (s**2 + 0.1 * w * s + w**2) / (s**2 + 1.0 * w * s + w**2)
    wanted = {
        "filters": [notch, (s + 2.0) / (s**2 + 3.0 * s + 9.0)],
        "rate_filters": [3600.0 / (s**2 + 84.0 * s + 3600.0)],
        "attitude_filters": [(1.0 - s / 8.0) / (1.0 + s / (4.0 * np.pi))],
    }
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    for name, values in wanted.items():
        chain = getattr(request.autopilot(plant), name)
        assert len(chain) == len(values)
        for one, value in zip(chain, values, strict=True):
            np.testing.assert_allclose(one(s), value, rtol=1e-13)


def test_a_study_file_takes_them_and_a_rule_keeps_them():
    plan = parse_study(tomllib.loads(STUDY + TABLES))
    assert len(plan.design.filters) == 2
    rule = STUDY + TABLES.replace(
        "attitude_gain = 0.36\nrate_gain_s = 0.56", 'design = "canonical"'
    )
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    assert len(parse_study(tomllib.loads(rule)).design.autopilot(plant).rate_filters) == 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('kind = "notch"\n', "", "filter 1 of the autopilot: a key is missing in .*: kind"),
        ('"notch"', '"comb"', "filter 1 of the autopilot: kind must be one of notch, low-pass"),
        ("zero_damping = 0.05\n", "", "filter 1 .*: zero_damping"),
        ('on = "rate"', 'on = "roll"', "filter 2 .*on must be one of sum, attitude, rate"),
        ("damping = 0.7", "pole_damping = 0.7", "a low-pass filter takes frequency, damping; got"),
        ("frequency_Hz", "frequency", "frequency has no known unit in .*autopilot.filter"),
        ("[1, 2]", '[1, "two"]', r"numerator\[1\] must be a number"),
        ("[1, 2]", "[1, 2, 3, 4]", "numerator must not be of higher degree"),
    ],
)
def test_a_wrong_filter_is_named_in_one_sentence(old, new, message):
    with pytest.raises(tv.InputError, match=message):
        AutopilotDesign.from_table(table(TABLES.replace(old, new, 1)))


def test_what_is_no_table_of_filters_is_refused():
    with pytest.raises(tv.InputError, match="filter in .autopilot. must be a list"):
        AutopilotDesign.from_table({"filter": "notch"})
    with pytest.raises(tv.InputError, match=r"must be given as \[\[autopilot.filter\]\]"):
        AutopilotDesign.from_table({"filter": [1]})


def margins(*more):
    gains = ("--attitude-gain", "0.36", "--rate-gain", "0.56", "--delay-ms", "20")
    return CliRunner().invoke(app, ["margins", "made-up-booster", *gains, *more])


FIRST = "autopilot.filter.1"
_NOTCH = '{kind="notch", frequency_Hz=5.1, zero_damping=0.06, pole_damping=0.6}'
FILTERS = (
    "--set",
    f'autopilot.filter=[{_NOTCH}, {{kind="low-pass", frequency_Hz=2.1, damping=0.95}}]',
)


MADE = tv.vehicle.Filter
LOOP_FILTERS = [
    MADE.lead_lag(2.0, 5.0),
    MADE.lead_lag(-2.0, 5.0),
    MADE.low_pass(3.0),
    MADE.low_pass(13.0, 0.95),
    MADE.notch(32.0, 0.06, 0.6),
    MADE.notch(3.0, 0.0, 0.5),
    MADE.notch(3.0, -0.1, 2.0),
    MADE.from_coefficients([2.0, 0.0], [1.0, 3.0, 7.0]),
    MADE.from_coefficients([2.0], [1.0, 0.0]),
    MADE.from_coefficients([0.5], [2.0]),
]


@pytest.mark.parametrize("rate", usual([None, 25.0], 1))
def test_the_command_line_has_filters_and_a_sample_rate(rate):
    sampled = () if rate is None else ("--sample-rate", str(rate))
    result = margins(*FILTERS, *sampled, "--json")
    document = json.loads(result.stdout)
    name = "made-up-booster"
    plant = tv.linear.plant_of(tv.load_vehicle(name))
    hertz = 2.0 * np.pi
    expected = tv.Autopilot(
        attitude_gain=0.36,
        rate_gain=0.56,
        delay=0.02,
        actuator=tv.Actuator(),
        filters=(
            tv.vehicle.Filter.notch(5.1 * hertz, 0.06, 0.6),
            tv.vehicle.Filter.low_pass(2.1 * hertz, 0.95),
        ),
        sample_rate=rate,
    ).margins(plant)
    assert document["stable"]
    computed = document["margins"]
    for margin in ("gain_increase_dB", "phase_margin_deg"):
        assert computed[margin] == pytest.approx(getattr(expected, margin), rel=1e-9)
    assert computed["delay_margin_s"] == pytest.approx(expected.delay_margin, rel=1e-9)
    poles = document["closed_loop_poles" if rate is None else "closed_loop_poles_z"]
    values = [complex(p["real"], p["imag"]) for p in poles]
    assert max(abs(z) for z in values) < 1 if rate else max(s.real for s in values) < 0
    shown = margins(*FILTERS, *sampled, "--more").output
    assert re.search(r"behind the sum, 1 +32.044 rad/s, +32.044 rad/s, damping +1 at rest", shown)
    assert re.search(r"behind the sum, 2 +none +13.195 rad/s, damping +1 at rest", shown)
    assert ("25 Hz" in shown) == (rate is not None)


@pytest.mark.parametrize("filter", LOOP_FILTERS, ids=str)
def test_a_filter_can_be_built_again_from_the_numbers_that_tables_show(filter):
    cells = sum(filter_cells(filter, "f"), ())
    numbers = {part.name: part.value for part in cells if not isinstance(part, str)}

    def powers(kind):
        result = np.ones(1)
        for key, value in numbers.items():
            if not key.startswith(f"f.{kind}"):
                continue
            if key.endswith(".frequency"):
                damping = numbers[key.replace("frequency", "damping")]
                result = np.polymul(result, [1.0, 2.0 * damping * value, value**2])
            elif not key.endswith(".damping"):
                result = np.polymul(result, [1.0, -value])
        return result

    above, below = powers("zeros"), powers("poles")
    gain = numbers.get("f.lead", numbers.get("f.rest", 0.0) * below[-1] / (above[-1] or 1.0))
    np.testing.assert_allclose(below, filter.denominator, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(gain * above, np.trim_zeros(filter.numerator, "f"), rtol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--set", f"{FIRST}.kind=notch", "--set", f"{FIRST}.frequency_Hz=12"), "zero_damping"),
        (
            ("--set", f"{FIRST}.kind=low-pass", "--set", f"{FIRST}.frequency_Hz=-1"),
            "must be between",
        ),
        (("--set", f"{FIRST}.kind=nich"), "did you mean 'notch'"),
        (("--set", f"{FIRST}.freqency_Hz=3"), "did you mean frequency_Hz"),
        (("--sample-rate", "0"), "--sample-rate must be"),
    ],
)
def test_wrong_filters_on_the_command_line_are_one_sentence(arguments, message):
    result = margins(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr
