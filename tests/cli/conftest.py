"""What the commands are tried on."""

import pytest

from tvclin.control import comparison as duration
from tvclin.vehicle.vehicle_file import read_vehicle_text


@pytest.fixture
def stable_vehicle(tmp_path):
    """Return the file of a vehicle whose centre of pressure lies behind that of gravity."""
    file = tmp_path / "stable.toml"
    text = read_vehicle_text("configuration-i")[0]
    file.write_text(text.replace("aerodynamic_arm_m = 9.45", "aerodynamic_arm_m = -2"))
    return file


@pytest.fixture(autouse=True)
def _few_swings(monkeypatch):
    """Take at most 50 durations for each mode in the search for the worst one."""
    monkeypatch.setattr(duration, "_MAX_PER_MODE", 50)
