"""The notebook file: one cell that says what to do, and one that shows the panel."""

import json

_WORDS = """\
**How much deflection must this booster have?** Change any value: figure, margins and verdict
follow."""


def notebook_text(source: str) -> str:
    """Return the text of a notebook (.ipynb) that explores a vehicle or a study file.

    Parameters
    ----------
    source : str
        As of `explore`.
    """
    code = f"import tvclin as tv\n\ntv.explore({source!r})"
    cells = [
        {"cell_type": "markdown", "id": "words", "metadata": {}, "source": _WORDS},
        {
            "cell_type": "code",
            "id": "panel",
            "metadata": {},
            "source": code,
            "execution_count": None,
            "outputs": [],
        },
    ]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    document = {
        "cells": cells,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(document, indent=1) + "\n"
