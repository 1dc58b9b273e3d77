"""One case of a campaign in full: its numbers, its plant and wind, and its exact response."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.answers.campaign.cases import batch, draw_case, evaluate
from tvclin.answers.campaign.dispersions import UNITS_OF
from tvclin.answers.campaign.outputs import columns, law_of, required_name
from tvclin.answers.campaign.plan import Campaign
from tvclin.base.documents import picked
from tvclin.base.errors import InputError, shown, whole_number
from tvclin.base.lines import Row, Table, degrees, quantities, significant
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.fly import fly
from tvclin.kernels.choice import pinned
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import FALLEN_OVER
from tvclin.linear.flexible import FlexiblePlant
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_response
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from control import TimeResponseData

_WATCHED = 20.0
"""A flight ends so long after its wind, over the fastest unstable pole."""


@dataclass(frozen=True, eq=False)
class Replay:
    """One case of a campaign.

    `inputs`: what was drawn for it [SI]. `outputs`: what was found [SI]; with the versions of the
    manifest the same bits as in the campaign. `status`: "ok", or in words what is different.
    `plant`, `wind`: its plant and wind; None where the case cannot be. `law`: what flew it, where
    the campaign flies. `flexible`: what was flown then, where the vehicle has a structure.
    """

    campaign: Campaign
    case: int
    inputs: dict[str, float]
    outputs: dict[str, float]
    status: str
    plant: Plant | None
    wind: History | None
    law: Law | None = None
    flexible: FlexiblePlant | None = None

    @property
    def dead_band(self) -> float:
        """K of `response`: the first of the campaign."""
        return self.campaign.dead_bands[0]

    @cached_property
    def required(self) -> float:
        """The deflection [rad] that is required at `dead_band` in the dynamic pressure of calm air.

        Its sign opposes the wind.
        """
        from tvclin.answers.requirement import required_deflection

        plant, wind = self._flown()
        return float(required_deflection(plant, wind, self.dead_band).deflection)

    def response(self, capability: float = 1.0, points: int = 401) -> "TimeResponseData":
        """Return the exact response to the wind and to trim until the dead band is left.

        `capability`: deflection limit over what is required, positive. With more than one the limit
        that is held for ever drives the attitude away to the other side. `points`: how many times,
        from the onset of the wind to twice its duration. `InputError` when the case cannot be, or
        needs no deflection.
        """
        plant, wind = self._flown()
        if self.required == 0.0:
            raise InputError(f"case {self.case} needs no deflection")
        deflection = trim_then_hold(
            plant, wind, capability * self.required, self.dead_band, "literal"
        )
        start, end = float(wind.onset), float(wind.end)
        return attitude_response(
            plant, deflection, wind, np.linspace(start, 2.0 * end - start, points)
        )

    @property
    def capability(self) -> float:
        """The limit over what it needs, where it is lost with the limit of the campaign; else one.

        What it needs counts the dynamic pressure met in its wind. A case that is flown by a law is
        judged by its flight.
        """
        limit, needs = self.campaign.nozzle.limit, self._needs
        if limit is None or "flight_survived" in self.outputs or not limit < needs < np.inf:
            return 1.0
        return limit / needs

    @property
    def _needs(self) -> float:
        return self.outputs.get(required_name(self.dead_band), abs(self.required))

    @property
    def fate(self) -> str:
        """What becomes of the case at the limit of the campaign, in words; empty without one."""
        limit = self.campaign.nozzle.limit
        if limit is None or self.plant is None:
            return ""
        if "flight_survived" in self.outputs:
            known = {1.0: "survives", 0.0: "lost"}
            word = known.get(self.outputs["flight_survived"], "neither survives nor is lost")
        else:
            word = "survives" if self._needs <= limit else "lost"
        return f"{word} with a limit of {np.degrees(limit):.4g} deg"

    @property
    def units(self) -> dict[str, str]:
        """Units of `inputs` and `outputs`, by name."""
        return UNITS_OF | columns(self.campaign)

    @property
    def extremes(self) -> dict[str, float]:
        """What is largest in `response` [deg], and its end [s]; nothing where there is none.

        It has as much of what it needs as the limit, where it is lost, and else all.
        """
        return _extremes(lambda: self.response(self.capability), ("attitude", "angle_of_attack"))

    @property
    def extremes_flown(self) -> dict[str, float]:
        """The same of `flown`, with the deflection."""
        return _extremes(self.flown, ("attitude", "angle_of_attack", "deflection"))

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON; units are told."""
        return picked(
            self, "case status fate inputs outputs units response=extremes flight=extremes_flown"
        )

    def tables(self) -> tuple[Table, ...]:
        """Return what was drawn, what it needs, what was flown, and the response."""
        angles = {k: v for k, v in self.outputs.items() if self.units[k] == "rad"}
        needs = {k: v for k, v in angles.items() if not k.startswith("flight_")}
        margins = {k: v for k, v in self.outputs.items() if k.startswith("margin_")}
        drawn = (
            (k, significant(f"input.{k}", v, 7, self.units.get(k, "")))
            for k, v in self.inputs.items()
        )
        part = "on the boundary"
        if self.plant is not None and self.capability < 1.0:
            part = f"with the limit, {100.0 * self.capability:.3g} percent of what it needs"
        every = (
            quantities(f"Case {self.case}: {self.fate or self.status}", drawn),
            quantities("It needs", _angles(needs)),
            quantities("Flown with the limit", _plain(self.extremes_flown)),
            quantities("Margins of the autopilot", _plain(margins)),
            quantities(f"Response {part}, K = {self.dead_band:g}", _plain(self.extremes)),
        )
        return tuple(one for one in every if one.rows)

    def flown(self) -> "TimeResponseData":
        """Return its flight with limits, at the samples of its law, until some time after its wind.

        `InputError` when the case cannot be, or the campaign flies nothing.
        """
        plant, wind = self._flown()
        if self.law is None or self.campaign.nozzle.limit is None:
            raise InputError('the campaign flies nothing: it has no output "flight"')
        hardware = self.campaign.hardware
        poles = np.real(unstable_modes(plant).poles)
        begin, rate = float(wind.onset), hardware["sample_rate"]
        end = float(wind.end) + (_WATCHED / float(poles.max()) if poles.size else 0.0)
        return fly(
            self.flexible or plant,
            self.law,
            wind,
            begin + np.arange(int(np.ceil((end - begin) * rate)) + 1) / rate,
            deflection_limit=self.campaign.nozzle.limit,
            **hardware,
        )

    def _flown(self) -> tuple[Plant, History]:
        if self.plant is None or self.wind is None:
            raise InputError(f"case {self.case} cannot be flown: {self.status}")
        return self.plant, self.wind


def _angles(found: dict[str, float]) -> Iterator[Row]:
    for name, angle in found.items():
        lost = np.isinf(angle)
        yield name, ("lost",) if lost else degrees(f"output.{name}", angle, unit="deg")


def _extremes(made: "Callable[[], TimeResponseData]", names: tuple[str, ...]) -> dict[str, float]:
    """The largest of some outputs of a response [deg], and its end [s]; nothing without one.

    It ends where the vehicle has fallen over.
    """
    try:
        response = made()
    except InputError:
        return {}
    fallen = np.flatnonzero(np.abs(response.outputs["attitude"]) > FALLEN_OVER)
    end = int(fallen[0]) if fallen.size else response.time.size - 1
    found = {
        f"largest_{name}_deg": float(np.degrees(np.abs(response.outputs[name][: end + 1]).max()))
        for name in names
    }
    return found | {"until_s": float(response.time[end])}


def _plain(found: dict[str, float]) -> Iterator[Row]:
    for name, value in found.items():
        yield name.replace("_", " "), significant(f"output.{name}", value)


def replay_case(campaign: Campaign, case: int, compiled: bool = False) -> Replay:
    """Return one case of a campaign, computed anew.

    `case`: which case. `compiled`: whether compiled kernels are used. `InputError` for a case that
    the campaign does not have.
    """
    if whole_number("case", case) >= campaign.cases:
        raise InputError(
            f"case must be below {campaign.cases}, the size of the campaign; got {shown(case)}"
        )
    with pinned(compiled):
        row = evaluate(campaign, case, 1)
    drawn = draw_case(campaign, case)
    plant: Plant | None = None
    wind: History | None = None
    law: Law | None = None
    flexible: FlexiblePlant | None = None
    if drawn.possible[0]:
        try:
            made = batch(campaign, drawn)
            plant, wind = made.one()
            flexible = made.one_flexible()
            law = law_of(campaign, made) if "flight" in campaign.outputs else None
        except InputError:  # its status says why
            pass
    found: dict[str, Any] = {name: values[0] for name, values in row.items()}
    status = str(found.pop("status"))
    del found["case"]
    inputs = {name: float(found.pop(name)) for name in drawn.values}
    return Replay(
        campaign,
        case,
        inputs,
        {k: float(v) for k, v in found.items()},
        status,
        plant,
        wind,
        law,
        flexible,
    )
