"""`reproduce`: every figure with its numbers, whole or not at all, and the exit codes."""

from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.turns import usual
from tvclin.base import files
from tvclin.cli.app import app
from tvclin.plots import boundaries as flown_room
from tvclin.show import reproduce

mpl.use("Agg")
pytestmark = pytest.mark.usefixtures("no_flights")

NAMES = [
    *(f"figure-{number}" for number in range(1, 12)),
    *(f"sketch-{letter}" for letter in "abc"),
]


def run(*arguments):
    return CliRunner().invoke(app, ["reproduce", *map(str, arguments)])


@pytest.fixture(scope="module", params=usual([["figure-3", "figure-7"], NAMES], 0), ids=len)
def names(request):
    return request.param


@pytest.fixture(scope="module")
def everything(names, tmp_path_factory, no_flights):
    plt.close("all")  # what other tests have drawn
    output = tmp_path_factory.mktemp("out") / "made" / "here"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reproduce, "FIGURES", {name: reproduce.FIGURES[name] for name in names})
        return output, run("--output", output)


@pytest.mark.thorough
def test_all_files_are_written_and_told(names, everything):
    output, result = everything
    expected = {f"{name}.{kind}" for name in names for kind in ("png", "csv")}

    assert result.exit_code == 0
    assert expected <= {path.name for path in output.iterdir()}
    for name in expected:
        assert str(output / name) in result.output.replace("\n", "")


@pytest.mark.thorough
def test_no_temporary_file_is_left_and_none_is_empty(everything):
    output, _ = everything

    for path in output.iterdir():
        assert not path.name.startswith(".")
        assert path.stat().st_size > 1000


@pytest.mark.thorough
def test_each_csv_names_its_figure_and_its_parameters(names, everything):
    output, _ = everything

    for name in names:
        comment, headings, *rows = (output / f"{name}.csv").read_text(encoding="utf-8").splitlines()
        assert comment.startswith(f"# {name}: ")
        assert "[-]" in headings
        assert len(rows) > 30
    assert "K = 1" in (output / "figure-3.csv").read_text(encoding="utf-8").splitlines()[0]


def test_each_csv_holds_what_the_figure_draws(everything):
    output, _ = everything
    plot = reproduce.FIGURES["figure-7"]()
    plt.close(plot.figure)
    drawn, written = plot.curves.csv(), (output / "figure-7.csv").read_text(encoding="utf-8")

    assert drawn.splitlines()[:2] == written.splitlines()[:2]
    tables = [np.genfromtxt(text.splitlines()[2:], delimiter=",") for text in (drawn, written)]
    np.testing.assert_allclose(*tables, rtol=1e-9, atol=1e-12)  # compiled or not


@pytest.mark.parametrize("there", [True, False])
def test_what_flies_is_said_where_jsbsim_is_missing(tmp_path, monkeypatch, there):
    monkeypatch.setattr(reproduce, "FIGURES", {})
    monkeypatch.setattr(flown_room, "find_spec", lambda name: object() if there else None)
    result = run("--output", tmp_path)

    assert result.exit_code == 0
    assert ('pip install "tvclin[sixdof]"' in result.output) is not there


def test_no_figure_stays_open(everything):
    assert everything[1].exit_code == 0
    assert not plt.get_fignums()


@pytest.mark.thorough
def test_every_figure_is_written_in_turn_and_again_over_itself(tmp_path, monkeypatch):
    two = {name: reproduce.FIGURES[name] for name in ("sketch-a", "sketch-b")}
    monkeypatch.setattr(reproduce, "FIGURES", two)
    expected = [tmp_path / f"{name}.{kind}" for name in two for kind in ("png", "csv")]

    for _ in range(2):
        assert reproduce.reproduce(tmp_path) == expected
        assert (tmp_path / "sketch-b.csv").read_text().startswith("# sketch-b")


def test_the_command_says_where_figures_differ_from_the_print(everything):
    said = " ".join(everything[1].output.split())
    for figure, words in reproduce.DIFFERENCES.items():
        assert f"{figure}: {words}" in said


@pytest.mark.parametrize("place", ["file", "file/below", "nul\0"])
def test_a_place_that_cannot_be_a_directory_is_one_sentence(tmp_path, place):
    (tmp_path / "file").write_text("mine")

    with pytest.raises(tv.InputError):
        reproduce.reproduce(tmp_path / place)
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_the_command_line_answers_two_for_such_a_place(tmp_path, place):
    (tmp_path / "file").write_text("mine")
    result = run("--output", tmp_path / place)

    assert result.exit_code == 2
    assert result.output.startswith("Error: ")
    assert len(result.output.strip().splitlines()) == 1
    assert (tmp_path / "file").read_text() == "mine"


def test_an_unwritable_place_is_one_sentence(tmp_path, monkeypatch):
    def refuse(**_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(files.tempfile, "mkstemp", refuse)
    with pytest.raises(tv.InputError, match="cannot be written: Permission denied"):
        reproduce.reproduce(tmp_path)

    plt.close("all")


def test_a_file_is_whole_or_as_it_was(tmp_path):
    path = tmp_path / "numbers.csv"
    path.write_text("before")

    def half(target):
        Path(target).write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(tv.InputError, match="No space left"):
        files.write_whole(path, half)
    assert path.read_text() == "before"
    assert [path] == list(tmp_path.iterdir())
