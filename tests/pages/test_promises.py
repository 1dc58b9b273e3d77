"""The pages keep their promises: the map is the house, and links lead somewhere."""

import ast
import copy
import inspect
import pickle
import pydoc
import re
import sys
import tomllib
from contextlib import suppress
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from types import ModuleType

import pytest

import tvclin
from tests.doors import public
from tvclin.base.public_names import CHAPTERS, GUESSES
from tvclin.linear.plant import DEFAULT_MODEL

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


def test_the_map_names_the_chapters_in_the_order_that_the_contract_enforces() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    contracts = project["tool"]["importlinter"]["contracts"]
    layers = next(c["layers"] for c in contracts if c["type"] == "layers")
    page = (ROOT / "docs" / "map.md").read_text()
    items = re.findall(r"^\d+\. ([^:]+):", page, flags=re.MULTILINE)
    chapters = {folder.name for folder in (ROOT / "tvclin").iterdir() if folder.is_dir()}

    assert re.findall(r"`(\w+)`", " ".join(items)) == layers[::-1]
    assert {*layers} == chapters - {"__pycache__"}


def test_every_function_of_the_table_of_roads_can_be_called_by_that_name() -> None:
    page = (ROOT / "docs" / "how-a-number-is-made.md").read_text()
    cells = re.findall(r"(?m)^\| (`[^|]*) \|", page)
    names = [name for cell in cells for name in re.findall(r"`([\w.]+)`", cell)]
    assert len(names) > 15
    for name in names:
        assert callable(attrgetter(name)(tvclin)), name


def _anchors(page: Path) -> set[str]:
    """The anchors of the headings of a page, as GitHub and the site name them."""
    outside = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^#+ (.+)$", outside, flags=re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_no_public_name_is_hidden_by_a_room_of_the_same_name() -> None:
    for door in (tvclin, *(getattr(tvclin, chapter) for chapter in CHAPTERS)):
        assert not {path.stem for path in Path(door.__file__).parent.iterdir()} & set(door.__all__)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_between_pages_lead_somewhere(page: Path) -> None:
    for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)\s]+))?\)", page.read_text()):
        if "://" not in target:
            there = page.parent / target if target else page
            assert there.exists(), target
            assert not anchor or anchor in _anchors(there), f"{target}#{anchor}"


def test_the_front_page_of_the_site_lists_every_page() -> None:
    """In its list for readers, and in the table of contents, by name or by a pattern."""
    front = (ROOT / "docs" / "index.md").read_text()
    entries = re.findall(
        r"^([\w*\[\]-]+)$", "".join(re.findall(r"(?s)```.toctree.+?```", front)), re.M
    )

    for page in (ROOT / "docs").glob("*.md"):
        if page.stem != "index":
            assert f"]({page.name})" in front, page.name
            assert any(page.match(f"{entry}.md") for entry in entries), page.name


@pytest.fixture
def pages(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(ROOT / "docs")
    return pytest.importorskip("pages")


def test_the_reference_names_every_public_name_once(pages: ModuleType) -> None:
    listed = re.findall(r"^   tvclin\.([\w.]+)$", pages.api(), flags=re.MULTILINE)
    everyday = set(tvclin.__all__)
    others = [
        f"{chapter}.{name}"
        for chapter in CHAPTERS
        for name in getattr(tvclin, chapter).__all__
        if name not in everyday
    ]

    assert sorted(listed) == sorted([*everyday, *others])
    assert "How far do the formulas hold?" in pages.api().splitlines()


def test_what_stands_after_the_dot_fits_on_a_screen() -> None:
    shown = [name for name in dir(tvclin) if not name.startswith("_")]

    assert len(tvclin.__all__) <= 66
    assert set(shown) == {*tvclin.__all__, *CHAPTERS}


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_the_page_of_a_chapter_names_what_is_public_by_question(chapter: str) -> None:
    door = getattr(tvclin, chapter)
    named = set(re.findall(r"`(?:\w+\.)*(\w+)`", door.__doc__.partition("\n- ")[2]))

    assert set(door.__all__) <= named <= {*public(), *door.__all__, "margins"}


@pytest.mark.parametrize(
    ("door", "name", "said"),
    [
        ("tvclin", "boundry_limit", "tvclin.boundary_limit"),
        ("tvclin", "Filter", "do you mean tvclin.vehicle.Filter?"),
        ("tvclin.winds", "Plant", "tvclin.winds has no Plant: do you mean tvclin.Plant?"),
        ("tvclin.control", "lqr_gain", "tvclin.control.lqr_gains"),
        ("tvclin", "tf", "do you mean Plant.tf("),
        ("tvclin", "transfer_function", "do you mean Plant.tf("),
        ("tvclin.linear", "poles", "do you mean Plant.poles or tvclin.unstable_modes?"),
    ],
)
def test_a_misspelt_name_is_answered_with_the_near_one(door: str, name: str, said: str) -> None:
    with pytest.raises(AttributeError, match=re.escape(said)):
        getattr(import_module(door), name)


@pytest.mark.parametrize("package", ["tvclin", *(f"tvclin.{chapter}" for chapter in CHAPTERS)])
def test_the_help_of_a_chapter_is_a_page_that_has_its_names(package: str) -> None:
    module = import_module(package)
    text = pydoc.plain(pydoc.render_doc(module))

    assert len(text.splitlines()) <= 80
    assert all(re.search(rf"\b{name}\b", text) for name in module.__all__)


def test_public_names_that_are_offered_for_first_guesses_exist() -> None:
    for offered in GUESSES.values():
        for name in re.findall(r"(?:tvclin|Plant|Autopilot)(?:\.\w+)+", offered):
            owner, *rest = name.split(".")
            result = tvclin if owner == "tvclin" else getattr(tvclin, owner)
            for one in rest:
                result = getattr(result, one)


@pytest.mark.parametrize("name", ["residues", "pole", "unstable_mode"])
def test_what_a_plant_has_not_is_answered_with_the_public_name(name: str) -> None:
    plant = tvclin.Plant.from_vehicle(tvclin.load_vehicle("configuration-i"))
    meant = {"residues": "tvclin.residues", "pole": "Plant.poles"}.get(name, "Plant has no")
    with pytest.raises(AttributeError, match=re.escape(meant)):
        getattr(plant, name)
    assert pickle.loads(pickle.dumps(plant)) == copy.deepcopy(plant) == plant


def test_pages_of_the_root_keep_their_links_in_the_site(pages: ModuleType) -> None:
    for name in pages.MOVED:
        place = ROOT / "docs" / "_generated"
        for target in re.findall(r"\]\(([^)#:]+)\)", pages.root_page(name)):
            assert Path(*(place / target).parts).resolve().exists(), (name, target)

    text = [
        "See [CONTRIBUTING.md](../CONTRIBUTING.md), [map.md](map.md), [this](../notebooks/a.ipynb)."
    ]
    pages.for_the_site("index", text)
    assert text == [
        "See [](_generated/contributing.md), [](map.md), [this](_generated/notebooks/a.ipynb)."
    ]


def test_the_first_page_of_the_site_has_the_question_the_picture_and_the_eight_lines() -> None:
    front, readme = ((ROOT / name).read_text() for name in ("docs/index.md", "README.md"))
    code = re.search(r"(?s)## Eight lines of Python\n\n(```python.+?\n```)", readme)
    table = front.index("| question |")

    assert "How much thrust-vector deflection" in front[:table]
    assert "](images/study.png)" in front[:table]
    assert code is not None
    assert code[1] in front[:table]


def test_the_site_is_built_with_nothing_but_its_group_and_the_package() -> None:
    """What the files of the site import or name as extensions stands in pyproject."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    needed = [*project["dependency-groups"]["docs"], *project["project"]["dependencies"]]
    known = {re.split(r"[<>=]", one)[0].replace("-", "_") for one in needed}
    own = {file.stem for file in (ROOT / "docs").glob("*.py")}
    imported = set()
    for file in (ROOT / "docs").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom):
                imported.add((node.module or "").partition(".")[0])
            if isinstance(node, ast.Import):
                imported |= {name.name.partition(".")[0] for name in node.names}
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "extensions":
                named = ast.literal_eval(node.value)
                imported |= {one.partition(".")[0].replace("-", "_") for one in named}

    assert imported - set(sys.stdlib_module_names) <= known | own | {"tvclin"}


def test_no_body_of_a_command_has_more_than_thirty_lines() -> None:
    for file in (ROOT / "tvclin" / "cli").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.FunctionDef):
                body = node.body[ast.get_docstring(node) is not None :]
                lines = body[-1].end_lineno - body[0].lineno + 1 if body else 0
                assert lines <= 30, f"{file.name}: {node.name} has {lines}"


def test_packages_are_tried_on_the_lowest_and_the_newest_python_that_is_promised() -> None:
    workflow = ROOT / ".github" / "workflows" / "check.yml"
    if not workflow.exists():
        pytest.skip("an sdist has no workflow")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    named = re.findall(r"Python :: (3\.\d+)", " ".join(project["classifiers"]))
    job = workflow.read_text().partition("\n  packages:")[2]
    tried = re.findall(r"3\.\d+", job[: job.index("]")])

    assert tried == [named[0], named[-1]]
    assert project["requires-python"] == f">={named[0]}"
    assert "- run: make packages" in job


def test_no_public_function_takes_another_model_by_itself() -> None:
    made = [value for value in public().values() if callable(value)]
    made += [one.from_vehicle for one in made if hasattr(one, "from_vehicle")]
    for function in made:
        with suppress(ValueError):  # some of numpy and control have no signature
            taken = inspect.signature(function).parameters.get("model")
            if taken is not None and taken.default is not inspect.Parameter.empty:
                assert taken.default in ("", None, DEFAULT_MODEL), function
    models = (ROOT / "docs" / "conventions.md").read_text().partition("## Models")[2]
    assert f"takes **`{DEFAULT_MODEL}`**" in models.partition("##")[0]


def test_every_public_name_is_documented_with_its_errors_and_units() -> None:
    for name, one in public().items():
        text = one.__doc__ or ""
        assert len(text.split()) > 5, name
        assert not text.startswith(f"{name}("), f"{name} has only its generated docstring"


@pytest.mark.thorough
def test_the_table_of_optima_is_what_the_package_finds() -> None:
    """Every number of the table in docs/optimum.md, to its printed digits."""
    columns = [
        ("configuration-i", "fixed-path"),
        ("configuration-i", "drift"),
        ("configuration-i", "drift-exact"),
        ("configuration-i", "drift-and-speed"),
        ("configuration-ii", "drift-exact"),
        ("configuration-ii", "drift-and-speed"),
    ]
    page = (ROOT / "docs" / "optimum.md").read_text()
    rows = re.findall(r"^\| (\d+) \|((?: 0\.\d{5} \|){6})$", page, flags=re.MULTILINE)

    assert [row[0] for row in rows] == ["2", "4", "8", "14", "20", "40"]
    for tau_beta, cells in rows:
        for (name, model), printed in zip(columns, re.findall(r"0\.\d{5}", cells), strict=True):
            plant = tvclin.Plant.from_vehicle(tvclin.load_vehicle(name), model)
            c = plant.coefficients
            wind = tvclin.TriangularWind(peak=0.1, duration=int(tau_beta) / c.beta)
            peak = tvclin.optimum_deflection(plant, wind).peak / (0.1 * c.B)
            assert f"{peak:.5f}" == printed, (tau_beta, name, model)
