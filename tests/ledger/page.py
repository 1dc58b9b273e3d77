"""The validation ledger: every equation and every number of the report, against the package."""

import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from tests.ledger import attempts, companion, flown, loads
from tests.ledger.claims import claims, compute, equations, records
from tests.ledger.computed import Computed, shown

REPRODUCED, NOT_REPRODUCED = "reproduced", "**not reproduced**"

_HEAD = """\
# Validation ledger

Borsody and Teren (NASA, Lewis Research Center, 1968) against `tvclin`: every equation, and every
number of the text. This page is generated: every number in the columns "I" and "II" is computed
with the package from Table I when the page is made, and a test holds the page to it.
`python -m tests.ledger.page docs/validation.md` writes it.

## How to read it

- I and II are the vehicles of Table I. "as I" says that the vehicle makes no difference, "-" that
  only I is meant. Numbers have at most four significant digits; those of II are in the order of I.
- A printed number is *reproduced* when ours rounds to it in its printed digits; "about" allows
  one step of the last digit. For words the criterion is an inequality, in the docstring of the
  function named under "function", in `tests/ledger/claims_*.py`.
- Numbers of equations are those of the report, (B1) and (C1) those of its appendices; "(after
  B7)" is an unnumbered one near (B7).
- A proof is a test of the repository that derives the equation independently of the package. All
  variables in linear equations are deviations from the nominal flight.
"""

_EQUATIONS = """\
## Equations

{count} equations; {agree} agree as printed, some of them as approximations or under a condition
that is named.
"""

_CLAIMS = """\
## Claims

{count} claims; {held} are reproduced, {failed} are not.
"""

_TRIED = """\
## Other readings of the claims that are not reproduced

- **24 percent by drift at tau beta = 20.** {readings} readings were tried, of the normalisation,
  the model, the abscissa, misprints, slips of units, and factors of ten in some of W, I, N, T and
  F_A of Table I. None gives 24 for either vehicle; the nearest explanation is a slip of the
  abscissa, 25 read as 20, for (18) gives 24 percent at tau beta = {first} (I) and {second} (II).
  Neither (18) nor Table I is changed for it.
- **28 s in appendix C.** The exponential of (C9) taken to first order gives the printed 28; the
  claim that tau beta = 14 is the end is the same number times 0.5 1/s.
- **38 percent without dead band, or a reduction by 62.** No equation rounds to 38 at tau beta =
  4; a value read from a curve may, for (12) does below tau beta = {below}.
- {ids}: there is no other reading to try.
"""

_LOADS = """\
## Loads

The report says that control below trim also reduces angle of attack and bending moments. This is
the peak angle of attack over the peak of the wind (`wind_loads`, triangular wind, on the boundary,
while the wind blows); the bending indicator N alpha falls by the same factor.
"""

_FLOWN = """\
## Flights

The flights of figures 6 to 11 are not printed as numbers. Those below are flown here with the
equations (B1), at tau beta = 4: with the parameters of Table I frozen, and along a trajectory that
is reconstructed from Table I with an assumed altitude and specific impulse. There the wind changes
the dynamic pressure, so that in pitch its sign and size matter. Of two entries the first belongs
to I, the second to II.

The boundary limit for K = 1. It agrees where (18) is within 5 percent, and the theory is
conservative where (18) requires no less. Whether (B9) diverges faster and converges more slowly
than flights with the same limit is among the claims above.
"""

_COMPANION = """\
## The companion report

Teren, Davidson, Borsody and Daniele (NASA TN D-4662, 1968) have the same question for whole
vehicles. Of it the abstract alone was read. It says that 99 percent winds need 2.4 deg (260-inch
booster with an S-IVB) and 1.17 deg (a second vehicle), that other effects need about 0.35 deg,
and the tail-off of the thrust about 1 deg. Configuration I, the 260-inch booster of Table I,
trims a wind of {peak:g} deg with {trim:.2f} deg at 66 s; 2.4 deg trim {across:.0f} m/s across the
flight there, and {slow_across:.0f} m/s at {early:g} s. A stage above the booster, which Table I
does not name, can explain the factor of {factor:.1f}: B is in proportion to the normal force and
its arm, and {example:g} m/s across the flight need 2.4 deg where B is {ratio:.1f} times that of
Table I. The abstract tells neither winds nor flight condition nor autopilot, nor whether 2.4 deg
are a peak or a static trim. So neither confirms the other, and neither speaks against it.
"""

_DEVIATIONS = """\
## Where the package differs from the report

On purpose, in these points; the numbers of the report are reproduced with its own rules.
"""


def page() -> str:
    """Return the whole ledger as Markdown, computed afresh."""
    computed = [(claim, compute(claim)) for claim in claims()]
    parts = [_HEAD, _equations(), _claims(computed), _tried(computed), _loads()]
    parts += [_flown(), _companion(), _deviations()]
    return "\n".join(parts)


def _equations() -> str:
    keys = ("id", "printed", "corrected", "why", "proof")
    found = equations()
    rows = [[*(e[key] for key in keys[:-1]), _code(e["proof"])] for e in found]
    agree = sum(e["corrected"].startswith("agrees") for e in found)
    headings = ("no.", "as printed", "as it should read", "why", "proof")
    return _EQUATIONS.format(count=len(found), agree=agree) + "\n" + _table(headings, rows)


def _claims(computed: Sequence[tuple[dict[str, str], Computed]]) -> str:
    headings = ("where", "claim", "printed", "I", "II", "verdict", "note", "function")
    rows = [
        [
            claim["where"],
            claim["text"],
            claim["printed"],
            *_cells(found),
            REPRODUCED if found.holds else NOT_REPRODUCED,
            claim.get("verdict_note", ""),
            _code(claim["compute"]),
        ]
        for claim, found in computed
    ]
    held = sum(found.holds for _, found in computed)
    text = _CLAIMS.format(count=len(computed), held=held, failed=len(computed) - held)
    return text + "\n" + _table(headings, rows)


def _cells(found: Computed) -> tuple[str, str]:
    """The values for I, each with its label, the first with its unit, and in their order for II."""
    units = [found.unit, *[""] * (len(found.values) - 1)]
    first = [_one(v.label, v.first, unit) for v, unit in zip(found.values, units, strict=True)]
    whole = all(v.second is not None for v in found.values)
    second = [
        _one("" if whole else v.label, v.second, "") for v in found.values if v.second is not None
    ]
    return "; ".join(first), "; ".join(second) or "as I"


def _one(label: str, number: float | str, unit: str) -> str:
    text = number if isinstance(number, str) else f"{shown(number)} {unit}".strip()
    return f"{label}: {text}" if label else text


def _tried(computed: Sequence[tuple[dict[str, str], Computed]]) -> str:
    by_id = {claim["id"]: found for claim, found in computed}
    _, where, _ = by_id["drift-24-percent-at-20"].values
    first, second = (shown(number) for number in where.numbers)
    readings = [*attempts.reductions_by_drift(), *attempts.reductions_with_factors_of_ten()]
    return _TRIED.format(
        readings=len(readings),
        first=first,
        second=second,
        below=shown(attempts.rounds_to_38_below()),
        ids=", ".join(_others(by_id)),
    )


def _others(by_id: dict[str, Computed]) -> list[str]:
    failed = (name for name, found in by_id.items() if not found.holds)
    return [_code(name) for name in failed if name not in attempts.CLAIMS]


def _loads() -> str:
    headings = ("case", "tau beta", "trim", *(f"K = {K:g}" for K in loads.DEAD_BANDS))
    found = loads.cases()
    rows = [
        [case.name, f"{case.tau_beta:g}", *(f"{x:.3f}" for x in (case.trim, *case.held))]
        for case in found
    ]
    return f"{_LOADS}\n{_table(headings, rows)}\n{_loads_verdict(found)}"


def _loads_verdict(found: Sequence[loads.Case]) -> str:
    parts = []
    for i, K in enumerate(loads.DEAD_BANDS):
        lower = sum(case.held[i] < case.trim for case in found)
        parts.append(f"in {lower} of {len(found)} cases for K = {K:g}")
    return (
        f"The peak is below that of ideal trim\n{', '.join(parts)}.\n"
        "So the statement holds for a control that uses its limit before it must, by the forecast\n"
        "of the wind. For K = 1 the vehicle is trimmed until the limit is reached, and from then\n"
        "on its angle of attack at first grows faster than with trim.\n"
    )


def _flown() -> str:
    limits = [
        [
            _parameters(b.along),
            b.gust.name,
            ", ".join(f"{limit:.3f}" for limit in b.flown),
            ", ".join(f"{percent:+.1f}" for percent in b.excess),
            _yes(b.agree),
            _yes(b.conservative),
        ]
        for b in flown.boundaries()
    ]
    first = ("parameters", "wind", "flown", "(18) above it [percent]", "agrees", "conservative")
    return f"{_FLOWN}\n{_table(first, limits)}"


def _parameters(along: bool) -> str:
    return "along the trajectory" if along else "frozen"


def _yes(verdicts: Iterable[bool]) -> str:
    return ", ".join("yes" if verdict else "no" for verdict in verdicts)


def _companion() -> str:
    found = companion.moments()
    early, own = found[0], next(m for m in found if m.time == 66.0)
    return _COMPANION.format(
        peak=companion.PEAK,
        trim=own.trim,
        factor=companion.WIND / own.trim,
        across=own.across,
        slow_across=early.across,
        early=early.time,
        example=companion.EXAMPLE,
        ratio=companion.example(),
    )


def _deviations() -> str:
    keys = ("topic", "report", "package", "why")
    rows = [[*(d[key] for key in keys), _code(d["proof"])] for d in records("deviation")]
    return _DEVIATIONS + "\n" + _table(("topic", "the report", "tvclin", "why", "proof"), rows)


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [headings, ["---"] * len(headings), *([_safe(cell) for cell in row] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _safe(text: str) -> str:
    """Markdown of a text: nothing ends a cell, and no formula becomes emphasis or a link."""
    parts = re.split(r"(`[^`]*`|\*\*[^*]*\*\*)", " ".join(text.split()))
    parts[::2] = [re.sub(r"([*<])", r"\\\1", part).replace("](", "]\\(") for part in parts[::2]]
    return "".join(parts).replace("|", "\\|")


def _code(text: str) -> str:
    return f"`{text}`"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(page(), encoding="utf-8")
