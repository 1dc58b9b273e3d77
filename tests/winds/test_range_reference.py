"""Monthly statistics of the wind above a launch site, and their percentiles."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm, pearson3

import tvclin as tv

GOLDEN = Path(__file__).parents[1] / "soundings"
EAST = np.pi / 2


@pytest.fixture(scope="module")
def cape():
    return tv.winds.read_range_reference(GOLDEN / "T1cap19.txt")


def test_the_tables_of_the_cape_are_read_as_they_stand(cape):
    assert [month.month for month in cape] == ["January", "February", "March"]
    february = cape[1]
    assert february.site == "74794 Cape Canaveral Air Force Station"
    at = int(np.flatnonzero(february.height == 12e3)[0])
    row = (february.mean_east, february.sd_east, february.correlation, february.mean_north)
    assert [field[at] for field in row] == [40.83, 17.25, 0.2638, 1.82]
    more = (february.sd_north, february.mean_speed, february.sd_speed, february.skew_speed)
    assert [field[at] for field in more] == [13.82, 43.47, 16.44, -0.28]
    assert february.count[at] == 1500
    site = february.site
    assert repr(february) == f"RangeReference({site}, February, {february.height.size} levels)"


@pytest.mark.parametrize("percentile", [1.0, 50.0, 95.0, 99.865])
def test_speeds_are_those_of_scipys_pearson_distribution(cape, percentile):
    for month in cape:
        some = month.sd_speed > 0.0
        law = pearson3(month.skew_speed[some], month.mean_speed[some], month.sd_speed[some])
        expected = np.maximum(law.ppf(percentile / 100), 0.0)
        np.testing.assert_allclose(month.speed(percentile)[some], expected, rtol=1e-9)
        np.testing.assert_array_equal(month.speed(percentile)[~some], 0.0)


def test_components_are_normal_with_the_covariance_of_the_table(cape):
    february, azimuth = cape[1], 1.2
    ahead = np.array([np.sin(azimuth), np.cos(azimuth)])
    for i, computed in enumerate(february.component(95.0, azimuth)):
        east, north = february.sd_east[i], february.sd_north[i]
        mixed = february.correlation[i] * east * north
        spread = np.sqrt(ahead @ np.array([[east**2, mixed], [mixed, north**2]]) @ ahead)
        mean = ahead @ [february.mean_east[i], february.mean_north[i]]
        assert computed == pytest.approx(mean + norm.ppf(0.95) * spread, rel=1e-13)
    np.testing.assert_array_equal(february.component(50.0, EAST), february.mean_east)
    np.testing.assert_allclose(
        february.component(5.0, azimuth + np.pi), -february.component(95.0, azimuth), rtol=1e-12
    )


def test_an_envelope_is_a_profile_and_says_that_it_is_one(cape):
    profile = cape[1].profile(95.0, EAST)
    np.testing.assert_allclose(profile.in_plane(EAST), cape[1].speed(95.0), rtol=1e-15)
    assert "an envelope" in profile.notes[0]
    assert profile.source.endswith("February, 95 %")


def test_the_worst_month_is_sought_at_each_height(cape):
    height, speed = tv.winds.worst_month(cape, 95.0)
    every = np.array([month.speed(95.0) for month in cape])
    np.testing.assert_array_equal(speed, every.max(axis=0))
    known = dict(zip(height, speed.round(1), strict=True))
    printed = {8e3: 52.0, 10e3: 64.7, 11e3: 68.7, 12e3: 69.4, 13e3: 66.9, 15e3: 55.3, 20e3: 21.5}
    assert {z: known[z] for z in printed} == printed


def test_bad_statistics_are_refused(tmp_path, cape):
    text = (GOLDEN / "T1cap19.txt").read_text()
    path = tmp_path / "T1cap19.txt"
    for wrong, said in (
        (text.replace("0.2638", "1.2638"), "line 28: the correlation must be between"),
        (text.replace("17.25", "-17.2"), "line 28: a standard deviation must not be negative"),
        (text.replace(" 12.000   40.83", " 10.000   40.83"), "line 28: heights must ascend"),
        (text.replace("17.25", "9e99"), "line 28: a number is beyond"),
        (text[: text.index("12.000   40.83") + 40], "line 28: a row has 10 numbers; got"),
        (text[: text.index("\n", text.index("KM  "))], "line 2: two or more rows must follow"),
        (text.replace("17.25", "x"), "line 28: sd_east must be a number"),
        ("wind", "is no Range Reference Atmosphere"),
        (text.splitlines()[1], "line 1: a month, a station and a line of units"),
    ):
        path.write_text(wrong)
        with pytest.raises(tv.InputError, match=said):
            tv.winds.read_range_reference(path)
    with pytest.raises(tv.InputError, match="percentile must be above 0 and below 100"):
        cape[0].speed(100.0)
    with pytest.raises(tv.InputError, match="months must be one or more"):
        tv.winds.worst_month([], 95.0)
