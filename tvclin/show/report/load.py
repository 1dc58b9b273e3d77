"""The section of the load: the limit over what the structure bears."""

from tvclin.answers.findings import Findings
from tvclin.plots import load_chart
from tvclin.show.report.blocks import Block, Figure, Paragraph, Section, section_of
from tvclin.show.report.figures import inline_svg


def load(found: Findings) -> Section | None:
    """Return the least deflection over the largest load."""
    return section_of(found, "loads", "load", "What the structure bears", _blocks)


def _blocks(found: Findings) -> list[Block]:
    front = found.loads
    assert front is not None
    label = "Least deflection over the largest load"
    caption = (
        "Least deflection of a control that knows the wind, over the largest load. Dashed: at least"
        " so much takes a law that does not know when the wind stops."
    )
    figure = Figure(label, caption, inline_svg(load_chart(front), "load", label))
    said = Paragraph((f"The verdict here: {front.verdict}. {_joined(front.notes)}",))
    return [said, figure, *front.tables()]


def _joined(notes: object) -> str:
    return " ".join(f"{one[0].upper()}{one[1:]}." for one in notes)  # type: ignore[attr-defined]
