"""Notes on gains that do not satisfy the criteria."""

from dataclasses import replace

import pytest

import tvclin as tv
from tvclin.case.flexible_autopilot import gain_notes

BENT = tv.load_vehicle("made-up-booster")


@pytest.mark.parametrize(
    ("vehicle", "bends"),
    [
        (BENT, True),
        (BENT.rigid, False),
        (replace(BENT, structure=replace(BENT.structure, bending=())), False),
    ],
    ids=["bending", "rigid", "slosh alone"],
)
def test_a_notch_is_proposed_for_a_vehicle_that_bends_alone(vehicle, bends):
    criteria = tv.control.Criteria.custom(phase_margin_deg=170.0)
    notes = " ".join(gain_notes(tv.Case(vehicle=vehicle), criteria, False, 1.0))

    assert "tvclin design --least seeks them" in notes
    assert ("a bending mode may need a notch" in notes) is bends
