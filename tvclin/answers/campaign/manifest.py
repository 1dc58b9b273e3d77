"""The manifest: what a campaign is and what it is computed with, sealed with a hash.

It is written before the first chunk, every value of the campaign by its kind and its fields, in SI
units, and every chunk carries its hash. Work goes on only with the versions that it names, so that
all chunks belong together to the last bit.
"""

import json
from dataclasses import dataclass, fields, is_dataclass
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.answers.campaign.dispersions import Dispersion, Dispersions
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.nozzle import Nozzle, NozzleData
from tvclin.base.errors import InputError, missing, shown
from tvclin.base.files import called, exists, make_directory, reason, write_text
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.design_rules import AutopilotDesign
from tvclin.kernels.choice import available, remedy
from tvclin.numerics.pieces import Pieces
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, Engine, SloshTank, Structure
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History, Piecewise
from tvclin.winds.shaped import ShapedWind, WindEnsemble

NAME = "manifest.json"
_FORMAT = 2
_MENDED = (
    "delete it and run the campaign file into this folder again: that writes the same manifest, and"
    " keeps the chunks"
)
_KINDS: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        *(Campaign, Dispersions, Dispersion),
        *(Nozzle, NozzleData, Actuator, AutopilotDesign, Filter),
        *(Vehicle, Structure, BendingMode, SloshTank, Engine),
        *(ShapedWind, WindEnsemble, Piecewise, Pieces),
    )
}


@dataclass(frozen=True)
class Manifest:
    """A campaign, the versions of what computes it (with numba, if compiled), and their SHA-256."""

    campaign: Campaign
    versions: dict[str, str]
    seal: str

    @property
    def compiled(self) -> bool:
        """Whether compiled kernels are used."""
        return "numba" in self.versions


def new_manifest(campaign: Campaign, compiled: bool | None = None) -> Manifest:
    """Return the manifest of a campaign that is computed here, compiled where that can be."""
    wanted = available() if compiled is None else compiled
    versions = _versions(wanted)
    return Manifest(campaign, versions, _seal(_content(campaign, versions)))


def begin(campaign: Campaign, folder: Path, compiled: bool | None = None) -> Manifest:
    """Write the manifest into a folder, or find it there, and return it."""
    if exists(folder / NAME):
        found = read_manifest(folder)
        if written(found.campaign) != written(campaign):
            raise InputError(
                f"{called(folder)} holds another campaign, or this one before it was changed; name"
                " another folder, or put the campaign file back as it was"
            )
        return found
    made = new_manifest(campaign, compiled)
    make_directory(folder)
    document = _content(campaign, made.versions) | {"sha256": made.seal}
    write_text(folder / NAME, json.dumps(document, indent=1) + "\n")
    return made


def read_manifest(folder: Path) -> Manifest:
    """Return the manifest of a folder, unless it was changed after the campaign began."""
    file = folder / NAME
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
        seal = document.pop("sha256")
        versions, described = document["versions"], document["design"]
        kind = document["format"]
    except OSError as error:
        raise InputError(
            f"{called(folder)} holds no campaign: {NAME} cannot be read ({reason(error)})"
        ) from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise InputError(f"{called(file)} is damaged: it is no manifest; {_MENDED}") from None
    if kind != _FORMAT:
        raise InputError(f"{file} has the format {shown(kind)}, and this version reads {_FORMAT}")
    if _seal(document) != seal:
        raise InputError(
            f"{called(file)} was changed after the campaign began; put it back, or {_MENDED}"
        )
    return Manifest(read(described), versions, seal)


def check_versions(manifest: Manifest) -> None:
    """Raise `InputError` unless this process computes with what the manifest names."""
    if manifest.compiled and not available():
        begun_with = manifest.versions["numba"]
        raise InputError(
            f"the campaign uses compiled kernels (numba {begun_with}), and numba is not available"
            f" here: {remedy()}"
        )
    here = _versions(manifest.compiled)
    for name, wanted in manifest.versions.items():
        if here.get(name) != wanted:
            raise InputError(
                f"the campaign was begun with {name} {wanted}, and here is {here.get(name)}; its"
                " last bits could differ: install that version, or begin another campaign"
            )


def _versions(compiled: bool) -> dict[str, str]:
    try:
        numba = {"numba": version("numba")} if compiled else {}
    except PackageNotFoundError:
        raise missing("compiled kernels need numba", "fast") from None
    return {name: version(name) for name in ("tvclin", "numpy", "scipy")} | numba


def _content(campaign: Campaign, versions: dict[str, str]) -> dict[str, Any]:
    return {"format": _FORMAT, "versions": versions, "design": written(campaign)}


def _seal(content: dict[str, Any]) -> str:
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


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
