"""An archive in a study file: the page shows the library's numbers, and a part is judged."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import tvclin as tv
from tests.archives import Balloon, days, jet, write
from tests.show.pages import section
from tvclin.cli.app import app
from tvclin.ensembles.availability.availability import AVAILABILITY_TABLE
from tvclin.studyfile.findings import find
from tvclin.studyfile.parse import parse_study
from tvclin.studyfile.questions import questions

LIMIT = 0.5
"""deg; the wind of the study needs 0.37."""
ASKED = {"archive": "s-data.txt", "azimuth_deg": 90, "plane": "pitch", "persistence_deg": 0.02}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder of jets of 2, 4 ... 80 m/s, in no order; the third is never encountered."""
    place = tmp_path_factory.mktemp("archive")
    times = days("2023-02-15T00", 40)
    balloons = [
        Balloon(time, jet(2.0 * (17 * i % 40 + 1), top=1e3 if i == 2 else 32e3))
        for i, time in enumerate(times)
    ]
    write(place / "s-data.txt", balloons)
    return place


def document(limit_deg: float | None = LIMIT, **changes: object) -> dict[str, dict]:
    question = {} if limit_deg is None else {"nozzle": {"limit_deg": limit_deg}}
    wind = {"peak_deg": 5.0, "duration_s": 7.5}
    head = {"vehicle": "configuration-i"}
    return {"study": head, "wind": wind, "availability": ASKED | changes} | question


def the_library(folder, **changes: object) -> tv.ensembles.Availability:
    options = {"limit": np.radians(LIMIT), "azimuth": np.radians(90), "plane": "pitch"}
    options |= {"persistence": np.radians(0.02)} | changes
    archive = tv.read_soundings(folder / "s-data.txt")
    return tv.availability(tv.load_schedule("configuration-i"), archive, **options)


def values(html: str) -> dict[str, float]:
    result = re.findall(r'data-name="([^"]+)"\s+data-value="([^"]+)"', html)
    return {name: float(value) for name, value in result}


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_the_page_holds_the_numbers_of_the_library(folder) -> None:
    pytest.importorskip("jinja2")
    pytest.importorskip("latex2mathml")
    html = tv.report_html(parse_study(document(), folder))
    shown, computed = values(html), the_library(folder)
    part = computed.fraction()
    assert (part.unknown, shown["availability.unknown"]) == (1, 1)
    assert 0 < part.flown < part.judged
    expected = {
        "flown": part.flown,
        "judged": part.judged,
        "effective": part.effective,
        "part_percent": 100 * part.fraction,
        "lower_percent": 100 * part.lower,
        "upper_percent": 100 * part.upper,
        "least_percent": 100 * part.bounds[0],
        "most_percent": 100 * part.bounds[1],
        "limit_deg": np.degrees(computed.limit),
    }
    for month, one in computed.by_month().items():
        expected |= {f"month.{month}.flown": one.flown, f"month.{month}.judged": one.judged}
        expected |= {f"month.{month}.lower_percent": 100 * one.lower}
    for name, value in expected.items():
        assert shown[f"availability.{name}"] == value, name
    placard = [shown[f"availability.placard.{p}_deg"] for p in (50, 80, 90, 95, 99)]
    assert placard == np.degrees(computed.placard()).tolist()
    section = html[html.index('id="availability"') :]
    assert "the sounding ends below the height of the largest dynamic pressure" in section
    assert "The soundings are of one season" in section
    assert "40 winds of ZZM00088801 from 2023-02-15 to 2023-03-06" in section
    assert "<svg" in section[: section.index("By month")]


@pytest.mark.thorough
def test_without_an_archive_there_is_no_section_and_the_seal_is_what_it_was(folder) -> None:
    bare = {key: value for key, value in document().items() if key != "availability"}
    assert not section(find(parse_study(bare)), "availability").text
    seals = [
        find(parse_study(one, folder)).seal
        for one in (bare, document(), document(), document(azimuth_deg=91))
    ]
    assert seals[1] == seals[2]
    assert len({*seals}) == 3


@pytest.mark.thorough
def test_a_part_is_asked_for_only_where_it_is_given(folder) -> None:
    def answer(**changes: object) -> list[tuple[str, bool | None]]:
        result = find(parse_study(document(**changes), folder))
        return [(question.name, question.yes) for question in questions(result)]

    part = the_library(folder).fraction()
    assert answer() == [("wind", True)]
    shown = 0.9 * part.lower, part.fraction, min(1.1 * part.upper, 1.0)
    said = [answer(least_part=one)[1] for one in shown]
    assert said == [("availability", yes) for yes in (True, None, False)]
    (_, why) = questions(find(parse_study(document(least_part=0.5), folder)))
    assert why.text == str(part)
    assert (why.measure.required, why.measure.available) == (50.0, 100.0 * part.fraction)


def test_what_is_not_known_is_lost_for_a_yes_and_flown_for_a_no(folder) -> None:
    """Half of the balloons burst; of those that did not, all fly, or none."""
    flight = tv.load_schedule("configuration-i")
    high = tv.read_soundings(folder / "s-data.txt")[9]
    winds = [high.between(0.0, 1e3) if i % 2 else high for i in range(60)]
    some = tv.winds.Soundings.from_profiles(winds, days("2023-01-01T00", 60))
    for limit, sure, not_shown in ((1.0, 0.3, 0.6), (1e-4, 0.7, 0.4)):
        result = tv.availability(flight, some, limit=limit, azimuth=1.57)
        assert (result.fraction().judged, result.fraction().unknown) == (30, 30)
        assert result.reaches(sure) is (limit == 1.0)
        assert result.reaches(not_shown) is None


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def written(folder, name: str, minimum: str, limit: str = f"limit_deg = {LIMIT}") -> str:
    file = folder / name
    file.write_text(
        f"""[study]\nvehicle = "configuration-i"\n[nozzle]\n{limit}\n[wind]
peak_deg = 5\nduration_s = 7.5\n[availability]
archive = ["s-data.txt"]\nazimuth_deg = 90\nplane = "pitch"\npersistence_deg = 0.02\n{minimum}"""
    )
    return str(file)


@pytest.mark.thorough
@pytest.mark.usefixtures("few_durations")
def test_a_study_and_a_page_exit_with_the_answer(folder, tmp_path) -> None:
    few, many = (written(folder, f"{x}.toml", f"least_part = {x}") for x in (0.3, 0.99))
    yes, no = run("study", few), run("study", many, "--json")
    assert (yes.exit_code, no.exit_code) == (0, 1)
    assert "Note: the soundings are of one season" in " ".join(yes.output.split())
    answered = {
        question["name"]: question["yes"] for question in json.loads(no.stdout)["questions"]
    }
    assert answered == {"wind": True, "availability": False}
    # a wider nozzle flies on more days: the option counts for the archive as well
    assert run("study", many, "--limit-deg", 3).exit_code == 1  # 39 of 40 are not 99 % for sure
    assert json.loads(run("study", many, "--limit-deg", 3, "--json").stdout)["questions"][1][
        "why"
    ].startswith("too few soundings to tell whether 99 % of days fly; 39 of 39 soundings survived")
    pytest.importorskip("jinja2")
    pytest.importorskip("latex2mathml")
    assert run("report", few, "-o", tmp_path / "a.html").exit_code == 0
    assert "NOT MET: " in run("report", many, "-o", tmp_path / "b.html").output


@pytest.mark.thorough
def test_without_a_limit_or_an_altitude_there_is_a_reason(folder) -> None:
    result = find(parse_study(document(None), folder))
    assert "judged for a limit" in result.reasons["availability"]
    lists = {name: [value, value] for name, value in LISTS.items()} | {"time_s": [60.0, 70.0]}
    result = find(parse_study(document() | {"schedule": lists}, folder))
    assert "no altitude" in result.reasons["availability"]


LISTS = {
    "weight_N": 1.48e6,
    "moment_of_inertia_kg_m2": 2.25e7,
    "normal_force_slope_N_per_rad": 6.67e5,
    "thrust_N": 2.495e6,
    "aerodynamic_arm_m": 9.45,
    "control_arm_m": 23.56,
    "axial_force_N": 80700.0,
    "velocity_m_per_s": 538.81,
    "attitude_deg": 44.83,
}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"archive": 3}, r"archive in \[availability\] must be a station file, a folder, or a"),
        ({"archive": []}, "must be a station file, a folder, or a list"),
        ({"archive": "none.txt"}, "none.txt does not exist"),
        ({"azimuth": 90}, "azimuth has no known unit .* write azimuth_rad or azimuth_deg"),
        ({"persistence_hours": 3.5}, "an angle and hours of persistence; keep one"),
        ({"months": [13]}, "months must be from 1 to 12"),
        ({"months": [7]}, "soundings must hold one or more"),
        ({"years": [2023]}, "years must be the first and the last"),
        ({"plane": "roll"}, "plane must be"),
        ({"limit_shape": "round"}, r"limit_shape stands in \[nozzle\], not in \[availability\]"),
        ({"least_part": 95}, "least_part must be"),
        ({"persistence_deg": -1}, "persistence must be"),
        ({"known_to_m": -1}, "known_to must be"),
        ({"confidence": 1}, "confidence must be"),
        ({"least_share": 0.9}, r"unknown key in \[availability\]"),
    ],
)
def test_a_table_that_does_not_fit_is_refused_in_one_sentence(folder, changes, said) -> None:
    with pytest.raises(tv.InputError, match=said) as error:
        find(parse_study(document(**changes), folder))
    assert "\n" not in str(error.value)


def test_an_archive_must_be_named() -> None:
    request = document()
    del request["availability"]["archive"]
    with pytest.raises(tv.InputError, match=r"missing in \[availability\]: archive"):
        parse_study(request)


def test_model_limit_stop_and_gust_are_those_of_the_study(folder) -> None:
    wind = {"peak_deg": 5.0, "duration_s": 7.5, "direction_deg": 270, "azimuth_deg": 90}
    plan = parse_study(
        document(plane="both")
        | {
            "study": {"vehicle": "configuration-i", "model": "drift"},
            "wind": wind,
            "gust": {"peak_deg": 0.5, "duration_s": 2.0},
            "nozzle": {"limit_deg": 0.3, "limit_shape": "square"},
        },
        folder,
    )
    assert plan.availability is not None
    result = plan.availability.availability(plan)
    assert (result.model, result.plane, result.judge.limit_shape) == ("drift", "both", "square")
    assert (result.limit, result.judge.additions.gust.peak) == (np.radians(0.3), np.radians(0.5))


def test_a_gust_by_its_speed_is_that_of_the_study(folder) -> None:
    table = {"gust": {"peak_speed_m_per_s": 9.0, "duration_s": 2.0}}
    plan = parse_study(document() | table, folder)
    assert plan.availability is not None
    result = plan.availability.availability(plan)
    gust = tv.OneMinusCosineGust(peak=0.02, duration=2.0)
    single = the_library(folder, gust=gust, gust_speed=9.0)
    assert result.lower == pytest.approx(single.lower, rel=1e-12, nan_ok=True)


def test_the_table_of_the_page_is_read(folder) -> None:
    page = (Path(__file__).parents[2] / "docs" / "availability.md").read_text()
    (text,) = re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL)
    table = tomllib.loads(text)["availability"]
    known = {*AVAILABILITY_TABLE.words, *AVAILABILITY_TABLE.lists} - {"dates"}  # in a comment
    known |= {name for name, _ in AVAILABILITY_TABLE.keys.values()} - {"persistence_hours"}
    assert known == {key.removesuffix("_deg").removesuffix("_m") for key in table}
    table |= {"archive": "s-data.txt", "station": "ZZM00088801"}
    request = parse_study(document() | {"availability": table}, folder).availability
    assert (request.known_to, request.least_part) == (16e3, 0.9)
    assert set(request.soundings.months.tolist()) == {2}
