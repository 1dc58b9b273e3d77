"""What every test may use: the two vehicles of Table I and the equations they obey."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import tvclin
from tests.vehicles import CONFIGURATION_I, CONFIGURATION_II
from tvclin.kernels import choice

G = 9.80665
LONGEST = 10.0
"""Seconds of flights and responses in plain Python beyond which a test waits for numba."""


def pytest_addoption(parser):
    """Let a run take a part of the tests that it selects, as `make thorough SHARES=3` does."""
    parser.addoption("--share", default="0/1", help="0/3: of the tests the first, fourth, ...")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config, items):
    """Keep the share that the options specify, of each file about as much."""
    first, each = map(int, config.getoption("--share").split("/"))
    taken = items[first::each]
    config.hook.pytest_deselected(items=[item for k, item in enumerate(items) if k % each != first])
    items[:] = taken


@pytest.fixture(autouse=not choice.available())
def _what_plain_python_can_carry(monkeypatch):
    """Skip a test whose kernels take minutes in plain Python; they are the same source with numba.

    tests/kernels holds the two against each other, and what is shorter runs here as well.
    """
    request, swiftest = [], choice.fastest

    def counted(function, seconds):
        request.append(seconds)
        if sum(request) > LONGEST:
            pytest.skip(f"needs numba: plain Python takes more than {LONGEST:g} s")
        return swiftest(function, seconds)

    monkeypatch.setattr(choice, "fastest", counted)


@pytest.fixture(scope="session", autouse=True)
def _as_into_a_file():
    """Let commands print lines of any width, whatever terminal the tests are begun in."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("COLUMNS", raising=False)
        yield


@pytest.fixture
def configuration_i():
    """Return configuration I of Table I."""
    return tvclin.Vehicle(**CONFIGURATION_I)


@pytest.fixture
def configuration_ii():
    """Return configuration II of Table I."""
    return tvclin.Vehicle(**CONFIGURATION_II)


@pytest.fixture(params=["I", "II"])
def configuration(request, configuration_i, configuration_ii):
    """Return both configurations in turn."""
    return {"I": configuration_i, "II": configuration_ii}[request.param]


@pytest.fixture
def linearised():
    """Return a function that linearises eqs (B1a) to (B1c) about the nominal flight.

    It gives A and B for the states attitude, its rate, flight path angle and V/V_n, and the
    inputs deflection and wind, by complex steps, which are exact to rounding.
    """

    def jacobian(vehicle):
        nominal = np.array([vehicle.attitude, 0.0, vehicle.attitude, 1.0, 0.0, 0.0], dtype=complex)
        columns = [
            np.imag(_planar_motion(vehicle, nominal + 1e-30j * unit)) / 1e-30 for unit in np.eye(6)
        ]
        both = np.stack(columns, axis=-1)
        return both[:, :4], both[:, 4:]

    return jacobian


@pytest.fixture(scope="session", autouse=True)
def _originals(pytestconfig):
    """Write figures with few pixels, of which no test reads one; and in a usual run save more.

    Figures are not laid out, which is half of their time, and machine code is loaded for shorter
    calls, and in commands for all of these, of which tests make thousands, and not compiled for
    their sum. Return what that replaces, for `as_users_have_it`.
    """
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    from tvclin.plots import style

    changes = [
        (ConstrainedLayoutEngine, "execute", lambda engine, figure: {}),
        (choice, "_MIN_LOADING_SECONDS", 0.0001),
        (choice, "_MIN_IMPORTING_SECONDS", 0.0),
        (choice, "_repays", lambda *_: False),
    ]
    originals = [(owner, name, getattr(owner, name)) for owner, name, _ in changes]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "_DPI", 40)
        for change in changes if pytestconfig.option.markexpr == "not thorough" else []:
            patch.setattr(*change)
        yield originals


@pytest.fixture
def as_users_have_it(_originals, monkeypatch):
    """Lay figures out, and choose machine code for the calls that are worth it."""
    for original in _originals:
        monkeypatch.setattr(*original)


@pytest.fixture(scope="module")
def no_flights():
    """Put still attitudes and one boundary in the place of the flights of figures, which cost."""
    from tvclin.flights import flown_boundary as flown_room
    from tvclin.plots.boundaries import flown_limit

    def still(vehicle, control, wind, times, **_):
        return times, np.zeros((5, np.size(times)))

    with pytest.MonkeyPatch.context() as patch:
        engines = {
            name: replace(engine, outputs=still) for name, engine in flown_room.ENGINES.items()
        }
        patch.setattr(flown_room, "ENGINES", engines)
        patch.setattr(flown_room, "flown_boundary", lambda *_, **__: SimpleNamespace(limit=0.5))
        flown_limit.cache_clear()
        yield
    flown_limit.cache_clear()


@pytest.fixture
def few_durations(monkeypatch):
    """Draw the boundaries of a page for three durations of the wind, not for 200, which cost."""
    from tvclin import plots
    from tvclin.plots import study_chart

    def few(study):
        return study_chart(study, np.array([0.02, 1.0, 3.0]) * float(study.wind.duration))

    monkeypatch.setattr(plots, "study_chart", few)


def _planar_motion(vehicle, values):
    attitude, rate, path, relative_speed, deflection, wind = values
    v, mass = vehicle, vehicle.weight / G
    lean, angle = attitude - path, attitude - path - wind
    # The thrust along the body and the control force across it; for T as slope this is T turned
    # by the deflection, to first order.
    along = (v.thrust - v.axial_force) * np.cos(lean) - v.control_force * deflection * np.sin(lean)
    across = (v.thrust - v.axial_force) * np.sin(lean) + v.control_force * deflection * np.cos(lean)
    normal = v.normal_force_slope * angle
    speed = v.velocity * relative_speed
    moment = normal * v.aerodynamic_arm - v.control_force * v.control_arm * np.sin(deflection)
    return np.array(
        [
            rate,
            moment / v.moment_of_inertia,
            (across + normal * np.cos(lean) - v.weight * np.cos(path)) / (mass * speed),
            (along - normal * np.sin(lean) - v.weight * np.sin(path)) / (mass * v.velocity),
        ]
    )


@pytest.fixture(autouse=True)
def global_state_stays_as_it_was():
    """No test, and nothing it calls, may change numpy's or python-control's settings."""
    numpy_before = np.geterr()
    yield
    assert np.geterr() == numpy_before
    if "control" in sys.modules:
        config = sys.modules["control"].config
        control_after = dict(config.defaults)
        config.reset_defaults()  # to what python-control is installed with
        assert control_after == dict(config.defaults)
