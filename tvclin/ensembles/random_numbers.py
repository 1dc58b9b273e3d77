"""Random numbers that belong to the case: the same for any chunk, worker, machine or order.

Case i of a seed has the same numbers whatever else is computed. Plain numbers come from a
counter-based generator, one key for each block of cases; the numbers of a Sobol sequence have an
index by definition; a Latin hypercube covers the whole campaign, and so needs its size.
"""

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, one_of, whole_number

METHODS = ("plain", "sobol", "latin")
_BLOCK = 1024
"""Cases whose plain numbers come from one key of the generator."""
_MIN_NUMBER = 2.0**-54
"""Smallest random number: distributions are infinite at zero and at one."""


def draw(
    seed: int, first: int, count: int, dimension: int, *, method: str = "plain", size: int = 0
) -> FloatArray:
    """Return random numbers in (0, 1) of the cases from `first` on, ``(count, dimension)``.

    `method`: independent numbers ("plain"), a scrambled Sobol sequence ("sobol"), or a Latin
    hypercube ("latin"), which alone needs the `size` of the whole campaign.
    """
    for name, value in (("seed", seed), ("first", first), ("count", count)):
        whole_number(name, value)
    one_of("method", method, METHODS)
    if not count or not dimension:
        return np.zeros((count, dimension))
    if method == "latin" and first + count > size:
        raise InputError(f"a Latin hypercube of {size} cases has no case {first + count - 1}")
    if method == "plain":
        begin, end = first // _BLOCK, -(-(first + count) // _BLOCK)
        seeds = (np.random.SeedSequence(seed, spawn_key=(block,)) for block in range(begin, end))
        blocks = [
            np.random.Generator(np.random.Philox(key)).random((_BLOCK, dimension)) for key in seeds
        ]
        numbers = np.concatenate(blocks)[first - begin * _BLOCK :][:count]
    else:
        from scipy.stats import qmc  # late: it takes half a second to import

        random = np.random.default_rng(seed)
        if method == "latin":
            numbers = qmc.LatinHypercube(dimension, rng=random).random(size)[first:][:count]
        else:
            sequence = qmc.Sobol(dimension, scramble=True, rng=random)
            if first:
                sequence.fast_forward(first)
            total = 1 << max(count - 1, 0).bit_length()  # scipy warns of other sizes
            numbers = sequence.random(total)[:count]
    return np.clip(numbers, _MIN_NUMBER, 1.0 - 2.0**-53)
