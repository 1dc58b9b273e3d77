"""The doors of the package and its chapters: names that are loaded when they are first used."""

import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import lazy_loader  # type: ignore[import-untyped]

CHAPTERS = ("vehicle", "winds", "linear", "boundary", "control", "flights", "answers", "plots")


def door(
    package: str, file: str
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` for the stub beside a file.

    A name that the door has not is answered with the one that is meant, or with its own door.
    """
    found, listed, names = lazy_loader.attach_stub(package, file)

    def get(name: str) -> Any:
        if name in names:
            return found(name)
        if name.startswith("_") or find_spec(f"{package}.{name}"):  # a file, about to be imported
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        raise AttributeError(_missing(package, name), name=name, obj=sys.modules[package])

    return get, listed, [name for name in names if name not in CHAPTERS]


def _missing(package: str, name: str) -> str:
    """A sentence for a name that a door has not: who has it, or what looks like it."""
    from difflib import get_close_matches  # late: seldom needed

    doors = ("tvclin", *(f"tvclin.{one}" for one in CHAPTERS))
    places: dict[str, str] = {}
    for one in doors:
        for public in import_module(one).__all__:
            places.setdefault(public, one)
    near = [name] if name in places else get_close_matches(name, places, n=2, cutoff=0.7)
    meant = " or ".join(f"{places[one]}.{one}" for one in near)
    return f"{package} has no {name}" + (f": do you mean {meant}?" if near else "")
