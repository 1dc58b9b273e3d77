"""A batch of flights as arrays for the kernel, at their start."""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.control.autopilot.actuator import plant_with_actuator
from tvclin.flights.closed_loop.batch import Batch, places_in
from tvclin.flights.closed_loop.gusts import polynomial_pieces
from tvclin.flights.closed_loop.law_batch import LawBatch
from tvclin.flights.closed_loop.outcomes import Judging, judging
from tvclin.flights.closed_loop.step_matrices import (
    even_steps,
    frequency,
    joint_steps,
    quickness,
    sensed_rows,
    substeps_of,
)
from tvclin.kernels import flights as kernel
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import (
    MEASURED,
    NEVER,
    PEAKS,
    Cases,
    Flights,
    Laws,
    Now,
    Steps,
    Vehicles,
    Winds,
)
from tvclin.linear.system import split_delay

_LONGEST = 1_000_000
"""Samples after its wind in which a flight may be decided; then it stays undecided."""
_AT_ONCE = 1e100
"""Bandwidth [1/s] of no nozzle at all."""


def flights(batch: Batch, *, track: bool = False) -> Flights:
    """Return the flights of a batch at their start, at rest; of one alone with its track.

    All arrays can be written to: the kernel is compiled anew for those that can not.
    """
    own, (vehicle, met) = batch.vehicles, batch.places
    knots, pieces = (np.ascontiguousarray(one) for one in polynomial_pieces(batch.wind))
    terms = pieces.shape[2]
    steps = _steps(batch, own, terms)
    judges, place = judging(batch.plant), places_in(batch.plant.batch, own)
    cases, noise = _cases(batch, judges, place)
    h = steps.lengths[vehicle, 0]
    memory = batch.laws.memory(h)
    N = steps.joint.shape[2]
    plant = batch.plant.system.cases(np.arange(int(np.prod(own))), own)
    now = _at_rest(vehicle.size, len(plant.states), steps, terms, memory.moved.shape[1])
    now.piece[:] = (knots[met] <= cases.start[:, np.newaxis]).sum(axis=1) - 1
    rows = int(steps.substeps.sum() * cases.finish.max()) if track else 0
    return Flights(
        steps=steps,
        vehicles=Vehicles(
            shown=sensed_rows(plant),
            A=plant.A,
            gust=np.ascontiguousarray(plant.B[..., 1]),
            fastest=np.abs(plant.poles).max(axis=-1),
            judges=_widened(judges.rows[place], N),
            reach=judges.reach[place],
            ratio=judges.ratio[place],
        ),
        winds=Winds(knots, pieces),
        laws=Laws([one or LawNumbers() for one in batch.laws.numbers], *memory, noise),
        cases=cases,
        now=now,
        track=np.full((rows, N + 4), np.nan),
    )


def _steps(batch: Batch, own: tuple[int, ...], terms: int) -> Steps:
    """The steps of vehicles in winds of so many terms.

    They are of a whole sample, and of its parts before and after a late command.
    """
    hardware, every = batch.hardware, np.arange(int(np.prod(own)))
    plant = batch.plant.system.cases(every, own)
    length, delay = (_spread(a, own) for a in (hardware.length, hardware.delay))
    late, rest = split_delay(delay, length)
    parts = [length - rest, rest] if np.any(rest) else [length]
    lengths = np.stack([length, *parts], axis=-1)
    pace = np.minimum(_spread(quickness(hardware.actuator), own), _AT_ONCE)[:, np.newaxis]
    substeps = substeps_of(_spread(frequency(hardware.actuator), own), lengths)
    short = lengths[:, 1:] / substeps
    moving = plant_with_actuator(batch.plant, hardware.actuator).cases(every, own)
    n = len(plant.states)
    joint = joint_steps(moving, n, lengths[:, 1:], terms)
    return Steps(
        joint=joint,
        fine=joint_steps(moving, n, short, terms) if np.any(substeps > 1) else joint,
        substeps=substeps,
        ramp=even_steps(plant, short),
        lengths=lengths,
        short=short,
        quick=np.where(short > 0.0, pace * short, 0.0),
        late=late.astype(np.int64),
    )


def _cases(batch: Batch, judges: Judging, place: IntArray) -> tuple[Cases, FloatArray]:
    """What each flight has, and the rows of noise; judges stand at a place for each vehicle."""
    shape, (vehicle, met) = batch.shape, batch.places
    h = _spread(batch.hardware.length, batch.vehicles)[vehicle]
    start, end = (a.ravel()[met] for a in (batch.wind.onset, batch.wind.end))
    known = ~np.isnan(judges.reach[place][vehicle])
    waiting, settling = (
        np.ceil(np.where(known, a[place][vehicle], 0.0) / h)
        for a in (judges.waiting, judges.settling)
    )
    waiting = -(-np.minimum(waiting, _LONGEST) // kernel.LOOK) * kernel.LOOK
    finish, ends = (_samples(a - start, h) for a in (np.full(h.shape, batch.until), end))
    noise, sequence = _noise(batch.laws, np.where(finish < NEVER, finish, ends + waiting))
    cases = Cases(
        vehicle=vehicle,
        wind=met,
        law=batch.laws.which.copy(),
        sequence=sequence,
        gain=_spread(batch.gain, shape),
        limit=_spread(batch.limit, shape),
        rate_limit=_spread(batch.hardware.rate_limit, shape),
        start=start.copy(),
        finish=finish,
        ends=ends,
        waiting=waiting.astype(np.int64),
        settling=settling.astype(np.int64),
    )
    return cases, noise


def _at_rest(m: int, n: int, steps: Steps, terms: int, memory: int) -> Now:
    """The state of m flights of n states, in winds of so many terms, of laws that remember."""
    N, late = steps.joint.shape[2], int(steps.late.max(initial=0))
    return Now(
        y=np.zeros((m, N)),
        states=np.zeros((m, memory)),
        here=np.zeros((m, terms)),
        sensed=np.zeros((m, MEASURED + 1)),
        measured=np.zeros((m, MEASURED)),
        next=np.zeros((m, max(N, memory))),
        series=np.zeros((m, 3, n)),
        commands=np.zeros((m, late + steps.joint.shape[1])),
        mode=np.zeros(m),
        bounded=np.zeros(m, np.bool_),
        peaks=np.zeros((m, PEAKS)),
        piece=np.zeros(m, np.int64),
        settled=np.zeros(m, np.int64),
        outcome=np.zeros(m, np.int64),
        ended=np.full(m, -1, np.int64),
    )


def _widened(rows: FloatArray, width: int) -> FloatArray:
    """Rows of states, with zeros for those that follow, and without what is no state here."""
    wide = np.zeros((*rows.shape[:-1], width))
    some = min(width, rows.shape[-1])
    wide[..., :some] = rows[..., :some]
    return wide


def _spread(array: float | FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """An array that broadcasts to a shape, spread to it, flat, and free to be written to."""
    return np.array(np.broadcast_to(array, shape), float).ravel()


def _samples(span: FloatArray, length: FloatArray) -> IntArray:
    known = np.isfinite(span)
    counted = np.ceil(np.where(known, span, 0.0) / length - 1e-9)
    return np.where(known, np.maximum(counted, 1), NEVER).astype(np.int64)


def _noise(laws: LawBatch, samples: FloatArray) -> tuple[FloatArray, IntArray]:
    """A row of noise for each level and seed, and the row of each flight."""
    every = list(dict.fromkeys(laws.noise))
    sequence = np.array([every.index(one) for one in laws.noise], dtype=np.int64)[laws.which]
    if not any(level for level, _ in every):
        return np.zeros((1, 0)), sequence
    count = int(samples.max()) + 2 * kernel.LOOK
    rows = [
        np.random.default_rng([seed, 0]).normal(0.0, level, count) if level else np.zeros(count)
        for level, seed in every
    ]
    return np.stack(rows), sequence
