"""Public names of the package and its chapters, which are loaded on first use."""

import sys
from collections.abc import Callable, Iterable
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import lazy_loader  # type: ignore[import-untyped]

GUESSES = {
    "tf": 'Plant.tf("attitude", "deflection")',
    "transfer_function": 'Plant.tf("attitude", "deflection")',
    "TransferFunction": 'Plant.tf("attitude", "deflection")',
    "ss": "Plant.ss()",
    "state_space": "Plant.ss()",
    "StateSpace": "Plant.ss()",
    "poles": "Plant.poles or tvclin.unstable_modes",
    "zeros": "Plant.numerator or Plant.tf(...).zeros()",
    "margin": "Autopilot.margins or tvclin.Loop",
    "margins": "Autopilot.margins or tvclin.Loop",
    "stability_margins": "Autopilot.margins or tvclin.Loop",
    "step_response": "control.step_response(Plant.ss()) or tvclin.plots.step_chart",
    "forced_response": "tvclin.attitude_response or control.forced_response(Plant.ss(), ...)",
    "bode": "tvclin.plots.bode_chart",
    "bode_plot": "tvclin.plots.bode_chart",
    "nyquist_plot": "tvclin.plots.nyquist_chart",
    "nichols_plot": "tvclin.plots.nichols_chart",
    "root_locus": "tvclin.plots.root_locus_chart",
    "lqr": "tvclin.control.lqr_gains",
    "residue": "tvclin.residues",
    "savefig": "tvclin.plots.save_figure(plot, path)",
}
"""Public names for those that users of python-control and matplotlib try first."""

CHAPTERS = (
    "vehicle",
    "winds",
    "linear",
    "ascent",
    "boundary",
    "control",
    "flights",
    "case",
    "requirement",
    "nozzle",
    "ensembles",
    "design",
    "studyfile",
    "plots",
)


def public_names(
    package: str, file: str
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a module `package`, lazily loaded.

    `file`: path of the module, whose stub (.pyi) lists the names. The message on a missing name
    proposes the public name that is meant, or its chapter.
    """
    load, all_names, names = lazy_loader.attach_stub(package, file)

    def get(name: str) -> Any:
        """Return the public `name`, loaded on first use; `AttributeError` if there is none."""
        if name in names:
            return load(name)
        if name.startswith("_") or find_spec(f"{package}.{name}"):  # a file, about to be imported
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        raise AttributeError(_missing(package, name), name=name, obj=sys.modules[package])

    def listed() -> list[str]:
        """Return the public names; none to `inspect`: pydoc would print the help of each."""
        caller = sys._getframe(1).f_globals.get("__name__", "")
        return [] if caller == "inspect" else all_names()

    return get, listed, [name for name in names if name not in CHAPTERS]


class Hinted:
    """A record whose missing attributes are answered with the public name that is meant."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Raise `AttributeError` on a missing `name`, with the public name that is meant."""
            kind = type(self)
            raise AttributeError(_hint(kind.__name__, name, dir(kind)), name=name, obj=self)


def _hint(kind: str, name: str, attributes: Iterable[str]) -> str:
    """Return the message that a class `kind` lacks `name`, with the public name that is meant.

    That is a name of the package, if it was written in lower case; one that users of other packages
    try first (`GUESSES`); or the most similar of `attributes`.
    """
    if name.startswith("_"):
        return f"{kind!r} object has no attribute {name!r}"
    from difflib import get_close_matches  # late: seldom needed

    public = {key.lower(): f"tvclin.{key}" for key in import_module("tvclin").__all__}
    candidates = [attribute for attribute in attributes if not attribute.startswith("_")]
    similar = get_close_matches(name, candidates, 1, 0.7)
    meant = public.get(name) or GUESSES.get(name) or (f"{kind}.{similar[0]}" if similar else "")
    return f"{kind} has no {name}" + (f": do you mean {meant}?" if meant else "")


def _missing(package: str, name: str) -> str:
    """Return the message that a `package` has no public `name`: a similar name, and its chapter.

    Names that users of other packages try first have an answer in `GUESSES`.
    """
    from difflib import get_close_matches  # late: seldom needed

    if name in GUESSES:
        return f"{package} has no {name}: do you mean {GUESSES[name]}?"
    modules: dict[str, str] = {}
    for module in ("tvclin", *(f"tvclin.{chapter}" for chapter in CHAPTERS)):
        for public in import_module(module).__all__:
            modules.setdefault(public, module)
    similar = [name] if name in modules else get_close_matches(name, modules, n=2, cutoff=0.7)
    meant = " or ".join(f"{modules[public]}.{public}" for public in similar)
    return f"{package} has no {name}" + (f": do you mean {meant}?" if similar else "")
