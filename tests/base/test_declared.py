"""A field that is declared once: its check, its keys, its option, its line of the template."""

from dataclasses import dataclass, replace
from math import radians

import numpy as np
import pytest

from tests.doors import hostile
from tvclin.answers.availability.request import AvailabilityRequest
from tvclin.answers.nozzle import Nozzle
from tvclin.answers.sizing.request import SIZE_TABLE, SizingRequest
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.answers.study_file.read import example
from tvclin.base.declared import (
    Declared,
    checked,
    completed,
    declared,
    file_table,
    help_line,
    quantity,
    text,
    word,
)
from tvclin.base.errors import InputError, between, positive, small_angle
from tvclin.base.files import tables_of
from tvclin.control.autopilot.design_rules import AutopilotDesign

EACH = (SizingRequest, StudyPlan, Nozzle, AutopilotDesign, AvailabilityRequest)


@dataclass(frozen=True, kw_only=True)
class Asked:
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


TABLE = file_table("[asked]", Asked)


def test_a_field_is_checked_where_it_is_given() -> None:
    assert Asked(turn=np.float64(0.1), bands=np.array([0.0, 1.0])).bands == (0.0, 1.0)
    for wrong, said in (
        ({"turn": -1.0}, "turn must be positive; got -1 rad"),
        ({"turn": 2.0}, "turn must be a turn within 90 degrees, in radians"),
        ({"bands": ()}, "bands must hold one number or more"),
        ({"bands": (0.5, 2.0)}, "bands must be between 0 and 1; got 2 at index 1"),
        ({"way": "lfet"}, r"way must be one of left, right; .*did you mean 'left'"),
        ({"place": 3}, "place must be a text of printable characters"),
        ({"way": None}, "way must be one of"),
    ):
        with pytest.raises(InputError, match=said):
            Asked(**wrong)


def test_a_file_has_its_keys_in_all_units_of_its_kind() -> None:
    assert TABLE.every_key == ("turn_rad", "turn_deg", "from_s", "way", "bands")
    given = TABLE.read({"turn_deg": 5, "bands": [1, 0], "way": "right"})
    assert Asked(**given) == Asked(turn=radians(5.0), bands=(1.0, 0.0), way="right")
    assert Asked(**TABLE.read({"from_s": 2})).start == 2.0
    for key in ("start_s", "start"):
        with pytest.raises(InputError, match=rf"'{key}'; did you mean from_s\?"):
            TABLE.read({key: 2})


def test_an_option_is_in_its_own_unit_and_says_so() -> None:
    turn, bands, way = (declared(Asked)[name] for name in ("turn", "bands", "way"))
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
    written = completed("# head\n\n[asked]\nbands = [1]\n\n[other]\n", TABLE, Asked)
    assert written == (
        "# head\n\n[asked]\nbands = [1]\n# also turn_rad: Angle of the turn; as seen from above.\n"
        "# also way: Which way.\n# also from_s: When it begins.\n\n[other]\n"
    )


@pytest.mark.parametrize("kind", EACH)
def test_what_is_declared_has_a_line_of_help(kind: type) -> None:
    for name, one in declared(kind).items():
        said = help_line(one)
        assert said[:1].isupper() or said[:1] in "'", name
        assert said.endswith((".", "?")), name
        assert "[" not in said, name


def _complaint(one: Declared, name: str, value: object) -> str:
    """What is said of a value of a field; its name where nothing is."""
    try:
        one.checked(name, value)
    except InputError as error:
        return str(error)
    return name


@pytest.mark.parametrize("kind", EACH)
def test_a_field_takes_a_value_or_says_in_one_sentence_what_is_wrong(kind: type) -> None:
    for name, one in declared(kind).items():
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
