"""The campaign commands: what they print is what the library finds, with exit code 2 for no."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.cli.app import app
from tvclin.ensembles.campaign.folder import chunk_file

pytest.importorskip("pyarrow")


def run(*arguments):
    return CliRunner().invoke(app, ["disperse", *map(str, arguments)])


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign")
    written = CliRunner().invoke(app, ["init", "--campaign", str(folder / "my.toml")])
    assert written.exit_code == 0
    text = (folder / "my.toml").read_text()
    small = text.replace("cases = 4096 ", "cases = 600 ").replace("chunk = 1024", "chunk = 256")
    assert small != text
    (folder / "my.toml").write_text(small)
    result = run(folder / "my.toml", "-o", folder / "results")
    assert result.exit_code == 1  # it is sufficient in far fewer than 99.865 percent
    assert result.stdout.startswith(
        "Limit 0.420 deg: NOT SUFFICIENT; required deflection of 600 cases: "
    )
    return folder


@pytest.mark.thorough
def test_show_says_what_the_library_finds(place):
    results = tv.ensembles.open_campaign(place / "results")
    document = json.loads(run(place / "results", "--json").stdout)
    required = results.quantile()
    assert document["estimate_deg"] == pytest.approx(np.degrees(required.estimate), rel=1e-15)
    assert document["upper_deg"] is None  # 600 cases prove nothing of 99.865 percent
    assert document["statuses"] == {"ok": 600}
    assert document["drivers"] == pytest.approx(results.drivers())
    assert document["success"] == pytest.approx(vars(results.success()))
    answers = results.column("required_K1")
    assert document["worst"][0]["case"] == np.argmax(answers)
    assert document["worst"][0]["deg"] == pytest.approx(np.degrees(answers.max()), rel=1e-15)
    assert [row["cases"] for row in document["convergence"]] == [37, 75, 150, 300, 600]
    text = run(place / "results").output
    assert "too few cases to say" in text
    assert f"{document['median_deg']:.3f} deg" in text


@pytest.mark.thorough
def test_show_answers_other_questions(place):
    options = ["--output", "minimum", "--probability", "0.9", "--limit-deg", "0.2", "--json"]
    document = json.loads(run(place / "results", *options).stdout)
    results = tv.ensembles.open_campaign(place / "results")
    values = results.column("minimum")
    assert document["estimate_deg"] == np.degrees(np.quantile(values, 0.9, method="inverted_cdf"))
    assert document["success"]["estimate"] == np.mean(values <= np.radians(0.2))
    assert document["lower_deg"] <= document["estimate_deg"] <= document["upper_deg"]


@pytest.mark.thorough
def test_show_says_which_dead_band_trusts_a_forecast(place):
    said = "trusts a forecast of the wind"
    assert said in run(place / "results", "--output", "required_K0.5").output
    assert said not in run(place / "results", "--output", "required_K1").output


def test_replay_is_the_case_to_the_bit(place):
    results = tv.ensembles.open_campaign(place / "results")
    worst = int(results.worst(1)[0])
    document = json.loads(run(place / "results", "--case", worst, "--json").stdout)
    for name in results.outputs:
        assert document["outputs"][name] == results.column(name)[worst]
    for name in results.campaign.dispersions.parameters:
        assert document["inputs"][name] == results.column(name)[worst]
    one = results.replay(worst)
    needs = results.column("required_K1")[worst]
    assert abs(one.required) < needs == one.outputs["required_K1"]  # in a head wind's pressure
    # On the boundary the attitude stays bounded for ever; with a little less it does not.
    attitude, lost = (
        np.abs(one.response(capability).outputs["attitude"]).max() for capability in (1.0, 0.9)
    )
    assert attitude < 2.0 * results.campaign.wind.peak < lost
    limit = results.campaign.nozzle.limit
    assert limit is not None
    assert needs > limit
    said = f"lost with a limit of {np.degrees(limit):.4g} deg"
    assert one.capability == limit / needs
    fallen = np.abs(one.response(one.capability).outputs["attitude"])
    shown = np.radians(document["response"]["largest_attitude_deg"])
    assert np.isclose(fallen, shown, rtol=1e-12).any()
    assert shown > 2.0 * results.campaign.wind.peak
    easy = results.replay(int(np.argmin(results.column("required_K1"))))
    assert (easy.capability, easy.fate) == (1.0, said.replace("lost", "survives"))
    assert document["fate"] == one.fate == said
    assert f"Case {worst}: {said}" in run(place / "results", "--case", worst).output


@pytest.mark.thorough
def test_resume_names_what_is_damaged_and_mends_it(place, tmp_path):
    folder = tmp_path / "results"
    assert run(place / "my.toml", "-o", folder, "--shard", "1/2").exit_code == 0
    text = run(folder).output
    assert "344 of 600, unfinished" in text
    file = chunk_file(folder, 0)
    file.write_bytes(file.read_bytes()[:1000])
    shown = run(folder)
    assert shown.exit_code == 2
    assert "is damaged; compute it anew: run the campaign" in shown.stderr
    result = run(place / "my.toml", "-o", folder)
    assert "00000000.parquet is damaged" in result.stderr
    assert "600 of 600" in result.output
    assert run(folder).output == run(place / "results").output


@pytest.mark.thorough
def test_it_stops_when_converged(place, tmp_path):
    keys = ("--set", "question.probability=0.5", "--set", "campaign.until_percent=10")
    for folder in ((), ("-o", tmp_path / "results")):
        assert "256 of 600" in run(place / "my.toml", *keys, *folder).output


@pytest.mark.thorough
def test_a_folder_and_the_memory_hold_the_same(place):
    in_memory = json.loads(run(place / "my.toml", "--json").stdout)
    assert in_memory == json.loads(run(place / "results", "--json").stdout)


@pytest.mark.thorough
def test_a_vehicle_is_dispersed_as_its_study(tmp_path):
    options = ("--peak-deg", 4, "--duration", 6, "--plane", "yaw", "--dead-band", 0.8)
    dispersed = run("configuration-ii", *options, "--limit-deg", 0.4, "--cases", 50, "--json")
    study = CliRunner().invoke(app, ["study", "configuration-ii", *map(str, options), "--json"])
    nominal = json.loads(study.stdout)["verdict"]["required_deflection_deg"]
    document = json.loads(dispersed.stdout)
    assert document["nominal_deg"] == pytest.approx(nominal, rel=1e-9)
    assert (document["limit_deg"], document["output"]) == (pytest.approx(0.4), "required_K0.8")
    shown = run("configuration-ii", *options, "--cases", 50)
    assert "these dispersions are assumed: thrust (truncated, 1 %)" in shown.output


def test_in_a_sounding_the_vehicle_alone_is_dispersed(tmp_path):
    """The deflections of a loop over vehicles, at nominal dynamic pressure."""
    sparse = tv.read_sounding(Path(__file__).parents[1] / "soundings" / "wyoming.txt")
    wind, heights = tmp_path / "wind.csv", np.arange(sparse.height[0], 4e4, 1e3)
    heights = np.union1d(heights, sparse.height)  # up to 40 km, without gaps
    east, north = (np.interp(heights, sparse.height, v) for v in (sparse.east, sparse.north))
    rows = [",".join(map(repr, row)) for row in np.stack([heights, east, north], -1).tolist()]
    text = "\n".join(["height_m,east_m_per_s,north_m_per_s", *rows, ""])
    wind.write_text(text, encoding="utf-8")
    given = ("--winds", wind, "--azimuth-deg", 90, "--set", "study.sign=frozen", "--cases", 5)
    result = run("configuration-i", *given, "--model", "fixed-path", "--json")
    document = json.loads(result.stdout)
    assert not any(name.startswith("wind") for name in document["drivers"])
    assert "the vehicle's own time count, cut with steps of" in " ".join(result.stderr.split())
    flight = tv.load_schedule("configuration-i")
    profile = tv.read_sounding(wind)
    encountered = tv.fly_through(profile, flight, azimuth=np.pi / 2, window=20.0)(flight.at(66.0))
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    nominal = np.degrees(abs(float(tv.required_deflection(plant, encountered).deflection)))
    assert document["nominal_deg"] == pytest.approx(nominal, rel=1e-6)


@pytest.mark.thorough
def test_a_terminal_sees_a_bar_and_others_nothing(place, tmp_path):
    arguments = ["disperse", str(place / "my.toml"), "-o"]
    quiet = CliRunner().invoke(app, [*arguments, str(tmp_path / "one")])
    assert quiet.stderr == ""
    shown = CliRunner().invoke(app, [*arguments, str(tmp_path / "two")], env={"FORCE_COLOR": "1"})
    assert "600 of 600 cases" in shown.stderr
    assert "━" in shown.stderr


def test_a_file_is_not_overwritten(place):
    result = CliRunner().invoke(app, ["init", "--campaign", str(place / "my.toml")])
    assert result.exit_code == 2
    assert "exists already" in result.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["none.toml", "-o", "results"],
        ["nowhere"],
        ["configuration-i", "--shard", "1/2"],
    ],
)
def test_bad_input_is_exit_code_two(arguments):
    result = run(*arguments)
    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit)
    assert result.output.strip()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["RESULTS", "--output", "minimun"], "did you mean 'minimum'"),
        (["RESULTS", "--probability", "2"], "probability must be"),
        (["RESULTS", "--limit-deg", "0"], "--limit-deg must be positive"),
        (["RESULTS", "--case", "600"], "case must be below 600"),
        (["RESULTS", "--peak-deg", "4"], "--peak-deg needs a vehicle or a file, not a folder"),
        (["FILE", "-o", "RESULTS", "--shard", "3"], "shard must be i/n"),
        (["FILE", "-o", "RESULTS", "--workers", "0"], "workers must be from 1"),
        (
            ["FILE", "--set", "campaign.until_percent=-1"],
            "until_percent in [campaign] must be positive",
        ),
        (["FILE", "-o", "FILE"], "is a file; name a directory"),
    ],
)
def test_bad_options_are_one_sentence(place, arguments, message):
    names = {"RESULTS": place / "results", "FILE": place / "my.toml"}
    result = run(*(names.get(word, word) for word in arguments))
    assert result.exit_code == 2
    assert message in result.stderr


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("outputs", "words"),
    [
        (["required"], "not counted here: rate limit and gains (tvclin study counts it)"),
        (["required", "margins"], "not counted here: rate limit (tvclin study counts it)"),
        (["required", "flight"], None),
    ],
)
def test_what_the_outputs_of_a_campaign_leave_out_is_said(outputs, words):
    options = {
        "nozzle.rate_limit_deg_per_s": 0.2,
        "autopilot.attitude_gain": 0.9,
        "autopilot.rate_gain_s": 0.9,
        "outputs.names": json.dumps(outputs),
    }
    settings = [word for key, value in options.items() for word in ("--set", key, value)]
    result = run("configuration-i", "--limit-deg", 0.6, "--cases", 20, *settings)
    said = " ".join(result.stderr.split())
    assert result.exit_code == 1, result.output
    assert ("not counted here" in said) == (words is not None), said
    assert words is None or words in said, said
