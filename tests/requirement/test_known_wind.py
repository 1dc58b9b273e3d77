"""The record and the tables of the minimum peak deflection in a known wind."""

import numpy as np
import pytest

import tvclin as tv
from tvclin.base.lines import text
from tvclin.boundary.closed_forms import triangular_limit
from tvclin.requirement.nominal_requirement import KnownWind, required_deflection

BOOSTER = tv.load_vehicle("configuration-i")
DEAD_BANDS = np.array([1.0, 0.0])


def known(model: str, duration: float) -> KnownWind:
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=duration)
    return KnownWind.of(tv.Plant.from_vehicle(BOOSTER, model), wind, 0.0)


def rows(of: KnownWind) -> list[list[str]]:
    required = required_deflection(of.plant, of.wind, DEAD_BANDS)
    table = of.dead_band_table("", DEAD_BANDS, required)
    return [list(table.head), *([text(cell) for cell in row] for row in table.rows)]


def test_with_one_pole_the_minimum_is_the_constant_deflection_of_equation_12_against_the_wind():
    of = known("fixed-path", 7.5)
    limit = triangular_limit(7.5 * of.plant.coefficients.beta, 0.0)
    assert [of.constant, of.best.peak] == pytest.approx(2 * [limit * of.trim], rel=1e-9)
    assert of.first_segment == "opposes the wind"
    assert rows(of)[0] == ["dead band", "required [deg]", "over trim"]
    assert rows(of)[-1][1:] == rows(of)[-2][1:]
    assert {len(row) for row in rows(of)} == {3}


def test_what_sets_a_limit_is_shown_where_it_is_not_the_boundary_throughout():
    head, first, *others = rows(known("drift-exact", 40.0))
    assert (head[-1], first[-1]) == ("set by", "the boundary of the control with the exit on trim")
    assert {row[-1] for row in others} == {"the minimum over all unstable poles"}


def test_six_switches_are_shown_and_the_others_counted():
    of = known("drift-and-speed", 60.0)
    (shown,) = [text(cell) for label, cell in of.table("").rows if text(label) == "switches"]
    assert shown.count(" s") == 6
    assert shown.endswith(f" and {of.best.switch_times.size - 6} more")
    assert of.first_segment == "goes with the wind"


def test_the_bound_names_start_and_end_of_the_controls_that_it_bounds():
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    plant = tv.Plant.from_vehicle(BOOSTER, "drift-exact")
    at_onset, early = (KnownWind.of(plant, wind, start) for start in (0.0, -30.0))
    assert early.best.peak < at_onset.best.peak
    assert at_onset.verdict().endswith("; no control survives this wind with less")
    assert early.verdict("it").endswith("; no control that begins at -30 s survives it with less")
    ends = KnownWind.of(plant, wind, 0.0, horizon=20.0).verdict()
    assert ends.endswith("; no control that ends at 20 s survives this wind with less")
