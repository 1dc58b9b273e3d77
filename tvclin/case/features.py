"""Use of each feature of a case by each question: computed, omitted with a note, or refused.

A feature that a question *computes* changes its result. For a feature that is *noted*, a note says
that it is omitted, and its effect where that is known. A *refused* feature ends with an error
message that names the questions that compute it. No feature is ignored.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from typing import Any

from tvclin.base.lines import listed
from tvclin.case.case import Case
from tvclin.case.nozzle import USUAL_ACTUATOR
from tvclin.winds.shaped import ShapedWind

COMPUTED, NOTED, REFUSED = "computed", "noted", "refused"
OPTIONS: dict[str, tuple[str, ...]] = {
    "structure": (),
    "damping": (),
    "gust": (),
    "head wind": ("--peak-deg", "--peak-speed"),
    "sign that counts": ("--sign",),
    "heading": (),
    "limit shape": ("--limit-shape",),
    "measured wind": ("--winds",),
    "actuator": (),
    "rate limit": ("--rate-limit-deg",),
    "delay": ("--delay-ms",),
    "sample rate": ("--sample-rate",),
    "filters": (),
    "gains": (
        *("--design", "--natural-frequency", "--damping"),
        *("--attitude-gain", "--rate-gain"),
    ),
    "dispersion": (),
    "turbulence": (),
    "limit": ("--limit-deg",),
    "torque, power, travel and acceleration limits": (),
}
"""Options by feature of a case; the sign of a peak makes it a head wind, and a sign that counts
selects an encountered dynamic pressure."""
_LAW = ("actuator", "delay", "filters")
_LOOP = (*_LAW, "rate limit", "sample rate", "gains")
_WIND = ("gust", "head wind", "sign that counts", "heading", "measured wind")
_WORK = "torque, power, travel and acceleration limits"
_STUDY_FEATURES = ("limit shape", "dispersion", "turbulence", _WORK)
_NOMINAL_PRESSURE = ("sign that counts", *_STUDY_FEATURES)
_REFUSED: dict[str, tuple[str, ...]] = {
    "study": (_WORK,),
    "report": (_WORK,),
    "respond": (*_LOOP, *_NOMINAL_PRESSURE),
    "boundary": (
        *(feature for feature in _LOOP if feature != "rate limit"),
        *_NOMINAL_PRESSURE,
        "limit",
    ),
    "boundary --tau-beta": (*_LOOP, *_WIND, *_STUDY_FEATURES, "limit"),
    "poles": (*_LOOP, *_WIND, *_STUDY_FEATURES, "limit"),
    "design": (*_NOMINAL_PRESSURE, "rate limit", "limit"),
    "margins": _NOMINAL_PRESSURE,
    "fly": _STUDY_FEATURES,
    "fly --law all": (*_NOMINAL_PRESSURE, "limit"),
    "nozzle": ("limit shape", "dispersion", "turbulence"),
    "nozzle --over load": _NOMINAL_PRESSURE,
    "nozzle --over flight": ("dispersion",),
    "ascent": ("dispersion", _WORK),
    "availability": (*_LOOP, "dispersion", "turbulence", _WORK),
    "disperse": ("turbulence", _WORK),
    "explore": ("measured wind", "dispersion", "turbulence", _WORK),
}
_OMITTED_BY_OPTIONS: dict[str, tuple[str, ...]] = {
    "margins without --limit-deg": ("rate limit", "limit"),
    "margins without a wind": ("gust", "head wind", "heading"),
    "margins along a flight": ("rate limit", "limit", "gust", "head wind", "heading"),
    "laws of a rigid vehicle": _LAW,
    "laws with a rate in [laws]": ("sample rate",),
    "fly --engine planar": (*_LAW, "rate limit", "sample rate"),
    "fly along a flight": tuple(f for f in _STUDY_FEATURES if f != "limit shape"),
    "fly without --law autopilot": ("gains",),
    "fly without the autopilot requirement": ("sign that counts",),
    "nozzle without --law": (*_LAW, "sample rate", "gains", "sign that counts", _WORK),
    "nozzle --over load without --law": (*_LAW, "sample rate", "gains"),
    "nozzle --over flight without the law autopilot": ("gains",),
    "disperse without flights": ("rate limit",),
    "disperse without flights and margins": _LOOP,
    "ascent without turbulence": tuple(feature for feature in _LOOP if feature != "rate limit"),
}
"""Features that a question computes, but omits with or without these options."""
_COMPUTED_WITH_OPTION = dict.fromkeys(
    ("margins without --limit-deg", "margins without a wind"), "margins --limit-deg"
)
"""Command that computes these features, by question that omits them without its option."""
_LIMITS_OF_WORK = ("torque_limit", "power_limit", "travel_limit", "acceleration_limit")
_ALL_NUMBERS = "these numbers"
_RIGID_NUMBERS: dict[str, str] = {
    "study": "the boundaries",
    "report": "boundaries and sizes on the page",
    "disperse": "all but margins and flights",
    "poles": "residues, and the poles of each model,",
    "nozzle": "angles over rates",
    "nozzle --over load": "angles over loads",
    **dict.fromkeys(
        (
            *("respond", "boundary", "boundary --tau-beta", "nozzle --over flight"),
            *("ascent", "availability"),
        ),
        _ALL_NUMBERS,
    ),
    "explore": "boundaries and the open-loop response",
    "design --box": "the margins in the box",
    "fly --law autopilot": "boundaries and minimum",
    "fly --engine planar": _ALL_NUMBERS,
}
"""Numbers of a result that are computed for the rigid vehicle, by question."""
QUESTIONS = tuple(_REFUSED)
_OF_PULSES = ("study", "nozzle --over flight")
_OF_SOUNDINGS = ("ascent", "disperse", "nozzle --over flight")
"""Questions that together compute every feature: of a wind of one shape, and of a sounding but for
those of `_LOOP`."""
_LOOP_IN_SOUNDINGS = "fly --engine linear"
"""Question that computes the features of `_LOOP` in a sounding, at one time and along a flight."""


def use_of(question: str, feature: str) -> str:
    """Return the use of a feature of a case by a question: `COMPUTED`, `NOTED` or `REFUSED`.

    Computed, it changes the result; noted, a note says that it is omitted; refused, it is an error.
    """
    if feature in _REFUSED[question]:
        return REFUSED
    return NOTED if feature == "structure" and question in _RIGID_NUMBERS else COMPUTED


def computing_questions(feature: str) -> list[str]:
    """Return the questions (commands, as "study") that compute a feature of a case, as "gust"."""
    return [question for question in QUESTIONS if use_of(question, feature) == COMPUTED]


def refusal(question: str, option: str, key: str | None = None) -> str | None:
    """Return the message that refuses an option to a question; None for any other option.

    `question`: name in `QUESTIONS`. `option`: option of the command line, such as "--sign". `key`:
    the key of --set that gives the same, where the question takes --set.
    """
    for feature, options in OPTIONS.items():
        if option in options and question in QUESTIONS:
            if (question, feature) == ("study", "measured wind"):  # along a flight of its file
                do = f"tvclin ascent VEHICLE {option} FILE --azimuth-deg DEG answers for a sounding"
                return f"tvclin study is of a wind of one shape and takes no {option}: {do}"
            if use_of(question, feature) == COMPUTED:  # but taken from a file or --set alone
                writes = "(tvclin init --study my.toml writes one)"
                by_file = f"a study file gives it the {feature} {writes}"
                by_key = f"--set {key} VALUE gives it"
                return f"tvclin {question} takes no {option}: {by_key if key else by_file}"
            commands = [f"tvclin {command}" for command in computing_questions(feature)]
            do = "do" if len(commands) > 1 else "does"
            return f"tvclin {question} does not take {option}: {listed(commands)} {do}"
    return None


def omission_notes(case: Case, *questions: str, tables: Collection[str] = ()) -> Iterator[str]:
    """Yield a note for each feature of a case that questions omit.

    Numbers of some questions are of the rigid vehicle, so that its structure is omitted; other
    features a question refuses, or does not compute with some options. `questions`: names in
    `QUESTIONS`, or a name with an option, such as "design --box". `tables`: tables of the file of a
    case, of features that the case itself does not hold.
    """
    rigid_questions = [question for question in questions if question in _RIGID_NUMBERS]
    if case.vehicle.structure is not None:
        for question in rigid_questions:
            from tvclin.case.flexible_autopilot import shift_words  # late: of flights

            numbers, shift = _RIGID_NUMBERS[question], shift_words(case.vehicle, case.plane)
            sentence = f"{numbers} are of the rigid vehicle, without the structure in its file"
            yield f"{sentence}{shift and f', which {shift}'} (tvclin margins has it)"
    if case.plant_system is not None:
        for question in rigid_questions:
            numbers = _RIGID_NUMBERS[question]
            sentence = f"{numbers} are of the vehicle, without the plant in its file"
            yield f"{sentence} (tvclin margins has it)"
    # "drift" has no structure, and laws measure no speed: another model takes its place
    flown = case.law_model if "fly --law all" in questions else case.loop_model
    if flown != case.model and not any(map(is_rigid_only, questions)):
        drift = case.model == "drift"
        why = "leaves out the structure" if drift else "has a speed, which laws are not shown"
        yield f"the model is {flown}: {case.model} {why}"
    omitted = {
        feature
        for question in questions
        for feature in (*_REFUSED.get(question, ()), *_OMITTED_BY_OPTIONS.get(question, ()))
    }
    named = _specified_features(case, omitted, tables)
    sizing = getattr(case, "sizing", None)  # of a flight, with its soundings
    measured = not isinstance(case.wind, ShapedWind) or bool(sizing and sizing.soundings)
    # questions that compute the features in such a wind
    candidates = _OF_SOUNDINGS if measured else _OF_PULSES
    counting: dict[str, list[str]] = {}  # omitted features, by a question that computes them
    for feature in named:
        with_option = [
            command
            for question, command in _COMPUTED_WITH_OPTION.items()
            if question in questions and feature in _OMITTED_BY_OPTIONS[question]
        ]
        if with_option:
            question = with_option[0]
        elif measured and feature in _LOOP:
            question = _LOOP_IN_SOUNDINGS
        else:
            question = next(name for name in candidates if use_of(name, feature) == COMPUTED)
        counting.setdefault(question, []).append(feature)
    for question, features in counting.items():
        yield f"not counted here: {listed(features)} (tvclin {question} counts it)"


def is_rigid_only(question: str) -> bool:
    """Return whether all numbers of a question are computed for the rigid vehicle."""
    return _RIGID_NUMBERS.get(question) == _ALL_NUMBERS


def _specified_features(case: Case, omitted: set[str], tables: Collection[str]) -> list[str]:
    """Return the omitted features that a case specifies, other than structure and damping.

    `omitted`: names of features in `OPTIONS`. `tables`: tables of the file of the case.
    """
    nozzle, wind = case.nozzle, case.wind
    # the plan of a study file has these, another case has not
    sizing, dispersions = getattr(case, "sizing", None), getattr(case, "dispersions", None)
    tests: dict[str, Callable[[], Any]] = {
        "gust": lambda: getattr(wind, "gust", None) is not None,
        "head wind": lambda: getattr(wind, "peak", 0.0) < 0.0,
        "sign that counts": lambda: case.sign is not None,
        "heading": lambda: case.heading is not None,
        "limit shape": lambda: nozzle.limit_shape is not None,
        "measured wind": lambda: sizing and sizing.soundings and isinstance(wind, ShapedWind),
        "actuator": lambda: nozzle.actuator != USUAL_ACTUATOR,
        "rate limit": lambda: nozzle.rate_limit is not None,
        "delay": lambda: case.autopilot_design.delay > 0.0,
        "sample rate": lambda: case.autopilot_design.sample_rate is not None,
        "filters": lambda: any(case.autopilot_design.chains.values()),
        # a controller, or more in the design than filters, delay and sample rate
        "gains": lambda: (
            case.controller is not None
            or replace(case.autopilot_design.without_filters_and_delay, sample_rate=None)
            != type(case.autopilot_design)()
        ),
        "dispersion": lambda: dispersions is not None and dispersions.distributions,
        "turbulence": lambda: (
            "turbulence" in tables or getattr(case, "turbulence", None) is not None
        ),
        "limit": lambda: nozzle.limit is not None,
        _WORK: lambda: any(vars(nozzle)[name] is not None for name in _LIMITS_OF_WORK),
    }
    return [
        feature for feature, is_specified in tests.items() if feature in omitted and is_specified()
    ]
