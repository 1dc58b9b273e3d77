"""Specification of a field: check, keys, option and template; document, card and table row."""

import inspect
import re
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module
from math import pi, radians
from pkgutil import walk_packages

import numpy as np
import pytest

import tvclin
from tests.doors import hostile
from tvclin.base.cards import Record
from tvclin.base.errors import InputError, between, positive, small_angle
from tvclin.base.fields import (
    Field,
    array_table,
    checked,
    completed,
    derived,
    document,
    fields_of,
    file_table,
    help_line,
    parameters,
    quantity,
    record_table,
    rows,
    spec,
    specs,
    text,
    word,
)
from tvclin.base.files import tables_of
from tvclin.base.lines import text as as_text
from tvclin.case.nozzle import Nozzle
from tvclin.control.autopilot.design_rules import AutopilotDesign
from tvclin.ensembles.availability.availability import AvailabilityRequest
from tvclin.requirement.flight.request import SIZE_TABLE, SizingRequest
from tvclin.studyfile.read import example
from tvclin.studyfile.study_plan import StudyPlan

LOADED_WHERE_NEEDED = (
    "tvclin.__main__",
    "tvclin.show.explorer.panel",
    "tvclin.flights.sixdof.airframe",
)
EACH = (SizingRequest, StudyPlan, Nozzle, AutopilotDesign, AvailabilityRequest)


@dataclass(frozen=True, kw_only=True)
class Request:
    """What a test asks.

    Attributes
    ----------
    turn : float, optional
        Angle of the turn [rad]; as seen from above.
    bands : tuple of float
        Bands, from 0 to 1.
    way, place : str
        Which way.
    start : float, optional
        When it begins [s].
    """

    turn: float | None = quantity("angle", None, small_angle("a turn", positive))
    bands: tuple[float, ...] = quantity("number", (0.5,), between(0.0, 1.0), many=True)
    way: str = word(("left", "right"), "left")
    place: str = text("here", key=None)
    start: float | None = quantity("time", None, key="from")

    def __post_init__(self) -> None:
        checked(self)


TABLE = file_table("[given]", Request)


def test_a_field_is_checked_where_it_is_given() -> None:
    assert Request(turn=np.float64(0.1), bands=np.array([0.0, 1.0])).bands == (0.0, 1.0)
    for wrong, said in (
        ({"turn": -1.0}, "turn must be positive; got -1 rad"),
        ({"turn": 2.0}, "turn must be a turn within 90 degrees; got"),
        ({"bands": ()}, "bands must hold one number or more"),
        ({"bands": (0.5, 2.0)}, "bands must be between 0 and 1; got 2 at index 1"),
        ({"way": "lfet"}, r"way must be one of left, right; .*did you mean 'left'"),
        ({"place": 3}, "place must be a text of printable characters"),
        ({"way": None}, "way must be one of"),
    ):
        with pytest.raises(InputError, match=said):
            Request(**wrong)


def test_none_is_a_value_only_where_it_is_the_default() -> None:
    @dataclass(frozen=True)
    class Needed:
        turn: float = quantity("angle")
        rate: float | None = quantity("angular rate", None)

        def __post_init__(self) -> None:
            checked(self)

    assert Needed(0.1).rate is None
    with pytest.raises(InputError, match="turn must be a number in rad; got None"):
        Needed(None)  # type: ignore[arg-type]


def test_a_file_has_its_keys_in_all_units_of_its_kind() -> None:
    assert TABLE.every_key == ("turn_rad", "turn_deg", "from_s", "way", "bands")
    given = TABLE.read({"turn_deg": 5, "bands": [1, 0], "way": "right"})
    assert Request(**given) == Request(turn=radians(5.0), bands=(1.0, 0.0), way="right")
    assert Request(**TABLE.read({"from_s": 2})).start == 2.0
    for key in ("start_s", "start"):
        with pytest.raises(InputError, match=rf"'{key}'; did you mean from_s\?"):
            TABLE.read({key: 2})


def test_an_option_is_in_its_own_unit_and_says_so() -> None:
    turn, bands, way = (parameters(Request)[name] for name in ("turn", "bands", "way"))
    assert help_line(turn) == "Angle of the turn, in deg; as seen from above."
    assert help_line(way) == "Which way: left or right."
    assert turn.from_option("--turn-deg", 5.0) == radians(5.0)
    assert bands.from_option("--bands", [0.0, 1.0]) == (0.0, 1.0)
    for value, said in ((-5.0, "--turn-deg must be positive; got -5 deg"), (90.0, "within 90 deg")):
        with pytest.raises(InputError, match=said):
            turn.from_option("--turn-deg", value)
    with pytest.raises(InputError, match="--bands must be between 0 and 1; got 2"):
        bands.from_option("--bands", [2.0])


def test_a_template_names_the_keys_that_it_leaves_out() -> None:
    written = completed("# head\n\n[given]\nbands = [1]\n\n[other]\n", TABLE)
    assert written == (
        "# head\n\n[given]\nbands = [1]\n# also turn_rad: Angle of the turn; as seen from above.\n"
        "# also way: Which way.\n# also from_s: When it begins.\n\n[other]\n"
    )


@pytest.mark.parametrize("kind", EACH)
def test_what_is_declared_has_a_line_of_help(kind: type) -> None:
    for name, one in parameters(kind).items():
        said = help_line(one)
        assert said[:1].isupper() or said[:1] in "'", name
        assert said.endswith((".", "?")), name
        assert "[" not in said, name


def _complaint(one: Field, name: str, value: object) -> str:
    """What is said of a value of a field; its name where nothing is."""
    try:
        one.checked(name, value)
    except InputError as error:
        return str(error)
    return name


@pytest.mark.thorough
@pytest.mark.parametrize("kind", EACH)
def test_a_field_takes_a_value_or_says_in_one_sentence_what_is_wrong(kind: type) -> None:
    for name, one in parameters(kind).items():
        for value in hostile().values():
            said = _complaint(one, name, value)
            assert name in said
            assert "\n" not in said


def test_the_study_file_of_init_names_every_key_of_a_sizing() -> None:
    written = example()
    tables_of(written, "the example")
    for name in SIZE_TABLE.quantities:
        assert name in written
    added = replace(SIZE_TABLE, quantities=SIZE_TABLE.quantities | {"turn": "angle"})
    assert added.spelled("turn") == "turn_rad or turn_deg"


@dataclass(frozen=True)
class Flown(Record):
    """Record of a test."""

    lag: float = field(default=-pi / 4, metadata=spec("angle", label="largest lag"))
    rate: float = field(default=pi, metadata=spec("angular rate", digits=1))
    gain: float = field(default=10.0, metadata=spec("gain", document=False))
    inertia: float = field(default=1.23456e5, metadata=spec("inertia"))
    each: dict[int, float | None] = field(
        default_factory=lambda: {1: pi, 2: None}, metadata=spec("angle")
    )
    peak: float | None = field(default=None, metadata=spec("angle"))
    request: Request = field(
        default_factory=lambda: Request(turn=0.25),
        metadata=specs(
            Field(of="request.turn", key="turn_rad", label="turn"),
            Field("turn", "angle", of=lambda flown: -flown.request.turn, card=False),
        ),
    )
    secret: float = 7.0

    @property
    @derived("angle", card=False)
    def size(self) -> float:
        """Size of the lag [rad]."""
        return abs(self.lag)

    @cached_property
    @derived()
    def status(self) -> str:
        """Status."""
        return "ok"


def test_records_and_arrays_are_columns_of_a_table_in_their_units() -> None:
    @dataclass(frozen=True)
    class Limits(Record):
        rates: np.ndarray = field(metadata=spec("angular rate", "rate limit"))
        limits: np.ndarray | None = field(metadata=spec("angle", infinite="none"))
        parts: tuple[float, ...] = field(metadata=spec(significant=2))

    limits = Limits(np.radians([1.0, 2.0]), np.array([np.inf, np.radians(3.0)]), (1.234, 0.5))
    table = array_table("Limits", "limit", limits, "limits", "rates", "parts", rows=[1, 0])
    assert table.head == ("limits [deg]", "rate limit [deg/s]", "parts")
    assert [tuple(map(as_text, row)) for row in table.rows] == [
        ("3.000", "2.000", "0.5"),
        ("none", "1.000", "1.2"),
    ]
    assert table.rows[0][1][0].name == "limit.1.rates_deg_per_s"
    bare = array_table("Limits", "limit", replace(limits, limits=None), "rates", "limits")
    assert [as_text(row[1]) for row in bare.rows] == ["-", "-"]

    labels = ("flight", ["first", "second"])
    flights = [Flown(), Flown(lag=0.1, rate=np.nan)]
    flown = record_table("Flights", "flown", flights, "rate", "lag", "peak", labels=labels)
    assert flown.head == ("flight", "rate [deg/s]", "largest lag [deg]", "peak [deg]")
    assert [tuple(map(as_text, row)) for row in flown.rows] == [
        ("first", "180.0", "-45.000", "-"),
        ("second", "-", f"{np.degrees(0.1):.3f}", "-"),
    ]


def test_a_document_has_each_field_in_the_unit_of_its_key() -> None:
    assert Flown().as_dict() == {
        "lag_deg": -45.0,
        "rate_deg_per_s": 180.0,
        "inertia_kg_m2": 1.23456e5,
        "each_deg": {"1": 180.0, "2": None},
        "peak_deg": None,
        "turn_rad": 0.25,
        "turn_deg": -np.degrees(0.25),
        "size_deg": 45.0,
        "status": "ok",
    }


def test_a_card_has_the_same_fields_with_label_and_unit() -> None:
    shown = re.findall("<t[hd].*?>(.*?)</t[hd]>", Flown()._repr_html_())
    rows_of_card = dict(zip(shown[::3], zip(shown[1::3], shown[2::3], strict=True), strict=True))
    assert rows_of_card == {
        "largest lag": ("-45.000", "deg"),
        "rate": ("180", "deg/s"),
        "gain": ("20", "dB"),
        "inertia": ("123456", "kg m²"),
        "each, 1": ("180.000", "deg"),
        "turn": ("0.25", ""),
        "status": ("ok", ""),
    }


def test_a_row_of_a_table_has_label_digits_unit_and_the_full_number() -> None:
    record = Flown(each={})
    shown = dict(rows(record, "flown", "lag", "rate", "gain", "inertia"))
    assert {label: as_text(line) for label, line in shown.items()} == {
        "largest lag": "-45.000 deg",
        "rate": "180.0 deg/s",
        "gain": "20.000 dB",
        "inertia": "1.235·10⁵ kg m²",
    }
    number = shown["rate"][0]
    assert (number.name, number.value) == ("flown.rate_deg_per_s", 180.0)


def test_a_field_of_nothing_is_a_fault_of_the_package() -> None:
    with pytest.raises(AttributeError, match="height"):
        document(Flown(), "height")


def test_every_field_of_the_package_has_its_attribute_its_unit_and_a_key_of_its_own() -> None:
    for module in walk_packages(tvclin.__path__, "tvclin."):
        if module.name in LOADED_WHERE_NEEDED:
            continue
        for kind in vars(import_module(module.name)).values():
            if inspect.isclass(kind) and kind.__module__ == module.name:
                names = {*dir(kind), *getattr(kind, "__dataclass_fields__", ())}
                specified = fields_of(kind)
                roots = {x.of.split(".")[0] for x in specified if isinstance(x.of, str)}
                assert roots <= names, kind
                keys = [x.document_key for x in specified if x.document]  # KeyError: unknown kind
                assert len(keys) == len(set(keys)), kind
