"""Vehicle files: every wrong one is refused in one sentence, and never with a traceback."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tvclin as tv
from tvclin.vehicle.vehicle_file import parse_vehicle, template

GOOD = """
[vehicle]
name = "test"
weight_N = 1.48e6
moment_of_inertia_kg_m2 = 2.25e7
normal_force_slope_N_per_rad = 6.67e5
thrust_N = 2.495e6
aerodynamic_arm_m = 9.45
control_arm_m = 23.56
axial_force_N = 8.07e4
velocity_m_per_s = 538.81
attitude_deg = 44.83
"""


def one_sentence(error: pytest.ExceptionInfo[tv.InputError]) -> str:
    text = str(error.value)
    assert "\n" not in text
    return text


def test_table_one_is_in_the_package() -> None:
    first, second = tv.load_vehicle("configuration-i"), tv.load_vehicle("configuration-ii")

    assert (1.48e6, 0.225e8, 9.45, 23.56, 66.0) == (
        first.weight,
        first.moment_of_inertia,
        first.aerodynamic_arm,
        first.control_arm,
        first.time,
    )
    assert math.radians(37.52) == second.attitude
    made_up = ["made-up-booster", "made-up-launcher"]
    assert ["configuration-i", "configuration-ii", *made_up] == tv.list_vehicles()


def test_us_units_give_the_same_vehicle() -> None:
    us = (
        GOOD.replace("weight_N = 1.48e6", f"weight_lbf = {1.48e6 / 4.4482216152605}")
        .replace("_arm_m = 9.45", f"_arm_ft = {9.45 / 0.3048}")
        .replace("velocity_m_per_s = 538.81", f"velocity_ft_per_s = {538.81 / 0.3048}")
        .replace("_kg_m2 = 2.25e7", f"_slug_ft2 = {2.25e7 / 1.3558179483314004}")
        .replace("slope_N_per_rad = 6.67e5", f"slope_N_per_deg = {6.67e5 * math.pi / 180}")
    )
    expected, got = parse_vehicle(GOOD, "si"), parse_vehicle(us, "us")

    for name in ("weight", "aerodynamic_arm", "velocity", "moment_of_inertia"):
        assert getattr(got, name) == pytest.approx(getattr(expected, name), rel=1e-14)
    assert got.normal_force_slope == pytest.approx(expected.normal_force_slope, rel=1e-14)


def test_aerodynamic_coefficients_may_replace_the_forces() -> None:
    text = "\n".join(
        line for line in GOOD.splitlines() if not line.startswith(("normal_force", "axial_force"))
    )
    text += """
    dynamic_pressure_psf = 950
    reference_area_m2 = 34.2
    normal_force_coefficient_slope_per_rad = 0.43
    axial_force_coefficient = 0.05
    """
    vehicle = parse_vehicle(text, "t")
    pressure = 950 * 4.4482216152605 / 0.3048**2

    assert vehicle.normal_force_slope == pytest.approx(pressure * 34.2 * 0.43, rel=1e-14)
    assert vehicle.axial_force == pytest.approx(pressure * 34.2 * 0.05, rel=1e-14)


def test_the_template_is_a_valid_vehicle() -> None:
    assert parse_vehicle(template(), "template").name == "My booster"


@pytest.mark.parametrize(
    ("change", "names"),
    [
        (("weight_N = 1.48e6", ""), "weight_N or weight_kN"),
        (("weight_N", "weight"), "weight has no known unit"),
        (("weight_N", "weight_kg"), "weight_kg has no known unit"),
        (("weight_N", "wieght_N"), "did you mean weight_N"),
        (("weight_N = 1.48e6", 'weight_N = "heavy"'), "weight_N must be a number"),
        (("weight_N = 1.48e6", "weight_N = true"), "weight_N must be a number"),
        (("weight_N = 1.48e6", "weight_N = nan"), "weight_N must be finite"),
        (("weight_N = 1.48e6", "weight_N = inf"), "weight_N must be finite"),
        (
            ("weight_N = 1.48e6", f"weight_N = 1{'0' * 400}"),
            "'weight_N' holds a whole number beyond",
        ),
        (("weight_N = 1.48e6", "weight_N = 1.48e6\nweight_lbf = 3e5"), "given twice"),
        (("inertia_kg_m2 = 2.25e7", "inertia_kg_m2 = -1"), "moment_of_inertia must be positive"),
        (("thrust_N = 2.495e6", "thrust_N = 0"), "thrust must be positive"),
        (("velocity_m_per_s = 538.81", "velocity_m_per_s = 0"), "velocity must be positive"),
        (("[vehicle]", "[rocket]"), r"no table \[vehicle\]"),
        (("[vehicle]", "[other]\n[vehicle]"), "'other'"),
        (('name = "test"', "name = 3"), "name must be a text"),
        (('name = "test"', 'name = "a\\u001b[31m"'), "name must be a text"),
        (("[vehicle]", "[vehicle"), "not valid TOML"),
    ],
)
def test_a_wrong_file_is_refused_in_one_sentence(change: tuple[str, str], names: str) -> None:
    with pytest.raises(tv.InputError, match=names) as error:
        parse_vehicle(GOOD.replace(*change), "file.toml")

    assert one_sentence(error).startswith("file.toml")


def test_unreadable_sources_are_refused_in_one_sentence(tmp_path: Path) -> None:
    empty, binary = tmp_path / "empty.toml", tmp_path / "binary.toml"
    empty.write_text("")
    (tmp_path / "empty.csv").write_text("")
    binary.write_bytes(bytes(range(256)))
    for source, names in [
        (empty, "is empty; write one with"),
        (tmp_path / "empty.csv", "is empty; tvclin init --keys lists the columns"),
        (binary, "UTF-8"),
        (tmp_path, "is a directory"),
        (tmp_path / "none.toml", "does not exist"),
        ("configuration-iii", "did you mean 'configuration-ii'"),
        ("\0", "name or a path"),
    ]:
        with pytest.raises(tv.InputError, match=names) as error:
            tv.load_vehicle(source)
        one_sentence(error)


@given(st.text())
def test_rubbish_is_never_a_traceback(text: str) -> None:
    with pytest.raises(tv.InputError):
        parse_vehicle(text, "rubbish")


_VALUES = st.one_of(st.floats(), st.integers(), st.text(max_size=5), st.booleans())


@given(st.sampled_from(sorted(GOOD.split()[2:-1:3])), _VALUES)
def test_any_value_gives_a_vehicle_or_one_sentence(key: str, value: object) -> None:
    lines = [line for line in GOOD.splitlines() if not line.startswith(key)]
    shown = f"'''{value}'''" if isinstance(value, str) else str(value).lower()
    try:
        vehicle = parse_vehicle("\n".join([*lines, f"{key} = {shown}"]), "f")
    except tv.InputError as error:
        assert str(error).startswith("f")  # noqa: PT017
    else:
        assert np.isfinite(vehicle.weight)


def test_a_mass_is_a_weight_over_g() -> None:
    by_weight = template()
    by_mass = by_weight.replace("weight_N = 1.5e7", "mass_slug = 104808.1955")

    made = parse_vehicle(by_mass, "mine")
    assert made.mass == pytest.approx(104808.1955 * 14.59390294, rel=1e-9)
    assert made.weight == pytest.approx(1.5e7, rel=1e-5)
    with pytest.raises(tv.InputError, match="both a weight and a mass"):
        parse_vehicle(by_weight.replace("weight_N", "mass_kg = 1.5e6\nweight_N"), "mine")
    with pytest.raises(tv.InputError, match=r"weight_N or .*, or mass_kg or mass_lb or mass_slug"):
        parse_vehicle(by_weight.replace("weight_N", "# weight_N"), "mine")


def test_all_faults_of_a_vehicle_file_are_told_at_once(tmp_path) -> None:
    path = tmp_path / "v.toml"
    path.write_text(
        'colour = 3\n[vehicle]\nweigth_N = 1e6\nmoment_of_inertia_kg_m2 = "big"\n'
        "thrust_furlong = 3\n[bendng]\na = 1\n"
    )
    with pytest.raises(tv.InputError) as error:
        tv.load_vehicle(path)
    lines = str(error.value).split("\n")
    said = ("'colour'", "'bendng'", "did you mean weight_N", "must be a number", "write thrust_N")
    assert len(lines) == len(said)
    for line, one in zip(lines, said, strict=True):
        assert line.startswith(f"{path}: ")
        assert one in line
    with pytest.raises(tv.InputError, match=r"(?s)weight must be positive.*\nthrust must be"):
        tv.load_vehicle("configuration-i").replace(weight=-1.0, thrust=0.0)
