"""What becomes of a record in JSON: its values by key, in the unit of the key."""

import json
from dataclasses import dataclass, field

import numpy as np

import tvclin as tv
from tvclin.base.cards import Record
from tvclin.base.fields import plain, spec


@dataclass(frozen=True)
class Inner:
    """A record without a document of its own."""

    angle: float


@dataclass(frozen=True)
class Outer(Record):
    """A record with one."""

    inner: Inner = field(metadata=spec("angle", name="angle", of="inner.angle"))
    each: tuple[float, ...] = field(default=(0.5, np.inf), metadata=spec())


OUTER = Outer(Inner(np.pi))


def test_every_value_of_a_mapping_is_converted():
    study = tv.Study.from_vehicle(tv.load_vehicle("configuration-i"), duration=7.5, peak=0.1)
    assert study.as_dict()["minimum_deg"] == {
        name: np.degrees(peak) for name, peak in study.minima.items()
    }


def test_json_holds_records_and_no_number_that_does_not_exist():
    given = {"all": [OUTER.inner, OUTER], "z": np.array([1 + 2j]), "n": np.int64(3), "no": np.nan}

    answer = json.loads(json.dumps(plain(given), allow_nan=False))

    assert answer["all"][0] == {"angle": np.pi}
    assert answer["all"][1]["each"] == [0.5, None]
    assert answer["z"] == [{"real": 1.0, "imag": 2.0}]
    assert (answer["n"], answer["no"]) == (3, None)
