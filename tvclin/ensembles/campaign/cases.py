"""Cases of a campaign: from an index to random numbers, vehicle, wind and outputs.

A case has the same bits whichever cases are computed with it.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.errors import InputError
from tvclin.boundary.limit import leading_pole
from tvclin.control.autopilot.detuning import structure_with_mode_factors
from tvclin.control.autopilot.feedback import GAINS
from tvclin.ensembles.campaign.campaign_plan import Campaign, mode_factors
from tvclin.ensembles.campaign.outputs import (
    COLUMNS,
    REGISTRY,
    REQUIRED,
    Batch,
    columns,
    compute,
    plane_columns,
)
from tvclin.ensembles.dispersions import WIND, Dispersed, draw, is_mode_factor
from tvclin.linear.flexible import FlexiblePlant
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant, flexible_model
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind, WindEnsemble
from tvclin.winds.wind_angles import BEYOND_LINEAR, within_linear

_FLOWN_PEAKS = {
    column
    for name in COLUMNS.keys() - {"flight_survived"}
    for column in (name, *plane_columns(name).values())
}
"""Names of the columns of largest values of flights."""
_MAX_BATCH_CASES = 4096
"""Largest number of cases that are computed in one batch."""
_CASE_ERRORS = (InputError, ArithmeticError, np.linalg.LinAlgError, RuntimeError)
"""Exceptions that a case can raise: it is refused, overflows, is singular, or is not solved."""
OK, IMPOSSIBLE, STABLE = "ok", "impossible vehicle or wind", "no unstable pole"
PAIRED = "two unstable poles are a pair or equal: the dead band must never be left"
BEYOND = f"wind beyond linear aerodynamics, counted as not survived; {BEYOND_LINEAR}"
ENCOUNTERED_UNKNOWN = (
    "wind angle or dynamic pressure encountered not known, counted as not survived"
)
UNKNOWN_WIND = "wind not known throughout, counted as not survived"
UNDECIDED = (
    "undecided, counted as not survived; the flight was not settled when it or its wind ended, or"
    " the wind is not known throughout"
)
NOT_KNOWN = (BEYOND, ENCOUNTERED_UNKNOWN, UNKNOWN_WIND, UNDECIDED)
"""Statuses of cases that no deflection is known to survive: their requirement is infinite."""


def draw_cases(campaign: Campaign, first: int, count: int) -> Dispersed:
    """Return the dispersed values [SI] of cases of a campaign, ``(count,)`` each.

    `first`, `count`: number of the first case, and how many.
    """
    parameters = len(campaign.dispersions.distributions)
    # a random number for each parameter, and one that chooses the wind of an ensemble
    dimension = parameters + (1 if campaign.wind.count else 0)
    method, size = campaign.method, campaign.cases
    rows = draw(campaign.seed, first, count, dimension, method=method, size=size)
    cases = campaign.dispersions.apply(campaign.nominal, rows[:, :parameters])
    if isinstance(campaign.wind, WindEnsemble):
        cases.values["wind"] = campaign.wind.chosen(rows[:, parameters])  # by the last number
    return cases


def evaluate(campaign: Campaign, first: int, count: int) -> dict[str, AnyArray]:
    """Return the columns of the cases `first` to `first + count - 1`, ``(count,)`` each.

    The columns are "case", the dispersed parameters [SI], the outputs of the campaign, and
    "status".
    """
    end = first + count
    batches = [
        _columns(campaign, at, min(_MAX_BATCH_CASES, end - at))
        for at in range(first, end, _MAX_BATCH_CASES)
    ]
    return {k: np.concatenate([columns[k] for columns in batches]) for k in batches[0]}


def batch(campaign: Campaign, cases: Dispersed) -> Batch:
    """Return the batch of plants, winds and gains of n cases, in the plane of a campaign.

    It has `plane_batches` for a wind with a heading, which has a component in each plane, if the
    nozzle has a limit shape, by which both count. `cases`: dispersed values [SI], ``(n,)`` each,
    all of possible cases: no mass is negative.
    """
    values = cases.values
    changes = {
        k: v
        for k, v in values.items()
        if k not in (*WIND, *GAINS, "wind") and not is_mode_factor(k)  # fields of the vehicle
    }
    vehicle = campaign.vehicle.replace(**changes) if changes else campaign.vehicle
    wind = campaign.wind.history(values)
    angle = np.abs(np.asarray(wind.peak))  # of the whole wind, in whatever plane

    def in_plane(of_plane: Campaign, wind_in_plane: History) -> Batch:
        """Return the batch in the plane of a campaign, in winds [rad] of that plane, ``(n,)``.

        A gain without a dispersed value is nominal.
        """
        return Batch(
            plant=Plant.from_vehicle(vehicle, of_plane.model, of_plane.plane),
            wind=wind_in_plane,
            gains={name: values.get(name, value) for name, value in of_plane.gains.items()},
            count=cases.possible.size,
            vehicle=vehicle,
            wind_angle=angle,
            flexible=_flexible(of_plane, vehicle, values),
            values=values,
        )

    if not isinstance(campaign.wind, ShapedWind) or campaign.heading is None:
        return in_plane(campaign, wind)
    winds = campaign.wind.in_planes(values, vehicle.attitude)
    batches = {k: in_plane(plan, winds[k]) for k, plan in campaign.plane_campaigns.items()}
    plane_batches = {} if campaign.nozzle.limit_shape is None else batches
    return replace(batches[campaign.plane], plane_batches=plane_batches)


def nominal(campaign: Campaign) -> dict[str, float]:
    """Return the outputs of the nominal case of a campaign [SI], by name; {} for many winds."""
    if isinstance(campaign.wind, WindEnsemble):
        return {}
    nominal_case = batch(campaign, Dispersed({}, np.ones(1, dtype=bool)))
    outputs: dict[str, FloatArray] = {}
    for case_by_case in (False, True):  # outputs of a whole batch, then of single cases
        outputs |= compute(campaign, nominal_case, case_by_case=case_by_case)
    return {name: float(values[0]) for name, values in outputs.items()}


def _flexible(
    campaign: Campaign, vehicle: Vehicle, values: dict[str, AnyArray]
) -> FlexiblePlant | None:
    """Return the flexible plants of vehicles with dispersed modes; None for a rigid vehicle.

    `values`: dispersed values by parameter, of which the factors on modes count, ``(n,)`` each.
    """
    if vehicle.structure is None:
        return None
    model = flexible_model(vehicle.structure, campaign.model)
    plant = FlexiblePlant.from_vehicle(vehicle, vehicle.structure, model, campaign.plane)
    if not any(map(is_mode_factor, values)):
        return plant
    factors = (
        mode_factors(vehicle.structure, values, number) for number in ("frequency", "damping")
    )
    return replace(plant, structure=structure_with_mode_factors(vehicle.structure, *factors))


def _columns(campaign: Campaign, first: int, count: int) -> dict[str, AnyArray]:
    """Return the columns of a batch of cases of a campaign; same parameters as `evaluate`."""
    cases = draw_cases(campaign, first, count)
    index = np.arange(first, first + count, dtype=np.int64)
    answers = {name: np.full(count, np.nan) for name in columns(campaign)}
    status = np.where(cases.possible, OK, IMPOSSIBLE).astype(object)

    def answer(which: IndexArray, case_by_case: bool) -> None:
        """Compute outputs and statuses of the cases with the indices `which`, into the columns.

        `case_by_case`: whether to compute the outputs that take a single case at a time, or the
        others.
        """
        selected = batch(campaign, cases.take(which))
        for name, values in compute(campaign, selected, case_by_case=case_by_case).items():
            answers[name][which] = values
        if not case_by_case:
            judged = selected.plane_batches.values() or (selected,)  # in both planes, or in one
            plants = [in_plane.plant for in_plane in judged]
            unstable = [unstable_modes(plant).poles for plant in plants]
            stable = np.all([np.isnan(poles).all(axis=-1) for poles in unstable], axis=0)
            # whether the fastest unstable poles are a pair, in any plane
            paired = np.any([is_pair for _, is_pair in map(leading_pole, plants)], axis=0)
            status[which[np.broadcast_to(stable, which.shape)]] = STABLE
            status[which[np.broadcast_to(paired, which.shape)]] = PAIRED
            if campaign.unknown_wind:
                status[which] = UNKNOWN_WIND
            status[which[np.broadcast_to(~within_linear(selected.wind_angle), which.shape)]] = (
                BEYOND
            )

    def refused(case: np.intp, error: Exception) -> None:
        """Write why a case cannot be computed, its `error`, as its status; `case`: its index."""
        status[case] = str(error) if isinstance(error, InputError) else f"failed: {error}"

    # all cases at once, halved by `divide` until each refused one is by itself; then, one by one,
    # outputs that take a single case
    possible = np.flatnonzero(cases.possible)
    divide(lambda which: answer(which, case_by_case=False), refused, possible)
    if any(REGISTRY[name].case_by_case(campaign) for name in campaign.outputs):
        for case in possible:
            divide(lambda which: answer(which, case_by_case=True), refused, np.array([case]))
    _count_unknown(answers, status)
    return {"case": index, **cases.values, **answers, "status": status}


def _count_unknown(answers: dict[str, FloatArray], status: AnyArray) -> None:
    """Make the angles [rad] of cases that are not known infinite, and write their status.

    They are required deflections that are NaN where the case has an answer, and peaks of flights
    that are neither survived nor lost. `answers`: outputs by name, ``(n,)`` each, which are
    changed. `status`: texts, ``(n,)``, too.
    """
    for name, values in answers.items():
        if name.startswith(REQUIRED):
            unknown = np.isnan(values) & np.isin(status, (OK, PAIRED, ENCOUNTERED_UNKNOWN))
            values[unknown], status[unknown] = np.inf, ENCOUNTERED_UNKNOWN
    if "flight_survived" in answers:
        undecided = (status == OK) & np.isnan(answers["flight_survived"])
        status[undecided] = UNDECIDED
        for name in answers.keys() & _FLOWN_PEAKS:
            answers[name][undecided] = np.inf


def divide(
    work: Callable[[IndexArray], None],
    refused: Callable[[np.intp, Exception], None],
    which: IndexArray,
) -> None:
    """Work on all cases at once; halve a refused batch until each bad case is a batch by itself.

    `work` takes indices of cases. `refused` takes the index of a bad case and its exception.
    `which`: indices of the cases. An exception that no single case can cause, such as arrays of
    different shapes, is raised.
    """
    if not which.size:
        return
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            work(which)
    except _CASE_ERRORS as error:
        if which.size == 1:
            refused(which[0], error)
            return
        middle = which.size // 2
        divide(work, refused, which[:middle])
        divide(work, refused, which[middle:])
