"""Numbers have the same digits in a terminal, on a page, in a notebook, and of a CSV."""

import csv
import json

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.show.pages import section
from tvclin.base.lines import Number
from tvclin.cli.app import app
from tvclin.control.margins.criteria import margin_table
from tvclin.design.standard_trials import bounds, limit_tables
from tvclin.requirement.study_tables import requirement
from tvclin.studyfile.findings import find

TEXT = """
[study]
vehicle = "configuration-i"
[wind]
peak_deg = 5
duration_s = 7.5
[autopilot]
natural_frequency_rad_per_s = 1.5
damping = 0.7
delay_ms = 10
"""
GIVEN = ("--natural-frequency", "1.5", "--damping", "0.7", "--delay-ms", "10")


@pytest.fixture(scope="module")
def findings(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "s.toml"
    path.write_text(TEXT)
    return find(tv.load_study(path))


@pytest.mark.thorough
def test_every_margin_of_the_page_stands_in_the_terminal(findings):
    printed = CliRunner().invoke(app, ["margins", "configuration-i", *GIVEN, "--more"]).output
    numbers = section(findings, "margins").numbers
    of_table = ("margin.", "criteria.")
    shown = [text for name, (_, text) in numbers.items() if name.startswith(of_table)]

    assert len(shown) > 20
    assert all(text in printed for text in shown)


def test_the_card_has_the_margins_of_the_table(findings):
    margins = findings.comparison.margins
    card = margins._repr_html_()

    for row in margin_table(margins).rows:
        label, value = row[0], row[1]
        if "gain and phase" not in label[0] and _is_number(value[0]):
            assert f">{value[0].text}</td>" in card


def _is_number(part):
    return isinstance(part, Number)


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments]).output


def shown(*tables):
    """Return the numbers of tables as they are shown."""
    rows = (row for table in tables for row in table.rows)
    return [one.text for row in rows for line in row for one in line if _is_number(one)]


def test_a_study_has_the_digits_of_the_page_in_the_terminal_and_in_a_notebook(findings):
    printed, card = run("study", "configuration-i", "--more"), findings.study._repr_html_()
    on_page = section(findings, "boundaries").numbers | section(findings, "inputs").numbers
    numbers = [
        text for name, (_, text) in on_page.items() if not name.startswith(("question.", "wind."))
    ]
    (needed,) = filter(_is_number, requirement(findings.study))

    assert len(numbers) > 40
    assert all(text in printed for text in numbers)
    assert f">{needed.text}</td>" in card
    assert needed.text in printed


@pytest.mark.thorough
def test_a_sizing_has_the_digits_of_its_csv_in_the_terminal(tmp_path):
    printed = run("ascent", "configuration-i", "--more", "--csv", tmp_path / "s.csv")
    heads, *rows = csv.reader((tmp_path / "s.csv").read_text().splitlines())
    angles = [k for k, head in enumerate(heads) if head.endswith("_deg")]

    assert len(rows) > 10
    assert all(f"{float(row[k]):.3f}" in printed for row in rows for k in angles)


def test_laws_have_the_digits_of_the_page_in_the_terminal_and_in_a_notebook():
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    winds = {"triangle": tv.TriangularWind(peak=np.radians(5.0), duration=3.0)}
    laws = tv.design.standard_laws(plant, np.radians(5.0))
    trials = tv.design.law_trials(plant, laws, winds, sample_rate=20.0)
    options = ("--duration", 3, "--wind", "triangular", "--sample-rate", 20, "--more")
    every = ("fly", "configuration-i", "--law", "all", "--model", "fixed-path")
    printed = run(*every, *options)
    over_trim = limit_tables(trials, bounds(plant, winds))[1]

    assert all(text in printed for text in shown(*limit_tables(trials, bounds(plant, winds))))
    assert all(f"<td>{text}</td>" in trials._repr_html_() for text in shown(over_trim)[:-1])


def test_a_flight_has_the_digits_of_its_json_in_the_terminal():
    arguments = ("fly", "configuration-i", "--limit-deg", 0.4, "--peak-deg", 2)
    printed, document = run(*arguments), json.loads(run(*arguments, "--json"))

    for peaks in document["peaks_over_the_wind_deg"].values():
        assert all(f"{value:.3f}" in printed for value in peaks.values())


def test_a_campaign_has_the_digits_of_its_json_in_the_terminal(tmp_path):
    vehicle = tv.load_vehicle("configuration-i")
    campaign = tv.Campaign(
        vehicle=vehicle,
        wind=tv.ShapedWind("triangular", peak=0.08, duration=7.5),
        dispersions=tv.Dispersions((tv.Dispersion("thrust", "normal", 0.01),)),
        cases=40,
    )
    tv.run_campaign(campaign, tmp_path / "results")
    arguments = ("disperse", tmp_path / "results", "--limit-deg", 0.4)
    printed, document = run(*arguments, "--more"), json.loads(run(*arguments, "--json"))

    assert all(f"{document[k]:.3f} deg" in printed for k in ("median_deg", "estimate_deg"))
    assert f"{100 * document['success']['lower']:.2f} to" in printed
