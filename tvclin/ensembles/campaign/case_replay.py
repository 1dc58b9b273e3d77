"""A case of a campaign in full: its inputs and outputs, plant, wind and exact response."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import InputError, one_of, shown, whole_number
from tvclin.base.lines import Row, Table, degrees, quantities, significant
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.ensembles.campaign.campaign_plan import Campaign
from tvclin.ensembles.campaign.cases import batch, draw_cases, evaluate
from tvclin.ensembles.campaign.outputs import (
    Batch,
    columns,
    flights_along,
    law_of,
    limits_along,
    required_name,
    shares_of,
)
from tvclin.ensembles.dispersions import UNITS_OF
from tvclin.flights.closed_loop.fly import fly
from tvclin.flights.closed_loop.fly_along import FlightAlong, sampled_outputs
from tvclin.kernels.choice import pinned
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import MAX_SHOWN_ATTITUDE
from tvclin.linear.modes import unstable_modes
from tvclin.linear.response import attitude_response
from tvclin.requirement.nominal_requirement import required_deflection
from tvclin.vehicle.coefficients import BOTH

if TYPE_CHECKING:
    from control import TimeResponseData

_FLOWN_TIME_CONSTANTS = 20.0
"""Duration of a flight after its wind, in time constants of the fastest unstable pole."""


@dataclass(frozen=True, eq=False)
class ReplayedPlane:
    """A case in a plane.

    `batch`: its plant and wind. `law`: the law of its flight; None where nothing is flown. `share`:
    the fraction of the limit that its flight has. `dead_band`: K of the required deflection.
    """

    batch: Batch
    law: Law | None
    share: float
    dead_band: float

    @cached_property
    def required(self) -> float:
        """Required deflection [rad] at nominal dynamic pressure; its sign opposes the wind."""
        batch = self.batch
        return float(required_deflection(batch.plant, batch.wind, self.dead_band).deflection)


@dataclass(frozen=True, eq=False)
class Replay:
    """A case of a campaign.

    `inputs`: its dispersed parameters [SI]. `outputs`: its answers [SI]; with the versions of the
    manifest the same bits as in the campaign. `status`: "ok", or in words why it has no answer.
    `planes`: the case in each plane that is judged and has wind; empty where the case is
    impossible. Methods with a `plane` take the plane of the campaign by default.
    """

    campaign: Campaign
    case: int
    inputs: dict[str, float]
    outputs: dict[str, float]
    status: str
    planes: dict[str, ReplayedPlane]

    @property
    def dead_band(self) -> float:
        """Dead band K of `required` and `response`: the first of the campaign."""
        return self.campaign.dead_bands[0]

    @property
    def required(self) -> float:
        """Required deflection [rad] at `dead_band`, at nominal dynamic pressure.

        It is in the plane of the campaign; its sign opposes the wind.
        """
        return self._plane("").required  # empty: the campaign's plane

    def response(
        self, capability: float = 1.0, points: int = 401, plane: str = ""
    ) -> "TimeResponseData":
        """Return the exact response to the wind and to trim, with the limit from the switch on.

        The switch is the exit of the dead band. `capability`: deflection limit normalised by the
        required deflection, positive; above 1 the constant limit drives the attitude away in the
        opposite direction. `points`: number of times, from the onset of the wind to twice its
        duration. `plane`: pitch or yaw, empty for the campaign's. `InputError` when the case
        is impossible, or requires no deflection.
        """
        replayed = self._plane(plane)
        batch, limit = replayed.batch, capability * replayed.required
        if replayed.required == 0.0:
            raise InputError(f"case {self.case} requires no deflection")
        deflection = trim_then_hold(batch.plant, batch.wind, limit, self.dead_band, "literal")
        start, end = float(batch.wind.onset), float(batch.wind.end)
        return attitude_response(
            batch.plant, deflection, batch.wind, np.linspace(start, 2.0 * end - start, points)
        )

    @property
    def capability(self) -> float:
        """Ratio of the limit of the campaign to the requirement where the limit is smaller; else 1.

        With it the response of the case is drawn. The requirement is at the dynamic pressure
        encountered in its wind. A case that is flown by a law is judged by its flight, and has the
        ratio 1.
        """
        limit, required = self.campaign.nozzle.limit, self._required_encountered
        if limit is None or "flight_survived" in self.outputs or not limit < required < np.inf:
            return 1.0
        return limit / required

    @property
    def _required_encountered(self) -> float:
        """Required deflection [rad], positive, at `dead_band` and encountered dynamic pressure.

        It is the column of the campaign, if there is one. Else it is computed where both planes are
        judged, and in a single plane it is `required`, at nominal dynamic pressure.
        """
        column = self.outputs.get(required_name(self.dead_band))
        if column is not None or self.campaign.planes != BOTH:
            return abs(self.required) if column is None else column
        # this case alone; the default law, since the output "flight" alone may have another
        campaign = replace(self.campaign, outputs=("required",), law=AUTOPILOT)
        return float(evaluate(campaign, self.case, 1)[required_name(self.dead_band)][0])

    @property
    def fate(self) -> str:
        """Survival or loss at the limit of the campaign, in words; empty without a limit."""
        limit = self.campaign.nozzle.limit
        if limit is None or not self.planes:
            return ""
        if "flight_survived" in self.outputs:
            words = {1.0: "survives", 0.0: "lost"}
            word = words.get(self.outputs["flight_survived"], "neither survives nor is lost")
        else:
            word = "survives" if self._required_encountered <= limit else "lost"
        return f"{word} with a limit of {np.degrees(limit):.4g} deg"

    @property
    def units(self) -> dict[str, str]:
        """Units of `inputs` and `outputs`, by name."""
        return UNITS_OF | columns(self.campaign)

    @property
    def extremes(self) -> dict[str, float]:
        """Largest angles in `response` [deg], and its end [s], by name; empty without a response.

        The response has the limit of the campaign where the case requires more, and else the
        required one (`capability`: its ratio to that). With two planes the names begin with the
        plane.
        """
        return self._extremes(
            lambda plane: self.response(self.capability, plane=plane),
            ("attitude", "angle_of_attack"),
        )

    @property
    def extremes_flown(self) -> dict[str, float]:
        """Largest angles in `flown` [deg], with the deflection, and its end [s], by name.

        Along a whole flight those in `flown_along`, of the worse direction of the wind.
        """
        names = ("attitude", "angle_of_attack", "deflection")
        if self.campaign.along is None:
            return self._extremes(self.flown, names)
        if not self.planes:  # an impossible case
            return {}
        flown = self.flown_along()
        peaks = {}
        for name in names:
            sizes = [abs(flight.largest(name).value) for flight in flown]  # [rad]
            peaks[f"largest_{name}_deg"] = float(np.degrees(max(sizes)))
        return peaks | {"until_s": float(flown[0].times[-1])}

    def flown_along(self) -> tuple[FlightAlong, ...]:
        """Return the flights along the whole flight, one for each possible direction of the wind.

        `InputError` when the case is impossible, or the campaign flies a frozen vehicle.
        """
        if self.campaign.along is None:
            raise InputError("the campaign flies no whole flight: give it along")
        # the batch of the campaign's own plane, "", holds this one case, of index 0
        flights = flights_along(self.campaign, self._plane("").batch, 0)
        return tuple(sampled_outputs(flights, *limits_along(self.campaign)))

    def _extremes(
        self, response_in: "Callable[[str], TimeResponseData]", names: tuple[str, ...]
    ) -> dict[str, float]:
        """Return the largest angles [deg] of responses in all planes, and end times [s], by name.

        A response ends where its attitude is beyond `MAX_SHOWN_ATTITUDE`. In two planes the names
        begin with the plane. `response_in`: function from a plane to the response. `names`: names
        of the angles.
        """
        extremes: dict[str, float] = {}
        for plane in self.planes:
            prefix = f"{plane}_" if len(self.planes) > 1 else ""
            with suppress(InputError):  # no response in this plane
                response = response_in(plane)
                # beyond this attitude the linear response has no meaning
                beyond = np.abs(response.outputs["attitude"]) > MAX_SHOWN_ATTITUDE
                end = int(np.argmax(beyond)) if beyond.any() else response.time.size - 1
                for name in names:
                    largest = np.abs(response.outputs[name][: end + 1]).max()
                    extremes[f"{prefix}largest_{name}_deg"] = float(np.degrees(largest))
                extremes[f"{prefix}until_s"] = float(response.time[end])
        return extremes

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, with units by name."""
        names = ("case", "status", "fate", "inputs", "outputs", "units")
        return {name: getattr(self, name) for name in names} | {
            "response": self.extremes,
            "flight": self.extremes_flown,
        }

    def tables(self) -> tuple[Table, ...]:
        """Return the tables of inputs, required deflections, flight, margins and response."""
        angles = {k: v for k, v in self.outputs.items() if self.units[k] == "rad"}
        required = {k: v for k, v in angles.items() if not k.startswith("flight_")}
        margins = {k: v for k, v in self.outputs.items() if k.startswith("margin_")}
        drawn = (
            (k, significant(f"input.{k}", v, 7, self.units.get(k, "")))
            for k, v in self.inputs.items()
        )
        angle_rows = (  # an infinite angle is of a lost flight
            (k, ("lost",) if np.isinf(v) else degrees(f"output.{k}", v, unit="deg"))
            for k, v in required.items()
        )
        # `capability`: limit of the response over the requirement, one being the boundary
        reference = "on the boundary"
        if self.planes and self.capability < 1.0:
            reference = f"with the limit, {100.0 * self.capability:.3g} percent of the requirement"
        tables = (
            quantities(f"Case {self.case}: {self.fate or self.status}", drawn),
            quantities("Required deflections", angle_rows),
            quantities("Flown with the limit", _plain(self.extremes_flown)),
            quantities("Margins of the autopilot", _plain(margins)),
            quantities(f"Response {reference}, K = {self.dead_band:g}", _plain(self.extremes)),
        )
        return tuple(table for table in tables if table.rows)

    def flown(self, plane: str = "") -> "TimeResponseData":
        """Return the flight with limits, at the samples of its law.

        It ends 20 time constants of the fastest unstable pole after the wind. `plane`: pitch, yaw,
        or empty for the campaign's. `InputError` for an impossible case, and where none is flown.
        """
        replayed = self._plane(plane)
        wind = replayed.batch.wind
        if self.campaign.along is not None:
            raise InputError("flights along a whole flight are those of flown_along")
        if replayed.law is None or self.campaign.nozzle.limit is None:
            raise InputError('the campaign flies nothing: it has no output "flight"')
        hardware = self.campaign.hardware
        poles = np.real(unstable_modes(replayed.batch.plant).poles)  # [1/s]
        begin, rate = float(wind.onset), hardware["sample_rate"]  # [s], [Hz]
        end = float(wind.end) + (_FLOWN_TIME_CONSTANTS / float(poles.max()) if poles.size else 0.0)
        samples = np.arange(int(np.ceil((end - begin) * rate)) + 1)
        return fly(
            replayed.batch.flying,  # the flexible plant, if the vehicle has a structure
            replayed.law,
            wind,
            begin + samples / rate,
            # of both planes each has a share of the limit shape
            deflection_limit=self.campaign.nozzle.limit * replayed.share,
            **hardware,
        )

    def _plane(self, plane: str) -> ReplayedPlane:
        """Return the case in a plane; `InputError` for an impossible case or another plane.

        `plane`: empty for the plane of the campaign.
        """
        if not self.planes:
            raise InputError(f"case {self.case} cannot be flown: {self.status}")
        return self.planes[one_of("plane", plane or self.campaign.plane, self.planes)]


_UNITS = ("deg", "s", "dB")
"""Units at the end of the names of largest values and margins."""


def _plain(values: dict[str, float]) -> Iterator[Row]:
    """Yield a row for each value, in the unit at the end of its name, as in "until_s"."""
    for name, value in values.items():
        label, _, unit = name.rpartition("_")
        if unit not in _UNITS:
            label, unit = name, ""
        yield label.replace("_", " "), significant(f"output.{name}", value, unit=unit)


def replay_case(campaign: Campaign, case: int, compiled: bool = False) -> Replay:
    """Return a case of a campaign, computed again.

    `case`: its number from zero. `compiled`: whether compiled kernels are used.
    """
    if whole_number("case", case) >= campaign.cases:
        raise InputError(
            f"case must be below {campaign.cases}, the size of the campaign; got {shown(case)}"
        )
    with pinned(compiled):
        row = evaluate(campaign, case, 1)
    drawn = draw_cases(campaign, case, 1)
    planes: dict[str, ReplayedPlane] = {}
    if drawn.possible[0]:
        with suppress(InputError):  # its status says why
            planes = _planes(campaign, batch(campaign, drawn))
    status = str(row.pop("status")[0])
    del row["case"]
    inputs = {name: float(row.pop(name)[0]) for name in drawn.values}
    outputs = {name: float(values[0]) for name, values in row.items()}  # the other columns
    return Replay(
        campaign=campaign, case=case, inputs=inputs, outputs=outputs, status=status, planes=planes
    )


def _planes(campaign: Campaign, batch: Batch) -> dict[str, ReplayedPlane]:
    """Return the first case of a batch of a campaign, by plane: with wind, law and limit share.

    The share is the fraction of the deflection limit that the plane has, one in a single plane; the
    law is None where the campaign flies none, or flies along a flight.
    """
    flies = "flight" in campaign.outputs and campaign.along is None
    shares = shares_of(campaign, batch) if batch.plane_batches else {}
    return {
        plane: ReplayedPlane(
            batch=in_plane.first,
            law=law_of(campaign.plane_campaigns[plane], in_plane) if flies else None,
            share=float(np.ravel(shares.get(plane, 1.0))[0]),
            dead_band=campaign.dead_bands[0],
        )
        for plane, in_plane in (batch.plane_batches or {campaign.plane: batch}).items()
    }
