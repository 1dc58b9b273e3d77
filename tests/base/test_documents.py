"""What becomes of a record in JSON: its values by key, in the unit of the key."""

import json
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import tvclin as tv
from tvclin.base.documents import keyed, picked, plain


@dataclass(frozen=True)
class Inner:
    """A record without a document of its own."""

    angle: float


@dataclass(frozen=True)
class Outer:
    """A record with one."""

    inner: Inner
    lag: float = -0.25
    peak: float | None = None
    wait: float = 2.0
    phase_deg: float = 30.0
    each: tuple[float, ...] = (0.5, np.inf)

    as_dict = keyed(
        "lag_deg=|lag| wait_s angle_deg=inner.angle phase_deg peak_deg size=|peak| each"
    )


OUTER = Outer(Inner(np.pi))


def test_a_key_in_degrees_is_converted_once():
    found = OUTER.as_dict()

    assert " ".join(found) == "lag_deg wait_s angle_deg phase_deg peak_deg size each"
    assert found["angle_deg"] == 180.0
    assert found["lag_deg"] == pytest.approx(45.0 / np.pi, rel=1e-15)
    assert (found["wait_s"], found["phase_deg"]) == (2.0, 30.0)
    assert found["peak_deg"] is found["size"] is None


def test_a_factor_by_a_key_in_decibels_is_converted_once():
    factors = SimpleNamespace(gain=10.0, none=0.0, peak_dB=3.0)
    found = picked(factors, "gain_dB none_dB peak_dB low_dB=gain")
    assert found == {"gain_dB": 20.0, "none_dB": -np.inf, "peak_dB": 3.0, "low_dB": 20.0}


def test_every_value_of_a_mapping_is_converted():
    found = picked(tv.linear.Loads(np.pi, 1.0, 0.0, 1.0), "deg=peak_angle_of_attack")
    assert found == {"deg": 180.0}
    study = tv.Study.from_vehicle(tv.load_vehicle("configuration-i"), duration=7.5, peak=0.1)
    assert picked(study, "minimum_deg=minima")["minimum_deg"] == {
        name: np.degrees(peak) for name, peak in study.minima.items()
    }


def test_a_key_of_nothing_is_a_fault_of_the_package():
    with pytest.raises(AttributeError, match="height"):
        picked(OUTER, "height_m")


def test_json_holds_records_and_no_number_that_does_not_exist():
    given = {"all": [OUTER.inner, OUTER], "z": np.array([1 + 2j]), "n": np.int64(3), "no": np.nan}

    found = json.loads(json.dumps(plain(given), allow_nan=False))

    assert found["all"][0] == {"angle": np.pi}
    assert found["all"][1]["each"] == [0.5, None]
    assert found["z"] == [{"real": 1.0, "imag": 2.0}]
    assert (found["n"], found["no"]) == (3, None)
