"""What `tvclin campaign show` prints."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tvclin.answers.campaign.results import CampaignResults
    from tvclin.answers.campaign.statistics import Success


def summary(
    found: "CampaignResults",
    output: str | None,
    limit: float | None,
    probability: float | None,
    confidence: float | None,
) -> dict[str, Any]:
    """Return what `tvclin campaign show` says, as one document."""
    import numpy as np

    from tvclin.answers.campaign.outputs import required_name
    from tvclin.base.documents import picked

    plan = found.campaign
    bands = {required_name(K): K for K in plan.dead_bands}
    required = found.quantile(output, probability, confidence)
    success = found.success(limit, output, confidence)
    counts, loss = found.flights, found.loss(confidence)
    name, asked = output or found.angles[0], plan.nozzle.limit if limit is None else limit
    worst = found.worst(5, output)
    answers = np.sort(found.answers(output))[::-1][: worst.size]
    return {
        **picked(plan, "vehicle=vehicle.name model"),
        "output": name,
        "trusts_a_forecast": bands.get(name, 1.0) < 1.0,
        "cases": found.cases,
        "cases_planned": plan.cases,
        "complete": found.complete,
        "statuses": found.statuses(),
        **picked(required, "probability confidence"),
        "nominal_deg": np.degrees(found.nominal[name]) if found.nominal else None,
        "median_deg": np.degrees(np.median(found.answers(output))),
        **picked(required, "estimate_deg lower_deg upper_deg"),
        "limit_deg": None if asked is None else np.degrees(asked),
        "success": success,
        "survival": found.survival(confidence),
        "flights": None if counts is None else dict(zip(("survived", "lost"), counts, strict=True)),
        "loss": loss,
        "loss_drivers": found.loss_drivers(),
        "drivers": found.drivers(output),
        "worst": [
            {"case": int(k), "deg": np.degrees(v)} for k, v in zip(worst, answers, strict=True)
        ],
        "convergence": [
            picked(one, "cases lower_deg estimate_deg upper_deg")
            for one in found.convergence(output)
        ],
    }


def print_summary(d: dict[str, Any]) -> None:
    """Print that document."""
    from tvclin.answers.campaign.statistics import shares
    from tvclin.cli.output import print_pairs, print_table

    lost = bool(d["output"].startswith("flight_") and d["flights"]["lost"])
    of_cases, of_flights = shares(d["probability"], d["confidence"])
    percent, sure = f"{100 * d['probability']:g} %", f"{100 * d['confidence']:g} %"
    pairs = [
        ("cases", f"{d['cases']} of {d['cases_planned']}{'' if d['complete'] else ', unfinished'}"),
        *((f"  {said.split(';')[0]}", str(count)) for said, count in d["statuses"].items()),
        *([("nominal", _angle(d["nominal_deg"]))] if d["nominal_deg"] is not None else []),
        ("median", _angle(d["median_deg"])),
        (of_cases, _angle(d["estimate_deg"])),
        (of_flights, _bound(d["upper_deg"], lost)),
    ]
    said = {
        "success": f"{d['limit_deg'] or 0.0:.4f} deg are enough in",
        "survival": "survive",
        "loss": "are lost",
    }
    pairs += [(label, _share(d[key])) for key, label in said.items() if d[key] is not None]
    if d["flights"] is not None:
        counts = f"{d['flights']['survived']} survived, {d['flights']['lost']} lost"
        pairs.append(("flights", counts))
        pairs.append(("loss is driven by", _loss_drivers(d)))
    if d["trusts_a_forecast"]:
        pairs.append(("this dead band", "trusts a forecast of the wind; K = 1 needs none"))
    pairs += [
        ("driven by", ", ".join(f"{k} ({v:+.2f})" for k, v in list(d["drivers"].items())[:5])),
        ("worst cases", ", ".join(f"{one['case']} ({_angle(one['deg'])})" for one in d["worst"])),
    ]
    print_pairs(f"{d['vehicle']}, {d['model']}: {d['output']}", pairs, columns=1)
    rows = [
        [
            f"{row['cases']}",
            *(_bound(row[k], lost) for k in ("lower_deg", "estimate_deg", "upper_deg")),
        ]
        for row in d["convergence"]
    ]
    print_table(
        f"Convergence of {percent}, each bound {sure} sure",
        ["cases", "not below", "sample", "not above"],
        rows,
    )


def _share(s: "Success") -> str:
    return f"{100 * s.estimate:.2f} % ({100 * s.lower:.2f} to {100 * s.upper:.2f} %)"


def _loss_drivers(d: dict[str, Any]) -> str:
    """What drives the loss of flights, as far as the campaign's confidence reaches."""
    survived, lost = d["flights"]["survived"], d["flights"]["lost"]
    if not lost or not survived:
        return "nothing: every flight is lost" if lost else "nothing: no flight is lost"
    known = {k: v for k, v in d["loss_drivers"].items() if v.sure >= d["confidence"]}
    shown = [f"{k} ({v.rank:+.2f}, {_sure(v.sure)} sure)" for k, v in known.items()]
    return ", ".join(shown[:5]) or "nothing that stands out from chance"


def _sure(sure: float) -> str:
    return "above 99.9 %" if sure > 0.999 else f"{100 * sure:.1f} %"


def _angle(value: float) -> str:
    from math import isinf

    return "lost" if isinf(value) else f"{value:.4f} deg"


def _bound(value: float, lost: bool) -> str:
    """An angle; where flights are lost there may be no largest."""
    from math import isinf

    if not isinf(value):
        return f"{value:.4f} deg"
    return "none, flights are lost" if lost and value > 0.0 else "too few cases to say"
