"""`tvclin explore` in a browser, from its opening to its end, and the ends without a browser."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from time import monotonic, sleep
from typing import Any
from urllib.request import Request, urlopen

import pytest

import tvclin as tv

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium drives the browser")

from selenium.common.exceptions import WebDriverException  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    None in map(find_spec, ("jupyterlab", "ipywidgets", "ipykernel")),
    reason='no JupyterLab: pip install "tvclin[notebook]"',
)
needs_a_browser = pytest.mark.skipif(
    BROWSER is None or DRIVER is None,
    reason="no browser: apt-get install chromium chromium-driver",
)

LONGEST_WAIT = 600.0
"""Seconds, for what never comes; on a quiet machine each step takes a few."""
_SEEN = """const out = '.jp-OutputArea ', all = what => [...document.querySelectorAll(out + what)];
const image = document.querySelector(out + 'img.widget-image');
const texts = all('.widget-label, .widget-readout, button').filter(one => one.offsetParent);
const shown = [...texts, ...all('select, .noUi-handle, img').filter(one => one.offsetParent)];
return {src: image ? image.src : '', width: image ? image.getBoundingClientRect().width : 0,
  text: all('.widget-html').map(one => one.innerText),
  sliders: all('.noUi-handle').length, buttons: all('button').map(one => one.innerText),
  greyed: all('.widget-slider').filter(one => one.querySelector('[disabled]'))
    .map(one => one.querySelector('.widget-label').innerText),
  clipped: texts.filter(one => one.scrollWidth > one.clientWidth)
    .map(one => one.className + one.innerText),
  outside: shown.filter(one => one.getBoundingClientRect().right > window.innerWidth)
    .map(one => one.className + one.innerText),
  sideways: [...document.querySelectorAll('.jp-WindowedPanel-outer, .jp-OutputArea-output')]
    .filter(one => one.scrollWidth > one.clientWidth).map(one => one.className)};"""


class Started:
    """`tvclin explore --no-browser` in a folder, with no settings but its own."""

    def __init__(self, folder: Path, terminal: int | None = None) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        places = ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")
        places += ("JUPYTERLAB_SETTINGS_DIR", "JUPYTERLAB_WORKSPACES_DIR")
        own = {name: str(folder / ".own" / name) for name in places}
        options = ["--allow-root", "--ip=127.0.0.1", f"--port={port}", "--LabApp.news_url="]
        options += ["--IdentityProvider.token=", "--ServerApp.port_retries=0"]
        options += ["--ServerApp.disable_check_xsrf=True"]
        options += ["--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate"]
        self.address, self.folder = f"http://127.0.0.1:{port}", folder
        self._log = (folder / "log").open("w")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tvclin", "explore", "--no-browser", "--", *options],
            cwd=folder,
            env=os.environ | own | {"PYTHONPATH": str(Path(tv.__file__).parents[1])},
            stdin=terminal,
            stdout=self._log,
            stderr=self._log,
        )

    def answers(self) -> bool:
        try:
            with urlopen(f"{self.address}/api", timeout=5.0) as result:
                return bool(result.status == 200)
        except OSError:
            return False

    def printed(self) -> str:
        """Return the address that it prints; empty until it has."""
        result = re.search(rf"{self.address}/\S+", (self.folder / "log").read_text())
        return "" if result is None else result[0]

    def kernels(self) -> list[Any]:
        psutil = pytest.importorskip("psutil")  # comes with ipykernel
        return list(psutil.Process(self.process.pid).children(recursive=True))

    def stop(self) -> None:
        self.process.kill()
        self.process.wait(LONGEST_WAIT)
        self._log.close()


@pytest.fixture
def started(tmp_path: Path) -> Iterator[Started]:
    one = Started(tmp_path)
    try:
        yield one
    finally:
        one.stop()


@pytest.fixture
def in_a_terminal(tmp_path: Path) -> Iterator[Started]:
    pty = pytest.importorskip("pty", reason="Windows has no such terminals and signals")
    ours, theirs = pty.openpty()
    one = Started(tmp_path, theirs)
    try:
        yield one
    finally:
        one.stop()
        os.close(ours)
        os.close(theirs)


@pytest.fixture
def browser() -> Iterator[Any]:
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for one in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(one)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        wide(driver, 1024, 768)
        yield driver
    finally:
        driver.quit()


def wide(browser: Any, width: int, height: int) -> None:
    """Set the size of the page, without what a window adds."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


def gone(kernels: list[Any]) -> bool:
    return not any(kernel.is_running() and kernel.status() != "zombie" for kernel in kernels)


@pytest.mark.thorough
@needs_a_browser
def test_the_panel_from_its_opening_to_its_end(started: Started, browser: Any) -> None:
    def until(what: Any) -> Any:
        return WebDriverWait(browser, LONGEST_WAIT, 0.2, [WebDriverException]).until(what)

    def seen() -> Any:
        return browser.execute_script(_SEEN)

    def click(button: str) -> None:
        path = f"//button[normalize-space()='{button}']"
        until(lambda one: one.find_element(By.XPATH, path).click() is None)

    until(lambda _: started.answers())
    until(lambda _: started.printed())
    browser.get(started.printed())
    until(lambda _: any("requires 0.412 deg" in text for text in seen()["text"]))  # by itself
    first = seen()
    assert first["text"][0].startswith(
        "NOT SUFFICIENT: with K = 1 the ideal trim law requires 0.412 deg"
    )
    assert first["sliders"] == 14
    gains = ["gain a0 [-]", "gain a1 [s]", "gain b0 [-]"]
    assert first["greyed"] == ["gust length [s]", "wind from [deg]", *gains]
    assert first["buttons"] == ["write study file", "End"]

    for width, height, minimum in ((1024, 768, 450), (1440, 900, 700)):
        wide(browser, width, height)
        until(lambda _, minimum=minimum: seen()["width"] > minimum)
        page = seen()
        assert (page["clipped"], page["outside"], page["sideways"]) == ([], [], [])

    click("write study file")
    until(lambda _: any(text.startswith("Wrote ") for text in seen()["text"]))
    study = tv.load_study(started.folder / "study-configuration-i.toml")
    assert study.wind.duration == 7.5

    handle = browser.find_element(By.CSS_SELECTOR, ".jp-OutputArea .noUi-handle")
    until(lambda _: handle.send_keys(Keys.PAGE_UP) is None)
    until(lambda _: "trim law requires 0.412 deg" not in seen()["text"][0])
    assert seen()["src"] != first["src"]

    kernels = started.kernels()
    click("End")
    assert started.process.wait(LONGEST_WAIT) == 0
    assert kernels
    assert gone(kernels)


@pytest.mark.thorough
@pytest.mark.parametrize("ended", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_jupyterlab_and_its_kernels(
    in_a_terminal: Started, ended: signal.Signals
) -> None:
    started, begun = in_a_terminal, monotonic()
    while not started.answers():
        assert monotonic() - begun < LONGEST_WAIT
        sleep(0.1)
    request = Request(f"{started.address}/api/kernels", data=b"{}", method="POST")
    urlopen(request, timeout=LONGEST_WAIT)
    kernels = started.kernels()
    started.process.send_signal(ended)

    assert started.process.wait(LONGEST_WAIT) == 0
    assert kernels
    assert gone(kernels)
