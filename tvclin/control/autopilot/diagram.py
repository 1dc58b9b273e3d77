"""The loop, drawn once; the docstrings that speak of it show it."""

from collections.abc import Callable
from inspect import cleandoc
from textwrap import indent
from typing import Any, TypeVar

_Documented = TypeVar("_Documented", bound=Callable[..., Any])

LOOP_DIAGRAM = """\
attitude_command                          deflection_disturbance               wind
       | -                                                    |                  |
       v     +-----------+                                    |                  v
 +-->( + )-->| a0 + aI/s |--+                                 |              +-------+
 |           +-----------+  v     +-------+   +----------+    v              |       |
 |  +------->|    a1     |>(+)-x->| delay |-->| actuator |-->(+)-deflection->| plant |
 |  |        +-----------+  ^     +-------+   +----------+                   |       |
 |  |  +---->|    b0     |--+                                                +-------+
 |  |  |     +-----------+                                                     | | |
 |  |  +---------------------------- angle_of_attack --------------------------+ | |
 |  +------------------------------- attitude_rate ------------------------------+ |
 +---------------------------------- attitude -------------------------------------+

 x  deflection_command: loop() is broken here, and L is minus what returns"""


def with_diagram(documented: _Documented) -> _Documented:
    """Put the loop diagram where the docstring says LOOP_DIAGRAM."""
    text = cleandoc(documented.__doc__ or "")
    documented.__doc__ = text.replace("LOOP_DIAGRAM", "::\n\n" + indent(LOOP_DIAGRAM, "    "))
    return documented
