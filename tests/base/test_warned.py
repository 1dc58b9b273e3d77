"""What is warned of, on the command line and beside an answer."""

import warnings

from tvclin.base.warned import warned


def test_each_sentence_is_told_once_and_those_of_other_packages_are_not() -> None:
    told: list[str] = []
    with warned(told.append):
        for sentence in ("a", "b", "a"):
            warnings.warn(sentence, stacklevel=1)
        with warnings.catch_warnings():
            warnings.simplefilter("always")  # as a package that shows its deprecations sets it
            for kind in (DeprecationWarning, FutureWarning, RuntimeWarning):
                warnings.warn("use another name", kind, stacklevel=1)

    assert told == ["a", "b"]
