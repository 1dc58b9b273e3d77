"""Time from a moved widget to the first new picture, in the kernel, for each law and some widgets.

Processor time, the median and the worst of ten moves; the worst has new axes to draw.
Run: python benchmarks/explorer_moves.py
"""

import asyncio
from statistics import median
from time import process_time

from tvclin.show.explorer.choices import CONTROLS, OWN
from tvclin.show.explorer.panel import Panel

MOVES = {
    "duration": ("wind duration", [7.6 + 0.3 * k for k in range(10)]),
    "dead_band": ("dead-band", [0.95 - 0.03 * k for k in range(10)]),
    "limit": ("limit", [0.41 + 0.01 * k for k in range(10)]),
    "attitude_gain": ("gain a0", [0.55 + 0.01 * k for k in range(10)]),
}


def times(panel: Panel, field: str, values: list[float]) -> list[float]:
    """Return how long [ms] each move takes; the widget is put back."""
    control = panel.controls[field]
    before, found = control.value, []
    for value in values:
        start = process_time()
        control.value = value
        found.append(1e3 * (process_time() - start))
    control.value = before
    return found


async def main() -> None:
    """Print the table; what the panel finds at rest is not waited for."""
    panel = Panel("configuration-i")
    panel.controls["design"].value = OWN
    print("| law | " + " | ".join(label for label, _ in MOVES.values()) + " |")
    print("| --- |" + " --- |" * len(MOVES))
    for shift, law in enumerate(CONTROLS):
        panel.controls["law"].value = law
        panel.controls["peak"].value = 5.0 + 0.1 * shift  # else much is known from the last law
        cells = []
        for field, (_, values) in MOVES.items():
            fresh = [value + 1e-4 * shift for value in values]
            found = times(panel, field, fresh)
            cells.append(f"{median(found):.0f}, {max(found):.0f} ms")
        print(f"| {law} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    asyncio.run(main())
