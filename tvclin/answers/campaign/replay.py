"""One case of a campaign in full: its numbers, its plant and wind, and its exact response."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.answers.campaign.batch import Batch, required_name
from tvclin.answers.campaign.cases import batch, draw_case, evaluate
from tvclin.answers.campaign.dispersions import UNITS_OF
from tvclin.answers.campaign.flights import law_of, shares_of
from tvclin.answers.campaign.outputs import columns
from tvclin.answers.campaign.plan import Campaign
from tvclin.base.documents import picked
from tvclin.base.errors import InputError, one_of, shown, whole_number
from tvclin.base.lines import Row, Table, degrees, quantities, significant
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.flights.closed_loop.fly import fly
from tvclin.kernels.choice import pinned
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import MAX_SHOWN_ATTITUDE
from tvclin.linear.modes import unstable_modes
from tvclin.linear.response import attitude_response
from tvclin.vehicle.coefficients import BOTH

if TYPE_CHECKING:
    from control import TimeResponseData

_WATCHED = 20.0
"""A flight ends so long after its wind, over the fastest unstable pole."""


@dataclass(frozen=True, eq=False)
class ReplayedPlane:
    """One case in one plane.

    `made`: its plant and wind. `law`: what flew it, where the campaign flies. `share`: the part of
    the limit that it was flown with.
    """

    made: Batch
    law: Law | None
    share: float


@dataclass(frozen=True, eq=False)
class Replay:
    """One case of a campaign.

    `inputs`: what was drawn for it [SI]. `outputs`: what was found [SI]; with the versions of the
    manifest the same bits as in the campaign. `status`: "ok", or in words what is different.
    `planes`: the case in each plane that is judged and in which its wind blows; none where it
    cannot be. Where a method takes a plane, that of the campaign is meant without one.
    """

    campaign: Campaign
    case: int
    inputs: dict[str, float]
    outputs: dict[str, float]
    status: str
    planes: dict[str, ReplayedPlane]

    @property
    def dead_band(self) -> float:
        """K of `response`: the first of the campaign."""
        return self.campaign.dead_bands[0]

    @cached_property
    def required(self) -> float:
        """The deflection [rad] that is required at `dead_band` at nominal dynamic pressure.

        In the plane of the campaign; its sign opposes the wind.
        """
        return self._required("")

    def _required(self, plane: str) -> float:
        from tvclin.answers.requirement import required_deflection

        made = self._plane(plane).made
        return float(required_deflection(made.plant, made.wind, self.dead_band).deflection)

    def response(
        self, capability: float = 1.0, points: int = 401, plane: str = ""
    ) -> "TimeResponseData":
        """Return the exact response to the wind and to trim until the dead band is left.

        `capability`: deflection limit over what is required, positive. With more than one the limit
        that is held for ever drives the attitude away to the other side. `points`: how many times,
        from the onset of the wind to twice its duration. `InputError` when the case cannot be, or
        needs no deflection.
        """
        made = self._plane(plane).made
        required = self._required(plane) if plane else self.required
        if required == 0.0:
            raise InputError(f"case {self.case} needs no deflection")
        deflection = trim_then_hold(
            made.plant, made.wind, capability * required, self.dead_band, "literal"
        )
        start, end = float(made.wind.onset), float(made.wind.end)
        return attitude_response(
            made.plant, deflection, made.wind, np.linspace(start, 2.0 * end - start, points)
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
        known = self.outputs.get(required_name(self.dead_band))
        if known is not None or self.campaign.planes != BOTH:
            return abs(self.required) if known is None else known
        asked = replace(self.campaign, outputs=("required",), law=AUTOPILOT)
        return float(evaluate(asked, self.case, 1)[required_name(self.dead_band)][0])

    @property
    def fate(self) -> str:
        """What becomes of the case at the limit of the campaign, in words; empty without one."""
        limit = self.campaign.nozzle.limit
        if limit is None or not self.planes:
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

        It has as much of what it needs as the limit, where it is lost, and else all. Of two planes
        the names say which.
        """
        return self._extremes(
            lambda plane: self.response(self.capability, plane=plane),
            ("attitude", "angle_of_attack"),
        )

    @property
    def extremes_flown(self) -> dict[str, float]:
        """The same of `flown`, with the deflection."""
        return self._extremes(self.flown, ("attitude", "angle_of_attack", "deflection"))

    def _extremes(
        self, made: "Callable[[str], TimeResponseData]", names: tuple[str, ...]
    ) -> dict[str, float]:
        every = {plane: _extremes(partial(made, plane), names) for plane in self.planes}
        if len(every) < 2:
            return next(iter(every.values()), {})
        return {f"{plane}_{k}": v for plane, found in every.items() for k, v in found.items()}

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
        if self.planes and self.capability < 1.0:
            part = f"with the limit, {100.0 * self.capability:.3g} percent of what it needs"
        every = (
            quantities(f"Case {self.case}: {self.fate or self.status}", drawn),
            quantities("It needs", _angles(needs)),
            quantities("Flown with the limit", _plain(self.extremes_flown)),
            quantities("Margins of the autopilot", _plain(margins)),
            quantities(f"Response {part}, K = {self.dead_band:g}", _plain(self.extremes)),
        )
        return tuple(one for one in every if one.rows)

    def flown(self, plane: str = "") -> "TimeResponseData":
        """Return its flight with limits, at the samples of its law, until some time after its wind.

        `InputError` when the case cannot be, or the campaign flies nothing.
        """
        one = self._plane(plane)
        wind = one.made.wind
        if one.law is None or self.campaign.nozzle.limit is None:
            raise InputError('the campaign flies nothing: it has no output "flight"')
        hardware = self.campaign.hardware
        poles = np.real(unstable_modes(one.made.plant).poles)
        begin, rate = float(wind.onset), hardware["sample_rate"]
        end = float(wind.end) + (_WATCHED / float(poles.max()) if poles.size else 0.0)
        return fly(
            one.made.flying,
            one.law,
            wind,
            begin + np.arange(int(np.ceil((end - begin) * rate)) + 1) / rate,
            deflection_limit=self.campaign.nozzle.limit * one.share,
            **hardware,
        )

    def _plane(self, plane: str) -> ReplayedPlane:
        if not self.planes:
            raise InputError(f"case {self.case} cannot be flown: {self.status}")
        return self.planes[one_of("plane", plane or self.campaign.plane, self.planes)]


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
    fallen = np.flatnonzero(np.abs(response.outputs["attitude"]) > MAX_SHOWN_ATTITUDE)
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
    """Return one case of a campaign, computed anew, by compiled kernels or without them."""
    if whole_number("case", case) >= campaign.cases:
        raise InputError(
            f"case must be below {campaign.cases}, the size of the campaign; got {shown(case)}"
        )
    with pinned(compiled):
        row = evaluate(campaign, case, 1)
    drawn = draw_case(campaign, case)
    planes: dict[str, ReplayedPlane] = {}
    if drawn.possible[0]:
        with suppress(InputError):  # its status says why
            planes = _planes(campaign, batch(campaign, drawn))
    status = str(row.pop("status")[0])
    del row["case"]
    inputs = {name: float(row.pop(name)[0]) for name in drawn.values}
    outputs = {name: float(values[0]) for name, values in row.items()}
    return Replay(campaign, case, inputs, outputs, status, planes)


def _planes(campaign: Campaign, made: Batch) -> dict[str, ReplayedPlane]:
    """The first case of a batch in each plane."""
    flies = "flight" in campaign.outputs
    shares = shares_of(campaign, made) if made.parts else {}
    return {
        plane: ReplayedPlane(
            one.first,
            law_of(campaign.parts[plane], one) if flies else None,
            float(np.ravel(shares.get(plane, 1.0))[0]),
        )
        for plane, one in (made.parts or {campaign.plane: made}).items()
    }
