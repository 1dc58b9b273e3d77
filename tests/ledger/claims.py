"""The report's equations and claims as records, and the computation behind each claim."""

import tomllib
from collections.abc import Callable
from pathlib import Path

from tests.ledger import claims_appendices, claims_boundary, claims_flown, claims_response
from tests.ledger.computed import Computed

COMPUTATIONS: dict[str, Callable[[], Computed]] = {
    function.__name__: function
    for claims in (claims_boundary, claims_response, claims_appendices)
    for function in claims.FUNCTIONS
} | claims_flown.COMPUTATIONS
"""The function of every `compute` identifier of claims.toml; each computes from Table I."""


def equations() -> list[dict[str, str]]:
    """Return the report's equations: id, page_section, printed, corrected, why (or none), proof."""
    return records("equation")


def claims() -> list[dict[str, str]]:
    """Return the report's claims: id, where, text, printed, compute and perhaps verdict_note."""
    return records("claim")


def compute(claim: dict[str, str]) -> Computed:
    """Return a claim computed with the package."""
    return COMPUTATIONS[claim["compute"]]()


def records(kind: str) -> list[dict[str, str]]:
    """Return the records of one of the files of this folder, in the order in which they stand.

    Parameters
    ----------
    kind : {"equation", "claim", "deviation"}
        What the file lists; it has the same name in the plural.
    """
    text = Path(__file__).with_name(f"{kind}s.toml").read_text(encoding="utf-8")
    computed: list[dict[str, str]] = tomllib.loads(text)[kind]
    return computed
