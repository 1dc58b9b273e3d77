"""A notebook with the panel, and JupyterLab on it, which runs it and which it can end."""

import json
import os
import signal
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

_WORDS = """\
**How much deflection must this booster have?** Change any value: figure, margins and verdict
follow."""
_SERVER = "TVCLIN_EXPLORE"
"""Environment variable of the kernels with the process that `end` ends."""
_SETTINGS = {
    "LabApp.extra_labextensions_path": str(Path(__file__).with_name("labextensions")),
    "ServerApp.answer_yes": "True",  # one Ctrl-C ends it
}
_ENDS_WITH_PAGE = {
    "MappingKernelManager.cull_idle_timeout": "60",  # a kernel that no page looks at
    "MappingKernelManager.cull_interval": "20",
    "ServerApp.shutdown_no_activity_timeout": "60",  # then the server
}
"""Settings of a server that opened its page itself: it ends minutes after that closes [s]."""


def notebook_text(source: str, time: float | None = None) -> str:
    """Return the text of a notebook (.ipynb) that explores a vehicle or a study file.

    With a time of flight [s] the source is a flight schedule.

    One cell says what to do, and one shows the panel.
    """
    opened = repr(source) if time is None else f"tv.load_schedule({source!r}).at({time!r})"
    code = f"import tvclin as tv\n\ntv.explore({opened})"
    cells = [
        {"cell_type": "markdown", "id": "words", "metadata": {}, "source": _WORDS},
        {
            "cell_type": "code",
            "id": "panel",
            "metadata": {},
            "source": code,
            "execution_count": None,
            "outputs": [],
        },
    ]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    document = {
        "cells": cells,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(document, indent=1) + "\n"


def open_notebook(path: Path, options: Sequence[str]) -> None:
    """Open a notebook in JupyterLab, in this process until it ends, and run the cells.

    `path`: file of the notebook. JupyterLab prints the addresses of the notebook; `options` of
    JupyterLab override the settings of this file. `SystemExit` where it cannot start.
    """
    from jupyterlab.labapp import LabApp

    os.environ[_SERVER] = str(os.getpid())  # the process that the notebook's `end` ends
    settings = _SETTINGS | {"LabApp.default_url": f"/lab/tree/{quote(path.name)}"}
    # with a browser the server ends by itself, minutes after its page is closed
    settings |= {} if "--no-browser" in options else _ENDS_WITH_PAGE
    options_of_settings = [
        f"--{name}={value}"
        for name, value in settings.items()
        if not any(option.startswith(f"--{name}") for option in options)
    ]
    LabApp.launch_instance([str(path), *options_of_settings, *options])


def is_open() -> bool:
    """Return whether this is the kernel of a notebook that `open_notebook` has opened."""
    return _SERVER in os.environ


def end() -> None:
    """End the JupyterLab of this notebook, with all its kernels."""
    os.kill(int(os.environ[_SERVER]), signal.SIGTERM)
