"""The pages that are made of other files: reference, notebooks, pages of the root, gallery."""

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import gallery

import tvclin
from tvclin.base.public_names import CHAPTERS

ROOT = Path(__file__).parents[1]
MOVED = ("CHANGELOG", "CONTRIBUTING")
"""Pages that stand at the root of the repository."""


def write(folder: Path) -> None:
    """Write all of them. What is right already stays untouched, what is of no use any more goes.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    """
    pages = {folder / "api.rst": api()}
    pages |= {folder / f"{name.lower()}.md": root_page(name) for name in MOVED}
    for notebook in sorted((ROOT / "notebooks").glob("*.ipynb")):
        pages[folder / "notebooks" / notebook.name] = notebook.read_text(encoding="utf-8")
    pages[folder / "gallery.md"] = gallery.write(folder / "figures")
    references = {
        folder / "api" / f"{name}.rst"
        for questions in chapters().values()
        for names in questions.values()
        for name in names
    }
    for suffix in ("md", "rst", "ipynb"):
        for old in set(folder.rglob(f"*.{suffix}")) - set(pages) - references:
            old.unlink()
    for path, text in pages.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def chapters() -> dict[str, dict[str, list[str]]]:
    """Return the public names of each chapter by question, each name once.

    Questions and names are those of the first docstring of the chapter; names of an ordinary week
    stand in the chapter that has them.
    """
    groups: dict[str, dict[str, list[str]]] = {}
    missing = [*tvclin.__all__]
    for chapter in CHAPTERS:
        module = getattr(tvclin, chapter)
        groups[f"tvclin.{chapter}"] = questions = {}
        missing += module.__all__
        for item in module.__doc__.split("\n- ")[1:]:
            question, mark, _ = item.partition("?")
            known = [name for name in re.findall(r"`(?:\w+\.)*(\w+)`", item) if name in missing]
            questions[" ".join(f"{question}{mark}".split())] = [
                f"tvclin.{name}" if name in tvclin.__all__ else f"tvclin.{chapter}.{name}"
                for name in dict.fromkeys(known)
            ]
            missing = [name for name in missing if name not in known]
    return {"tvclin": {"": [f"tvclin.{name}" for name in missing]}, **groups}


def api() -> str:
    """Return the page of all public names, by chapter and question, as reStructuredText."""
    return "\n".join(_api_lines())


def _api_lines() -> Iterator[str]:
    title = "Reference"
    yield from (title, "=" * len(title), "")
    yield "Public names by question; those of an ordinary week are in ``tvclin`` itself."
    for chapter, questions in chapters().items():
        heading = chapter.removeprefix("tvclin.")
        yield from ("", heading, "-" * len(heading))
        if heading != chapter:
            yield from ("", (import_module(chapter).__doc__ or "").partition("\n\n")[0])
        for question, names in questions.items():
            yield from ("", question, "", ".. autosummary::", "   :nosignatures:")
            yield from ("   :toctree: api", "", *(f"   {name}" for name in names))
    yield ""


def root_page(name: str) -> str:
    """Return a page of the root with its links as seen from the folder of the site's pages."""
    return (ROOT / f"{name}.md").read_text(encoding="utf-8").replace("](docs/", "](../")


def for_the_site(name: str, text: list[str]) -> None:
    """Adapt the links of a page: to pages of the root and notebooks, and to titles for file names.

    Parameters
    ----------
    name : str
        The page.
    text : list of str
        Its source, one item, which is replaced.
    """
    if "/" not in name:
        for moved in MOVED:
            text[0] = text[0].replace(f"](../{moved}.md", f"](_generated/{moved.lower()}.md")
        text[0] = text[0].replace("](../notebooks/", "](_generated/notebooks/")
    text[0] = re.sub(r"\[[\w/-]+\.md\](\([\w./-]+\.md\))", r"[]\1", text[0])
