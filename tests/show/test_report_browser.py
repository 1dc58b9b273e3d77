"""The page in a browser: nothing overflows, every figure is seen, and the print cuts none."""

import base64
import re
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

import tvclin as tv
from tvclin.studyfile.parse import parse_study
from tvclin.studyfile.read import example

pytest.importorskip("jinja2")
pytest.importorskip("latex2mathml")
webdriver = pytest.importorskip("selenium.webdriver", reason="selenium drives the browser")

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
DRIVER = shutil.which("chromedriver")
pytestmark = [
    pytest.mark.thorough,
    pytest.mark.skipif(
        BROWSER is None or DRIVER is None,
        reason="no browser: apt-get install chromium chromium-driver",
    ),
]

WIDTHS = (390, 1024, 1440)
SCHEMES = ("light", "dark")
A4 = (180.0 / 25.4 * 96.0, 265.0 / 25.4 * 96.0)
"""What the margins leave of a page of A4, in CSS pixels."""
READABLE = 4.5
"""Contrast of text that WCAG 2 asks for at level AA."""

_FIGURES = """return [...document.querySelectorAll('figure svg')].map(svg => {
  const box = svg.getBoundingClientRect();
  const drawn = [...svg.querySelectorAll('path')].filter(path => path.getBBox().width > 0);
  return [box.left, box.right, box.width, box.height, drawn.length];
});"""
_BROKEN = """return [...document.querySelectorAll('a[href^="#"], use')].filter(one => {
  const target = one.getAttribute('href') || one.getAttribute('xlink:href');
  return !document.getElementById(target.slice(1));
}).length;"""
_COLOURS = """const paper = one => {
  for (; one; one = one.parentElement) {
    const color = getComputedStyle(one).backgroundColor;
    if (color !== 'rgba(0, 0, 0, 0)') return color;
  }
  return 'rgb(255, 255, 255)';
};
const texts = 'h1, h2, p, a, dt, dd, th, td, caption, figcaption, li, .mark';
return [...document.querySelectorAll(texts)].map(one =>
  [one.textContent.slice(0, 30), getComputedStyle(one).color, paper(one)]);"""
_LINES = """return [...document.querySelectorAll('figure svg path')]
  .map(path => getComputedStyle(path).stroke).filter(colour => colour.startsWith('rgb('));"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Open the example's page, with fewer laws and cases, in a browser without a window."""
    whole = parse_study(tomllib.loads(example()))
    laws = tv.design.LawsRequest(
        names=("trim",), winds=("triangle", "1 - cosine"), sample_rate=20.0
    )
    page = tmp_path_factory.mktemp("page") / "report.html"
    page.write_text(tv.report_html(replace(whole, laws=laws, cases=200)), encoding="utf-8")
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for one in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(one)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        driver.get(page.as_uri())
        yield driver
    finally:
        driver.quit()


def look(browser: Any, width: float, scheme: str = "light", media: str = "screen") -> None:
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media, "features": [feature]})
    size = {"width": round(width), "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


def luminance(colour: str) -> float:
    parts = [float(match) / 255.0 for match in re.findall(r"[\d.]+", colour)[:3]]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_the_browser_has_nothing_to_complain_of(browser: Any) -> None:
    assert browser.get_log("browser") == []
    assert browser.execute_script(_BROKEN) == 0


@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_overflows_and_every_figure_is_seen(browser: Any, width: int) -> None:
    look(browser, width)
    figures = browser.execute_script(_FIGURES)

    wide, seen = browser.execute_script(
        "const page = document.documentElement; return [page.scrollWidth, page.clientWidth]"
    )
    assert wide == seen <= width
    assert len(figures) == 8
    for left, right, wide, high, drawn in figures:
        assert 0 <= left < right <= width
        assert wide > 0.55 * min(width, 800)
        assert high > 0.2 * wide  # the vehicle is long
        assert drawn > 20


def test_the_table_of_questions_fits_a_window_of_800_pixels(browser: Any) -> None:
    look(browser, 800)
    result = "const table = document.querySelector('#questions .table');"
    whole, seen = browser.execute_script(f"{result} return [table.scrollWidth, table.clientWidth]")
    assert whole == seen


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_text_stands_out_from_its_paper(browser: Any, scheme: str) -> None:
    look(browser, 1280, scheme)
    result = browser.execute_script(_COLOURS)

    assert len(result) > 100
    assert (luminance(result[0][2]) < 0.2) is (scheme == "dark")
    assert [one for one in result if contrast(*one[1:]) < READABLE] == []


def test_no_line_of_a_figure_is_lost_in_the_dark(browser: Any) -> None:
    look(browser, 1280, "dark")
    paper = browser.execute_script("return getComputedStyle(document.body).backgroundColor")

    assert [one for one in browser.execute_script(_LINES) if contrast(one, paper) < 1.15] == []


def test_the_print_is_on_paper_and_cuts_no_figure(browser: Any) -> None:
    look(browser, A4[0], "dark", media="print")
    sizes = browser.execute_script(
        "return [...document.querySelectorAll('figure')].map(one =>"
        " [one.getBoundingClientRect().height, getComputedStyle(one).breakInside])"
    )
    paper = browser.execute_script("return getComputedStyle(document.body).backgroundColor")
    options = {"preferCSSPageSize": True, "printBackground": True}
    pdf = base64.b64decode(browser.execute_cdp_cmd("Page.printToPDF", options)["data"])

    assert all(height < A4[1] and rule == "avoid" for height, rule in sizes)
    assert paper == "rgb(255, 255, 255)"
    assert pdf.startswith(b"%PDF")
    pages = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    assert 5 <= len(pages) <= 14
    for wide, high in pages:
        assert (float(wide), float(high)) == pytest.approx((595.3, 841.9), abs=1.0)
