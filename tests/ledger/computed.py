"""What the computation of a claim gives: numbers for both vehicles, and whether it holds."""

from typing import NamedTuple


class Value(NamedTuple):
    """One number or word behind a claim.

    Attributes
    ----------
    label : str
        What it is, and under which conditions; empty for the claimed quantity itself.
    first : float or str
        For configuration I, or for any vehicle.
    second : float, str or None
        For configuration II; None where vehicles make no difference, "-" where it is not meant.
    """

    label: str
    first: float | str
    second: float | str | None = None

    @property
    def numbers(self) -> tuple[float, ...]:
        """The numbers among both."""
        return tuple(n for n in (self.first, self.second) if isinstance(n, float))


class Computed(NamedTuple):
    """A claim, computed.

    Attributes
    ----------
    values : tuple of Value
        The claimed quantity first, then whatever its note quotes.
    holds : bool
        Whether the claim is reproduced, by the criterion of the computation.
    unit : str
        Unit of the first value.
    """

    values: tuple[Value, ...]
    holds: bool
    unit: str = ""


def rounds_to(printed: float, *numbers: float, last: float = 1.0) -> bool:
    """Return whether every number rounds to the printed one; `last` is the unit of its last digit.

    Parameters
    ----------
    printed : float
        The number as printed.
    *numbers : float
        Those of the package.
    last : float
        What one step in the last printed digit means.
    """
    return all(abs(number - printed) <= last / 2.0 for number in numbers)


def about(printed: float, *numbers: float, last: float = 1.0) -> bool:
    """Return whether every number is within one step of the last digit: "about 4" is 3 to 5.

    Parameters
    ----------
    printed, *numbers, last
        As of `rounds_to`.
    """
    return all(abs(number - printed) < last for number in numbers)


def shown(number: float | str) -> str:
    """Return a number with four significant digits, a large one with all before the point."""
    if isinstance(number, str):
        return number
    return f"{number:.0f}" if abs(number) >= 1e4 else f"{number:.4g}"
