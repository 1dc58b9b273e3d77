"""The panel in JupyterLab in a browser: the cell is run, a slider is moved, the answer follows."""

import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest

from tvclin.show.explorer.notebook import notebook_text

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium drives the browser")

from selenium.common.exceptions import WebDriverException  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
DRIVER = shutil.which("chromedriver")
pytestmark = [
    pytest.mark.skipif(
        None in map(find_spec, ("jupyterlab", "ipywidgets", "ipykernel")),
        reason='no JupyterLab: pip install "tvclin[notebook]"',
    ),
    pytest.mark.skipif(
        BROWSER is None or DRIVER is None,
        reason="no browser: apt-get install chromium chromium-driver",
    ),
]

LONGEST_WAIT = 90.0
"""Seconds; on a quiet machine each step takes a few."""
_SEEN = """const seen = one => one ? one.getBoundingClientRect() : {width: 0, height: 0};
const image = document.querySelector('.jp-OutputArea img.widget-image');
const box = seen(image), sliders = [...document.querySelectorAll('.jp-OutputArea .noUi-handle')];
return {src: image ? image.src : '', width: box.width, right: box.right, sliders: sliders.length,
  text: [...document.querySelectorAll('.jp-OutputArea .widget-html')].map(o => o.innerText),
  labels: [...document.querySelectorAll('.jp-OutputArea .widget-label')]
    .filter(o => o.offsetParent && o.scrollWidth > o.clientWidth).map(o => o.innerText)};"""


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """Start JupyterLab on a notebook, with no settings but its own, and give its address."""
    (tmp_path / "explore.ipynb").write_text(notebook_text("configuration-i"), encoding="utf-8")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    places = ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")
    places += ("JUPYTERLAB_SETTINGS_DIR", "JUPYTERLAB_WORKSPACES_DIR")
    own = {name: str(tmp_path / ".own" / name) for name in places}
    options = ["--no-browser", "--allow-root", "--ip=127.0.0.1", f"--port={port}"]
    options += ["--IdentityProvider.token=", "--ServerApp.port_retries=0"]
    options += [f"--ServerApp.root_dir={tmp_path}", "--LabApp.news_url="]
    options += ["--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate"]
    with (tmp_path / "log").open("w") as log:
        lab = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *options],
            env=os.environ | own,
            stdout=log,
            stderr=log,
        )
        try:
            yield f"http://127.0.0.1:{port}"
        finally:
            lab.terminate()
            lab.wait(30.0)


@pytest.fixture
def browser() -> Iterator[Any]:
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for one in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(one)
    options.add_argument("--window-size=1280,900")
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        yield driver
    finally:
        driver.quit()


def answers(address: str) -> bool:
    try:
        with urlopen(f"{address}/api", timeout=5.0) as found:
            return bool(found.status == 200)
    except OSError:
        return False


def test_the_panel_follows_a_slider_in_the_browser(address: str, browser: Any) -> None:
    def until(what: Any) -> Any:
        return WebDriverWait(browser, LONGEST_WAIT, 0.2, [WebDriverException]).until(what)

    def seen() -> Any:
        return browser.execute_script(_SEEN)

    until(lambda _: answers(address))
    browser.get(f"{address}/lab/tree/explore.ipynb")
    until(lambda one: one.find_elements(By.CSS_SELECTOR, ".jp-CodeCell .cm-content"))
    until(lambda one: "Idle" in one.find_element(By.TAG_NAME, "body").text)
    cell = browser.find_element(By.CSS_SELECTOR, ".jp-CodeCell .cm-content")
    cell.click()
    cell.send_keys(Keys.SHIFT, Keys.ENTER)
    until(lambda _: seen()["width"] > 0 and seen()["text"])
    first = seen()

    assert first["text"][0].startswith("Enough: with K = 1 this wind needs 0.356 deg")
    assert first["labels"] == []
    assert first["sliders"] == 7
    assert first["width"] > 400
    assert first["right"] <= 1280

    handle = browser.find_element(By.CSS_SELECTOR, ".jp-OutputArea .noUi-handle")
    until(lambda _: handle.send_keys(Keys.PAGE_UP) is None)
    until(lambda _: seen()["src"] != first["src"])
    assert not seen()["text"][0].startswith("Enough: with K = 1 this wind needs 0.356 deg")
