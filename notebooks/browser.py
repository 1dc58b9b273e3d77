"""A site whose notebooks and panel run in the reader's own browser, with JupyterLite: `make site`.

It holds the wheels of this package and of what it needs in pure Python. The interpreter with numpy,
scipy and matplotlib is Pyodide's: the browser loads it from where JupyterLite's settings say.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent
SITE = FOLDER.parent / "docs" / "_build" / "browser"
CHOSEN = ("01", "02", "03", "04", "10", "14")
"""What needs no threads, processes or extras, and no minutes without a compiler."""
PURE = ("control", "lazy-loader", "typer")
"""What the package needs and Pyodide does not have."""
PANEL = "import tvclin\n\ntvclin.explore('configuration-i')"


def contents() -> dict[str, str]:
    """Return the notebooks of the site by name, with a first cell that installs the package."""
    files = [one for number in CHOSEN for one in FOLDER.glob(f"{number}_*.ipynb")]
    read = {one.name: json.loads(one.read_text(encoding="utf-8")) for one in sorted(files)}
    panel = {name: value for name, value in next(iter(read.values())).items() if name != "cells"}
    read["panel.ipynb"] = panel | {"cells": [_cell("panel", PANEL)]}
    for notebook in read.values():
        notebook["cells"].insert(0, _cell("install", "%pip install -q tvclin ipywidgets"))
    return {name: json.dumps(notebook, indent=1) for name, notebook in read.items()}


def _cell(name: str, source: str) -> dict[str, Any]:
    empty: dict[str, Any] = {"execution_count": None, "metadata": {}, "outputs": []}
    return {"cell_type": "code", "id": name, "source": source} | empty


def main() -> None:
    """Build the site."""
    with tempfile.TemporaryDirectory() as place:
        pages, wheels = Path(place) / "contents", Path(place) / "wheels"
        pages.mkdir()
        for name, text in contents().items():
            (pages / name).write_text(text, encoding="utf-8")
        pip = (sys.executable, "-m", "pip")
        subprocess.run([*pip, "wheel", "-q", "--no-deps", "-w", wheels, FOLDER.parent], check=True)
        subprocess.run([*pip, "download", "-q", "--no-deps", "-d", wheels, *PURE], check=True)
        given = [word for one in wheels.iterdir() for word in ("--piplite-wheels", str(one))]
        build = [sys.executable, "-m", "jupyter", "lite", "build", "--lite-dir", place]
        subprocess.run(
            [*build, "--contents", pages, "--output-dir", SITE, *given], check=True, cwd=place
        )


if __name__ == "__main__":
    main()
