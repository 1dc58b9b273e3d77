"""The response of one loop to a wind as python-control's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.winds.histories import History

if TYPE_CHECKING:
    import control


def wind_response(
    times: FloatArray,
    outputs: FloatArray,
    wind: History,
    labels: tuple[str, ...],
    *,
    name: str,
    title: str,
) -> control.TimeResponseData:
    """Return a response to a wind alone as `control.TimeResponseData`.

    `times`, `outputs`: times [s], ``(m,)``, and the outputs there, ``(n, m)``, with their names.
    `name`, `title`: what responds, and the title of its plot.
    """
    from control import TimeResponseData

    return TimeResponseData(
        times,
        outputs,
        None,
        wind(times)[np.newaxis],
        issiso=False,
        output_labels=list(labels),
        input_labels=["wind"],
        sysname=name,
        plot_inputs=True,
        title=f"{title} [rad, rad/s]",
        trace_types=["forced"],
    )
