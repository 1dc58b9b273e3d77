"""What `tvclin campaign show` prints."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tvclin.campaign import CampaignResults


def summary(
    found: "CampaignResults",
    output: str | None,
    limit: float | None,
    probability: float | None,
    confidence: float | None,
) -> dict[str, Any]:
    """Return what `tvclin campaign show` says, as one document."""
    import numpy as np

    plan = found.campaign
    required = found.quantile(output, probability, confidence)
    success = found.success(limit, output, confidence)
    name, asked = output or found.angles[0], plan.limit if limit is None else limit
    survival = found.survival(confidence)
    worst = found.worst(5, output)
    answers = np.sort(found.answers(output))[::-1][: worst.size]
    return {
        "vehicle": plan.vehicle.name,
        "model": plan.model,
        "output": name,
        "cases": found.cases,
        "cases_planned": plan.cases,
        "complete": found.complete,
        "statuses": found.statuses(),
        "probability": required.probability,
        "confidence": required.confidence,
        "nominal_deg": np.degrees(found.nominal[name]) if found.nominal else None,
        "median_deg": np.degrees(np.median(found.answers(output))),
        "estimate_deg": np.degrees(required.estimate),
        "lower_deg": np.degrees(required.lower),
        "upper_deg": np.degrees(required.upper),
        "limit_deg": None if asked is None else np.degrees(asked),
        "success": None if success is None else vars(success),
        "survival": None if survival is None else vars(survival),
        "drivers": found.drivers(output),
        "worst": [
            {"case": int(k), "deg": np.degrees(v)} for k, v in zip(worst, answers, strict=True)
        ],
        "convergence": [
            {
                "cases": one.cases,
                "lower_deg": np.degrees(one.lower),
                "estimate_deg": np.degrees(one.estimate),
                "upper_deg": np.degrees(one.upper),
            }
            for one in found.convergence(output)
        ],
    }


def print_summary(d: dict[str, Any]) -> None:
    """Print that document."""
    from tvclin.cli.output import print_pairs, print_table

    percent, sure = f"{100 * d['probability']:g} %", f"{100 * d['confidence']:g} %"
    pairs = [
        ("cases", f"{d['cases']} of {d['cases_planned']}{'' if d['complete'] else ', unfinished'}"),
        *((f"  {said.split(';')[0]}", str(count)) for said, count in d["statuses"].items()),
        *([("nominal", f"{d['nominal_deg']:.4f} deg")] if d["nominal_deg"] is not None else []),
        ("median", f"{d['median_deg']:.4f} deg"),
        (f"{percent} of the cases", f"{d['estimate_deg']:.4f} deg"),
        (f"{percent} of flights, {sure} sure", _bound(d["upper_deg"])),
        ("driven by", ", ".join(f"{k} ({v:+.2f})" for k, v in list(d["drivers"].items())[:5])),
        ("worst cases", ", ".join(f"{one['case']} ({one['deg']:.4f} deg)" for one in d["worst"])),
    ]
    said = {"success": f"{d['limit_deg'] or 0.0:.4f} deg are enough in", "survival": "survive"}
    for key, label in said.items():
        if d[key] is not None:
            pairs.insert(-2, (label, _share(d[key])))
    print_pairs(f"{d['vehicle']}, {d['model']}: {d['output']}", pairs, columns=1)
    rows = [
        [f"{row['cases']}", *(_bound(row[k]) for k in ("lower_deg", "estimate_deg", "upper_deg"))]
        for row in d["convergence"]
    ]
    print_table(
        f"Convergence of {percent}, each bound {sure} sure",
        ["cases", "not below", "sample", "not above"],
        rows,
    )


def _share(s: dict[str, float]) -> str:
    return f"{100 * s['estimate']:.2f} % ({100 * s['lower']:.2f} to {100 * s['upper']:.2f} %)"


def _bound(value: float) -> str:
    from math import isinf

    return "too few cases to say" if isinf(value) else f"{value:.4f} deg"
