"""Flights of laws that are computed at a sample rate, each stepped exactly from sample to sample.

A command that takes effect between two samples, by a computing delay, parts each step in two.
`flight_steps` moves vehicle and nozzle through a part, in the wind of `flight_winds`.
"""

from tvclin.base.arrays import FloatArray
from tvclin.kernels.control_laws import asked, slow_ends, switched
from tvclin.kernels.flight_arrays import LOST, MEASURED, NEVER, SURVIVED, UNDECIDED, Flights
from tvclin.kernels.flight_steps import raised, through
from tvclin.kernels.flight_winds import about
from tvclin.kernels.source import bare, inlined

PLAIN, COMPILED = 3e-5, 5e-8
"""About how many seconds a sample of a flight takes, in plain Python and as machine code."""
SETTLED = 0.3
"""Saved: every unstable coordinate is below this part of the reach for a while."""
LOOK = 8
"""Samples between two looks at a flight."""


@bare
def fly(f: Flights, first: int, last: int) -> None:
    """Fly the cases from `first` up to `last`, each to its end."""
    for i in range(first, last):
        law = f.laws.numbers[f.cases.law[i]]
        for k in range(NEVER):
            if not looked(f, i, k):
                break
            demand = asked(law, f.now.measured[i], f.now.states[i], f.cases.limit[i])
            stepped(f, i, k, demand, law.engage, law.release)


@bare
def look(f: Flights, k: int) -> int:
    """Look at all flights at a sample; return how many go on."""
    some = 0
    for i in range(f.cases.limit.size):
        if f.now.ended[i] < 0 and looked(f, i, k):
            some += 1
    return some


@bare
def advance(
    f: Flights, k: int, demand: FloatArray, engage: FloatArray, release: FloatArray
) -> None:
    """Move all flights that go on by a sample, with what laws in Python ask for, ``(m,)``."""
    for i in range(f.cases.limit.size):
        if f.now.ended[i] < 0:
            stepped(f, i, k, demand[i], engage[i], release[i])


@inlined
def looked(f: Flights, i: int, k: int) -> bool:
    """Write what a law is shown at a sample; return whether the flight goes on."""
    p, peaks, sensed, x = f.cases.vehicle[i], f.now.peaks[i], f.now.sensed[i], f.now.y[i]
    n = f.vehicles.A.shape[1]
    about(f, i, f.cases.start[i] + f.steps.lengths[p, 0] * k)
    for r in range(4):
        total = f.vehicles.shown[p, r, n] * f.now.here[i, 0]
        for j in range(n):
            total += f.vehicles.shown[p, r, j] * x[j]
        sensed[r] = total
    sensed[4] = min(max(x[n], -f.cases.limit[i]), f.cases.limit[i])
    raised(peaks, 0, x[0])
    raised(peaks, 1, x[1])
    raised(peaks, 4, sensed[3])
    after = k - f.cases.ends[i]
    if after > 0 and after % LOOK == 0 and f.now.outcome[i] != LOST:
        judged(f, i)
    going = f.now.outcome[i] == UNDECIDED and after < f.cases.waiting[i]
    if k >= f.cases.finish[i] or (not going and f.cases.finish[i] == NEVER):
        f.now.ended[i] = k
        return False
    if k < f.laws.noise.shape[1]:
        sensed[1] += f.laws.noise[f.cases.sequence[i], k]
    for r in range(MEASURED):
        f.now.measured[i, r] = sensed[r]
    if f.laws.seen.shape[0]:
        own = i if f.laws.seen.shape[0] > 1 else 0
        for r in range(MEASURED):
            f.now.measured[i, r] = filtered(f, i, f.laws.seen[own, r])
    return True


@inlined
def filtered(f: Flights, i: int, row: FloatArray) -> float:
    """Return what a row makes of the states of a law and of what is sensed."""
    s, total = f.now.states.shape[1], 0.0
    for j in range(s):
        total += row[j] * f.now.states[i, j]
    for j in range(MEASURED + 1):
        total += row[s + j] * f.now.sensed[i, j]
    return total


@inlined
def judged(f: Flights, i: int) -> None:
    """Decide a flight after its wind, if that can be done; one that was saved may yet be lost.

    Lost outside the recoverable set |z1| < D, slow_ends(z1) about z2 (see `boundary.recoverable`,
    whose rows times the states are z1 and z2); saved when both stay below a part of D for a while.
    """
    p = f.cases.vehicle[i]
    reach, ratio = f.vehicles.reach[p] * f.cases.limit[i], f.vehicles.ratio[p]
    if not reach > 0.0:
        return
    fast, slow = 0.0, 0.0
    for j in range(f.vehicles.judges.shape[2]):
        fast += f.vehicles.judges[p, 0, j] * f.now.y[i, j]
        slow += f.vehicles.judges[p, 1, j] * f.now.y[i, j]
    recoverable = abs(fast) < reach
    if recoverable and ratio > 0.0:
        low, high = slow_ends(fast / reach, ratio)
        recoverable = low * reach < slow < high * reach
    if not recoverable:
        f.now.outcome[i] = LOST
        return
    f.now.settled[i] = f.now.settled[i] + LOOK if max(abs(fast), abs(slow)) < SETTLED * reach else 0
    if f.now.settled[i] >= f.cases.settling[i]:
        f.now.outcome[i] = SURVIVED


@inlined
def stepped(f: Flights, i: int, k: int, demand: float, engage: float, release: float) -> None:
    """Move a flight by a sample.

    The command of sample k acts from k + late on, or where the delay is no whole number of samples
    within that step: its first part (1) still has the command before, its second (0) this one.
    """
    p, limit, sensed = f.cases.vehicle[i], f.cases.limit[i], f.now.sensed[i]
    demand = f.cases.gain[i] * demand
    sensed[MEASURED] = demand
    if f.laws.told.shape[0]:
        demand = filtered(f, i, f.laws.told[i if f.laws.told.shape[0] > 1 else 0])
    mode = switched(engage * limit, release * limit, demand, f.now.mode[i])
    f.now.mode[i] = mode
    command = mode * limit if mode != 0.0 else min(max(demand, -limit), limit)
    if abs(command) >= limit:
        f.now.peaks[i, 5] += 1.0
    begin = f.cases.start[i] + f.steps.lengths[p, 0] * k
    end = f.cases.start[i] + f.steps.lengths[p, 0] * (k + 1)
    parts, ring, since = f.steps.joint.shape[1], f.now.commands.shape[1], k - f.steps.late[p]
    if ring > 1:
        f.now.commands[i, k % ring] = command
    for part in range(parts - 1, -1, -1):
        now = f.now.commands[i, (since - part) % ring] if ring > 1 else command
        stop = begin + f.steps.lengths[p, 2] if part > 0 else end
        through(f, i, part, k, now, begin, stop)
        if part > 0:
            about(f, i, stop)
        begin = stop
    learnt(f, i)
    n = f.vehicles.A.shape[1]
    deflection = min(max(f.now.y[i, n], -limit), limit)
    raised(f.now.peaks[i], 2, deflection)
    raised(f.now.peaks[i], 3, (deflection - sensed[4]) / f.steps.lengths[p, 0])


@inlined
def learnt(f: Flights, i: int) -> None:
    """Move the states of a law and of its filters, by what was sensed and asked for."""
    s = f.now.states.shape[1]
    own = i if f.laws.memory.shape[0] > 1 else 0
    for r in range(s):
        f.now.next[i, r] = filtered(f, i, f.laws.memory[own, r])
    for r in range(s):
        f.now.states[i, r] = f.now.next[i, r]
