"""What the commands are tried on."""

import pytest

from tvclin.vehicle.file import vehicle_text


@pytest.fixture
def stable_vehicle(tmp_path):
    """Return the file of a vehicle whose centre of pressure lies behind that of gravity."""
    file = tmp_path / "stable.toml"
    text = vehicle_text("configuration-i")[0]
    file.write_text(text.replace("aerodynamic_arm_m = 9.45", "aerodynamic_arm_m = -2"))
    return file


@pytest.fixture
def few_swings(monkeypatch):
    """Look for the worst duration of a wind at 50 in the swings of a mode, not at 2000."""
    from tvclin.control.comparison import duration

    monkeypatch.setattr(duration, "_MOST_IN_A_SWING", 50)
