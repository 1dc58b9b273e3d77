"""The command line: exit codes, JSON that equals the library, and never a traceback."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import typer
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.turns import by_turns, drawn
from tvclin.base.files import write_text
from tvclin.boundary.limit_shapes import LIMIT_SHAPES
from tvclin.cli.app import NAMES, app
from tvclin.control.laws.registry import LAWS
from tvclin.vehicle.vehicle_file import template


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


def helps(command: str) -> str:
    """Return the help of a command, in one line and without its frame."""
    shown = CliRunner(env={"COLUMNS": "400"}).invoke(app, [command, "--help"])
    assert shown.exit_code == 0
    return " ".join(shown.output.replace("\u2502", " ").split())


@pytest.mark.parametrize("command", NAMES)
def test_a_help_says_its_defaults_in_one_way(command: str) -> None:
    said = helps(command)
    for riddle in ("as without", "if nothing is", "in its place, in", "; 0.7.", "; 2000."):
        assert riddle not in said


def test_a_help_leaves_the_line_ends_of_its_paragraphs_to_the_terminal() -> None:
    shown = CliRunner(env={"COLUMNS": "400"}).invoke(app, ["fly", "--help"]).output
    (line,) = (one for one in shown.splitlines() if "about a second" in one)
    assert line.strip().endswith("for each law and wind.")


def test_a_help_names_what_there_is_to_choose() -> None:
    for law in LAWS:
        assert law in helps("fly")
    for shape in LIMIT_SHAPES:
        assert shape in helps("study")


def test_the_help_of_margins_limits_its_csv_to_a_whole_flight_as_its_message_does() -> None:
    assert "Of a whole flight, also write the margins by flight time into this CSV" in helps(
        "margins"
    )
    refused = run("margins", "configuration-i", "--chart", "root-locus", "--csv", "no.csv")
    assert refused.exit_code == 2
    assert "--csv needs a whole flight" in refused.output


def test_a_shipped_vehicle_can_be_copied(tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    assert run("init", str(mine), "--vehicle", "made-up-booster").exit_code == 0
    assert tv.load_vehicle(mine) == tv.load_vehicle("made-up-booster")
    assert len(tv.load_vehicle(mine).structure.bending) == 3
    for wrong, said in {
        ("--vehicle", "configuration-ii", "--study"): "--study or --vehicle, not both",
        ("--vehicle", "configuration-x"): "--vehicle must be one of configuration-i",
    }.items():
        result = run("init", str(tmp_path / "new.toml"), *wrong)
        assert (result.exit_code, said in result.output) == (2, True)
        assert not (tmp_path / "new.toml").exists()


def test_the_study_prints_the_report_numbers() -> None:
    arguments = ("--duration", str(4 / 0.5292825), "--peak-deg", "5", "--model", "drift")
    result = run("study", "configuration-i", *arguments, "--more")

    assert result.exit_code == 0
    for number in (
        "0.5293",
        "0.1072",
        "0.5102, 0.012854",
        "0.688",
        "0.559",
        "0.374",
        "0.665",
    ):
        assert number in result.output


@pytest.mark.thorough
def test_a_damped_vehicle_is_shown_with_its_pole(tmp_path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(template() + "\n", encoding="utf-8")
    undamped = run("study", str(mine), "--more")
    assert "damping" not in undamped.output.replace("pitch_damping is given", "")
    line = "# pitch_damping_N_m_s_per_rad = 5.0e6"
    mine.write_text(template().replace(line, line[2:]), encoding="utf-8")
    shown = run("study", str(mine), "--more")
    c = tv.Coefficients.from_vehicle(tv.load_vehicle(mine))
    for said in ("pitch damping M_q", f"{c.pole:.4f}", f"{c.damping:.5f}", f"{c.beta:.4f}"):
        assert said in shown.output
    document = json.loads(run("study", str(mine), "--json").stdout)
    assert document["coefficients"]["pole_per_s"] == c.pole
    assert document["coefficients"]["damping"] == c.damping
    over = ("--tau-beta", "4")
    assert "tau*p" in run("boundary", str(mine), *over).output
    assert "tau*beta" in run("boundary", "configuration-i", *over).output
    for source, key in ((str(mine), "tau_p"), ("configuration-i", "tau_beta")):
        assert key in json.loads(run("boundary", source, *over, "--json").stdout)


def test_json_equals_the_library() -> None:
    document = json.loads(run("study", "configuration-ii", "--limit-deg", "0.2", "--json").stdout)
    expected = tv.Study.from_vehicle(
        tv.load_vehicle("configuration-ii"),
        duration=7.5,
        peak=np.radians(5),
        limit=np.radians(0.2),
    )

    computed = {name: boundary["limit"] for name, boundary in document["boundaries"].items()}
    assert computed == {
        name: boundary.limit.tolist() for name, boundary in expected.boundaries.items()
    }
    assert expected.sufficient is document["verdict"]["sufficient"]
    assert document["verdict"]["required_deflection_deg"] == pytest.approx(
        np.degrees(expected.required_deflection), rel=1e-15
    )


@pytest.mark.parametrize(("limit", "code"), [("0.42", 0), ("0.41", 1)])
def test_the_exit_code_is_the_verdict(limit: str, code: int) -> None:
    assert code == run("study", "--limit-deg", limit).exit_code


def test_a_wind_speed_becomes_the_angle_of_eq_b1e() -> None:
    pitch = json.loads(run("study", "--peak-speed", "69.4", "--json").stdout)
    yaw = json.loads(run("study", "--peak-speed", "69.4", "--plane", "yaw", "--json").stdout)

    sine = 69.4 / 538.81
    expected = np.degrees(np.arcsin(sine * np.sin(np.radians(44.83))))
    assert pitch["wind"]["peak_deg"] == pytest.approx(expected, rel=1e-12)
    assert yaw["wind"]["peak_deg"] == pytest.approx(np.degrees(np.arcsin(sine)), rel=1e-12)


def test_boundary_prints_figure_two() -> None:
    result = run("boundary", "--tau-beta", "4", "--json")

    expected = [0.6884593698, 0.6539593346, 0.5587576750, 0.4554095018, 0.3738225362]
    assert json.loads(result.stdout)["limit"][0] == pytest.approx(expected, abs=5e-11)


def test_boundary_of_a_vehicle_includes_its_drift() -> None:
    arguments = ("boundary", "configuration-i", "--tau-beta", "4", "--dead-band", "1", "--json")

    for model, expected in ((("--model", "drift"), 0.66484), ((), 0.65596)):
        computed = json.loads(run(*arguments, *model).stdout)["limit"][0][0]
        assert computed == pytest.approx(expected, abs=5e-6)


def test_poles_prints_every_model() -> None:
    result = run("poles", "configuration-i")

    assert result.exit_code == 0
    for number in ("-0.54812", "0.5102", "0.012854", "0.0064156±0.011214j"):
        assert number in result.output


def test_poles_in_json_are_beta_and_its_residues() -> None:
    document = json.loads(run("poles", "--model", "fixed-path", "--json").stdout)
    c = tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))
    poles = {one["pole_per_s"]: one for one in document["models"]["fixed-path"]}

    assert sorted(poles) == pytest.approx([-c.beta, c.beta], rel=1e-14)
    # -mu_delta/(s^2 - beta^2) at the pole beta, and -B of it for the wind
    growing = poles[max(poles)]
    assert abs(growing["deflection_residue_per_s"]) == pytest.approx(c.mu_delta / (2 * c.beta))
    assert abs(growing["wind_residue_per_s"]) == pytest.approx(c.beta / 2)


def test_poles_of_a_flexible_vehicle_list_its_modes_by_name() -> None:
    """They are eigenvalues of the exported state space, near the frequencies of the file."""
    vehicle = tv.load_vehicle("made-up-booster")
    eigenvalues = np.linalg.eigvals(tv.linear.plant_of(vehicle).ss().A)
    modes = json.loads(run("poles", "made-up-booster", "--json").stdout)["modes"]
    names = [f"bending {k}" for k in (1, 2, 3)] + ["slosh 1", "slosh 2"]
    assert [mode["name"] for mode in modes] == names
    for mode in modes:
        pole = complex(mode["pole_per_s"]["real"], mode["pole_per_s"]["imag"])
        assert np.abs(eigenvalues - pole).min() < 1e-9 * abs(pole)
        assert mode["damping"] == pytest.approx(-pole.real / abs(pole), rel=1e-12)
    said = run("poles", "made-up-booster").output
    assert "slosh 2      -0.031136±3.0407j" in said
    assert "rigid body             0.50775" in said
    assert json.loads(run("poles", "configuration-i", "--json").stdout)["modes"] == []


def test_a_gust_on_top_is_told() -> None:
    said = " ".join(run("study", "--gust", "1", "2", "--sign", "frozen").output.split())
    assert ", with a gust of 1 deg and 2 s" in said


@pytest.mark.skipif(not Path("/dev/null").exists(), reason="a device of POSIX")
def test_a_device_is_no_file_to_replace() -> None:
    with pytest.raises(tv.InputError, match=r"^/dev/null is not an ordinary file; name another$"):
        write_text(Path("/dev/null"), "a figure")


def test_a_fault_of_the_package_is_not_dressed_up_as_bad_input(monkeypatch) -> None:
    def broken(_: object) -> None:
        raise ValueError("operands could not be broadcast together")

    monkeypatch.setattr("tvclin.studyfile.read.load_any_vehicle", broken)
    result = run("poles")

    assert result.exit_code == 1
    assert type(result.exception) is ValueError


def test_vehicles_and_version_are_told() -> None:
    assert "configuration-ii" in run("vehicles").output
    assert json.loads(run("vehicles", "--json").stdout)["configuration-i"]["B"] == pytest.approx(
        0.107229, abs=5e-7
    )
    assert tv.__version__ in run("--version").output


def test_a_file_from_init_can_be_studied_and_is_not_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"

    assert run("init", str(file)).exit_code == 0
    assert run("study", str(file)).exit_code == 0
    before = file.read_text()
    again = run("init", str(file))
    assert again.exit_code == 2
    assert "exists already" in again.output
    assert before == file.read_text()


@by_turns("command,kind", ["study", "poles", "boundary"], ["png", "svg", "pdf"], each=5)
def test_figures_are_written(tmp_path: Path, command: str, kind: str) -> None:
    file = tmp_path / f"figure.{kind}"

    assert run(command, "--plot", str(file)).exit_code == 0
    assert file.stat().st_size > 5000
    assert [file] == list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "arguments",
    [
        ["study", "configuration-3"],
        ["study", "--wind", "square"],
        ["study", "--duration", "0"],
        ["study", "--duration", "nan"],
        ["study", "--duration", "many"],
        ["study", "--peak-deg", "0"],
        ["study", "--peak-deg", "90"],
        ["study", "--peak-deg", "5", "--peak-speed", "40"],
        ["study", "--peak-speed", "1e4"],
        ["study", "--dead-band", "1.5"],
        ["study", "--limit-deg", "0"],
        ["study", "--limit-deg", "-1"],
        ["study", "--model", "drifty"],
        ["study", "--plane", "roll"],
        ["study", "--cases", "100"],
        ["study", "--seed", "1"],
        ["study", "--set", "gust.peak_time_s=3"],
        ["study", "--plot", "figure.xyz"],
        ["study", "--plot", "/nowhere/at/all/figure.png"],
        ["study", "."],
        ["study", "missing.toml"],
        ["boundary", "--tau-beta", "-1"],
        ["boundary", "--dead-band", "2"],
        ["boundary", "--model", "drift"],
        ["boundary", "--wind", "square"],
        ["poles", "--model", "none"],
        ["init", "."],
        ["init", "/nowhere/at/all/x.toml"],
        ["nonsense"],
    ],
)
def test_bad_input_is_exit_code_two_without_a_traceback(arguments: list[str]) -> None:
    result = run(*arguments)

    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit)
    assert result.output.strip()


WORDS = st.one_of(
    st.sampled_from(
        ["study", "boundary", "poles", "--json", "--wind", "--duration", "--limit-deg"]
    ),
    st.sampled_from(["--peak-deg", "--dead-band", "--model", "configuration-i", "all", "drift"]),
    st.floats().map(str),
    st.text(max_size=8),
)


@drawn(20, 80, st.lists(WORDS, max_size=6))
def test_rubbish_never_ends_in_a_traceback(arguments: list[str]) -> None:
    if "init" in arguments or "--plot" in arguments:
        return
    result = run(*arguments)

    assert result.exit_code in (0, 1, 2)
    assert result.exception is None or isinstance(result.exception, SystemExit)


def test_nothing_heavy_is_loaded_before_it_is_needed() -> None:
    code = (
        "import sys, tvclin; from tvclin.cli.app import app;"
        "print([m for m in ('numpy', 'control', 'scipy', 'matplotlib') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert out.stdout.strip() == "[]"


@pytest.mark.thorough
def test_a_study_needs_neither_control_nor_pyplot() -> None:
    code = (
        "import sys, tvclin as tv;"
        "tv.Study.from_vehicle(tv.load_vehicle('configuration-i'), duration=7.5, peak=0.08);"
        "print([m for m in ('control', 'matplotlib') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert out.stdout.strip() == "[]"


HEAVY = ("control", "matplotlib", "scipy.signal", "scipy.stats", "jinja2", "pyarrow", "jsbsim")


def loaded_by(commands: list[str], folder: Path) -> set[str]:
    """Return which heavy modules a process has after these commands; it says so at the end."""
    code = (
        "import sys\n"
        "from tvclin.cli.app import main\n"
        "for line in sys.argv[2:]:\n"
        "    sys.argv[1:] = line.split()\n"
        "    try: main()\n"
        "    except SystemExit as end: assert end.code in (0, 1, None), (line, end.code)\n"
        f"print(*[m for m in {HEAVY!r} if m in sys.modules], file=sys.stderr)"
    )
    command = [sys.executable, "-c", code, "", *commands]
    run = subprocess.run(command, capture_output=True, text=True, check=True, cwd=folder)
    return set(run.stderr.splitlines()[-1].split())


@pytest.mark.thorough
def test_what_is_only_printed_needs_neither_control_nor_pyplot(tmp_path: Path) -> None:
    commands = ["vehicles", "poles", "boundary", "respond", "study", "fly", "margins"]
    commands += ["margins --delay-ms 40", "margins --json", "fly --law autopilot --json"]

    assert loaded_by(commands, tmp_path) == set()


def test_a_study_imports_neither_scipy_nor_numba() -> None:
    code = (
        "import sys\n"
        "from tvclin.cli.app import main\n"
        "sys.argv[1:] = ['study']\n"
        "try: main()\n"
        "except SystemExit as end: assert end.code in (0, 1, None)\n"
        "print(*{m.split('.')[0] for m in sys.modules}, file=sys.stderr)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"scipy", "numba", "matplotlib", "control"} & set(out.stderr.split())


@pytest.mark.thorough
def test_a_study_of_a_fixed_path_in_calm_air_loads_neither_flights_nor_other_commands() -> None:
    """With drift the trim law is flown, and a head wind changes the parameters.

    Of autopilots only what specifies the options of gains is loaded.
    """
    code = (
        "import sys\n"
        "from tvclin.cli.app import main\n"
        "sys.argv[1:] = 'study configuration-i --model fixed-path --sign frozen'.split()\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print(*[m for m in sys.modules if m.startswith('tvclin')], file=sys.stderr)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = out.stderr.split()

    assert not [m for m in loaded if m.startswith("tvclin.flights")]
    control = {m for m in loaded if m.startswith("tvclin.control.")}
    assert "tvclin.control.autopilot.design_rules" in control
    late = ("turbulence", "autopilot.detuning", "autopilot.sweep", "comparison")
    assert not [m for m in control if m.startswith(tuple(f"tvclin.control.{m}" for m in late))]
    assert {"tvclin.cli.study", "tvclin.cli.app"} <= set(loaded)
    assert not {"tvclin.cli.ascent", "tvclin.cli.campaign", "tvclin.cli.fly"} & set(loaded)
    assert len(loaded) <= 145


@pytest.mark.thorough
def test_a_figure_of_boundaries_needs_pyplot_but_not_control(tmp_path: Path) -> None:
    commands = ["boundary --plot b.png", "boundary configuration-i --plot o.png"]

    assert loaded_by(commands, tmp_path) == {"matplotlib"}
    assert {path.name for path in tmp_path.iterdir()} == {"b.png", "o.png"}


def test_python_m_is_the_command_line() -> None:
    command = [sys.executable, "-m", "tvclin", "boundary", "--tau-beta", "4"]
    out = subprocess.run(command, capture_output=True, text=True, check=True)

    assert "0.688" in out.stdout


def test_no_help_holds_square_brackets_which_would_vanish() -> None:
    """The help is written with rich, to which [schedule] is a style."""

    def texts(command):
        yield command.help or ""
        for parameter in command.params:
            yield getattr(parameter, "help", None) or ""
        for value in getattr(command, "commands", {}).values():
            yield from texts(value)

    result = list(texts(typer.main.get_command(app)))
    assert len(result) > 100
    assert [text for text in result if "[" in text] == []


@pytest.mark.thorough
def test_a_limit_that_does_not_exist_is_said_in_the_same_words_everywhere(tmp_path: Path) -> None:
    slow = tmp_path / "slow.toml"
    text = template().replace("velocity_m_per_s = 540.0", "velocity_m_per_s = 45.0")
    slow.write_text(text.replace("attitude_deg = 45.0", "attitude_deg = 85.0"))
    exact = (str(slow), "--model", "drift-exact")
    study = run("study", *exact, "--dead-band", "0", "--limit-deg", "0.4")

    assert study.exit_code == 1
    assert "Required deflection: none is sufficient (model drift-exact, dead band 0" in study.output
    for others in (
        run("boundary", *exact, "--tau-beta", "4"),
        run("fly", *exact, "--law", "autopilot"),
        run("boundary", *exact),
    ):
        assert "none is sufficient" in others.output
        assert " inf" not in others.output
    flown = run("fly", str(slow), "--dead-band", "0")
    assert flown.exit_code == 2
    assert flown.stderr.startswith("Error: no limit is sufficient with this dead band")


def test_a_table_of_boundaries_says_which_of_them_are_not_all_that_is_required() -> None:
    arguments = ("boundary", "configuration-i", "--tau-beta", "4", "--tau-beta", "20")
    exact = " ".join(run(*arguments, "--model", "drift-exact", "--more").output.split())

    minimum = "the minimum over all unstable poles"
    assert f"Note: K = 0, tau*beta 20: {minimum} is larger." in exact
    assert f"Note: K = 0.25, tau*beta 20: {minimum} after trim is larger." in exact
    assert "Note: K = 1, 0.75, 0.5, tau*beta 4 to 20: in flight" in exact
    assert "Note" not in run("boundary", "--tau-beta", "4").output


@pytest.mark.thorough
def test_an_empty_folder_is_refused_and_the_backend_of_a_terminal_is_left_out(tmp_path) -> None:
    assert "must name a directory" in CliRunner().invoke(app, ["reproduce", "--output", ""]).stderr
    words = [sys.executable, "-m", "tvclin", "boundary", "--plot", str(tmp_path / "limits.png")]
    done = subprocess.run(words, env=os.environ | {"MPLBACKEND": "nonsense"}, check=False)
    assert done.returncode == 0


def test_the_vehicle_of_a_flight_has_a_name_and_its_altitude_in_its_file(tmp_path) -> None:
    file = tmp_path / "at.toml"
    CliRunner().invoke(app, ["init", "--from", "configuration-i", "--at", "66", str(file)])
    assert tv.load_vehicle(file).name
    assert "# altitude_m = 11950" in file.read_text(encoding="utf-8")


_MAX_OPTIONS = 20
_COMMON = {"--set", "--json", "--csv", "--plot", "--more", "--help"}


@pytest.mark.parametrize("command", NAMES)
def test_a_command_has_at_most_twenty_options_of_its_case(command: str) -> None:
    made = typer.main.get_command(app).commands[command]
    for value in getattr(made, "commands", {command: made}).values():
        flags = {item.opts[0] for item in value.params if item.opts[0].startswith("-")} - _COMMON
        assert len(flags) <= _MAX_OPTIONS, sorted(flags)
