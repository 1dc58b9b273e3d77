"""Use of each part of a case by each question: computed, told in a note, or refused.

A part that a question *computes* changes its answer. Where a part is *told*, a note says what is
omitted, and by how much where that is known. A part that is *refused* ends with a sentence that
names the questions that compute it. No part is ignored.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from tvclin.base.errors import one_of
from tvclin.base.lines import listed
from tvclin.case.case import Case
from tvclin.case.nozzle import USUAL_ACTUATOR
from tvclin.winds.histories import History

COMPUTED, TOLD, REFUSED = "computed", "told", "refused"
OPTIONS: dict[str, tuple[str, ...]] = {
    "structure": ("--rigid",),
    "damping": (),
    "gust": ("--gust", "--gust-speed", "--gust-plateau", "--gust-at"),
    "head wind": ("--peak-deg", "--peak-speed"),
    "sign that counts": ("--sign",),
    "heading": ("--wind-direction-deg",),
    "shape of the stop": ("--stop",),
    "measured wind": (
        *("--winds", "--winds-time", "--winds-format", "--units", "--above-ground"),
        *("--window", "--bias", "--bias-month"),
    ),
    "actuator": ("--actuator-frequency", "--actuator-hz", "--actuator-damping"),
    "rate limit": ("--rate-limit-deg",),
    "delay": ("--delay-ms",),
    "sample rate": ("--sample-rate",),
    "filters": ("--notch-hz", "--low-pass-hz"),
    "gains": (
        *("--design", "--natural-frequency", "--damping"),
        *("--attitude-gain", "--rate-gain", "--alpha-gain", "--integral-gain"),
    ),
    "dispersion": ("--disperse",),
    "limit": ("--limit-deg",),
    "torque, power, travel and acceleration limits": (),
}
"""Parts of a case, and the options that give each; the sign of a peak makes it a head wind, and a
sign that counts selects an encountered dynamic pressure."""
_LAW = ("actuator", "delay", "filters")
_LOOP = (*_LAW, "rate limit", "sample rate", "gains")
_WIND = ("gust", "head wind", "sign that counts", "heading", "measured wind")
_WORK = "torque, power, travel and acceleration limits"
_SEVERAL = ("shape of the stop", "dispersion", _WORK)
_CALM = ("sign that counts", *_SEVERAL)
_REFUSED: dict[str, tuple[str, ...]] = {
    "study": (_WORK,),
    "report": (_WORK,),
    "respond": (*_LOOP, *_CALM),
    "optimum": (*(part for part in _LOOP if part != "rate limit"), *_CALM, "limit"),
    "boundary": (*_LOOP, *_WIND, *_SEVERAL, "limit"),
    "poles": (*_LOOP, *_WIND, *_SEVERAL, "limit"),
    "margins": _CALM,
    "autopilot": _SEVERAL,
    "laws": (*_CALM, "limit"),
    "fly": _CALM,
    "nozzle": ("sign that counts", "shape of the stop", "dispersion"),
    "loads": _CALM,
    "card": ("dispersion",),
    "size": (*(part for part in _LOOP if part != "rate limit"), _WORK),
    "availability": (*_LOOP, "dispersion", _WORK),
    "campaign": (_WORK,),
    "explore": ("measured wind", "dispersion", _WORK),
}
_ONLY_ASIDE: dict[str, tuple[str, ...]] = {
    "margins without --flown": ("rate limit", "limit"),
    "margins without --flown and --box": ("gust", "head wind", "heading"),
    "laws of a rigid vehicle": _LAW,
    "laws with a rate in [laws]": ("sample rate",),
    "fly --engine planar": (*_LAW, "rate limit", "sample rate"),
    "fly without --law autopilot": ("gains",),
    "card without the law autopilot": ("gains",),
    "nozzle without --law": (*_LAW, "sample rate", "gains", _WORK),
    "loads without --law": (*_LAW, "sample rate", "gains"),
}
"""Parts that a question computes, and omits with or without these options."""
_LIMITS_OF_WORK = ("torque_limit", "power_limit", "travel_limit", "acceleration_limit")
_HERE = "these numbers"
_OF_THE_RIGID: dict[str, str] = {
    "study": "the boundaries",
    "report": "boundaries and sizes on the page",
    "autopilot": "boundaries and minimum",
    "campaign": "all but margins and flights",
    "nozzle": "angles over rates",
    "loads": "angles over loads",
    **dict.fromkeys(
        ("respond", "optimum", "boundary", "poles", "card", "size", "availability"),
        _HERE,
    ),
    "explore": "boundaries and the open-loop response",
    "margins --box": "the margins in the box",
    "fly --engine planar": _HERE,
}
"""Numbers of an answer that are those of the rigid vehicle, by question."""
QUESTIONS = tuple(_REFUSED)


def entry(question: str, part: str) -> str:
    """Return the use of a part of a case by a question: `COMPUTED`, `TOLD` or `REFUSED`.

    `InputError` for an unknown question or part.
    """
    one_of("question", question, QUESTIONS)
    one_of("part", part, OPTIONS)
    if part in _REFUSED[question]:
        return REFUSED
    return TOLD if part == "structure" and question in _OF_THE_RIGID else COMPUTED


def who_computes(part: str) -> list[str]:
    """Return the questions that compute a part of a case."""
    return [question for question in QUESTIONS if entry(question, part) == COMPUTED]


def refusal(question: str, option: str) -> str | None:
    """Return the message that refuses an option to a question; None for an option of no part."""
    for part, options in OPTIONS.items():
        if option in options and question in QUESTIONS:
            if entry(question, part) == COMPUTED:
                return (
                    f"tvclin {question} takes no {option}: a study file gives it the {part}"
                    " (tvclin init --study my.toml writes one)"
                )
            commands = [f"tvclin {command}" for command in who_computes(part)]
            do = "do" if len(commands) > 1 else "does"
            return f"tvclin {question} does not take {option}: {listed(commands)} {do}"
    return None


def told(case: Case, *questions: str) -> Iterator[str]:
    """Yield a note for each part of a case that questions omit.

    `questions`: of `QUESTIONS`, or with the words for an option, such as "margins --box".
    """
    of_the_rigid = [question for question in questions if question in _OF_THE_RIGID]
    if case.vehicle.structure is not None:
        for question in of_the_rigid:
            from tvclin.case.flexible_autopilot import shift_words  # late: of flights

            which, moved = _OF_THE_RIGID[question], shift_words(case.vehicle, case.plane)
            said = f"{which} are of the rigid vehicle, without the structure in its file"
            yield f"{said}{moved and f', which {moved}'} (tvclin margins has it)"
    flown = case.law_model if "laws" in questions else case.loop_model
    if flown != case.model and not any(map(wholly_rigid, questions)):
        drift = case.model == "drift"
        why = "leaves out the structure" if drift else "has a speed, which laws are not shown"
        yield f"the model is {flown}: {case.model} {why}"
    omitted = {
        part
        for question in questions
        for part in (*_REFUSED.get(question, ()), *_ONLY_ASIDE.get(question, ()))
    }
    named = _given(case, omitted)
    for who, parts in (("study", set(named) - {_WORK}), ("card", set(named) & {_WORK})):
        if parts:
            of = listed([part for part in named if part in parts])
            yield f"what the file says of {of} is left out here; tvclin {who} has it"


def wholly_rigid(question: str) -> bool:
    """Return whether all numbers of a question are those of the rigid vehicle."""
    return _OF_THE_RIGID.get(question) == _HERE


def _given(case: Case, omitted: set[str]) -> list[str]:
    """Return the omitted parts that a case has, without structure and damping."""
    nozzle, wind = case.nozzle, case.wind
    sizing, dispersions = getattr(case, "sizing", None), getattr(case, "dispersions", None)
    tests: dict[str, Callable[[], Any]] = {
        "gust": lambda: getattr(wind, "gust", None) is not None,
        "head wind": lambda: getattr(wind, "peak", 0.0) < 0.0,
        "sign that counts": lambda: case.sign is not None,
        "heading": lambda: case.heading is not None,
        "shape of the stop": lambda: nozzle.stop is not None,
        "measured wind": lambda: sizing and sizing.soundings and not isinstance(wind, History),
        "actuator": lambda: nozzle.actuator != USUAL_ACTUATOR,
        "rate limit": lambda: nozzle.rate_limit is not None,
        "delay": lambda: case.asked.delay > 0.0,
        "sample rate": lambda: case.asked.sample_rate is not None,
        "filters": lambda: any(case.asked.chains.values()),
        "gains": lambda: (
            replace(case.asked.without_filters_and_delay, sample_rate=None) != type(case.asked)()
        ),
        "dispersion": lambda: dispersions is not None and dispersions.distributions,
        "limit": lambda: nozzle.limit is not None,
        _WORK: lambda: any(vars(nozzle)[name] is not None for name in _LIMITS_OF_WORK),
    }
    return [part for part, given in tests.items() if part in omitted and given()]


def table() -> str:
    """Return the table of questions by parts, in Markdown."""
    signs = {COMPUTED: "yes", TOLD: "told", REFUSED: "-"}
    lines = [["", *OPTIONS], ["---"] * (1 + len(OPTIONS))]
    lines += [[f"`{q}`", *(signs[entry(q, part)] for part in OPTIONS)] for q in QUESTIONS]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
