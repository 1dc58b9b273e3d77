"""Notes on what a question omits name a command that computes it."""

import re

import numpy as np
import pytest

import tvclin as tv
from tvclin.case.features import COMPUTED, omission_notes, use_of

HEAD_WIND = -1.0 * tv.TriangularWind(peak=np.radians(5.0), duration=7.5)


@pytest.mark.parametrize(
    ("question", "command"),
    [("margins without --limit-deg", "margins --limit-deg"), ("margins along a flight", "study")],
)
def test_a_limit_is_counted_by_margins_with_that_option(question, command):
    """Along a flight, where margins take no limit, the study counts it."""
    case = tv.Case(
        vehicle=tv.load_vehicle("configuration-i"), nozzle=tv.Nozzle(limit=0.02, rate_limit=0.1)
    )
    (note,) = omission_notes(case, "margins", question)
    assert note == f"not counted here: rate limit and limit (tvclin {command} counts it)"


@pytest.mark.parametrize("question", ["fly --engine planar", "ascent without turbulence"])
def test_a_loop_in_a_measured_wind_is_flown_by_the_linear_engine(question):
    """Neither the study, which takes pulses alone, nor ascent, which flies pulses alone."""
    case = tv.Case(
        vehicle=tv.load_vehicle("configuration-i"),
        wind=HEAD_WIND,
        design=tv.AutopilotDesign(delay=0.02, sample_rate=50.0),
    )
    (note,) = omission_notes(case, question)
    features, command = re.fullmatch(
        r"not counted here: (.*) \(tvclin (.*) counts it\)", note
    ).groups()
    assert (features, command) == ("delay and sample rate", "fly --engine linear")
    assert {use_of("fly", feature) for feature in features.split(" and ")} == {COMPUTED}
