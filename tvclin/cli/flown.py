"""What `tvclin margins --flown` adds: how much may change in this wind, with this stop."""

import numpy as np

from tvclin.answers.case import Case
from tvclin.base.errors import InputError
from tvclin.cli.output import print_tables, say, say_notes
from tvclin.cli.wind import wind_words
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.flights.closed_loop.flown_margins import flown_margins
from tvclin.flights.closed_loop.flown_record import FlownMargins, flown_table


def flown_found(case: Case, autopilot: Autopilot) -> FlownMargins:
    """Return the flown margins of a case and its autopilot, its delay that of a computer."""
    limit, law = case.nozzle.limit, SaturatedLaw.of(autopilot)
    if limit is None:
        raise InputError("--flown needs --limit-deg, the deflection limit in deg")
    return flown_margins(case.plant, law, case.history, limit=limit, **case.hardware)


def print_flown(found: FlownMargins, case: Case, name: str) -> None:
    """Print the flown margins of a case in a wind with a name, and what is odd about them."""
    title = (
        f"In this {wind_words(name, case)}, with a stop at"
        f" {np.degrees(case.nozzle.limit or 0.0):g} deg, {case.hardware['sample_rate']:g} Hz"
    )
    print_tables(flown_table(found, title))
    say(
        f"The limit is {found.limit:.4g} of full trim, {found.spare:.4g} times the boundary of the"
        " autopilot."
    )
    say_notes(found.notes)
