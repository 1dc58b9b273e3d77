"""Structures from vehicle files: keys and units, the shipped ones, and what is refused."""

import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import tvclin as tv
from tests.flexible import BOOSTER, STRUCTURE
from tvclin.vehicle.vehicle_file import template

VEHICLE = (Path(tv.__file__).parent / "vehicle/shipped/configuration-i.toml").read_text()
MODE = """
[[bending]]
frequency_rad_per_s = 13.58
damping = 0.005
modal_mass_kg = 5.1e5
gimbal_displacement = 1.0
gimbal_slope_per_m = -0.0682
attitude_slope_per_m = 0.2724
rate_slope_per_m = 0.2548
"""
TANK = """
[[slosh]]
mass_kg = 24000
station_m = 19.94
damping = 0.01
pendulum_length_m = 2.10
"""


@pytest.fixture
def load(tmp_path):
    def read(text, vehicle=VEHICLE):
        file = tmp_path / "vehicle.toml"
        file.write_text(vehicle + text)
        tv.load_vehicle(file)  # the same file is that of the rigid vehicle
        return tv.load_vehicle(file).structure

    return read


def same(one, other):
    """Return whether two structures hold the same numbers."""
    if isinstance(one, tv.vehicle.Filter):
        return all(
            np.array_equal(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)
        )
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, tv.Structure):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    return one == other


def test_the_made_up_booster_is_that_of_the_tests():
    assert same(tv.load_vehicle("made-up-booster").structure, STRUCTURE)
    vehicle = tv.load_vehicle("made-up-booster")
    assert vehicle.rigid.replace(name=BOOSTER.name, time=None) == BOOSTER


def test_the_made_up_launcher_has_the_modes_of_a_uniform_beam():
    """Displacement 1 at both ends and a quarter of the mass; four printed digits."""
    vehicle = tv.load_vehicle("made-up-launcher")
    structure = vehicle.structure
    length, stations = 20.0, {"rate_slope": 2.0, "attitude_slope": 6.0, "gimbal_slope": -10.0}
    assert vehicle.moment_of_inertia == pytest.approx(vehicle.mass * length**2 / 12, rel=1e-4)
    for mode, k in zip(structure.bending, (4.7300407, 7.8532046), strict=True):
        ratio = (np.cosh(k) - np.cos(k)) / (np.sinh(k) - np.sin(k))

        def shape(x, k=k, ratio=ratio):
            y = k * (x / length + 0.5)
            even, odd = np.cosh(y) + np.cos(y), np.sinh(y) + np.sin(y)
            turned = np.sinh(y) - np.sin(y) - ratio * even
            return (even - ratio * odd) / 2, k / length * turned / 2

        for name, station in stations.items():
            assert getattr(mode, name) == pytest.approx(shape(station)[1], abs=6e-5)
        assert mode.pressure_displacement == pytest.approx(shape(4.0)[0], abs=6e-5)
        at_tank = mode.tank_displacements[0], mode.tank_slopes[0]
        assert at_tank == pytest.approx(shape(3.0), abs=6e-5)
        assert mode.modal_mass == pytest.approx(vehicle.mass / 4, rel=1e-4)
    first, second = structure.bending
    assert second.frequency / first.frequency == pytest.approx((7.8532 / 4.73) ** 2, abs=1e-3)


@pytest.mark.parametrize("name", ["configuration-i", "configuration-ii"])
def test_a_file_without_these_tables_is_that_of_a_rigid_vehicle(name):
    assert tv.load_vehicle(name).structure is None


@pytest.mark.parametrize(
    ("change", "factor"),
    [
        (("frequency_rad_per_s = 13.58", "frequency_Hz = 13.58"), ("frequency", 2 * np.pi)),
        (("modal_mass_kg", "modal_mass_lb"), ("modal_mass", 0.45359237)),
        (("modal_mass_kg", "modal_mass_slug"), ("modal_mass", 14.593902937206364)),
        (("gimbal_slope_per_m", "gimbal_slope_per_ft"), ("gimbal_slope", 1 / 0.3048)),
        (("rate_slope_per_m", "rate_slope_per_in"), ("rate_slope", 1 / 0.0254)),
    ],
)
def test_units_are_in_the_keys(load, change, factor):
    was, now = load(MODE).bending[0], load(MODE.replace(*change)).bending[0]
    name, times = factor
    assert getattr(now, name) == pytest.approx(times * getattr(was, name), rel=1e-14)


def test_slopes_at_tanks_have_units_too(load):
    metric = load(MODE + "tank_slopes_per_m = [0.3]\n" + TANK).bending[0]
    imperial = load(MODE + "tank_slopes_per_ft = [0.3]\n" + TANK).bending[0]
    assert imperial.tank_slopes[0] == pytest.approx(metric.tank_slopes[0] / 0.3048, rel=1e-14)


def test_a_lag_without_damping_is_of_first_order(load):
    result = load("[sensors]\nattitude_sensor_frequency_Hz = 3\n")
    assert result.attitude_sensor.order == 1
    assert result.rate_gyro is None


def test_the_template_shows_every_table():
    """What is commented out there is read when it is not."""
    text = template()
    start = text.index("# [engine]")
    shown = tomllib.loads(text[start:].replace("\n# ", "\n").replace("\n#\n", "\n\n")[2:])
    assert shown.keys() == {"engine", "sensors", "structure", "bending", "slosh"}


VALUES = (
    *("0", "-1", "1e-300", "1e-12", "1e-6", "1e6", "1e12", "1e150", "1e400", "nan", "inf"),
    *("true", '"a"', "[]", "[1e12, -1e12]", "[[1]]", "{a = 1}"),
)


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore:.*has no damping:UserWarning")
def test_whatever_a_file_says_its_plant_has_numbers_or_is_refused(tmp_path):
    whole = (Path(tv.__file__).parent / "vehicle/shipped/made-up-launcher.toml").read_text()
    lines, file = whole.splitlines(), tmp_path / "vehicle.toml"
    made = 0
    for k, line in enumerate(lines):
        if "=" not in line or line.startswith(("#", "name")):
            continue
        for value in VALUES:
            changed = [*lines[:k], f"{line.split('=')[0]} = {value}", *lines[k + 1 :]]
            file.write_text("\n".join(changed))
            try:
                vehicle, structure = tv.load_vehicle(file), tv.load_vehicle(file).structure
                plant = tv.FlexiblePlant.from_vehicle(vehicle, structure, "drift-exact")
                numbers = (*plant.matrices(), plant.poles, *plant.shift())
            except tv.InputError as error:
                assert "\n" not in str(error)  # noqa: PT017
                continue
            made += 1
            assert all(np.all(np.isfinite(number)) for number in numbers), changed[k]
    assert made > 100


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (MODE.replace("damping", "dampin"), "bending 1: unknown key in .*did you mean damping"),
        (MODE.replace("slope_per_m = 0.27", "slope = 0.27"), "attitude_slope has no known unit"),
        (MODE.replace("damping = 0.005", ""), "bending 1: a key is missing in .*: damping"),
        (MODE.replace("0.005", "-0.005"), "bending 1: damping must be between 0"),
        (MODE + "tank_slopes_per_m = [1]\n", "tank_slopes of bending mode 1 must be one for each"),
        (MODE + "tank_slopes_per_m = 1\n", "tank_slopes_per_m in .* must be a list"),
        (MODE + 'tank_displacements = ["a"]\n', "tank_displacements.0. must be a number"),
        (
            MODE + "tank_slopes_per_m = [1]\ntank_slopes_per_ft = [1]\n" + TANK,
            "tank_slopes is given twice, as tank_slopes_per_m and tank_slopes_per_ft",
        ),
        (TANK + "frequency_Hz = 1\n", "slosh 1: a slosh tank needs a pendulum_length or a frequ"),
        (TANK.replace("[[slosh]]", "[slosh]"), "slosh must be given as .*once for each"),
        ("[engine]\nmass_kg = 10\n", "a key is missing in .engine.: arm_m"),
        ("[engine]\n", "a key is missing in .engine.: mass_kg"),
        ("[engin]\nmass_kg = 10\n", "unknown heading or key 'engin'"),
        ("[sensors]\nrate_gyro_damping = 0.7\n", "a key is missing in .sensors.: rate_gyro_freq"),
        ("[structure]\nthrust_follows = 1\n", "thrust_follows must be True or False; got 1"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_sentence(load, text, said):
    with pytest.raises(tv.InputError, match=said) as refused:
        load(text)
    assert all("vehicle.toml: " in line for line in str(refused.value).split("\n"))
