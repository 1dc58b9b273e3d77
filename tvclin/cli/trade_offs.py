"""Answers of `tvclin nozzle` in one wind: the deflection limit over rate or load, laws flown."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.lines import Table
from tvclin.boundary.limit_over_load import LoadTradeOff, load_trade_off
from tvclin.boundary.limit_over_rate import RateTradeOff, rate_trade_off
from tvclin.case.load import FlownLoad
from tvclin.cli.fly_linear import limited_law
from tvclin.cli.progress import bar, waiting
from tvclin.control.laws.registry import LAWS
from tvclin.nozzle.duty_over_flight import FlownDuty
from tvclin.nozzle.flown_trade_off import FlownTradeOff, flown_trade_offs
from tvclin.requirement.case_requirement import CaseRequirement
from tvclin.studyfile.study_plan import StudyPlan

if TYPE_CHECKING:
    from control import ControlPlot

    from tvclin.plots.curves import Curves


@dataclass(frozen=True, kw_only=True)
class TradeOffAnswer:
    """A trade-off with its flights: what is printed, drawn and written.

    `outcomes`: the outcomes of the flights, in words. `tables`: the answer; `further`: the others.
    `satisfied`: whether no limit is below its lower bound, and the flights satisfy the limits.
    """

    trade_off: RateTradeOff | LoadTradeOff
    document: dict[str, Any]
    outcomes: list[str]
    tables: tuple[Table, ...]
    further: tuple[Table, ...]
    notes: tuple[str, ...]
    satisfied: bool
    curves: "Callable[[], Curves]"
    chart: "Callable[[Curves], ControlPlot]"

    def verdict(self, required: CaseRequirement | None) -> str:
        """Return the verdict on the limit, its lower bound, the study's requirement and flights."""
        front, bound = self.trade_off, []
        if not front.beyond:
            bound = [front.bound_text, *([] if required is None else [required.see_study])]
        return "; ".join([*filter(None, [front.verdict]), *self.outcomes, *bound])


def over_rate(case: StudyPlan, title: str, names: list[str], every_law: bool) -> TradeOffAnswer:
    """Return the deflection limit over the rate limit, with the duty of laws by their names.

    `every_law`: whether laws are flown for the limit that they need at each rate limit.
    """
    from tvclin import plots

    with waiting("flying"):
        flown = [FlownDuty.of(case, name, limited_law(case, name)) for name in names]
    limit, rate_limit = case.nozzle.limit, case.nozzle.rate_limit
    with waiting("angle over rate"):
        front = rate_trade_off(case.plant.rigid, case.history, limit=limit, rate_limit=rate_limit)
    needed = _flown_limits(case) if every_law else None
    drawn, (curve, point) = needed or front, front.tables()
    flown_tables = () if needed is None else needed.tables()
    limited = limit is not None or rate_limit is not None
    return TradeOffAnswer(
        trade_off=front,
        document={"trade_off": front, "flown": flown}
        | ({} if needed is None else {"laws": needed}),
        outcomes=[f"{duty.law} flown: {duty.verdict.words}" for duty in flown],
        tables=_titled(title, (*flown_tables, curve)[0]),
        further=(
            *(flown_tables and (curve,)),
            point,
            *(table for duty in flown for table in duty.tables()),
        ),
        notes=tuple(note for result in (drawn, *flown) for note in result.notes),
        satisfied=not (limited and front.verdict)
        and all(bool(duty.verdict.satisfied) for duty in flown),
        curves=lambda: plots.rate_curves(drawn),
        chart=lambda _: plots.rate_chart(drawn, title.replace(": ", "\n")),
    )


def _flown_limits(case: StudyPlan) -> FlownTradeOff:
    """Return the limits that laws need when flown, at each rate limit."""
    laws = tuple(LAWS) if case.laws is None else case.laws.names
    with bar("boundaries") as progress:
        return flown_trade_offs({"": case}, laws=laws, progress=progress)[""]


def over_load(case: StudyPlan, title: str, names: list[str]) -> TradeOffAnswer:
    """Return the deflection limit over the load, with the largest load of laws by their names."""
    from tvclin import plots

    with waiting("flying"):
        flown = [FlownLoad.of(case, name, limited_law(case, name), case.load) for name in names]
    with waiting("angle over load"):
        front = _load_trade_off(case)
    curve, point = front.tables()
    return TradeOffAnswer(
        trade_off=front,
        document={"trade_off": front, "flown": flown},
        outcomes=[f"flown, {load.words}" for load in flown],
        tables=_titled(title, curve),
        further=(point,),
        notes=tuple(front.notes),
        satisfied=(front.limit is None or not front.verdict)
        and all(load.survives_within for load in flown),
        curves=lambda: plots.load_curves(front, flown),
        chart=lambda _: plots.load_chart(front, flown, title.replace(": ", "\n")),
    )


def _load_trade_off(case: StudyPlan) -> LoadTradeOff:
    """Return the trade-off curve of limit over load, by the load limit of a file if it has one."""
    if case.load is not None:
        return case.load.trade_off(case)
    limit, rate = case.nozzle.limit, case.nozzle.rate_limit
    fastest = np.inf if rate is None else rate
    return load_trade_off(case.plant.rigid, case.history, limit=limit, rate_limit=fastest)


def _titled(title: str, table: Table) -> tuple[Table]:
    """Return a table below the title of its case."""
    return (replace(table, caption=f"{title}\n{table.caption}"),)
