"""What is warned of, on the command line and beside an answer."""

import warnings

from tvclin.base.package_warnings import MachineWarning, pass_warnings


def test_each_sentence_is_told_once_and_those_of_other_packages_are_not() -> None:
    messages: list[str] = []
    with pass_warnings(messages.append):
        for sentence in ("a", "b", "a"):
            warnings.warn(sentence, stacklevel=1)
        with warnings.catch_warnings():
            warnings.simplefilter("always")  # as a package that shows its deprecations sets it
            for kind in (DeprecationWarning, FutureWarning, RuntimeWarning):
                warnings.warn("use another name", kind, stacklevel=1)

    assert messages == ["a", "b"]


def test_what_is_said_of_the_machine_is_no_part_of_an_answer_and_reaches_the_command() -> None:
    messages: list[str] = []
    answer: list[str] = []
    with pass_warnings(messages.append, machine=messages.append), pass_warnings(answer.append):
        for sentence in ("numba is missing", "numba is missing", "a kernel was compiled"):
            warnings.warn(sentence, MachineWarning, stacklevel=1)
        warnings.warn("the wind is long", stacklevel=1)

    assert messages == ["numba is missing", "a kernel was compiled"]
    assert answer == ["the wind is long"]
