"""Results of a campaign: columns read chunk by chunk, and their statistics."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IntArray
from tvclin.base.cards import Column, Columns, Tabled
from tvclin.base.errors import InputError, number, one_of, path, small_angle, whole_number
from tvclin.base.fields import Field, derived, specs
from tvclin.ensembles import statistics
from tvclin.ensembles.campaign.campaign_plan import Campaign, checkpoints
from tvclin.ensembles.campaign.case_replay import Replay, replay_case
from tvclin.ensembles.campaign.cases import UNDECIDED, evaluate, nominal
from tvclin.ensembles.campaign.folder import (
    Manifest,
    chunk_file,
    new_manifest,
    read_columns,
    read_manifest,
)
from tvclin.ensembles.campaign.outputs import MOTIONS, columns
from tvclin.ensembles.dispersions import UNITS_OF

_MAX_CASES_IN_MEMORY = 1_000_000
"""Largest number of cases of a campaign without a folder."""


@dataclass(frozen=True, eq=False)
class CampaignResults(Tabled):
    """The finished chunks of a campaign; a column is read when it is used.

    Attributes
    ----------
    folder : Path
        The folder of the campaign.
    manifest : Manifest
        Its manifest.
    chunks : tuple of int
        Numbers of the chunks that were finished when the folder was opened.
    """

    folder: Path
    manifest: Manifest = field(
        metadata=specs(
            Field("vehicle", of="campaign.vehicle.name"),
            Field("model", of="campaign.model"),
            Field("seed", of="campaign.seed"),
        )
    )
    chunks: tuple[int, ...]

    @classmethod
    def read(cls, folder: Path) -> "CampaignResults":
        """Return the results of the campaign in a folder, of all chunks that are finished."""
        folder = path("folder", folder)
        manifest = read_manifest(folder)
        chunks = range(manifest.campaign.chunks)
        return cls(folder, manifest, tuple(k for k in chunks if chunk_file(folder, k).exists()))

    @property
    def campaign(self) -> Campaign:
        """The plan of the campaign: dispersions, winds, outputs and number of cases."""
        return self.manifest.campaign

    @property
    @derived()
    def cases(self) -> int:
        """Number of cases in the finished chunks."""
        return sum(count for _, count in map(self.campaign.span, self.chunks))

    @property
    @derived()
    def complete(self) -> bool:
        """Whether the campaign has ended: all chunks are finished, or the answer has converged."""
        return len(self.chunks) == self.campaign.chunks or self.converged

    @property
    def converged(self) -> bool:
        """Whether the answer has converged, so that the campaign has ended.

        It has if the bounds of the quantile differ by at most the fraction `until` of it, after one
        of the numbers of chunks at which this is checked, with none missing before.
        """
        until, finished = self.campaign.until, len(self.chunks)
        checked = finished in checkpoints(self.campaign.chunks)
        if until is None or not checked or self.chunks != tuple(range(finished)):
            return False
        try:
            return self.quantile().within(until)
        except InputError:  # no case has an answer yet
            return False

    @property
    def nominal(self) -> dict[str, float]:
        """The outputs of the nominal case [SI] by name; empty for a wind ensemble."""
        return nominal(self.campaign)

    @property
    @derived()
    def outputs(self) -> tuple[str, ...]:
        """Names of the columns of all outputs of the campaign, in their order."""
        return tuple(columns(self.campaign))

    @property
    def angles(self) -> tuple[str, ...]:
        """Names of `outputs` that are angles [rad]; the first is the answer."""
        return tuple(name for name, unit in columns(self.campaign).items() if unit == "rad")

    @property
    def deflections(self) -> tuple[str, ...]:
        """Names of `angles` that are deflections, with which a limit is compared."""
        return tuple(name for name in self.angles if name not in MOTIONS)

    def column(self, name: str) -> AnyArray:
        """Return a column of all finished cases, ``(n,)``, in the order of the cases.

        Parameters
        ----------
        name : str
            "case", "status", a dispersed parameter, or a name of `outputs`. [SI]

        Raises
        ------
        InputError
            For an unknown name, and for a chunk that is damaged or of another campaign.
        """
        return self._read([one_of("column", name, self._names)])[name]

    def _read(self, names: Sequence[str]) -> dict[str, AnyArray]:
        """Return the columns with these names, ``(n,)`` over all n finished cases, by name."""
        values: dict[str, list[AnyArray]] = {name: [] for name in names}
        for k in self.chunks:
            columns = self._chunk(k)
            for name in names:
                values[name].append(columns[name])
        return {k: np.concatenate(v) if v else np.zeros(0) for k, v in values.items()}

    def _chunk(self, chunk: int) -> dict[str, AnyArray]:
        """Return the columns of the finished chunk `chunk`, its number, by name, ``(n,)`` each."""
        return read_columns(self.folder, self.manifest, chunk)

    def statuses(self) -> dict[str, int]:
        """Return the number of finished cases by text of their status, the most frequent first."""
        counts: dict[str, int] = {}
        for k in self.chunks:
            column = self._chunk(k)["status"]
            for status, count in zip(*np.unique(column, return_counts=True), strict=True):
                counts[str(status)] = counts.get(str(status), 0) + int(count)
        return dict(sorted(counts.items(), key=lambda item: -item[1]))

    def quantile(
        self,
        output: str | None = None,
        probability: float | None = None,
        confidence: float | None = None,
    ) -> statistics.Quantile:
        """Return the quantile [rad] of an output over all cases; see `quantile_bound`.

        Parameters
        ----------
        output : str, optional
            A name of `angles`; by default the first.
        probability, confidence : float, optional
            Probability and confidence; by default the values of the campaign.

        Raises
        ------
        InputError
            For an unknown output, numbers outside (0, 1), and when no case has an answer.
        """
        answers = self.answers(output)
        if not answers.size:
            raise InputError("there is no finished case with an answer")
        return statistics.quantile_bound(answers, *self._level(probability, confidence))

    def success(
        self, limit: float | None = None, output: str | None = None, confidence: float | None = None
    ) -> statistics.Success | None:
        """Return the probability that a limit [rad] is sufficient; None without a limit.

        Parameters
        ----------
        limit : float, optional
            By default the limit of the campaign, for an output that is a deflection.
        output : str, optional
            A name of `deflections`; by default the first angle.
        confidence : float, optional
            Confidence of the interval; by default the value of the campaign.

        Raises
        ------
        InputError
            Same exceptions as `quantile`; also for a limit with an output that is no deflection.
        """
        name = self._output(output)
        if name not in self.deflections:
            if limit is None:
                return None
            others = " or ".join(self.deflections)
            raise InputError(f"limit is a deflection, and {name} is none; use the output {others}")
        limit = self.campaign.nozzle.limit if limit is None else limit
        if limit is None:
            return None
        limit = number("limit", limit, small_angle("a deflection"), "rad")
        required = self.answers(output)  # [rad], of the cases in which it is known
        _, confidence = self._level(probability=None, confidence=confidence)
        return statistics.success_probability(
            int(np.sum(required <= limit)), required.size, confidence
        )

    def survival(self, confidence: float | None = None) -> statistics.Success | None:
        """Return the probability that a flight survives; None where nothing was flown.

        `confidence`: of its interval, by default the campaign's.
        """
        return self._flight_probability(lost=False, confidence=confidence)

    def loss(self, confidence: float | None = None) -> statistics.Success | None:
        """Return the probability that a flight is lost; same parameters as `survival`."""
        return self._flight_probability(lost=True, confidence=confidence)

    def _flight_probability(
        self, lost: bool, confidence: float | None
    ) -> statistics.Success | None:
        """Return the probability that a flight is lost, or that it survives.

        Undecided flights count among all. `lost`: true for loss. `confidence`: of its
        interval, by default the campaign's. None without flights.
        """
        if self.flights is None:
            return None
        survived, losses = self.flights
        total = survived + losses + self.statuses().get(UNDECIDED, 0)
        _, confidence = self._level(probability=None, confidence=confidence)
        count = losses if lost else survived
        return statistics.success_probability(count, total, confidence) if total else None

    @property
    def flights(self) -> tuple[int, int] | None:
        """Numbers of flights that survived and that are lost; None if the campaign flies none."""
        if "flight" not in self.campaign.outputs:
            return None
        survived = self.column("flight_survived")
        return int(np.sum(survived == 1.0)), int(np.sum(survived == 0.0))

    def loss_drivers(self) -> dict[str, statistics.Driver]:
        """Return the drivers of the loss of flights by dispersed parameter, the strongest first.

        A driver is the correlation of a parameter with the loss, and its confidence. Empty where
        nothing was flown, no flight is lost, or every flight is lost.
        """
        if "flight" not in self.campaign.outputs:
            return {}
        dispersed, survived = self._dispersed_and("flight_survived")  # 1 survived, 0 lost
        return statistics.loss_drivers(dispersed, survived == 0.0)

    def drivers(self, output: str | None = None) -> dict[str, float]:
        """Return the rank correlation of dispersed parameters with an output, the strongest first.

        `output`: a name of `angles`, by default the first. A lost flight counts as worse than any
        number.
        """
        dispersed, values = self._dispersed_and(self._output(output))
        return statistics.sensitivities(dispersed, values) if values.size else {}

    def _dispersed_and(self, output: str) -> tuple[dict[str, FloatArray], FloatArray]:
        """Return dispersed parameters by name, and an output, of cases where that is no NaN.

        `output`: name of its column. Arrays are ``(n,)``, in SI units.
        """
        columns = self._read([*self.campaign.dispersions.parameters, output])
        answered = ~np.isnan(columns[output])
        dispersed = {name: column[answered] for name, column in columns.items()}
        values = dispersed.pop(output)
        return dispersed, values

    def convergence(
        self,
        output: str | None = None,
        probability: float | None = None,
        confidence: float | None = None,
    ) -> tuple[statistics.Quantile, ...]:
        """Return the quantiles of the first 1/16, 1/8, 1/4, 1/2 of the cases, and of all cases.

        `output`: a name of `angles`, by default the first. `probability`, `confidence`: of the
        quantiles and of their bounds; by default the campaign's.
        """
        answers = self.answers(output)
        # numbers of cases, halved four times
        sizes = sorted({max(answers.size // 2**k, 1) for k in range(5)}) if answers.size else []
        level = self._level(probability, confidence)
        return tuple(statistics.quantile_bound(answers[:n], *level) for n in sizes)

    def worst(self, count: int = 5, output: str | None = None) -> IntArray:
        """Return the indices of the cases that require most, ``(count,)``, the worst first.

        `output`: the angle that counts, a name of `angles`, by default the first.
        """
        count = whole_number("count", count)
        columns = self._read(["case", name := self._output(output)])
        values = columns[name]
        order = np.argsort(-np.nan_to_num(values, nan=-np.inf), kind="stable")[:count]
        return np.asarray(columns["case"][order[~np.isnan(values[order])]])

    def replay(self, case: int) -> Replay:
        """Return a case in full, computed again: inputs, outputs, response and flight."""
        return replay_case(self.campaign, case, self.manifest.compiled)

    def _columns(self) -> Columns:
        """Return all columns over the cases, with units, and what identifies the campaign."""
        units, plan = UNITS_OF | columns(self.campaign), self.campaign
        case, *others = self._names
        values = self._read(self._names)
        return Columns(
            (Column(case, values[case], ""),),
            tuple(Column(name, values[name], units.get(name, "")) for name in others),
            {
                "vehicle": plan.vehicle.name,
                "model": plan.model,
                "plane": plan.plane,
                "seed": plan.seed,
                "sha256": self.manifest.seal,
            },
        )

    def answers(self, output: str | None = None) -> FloatArray:
        """Return an output [rad] of the n cases that have an answer, ``(n,)``, in their order.

        `output`: a name of `angles`, by default the first.
        """
        values = self.column(self._output(output))
        return np.asarray(values[~np.isnan(values)])

    def _output(self, name: str | None) -> str:
        """Return `name` if it is one of `angles`, the first of them for None; else `InputError`."""
        return self.angles[0] if name is None else one_of("output", name, self.angles)

    def _level(self, probability: float | None, confidence: float | None) -> tuple[float, float]:
        """Return probability and confidence level of a quantile; None takes the campaign's."""
        plan = self.campaign
        return (
            plan.probability if probability is None else probability,
            plan.confidence if confidence is None else confidence,
        )

    @cached_property
    def _names(self) -> tuple[str, ...]:
        """Names of all columns: case number, dispersed parameters, wind, outputs, status."""
        drawn = self.campaign.dispersions.parameters
        wind = ("wind",) if self.campaign.wind.count else ()
        return ("case", *drawn, *wind, *self.outputs, "status")


@dataclass(frozen=True, eq=False)
class ResultsInMemory(CampaignResults):
    """The finished chunks of a campaign without a folder.

    `columns`: the columns of each chunk by name, see `evaluate`.
    """

    columns: tuple[dict[str, AnyArray], ...] = ()

    @classmethod
    def of(
        cls, campaign: Campaign, progress: Callable[[int, int], None] | None = None
    ) -> "ResultsInMemory":
        """Return all cases of a campaign, or those up to its convergence.

        `progress`: called with the numbers of finished and of all cases.
        """
        if campaign.cases > _MAX_CASES_IN_MEMORY:
            raise InputError(
                f"more than {_MAX_CASES_IN_MEMORY} cases need a folder, -o results; got"
                f" {campaign.cases}"
            )
        nominal(campaign)  # raises for a campaign that cannot be computed, before the many cases
        results = cls(Path(), new_manifest(campaign), ())
        for k in range(campaign.chunks):
            columns = (*results.columns, evaluate(campaign, *campaign.span(k)))  # one by chunk
            results = replace(results, chunks=tuple(range(k + 1)), columns=columns)
            if progress is not None:
                progress(results.cases, campaign.cases)
            if results.converged:
                break
        return results

    def _chunk(self, chunk: int) -> dict[str, AnyArray]:
        """Return the columns of a chunk by name, ``(n,)`` each."""
        return self.columns[chunk]
