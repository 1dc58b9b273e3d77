"""How a manifest writes a campaign: every value by its kind and its fields, in SI units."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from tvclin.answers.campaign.dispersions import Dispersion, Dispersions
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.nozzle import Nozzle
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.rules import AutopilotDesign
from tvclin.kernels.pieces import Pieces
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, Engine, SloshTank, Structure
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History, Piecewise
from tvclin.winds.shaped import ShapedWind, WindEnsemble

_KINDS: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        *(Campaign, Dispersions, Dispersion, Nozzle, Actuator, AutopilotDesign, Filter),
        *(Vehicle, Structure, BendingMode, SloshTank, Engine),
        *(ShapedWind, WindEnsemble, Piecewise, Pieces),
    )
}


def written(value: Any) -> Any:
    """Return a campaign, or a part of it, as JSON holds it; of a gust its exact pieces."""
    if isinstance(value, History):
        value = Piecewise(value.pieces)
    if is_dataclass(value):
        parts = {one.name: written(getattr(value, one.name)) for one in fields(value)}
        return {"kind": type(value).__name__} | parts
    if isinstance(value, np.ndarray):
        whole = {"real": value.real.tolist(), "imag": value.imag.tolist()}
        return whole if np.iscomplexobj(value) else value.tolist()
    return [written(one) for one in value] if isinstance(value, tuple) else value


def read(record: Any) -> Any:
    """Return what was `written`; `InputError` where it is none that this version writes."""
    if isinstance(record, list):
        return tuple(read(one) for one in record)
    if not isinstance(record, dict):
        return record
    parts = {name: read(one) for name, one in record.items() if name != "kind"}
    try:
        if "kind" not in record:
            return np.array(parts["real"]) + 1j * np.array(parts["imag"])
        if record["kind"] == Pieces.__name__:
            parts = {name: np.array(one) for name, one in parts.items()}
        return _KINDS[record["kind"]](**parts)
    except (KeyError, TypeError):
        raise InputError("a manifest must hold every number of a campaign, and no others") from None
