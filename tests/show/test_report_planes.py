"""The page of a wind with a direction: both planes, each number the library's."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.show.pages import Page
from tests.turns import usual
from tvclin.cli.app import app
from tvclin.show.report.page import page_of
from tvclin.studyfile.parse import parse_study
from tvclin.vehicle.vehicle_file import vehicle_file

pytest.importorskip("jinja2")
pytest.importorskip("latex2mathml")
pytestmark = pytest.mark.usefixtures("few_durations")

WIND = {"peak_deg": 5.0, "duration_s": 7.5, "direction_deg": 270.0, "azimuth_deg": 45.0}


def values(html: str) -> dict[str, float]:
    """Return the numbers of a page by their names."""
    result = re.findall(r'data-name="([^"]+)"\s+data-value="([^"]+)"', html)
    return {name: float(value) for name, value in result}


@pytest.mark.thorough
@pytest.mark.parametrize("stop", usual([None, "square"], 1))
def test_both_planes_have_a_section_where_the_wind_has_a_direction(stop) -> None:
    head = {"vehicle": "configuration-i"}
    nozzle = {} if stop is None else {"limit_shape": stop}
    plan = parse_study({"study": head, "wind": WIND, "nozzle": nozzle})
    html, computed = page_of(plan)
    study = computed.study
    assert study.planes is not None
    numbers = values(html)
    assert numbers["planes.required_deg"] == np.degrees(study.planes.deflection)
    assert numbers["planes.pitch_deg"] == np.degrees(study.planes.separate["pitch"])
    assert numbers["planes.heading_deg"] == pytest.approx(225.0)
    assert numbers["verdict.required_deg"] == np.degrees(study.required_deflection)
    words = "The verdict is on both planes." if stop else "The verdict is on the pitch plane alone."
    assert words in Page(html).text
    assert ("in both planes with one stop" in html) is (stop is not None)


@pytest.mark.thorough
def test_a_wind_without_a_direction_has_no_such_section() -> None:
    plain = {key: value for key, value in WIND.items() if key in ("peak_deg", "duration_s")}
    head = {"vehicle": "configuration-i", "model": "fixed-path"}
    html = tv.report_html(parse_study({"study": head, "wind": plain}))
    assert 'id="planes"' not in html


@pytest.mark.thorough
def test_a_vehicle_without_a_name_has_that_of_its_file_in_the_title(tmp_path):
    file = tmp_path / "own.toml"
    text = vehicle_file(tv.load_vehicle("configuration-i").replace(name=""))
    file.write_text(text, encoding="utf-8")
    page = tmp_path / "page.html"
    assert CliRunner().invoke(app, ["report", str(file), "-o", str(page)]).exit_code == 0
    assert "<title>own.toml: deflection study" in page.read_text(encoding="utf-8")
