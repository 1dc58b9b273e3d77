"""What each question does with each part of a case: it is computed, told, or refused.

A part that a question *computes* changes its answer. Where a part is *told*, a sentence says what
was left out, and by how much where that is known. What is *refused* ends with a sentence that names
who answers it. Nothing is ignored.
"""

from __future__ import annotations

from collections.abc import Iterator

from tvclin.base.errors import one_of
from tvclin.vehicle.linear_vehicle import AnyVehicle

COMPUTED, TOLD, REFUSED = "computed", "told", "refused"
OPTIONS: dict[str, tuple[str, ...]] = {
    "structure": ("--rigid",),
    "damping": (),
    "gust": ("--gust", "--gust-at"),
    "head wind": ("--peak-deg", "--peak-speed"),
    "heading": ("--wind-direction-deg",),
    "shape of the stop": ("--stop",),
    "measured wind": ("--winds", "--winds-time", "--window"),
    "actuator": ("--actuator-frequency", "--actuator-hz", "--actuator-damping"),
    "rate limit": ("--rate-limit-deg",),
    "delay": ("--delay-ms",),
    "sample rate": ("--sample-rate",),
    "filters": ("--notch-hz", "--low-pass-hz"),
    "integral gain": ("--integral-gain",),
    "dispersion": ("--disperse",),
    "limit": ("--limit-deg",),
}
"""The parts of a case, and the options that give each; the sign of a peak makes it a head wind."""
_LOOP = ("actuator", "rate limit", "delay", "sample rate", "filters", "integral gain")
_WIND = ("gust", "head wind", "heading", "measured wind")
_SEVERAL = ("shape of the stop", "dispersion")
_REFUSED: dict[str, tuple[str, ...]] = {
    "study": (),
    "report": (),
    "respond": (*_LOOP, *_SEVERAL),
    "optimum": (*(one for one in _LOOP if one != "rate limit"), *_SEVERAL, "limit"),
    "boundary": (*_LOOP, *_WIND, *_SEVERAL, "limit"),
    "poles": (*_LOOP, *_WIND, *_SEVERAL, "limit"),
    "margins": ("rate limit", *_SEVERAL),
    "autopilot": ("rate limit", "sample rate", *_SEVERAL),
    "laws": ("integral gain", *_SEVERAL, "limit"),
    "fly": _SEVERAL,
    "size": _LOOP,
    "availability": (*_LOOP, "head wind", "dispersion"),
    "campaign": ("shape of the stop",),
}
_OF_THE_RIGID: dict[str, str] = {
    "study": "the boundaries",
    "report": "boundaries and sizes on the page",
    "autopilot": "boundaries and minimum",
    "campaign": "all but margins and flights",
    **dict.fromkeys(
        ("respond", "optimum", "boundary", "poles", "size", "availability"),
        "these numbers",
    ),
    "explore": "all here, margins too,",
    "margins --box": "the margins in the box",
    "fly --engine planar": "these numbers",
}
"""What of an answer is of the rigid vehicle, as the residue condition is; so of panel and modes."""
QUESTIONS = tuple(_REFUSED)


def entry(question: str, part: str) -> str:
    """Return what a question does with a part of a case: `COMPUTED`, `TOLD` or `REFUSED`.

    Raises
    ------
    InputError
        For a question or a part that there is not.
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
    """Return why a question has not this option, and who has; None for an option of no part."""
    for part, options in OPTIONS.items():
        if option in options and question in QUESTIONS:
            if entry(question, part) == COMPUTED:
                return (
                    f"tvclin {question} takes no {option}: the {part} is given in its file, or as"
                    f" tvclin {question} --help says"
                )
            *others, last = (f"tvclin {one}" for one in who_computes(part))
            named = f"{', '.join(others)} and {last} do" if others else f"{last} does"
            return f"tvclin {question} does not take {option}: {named}"
    return None


def told(question: str, vehicle: AnyVehicle, plane: str) -> Iterator[str]:
    """Yield a sentence for each part of a vehicle that a question leaves out."""
    if vehicle.structure is None or question not in _OF_THE_RIGID:
        return
    from tvclin.answers.flexible import shift_words  # late: of flights, which a boundary has not

    which, moved = _OF_THE_RIGID[question], shift_words(vehicle, plane)
    said = f"{which} are of the rigid vehicle, without the structure in its file"
    yield f"{said}{moved and f', which {moved}'} (tvclin margins has it)"


def table() -> str:
    """Return the table of questions by parts, in Markdown."""
    signs = {COMPUTED: "yes", TOLD: "told", REFUSED: "-"}
    lines = [["", *OPTIONS], ["---"] * (1 + len(OPTIONS))]
    lines += [[f"`{q}`", *(signs[entry(q, part)] for part in OPTIONS)] for q in QUESTIONS]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
