"""A page or a section of it, read: its numbers by their names, its tags and its texts."""

from html.parser import HTMLParser

from tvclin.show.report.page import _environment, _names
from tvclin.studyfile.findings import Findings

_CELLS = ("caption", "th", "td", "p", "li", "figcaption")


class Page(HTMLParser):
    """Numbers by their names, with their texts, tags, texts and cells of HTML."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.numbers: dict[str, tuple[float, str]] = {}
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.cells: list[tuple[str, str]] = []
        self._name: str | None = None
        self._cell: list[str] = []
        self.feed(html)

    @property
    def values(self) -> dict[str, float]:
        """Values of the numbers, by name."""
        return {name: value for name, (value, _) in self.numbers.items()}

    @property
    def text(self) -> str:
        """The whole text, with single blanks."""
        return " ".join("".join(self.texts).split())

    def of(self, tag: str) -> list[str]:
        """Return the texts of the elements of a tag."""
        return [text for name, text in self.cells if name == tag]

    def attributes(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.tags.append((tag, given))
        if tag in _CELLS:
            self._cell = []
        if "data-value" in given:
            assert given["data-name"] not in self.numbers
            self._name = given["data-name"]
            self.numbers[self._name] = (float(given["data-value"]), "")

    def handle_data(self, data: str) -> None:
        self.texts.append(data)
        self._cell.append(data)
        if self._name is not None:
            self.numbers[self._name] = (self.numbers[self._name][0], data)
            self._name = None

    def handle_endtag(self, tag: str) -> None:
        if tag in _CELLS:
            self.cells.append((tag, " ".join("".join(self._cell).split())))


def section(findings: Findings, name: str) -> Page:
    """Return a section of the page of findings; empty where the page has none."""
    template = _environment().get_template("sections.html")
    return Page("".join(template.blocks[name](template.new_context(_names(findings)))))
