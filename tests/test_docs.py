"""The pages keep their promises: the map is the house, and links lead somewhere."""

import re
import tomllib
from pathlib import Path

import pytest

import tvclin

ROOT = Path(__file__).parents[1]
PAGES = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]


def test_the_map_shows_the_layers_that_the_contract_enforces() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    contracts = project["tool"]["importlinter"]["contracts"]
    layers = next(c["layers"] for c in contracts if c["type"] == "layers")
    page = (ROOT / "docs" / "map.md").read_text()

    assert "```\n" + "\n".join(layers) + "\n```" in page


def test_the_map_names_every_room() -> None:
    page = (ROOT / "docs" / "map.md").read_text()
    files = (ROOT / "tvclin").glob("[a-z]*")
    rooms = {f.stem for f in files if f.suffix == ".py" or (f.is_dir() and f.stem != "vehicles")}

    assert rooms - set(re.findall(r"\| `(\w+)/?` \|", page)) == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_between_pages_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text()):
        if "://" not in target:
            assert (page.parent / target).exists(), target


def test_every_public_name_is_documented_with_its_errors_and_units() -> None:
    for name in tvclin.__all__:
        text = getattr(tvclin, name).__doc__ or ""
        assert len(text.split()) > 5, name
        assert not text.startswith(f"{name}("), f"{name} has only its generated docstring"


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
