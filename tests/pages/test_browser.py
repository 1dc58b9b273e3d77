"""What the site of `make site` shows runs in a process as poor as an interpreter in a browser."""

import json
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
POOR = """
import doctest, multiprocessing, os, runpy, subprocess, sys, threading
import matplotlib
matplotlib.use("agg")
def refuse(*given, **options): raise OSError("there is no such thing in a browser")
for name in ("numba", "slycot", "pyarrow", "distributed", "jsbsim", "jinja2", "latex2mathml"):
    sys.modules[name] = None
threading.Thread.start = multiprocessing.Process.start = subprocess.Popen.__init__ = refuse
os.fork = refuse
for one in sys.argv[1:]:
    if one.endswith(".md"):
        flags = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
        assert not doctest.testfile(one, module_relative=False, optionflags=flags).failed
    elif one.endswith(".py"):
        runpy.run_path(one)
    else:
        exec(one)
"""


@pytest.fixture
def browser(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(ROOT / "notebooks")
    return import_module("browser")


def run_poorly(folder: Path, *what: str) -> None:
    command = [sys.executable, "-c", POOR, *what]
    path = {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env=os.environ | path
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]


@pytest.mark.thorough
def test_pages_run_without_threads_processes_compiler_and_extras(tmp_path: Path) -> None:
    run_poorly(tmp_path, *(str(ROOT / name) for name in ("README.md", "docs/start.md")))


@pytest.mark.thorough
def test_the_panel_runs_without_threads_processes_compiler_and_extras(browser, tmp_path) -> None:
    pytest.importorskip("ipywidgets")
    run_poorly(tmp_path, browser.PANEL)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "number",
    [
        "02",
        *(pytest.param(one, marks=pytest.mark.thorough) for one in ("01", "03", "04", "10", "14")),
    ],
)
def test_notebooks_of_the_site_run_without_threads_processes_compiler_and_extras(
    number: str, tmp_path: Path
) -> None:
    (source,) = (ROOT / "notebooks").glob(f"{number}_*.py")
    run_poorly(tmp_path, str(source))


def test_each_notebook_of_the_site_installs_the_package_first(browser) -> None:
    computed = {name: json.loads(text)["cells"] for name, text in browser.contents().items()}

    assert len(computed) == len(browser.CHOSEN) + 1
    for cells in computed.values():
        assert cells[0]["source"] == "%pip install -q tvclin ipywidgets"
        assert len(cells) > 1
