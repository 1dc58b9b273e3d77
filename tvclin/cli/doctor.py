"""`tvclin doctor`: installed versions, and the purpose of each extra."""

import re
import sys
from importlib import metadata
from typing import Any

from tvclin.cli.options import AsJson
from tvclin.cli.output import say

ADDS = {
    "slycot": "more routines of python-control",
    "fast": "compiled kernels: thousands of cases in a second",
    "campaign": "many dispersed cases, tvclin disperse",
    "sixdof": "flights with six degrees of freedom, tvclin fly --engine sixdof",
    "report": "one page to hand over, tvclin report",
    "notebook": "a page to explore, tvclin explore",
}


def doctor(as_json: AsJson = False) -> None:
    """Print versions, and which extras are installed."""
    from tvclin.base.errors import install
    from tvclin.base.lines import words
    from tvclin.cli.output import print_json, print_tables

    packages, extras = _requirements()
    versions = {name: _version(name) for name in packages}
    installed = {extra: {name: _version(name) for name in names} for extra, names in extras.items()}
    python = {"tvclin": _version("tvclin"), "python": sys.version.split()[0]}
    if as_json:
        print_json({"versions": python | versions, "extras": installed})
        return
    rows = [[name, version or "missing"] for name, version in (python | versions).items()]
    extra_rows = []
    for extra, of_extra in installed.items():
        names = ", ".join(f"{name} {version or 'missing'}" for name, version in of_extra.items())
        extra_rows.append([f"{extra}: {ADDS.get(extra, '')}", names])
    print_tables(
        words("Versions", ["package", "version"], rows),
        words("Extras", ["extra: what it adds", "packages"], extra_rows),
    )
    wanting = [extra for extra, names in installed.items() if None in names.values()]
    if wanting:
        say(f"To add what is missing: {install(*wanting)}")


def _requirements() -> tuple[list[str], dict[str, list[str]]]:
    """Return the required packages, and the packages of each extra, from the installed metadata.

    A requirement begins with the name of its package, and ends with its extra if it has one; the
    extra "all", of all others, is left out.
    """
    packages: list[str] = []
    extras: dict[str, list[str]] = {}
    for requirement in metadata.requires("tvclin") or []:
        name = re.split(r"[^\w.-]", requirement, maxsplit=1)[0]
        extra: Any = re.search(r"extra == ['\"]([\w-]+)['\"]", requirement)
        if extra is None:
            packages.append(name)
        elif extra[1] != "all":
            extras.setdefault(extra[1], []).append(name)
    return packages, extras


def _version(name: str) -> str | None:
    """Return the version of an installed package; None if it is missing."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
