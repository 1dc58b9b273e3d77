"""The row that a study marks as that of its verdict shows what is required."""

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.base.lines import text
from tvclin.requirement.study import Study
from tvclin.requirement.study_tables import boundaries, requirement


def quick_path() -> tv.Vehicle:
    """Return a booster at 115 m/s, both of whose unstable poles count in a short wind."""
    return tv.Vehicle(
        weight=372653.0,
        moment_of_inertia=1.49231e6,
        normal_force_slope=59978.6,
        thrust=626956.0,
        aerodynamic_arm=3.208,
        control_arm=8.277,
        axial_force=6082.86,
        velocity=115.12,
        attitude=np.radians(79.501),
    )


def marked(study: Study) -> list[str]:
    """Return the cells of the one row that is marked."""
    (row,) = [row for row in boundaries(study).rows if "(verdict)" in text(row[0])]
    return [text(cell) for cell in row]


@pytest.mark.parametrize(
    ("label", "changes"),
    usual(
        [
            ("head wind (verdict)", {"duration": 90.0, "dead_band": 0.5}),
            ("K = 0.5 (verdict)", {"duration": 90.0, "dead_band": 0.5, "sign": "frozen"}),
            (
                "required, K = 1 (verdict)",
                {"duration": 7.5, "sign": "frozen", "switch": "report"},
            ),
            ("K = 1 (verdict)", {"duration": 7.5, "sign": "frozen"}),
            ("cross wind (verdict)", {"duration": 7.5, "plane": "yaw"}),
            (
                "both planes (verdict)",
                {"duration": 7.5, "heading": np.radians(225), "limit_shape": "round"},
            ),
        ],
        0,
        1,
        2,
        5,
    ),
)
def test_the_marked_row_is_what_the_verdict_requires(label, changes) -> None:
    vehicle = tv.load_vehicle("configuration-i")
    study = Study.from_vehicle(vehicle, peak=np.radians(5), limit=np.radians(0.1376), **changes)
    required = f"{np.degrees(study.required_deflection):.3f}"
    row = marked(study)
    assert row[0] == label
    assert row[3] == required
    assert text(requirement(study)).startswith(f"Required deflection: {required} deg")
    if not study.judges_both_planes:
        assert row[-1] == f"{np.degrees(abs(study.survivable_peak)):.3f}"


def test_rows_of_dead_bands_are_required_deflections_where_two_poles_count() -> None:
    """They are no boundary limits, which are lower, and no bound is below the minimum peak."""
    study = Study.from_vehicle(quick_path(), peak=np.radians(5), duration=7.5)
    plant = tv.Plant.from_vehicle(quick_path(), "drift-exact")
    needed = tv.required_deflection(plant, study.history, study.dead_bands)
    rows = {text(row[0]): text(row[3]) for row in boundaries(study).rows}
    degrees = np.degrees(np.abs(needed.deflection)).tolist()
    assert [rows[f"K = {K:g}"] for K in study.dead_bands] == [f"{size:.3f}" for size in degrees]
    assert degrees[0] > 1.1 * np.degrees(abs(study.boundaries["drift-exact"].deflection[0]))
    minimum = tv.optimum_deflection(plant, study.history, 0.0).peak
    bound = tv.forecast_free_limit(plant, study.history)
    assert abs(bound.deflection) == pytest.approx(minimum, rel=1e-9)
    assert bound.wind_known < 0.98 * bound.limit
    assert rows["lower bound, no forecast"] == rows["lower bound, wind known"] == rows["K = 0"]
