"""Dispersions of vehicle and wind: dispersed values from random numbers in (0, 1).

A case has the same random numbers in any chunk, worker, machine or order. Plain numbers come from a
counter-based generator, one key for each block of cases; the numbers of a Sobol sequence have an
index by definition; a Latin hypercube covers the whole campaign, and so needs its size.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import AnyArray, BoolArray, FloatArray
from tvclin.base.fields import checked, flag, quantity, word
from tvclin.base.tables import FileTable
from tvclin.base.units import si_unit
from tvclin.control.autopilot.feedback import GAINS
from tvclin.vehicle.structure import Structure
from tvclin.vehicle.vehicle import NUMBERS
from tvclin.vehicle.vehicle_file import VEHICLE_TABLE

SHAPES = ("normal", "uniform", "truncated")
WIND = {"wind_peak": "angle", "wind_duration": "time"}
_MAX_NORMAL_DEVIATE = 3.0
"""End of a truncated normal distribution, in standard deviations of the normal one."""


@dataclass(frozen=True)
class Dispersion:
    """Distribution of an uncertain parameter.

    Attributes
    ----------
    parameter : str
        A field of `Vehicle`, "wind_peak" or "wind_duration", a gain of `Autopilot`, or a factor on
        modes of a flexible vehicle: "bending_frequency", "bending_damping", "slosh_frequency" and
        "slosh_damping" on all, "bending_2_frequency" on one.
    shape : str
        "normal", "uniform" or "truncated" (normal, cut at three standard deviations).
    spread : float
        One standard deviation; of a uniform distribution half its width.
    relative : bool
        Whether the spread is a fraction of the nominal value, or else in its SI unit.
    """

    parameter: str
    shape: str = word(SHAPES)
    spread: float = quantity("number", check=errors.positive)
    relative: bool = flag(True)

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for an unknown parameter or shape, and a bad spread."""
        checked_parameter("parameter", self.parameter)
        checked(self)

    def deviates(self, normal: FloatArray) -> FloatArray:
        """Return deviations of n cases in units of the spread, ``(n,)``.

        `normal`: standard normal deviates of the cases, ``(n,)``; their probabilities are turned
        into deviates of the distribution, so that cases keep their order.
        """
        from scipy.special import ndtr, ndtri

        if self.shape == "normal":
            return normal
        if self.shape == "uniform":
            return np.asarray(2.0 * ndtr(normal) - 1.0)
        # truncated normal: probabilities between those of its two ends
        low, high = ndtr(np.array([-_MAX_NORMAL_DEVIATE, _MAX_NORMAL_DEVIATE]))
        return np.asarray(ndtri(low + (high - low) * ndtr(normal)))


@dataclass(frozen=True, eq=False)
class Dispersed:
    """Dispersed values of cases, and whether each case is possible, ``(n,)`` each.

    `values`: by parameter [SI], and under "wind" the index of the wind in an ensemble. `possible`:
    False where a value has no meaning, such as a thrust below zero.
    """

    values: dict[str, AnyArray]
    possible: BoolArray

    def take(self, which: AnyArray) -> "Dispersed":
        """Return some of the cases; `which`: their indices, in the order of the result."""
        return Dispersed({k: v[which] for k, v in self.values.items()}, self.possible[which])


@dataclass(frozen=True)
class Dispersions:
    """Several dispersions, independent or correlated.

    Attributes
    ----------
    distributions : tuple of Dispersion
        Distributions, one for each parameter.
    correlation : tuple of tuple of float, optional
        Correlation of the underlying normal numbers, symmetric and positive definite.

    Raises
    ------
    InputError
        For a parameter that is dispersed twice, and a matrix that is no correlation.
    """

    distributions: tuple[Dispersion, ...]
    correlation: tuple[tuple[float, ...], ...] | None = None

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for a parameter twice, and a matrix of no correlation."""
        dispersions = errors.each(
            "distributions", self.distributions, Dispersion, "one for each parameter"
        )
        object.__setattr__(self, "distributions", dispersions)
        names = list(self.parameters)
        if len(set(names)) < len(names):
            raise errors.InputError(f"a parameter is dispersed twice: {', '.join(sorted(names))}")
        if self.correlation is not None:
            _ = self._factor  # refuses a matrix of no correlation

    @property
    def words(self) -> str:
        """Parameters, distributions and standard deviations, in words."""
        return ", ".join(
            f"{dispersion.parameter.replace('_', ' ')} ({dispersion.shape}, "
            + (
                f"{100 * dispersion.spread:.4g} %)"
                if dispersion.relative
                else f"{dispersion.spread:.4g} in its SI unit)"
            )
            for dispersion in self.distributions
        )

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the dispersed parameters."""
        return tuple(dispersion.parameter for dispersion in self.distributions)

    def apply(self, nominal: Mapping[str, Any], numbers: ArrayLike) -> Dispersed:
        """Return the dispersed values of cases [SI], ``(n,)`` by parameter.

        Parameters
        ----------
        nominal : mapping of str to float
            The nominal value of each parameter [SI].
        numbers : array_like
            Numbers in (0, 1), ``(n, parameters)``; see `draw`.

        Raises
        ------
        InputError
            For a parameter without a nominal value, and a relative spread of a nominal zero.
        """
        from scipy.special import ndtri

        errors.instance("nominal", nominal, Mapping, "of parameters to numbers")
        drawn = errors.finite("numbers", numbers)
        if drawn.ndim != 2 or drawn.shape[-1] != len(self.distributions):
            raise errors.InputError(
                f"numbers must have a row of {len(self.distributions)} for each case; got an"
                f" array of shape {drawn.shape}"
            )
        if np.any((drawn <= 0.0) | (drawn >= 1.0)):
            raise errors.InputError("numbers must all be above 0 and below 1")
        normal = ndtri(drawn)
        if self.correlation is not None:
            # Correlated by the Cholesky factor `_factor` of the correlation matrix, element by
            # element: the bits of a matrix product depend on the number of cases.
            columns = zip(normal.T, self._factor.T, strict=True)
            normal = sum((column[:, np.newaxis] * row for column, row in columns), 0.0 * drawn)
        values, possible = {}, np.ones(len(normal), dtype=bool)
        for column, dispersion in zip(normal.T, self.distributions, strict=True):
            centre = self._centre(nominal, dispersion)
            scale = dispersion.spread * (abs(centre) if dispersion.relative else 1.0)
            value = centre + scale * dispersion.deviates(column)
            values[dispersion.parameter] = value
            for names, rule in _RULES:  # rules by which values have a meaning, such as mass > 0
                if dispersion.parameter in names:
                    possible &= rule(value, centre)
            if is_mode_factor(dispersion.parameter):
                possible &= value > 0.0
        return Dispersed(values, possible)

    @staticmethod
    def _centre(nominal: Mapping[str, Any], dispersion: Dispersion) -> float:
        """Return the nominal value [SI] of the parameter of a dispersion.

        `nominal`: nominal values [SI] by parameter. `InputError` where it has none, and where a
        relative spread would be one of zero.
        """
        if nominal.get(dispersion.parameter) is None:
            # winds that are measured are not dispersed
            or_pulse = ", or give a pulse (leave --winds out)" * (dispersion.parameter in WIND)
            raise errors.InputError(
                f"{dispersion.parameter} is dispersed, but has no nominal value here: take its"
                f" dispersion out{or_pulse}"
            )
        centre = errors.number(dispersion.parameter, nominal[dispersion.parameter])
        if dispersion.relative and centre == 0.0:
            raise errors.InputError(
                f"{dispersion.parameter} is zero, and no part of zero can be its spread; give one"
                " in its unit"
            )
        return centre

    @property
    def _factor(self) -> FloatArray:
        """Cholesky factor of the correlation matrix, ``(k, k)`` for k distributions.

        `InputError` if the matrix is no correlation matrix.
        """
        matrix = errors.finite("correlation", () if self.correlation is None else self.correlation)
        size = len(self.distributions)
        if matrix.shape != (size, size) or not np.allclose(matrix, matrix.T):
            raise errors.InputError(f"correlation must be a symmetric matrix of {size} rows")
        if not np.allclose(np.diag(matrix), 1.0):
            raise errors.InputError("correlation must have ones on its diagonal")
        try:
            return np.asarray(np.linalg.cholesky(matrix), dtype=float)
        except np.linalg.LinAlgError:
            raise errors.InputError("correlation must be positive definite") from None


_POSITIVE = (
    "weight",
    "moment_of_inertia",
    "thrust",
    "velocity",
    "control_force_slope",
    "wind_duration",
)
_RULES: tuple[tuple[tuple[str, ...], Callable[[FloatArray, float], BoolArray]], ...] = (
    (_POSITIVE, lambda value, _: value > 0.0),
    (("normal_force_slope", "axial_force", "pitch_damping"), lambda value, _: value >= 0.0),
    (("control_arm", "wind_peak"), lambda value, centre: value * centre > 0.0),
    (("attitude", "wind_peak"), lambda value, _: np.abs(value) < np.pi / 2),
)
"""Parameters, and the rule of their dispersed values and nominal value [SI] for a possible case."""
MODES = ("bending_frequency", "bending_damping", "slosh_frequency", "slosh_damping")
"""Factors on all modes of a flexible vehicle; on a single mode as in bending_2_frequency."""
_SINGLE_MODE_FACTOR = re.compile(r"(bending|slosh)_[1-9]\d*_(frequency|damping)")
PARAMETERS = (*(name for name in NUMBERS if name != "time"), *WIND, *GAINS, *MODES)
"""Parameters that can be dispersed; a factor on a single mode can be as well."""


def checked_parameter(what: str, name: Any, others: tuple[str, ...] = ()) -> str:
    """Return the name of a parameter that can be dispersed; `InputError` for another name.

    `what`: the argument or key in the error. `name`: the name to check. `others`: further names
    that the error lists.
    """
    if isinstance(name, str):
        if _SINGLE_MODE_FACTOR.fullmatch(name):
            return name
        if name == "mass":
            raise errors.InputError(f"{what}: a mass is dispersed as its weight; write weight")
    return errors.one_of(what, name, (*PARAMETERS, *others))


def is_mode_factor(name: str) -> bool:
    """Return whether a parameter, by `name`, is a factor on modes of a flexible vehicle."""
    return name in MODES or _SINGLE_MODE_FACTOR.fullmatch(name) is not None


def mode_names(structure: Structure | None) -> dict[str, list[str]]:
    """Return the names of the modes of a structure, as in "bending_1", by kind.

    The kinds are "bending" and "slosh", for which there are modes; None has none.
    """
    kinds = {} if structure is None else {"bending": structure.bending, "slosh": structure.slosh}
    return {
        kind: [f"{kind}_{k}" for k in range(1, len(modes) + 1)]
        for kind, modes in kinds.items()
        if modes
    }


def modes_nominal(structure: Structure | None) -> dict[str, float]:
    """Return the nominal factors, all 1.0, on frequencies and dampings of the modes of a structure.

    "bending_frequency" is a factor on all bending modes, "bending_2_frequency" on the second one.
    """
    names = mode_names(structure)
    bodies = [*names, *(name for modes in names.values() for name in modes)]
    return {f"{body}_{number}": 1.0 for body in bodies for number in ("frequency", "damping")}


KINDS = {name: VEHICLE_TABLE.quantities.get(name, "number") for name in PARAMETERS} | WIND
"""Kind of `UNITS` of the spread by parameter, where a file gives a spread that is no fraction."""
UNITS_OF = {name: si_unit(kind) for name, kind in KINDS.items()} | {
    "attitude_gain": "rad/rad",
    "rate_gain": "s",
    "alpha_gain": "rad/rad",
    "integral_gain": "1/s",
    "drift_rate_gain": "rad s/m",
    "drift_gain": "rad/m",
    "acceleration_gain": "rad s2/m",
}
"""SI units by parameter."""
DISPERSION_TABLE = FileTable(
    "[[dispersion]]", {"part": "number", "percent": "hundredths"}, words=("parameter", "shape")
)
CORRELATION_TABLE = FileTable("[[correlation]]", words=("between", "coefficient"))


def spread_table(parameter: Any) -> FileTable:
    """Return the table of the keys of a dispersion; `InputError` for an unknown parameter.

    A file may name the weight "mass", with a spread in units of mass.
    """
    name, kind = parameter, "mass"
    if parameter != "mass":
        name = checked_parameter("parameter in [[dispersion]]", parameter, ("mass",))
        kind = KINDS.get(name, "number")
    kinds = DISPERSION_TABLE.quantities | {"spread": kind}
    return replace(DISPERSION_TABLE, heading=f"[[dispersion]] of {name}", quantities=kinds)


DEFAULT_DISPERSIONS = Dispersions(
    (
        Dispersion("thrust", "truncated", 0.01),
        Dispersion("moment_of_inertia", "truncated", 0.02),
        Dispersion("normal_force_slope", "truncated", 0.05),
        Dispersion("aerodynamic_arm", "truncated", 0.05),
        Dispersion("control_arm", "truncated", 0.005),
        Dispersion("velocity", "truncated", 0.005),
        Dispersion("wind_duration", "uniform", 0.3),
    )
)
"""Assumed for a first answer: standard deviations as fractions of the nominal values."""


METHODS = ("plain", "sobol", "latin")
_BLOCK = 1024
"""Cases whose plain numbers come from one key of the generator."""
_MIN_NUMBER = 2.0**-54
"""Smallest random number: distributions are infinite at zero and at one."""


def draw(
    seed: int, first: int, count: int, dimension: int, *, method: str = "plain", size: int = 0
) -> FloatArray:
    """Return random numbers in (0, 1) of the cases from `first` on, ``(count, dimension)``.

    `seed`: seed of the generator; a case depends on it and on its own number alone. `count`,
    `dimension`: number of cases, and of random numbers of each. `method`: independent numbers
    ("plain"), a scrambled Sobol sequence ("sobol"), or a Latin hypercube ("latin"), which alone
    needs the `size` of the campaign, its number of cases.
    """
    for name, value in (("seed", seed), ("first", first), ("count", count)):
        errors.whole_number(name, value)
    errors.one_of("method", method, METHODS)
    if not count or not dimension:
        return np.zeros((count, dimension))
    if method == "latin" and first + count > size:
        raise errors.InputError(
            f"a Latin hypercube of {size} cases has no case {first + count - 1}"
        )
    if method == "plain":
        # whole blocks of cases, each with its own key, from which the cases are cut
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
    return np.clip(numbers, _MIN_NUMBER, 1.0 - 2.0**-53)  # the largest number below one
