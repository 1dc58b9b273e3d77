"""What the largest dead band needs in a head wind and in a tail wind, beside a sizing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tvclin.answers.case import SIGNS, Case
from tvclin.answers.sizing.record import IN_A, VARYING, Sizing
from tvclin.answers.sizing.wind_sign import sign_factors
from tvclin.base.errors import InputError


def base_of(found: Sizing) -> str:
    """Return the largest dead band: with varying parameters, if known wherever frozen ones are."""
    name = f"K = {found.dead_bands[0]:g}"
    frozen, along = found.required[name], found.required.get(f"{name}{VARYING}")
    if along is None or np.isnan(along).all() or np.any(np.isnan(along) & ~np.isnan(frozen)):
        return name
    return f"{name}{VARYING}"


def by_sign(found: Sizing, pulses: int, case_at: Callable[[float, int], Case]) -> Sizing:
    """Return a sizing with what its first winds, so many pulses, need by their sign.

    What has no sign, as a wind across the path, or its own, as a sounding, needs the same in both;
    nothing is added where all winds are of that kind. `case_at` is the case of a flight time [s]
    and a pulse, which says the sign that counts, if not both.
    """
    shape = found.times.size, len(found.winds)
    factors = {one: np.full(shape, np.nan) for one in SIGNS}
    unsigned, why, K = np.zeros(shape, dtype=bool), "", float(found.dead_bands[0])
    for i, j in np.argwhere(found.known[:, :pulses]).tolist():
        try:
            at = case_at(float(found.times[i]), j)
            along = sign_factors(at, at.history_at(K), K)
            for one, factor in along.items():
                factors[one][i, j] = factor
        except InputError as error:  # no sign at this path, no real pole: as it stands
            unsigned[i, j], why = True, why or f"{found.times[i]:g} s: {error}"
    name = base_of(found)
    signed = {
        name + IN_A[one]: found.required[name] * np.where(np.isnan(factor), 1.0, factor)
        for one, factor in factors.items()
        if not np.isnan(factor).all()
    }
    arises = dict(found.arises)
    if name in arises:
        arises |= dict.fromkeys(signed, arises[name])
    if not (why and signed):
        return replace(found, required=found.required | signed, arises=arises)
    said = f"what the sign of a pulse changes is not known at {why}"
    required, notes = found.required | signed, (*found.notes, said)
    return replace(found, required=required, arises=arises, unsigned=unsigned, notes=notes)
