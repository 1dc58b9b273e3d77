"""The report's control as it is flown: what is trimmed is measured, not planned."""

from dataclasses import dataclass

from tvclin.errors import within


@dataclass(frozen=True)
class ReportControl:
    """Trim until K times the deflection limit is asked for, then the whole limit for ever.

    The dead band is left by the trim deflection itself, which is the literal switch of
    `trim_then_hold`, but trim is what the measured angle of attack asks for.

    Parameters
    ----------
    dead_band : float
        K, from 0 to 1; zero applies the limit when the wind sets in.

    Raises
    ------
    InputError
        For a dead band outside [0, 1].
    """

    dead_band: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "dead_band", float(within("dead_band", self.dead_band, 0.0, 1.0)))
