"""The page: its sections, rendered by the template."""

from collections.abc import Callable
from dataclasses import asdict
from importlib.resources import files
from os import PathLike
from typing import TYPE_CHECKING

from tvclin.base.errors import missing
from tvclin.base.lines import Formula, Number
from tvclin.requirement.study import Study
from tvclin.show.report import basis, control, flexible, flight, rests, sections, verdict
from tvclin.show.report.blocks import Section
from tvclin.studyfile.findings import Findings, Told, find
from tvclin.studyfile.questions import sufficient
from tvclin.studyfile.read import load_study
from tvclin.studyfile.study_plan import StudyPlan

if TYPE_CHECKING:
    from jinja2 import Template

SECTIONS: tuple[Callable[[Findings], Section | None], ...] = (
    sections.vehicle,
    verdict.asked,
    sections.boundaries,
    sections.both_planes,
    sections.response,
    sections.load,
    flight.over_flight,
    flight.availability,
    control.laws,
    control.autopilot,
    flexible.flexible,
    control.dispersed,
    sections.inputs,
    basis.assumptions,
    basis.equations,
    basis.origin,
)
"""The sections in their order; one that was not requested is None and omitted."""


def report_html(source: Study | StudyPlan | str | PathLike[str]) -> str:
    """Return the whole answer as one self-contained HTML page.

    Parameters
    ----------
    source : Study, StudyPlan, str or path
        A study, a plan, or what `load_study` makes a plan of.

    Returns
    -------
    str
        The page: no script, nothing from the network, the same text for the same inputs and
        versions.

    Raises
    ------
    InputError
        Where jinja2 or latex2mathml is missing, and as `load_study` and `StudyPlan.study`.

    Examples
    --------
    >>> import tvclin as tv
    >>> page = tv.report_html("configuration-i")
    >>> page.count("<h1"), page.count("<script")
    (1, 0)
    """
    if isinstance(source, Study):
        plan = StudyPlan.of_study(source)
    else:
        plan = source if isinstance(source, StudyPlan) else load_study(source)
    return page_of(plan)[0]


def page_of(plan: StudyPlan, progress: Told | None = None) -> tuple[str, Findings]:
    """Return the page of a plan, and its findings; same exceptions as `report_html`."""
    template = _template()
    findings = find(plan, progress)
    return _render(findings, template), findings


def _render(findings: Findings, template: "Template") -> str:
    made = [section for make in SECTIONS if (section := make(findings)) is not None]
    assumed = rests.rests(findings)
    fields = {} if findings.plan.document is None else asdict(findings.plan.document)
    return template.render(
        document={name: value for name, value in fields.items() if value},
        name=findings.study.vehicle.name or "unnamed vehicle",
        state={True: "yes", False: "no", None: "open"}[sufficient(findings)],
        verdict=verdict.sentence(findings),
        basis=verdict.basis(findings),
        facts=verdict.facts(findings),
        rests=assumed,
        doubts=rests.doubts_counted(assumed, made),
        sections=[*made, basis.glossary(made)],
        seal=findings.seal,
    )


def _template() -> "Template":
    try:
        from jinja2 import Environment, PackageLoader, StrictUndefined
        from latex2mathml.converter import convert
    except ImportError as error:
        name = (error.name or "jinja2").partition(".")[0]
        raise missing(f"the page needs {name}", "report") from None
    environment = Environment(
        loader=PackageLoader("tvclin.show.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_printable,
    )
    environment.globals["style"] = (
        files("tvclin.show.report").joinpath("style.css").read_text("utf-8")
    )
    environment.tests["number"] = lambda value: isinstance(value, Number)
    environment.tests["formula"] = lambda value: isinstance(value, Formula)
    environment.filters["mathml"] = convert
    return environment.get_template("page.html")


def _printable(value: object) -> object:
    """Return a text with each character that HTML cannot hold replaced, such as a control code."""
    if not isinstance(value, str) or all(line.isprintable() for line in value.split("\n")):
        return value
    printable = "".join(
        character if character.isprintable() or character in "\n\t" else "\ufffd"
        for character in value
    )
    return type(value)(printable)
