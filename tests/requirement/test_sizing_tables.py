"""A sizing as tables: a number has the same digits in a terminal, in a notebook and on a page."""

from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.show.pages import section
from tvclin import plots
from tvclin.base.lines import Number, text
from tvclin.cli.app import app
from tvclin.requirement.flight import sizing_tables as tables
from tvclin.requirement.flight.total import total_table
from tvclin.studyfile.findings import find
from tvclin.studyfile.read import load_study

FOLDER = Path(__file__).parents[1] / "soundings"
TEXT = """
[study]
vehicle = "configuration-i"
[[wind]]
peak_deg = 5
duration_s = 7.5
[nozzle]
limit_deg = 0.5
[size]
from_s = 60
to_s = 80
every_s = 10
varying = true
reserve_percent = 10
thrust_offset_deg = 0.1
"""


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """Return the terminal's words, the section of the page, the sizing and its total."""
    path = tmp_path_factory.mktemp("study") / "s.toml"
    path.write_text(TEXT)
    plan = replace(load_study(path), laws=None)
    result = find(plan)
    printed = (
        CliRunner().invoke(app, ["ascent", str(path), "--more"], env={"COLUMNS": "200"}).output
    )
    return printed, section(result, "flight"), *result.flight


def texts(parts):
    return [one.text for line in parts for one in line if isinstance(one, Number)]


@pytest.mark.thorough
def test_every_number_of_the_page_stands_in_the_terminal_with_the_same_digits(answers):
    printed, page, _, _ = answers
    shown = [
        text
        for name, (_, text) in page.numbers.items()
        if not name.endswith(("change_percent", "ratio.ratio"))
    ]
    assert len(shown) > 30
    assert set(shown) <= set(printed.split())


@pytest.mark.thorough
def test_the_verdict_is_one_sentence_in_terminal_and_page(answers):
    printed, page, _, total = answers
    (line,) = total.verdict
    said = "".join(getattr(one, "text", one) for one in line)
    assert said in printed
    assert said in page.of("p")


@pytest.mark.thorough
@pytest.mark.parametrize(("lacks", "words"), [(2e-6, "0.0001146 deg"), (2e-3, "0.115 deg")])
def test_a_shortfall_is_never_printed_as_zero(answers, lacks, words):
    total = answers[3]
    short = replace(total, reserve=0.0, limit=total.total - lacks)
    (line,) = short.verdict
    said = "".join(getattr(one, "text", one) for one in line)
    assert f"NOT SUFFICIENT, short by {words}" in said


@pytest.mark.thorough
def test_the_card_of_a_notebook_has_the_digits_of_the_tables(answers):
    _, _, sizing, total = answers
    tallest = tables.by_wind(sizing, "K = 1").rows[0]
    for number in texts(tallest):
        assert f"<td>{number}</td>" in sizing._repr_html_()
    for number in texts(line for row in total_table(total).rows for line in row):
        assert number in total._repr_html_()


def test_of_one_wind_the_worst_is_that_wind(answers):
    _, _, sizing, _ = answers
    worst, only = (tables.time_tables(sizing, "K = 1", wind) for wind in (None, 0))
    width = len([one for one in sizing.required if not one.varying])
    for both in zip(worst, only, strict=True):
        first, second = ([texts(row)[:width] for row in one.rows] for one in both)
        assert first == second


@pytest.mark.thorough
def test_a_frozen_requirement_that_is_no_approximation_has_no_row() -> None:
    pulse = tv.TriangularWind(peak=0.05, duration=7.5)
    schedule = tv.load_schedule("configuration-i")
    sizing = tv.size(schedule, pulse, times=[60.0, 66.0], varying=True)
    off = {
        key: need * [[1.0], [3.0]] if key == "K = 1" else need
        for key, need in sizing.required.items()
    }
    whole, frozen = (
        tables.time_tables(sizing, "K = 1, varying"),
        tables.time_tables(replace(sizing, required=off), "K = 1, varying"),
    )
    assert [len(table.rows) for table in whole] == [2, 2]
    assert [len(table.rows) for table in frozen] == [2, 1]
    assert frozen[1].caption.endswith("where that is off by at most 100 % [deg]")


def test_a_lower_bound_of_the_frozen_vehicle_that_is_far_off_is_explained() -> None:
    """At 40 s of a pulse parameters change so much that both bounds part; at 7.5 s they do not."""
    flight = tv.load_schedule("configuration-i")
    far, near = (
        tv.size(
            flight,
            tv.TriangularWind(peak=0.09, duration=duration),
            times=[61.0, 80.0],
            dead_bands=1.0,
            varying=True,
        )
        for duration in (40.0, 7.5)
    )
    ratio = far.required["minimum"][0, 0] / far.required["minimum, varying"][0, 0]

    assert ratio > 1.5
    assert f"is {ratio:.3g} times the bound with parameters that change" in tables.legend(far)
    assert "holds for that vehicle alone" not in tables.legend(near)
    (drawn,) = plots.sizing_chart(near).figure.legends
    assert drawn.get_title().get_text() == "lines: vehicle frozen\nmarks: vehicle varying"


def test_a_sounding_beside_a_pulse_has_no_columns_of_head_and_tail_wind(tmp_path) -> None:
    """Where it is not known, the flight data are not said to cover it."""
    sounding = (FOLDER / "wyoming.txt").read_text()
    (tmp_path / "wyoming.txt").write_text(sounding)
    second = '[[wind]]\nsounding = "wyoming.txt"\nazimuth_deg = 90\n[nozzle]'
    path = tmp_path / "s.toml"
    path.write_text(TEXT.replace("[nozzle]", second).replace("varying = true", "varying = false"))
    plan = load_study(path)
    sizing = plan.sizing.sizing(plan)
    pulse, balloon = (tables.time_tables(sizing, next(iter(sizing.required)), j)[0] for j in (0, 1))

    assert {"head wind", "tail wind"} <= set(pulse.head)
    assert not {"head wind", "tail wind"} & set(balloon.head)
    assert [text(row[-1]) for row in balloon.rows] == ["yes", "no", "no"]
