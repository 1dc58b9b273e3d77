"""What a campaign has found: columns read chunk by chunk, and what they prove."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tvclin.answers.campaign.cases import nominal
from tvclin.answers.campaign.chunks import chunk_file, read_columns
from tvclin.answers.campaign.dispersions import UNITS_OF
from tvclin.answers.campaign.flights import MOTIONS
from tvclin.answers.campaign.manifest import Manifest, read_manifest
from tvclin.answers.campaign.outputs import columns
from tvclin.answers.campaign.plan import Campaign, checkpoints
from tvclin.answers.campaign.replay import Replay, replay_case
from tvclin.answers.campaign.statistics import (
    Driver,
    Quantile,
    Success,
    loss_drivers,
    quantile_bound,
    sensitivities,
    success_probability,
)
from tvclin.base.arrays import AnyArray, FloatArray, IntArray
from tvclin.base.columns import Column, Columns, Tabled
from tvclin.base.documents import picked
from tvclin.base.errors import InputError, number, one_of, path, small_angle, whole_number


@dataclass(frozen=True, eq=False)
class CampaignResults(Tabled):
    """The finished chunks of a campaign. Columns are read when they are asked for.

    Attributes
    ----------
    folder : Path
        Where the campaign lies.
    manifest : Manifest
        What it is.
    chunks : tuple of int
        Which chunks were there when this was opened.
    """

    folder: Path
    manifest: Manifest
    chunks: tuple[int, ...]

    _keys = (
        "vehicle=campaign.vehicle.name model=campaign.model cases seed=campaign.seed complete"
        " outputs"
    )

    @classmethod
    def read(cls, folder: Path) -> "CampaignResults":
        """Return what lies in a folder; see `open_campaign`."""
        folder = path("folder", folder)
        manifest = read_manifest(folder)
        every = range(manifest.campaign.chunks)
        return cls(folder, manifest, tuple(k for k in every if chunk_file(folder, k).exists()))

    @property
    def campaign(self) -> Campaign:
        """The campaign."""
        return self.manifest.campaign

    @property
    def cases(self) -> int:
        """How many cases are there."""
        return sum(self.campaign.span(k)[1] for k in self.chunks)

    @property
    def complete(self) -> bool:
        """Whether no chunk is left to do: all are there, or the answer has converged."""
        return len(self.chunks) == self.campaign.chunks or self.converged

    @property
    def converged(self) -> bool:
        """Whether the rule of the campaign says that the chunks so far suffice."""
        until, there = self.campaign.until, len(self.chunks)
        looked = there in checkpoints(self.campaign.chunks)
        if until is None or not looked or self.chunks != tuple(range(there)):
            return False
        try:
            return self.quantile().within(until)
        except InputError:  # no case has an answer yet
            return False

    @property
    def nominal(self) -> dict[str, float]:
        """The outputs without any dispersion; nothing for a wind ensemble."""
        return nominal(self.campaign)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the columns that were computed."""
        return tuple(columns(self.campaign))

    @property
    def angles(self) -> tuple[str, ...]:
        """Those of `outputs` that are angles [rad]; the first is the answer."""
        return tuple(name for name, unit in columns(self.campaign).items() if unit == "rad")

    @property
    def deflections(self) -> tuple[str, ...]:
        """Those of `angles` that are deflections, with which a limit is compared."""
        return tuple(name for name in self.angles if name not in MOTIONS)

    def column(self, name: str) -> AnyArray:
        """Return one column of all finished cases, in the order of the cases.

        Parameters
        ----------
        name : str
            "case", "status", what was dispersed, or one of `outputs`. [SI]

        Raises
        ------
        InputError
            For an unknown name, and for a chunk that is damaged or of another campaign.
        """
        return self._read([one_of("column", name, self._names)])[name]

    def _read(self, names: Sequence[str]) -> dict[str, AnyArray]:
        """Return columns by name, of all finished cases, in one pass over the chunks."""
        parts: dict[str, list[AnyArray]] = {name: [] for name in names}
        for k in self.chunks:
            columns = read_columns(self.folder, self.manifest, k)
            for name in names:
                parts[name].append(columns[name])
        return {k: np.concatenate(some) if some else np.zeros(0) for k, some in parts.items()}

    def statuses(self) -> dict[str, int]:
        """Return how many cases have each status, the most frequent first."""
        found: dict[str, int] = {}
        for k in self.chunks:
            column = read_columns(self.folder, self.manifest, k)["status"]
            for said, count in zip(*np.unique(column, return_counts=True), strict=True):
                found[str(said)] = found.get(str(said), 0) + int(count)
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    def quantile(
        self,
        output: str | None = None,
        probability: float | None = None,
        confidence: float | None = None,
    ) -> Quantile:
        """Return the value of an output that covers a part of all cases; see `quantile_bound`.

        Parameters
        ----------
        output : str, optional
            One of `angles`; the first without it.
        probability, confidence : float, optional
            Those of the campaign without them.

        Raises
        ------
        InputError
            For an unknown output, numbers outside (0, 1), and when no case has an answer.
        """
        found = self.answers(output)
        if not found.size:
            raise InputError(f"{self.folder} holds no finished case with an answer")
        return quantile_bound(found, *self._asked(probability, confidence))

    def success(
        self, limit: float | None = None, output: str | None = None, confidence: float | None = None
    ) -> Success | None:
        """Return how probable it is that a limit [rad] is sufficient; None without a limit.

        Parameters
        ----------
        limit : float, optional
            That of the campaign without it, for an output that is a deflection.
        output, confidence
            As of `quantile`.

        Raises
        ------
        InputError
            As `quantile`, and for a limit beside an output that is no deflection.
        """
        name = self._output(output)
        if name not in self.deflections:
            if limit is None:
                return None
            others = " or ".join(self.deflections)
            raise InputError(f"limit is a deflection, and {name} is none; use the output {others}")
        asked = self.campaign.nozzle.limit if limit is None else limit
        if asked is None:
            return None
        most = number("limit", asked, small_angle("a deflection"), "rad")
        found = self.answers(output)
        sure = self._asked(None, confidence)[1]
        return success_probability(int(np.sum(found <= most)), found.size, sure)

    def survival(self, confidence: float | None = None) -> Success | None:
        """Return how probable a flight survives; None where nothing was flown.

        Parameters
        ----------
        confidence : float, optional
            As of `quantile`.
        """
        return self._part_of_flights(0, confidence)

    def loss(self, confidence: float | None = None) -> Success | None:
        """Return how probable a flight is lost; None where nothing was flown.

        Parameters
        ----------
        confidence : float, optional
            As of `quantile`.
        """
        return self._part_of_flights(1, confidence)

    def _part_of_flights(self, which: int, confidence: float | None) -> Success | None:
        counts = self.flights
        if counts is None or not sum(counts):
            return None
        sure = self._asked(None, confidence)[1]
        return success_probability(counts[which], sum(counts), sure)

    @property
    def flights(self) -> tuple[int, int] | None:
        """How many flights survived and how many are lost; None where nothing was flown."""
        if "flight" not in self.campaign.outputs:
            return None
        survived = self.column("flight_survived")
        return int(np.sum(survived == 1.0)), int(np.sum(survived == 0.0))

    def loss_drivers(self) -> dict[str, Driver]:
        """Return what drives the loss of flights, over all that were flown, the strongest first.

        Nothing where nothing was flown, no flight is lost, or every one is.
        """
        if "flight" not in self.campaign.outputs:
            return {}
        drawn, survived = self._drawn_and("flight_survived")
        return loss_drivers(drawn, survived == 0.0)

    def drivers(self, output: str | None = None) -> dict[str, float]:
        """Return the rank correlation of what was dispersed with an output, the strongest first.

        A flight that is lost counts, as worse than any number.
        """
        drawn, values = self._drawn_and(self._output(output))
        return sensitivities(drawn, values) if values.size else {}

    def _drawn_and(self, output: str) -> tuple[dict[str, FloatArray], FloatArray]:
        """What was dispersed, and an output, of the cases in which that is a number."""
        found = self._read([*self.campaign.dispersions.parameters, output])
        good = ~np.isnan(found[output])
        some = {name: values[good] for name, values in found.items()}
        return some, some.pop(output)

    def convergence(self, output: str | None = None) -> tuple[Quantile, ...]:
        """Return the quantile of the first 1/16, 1/8, 1/4, 1/2 of the cases, and of all."""
        found = self.answers(output)
        sizes = sorted({max(found.size >> k, 1) for k in range(5)}) if found.size else []
        return tuple(quantile_bound(found[:n], *self._asked(None, None)) for n in sizes)

    def worst(self, count: int = 5, output: str | None = None) -> IntArray:
        """Return the numbers of the cases that need the most, the worst first."""
        most = whole_number("count", count)
        found = self._read(["case", name := self._output(output)])
        values = found[name]
        order = np.argsort(-np.nan_to_num(values, nan=-np.inf), kind="stable")[:most]
        return np.asarray(found["case"][order[~np.isnan(values[order])]])

    def replay(self, case: int) -> Replay:
        """Return one case in full; see `Replay`."""
        return replay_case(self.campaign, case, self.manifest.compiled)

    def _columns(self) -> Columns:
        units, plan = UNITS_OF | columns(self.campaign), self.campaign
        case, *others = self._names
        found = self._read(self._names)
        return Columns(
            (Column(case, found[case], ""),),
            tuple(Column(name, found[name], units.get(name, "")) for name in others),
            {
                **picked(plan, "vehicle=vehicle.name model plane seed"),
                "sha256": self.manifest.seal,
            },
        )

    def answers(self, output: str | None = None) -> FloatArray:
        """Return an output of the cases that have an answer, in the order of the cases."""
        values = self.column(self._output(output))
        return np.asarray(values[~np.isnan(values)])

    def _output(self, name: str | None) -> str:
        return self.angles[0] if name is None else one_of("output", name, self.angles)

    def _asked(self, probability: float | None, confidence: float | None) -> tuple[float, float]:
        plan = self.campaign
        return (
            plan.probability if probability is None else probability,
            plan.confidence if confidence is None else confidence,
        )

    @cached_property
    def _names(self) -> tuple[str, ...]:
        drawn = self.campaign.dispersions.parameters
        wind = ("wind",) if self.campaign.wind.count else ()
        return ("case", *drawn, *wind, *self.outputs, "status")
