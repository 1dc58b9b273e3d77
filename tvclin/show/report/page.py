"""The page: templates rendered with the findings of a study, their tables and notes, and plots.

Figures are inline SVG: reproducible bytes, and colours that a style can change.
"""

import platform
import re
from dataclasses import asdict
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin import plots
from tvclin.base.errors import InputError, imported
from tvclin.base.lines import Formula, Line, Number, Table, as_sentence
from tvclin.case.flexible_autopilot import shift_lines
from tvclin.control.margins.criteria import band_table, margin_table
from tvclin.design import standard_trials as trial_tables
from tvclin.ensembles.availability import availability_record as answer_tables
from tvclin.flights.closed_loop.flown_margins import flown_table
from tvclin.linear.flexible import mode_tables, plant_of
from tvclin.plots.style import figure_bytes
from tvclin.requirement import study_tables
from tvclin.requirement.flight import sizing_tables
from tvclin.requirement.flight.total import total_table
from tvclin.requirement.study import Study
from tvclin.requirement.study_tables import study_response
from tvclin.studyfile import assumptions, autopilot_tables, verdict
from tvclin.studyfile.findings import Findings, Progress, find
from tvclin.studyfile.glossary import equation_table, glossary_table
from tvclin.studyfile.questions import sufficient
from tvclin.studyfile.read import load_study
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.studyfile.verdict import questions_table
from tvclin.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from control import ControlPlot
    from jinja2 import Environment
    from markupsafe import Markup

_PACKAGES = ("tvclin", "numpy", "scipy", "control", "matplotlib")
_NAMES: dict[str, Any] = {
    "plots": plots,
    "study_tables": study_tables,
    "sizing_tables": sizing_tables,
    "trial_tables": trial_tables,
    "availability_tables": answer_tables,
    "autopilot_tables": autopilot_tables,
    **{
        function.__name__: function
        for function in (
            questions_table,
            assumptions.study_warnings,
            assumptions.general_assumptions,
            band_table,
            equation_table,
            flown_table,
            margin_table,
            mode_tables,
            plant_of,
            shift_lines,
            assumptions.loop_notes,
            study_response,
            total_table,
        )
    },
}
"""Figures, tables and notes of answers that the templates place."""
_HEADING = re.compile(r'<h2 id="([a-z]+)-title">(.*?)</h2>')
"""Name and title of a section in HTML."""
_DOUBT = '<li class="doubt">'
"""Begin of a doubtful note in HTML."""


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
    page, _ = page_of(plan)
    return page


def page_of(
    plan: StudyPlan, progress: Progress | None = None, name: str = "unnamed vehicle"
) -> tuple[str, Findings]:
    """Return the page of a plan as HTML, and its findings; `InputError` without jinja2.

    `progress`: called with results done and in total. `name`: title of the page where the vehicle
    has no name, such as that of its file.
    """
    environment = _environment()
    from markupsafe import Markup  # late: with the extra, which the environment needs

    findings = find(plan, progress)
    names = _names(findings)
    sections = environment.get_template("sections.html").render(names)
    # their text, with formulas as plain text, for the glossary
    spaced = re.sub(r'<math [^>]*alttext="([^"]*)".*?</math>', r" \1 ", sections)
    words = Markup(spaced.replace("<", " <")).striptags()
    assumed, doubtful_notes = assumptions.assumptions(findings), sections.count(_DOUBT)
    document = {} if findings.plan.document is None else asdict(findings.plan.document)
    page = environment.get_template("page.html").render(
        names,
        document={key: value for key, value in document.items() if value},
        name=findings.study.vehicle.name or name,
        sufficient=sufficient(findings),
        sentence=verdict.sentence(findings),
        basis=verdict.basis(findings),
        facts=verdict.facts(findings),
        assumed=assumed,
        doubts=assumptions.doubts_counted(assumed, doubtful_notes),
        sections=sections,
        headings=_HEADING.findall(sections),
        glossary=glossary_table(words),
    )
    return page, findings


def _names(findings: Findings) -> dict[str, Any]:
    """Return the names of the template: findings, study, plan and the origin of the study.

    The origin is the table of the seal of the inputs and of the versions of packages.
    """
    rows: list[tuple[Line, ...]] = [(("inputs, SHA-256",), (findings.seal,))]
    rows += [((name,), (version(name),)) for name in _PACKAGES]
    rows.append((("Python",), (platform.python_version(),)))
    origin = Table("Inputs and versions", ("what", "which"), tuple(rows))
    study, plan = findings.study, findings.plan
    return {"findings": findings, "study": study, "plan": plan, "origin": origin}


def _plane_vectors(study: Study) -> "ControlPlot | None":
    """Return the figure of a study's deflections in both planes; None with complex poles."""
    try:
        return plots.study_planes_chart(study)
    except InputError:
        return None


def _environment() -> "Environment":
    """Return the environment of the templates; `InputError` without jinja2 or latex2mathml."""
    for package in ("jinja2", "latex2mathml"):
        imported(package, f"the page needs {package}", "report")
    return _templates()


@cache
def _templates() -> "Environment":
    """Return the environment of the templates, each of which is compiled once.

    Text is escaped, an unknown name is an error, and templates call `show` for the parts of a page.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("tvclin.show.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_printable,
    )
    environment.tests["number"] = lambda value: isinstance(value, Number)
    environment.tests["formula"] = lambda value: isinstance(value, Formula)
    environment.tests["complete"] = lambda value: isinstance(value, Vehicle)
    environment.filters["mathml"] = _mathml
    environment.filters["sentence"] = as_sentence
    environment.globals |= _NAMES
    environment.globals |= {"svg": inline_svg, "plane_vectors": _plane_vectors}
    environment.globals["style"] = files(__package__).joinpath("style.css").read_text("utf-8")
    environment.globals["show"] = environment.get_template("parts.html").module
    return environment


def _mathml(formula: Formula) -> "Markup":
    """Return a formula in MathML, with its plain text as the alternative."""
    from latex2mathml.converter import convert
    from markupsafe import Markup, escape

    return Markup(
        convert(formula.tex).replace("<math ", f'<math alttext="{escape(formula.text)}" ', 1)
    )


def _printable(value: object) -> object:
    """Return a value; in a text each control code, which HTML cannot hold, is replaced."""
    if not isinstance(value, str) or all(line.isprintable() for line in value.split("\n")):
        return value
    printable = "".join(
        character if character.isprintable() or character in "\n\t" else "\ufffd"
        for character in value
    )
    return type(value)(printable)


_WIDTH, _PANEL, _FOOT = 6.4, 1.9, 1.1
"""Sizes [inch]: of a figure, of one panel where there are several, and of the legend."""
_SINGLE_PANEL = 4.2
"""Height of the only panel of a figure [inch]."""
_LINE = 0.21
"""Height of a line of the legend [inch]."""
_COLOUR = re.compile(r"#([0-9a-f]{6})\b")
"""Colour of an SVG."""
_IDENTIFIER = re.compile(r'\b(id="|href="#|url\(#)')
"""Beginning of an identifier in an SVG, or of a reference to it."""


def inline_svg(plot: "ControlPlot", name: str, label: str) -> "Markup":
    """Return the `svg` element of a figure, and close the plot.

    `name`: letters, unique within the page. `label`: description of the figure for screen readers.
    Titles are removed, for the page has a caption, and the legend stands below, so that the letters
    stay large on a narrow screen. Every colour becomes a variable of the page's style sheet with
    the colour itself in reserve, and the figure's name prefixes every name within it.
    """
    import matplotlib.pyplot as plt
    from markupsafe import Markup, escape

    narrow(plot)
    with plt.rc_context({"svg.hashsalt": name, "svg.fonttype": "path"}):
        unmarked = dict.fromkeys(("Creator", "Date", "Format", "Type"))  # the same bytes each time
        drawn = figure_bytes(plot.figure, format="svg", transparent=True, metadata=unmarked)
    plt.close(plot.figure)
    text = drawn.decode()
    body = text[text.index("<svg") :]
    body = _IDENTIFIER.sub(rf"\1{name}-", body)
    body = _COLOUR.sub(r"var(--c\1, #\1)", body)
    opening = re.search(r'viewBox="[^"]+"', body)
    assert opening is not None
    inside = body[body.index(">") + 1 :]
    head = f'<svg role="img" aria-label="{escape(label)}" {opening.group()}'
    return Markup(f'{head} xmlns:xlink="http://www.w3.org/1999/xlink">{inside.strip()}')


def narrow(plot: "ControlPlot") -> None:
    """Give the figure of a plot the width of a page's column, and put one legend below it.

    Titles and minor ticks are removed. The legend has two columns, or one where these are wider
    than the figure.
    """
    figure = plot.figure
    panels = [axes for axes in np.ravel(plot.axes) if axes.axison]
    entries: dict[str, Any] = {}
    for axes in panels:
        axes.minorticks_off()
        handles, labels = axes.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
        if axes.get_legend() is not None:
            axes.get_legend().remove()
        if len(panels) == 1:
            axes.set_title("")
    for legend in figure.legends:
        legend.remove()
    figure.suptitle("")
    if not panels:  # a drawing without axes
        plot.axes.flat[0].set_title("")
        ends = plot.axes.flat[0].get_ylim(), plot.axes.flat[0].get_xlim()
        high, wide = (float(np.ptp(interval)) for interval in ends)
        figure.set_size_inches(_WIDTH, _WIDTH * high / wide)
        return
    height = _SINGLE_PANEL if len(panels) == 1 else _PANEL * len(panels)
    options = {"handles": list(entries.values()), "labels": list(entries), "frameon": False}
    for columns in (2, 1):
        rows = -(-len(entries) // columns)  # rounded up
        foot = max(_FOOT, _LINE * (rows + 1))  # [inch]
        figure.set_size_inches(_WIDTH, height + foot)
        legend = figure.legend(loc="outside lower center", ncols=columns, **options)
        if columns == 1 or legend.get_window_extent().width < figure.bbox.width:
            break
        legend.remove()
