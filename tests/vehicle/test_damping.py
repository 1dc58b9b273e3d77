"""The damping of a vehicle: from coefficients, from a jet, and in files; what is refused."""

import numpy as np
import pytest

import tvclin as tv
from tests.vehicle.test_file import GOOD
from tvclin.vehicle.vehicle_file import parse_vehicle

COEFFICIENTS = """
dynamic_pressure_Pa = 45500
reference_area_m2 = 34.2
normal_force_coefficient_slope_per_rad = 0.43
axial_force_coefficient = 0.05
"""
FORCES = ("normal_force", "axial_force")
JET = "jet_mass_flow_kg_per_s = 900"
RATE = "inertia_rate_kg_m2_per_s = -4e4"


def of_coefficients(*lines):
    text = "\n".join(line for line in GOOD.splitlines() if not line.startswith(FORCES))
    return parse_vehicle("\n".join([text + COEFFICIENTS, *lines]), "f").pitch_damping


def of_forces(*lines):
    return parse_vehicle("\n".join([GOOD, *lines]), "f").pitch_damping


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("", 0.0),
        ("pitch_damping_N_m_s_per_rad = 4710", 4710.0),
        ("pitch_damping_N_m_s_per_rad = 0", 0.0),
        ("pitch_damping_lbf_ft_s_per_rad = 1000", 1000 * 4.4482216152605 * 0.3048),
        ("pitch_damping_N_m_s_per_deg = 100", 100 * 180 / np.pi),
        (f"{JET}\n{RATE}", 900 * 23.56**2 - 4e4),
        (f"{JET}\n{RATE}\nexit_arm_m = 25", 900 * 25.0**2 - 4e4),
        (f"{JET}\ninertia_rate_kg_m2_per_s = 0\nexit_arm_m = 25", 900 * 25.0**2),
    ],
)
def test_a_file_gives_the_damping_in_its_units(line, expected):
    assert of_forces(line) == pytest.approx(expected, rel=1e-14)


def test_the_rate_of_a_coefficient_stands_in_its_key_and_is_worth_a_factor_of_two():
    """M = C q S L (theta' L/(f V)) by hand, and its sign: a C_mq below zero damps."""
    per_whole = 40.0 * 45500 * 34.2 * 6.6**2 / 538.81
    whole = of_coefficients(
        "reference_length_m = 6.6", "pitch_damping_coefficient_per_qL_over_V = -40"
    )
    half = of_coefficients(
        "reference_length_m = 6.6", "pitch_damping_coefficient_per_qL_over_2V = -40"
    )
    assert whole == pytest.approx(per_whole, rel=1e-14)
    assert half == pytest.approx(per_whole / 2, rel=1e-14)
    air = {"dynamic_pressure": 45500, "reference_area": 34.2, "reference_length": 6.6}
    for per, expected in (("qL/V", whole), ("qL/2V", half)):
        damping = tv.vehicle.aerodynamic_damping(-40.0, per, velocity=538.81, **air)
        assert damping == pytest.approx(expected, rel=1e-14)


def test_air_and_jet_add():
    air = ("reference_length_m = 6.6", "pitch_damping_coefficient_per_qL_over_V = -40")
    both = of_coefficients(*air, JET, RATE)
    assert both == pytest.approx(of_coefficients(*air) + of_coefficients(JET, RATE), rel=1e-14)


LENGTH = "reference_length_m = 6.6"
PER_V = "pitch_damping_coefficient_per_qL_over_V"


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (["pitch_damping_N_m_s_per_rad = -1"], "pitch_damping must be zero or positive"),
        (["pitch_damping = 1"], r"no known unit in \[vehicle\]; write pitch_damping_N_m_s_per_rad"),
        (
            ["pitch_damping_coefficient = -40", LENGTH],
            f"no known unit.*{PER_V} or .*per_qL_over_2V",
        ),
        (
            [f"{PER_V} = -4", f"{PER_V[:-1]}2V = -4", LENGTH],
            "pitch_damping_coefficient is given tw",
        ),
        ([f"{PER_V} = 40", LENGTH], "must be zero or negative: C_mq below zero damps; got 40"),
        ([f"{PER_V} = -40"], "a key is missing in .*: reference_length_m"),
        ([LENGTH], "reference_length in .* needs pitch_damping_coefficient_per_qL_over_V or"),
        ([RATE], "inertia_rate in .* needs jet_mass_flow_kg_per_s"),
        ([JET], "jet_mass_flow in .* needs inertia_rate_kg_m2_per_s .*0 for an upper bound"),
        ([JET, "inertia_rate_kg_m2_per_s = -1e6"], "damping would be negative"),
        ([JET, RATE, "pitch_damping_N_m_s_per_rad = 1"], "both pitch_damping and jet_mass_flow"),
    ],
)
def test_what_cannot_be_meant_is_refused_in_one_sentence(lines, says):
    with pytest.raises(tv.InputError, match=says) as error:
        of_coefficients(*lines)
    assert "\n" not in str(error.value)


def test_a_coefficient_needs_the_air_that_it_belongs_to():
    with pytest.raises(tv.InputError, match="a key is missing in .*: dynamic_pressure_Pa"):
        of_forces(f"{PER_V} = -40", LENGTH)


def test_an_unknown_rate_is_refused():
    air = {"dynamic_pressure": 1e4, "reference_area": 1.0, "reference_length": 1.0}
    with pytest.raises(tv.InputError, match="per must be one of qL/2V, qL/V; got 'qL'"):
        tv.vehicle.aerodynamic_damping(-1.0, "qL", velocity=100.0, **air)


def test_a_card_shows_the_damping_where_there_is_one():
    vehicle = tv.load_vehicle("configuration-i")
    assert "pitch damping M_q" not in vehicle._repr_html_()
    assert "pitch damping M_q" in vehicle.replace(pitch_damping=5e5)._repr_html_()
