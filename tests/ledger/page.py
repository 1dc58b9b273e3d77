"""The validation ledger: every equation and every number of the report, against the package."""

import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from tests.ledger import attempts, companion, flown, loads
from tests.ledger.claims import claims, compute, equations, records
from tests.ledger.computed import Computed, shown

_HEAD = """\
# Validation ledger

Every equation, and every number of the text, of Borsody and Teren (NASA, Lewis Research Center,
1968). `python -m tests.ledger.page docs/validation.md` computes this page from Table I.

A printed number is reproduced when ours rounds to it in its printed digits; "about" allows one
step of the last digit. For words the criterion is an inequality, in the docstring of the function
that `tests/ledger/claims.toml` names. Of two numbers the first belongs to configuration I, the
second to II. "(after B7)" is an unnumbered equation near (B7).
"""

_CLAIMS = """\
## Claims

Of {count} claims {held} are reproduced, {failed} are not.

### Not reproduced

{failures}
None of {readings} readings gives 24 percent by drift at tau beta = 20, of normalisation, model,
abscissa, misprints, units, and factors of ten in some of W, I, N, T and F_A; the nearest is an
abscissa of 25 read as 20. No equation rounds to 38 percent at tau beta = 4, but (12) does below
{below}, as a value read from a curve may.

### Reproduced

{successes}"""

_EQUATIONS = """\
## Equations

Of {count} equations {agree} agree as printed, some as approximations or under a condition. The
proof is a test that derives the equation independently of the package;
`tests/ledger/equations.toml` has the printed form of each.

### Misprints and conditions

{exceptions}
### As printed

{exact}"""

_LOADS = """\
## Loads

The report says that control below trim also reduces angle of attack and bending moments. Peak angle
of attack over the peak of a triangular wind, on the boundary (`wind_loads`):
"""

_FLOWN = """\
## Flights

The report does not print the flights of its figures 6 to 11 as numbers. These are flown here with
the equations (B1), K = 1, at tau beta = 4: with the parameters of Table I frozen, and along a
trajectory reconstructed from it, where the wind changes the dynamic pressure. Where (18) is above
the flown limit the theory is conservative.
"""

_COMPANION = """\
## The companion report

Teren, Davidson, Borsody and Daniele (NASA TN D-4662, 1968) have the same question for whole
vehicles. Its abstract says that 99 percent winds need 2.4 deg (260-inch booster with an S-IVB).
Configuration I trims a wind of {peak:g} deg with {trim:.2f} deg at 66 s; 2.4 deg trim
{across:.0f} m/s across the flight there, and {slow:.0f} m/s at {early:g} s. A stage above the
booster can explain the factor of {factor:.1f}: {example:g} m/s need 2.4 deg where B is {ratio:.1f}
times that of Table I. Without winds, flight condition and autopilot neither report confirms or
contradicts the other.
"""

_DEVIATIONS = """\
## Where the package differs from the report

The numbers of the report are reproduced with its own rules.
"""


def page() -> str:
    """Return the whole ledger as Markdown, computed afresh."""
    parts = [_HEAD, _claims(), _equations(), _loads(), _flown(), _companion(), _deviations()]
    return "\n".join(parts)


def _equations() -> str:
    """The equations in two tables: with a correction or condition, and exactly as printed."""
    result = equations()
    exceptions = [
        (e["id"], e["printed"], f"{e['corrected']}. {e.get('why', '')}", _code(e["proof"]))
        for e in result
        if e["corrected"] != "agrees"
    ]
    exact: dict[str, list[str]] = {}
    for e in result:
        if e["corrected"] == "agrees":
            exact.setdefault(e["proof"].partition("::")[0], []).append(e["id"])
    return _EQUATIONS.format(
        count=len(result),
        agree=sum(e["corrected"].startswith("agrees") for e in result),
        exceptions=_table(("no.", "as printed", "as it should read", "proof"), exceptions),
        exact=_table(
            ("proof", "equations"), [(_code(path), ", ".join(ids)) for path, ids in exact.items()]
        ),
    )


def _claims() -> str:
    """The claims in two tables, not reproduced and reproduced, and other readings of the former."""
    computed = [(claim, compute(claim)) for claim in claims()]
    rows: dict[bool, list[Sequence[str]]] = {True: [], False: []}
    for claim, result in computed:
        rows[result.holds].append((claim["where"], claim["text"], _result(claim, result)))
    headings = ("where", "claim", "tvclin")
    readings = [*attempts.reductions_by_drift(), *attempts.reductions_with_factors_of_ten()]
    return _CLAIMS.format(
        count=len(computed),
        held=len(rows[True]),
        failed=len(rows[False]),
        failures=_table(headings, rows[False]),
        readings=len(readings),
        below=shown(attempts.rounds_to_38_below()),
        successes=_table(headings, rows[True]),
    )


def _result(claim: dict[str, str], result: Computed) -> str:
    """The claimed quantity for I and II with its unit, and the note; with a label only alone."""
    value, note = result.values[0], claim.get("verdict_note", "")
    if value.label and note:
        return note
    numbers = [shown(n) for n in (value.first, value.second) if n not in (None, "-")]
    quantity = f"{', '.join(dict.fromkeys(numbers))} {result.unit}".strip()
    text = f"{value.label}: {quantity}" if value.label else quantity
    return f"{text}. {note}" if note else text


def _loads() -> str:
    headings = ("case", "tau beta", "trim", *(f"K = {K:g}" for K in loads.DEAD_BANDS))
    result = loads.cases()
    rows = [
        [case.name, f"{case.tau_beta:g}", *(f"{x:.3f}" for x in (case.trim, *case.held))]
        for case in result
    ]
    return f"{_LOADS}\n{_table(headings, rows)}\n{_loads_verdict(result)}"


def _loads_verdict(judged: Sequence[loads.Case]) -> str:
    parts = []
    for i, K in enumerate(loads.DEAD_BANDS):
        lower = sum(case.held[i] < case.trim for case in judged)
        parts.append(f"in {lower} of {len(judged)} cases for K = {K:g}")
    return (
        f"The peak is below that of ideal trim\n{', '.join(parts)}:\n"
        "the statement holds for a control that uses its limit early, by the forecast of the\n"
        "wind.\n"
    )


def _flown() -> str:
    limits = [
        [
            "along the trajectory" if b.along else "frozen",
            b.gust.name,
            ", ".join(f"{limit:.3f}" for limit in b.flown),
            ", ".join(f"{percent:+.1f}" for percent in b.excess),
        ]
        for b in flown.boundaries()
    ]
    headings = ("parameters", "wind", "flown", "(18) above it [percent]")
    return f"{_FLOWN}\n{_table(headings, limits)}"


def _companion() -> str:
    moments = companion.moments()
    early, own = moments[0], next(m for m in moments if m.time == 66.0)
    return _COMPANION.format(
        peak=companion.PEAK,
        trim=own.trim,
        factor=companion.WIND / own.trim,
        across=own.across,
        slow=early.across,
        early=early.time,
        example=companion.EXAMPLE,
        ratio=companion.example(),
    )


def _deviations() -> str:
    rows = [
        (d["topic"], d["report"], d["package"], _code(d["proof"])) for d in records("deviation")
    ]
    return _DEVIATIONS + "\n" + _table(("topic", "the report", "tvclin", "proof"), rows)


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
