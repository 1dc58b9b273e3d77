"""JupyterLab on one notebook, which it runs when it opens, and which can end it."""

import os
import signal
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

_SERVER = "TVCLIN_EXPLORE"
"""In the environment of the kernels: the process that `end` ends."""
_SETTINGS = {
    "LabApp.extra_labextensions_path": str(Path(__file__).with_name("labextensions")),
    "ServerApp.answer_yes": "True",  # one Ctrl-C ends it
}
_WATCHED = {
    "MappingKernelManager.cull_idle_timeout": "60",  # a kernel that no page looks at
    "MappingKernelManager.cull_interval": "20",
    "ServerApp.shutdown_no_activity_timeout": "60",  # then the server
}
"""Of a server that has opened its page itself: it ends some minutes after that is closed [s]."""


def open_notebook(path: Path, options: Sequence[str]) -> None:
    """Open a notebook in JupyterLab, in this process, until that is ended.

    The addresses that JupyterLab prints are those of the notebook.

    Parameters
    ----------
    path : Path
        The notebook; all its cells are run.
    options : sequence of str
        Of JupyterLab; they go before those of this file.

    Raises
    ------
    SystemExit
        Where JupyterLab cannot start.
    """
    from jupyterlab.labapp import LabApp

    os.environ[_SERVER] = str(os.getpid())
    settings = _SETTINGS | {"LabApp.default_url": f"/lab/tree/{quote(path.name)}"}
    settings |= {} if "--no-browser" in options else _WATCHED
    ours = [
        f"--{name}={value}"
        for name, value in settings.items()
        if not any(option.startswith(f"--{name}") for option in options)
    ]
    LabApp.launch_instance([str(path), *ours, *options])


def is_open() -> bool:
    """Whether this is the kernel of a notebook that `open_notebook` has opened."""
    return _SERVER in os.environ


def end() -> None:
    """End the JupyterLab of this notebook, with all its kernels."""
    os.kill(int(os.environ[_SERVER]), signal.SIGTERM)
