"""The engines that fly the nonlinear equations, by name: what each is, flies and judges."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from tvclin.flights.planar.fly_planar import fly_planar
from tvclin.flights.planar.survival import planar_verdict
from tvclin.flights.sixdof.fly_sixdof import fly_sixdof
from tvclin.flights.sixdof.survival import sixdof_verdict

if TYPE_CHECKING:
    from control import TimeResponseData

Verdict = Callable[[float], bool]
"""Takes a deflection limit [rad] and says whether its flight survives."""


@dataclass(frozen=True)
class Engine:
    """One way to fly.

    Attributes
    ----------
    words : str
        What it is.
    fly : callable
        A flight, as of `fly_planar`.
    verdict : callable
        Takes a vehicle, a wind and a control, and by name the plane, whether parameters are frozen,
        and options of its own, and gives the verdict on a limit.
    """

    words: str
    fly: Callable[..., TimeResponseData]
    verdict: Callable[..., Verdict]


ENGINES: Mapping[str, Engine] = MappingProxyType(
    {
        "planar": Engine("planar equations (B1)", fly_planar, planar_verdict),
        "sixdof": Engine("six degrees of freedom (JSBSim)", fly_sixdof, sixdof_verdict),
    }
)
