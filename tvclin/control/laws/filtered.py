"""A law with filters before and behind it, which keep it from the modes of a flexible vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, each, instance
from tvclin.control.laws.law import Chains, Law, Measurement
from tvclin.kernels.control_laws import LawNumbers
from tvclin.vehicle.filters import Filter


@dataclass(frozen=True)
class FilteredLaw(Law):
    """Any law, with filters; for flights by samples.

    Parameters
    ----------
    law : Law
        The law, without filters of its own.
    filters : tuple of Filter
        Between what the law asks for and the limit, as of an `Autopilot`.
    attitude_filters, rate_filters : tuple of Filter
        Between the sensors and the law.

    Raises
    ------
    InputError
        For what is no law or no filter, batches of filters, and a law that has filters already.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> notch = tv.vehicle.Filter.notch(30.0, zero_damping=0.05, pole_damping=0.5)
    >>> law = tv.control.FilteredLaw(tv.TrimLaw(plant), filters=(notch,))
    """

    law: Law
    filters: tuple[Filter, ...] = ()
    attitude_filters: tuple[Filter, ...] = ()
    rate_filters: tuple[Filter, ...] = ()

    def __post_init__(self) -> None:
        instance("law", self.law, Law, "such as TrimLaw")
        if any(self.law.chains):
            raise InputError("law has filters already; give all of them to one FilteredLaw")
        for name in ("filters", "attitude_filters", "rate_filters"):
            chain = each(name, getattr(self, name), Filter, "Filter.notch(...)")
            if any(one.batch for one in chain):
                raise InputError(f"{name} must be single filters; a law flies with one of each")
            object.__setattr__(self, name, chain)
        for name in ("engage", "release"):
            object.__setattr__(self, name, getattr(self.law, name))

    _keys = "law attitude_filters rate_filters filters"

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """Those of the law; the flight keeps those of the filters."""
        return self.law.states

    @property
    def chains(self) -> Chains:
        """The filters."""
        return Chains(self.attitude_filters, self.rate_filters, self.filters)

    @property
    def rate_noise(self) -> tuple[float, int]:
        """That of the law, which its filters pass."""
        return self.law.rate_noise

    @property
    def numbers(self) -> LawNumbers | None:
        """Those of the law."""
        return self.law.numbers

    def demand(self, measured: Measurement, states: FloatArray, limit: Any) -> Any:
        """Return what the law asks for [rad], before the filters behind it."""
        return self.law.demand(measured, states, limit)


@dataclass(frozen=True)
class NoisyLaw(FilteredLaw):
    """A law with filters and a gyro that is noisy: its noise [rad/s], rms for each sample."""

    noise: float = 0.0
    seed: int = 0

    @property
    def rate_noise(self) -> tuple[float, int]:
        """Its own noise."""
        return self.noise, self.seed
