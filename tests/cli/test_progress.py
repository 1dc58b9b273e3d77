"""What long work tells: lines in a pipe, parts of a page, and how a campaign goes on."""

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.base.files import tables_of
from tvclin.base.package_warnings import MachineWarning
from tvclin.cli import output
from tvclin.cli.app import app
from tvclin.ensembles.campaign import chunk_runner as engine
from tvclin.kernels import choice
from tvclin.show import reproduce
from tvclin.studyfile.campaign_file import parse_campaign, template
from tvclin.studyfile.findings import find


def test_a_pipe_gets_a_line_now_and_then(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(output, "monotonic", lambda: now[0])
    with output.bar("cases") as tell:
        for second in range(1, 101):
            now[0] = float(second)
            tell(10.0 * second, 1000.0)

    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines() == [
        "200 of 1000 cases, about 80 s left",
        "400 of 1000 cases, about 60 s left",
        "600 of 1000 cases, about 40 s left",
        "800 of 1000 cases, about 20 s left",
    ]


def test_work_of_unequal_parts_has_no_remaining_time(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = iter(range(0, 1000, 25))
    monkeypatch.setattr(output, "monotonic", lambda: float(next(now)))
    with output.bar("answers", even=False) as tell:
        for done in range(1, 4):
            tell(done, 4)

    assert capsys.readouterr().err.splitlines() == [f"{n} of 4 answers" for n in (1, 2, 3)]


@pytest.mark.parametrize("before", [0, 600])
def test_the_time_left_counts_neither_compiling_nor_what_was_done_before(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], before: int
) -> None:
    now = [0.0]
    monkeypatch.setattr(output, "monotonic", lambda: now[0])
    with output.bar("cases") as tell:
        for case in range(1, 61):  # the first after half a minute, the others one a second
            now[0] = 34.0 + case
            tell(before + case, before + 60)

    assert capsys.readouterr().err.splitlines() == [
        f"{before + 1} of {before + 60} cases",
        f"{before + 21} of {before + 60} cases, about 39 s left",
        f"{before + 41} of {before + 60} cases, about 19 s left",
    ]


def test_a_page_tells_of_each_part() -> None:
    plan = tv.load_study("configuration-i")
    request = tv.studyfile.StudyPlan(vehicle=plan.vehicle, criteria=tv.CRITERIA["classic"])
    calls: list[tuple[float, float]] = []
    find(request, lambda done, total: calls.append((done, total)))

    assert calls[-1] == (1.0, 1.0)


def test_a_study_tells_of_its_answers(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(output, "_LINE_INTERVAL_S", 0.0)
    monkeypatch.setattr(output, "monotonic", iter(range(100_000)).__next__)
    (tmp_path / "all.toml").write_text(
        '[study]\nvehicle = "configuration-i"\n'
        '[wind]\npeak_deg = 5.0\nduration_s = 7.5\n[criteria]\nname = "classic"\n'
        "[campaign]\ncases = 64\n"
        '[[dispersion]]\nparameter = "thrust"\nshape = "normal"\npercent = 1.0\n'
    )
    said = CliRunner().invoke(app, ["study", str(tmp_path / "all.toml")])

    assert " answers" in said.stderr
    assert " answers" not in said.stdout


@pytest.mark.thorough
def test_the_report_tells_of_each_figure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = reproduce.FIGURES["sketch-a"]
    monkeypatch.setattr(reproduce, "FIGURES", dict.fromkeys("abc", drawn))
    calls: list[tuple[float, float]] = []
    reproduce.reproduce(tmp_path, lambda done, total: calls.append((done, total)))

    assert calls == [(1, 3), (2, 3), (3, 3)]


def test_an_interrupted_campaign_says_how_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    file, folder = tmp_path / "my.toml", tmp_path / "results"
    file.write_text(template())
    monkeypatch.setattr(engine, "run_chunk", interrupted)
    result = CliRunner().invoke(app, ["disperse", str(file), "-o", str(folder)])

    assert result.exit_code == 130
    assert "The same command again" in result.output


def test_the_flight_of_the_template_can_be_taken_in() -> None:
    begin, end = template().index("[outputs]"), template().index("[question]")
    taken = template()[begin:end].replace("\n# stop", "\n#stop")  # that needs a direction
    flight = taken.replace("\n# ", "\n")
    text = template()[:begin] + flight + template()[end:]
    with_flight = text.replace('names = ["required", "minimum"]', 'names = ["required", "flight"]')

    plan = parse_campaign(tables_of(with_flight, "mine"))
    assert (plan.nozzle.rate_limit, plan.autopilot_design.sample_rate) == (np.radians(10.0), 50.0)


@pytest.fixture
def _without_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let there be no compiler, and let a hundredth of a second be long."""
    monkeypatch.setattr(choice, "available", lambda: False)
    monkeypatch.setattr(engine, "available", lambda: False)
    monkeypatch.setattr(choice, "_LONG", 0.01)
    monkeypatch.setattr(choice, "_plain_work", choice._PlainWork())


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_without_numba_a_command_says_so_once_and_its_page_has_the_same_bytes(
    request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    def page() -> tuple[bytes, str]:
        result = CliRunner().invoke(app, ["report", "configuration-i", "-o", f"{tmp_path}/p.html"])
        return (tmp_path / "p.html").read_bytes(), result.stderr

    installed, quiet = page()
    request.getfixturevalue("_without_numba")
    missing, said = page()

    assert "numba" not in quiet
    assert len(re.findall(r"takes about .* without numba.*pip install", said)) == 1
    assert missing == installed
    assert b"numba" not in installed


@pytest.mark.thorough
@pytest.mark.usefixtures("_without_numba")
def test_without_numba_the_work_of_all_cases_of_a_campaign_is_announced_at_its_start(
    tmp_path: Path,
) -> None:
    campaign = parse_campaign(tables_of(template(), "mine"))
    campaign = replace(campaign, cases=8, chunk=8, until=None)
    with pytest.warns(UserWarning, match="without numba") as said, ThreadPoolExecutor(1) as pool:
        tv.run_campaign(campaign, tmp_path / "r", executor=pool, compiled=False)

    assert [one.category for one in said] == [MachineWarning]
    assert choice._plain_work.seconds > 0.0
