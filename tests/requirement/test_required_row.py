"""The row that a study marks as that of its verdict shows what is required."""

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.base.lines import text
from tvclin.requirement.study import Study
from tvclin.requirement.study_tables import boundaries, requirement


def marked(study: Study) -> list[str]:
    """Return the cells of the one row that is marked."""
    (row,) = [row for row in boundaries(study).rows if "(verdict)" in text(row[0])]
    return [text(cell) for cell in row]


@pytest.mark.parametrize(
    ("label", "changes"),
    usual(
        [
            ("head wind (verdict)", {"duration": 90.0, "dead_band": 0.5}),
            ("required (verdict)", {"duration": 90.0, "dead_band": 0.5, "sign": "frozen"}),
            ("K = 1 (verdict)", {"duration": 7.5, "sign": "frozen"}),
            ("cross wind (verdict)", {"duration": 7.5, "plane": "yaw"}),
            (
                "both planes (verdict)",
                {"duration": 7.5, "heading": np.radians(225), "limit_shape": "round"},
            ),
        ],
        0,
        4,
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
