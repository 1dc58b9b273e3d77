"""Margins of the loop of an autopilot with their criteria, and the verdict in words."""

from dataclasses import dataclass

from tvclin.base.lines import listed, text
from tvclin.base.quantities import satisfaction
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.detuning import Detuned, detuned
from tvclin.control.margins.bands import BandMargins
from tvclin.control.margins.criteria import Criteria, Judgement
from tvclin.control.margins.margins import Margins
from tvclin.linear.flexible import AnyPlant, FlexiblePlant


@dataclass(frozen=True, eq=False)
class JudgedMargins:
    """The margins of a loop, by band too of a flexible plant, and their criteria."""

    autopilot: Autopilot
    plant: AnyPlant
    whole: Margins
    bands: BandMargins | None
    criteria: Criteria

    @classmethod
    def of(cls, autopilot: Autopilot, plant: AnyPlant, criteria: Criteria) -> "JudgedMargins":
        """Return the margins of an autopilot with a plant, by band too where it is flexible.

        `criteria`: criteria by which they are judged.
        """
        if plant.structure is None:
            margins = autopilot.margins(plant)
            return cls(autopilot, plant, whole=margins, bands=None, criteria=criteria)
        bands = autopilot.band_margins(plant)
        return cls(autopilot, plant, whole=bands.margins, bands=bands, criteria=criteria)

    @property
    def judged(self) -> tuple[Judgement, ...]:
        """Judgement of each criterion of `criteria`: for the whole loop, and each flexible mode."""
        return self.criteria.judge(self.bands or self.whole)

    @property
    def detuned(self) -> Detuned:
        """The margins of a flexible vehicle's loop with detuned modes."""
        assert isinstance(self.plant, FlexiblePlant)  # `margins` refuses it of all else
        return detuned(self.autopilot, self.plant, criteria=self.criteria)

    @property
    def satisfied(self) -> bool:
        """Whether the margins satisfy all criteria, by frequency band of a flexible plant."""
        return bool(self.criteria.are_satisfied(self.bands or self.whole))

    @property
    def verdict(self) -> str:
        """The verdict on the criteria in words, with the margins that miss their limits."""
        head = f"criteria {self.criteria.name}: {satisfaction(self.satisfied)}"
        if not self.whole.stable:
            return f"{head}, {self.whole.reason}"
        missed = [judgement for judgement in self.judged if not judgement.satisfied]
        return f"{head} ({listed(text(item.shortfall) for item in missed)})" if missed else head
