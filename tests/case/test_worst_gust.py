"""A gust comes when it asks for most."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.requirement.study import GUST_NEARER_TO_PEAK

GUST = tv.OneMinusCosineGust(peak=np.radians(1.5), duration=2.0)
SHAPES = {"triangular": tv.TriangularWind, "rectangular": tv.RectangularWind}


def study(configuration_i, **given):
    return tv.Study.from_vehicle(
        configuration_i, duration=7.5, peak=np.radians(5), **({"gust": GUST} | given)
    )


@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact"], 1))
@pytest.mark.parametrize("shape", usual(SHAPES, 0))
def test_no_time_of_a_fine_scan_asks_for_more(configuration_i, shape, model) -> None:
    """The limit is that of eq (4b) at each time; the time is known to 1e-4 of the duration."""
    result = study(configuration_i, wind=shape, model=model)
    times = np.linspace(0.0, 7.5, 61)
    wind = SHAPES[shape](peak=np.radians(5), duration=7.5) + GUST.shift(times - 1.0)
    plant = tv.Plant.from_vehicle(configuration_i, model)
    scanned = np.abs(tv.boundary_limit(plant, wind, switch="literal").deflection)
    middle = study(configuration_i, wind=shape, model=model, gust_at=3.75)

    assert scanned.max() <= result.nominal_deflection * (1.0 + 1e-4)
    assert abs(times[scanned.argmax()] - result.wind_in_plane.gust_at) <= times[1]
    assert middle.nominal_deflection < result.nominal_deflection
    assert any("at the worst time" in note for note in result.notes)
    assert not any("at the worst time" in note for note in middle.notes)


def test_a_gust_against_the_wind_stays_in_its_middle(configuration_i) -> None:
    result = study(configuration_i, gust=-0.2 * GUST, model="fixed-path")
    assert (result.wind_in_plane.gust_at, result.gust.onset, result.gust.end) == (None, 2.75, 4.75)


def test_dispersed_winds_have_the_gust_of_the_nominal_one(configuration_i) -> None:
    nominal = study(configuration_i, model="fixed-path")
    fixed = study(configuration_i, model="fixed-path", gust_at=nominal.wind_in_plane.gust_at)
    one, other = (tv.ensembles.disperse_study(each, cases=20) for each in (nominal, fixed))
    np.testing.assert_array_equal(one.deflection, other.deflection)


def test_a_note_says_that_a_gust_nearer_to_the_peak_of_a_head_wind_may_require_more() -> None:
    """The time is that of nominal dynamic pressure."""
    shallow = tv.load_vehicle("configuration-i").replace(attitude=np.radians(28.9))
    gust = tv.OneMinusCosineGust(peak=np.radians(3.0), duration=2.0)
    options = {"duration": 13.0, "peak": np.radians(7.8), "dead_band": 0.5, "gust": gust}

    def of(**given: float) -> tv.Study:
        return tv.Study.from_vehicle(shallow, **options, model="fixed-path", **given)

    result = of()
    placed = float(result.wind_in_plane.gust_at or 0.0)
    later = [of(gust_at=placed + dt).required_deflection for dt in (0.5, 1.0)]
    noted = any("nearer to the peak of a strong head wind" in note for note in result.notes)
    assert noted == (max(later) > result.required_deflection * 1.003)
    assert noted


@pytest.mark.parametrize(
    ("duration", "gust_deg", "time", "percent"), [(13.0, 3.0, 4.03, 16.0), (25.0, 5.0, 8.93, 55.0)]
)
def test_another_time_of_a_gust_requires_what_the_page_on_limits_says(
    duration: float, gust_deg: float, time: float, percent: float
) -> None:
    shallow = tv.load_vehicle("configuration-i").replace(attitude=np.radians(28.9))
    gust = tv.OneMinusCosineGust(peak=np.radians(gust_deg), duration=2.0)
    options = {"duration": duration, "peak": np.radians(7.8), "dead_band": 0.5, "gust": gust}
    placed, other = (
        tv.Study.from_vehicle(shallow, **options, model="fixed-path", **given).required_deflection
        for given in ({}, {"gust_at": time})
    )
    assert 100.0 * (other / placed - 1.0) == pytest.approx(percent, abs=0.5)


@pytest.mark.parametrize(
    ("options", "noted"), [((), True), (("--set", "study.sign", "tail"), False)]
)
def test_a_flight_notes_it_where_a_head_wind_counts(options, noted) -> None:
    gust = ["--set", "gust.peak_deg", "1", "--set", "gust.duration_s", "2", "--dead-band", "0.5"]
    arguments = ["ascent", "configuration-i", "--from", "66", "--to", "66", *gust, *options]
    result = CliRunner().invoke(app, [*arguments, "--peak-deg", "5", "--json"])
    notes = json.loads(result.stdout)["notes"]
    assert any(GUST_NEARER_TO_PEAK in note for note in notes) == noted
