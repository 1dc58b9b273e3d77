"""Margins have the same digits in a terminal, on a page and in a notebook."""

import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.answers.findings import find
from tvclin.base.lines import Number, Table
from tvclin.cli.app import app
from tvclin.control.margins.tables import margin_table
from tvclin.show.report import control

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
def found(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "s.toml"
    path.write_text(TEXT)
    return find(tv.load_study(path))


def test_every_margin_of_the_page_stands_in_the_terminal(found):
    printed = CliRunner().invoke(app, ["margins", "configuration-i", *GIVEN]).output
    blocks = control.autopilot(found).blocks
    (table,) = (one for one in blocks if isinstance(one, Table) and one.caption == "Margins")
    shown = [one.text for row in table.rows for line in row for one in line if _is_number(one)]

    assert len(shown) > 20
    assert all(text in printed for text in shown)


def test_the_card_has_the_margins_of_the_table(found):
    margins = found.comparison.margins
    card = margins._repr_html_()

    for row in margin_table(margins).rows:
        label, value = row[0], row[1]
        if "gain and phase" not in label[0] and _is_number(value[0]):
            assert f">{value[0].text}</td>" in card


def _is_number(part):
    return isinstance(part, Number)
