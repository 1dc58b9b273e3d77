"""JSBSim, silent, with the integrators that hold its accuracy, and the same after every reset."""

from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tvclin.base.errors import missing

_INTEGRATORS = {
    "rate/rotational": 3,
    "rate/translational": 3,
    "position/rotational": 4,
    "position/translational": 4,
}
"""Adams-Bashforth of second order for rates and of third order for positions."""


class Engine:
    """One instance of JSBSim with one model, at rest in its initial state.

    Each `run` moves the state with what acted before, then evaluates what acts at the new time:
    inputs of the new time are set before the call.

    `model`, `planet`: XML; without a planet it is the rotating Earth, WGS84. `initial`: properties
    below ``ic/`` and their values. `step`: in s. `drift`: whether the velocity changes.
    `InputError` when JSBSim is not installed.
    """

    def __init__(
        self,
        model: str,
        initial: Mapping[str, float],
        step: float,
        *,
        planet: str | None = None,
        drift: bool = True,
    ) -> None:
        self._jsbsim = _loaded(model, planet)
        self._kept = {"rate/translational": 0} if not drift else {}
        self._nodes = self._jsbsim.get_property_manager()
        self._jsbsim.set_dt(step)
        for name, value in initial.items():
            self._jsbsim[f"ic/{name}"] = value
        self._jsbsim.run_ic()
        self.run: Callable[[], bool] = self._jsbsim.run
        self.reset()

    def reset(self) -> None:
        """Go back to the initial state, all inputs at zero, as if the engine were new."""
        self._jsbsim.reset_to_initial_conditions(0)
        for name, number in {**_INTEGRATORS, **self._kept}.items():
            self._jsbsim[f"simulation/integrator/{name}"] = number

    def reader(self, name: str) -> Callable[[], float]:
        """Return the function that reads a property."""
        return self._nodes.get_node(name).get_double_value

    def writer(self, name: str) -> Callable[[float], Any]:
        """Return the function that sets a property."""
        return self._nodes.get_node(name).set_double_value


def _loaded(model: str, planet: str | None) -> Any:
    try:
        import jsbsim
    except ImportError:
        raise missing("flights with six degrees of freedom need JSBSim", "sixdof") from None
    base: Any = jsbsim.FGJSBBase
    base().debug_lvl = 0  # or it writes a page for every engine
    with TemporaryDirectory() as folder:
        place = Path(folder) / "aircraft" / "vehicle"
        place.mkdir(parents=True)
        (place / "vehicle.xml").write_text(model)
        engine = jsbsim.FGFDMExec(folder)
        if planet is not None:
            (Path(folder) / "planet.xml").write_text(planet)
            engine.load_planet(str(Path(folder) / "planet.xml"), False)
        engine.load_model("vehicle")
    return engine
