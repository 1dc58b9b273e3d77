"""Names of users in figures: written as they are, never read as formulas."""

from dataclasses import replace

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

import tvclin as tv
from tests.turns import by_turns
from tvclin import plots
from tvclin.control.margins.criteria import CRITERIA

mpl.use("Agg")

NAMES = [r"$\frac", r"a$b$c \$"]
GAINS = {"attitude_gain": 0.5, "rate_gain": 0.5}
X = [0.5, 1.0]


def vehicle(name):
    return replace(tv.load_vehicle("configuration-i"), name=name)


def plant(name):
    return tv.Plant.from_vehicle(vehicle(name))


def criteria(name):
    return plots.nichols_chart(
        tv.Autopilot(**GAINS), plant(""), criteria=replace(CRITERIA["classic"], name=name)
    )


def study(name):
    request = tv.Study.from_vehicle(vehicle(name), duration=7.5, peak=0.08)
    return plots.study_chart(request, [5.0, 7.5])


FIGURES = {
    "study": study,
    "boundary": lambda name: plots.boundary_chart(X, coefficients=plant(name).coefficients),
    "figure 5": lambda name: plots.figure_5(X, (1.0,), [vehicle(name)]),
    "poles": lambda name: plots.pole_map(plant(name).coefficients),
    "bode": lambda name: plots.bode_chart(tv.Autopilot(**GAINS), plant(name)),
    "nyquist": lambda name: plots.nyquist_chart(tv.Autopilot(**GAINS), plant(name)),
    "step": lambda name: plots.step_chart(tv.Autopilot(**GAINS), plant(name)),
    "criteria": criteria,
}


@pytest.fixture(autouse=True)
def no_figure_stays_open():
    yield
    plt.close("all")


def written(plot, tmp_path):
    """Return the words of a figure as SVG has them: those of a formula are taken apart there."""
    from xml.etree import ElementTree

    file = tmp_path / "figure.svg"
    with mpl.rc_context({"svg.fonttype": "none"}):
        plots.save_figure(plot, file)
    texts = ElementTree.parse(file).iter("{http://www.w3.org/2000/svg}text")
    return [" ".join("".join(text.itertext()).split()) for text in texts]


@pytest.mark.thorough
@by_turns("name,draw", NAMES, FIGURES, each=4)
def test_a_dollar_sign_in_a_name_is_a_dollar_sign(tmp_path, draw, name):
    words = written(FIGURES[draw](name), tmp_path)
    assert any(name in word for word in words), words


def test_a_figure_is_saved_as_one_of_matplotlib(tmp_path):
    plots.boundary_chart(X, coefficients=plant("").coefficients).savefig(tmp_path / "a.png")

    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
