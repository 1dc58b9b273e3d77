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
