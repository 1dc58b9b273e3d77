"""The manifest: a campaign and the versions that compute it, with their hash.

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
"""Version of the layout of a manifest."""
_REMEDY = (
    "delete it and run the campaign file into this folder again: that writes the same manifest, and"
    " keeps the chunks"
)
"""How a damaged manifest is restored, for messages."""
_KINDS: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        *(Campaign, Dispersions, Dispersion),
        *(Nozzle, NozzleData, Actuator, AutopilotDesign, Filter),
        *(Vehicle, Structure, BendingMode, SloshTank, Engine),
        *(ShapedWind, WindEnsemble, Piecewise, Pieces),
    )
}
"""Classes of the values that a manifest holds, by name."""


@dataclass(frozen=True)
class Manifest:
    """A campaign, the versions of the packages that compute it, and the SHA-256 of both.

    `versions`: by package, with numba where kernels are compiled. `seal`: the hash.
    """

    campaign: Campaign
    versions: dict[str, str]
    seal: str

    @property
    def compiled(self) -> bool:
        """Whether compiled kernels are used."""
        return "numba" in self.versions


def new_manifest(campaign: Campaign, compiled: bool | None = None) -> Manifest:
    """Return the manifest of a new campaign, by default with compiled kernels where available."""
    compiled = available() if compiled is None else compiled
    versions = _versions(compiled)
    return Manifest(campaign, versions, _seal(_content(campaign, versions)))


def begin(campaign: Campaign, folder: Path, compiled: bool | None = None) -> Manifest:
    """Return the manifest of a folder, and write it where the folder has none."""
    if exists(folder / NAME):
        existing = read_manifest(folder)
        if written(existing.campaign) != written(campaign):
            raise InputError(
                f"{called(folder)} holds another campaign, or this one before it was changed; name"
                " another folder, or put the campaign file back as it was"
            )
        return existing
    manifest = new_manifest(campaign, compiled)
    make_directory(folder)
    document = _content(campaign, manifest.versions) | {"sha256": manifest.seal}
    write_text(folder / NAME, json.dumps(document, indent=1) + "\n")
    return manifest


def read_manifest(folder: Path) -> Manifest:
    """Return the manifest of a folder; `InputError` if it changed after the campaign began."""
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
        raise InputError(f"{called(file)} is damaged: it is no manifest; {_REMEDY}") from None
    if kind != _FORMAT:
        raise InputError(f"{file} has the format {shown(kind)}, and this version reads {_FORMAT}")
    if _seal(document) != seal:
        raise InputError(
            f"{called(file)} was changed after the campaign began; put it back, or {_REMEDY}"
        )
    return Manifest(read(described), versions, seal)


def check_versions(manifest: Manifest) -> None:
    """Raise `InputError` unless this process has the versions that the manifest names."""
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
    """Return the installed versions by package, with numba for compiled kernels."""
    try:
        numba = {"numba": version("numba")} if compiled else {}
    except PackageNotFoundError:
        raise missing("compiled kernels need numba", "fast") from None
    return {name: version(name) for name in ("tvclin", "numpy", "scipy")} | numba


def _content(campaign: Campaign, versions: dict[str, str]) -> dict[str, Any]:
    """Return the document of a manifest without its hash."""
    return {"format": _FORMAT, "versions": versions, "design": written(campaign)}


def _seal(content: dict[str, Any]) -> str:
    """Return the SHA-256 of the document of a manifest."""
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def written(value: Any) -> Any:
    """Return a campaign, or a value of it, as JSON holds it; a gust by its exact pieces."""
    if isinstance(value, History):
        value = Piecewise(value.pieces)
    if is_dataclass(value):
        members = {field.name: written(getattr(value, field.name)) for field in fields(value)}
        return {"kind": type(value).__name__} | members
    if isinstance(value, np.ndarray):
        if np.iscomplexobj(value):
            return {"real": value.real.tolist(), "imag": value.imag.tolist()}
        return value.tolist()
    return [written(item) for item in value] if isinstance(value, tuple) else value


def read(record: Any) -> Any:
    """Return the value that `written` has made a record of; `InputError` for any other record."""
    if isinstance(record, list):
        return tuple(read(item) for item in record)
    if not isinstance(record, dict):
        return record
    members = {name: read(item) for name, item in record.items() if name != "kind"}
    try:
        if "kind" not in record:
            return np.array(members["real"]) + 1j * np.array(members["imag"])
        if record["kind"] == Pieces.__name__:
            members = {name: np.array(item) for name, item in members.items()}
        return _KINDS[record["kind"]](**members)
    except (KeyError, TypeError):
        raise InputError("a manifest must hold every number of a campaign, and no others") from None
