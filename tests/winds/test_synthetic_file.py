"""A synthetic wind in a file is the one that Python makes."""

import numpy as np
import pytest

import tvclin as tv

TEXT = """
[synthetic]
height_m = [0, 11000, 30000]
speed_kt = [20, 120, 30]
peak_height_m = 11000
thickness_m = [100, 500, 1000]
change_m_per_s = [8, 20, 32]
direction_deg = 270

[[gust]]
base_m = 10400
amplitude_m_per_s = 9
blend_m = 60
thickness_m = 100
direction_deg = 270
"""


def test_a_file_is_read_in_its_units(tmp_path) -> None:
    file = tmp_path / "jet.toml"
    file.write_text(TEXT)
    profile = tv.winds.read_sounding(file)
    bare = tv.winds.synthetic_profile(
        np.array([0.0, 11e3, 30e3]),
        np.array([20.0, 120.0, 30.0]) * 1852.0 / 3600.0,
        peak_height=11e3,
        thickness=[100.0, 500.0, 1000.0],
        change=[8.0, 20.0, 32.0],
        azimuth=np.pi / 2,
    )
    gust = {"base": 10400.0, "amplitude": 9.0, "blend": 60.0, "thickness": 100.0}
    made = tv.winds.add_gust(bare, azimuth=np.pi / 2, **gust)
    for name in ("height", "east", "north"):
        np.testing.assert_allclose(getattr(profile, name), getattr(made, name), atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("speed_kt", "speed_knots", "speed_kt"),
        ("peak_height_m = 11000", "", "needs peak_height"),
        ("[[gust]]", "[[gusts]]", "gust"),
        ("base_m = 10400", "base_m = true", "base_m"),
    ],
)
def test_a_file_at_fault_is_one_sentence(tmp_path, old, new, said) -> None:
    file = tmp_path / "jet.toml"
    file.write_text(TEXT.replace(old, new))
    with pytest.raises(tv.InputError, match=said):
        tv.winds.read_sounding(file)
