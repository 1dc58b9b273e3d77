"""What notebooks show of a record: its own numbers, and no text as markup."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import tvclin as tv
from tvclin.base.cards import Shown, card
from tvclin.base.fields import derived
from tvclin.ensembles.statistics import quantile_bound
from tvclin.requirement.required_quantity import heading_of


class Cells(HTMLParser):
    """The texts of a table by row."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.inside = False
        self.feed(html)

    def handle_starttag(self, tag, attrs) -> None:
        if tag == "tr":
            self.rows.append([])
        self.inside = tag in {"th", "td"}
        if self.inside:
            self.rows[-1].append("")

    def handle_data(self, data) -> None:
        if self.inside:
            self.rows[-1][-1] += data


def cells(record) -> dict[str, tuple[str, str]]:
    return {name: (value, unit) for name, value, unit in Cells(record._repr_html_()).rows}


PLANT = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
WIND = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)


def test_a_boundary_shows_its_numbers():
    boundary = tv.boundary_limit(PLANT, WIND)
    shown = cells(boundary)

    assert float(shown["limit over trim"][0]) == pytest.approx(boundary.limit, rel=1e-5)
    assert float(shown["deflection"][0]) == pytest.approx(np.degrees(boundary.deflection), abs=5e-4)
    assert shown["deflection"][1] == "deg"
    assert shown["status"][0] == boundary.status


def test_margins_are_shown_in_the_units_they_name():
    margins = tv.control.canonical_gains(PLANT.coefficients).margins(PLANT)
    shown = cells(margins)

    assert float(shown["phase"][0]) == pytest.approx(np.degrees(margins.phase_margin), abs=5e-3)
    assert float(shown["aero: gain may fall"][0]) == pytest.approx(
        20 * np.log10(margins.aero_margin), abs=5e-3
    )


def test_a_quantile_shows_its_bounds():
    shown = cells(quantile_bound(np.arange(1.0, 501.0), 0.9, 0.95))
    bound = quantile_bound(np.arange(1.0, 501.0), 0.9, 0.95)

    assert float(shown["lower"][0]) == bound.lower < bound.estimate
    assert float(shown["upper"][0]) == bound.upper > bound.estimate
    assert shown["cases"][0] == "500"


def test_the_boundary_of_a_law_shows_degrees():
    boundary = tv.flights.ClosedLoopBoundary(
        limit=0.8,
        deflection=np.radians(0.4),
        scan=np.array([0.7, 0.9]),
        survives=np.array([False, True]),
        refinements=((0.01, 0.9), (0.001, 0.83)),
        growth=-0.1,
        has_unstable_mode=False,
        status="ok",
    )
    assert list(cells(boundary).values()) == [
        ("0.8", ""),
        ("0.400", "deg"),
        ("0.01, 0.9, 0.001, 0.83", ""),
        ("-0.1", "1/s"),
        ("ok", ""),
    ]


RECORDS = {
    "vehicle": lambda: tv.load_vehicle("configuration-ii"),
    "coefficients": lambda: PLANT.coefficients,
    "modes": lambda: tv.unstable_modes(PLANT),
    "bound": lambda: tv.forecast_free_limit(PLANT, WIND),
    "optimum": lambda: tv.optimum_deflection(PLANT, WIND),
    "plant": lambda: PLANT,
    "wind": lambda: WIND,
    "schedule": lambda: tv.load_schedule("configuration-i"),
    "law": lambda: tv.RecoverableAttitudeLaw(
        PLANT, estimator=tv.control.WindEstimator(bandwidth=2.0)
    ),
    "stable": lambda: tv.Coefficients(mu_alpha=-1.0, mu_delta=2.0),
    "batch": lambda: tv.Coefficients(mu_alpha=np.linspace(0.1, 2.0, 50), mu_delta=2.0),
}


@pytest.mark.parametrize("made", RECORDS.values(), ids=RECORDS)
def test_every_line_has_a_name_a_value_and_a_unit(made):
    rows = Cells(made()._repr_html_()).rows

    assert len(rows) >= 3
    assert all(len(row) == 3 and row[0] and row[1] for row in rows)


def test_an_autopilot_shows_what_it_has_and_how_many_filters():
    low_pass = tv.vehicle.Filter.low_pass(13.0)
    bare = tv.Autopilot(attitude_gain=0.5, rate_gain=0.25)
    full = replace(
        bare, actuator=tv.Actuator(natural_frequency=25.0), delay=0.02, filters=(low_pass, low_pass)
    )
    one, shown = cells(bare), cells(full)

    assert "actuator, damping" not in one
    assert "filters" not in one
    assert shown["attitude gain"] == ("0.5", "")
    assert shown["actuator, natural frequency"] == ("25", "rad/s")
    assert shown["delay"] == ("0.02", "s")
    assert shown["filters"] == ("2", "")


def test_laws_show_what_is_inside_them():
    gains = tv.Autopilot(attitude_gain=0.5, rate_gain=0.25)
    trim = tv.TrimLaw(PLANT, gain=3.0)
    filtered = tv.control.FilteredLaw(trim, filters=(tv.vehicle.Filter.low_pass(13.0),))

    assert cells(tv.SaturatedLaw(gains))["autopilot, rate gain"] == ("0.25", "s")
    assert cells(trim) == {"model": ("drift-exact", ""), "gain": ("3", "")}
    inside = {f"law, {name}": value for name, value in cells(trim).items()}
    assert cells(filtered) == inside | {"filters": ("1", "")}


def test_a_sizing_shows_its_worst_and_a_total_its_lines_in_degrees():
    flight = tv.load_schedule("configuration-i")
    sized = tv.size(flight, {"gust": WIND}, times=[60.0, 70.0], dead_bands=1.0)
    rows = {row[0]: row[1:] for row in Cells(sized._repr_html_()).rows}
    total = tv.worst_total(sized, "K = 1", limit=0.1)
    lines = {row[0]: row[-1] for row in Cells(total._repr_html_()).rows}

    assert {heading_of(one.label) for one in sized.worst} <= set(rows)
    need, time, wind = rows["K = 1"]
    assert float(need) == pytest.approx(np.degrees(sized.worst["K = 1"].deflection), abs=5e-4)
    assert (time, wind) == (f"{sized.worst['K = 1'].time:g}", "gust")
    assert float(lines["total"]) == pytest.approx(np.degrees(total.total), abs=5e-4)
    assert "<p>Limit 5.730 deg: SUFFICIENT, " in total._repr_html_()


def test_trials_are_one_table_of_laws_and_winds():
    fixed = tv.Plant.from_coefficients(PLANT.coefficients)
    trials = tv.design.law_trials(fixed, {"<trim>": tv.TrimLaw(fixed)}, {"gust": WIND}, loads=False)
    heads, row = Cells(trials._repr_html_()).rows

    assert heads[:2] == ["law", "wind"]
    assert row[:2] == ["<trim>", "gust"]
    assert float(row[2]) == pytest.approx(trials[0].limit, abs=5e-4)
    assert float(cells(trials[0])["limit"][0]) == pytest.approx(trials[0].limit, rel=1e-5)


def test_residues_of_modes_that_oscillate_are_shown_in_degrees():
    class Found(Shown):
        @property
        @derived("angle")
        def residue(self):
            return np.array([0.1 + 0.2j])

    shown = Cells(Found()._repr_html_()).rows

    assert complex(shown[0][1]) == pytest.approx(np.degrees(0.1) + 1j * np.degrees(0.2), rel=1e-5)


GAINS = tv.control.canonical_gains(PLANT.coefficients)
BATCH = tv.TriangularWind(peak=np.full(900, 0.05), duration=7.5)
ANSWERS = {
    "boundary": lambda: tv.boundary_limit(PLANT, BATCH),
    "requirement": lambda: tv.required_deflection(PLANT, BATCH),
    "optimum": lambda: tv.optimum_deflection(PLANT, WIND),
    "study": lambda: tv.Study.from_vehicle(
        tv.load_vehicle("configuration-i"), duration=7.5, peak=0.08
    ),
    "sizing": lambda: tv.size(
        tv.load_schedule("configuration-i"), {"gust": WIND}, times=[60.0, 70.0], dead_bands=1.0
    ),
    "margins": lambda: GAINS.margins(PLANT),
    "comparison": lambda: tv.compare_with_trim(PLANT, GAINS, WIND),
    "schedule": lambda: tv.load_schedule("configuration-i"),
}


@pytest.mark.parametrize("made", ANSWERS.values(), ids=ANSWERS)
def test_an_answer_is_printed_in_a_few_words(made):
    record = made()
    assert "\n" not in repr(record)
    assert 20 < len(repr(record)) < 800
    assert "array" not in repr(record)


def test_a_long_array_is_shown_by_its_range():
    row = cells(tv.Coefficients(mu_alpha=np.linspace(0.1, 2.0, 50), mu_delta=2.0))["mu_alpha"]

    assert row[0] == "0.1 to 2, shape (50,)"


def test_what_is_no_row_of_numbers_is_shown_in_words():
    rows = [
        ("nothing", np.array([]), ""),
        ("verdicts", [True, False], ""),
        ("statuses", np.array(["ok", "lost", "ok"]), ""),
    ]
    assert [row[1] for row in Cells(card("x", rows)).rows] == ["none", "yes, no", "lost, ok"]


def test_names_are_no_markup():
    vehicle = tv.load_vehicle("configuration-i").replace(name="<script>alert(1)</script>")

    assert "<script>" not in vehicle._repr_html_()
    assert "<b>" not in card("x", [("<b>", "<b>", "<b>")]).replace("<b>x</b>", "")


def test_only_vehicles_that_are_all_unstable_show_a_response_parameter():
    shown = cells(PLANT.coefficients)["beta"]
    assert float(shown[0]) == pytest.approx(PLANT.coefficients.beta, rel=1e-5)
    assert shown[1] == "1/s"
    for stable in (-1.0, 0.0, [1.0, -1.0]):
        assert "beta" not in cells(tv.Coefficients(mu_alpha=stable, mu_delta=2.0))


def test_many_flights_are_counted_by_what_became_of_them() -> None:
    need = abs(tv.boundary_limit(PLANT, WIND).deflection)
    limits = need * np.array([0.5, 1.5, 1.6, -1.0])
    law = tv.TrimLaw(PLANT)
    flown = tv.fly_many(PLANT, law, WIND, deflection_limit=limits, sample_rate=100.0)
    assert flown.counts == {"survived": 2, "lost": 1, "no flight": 1}
    assert "counts, survived 2, counts, lost 1, counts, no flight 1" in repr(flown)
    shown = cells(flown)
    assert shown["counts, survived"] == ("2", "")
    assert shown["peak deflection"][1] == "deg"


@pytest.mark.parametrize("name", ["configuration-i", "made-up-booster"])
def test_a_vehicle_its_coefficients_and_its_plant_are_printed_in_a_few_lines_with_few_digits(name):
    vehicle = tv.load_vehicle(name)
    plant = tv.Plant.from_vehicle(vehicle)
    for record in filter(None, (vehicle, plant, plant.coefficients, vehicle.structure)):
        printed = repr(record)
        assert len(printed.splitlines()) <= 6
        assert max(map(len, printed.splitlines())) <= 88
        digits = [match.replace(".", "").lstrip("0") for match in re.findall(r"[\d.]+", printed)]
        assert max(map(len, digits)) <= 6
    assert "mu_alpha 0.28014 1/s²" in repr(plant).replace("\n  ", " ")
