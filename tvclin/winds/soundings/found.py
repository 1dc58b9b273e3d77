"""A sounding that was found in a file and is not yet read."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from tvclin.winds.soundings.levels import Levels


@dataclass(frozen=True)
class Found:
    """A sounding in a file.

    `read`: reads its levels. `time`: its time, as "2024-01-15 12"; empty where the file does not
    say. `notes`: notes for its levels.
    """

    read: Callable[[], Levels]
    time: str = ""
    notes: tuple[str, ...] = ()

    def noted(self, note: str) -> "Found":
        """Return the same with a note more."""
        return replace(self, notes=(*self.notes, note))

    def levels(self) -> Levels:
        """Return the levels, with the notes."""
        levels = self.read()
        return replace(levels, notes=(*levels.notes, *self.notes))
