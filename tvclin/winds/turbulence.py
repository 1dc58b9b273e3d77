"""Turbulence: a random wind in time, as a shaping filter of white noise, and its exact samples.

Frozen turbulence of scale length L is met at the airspeed V. In the distance flown, normalised by
the length, d xi = V dt/L, every filter is one with constant coefficients,

    dx/dxi = A x + b n,    E[n(xi) n(xi')] = delta(xi - xi'),    w = sigma c x,

so that the wind w has the standard deviation sigma while V and L change. With s for d/dxi,

    Dryden, along       G = sqrt(2)/(1 + s)
    Dryden, transverse  G = (1 + sqrt(3) s)/(1 + s)^2
    von Karman, along       G = k (1 + .25 s)/(1 + 1.357 s + .1987 s^2)
    von Karman, transverse  G = k (1 + 2.7478 s + .3398 s^2)/(1 + 2.9958 s + 1.9754 s^2 + .1539 s^3)

Dryden's are exact. Those of von Karman are the rational fits of MIL-HDBK-1797, k being such that
the variance is sigma^2 (without that it is 3.1 and 3.8 percent less). Up to omega L/V = 10 the
spectrum of the fit is -.01 to .26 dB (along) and -.04 to .23 dB (transverse) above von Karman's;
beyond it falls below: by .8 and .3 dB at 30, by 2.4 and 1.8 dB at 100.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Record
from tvclin.base.fields import checked, quantity, spec, word
from tvclin.base.units import UNITS
from tvclin.numerics.covariance import stationary_covariance, steps
from tvclin.winds.pulses import SampledWind

FilterMatrices = tuple[FloatArray, FloatArray, FloatArray]

_ALONG, _TRANSVERSE = "along", "transverse"
COMPONENTS = (_TRANSVERSE, _ALONG)
"""Components of the turbulence: across the path, which turns the vehicle, and along it."""
_DRYDEN, _VON_KARMAN = "dryden", "von-karman"
SPECTRA = (_DRYDEN, _VON_KARMAN)
_FILTERS: dict[tuple[str, str], tuple[list[float], list[float]]] = {
    (_DRYDEN, _ALONG): ([1.0], [1.0, 1.0]),
    (_DRYDEN, _TRANSVERSE): ([1.0, np.sqrt(3.0)], [1.0, 2.0, 1.0]),
    (_VON_KARMAN, _ALONG): ([1.0, 0.25], [1.0, 1.357, 0.1987]),
    (_VON_KARMAN, _TRANSVERSE): ([1.0, 2.7478, 0.3398], [1.0, 2.9958, 1.9754, 0.1539]),
}
"""Numerator and denominator in s of each filter, lowest power first, before its scaling."""
_VON_KARMAN_LENGTH_FACTOR = 1.339
"""Factor a of the scale length in von Karman's spectra."""
LENGTHS = {_DRYDEN: 533.4, _VON_KARMAN: 762.0}
"""Scale length [m] of each spectrum above 2000 ft by MIL-F-8785C."""

SEVERITIES = {"light": 1e-2, "moderate": 1e-3, "severe": 1e-5}
"""Probability of exceedance of the intensities of MIL-F-8785C by their names."""
_FOOT, _KNOT = UNITS["length"]["ft"], UNITS["speed"]["kt"]
_LOW_WINDS_KT = {"light": 15.0, "moderate": 30.0, "severe": 45.0}
"""Wind at 20 ft [kt] of each severity."""
_PROBABILITIES = (2e-1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
_ALTITUDES_FT = (1750, 3750, 7500, 15000, 25000, 35000, 45000, 55000, 65000, 75000, 80000)
_INTENSITIES_FT_PER_S = (
    (2.2, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (3.6, 3.3, 1.6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (6.9, 7.4, 6.7, 4.6, 2.7, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0),
    (9.6, 10.6, 10.1, 8.0, 6.6, 5.0, 4.2, 2.7, 0.0, 0.0, 0.0),
    (13.0, 16.0, 15.1, 11.6, 9.7, 8.1, 8.2, 7.9, 4.9, 3.2, 2.1),
    (17.6, 23.0, 23.6, 22.1, 20.0, 16.0, 15.1, 12.1, 7.9, 6.2, 5.1),
    (21.5, 28.4, 30.2, 30.7, 31.0, 25.2, 23.1, 17.5, 10.7, 8.4, 7.2),
)
"""Intensity [ft/s] at each probability and altitude: MIL-F-8785C, figure 7, as read for JSBSim."""
_LOW_ALTITUDES_FT = (10, 20, 50, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000)
"""Altitudes [ft] at which the equations of MIL-F-8785C below 1000 ft are tabulated."""
_MIN_ALTITUDE_OF_TABLE_FT = 2000.0
"""Altitude [ft] from which the table counts; below are straight lines down to 1000 ft."""

_SPEEDS = errors.between(1e-3, 1e6)
"""Check of airspeeds [m/s]."""
_LENGTH_RANGE, _MAX_INTENSITY, _MAX_FREQUENCY = (1e-3, 1e9), 1e4, 1e9
"""Scale lengths [m], largest intensity [m/s] and largest frequency [rad/s]."""
_MAX_SAMPLES = 100_000_000
"""Samples of one call, of all runs together."""


@dataclass(frozen=True, eq=False)
class Turbulence(Record):
    """Random wind with a Gaussian distribution, a spectrum, an intensity and a scale length.

    Parameters
    ----------
    intensity : array_like
        Standard deviation sigma of the wind [m/s]: one, or one for each altitude, ``(n,)``.
    length : array_like, optional
        Scale length L [m], ``()`` or ``(n,)``; by default MIL-F-8785C's above 2000 ft,
        533.4 m for Dryden and 762 m for von Karman.
    spectrum : {"dryden", "von-karman"}
        Form of the spectrum; von Karman's as a rational fit, whose error the module states.
    component : {"transverse", "along"}
        Component across the path, which turns the vehicle, or along it.
    altitude : array_like, optional
        Altitudes of a table [m], rising, ``(n,)``; straight lines between, constant outside.
    cutoff_wavelength : float, optional
        Wavelength along the path [m] above which the turbulence is omitted, because a known wind,
        such as a sounding, holds it already; see the notes.

    Raises
    ------
    InputError
        For an intensity beyond 0 to 1e4 m/s, a length or wavelength beyond 1e-3 to 1e9 m, unknown
        names, and altitudes that do not rise or have another shape.

    Notes
    -----
    The intensity is that of all wavelengths. A cutoff multiplies the spectrum by x^4/(1 + x^4), x
    being the cutoff over the wavelength: a high-pass of second order, whose remaining variance is
    `remaining_variance` times sigma^2. A sounding over height whose levels are d apart resolves
    vertical wavelengths down to 2 d, which at a flight path angle gamma are 2 d/sin(gamma) along
    the path; `WindProfile.resolved_wavelength` is that of its widest gap.

    Examples
    --------
    >>> import tvclin as tv
    >>> gusty = tv.winds.Turbulence.mil_f_8785c("severe").at(11000.0)
    >>> round(gusty.intensity, 2), round(gusty.length, 1)
    (4.85, 533.4)
    """

    intensity: float | FloatArray = field(metadata=spec("speed"))
    length: float | FloatArray | None = field(default=None, metadata=spec("length"))
    spectrum: str = word(SPECTRA, _DRYDEN)
    component: str = word(COMPONENTS, _TRANSVERSE)
    altitude: FloatArray | None = field(default=None, metadata=spec("length", card=False))
    cutoff_wavelength: float | None = quantity("length", None, errors.between(*_LENGTH_RANGE))

    def __post_init__(self) -> None:
        """Check the fields, and set them to arrays; `InputError` as the class says."""
        checked(self, "spectrum", "component", "cutoff_wavelength")
        intensity = errors.within("intensity", self.intensity, 0.0, _MAX_INTENSITY, "m/s")
        length = LENGTHS[self.spectrum] if self.length is None else self.length
        length = errors.within("length", length, *_LENGTH_RANGE, "m")
        errors.together(intensity=intensity, length=length)
        if self.altitude is not None:
            altitude = errors.finite("altitude", self.altitude, "m")
            if altitude.ndim != 1 or altitude.size < 2 or np.any(np.diff(altitude) <= 0.0):
                raise errors.InputError("altitude must be two or more rising altitudes in m")
            object.__setattr__(self, "altitude", altitude)
        table = () if self.altitude is None else self.altitude.shape
        if any(array.shape not in {(), table} for array in (intensity, length)):
            raise errors.InputError(
                "intensity and length must be one number, or one for each altitude; got shapes"
                f" {intensity.shape} and {length.shape} for altitudes of shape {table}"
            )
        object.__setattr__(self, "intensity", errors.plain(intensity))
        object.__setattr__(self, "length", errors.plain(length))

    @classmethod
    def mil_f_8785c(
        cls,
        exceedance: str | float,
        *,
        spectrum: str = _DRYDEN,
        component: str = _TRANSVERSE,
        wind_at_20_ft: float | None = None,
    ) -> Self:
        """Return the turbulence of MIL-F-8785C as a table over altitude.

        Below 1000 ft a launcher climbs steeply, so that its transverse component is the horizontal
        one of the specification, and that along its path the vertical one. Above 80,000 ft the
        last value counts.

        Parameters
        ----------
        exceedance : {"light", "moderate", "severe"} or float
            Probability with which the intensity is exceeded, 0.2 to 1e-6, or a name: light is
            1e-2, moderate 1e-3, severe 1e-5. Between the curves of the specification the intensity
            is linear in the logarithm of the probability.
        spectrum, component : str
            "dryden" or "von-karman"; "transverse" (across the path) or "along" it.
        wind_at_20_ft : float, optional
            Wind speed at 20 ft [m/s], which sets the intensity below 1000 ft; by default 15, 30
            and 45 kt for light, moderate and severe, and between them for a probability.

        Raises
        ------
        InputError
            For unknown names, a probability outside the specification, and a negative wind.
        """
        if isinstance(exceedance, str):
            probability = SEVERITIES[errors.one_of("exceedance", exceedance, SEVERITIES)]
        else:
            probability = errors.fraction("exceedance", exceedance)
            if not _PROBABILITIES[-1] <= probability <= _PROBABILITIES[0]:
                raise errors.InputError(
                    "exceedance must be a probability from 1e-6 to 0.2, which MIL-F-8785C covers,"
                    f" or one of {', '.join(SEVERITIES)}; got {probability:.6g}"
                )
        exponent = -np.log10(probability)
        if wind_at_20_ft is None:
            severities = -np.log10(list(SEVERITIES.values()))
            winds_kt = list(_LOW_WINDS_KT.values())
            low_wind = _KNOT * float(np.interp(exponent, severities, winds_kt))
        else:
            low_wind = errors.number("wind_at_20_ft", wind_at_20_ft, errors.nonnegative, "m/s")
        exponents = -np.log10(_PROBABILITIES)
        # intensity [ft/s] of this probability at each altitude of the table
        high = [np.interp(exponent, exponents, row) for row in np.transpose(_INTENSITIES_FT_PER_S)]
        low_ft, table_ft = np.array(_LOW_ALTITUDES_FT, float), np.array(_ALTITUDES_FT, float)
        errors.one_of("component", component, COMPONENTS)
        start, above = _MIN_ALTITUDE_OF_TABLE_FT, table_ft > _MIN_ALTITUDE_OF_TABLE_FT
        # sigma_w = 0.1 u20, and both factors over altitude: MIL-F-8785C, low-altitude model
        vertical, factor = 0.1 * low_wind, 0.177 + 0.000823 * low_ft
        if component == _TRANSVERSE:
            low_sigma, low_length = vertical / factor**0.4, low_ft / factor**1.2
        else:
            low_sigma, low_length = np.full(low_ft.shape, vertical), low_ft
        high_sigma = _FOOT * np.array([np.interp(start, table_ft, high), *np.array(high)[above]])
        length = LENGTHS[errors.one_of("spectrum", spectrum, SPECTRA)]
        return cls(
            intensity=np.concatenate([low_sigma, high_sigma]),
            length=np.concatenate([_FOOT * low_length, np.full(high_sigma.shape, length)]),
            spectrum=spectrum,
            component=component,
            altitude=_FOOT * np.concatenate([low_ft, [start], table_ft[above]]),
        )

    def at(self, altitude: float) -> Self:
        """Return the turbulence of one altitude [m]; itself without a table over altitude."""
        if self.altitude is None:
            return self
        sigma, length = self.over(errors.number("altitude", altitude, unit="m"))
        return replace(self, intensity=float(sigma), length=float(length), altitude=None)

    def over(self, altitude: ArrayLike | None) -> tuple[FloatArray, FloatArray]:
        """Return intensity [m/s] and length [m] at altitudes [m], in their shape.

        `InputError` for a table over altitude, and no altitude to read it at.
        """
        if self.altitude is None:
            return np.asarray(self.intensity), np.asarray(self.length)
        if altitude is None:
            raise errors.InputError(
                "this turbulence is a table over altitude; give the altitude, or take at(altitude)"
            )
        heights = errors.finite("altitude", altitude, "m")
        sigma, length = (
            np.interp(heights, self.altitude, np.broadcast_to(table, self.altitude.shape))
            for table in (np.asarray(self.intensity), np.asarray(self.length))
        )
        return np.asarray(sigma), np.asarray(length)

    @cached_property
    def normalised_filter(self) -> FilterMatrices:
        """A ``(n, n)``, b ``(n, 1)`` and c ``(1, n)`` of the wind w from unit white noise v.

        The filter of n states x is dx/dxi = A x + b v, w = c x, over the distance xi flown
        normalised by the scale length, in the controllable canonical form; the variance of w is 1.
        """
        # in s, lowest power first
        numerator, denominator = (np.array(p) for p in _FILTERS[self.spectrum, self.component])
        n = denominator.size - 1
        A, b, c = np.eye(n, k=1), np.zeros((n, 1)), np.zeros((1, n))
        A[-1], b[-1] = -denominator[:-1] / denominator[-1], 1.0
        c[0, : numerator.size] = numerator
        return A, b, c / np.sqrt(c @ stationary_covariance(A, b @ b.T) @ c.T)

    def shaping_filter(self, speed: ArrayLike, altitude: ArrayLike | None = None) -> FilterMatrices:
        """Return A [1/s], b and c of the filter in time from unit white noise to the wind [m/s].

        With white noise n the filter is x' = A x + b n, w = c x. Its first states are the states of
        `normalised_filter`; with a cutoff two more follow.

        Parameters
        ----------
        speed : array_like
            Airspeed V [m/s], ``(...)``, which are leading axes of the matrices.
        altitude : array_like, optional
            Altitude [m], for a table, which broadcasts with the speed.

        Raises
        ------
        InputError
            For a speed beyond 1e-3 to 1e6 m/s, and a table without an altitude.
        """
        V = _SPEEDS("speed", speed, "m/s")
        sigma, length = self.over(altitude)
        shape = errors.broadcast(speed=V.shape, altitude=sigma.shape)
        rate, size = (  # dxi/dt [1/s] of the distance xi in scale lengths; sigma [m/s]
            np.broadcast_to(x, shape)[..., np.newaxis, np.newaxis] for x in (V / length, sigma)
        )
        A, b, c = self._filter(np.broadcast_to(length, shape))
        # white noise of unit intensity over xi has the intensity dxi/dt over time
        return A * rate, b * np.sqrt(rate), c * size

    def _filter(self, length: FloatArray) -> FilterMatrices:
        """Return A, b, c of the filter with the cutoff, over distance flown in scale lengths L.

        `length`: L [m], ``(...)``. With the wind w of `normalised_filter` and k = 2 pi L over the
        cutoff wavelength a high-pass of second order follows, v1' = k v2, v2' = k (w - v1 -
        sqrt(2) v2); its output is w - v1 - sqrt(2) v2.
        """
        A, b, c = self.normalised_filter
        if self.cutoff_wavelength is None:
            return A, b, c
        n = len(A)
        matrix = np.zeros((*length.shape, n + 2, n + 2))
        # w - v1 - sqrt(2) v2 as a row over all states
        passed = np.concatenate([c[0], [-1.0, -np.sqrt(2.0)]])
        corner = (2.0 * np.pi / self.cutoff_wavelength) * length[..., np.newaxis]
        matrix[..., :n, :n], matrix[..., n, n + 1] = A, corner[..., 0]
        matrix[..., n + 1, :] = corner * passed
        return matrix, np.concatenate([b, np.zeros((2, 1))]), passed[np.newaxis]

    def remaining_variance(self, altitude: float | None = None) -> float:
        """Return the fraction of the variance below the cutoff wavelength; one without a cutoff.

        `altitude`: altitude [m] at which a table is read. `InputError` for a table without it.
        """
        _, length = self.over(altitude)
        A, b, c = self._filter(length)  # its output has a variance of one without a cutoff
        return float((c @ stationary_covariance(A, b @ b.T) @ c.T).item())

    def power_spectrum(
        self, omega: ArrayLike, speed: float, altitude: float | None = None
    ) -> FloatArray:
        """Return the one-sided power spectrum [m^2/s^2 per rad/s], whose integral is sigma^2.

        Von Karman's is exact, without the error of the fit.

        Parameters
        ----------
        omega : array_like
            Frequencies [rad/s] of any shape, which is that of the result.
        speed, altitude : float
            Airspeed V [m/s], and altitude [m] of a table.

        Raises
        ------
        InputError
            As `shaping_filter`, and for frequencies beyond 0 to 1e9 rad/s.
        """
        V = errors.number("speed", speed, _SPEEDS, "m/s")
        sigma, length = self.over(None if altitude is None else errors.number("altitude", altitude))
        frequencies = errors.within("omega", omega, 0.0, _MAX_FREQUENCY, "rad/s")
        x = frequencies * length / V  # omega L/V, the frequency over the distance in scale lengths
        along = self.component == _ALONG
        if self.spectrum == _VON_KARMAN:
            square = (_VON_KARMAN_LENGTH_FACTOR * x) ** 2
            transverse = (1.0 + 8 / 3 * square) / (1.0 + square) ** (11 / 6)
            shape = 2.0 / (1.0 + square) ** (5 / 6) if along else transverse
        else:  # |G(j x)|^2 of Dryden's filter
            shape = 2.0 / (1.0 + x**2) if along else (1.0 + 3.0 * x**2) / (1.0 + x**2) ** 2
        if self.cutoff_wavelength is not None:
            ratio = np.minimum(frequencies / V * self.cutoff_wavelength / (2.0 * np.pi), 1e6)
            shape = shape * (ratio**4 / (1.0 + ratio**4))
        return np.asarray(sigma**2 * length / (np.pi * V) * shape)

    def samples(
        self,
        times: ArrayLike,
        speed: ArrayLike,
        *,
        altitude: ArrayLike | None = None,
        seed: int = 0,
        first: int = 0,
        runs: int = 1,
    ) -> FloatArray:
        """Return winds [m/s] at given times, ``(runs, n)``, with exactly the filter's covariance.

        The states of the filter of each step are e^(A h) times those before, plus Gaussian noise
        with the covariance that white noise adds in the step; the first are drawn from the
        stationary covariance. Run number k of a seed has the same noise whichever other runs are
        drawn.

        Parameters
        ----------
        times : array_like
            Times [s], rising, ``(n,)``.
        speed, altitude : array_like
            Airspeed [m/s] and altitude [m] at the times, ``()`` or ``(n,)``. The distance flown
            between two times is that of straight lines between their values of V/L.
        seed : int
            Seed of the noise.
        first, runs : int
            Number of the first run, and how many.

        Raises
        ------
        InputError
            For times that do not rise, numbers out of range, and a table without an altitude.
        """
        when, V = errors.times_row("times", times), _SPEEDS("speed", speed, "m/s")
        if np.any(np.diff(when) <= 0.0):
            raise errors.InputError("times must rise")
        seed, first, runs = map(errors.whole_number, ("seed", "first", "runs"), (seed, first, runs))
        if not 1 <= runs * when.size <= _MAX_SAMPLES:
            raise errors.InputError(
                f"runs must be 1 or more, with up to {_MAX_SAMPLES:.0g} samples in all; got"
                f" {errors.shown(runs)} runs of {when.size} samples"
            )
        sigma, length = self.over(altitude)
        for name, array in {"speed": V, "altitude": sigma}.items():
            if array.shape not in {(), when.shape}:
                raise errors.InputError(
                    f"{name} must be one number, or one for each of the {when.size} times; got"
                    f" shape {array.shape}"
                )
        advance, sigma = (np.broadcast_to(array, when.shape) for array in (V / length, sigma))
        distances = 0.5 * (advance[1:] + advance[:-1]) * np.diff(when)  # in scale lengths
        length = np.broadcast_to(length, when.shape)
        lengths = np.append(length[:1], 0.5 * (length[1:] + length[:-1]))
        A, b, c = self._filter(lengths)
        A = np.broadcast_to(A, (when.size, *A.shape[-2:]))
        count = A.shape[-1]
        white = [
            np.random.Generator(
                np.random.Philox(np.random.SeedSequence(seed, spawn_key=(run,)))
            ).standard_normal((when.size, count))
            for run in range(first, first + runs)
        ]
        noise = np.array(white).reshape(runs, when.size, count)
        pairs = np.stack([distances, lengths[1:]])  # steps alike in both are computed once
        _, first_of, which = np.unique(pairs, axis=1, return_index=True, return_inverse=True)
        # e^(A h), and the covariance of the noise, of each different step
        transitions, covariances = steps(A[1:][first_of], b @ b.T, distances[first_of])
        roots = _square_root(covariances)
        state = noise[:, 0] @ _square_root(stationary_covariance(A[0], b @ b.T)).T
        wind = np.empty((runs, when.size))
        wind[:, 0] = state @ c[0]
        for k, step in enumerate(which.ravel(), start=1):
            state = state @ transitions[step].T + noise[:, k] @ roots[step].T
            wind[:, k] = state @ c[0]
        return wind * sigma

    def winds(
        self,
        times: ArrayLike,
        speed: ArrayLike,
        *,
        altitude: ArrayLike | None = None,
        seed: int = 0,
        first: int = 0,
        runs: int = 1,
    ) -> SampledWind:
        """Return the wind angles w/V [rad] of `samples` as histories, a batch ``(runs,)``.

        Between the times [s] they are straight; a step well below L/V keeps the spectrum. `speed`,
        `altitude`: airspeed [m/s] and altitude [m] at the times. `seed`, `first`: seed of the
        noise, and number of the first run. `InputError` for times that do not rise, numbers out of
        range, and a table without an altitude.
        """
        wind = self.samples(times, speed, altitude=altitude, seed=seed, first=first, runs=runs)
        angle = wind / _SPEEDS("speed", speed, "m/s")
        return SampledWind(time=errors.times_row("times", times), angle=angle)


def _square_root(covariance: FloatArray) -> FloatArray:
    """Return S with S S' = P of positive semidefinite covariances P, ``(..., n, n)`` both."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0))[..., np.newaxis, :])
