"""JSBSim without console output, with fixed integrators, and reproducible after every reset."""

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
    """Instance of JSBSim with one model, in its initial state.

    Each `run` integrates the state with the previous forces, then evaluates the forces at the new
    time: inputs of the new time are set before the call.

    `model`, `planet`: XML; without a planet it is the rotating Earth, WGS84. `initial`: properties
    below ``ic/`` and their values. `step`: step [s]. `drift`: whether the velocity changes.
    `InputError` if JSBSim is not installed.
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
        self._frozen = {"rate/translational": 0} if not drift else {}
        self._nodes = self._jsbsim.get_property_manager()
        self._jsbsim.set_dt(step)
        for name, value in initial.items():
            self._jsbsim[f"ic/{name}"] = value
        self._jsbsim.run_ic()
        self.run: Callable[[], bool] = self._jsbsim.run
        self.reset()

    def reset(self) -> None:
        """Restore the initial state with all inputs at zero, as in a new engine."""
        self._jsbsim.reset_to_initial_conditions(0)
        for name, number in {**_INTEGRATORS, **self._frozen}.items():
            self._jsbsim[f"simulation/integrator/{name}"] = number

    def reader(self, name: str) -> Callable[[], float]:
        """Return the function that reads a property."""
        return self._nodes.get_node(name).get_double_value

    def writer(self, name: str) -> Callable[[float], Any]:
        """Return the function that sets a property."""
        return self._nodes.get_node(name).set_double_value


def _loaded(model: str, planet: str | None) -> Any:
    """Return a JSBSim executive with the model and planet loaded."""
    try:
        import jsbsim
    except ImportError:
        raise missing("flights with six degrees of freedom need JSBSim", "sixdof") from None
    base: Any = jsbsim.FGJSBBase
    base().debug_lvl = 0  # or it writes a page for every engine
    with TemporaryDirectory() as folder:
        aircraft = Path(folder) / "aircraft" / "vehicle"
        aircraft.mkdir(parents=True)
        (aircraft / "vehicle.xml").write_text(model)
        engine = jsbsim.FGFDMExec(folder)
        if planet is not None:
            (Path(folder) / "planet.xml").write_text(planet)
            engine.load_planet(str(Path(folder) / "planet.xml"), False)
        engine.load_model("vehicle")
    return engine
