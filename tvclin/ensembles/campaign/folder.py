"""Folder of a campaign: its manifest, and its chunks, each complete or absent.

The manifest holds a campaign and the versions that compute it, with their hash. It is written
before the first chunk, every value of the campaign by its kind and its fields, in SI units, and
every chunk carries its hash. Work goes on only with the versions that it names, so that all chunks
belong together to the last bit.

A chunk is cases that are computed together and written as one Parquet file. It says in its metadata
to which campaign it belongs, which chunk it is, and the hash of its columns. It is read as a whole,
and the hash is that of the very arrays that are returned: whatever changes in a file, its footer
included, either changes these, and so the hash, or changes nothing.
"""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import lru_cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import mkdtemp
from time import time
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.ascent.measured_wind import MeasuredWind, SoundingGaps, SoundingSpeeds
from tvclin.ascent.schedule import FlightSchedule
from tvclin.ascent.structure_schedule import StructureSchedule
from tvclin.base.arrays import AnyArray
from tvclin.base.errors import InputError, imported, missing, shown
from tvclin.base.files import called, exists, make_directory, reason, write_text, write_whole
from tvclin.case.nozzle import Nozzle, NozzleData
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import AutopilotDesign
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.control.autopilot.gain_table import ModeNotch
from tvclin.ensembles.campaign.campaign_plan import Campaign, FlightPlan, SoundingEnsemble
from tvclin.ensembles.campaign.cases import evaluate
from tvclin.ensembles.dispersions import Dispersion, Dispersions
from tvclin.kernels.choice import available, pinned, remedy
from tvclin.linear.system import LinearSystem, Names
from tvclin.numerics.pieces import Pieces
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.structure import BendingMode, Engine, SloshTank, Structure
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History, Piecewise
from tvclin.winds.pulses import SampledWind
from tvclin.winds.shaped import FixedWind, ShapedWind, WindEnsemble

if TYPE_CHECKING:
    import pyarrow

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
        *(ShapedWind, FixedWind, WindEnsemble, Piecewise, Pieces, LinearSystem),
        *(FlightPlan, FlightSchedule, StructureSchedule, GainSchedule, ModeNotch, Autopilot),
        *(SoundingEnsemble, MeasuredWind, SoundingSpeeds, SoundingGaps, SampledWind, dict),
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
    """Return the manifest of a new campaign.

    `compiled`: whether compiled kernels are used; by default where they are available.
    """
    compiled = available() if compiled is None else compiled
    versions = _versions(compiled)
    return Manifest(campaign, versions, _seal(_manifest_content(campaign, versions)))


def begin(campaign: Campaign, folder: Path, compiled: bool | None = None) -> Manifest:
    """Return the manifest of a folder, and write a new one of a campaign where it has none.

    `compiled`: whether a new campaign uses compiled kernels; by default where they are available.
    `InputError` where the folder holds another campaign.
    """
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
    document = _manifest_content(campaign, manifest.versions) | {"sha256": manifest.seal}
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


def _manifest_content(campaign: Campaign, versions: dict[str, str]) -> dict[str, Any]:
    """Return the document of the manifest of a campaign, without its hash.

    `versions`: versions of the packages that compute it, by name.
    """
    return {"format": _FORMAT, "versions": versions, "design": written(campaign)}


def _seal(content: dict[str, Any]) -> str:
    """Return the SHA-256 of the document of a manifest, its `content` without the hash."""
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def written(value: Any) -> Any:
    """Return a campaign, or a value of it, as JSON holds it; a gust by its exact pieces."""
    if isinstance(value, Mapping):
        return {"kind": "dict"} | {name: written(item) for name, item in value.items()}
    if isinstance(value, History) and not isinstance(value, SampledWind):
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
    """Return the value of a record that `written` returned; `InputError` for any other record."""
    if isinstance(record, list):
        return tuple(read(item) for item in record)
    if not isinstance(record, dict):
        return record
    members = {name: read(item) for name, item in record.items() if name != "kind"}
    try:
        if "kind" not in record:  # a complex array
            return np.array(members["real"]) + 1j * np.array(members["imag"])
        if record["kind"] == Pieces.__name__:
            members = {name: np.array(item) for name, item in members.items()}
        if record["kind"] == LinearSystem.__name__:
            return _system(**members)
        return _KINDS[record["kind"]](**members)
    except (KeyError, TypeError):
        raise InputError("a manifest must hold every number of a campaign, and no others") from None


def _system(
    *, inputs: Names, outputs: Names, states: Names, period: float | None, **matrices: Any
) -> LinearSystem:
    """Return a linear system from names of its inputs, outputs and states, and its matrices.

    `period`: sample period [s], None for continuous time. `matrices`: rows of A, B, C and D, which
    are empty lists where there are no states.
    """
    n, m, p = len(states), len(inputs), len(outputs)
    sizes = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m)}
    arrays = {k: np.array(matrices[k], float).reshape(size) for k, size in sizes.items()}
    length = None if period is None else np.asarray(period)
    return LinearSystem(**arrays, inputs=inputs, outputs=outputs, states=states, period=length)


FOLDER = "chunks"
_MAX_WRITING_S = 3600.0
"""Longest time [s] for which a temporary file is still written to; an older file is removed."""
_REPAIR = "compute it anew: run the campaign into its folder again"
"""How a damaged chunk is restored, for messages."""
_SEAL, _CHUNK, _CONTENT = b"tvclin_campaign", b"tvclin_chunk", b"tvclin_content"
"""Keys of the metadata: hash of the manifest, number of the chunk, hash of its columns."""


def chunk_file(folder: Path, chunk: int) -> Path:
    """Return the path of the Parquet file of a chunk, by number, in the folder of a campaign."""
    return folder / FOLDER / f"{chunk:08d}.parquet"


def run_chunk(folder: str, seal: str, chunk: int) -> int:
    """Compute one chunk of the campaign in a folder and write it; return its number.

    `seal`: hash of the manifest, which a worker reads from the folder once in each process.
    """
    manifest = _manifest(folder, seal)
    with pinned(manifest.compiled):
        columns = evaluate(manifest.campaign, *manifest.campaign.span(chunk))
    write_chunk(Path(folder), manifest, chunk, columns)
    return chunk


def write_chunk(folder: Path, manifest: Manifest, chunk: int, columns: dict[str, AnyArray]) -> None:
    """Write the columns of a chunk into its file; a folder or pipe of the same name is renamed.

    `manifest`: manifest of the folder, whose hash stands in the file. `chunk`: number of the
    chunk. `columns`: columns of its n cases by name, ``(n,)`` each.
    """
    parquet, pyarrow = _parquet(), arrow()
    table = pyarrow.table(
        {
            name: pyarrow.array(values.tolist(), pyarrow.string()).dictionary_encode()
            if values.dtype == object
            else pyarrow.array(values)
            for name, values in columns.items()
        }
    )
    metadata = {
        _SEAL: manifest.seal.encode(),
        _CHUNK: str(chunk).encode(),
        _CONTENT: _columns_digest(_columns(table)).encode(),
    }
    table = table.replace_schema_metadata(metadata)
    if not exists(folder / NAME):
        raise InputError(f"{called(folder)} was removed, with its manifest, while the campaign ran")
    make_directory(folder / FOLDER)
    file = chunk_file(folder, chunk)
    if exists(file) and not file.is_file():  # of unknown origin, and so not deleted
        file.rename(Path(mkdtemp(prefix=f"{file.name}.", dir=file.parent)) / file.name)
    options = {"compression": "none", "write_statistics": False, "write_page_checksum": True}
    write_whole(
        file,
        lambda target: parquet.write_table(table, target, use_dictionary=["status"], **options),
    )


def remove_stale_files(folder: Path) -> None:
    """Remove the temporary files of killed workers in a folder, older than `_MAX_WRITING_S`."""
    for file in (folder / FOLDER).glob(".*.parquet.*"):
        with suppress(OSError):
            if time() - file.stat().st_mtime > _MAX_WRITING_S:
                file.unlink()


def chunk_fault(folder: Path, manifest: Manifest, chunk: int) -> str | None:
    """Return the fault of the file of a chunk in words; None for a sound file.

    `folder`, `manifest`: folder of the campaign, and the manifest in it.
    """
    if not chunk_file(folder, chunk).exists():
        return "missing"
    try:
        read_columns(folder, manifest, chunk)
    except InputError as error:
        return str(error)
    return None


def read_columns(folder: Path, manifest: Manifest, chunk: int) -> dict[str, AnyArray]:
    """Return the columns of a chunk by name, ``(n,)`` each.

    `folder`, `manifest`: folder of the campaign, and the manifest in it, of which the file must be.
    The hash in the file is of the returned arrays, so that damage to values, types, names or
    order raises an exception and never changes a number. `InputError` for a file that is missing,
    damaged, or of another campaign or chunk.
    """
    file = chunk_file(folder, chunk)
    try:
        columns, content, metadata = _read(file)
    except FileNotFoundError:
        raise InputError(f"{file} is missing; {_REPAIR}") from None
    except Exception:  # pyarrow raises whatever a damaged file leads to
        raise InputError(f"{file} is damaged; {_REPAIR}") from None
    if metadata.get(_SEAL) != manifest.seal.encode() or metadata.get(_CHUNK) != b"%d" % chunk:
        raise InputError(f"{file} is not chunk {chunk} of this campaign")
    if metadata.get(_CONTENT) != content.encode():
        raise InputError(
            f"{file} is damaged: its columns do not have the hash that it says; {_REPAIR}"
        )
    return columns


def _read(file: Path) -> tuple[dict[str, AnyArray], str, dict[bytes, bytes]]:
    """Return the columns of a Parquet file as arrays, ``(n,)`` each, their hash, and metadata."""
    if exists(file) and not file.is_file():
        raise OSError  # a folder, or a pipe that would be waited for
    with _parquet().ParquetFile(file, page_checksum_verification=True) as source:
        table = source.read()
    columns = _columns(table)
    return columns, _columns_digest(columns), table.schema.metadata or {}


def _columns(table: "pyarrow.Table") -> dict[str, AnyArray]:
    """Return the columns of a table as arrays, ``(n,)`` each."""
    return {name: np.asarray(table[name].to_numpy()) for name in table.column_names}


def _columns_digest(columns: dict[str, AnyArray]) -> str:
    """Return the SHA-256 of names, types and values of columns, whatever the encoding."""
    digest = sha256()
    for name, values in columns.items():
        raw = "\0".join(values).encode() if values.dtype == object else values.tobytes()
        digest.update(f"{name}:{values.dtype}:{len(raw)}:".encode())
        digest.update(raw)
    return digest.hexdigest()


@lru_cache(maxsize=1)
def _manifest(folder: str, seal: str) -> Manifest:
    """Return the manifest of a folder; `InputError` for another hash or other versions.

    `seal`: hash of the manifest when the run began.
    """
    manifest = read_manifest(Path(folder))
    if manifest.seal != seal:
        raise InputError(f"{folder} holds another campaign now than when this one was begun")
    check_versions(manifest)
    return manifest


def arrow() -> Any:
    """Return pyarrow; `InputError` where it is not installed."""
    return imported("pyarrow", "campaigns need pyarrow", "campaign")


def _parquet() -> Any:
    """Return the module `pyarrow.parquet`; `InputError` where it is not installed."""
    arrow()
    import pyarrow.parquet

    return pyarrow.parquet
