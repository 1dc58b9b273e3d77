"""Notes on gains that do not satisfy the criteria."""

import re
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


@pytest.mark.thorough
def test_of_an_autopilot_with_a_notch_another_is_proposed_or_sensor_slopes_of_the_other_sign():
    criteria = tv.control.Criteria.custom(phase_margin_deg=170.0)
    notched = tv.AutopilotDesign(filters=(tv.vehicle.Filter.notch(30.0, 0.05, 0.5),))
    notes = " ".join(gain_notes(tv.Case(vehicle=BENT, design=notched), criteria, False, 1.0))

    assert "another notch ([[autopilot.filter]]), or sensor slopes of the other sign" in notes


@pytest.mark.parametrize(
    ("design", "limits", "proposed"),
    [
        ({}, {"phase_margin_deg": 30.0}, "--design poles --natural-frequency 0.79, or"),
        ({}, {"phase_margin_deg": 60.0}, "--design half-relief, or"),
        (
            {"natural_frequency": 0.3, "damping": 2.0},
            {"gain_increase_dB": 37.0},
            "--design poles --natural-frequency 0.3, or",
        ),
    ],
)
def test_the_rule_of_the_note_satisfies_the_criteria(design, limits, proposed):
    """The margins of the rule, designed again from the words of the note, are what is required."""
    case = tv.Case(vehicle=tv.load_vehicle("configuration-i"), design=tv.AutopilotDesign(**design))
    criteria = tv.control.Criteria.custom(**limits)
    (note,) = (n for n in gain_notes(case, criteria, False, 1.0) if "gains that satisfy" in n)
    assert proposed in note
    proposal = re.search(r"--design (\S+?)(?: --natural-frequency (\S+?))?, or", note)
    name, frequency = proposal.groups()
    rule = replace(case.autopilot_design, natural_frequency=None, damping=None, design=name)
    if frequency:
        rule = replace(rule, natural_frequency=float(frequency))
    ruled = replace(case, design=rule)

    margins = ruled.autopilot.margins(ruled.plant)
    assert all(getattr(margins, name) >= limit for name, limit in limits.items())
    assert ("angle of attack too" in note) is (ruled.autopilot.alpha_gain != 0.0)


def test_a_search_for_gains_that_has_failed_is_not_proposed_again():
    case = tv.Case(vehicle=BENT.rigid, design=tv.AutopilotDesign(design="least-nozzle"))
    criteria = tv.control.Criteria.custom(phase_margin_deg=170.0)
    (note,) = (n for n in gain_notes(case, criteria, False, 1.0) if "gains that satisfy" in n)

    assert "no design rule has gains" in note
    assert "--least" not in note
