"""A page says each number once: head, table of all questions, sections and figure agree."""

import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from tests.archives import Balloon, days, jet, write
from tests.turns import usual
from tvclin.plots.boundaries import study_chart
from tvclin.show.report.page import page_of
from tvclin.studyfile.findings import Findings
from tvclin.studyfile.parse import parse_study
from tvclin.studyfile.questions import questions

pytest.importorskip("jinja2")
pytest.importorskip("latex2mathml")
pytestmark = pytest.mark.usefixtures("few_durations")

WIND = {"shape": "triangular", "peak_deg": 4.0, "duration_s": 6.0}
SPREAD = {"parameter": "thrust", "shape": "truncated", "percent": 1.0}
REPORT = {
    "study": {"vehicle": "configuration-i"},
    "wind": {**WIND, "peak_deg": 5.0, "duration_s": 7.5},
    "nozzle": {"limit_deg": 0.4, "rate_limit_deg_per_s": 10.0},
    "autopilot": {"design": "canonical"},
    "schedule": {"source": "configuration-i"},
    "size": {"from_s": 60.0, "to_s": 70.0, "reserve_percent": 10.0},
    "question": {"probability": 0.9},
    "campaign": {"cases": 200, "seed": 1},
    "dispersion": [SPREAD],
}
COEFFICIENTS = {
    "study": {"vehicle": "known.toml"},
    "wind": {**WIND, "peak_deg": 5.0},
    "nozzle": {"limit_deg": 0.45},
    "autopilot": {"design": "canonical"},
}
FLEXIBLE = {
    "study": {"vehicle": "made-up-launcher"},
    "wind": [
        {**WIND, "direction_deg": 280.0, "azimuth_deg": 45.0},
        {"sounding": "wind.csv", "azimuth_deg": 45.0},
    ],
    "gust": {"peak_deg": 1.0, "duration_s": 2.0, "peak_time_s": 3.0},
    "nozzle": {"limit_deg": 3.0, "limit_shape": "square", "actuator_frequency_Hz": 10.0},
    "autopilot": {
        **{"design": "poles", "natural_frequency_rad_per_s": 1.5, "damping": 0.8},
        **{"delay_ms": 10, "sample_rate_Hz": 100.0},
        "filter": [
            {"kind": "notch", "frequency_Hz": 5.6, "zero_damping": 0.05, "pole_damping": 0.5},
            {"kind": "low-pass", "frequency_Hz": 12.0, "damping": 0.7},
        ],
    },
    "schedule": {"source": "made-up-launcher"},
    "size": {"from_s": 50.0, "to_s": 60.0, "reserve_percent": 10.0},
    "availability": {
        **{"archive": "s-data.txt", "azimuth_deg": 45.0, "least_part": 0.5},
        "persistence_deg": 0.1,
    },
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("agrees")
    text = "[coefficients]\nmu_alpha_per_s2 = 0.28\nmu_delta_per_s2 = 2.6\n"
    (place / "known.toml").write_text(text)
    balloons = [
        Balloon(time, jet(3.0 * (i + 1), direction=240 + i))
        for i, time in enumerate(days("2023-02-15T00", 8))
    ]
    write(place / "s-data.txt", balloons)
    heights = np.arange(0.0, 25001.0, 1000.0)
    speeds = 4.0 + 30.0 * np.exp(-(((heights - 11e3) / 4e3) ** 2))
    rows = [f"{h:.0f},{v:.1f},250" for h, v in zip(heights, speeds, strict=True)]
    head = "height_m,speed_m_per_s,direction_deg"
    (place / "wind.csv").write_text("\n".join((head, *rows)) + "\n")
    return place


def read(html: str) -> dict[str, float]:
    result = re.findall(r'data-name="([^"]+)"\s+data-value="([^"]+)"', html)
    return {name: float(value) for name, value in result}


def marked(html: str) -> float:
    """Return the deflection [deg] in the row of the verdict, with the model of the verdict."""
    (row,) = re.findall(r"<tr><th[^>]*>(?:(?!</th>).)*\(verdict\).*?</tr>", html, re.DOTALL)
    angles = re.findall(r'data-name="[^"]+_deg" data-value="([^"]+)"', row)
    models = re.findall(r'<th scope="col">([a-z-]+) \[deg\]</th>', html)
    return float(angles[models.index("drift-exact")] if len(angles) > 2 else angles[0])


def close(one: float, other: float) -> bool:
    return one == pytest.approx(other, rel=1e-9)


@pytest.mark.parametrize(
    ("document", "count"),
    usual([(REPORT, 7), (COEFFICIENTS, 3), (FLEXIBLE, 6)], 1),
    ids=["report", "coefficients", "flexible"],
)
def test_head_table_sections_and_figure_agree(document, count, folder) -> None:
    html, computed = page_of(parse_study(document, folder))
    shown, limit = read(html), document["nozzle"]["limit_deg"]
    # no margins where the limit loses it, no flights of a loop along the flight in both planes
    assert not computed.reasons.keys() - {"flown", "flights"}
    each = {question.name: question for question in questions(computed)}
    assert len(each) >= count - 1
    for value in each.values():
        if value.measure is None or np.isinf(value.measure.required):  # none is sufficient
            continue
        names = [key for key in shown if key.startswith(f"answer.{value.name.replace(' ', '_')}.")]
        values = {
            re.sub(r".*\.(required|available|remaining).*", r"\1", key): shown[key] for key in names
        }
        assert ("remaining" in values) == (value.yes is not None)
        if value.yes is not None:
            assert close(values["remaining"], values["available"] - values["required"])
        if value.measure.unit == "deg" and value.name != "margins":
            assert close(values["available"], limit)
    wind = shown["answer.wind.required_deg"]
    _head(shown, wind, limit, each)
    assert close(marked(html), wind)
    _figure(computed, wind, limit)
    _sections(shown, computed)


def _head(shown, wind, limit, each) -> None:
    assert close(shown["facts.limit_deg"], limit)
    if "verdict.required_deg" in shown:
        sized = [value for value in each.values() if np.isfinite(value.required_deflection)]
        failed = [one for one in sized if one.yes is False] or sized
        worst = max(float(np.degrees(one.required_deflection)) for one in failed)
        assert close(shown["verdict.required_deg"], worst)
        assert close(shown["verdict.surplus_deg"], abs(worst - limit))
    peak = shown["basis.peak_deg"]
    assert shown["facts.survivable_peak_deg"] <= peak * limit / wind * 1.2  # of a head wind less


def _figure(findings: Findings, wind: float, limit: float) -> None:
    """The dot and the line of the limit in the figure of the boundaries."""
    study = findings.study
    chart = study_chart(study, [0.5 * study.wind.duration, study.wind.duration])
    dot, line = (
        next(one for one in chart.axes.flat[0].lines if one.get_label().startswith(label))
        for label in ("required", "available limit")
    )
    assert close(float(np.ravel(dot.get_ydata())[0]), wind)
    assert close(float(np.ravel(line.get_ydata())[0]), limit)


def _sections(shown: dict[str, float], findings: Findings) -> None:
    """What the table says of each question is what its own section says."""
    calm = "answer.calm_deg"  # of the autopilot, where a head wind asks for more
    autopilot = calm if calm in shown else "answer.autopilot.required_deg"
    pairs = {
        "answer.whole_flight.required_deg": "total.required_deg",
        autopilot: "wind.stop_deg",
        "answer.probability.required_deg": "dispersed.upper_deg",
        "answer.availability.available_percent": "availability.part_percent",
        "answer.margins.required_dB": "criteria.aero_margin_dB",
        "answer.margins.available_dB": "margin.aero_margin_dB",
        "answer.margins.required_deg": "criteria.phase_margin_deg",
        "answer.margins.available_deg": "margin.phase_margin_deg",
    }
    seen = [name for name in pairs if name in shown]
    assert seen
    over = findings.study.plane_ratio
    for name in seen:
        part = over if name == autopilot else 1.0
        assert close(shown[name], part * shown[pairs[name]]), name
    if findings.flexible is not None:
        assert close(shown[autopilot], over * shown["flown.0.0_deg"])
        assert close(shown["answer.flexible_flight.required_deg"], shown[autopilot])
    turns = over * shown["wind.deflection_deg"]
    assert close(shown["answer.autopilot_deg"], turns)


def test_each_section_that_the_style_names_is_on_the_page() -> None:
    folder = files("tvclin.show.report")
    style, *pages = (
        folder.joinpath(name).read_text(encoding="utf-8")
        for name in ("style.css", "sections.html", "page.html")
    )
    named = set(re.findall(r"#([a-z]+)\b(?=[^;{}]*\{)", style))
    shown = set(re.findall(r'(?:section|figure)\("(\w+)"|id="(\w+)"', "".join(pages)))
    assert named <= {name for pair in shown for name in pair}
