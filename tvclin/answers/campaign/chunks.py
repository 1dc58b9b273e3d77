"""Chunks: so many cases computed and written as one Parquet file, whole or not at all.

A file says in its metadata to which campaign it belongs, which chunk it is, and the hash of its
columns. So a file that was cut short, whose bits have flipped, or that came from elsewhere is
found: whatever changes in it either changes what is read, and so the hash, or changes nothing.
"""

from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from tempfile import mkdtemp
from time import time
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.answers.campaign.cases import evaluate
from tvclin.answers.campaign.manifest import NAME, Manifest, check_versions, read_manifest
from tvclin.base.arrays import AnyArray
from tvclin.base.errors import InputError, imported
from tvclin.base.files import called, exists, make_directory, write_whole
from tvclin.kernels.choice import pinned

if TYPE_CHECKING:
    import pyarrow

FOLDER = "chunks"
_OLD = 3600.0
"""Seconds after which nobody writes to a temporary file any more."""
_SEAL, _CHUNK, _CONTENT = b"tvclin_campaign", b"tvclin_chunk", b"tvclin_content"


def chunk_file(folder: Path, chunk: int) -> Path:
    """Return where a chunk is kept."""
    return folder / FOLDER / f"{chunk:08d}.parquet"


def run_chunk(folder: str, seal: str, chunk: int) -> int:
    """Compute one chunk of the campaign in a folder and write it; return its number.

    Everything a worker needs is read from the folder, once in each process.
    """
    manifest = _manifest(folder, seal)
    with pinned(manifest.compiled):
        columns = evaluate(manifest.campaign, *manifest.campaign.span(chunk))
    write_chunk(Path(folder), manifest, chunk, columns)
    return chunk


def write_chunk(folder: Path, manifest: Manifest, chunk: int, columns: dict[str, AnyArray]) -> None:
    """Write the columns of a chunk; what stands in its place and is no file is moved aside."""
    parquet, pyarrow = _parquet(), arrow()
    table = pyarrow.table(
        {
            name: pyarrow.array(values.tolist(), pyarrow.string()).dictionary_encode()
            if values.dtype == object
            else pyarrow.array(values)
            for name, values in columns.items()
        }
    )
    kept = {
        _SEAL: manifest.seal.encode(),
        _CHUNK: str(chunk).encode(),
        _CONTENT: _content(table).encode(),
    }
    table = table.replace_schema_metadata(kept)
    if not exists(folder / NAME):
        raise InputError(f"{called(folder)} was removed, with its manifest, while the campaign ran")
    make_directory(folder / FOLDER)
    file = chunk_file(folder, chunk)
    if exists(file) and not file.is_file():  # nothing of whoever made it is deleted
        file.rename(Path(mkdtemp(prefix=f"{file.name}.", dir=file.parent)) / file.name)
    options = {"compression": "none", "write_statistics": False, "write_page_checksum": True}
    write_whole(
        file,
        lambda target: parquet.write_table(table, target, use_dictionary=["status"], **options),
    )


def sweep(folder: Path) -> None:
    """Remove what killed workers left half written; young files may still be written to."""
    for file in (folder / FOLDER).glob(".*.parquet.*"):
        with suppress(OSError):
            if time() - file.stat().st_mtime > _OLD:
                file.unlink()


def flaw(folder: Path, manifest: Manifest, chunk: int) -> str | None:
    """Return in words what is wrong with the whole file of a chunk; None if nothing is."""
    file = chunk_file(folder, chunk)
    if not file.exists():
        return "missing"
    try:
        table = _read(folder, manifest, chunk, None)
    except InputError as error:
        return str(error)
    if _content(table).encode() != table.schema.metadata[_CONTENT]:
        return f"{file} is damaged: its columns do not have the hash that it says"
    return None


def read_columns(
    folder: Path, manifest: Manifest, chunk: int, names: Sequence[str]
) -> dict[str, AnyArray]:
    """Return some columns of a chunk."""
    table = _read(folder, manifest, chunk, list(names))
    return {name: np.asarray(table[name].to_numpy()) for name in names}


def _read(folder: Path, manifest: Manifest, chunk: int, names: list[str] | None) -> "pyarrow.Table":
    file = chunk_file(folder, chunk)
    try:
        if exists(file) and not file.is_file():
            raise OSError  # a folder, or a pipe that would be waited for
        with _parquet().ParquetFile(file, page_checksum_verification=True) as source:
            kept = source.schema_arrow.metadata or {}
            if kept.get(_SEAL) != manifest.seal.encode() or kept.get(_CHUNK) != b"%d" % chunk:
                raise InputError(f"{file} is not chunk {chunk} of this campaign")
            table = source.read(names)
    except FileNotFoundError:
        raise InputError(
            f"{file} is missing; go on with: tvclin campaign resume {folder}"
        ) from None
    except (OSError, ValueError, KeyError, MemoryError, arrow().ArrowException) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{file} is damaged; compute it anew with: tvclin campaign resume {folder}"
        ) from None
    if table.num_rows != manifest.campaign.span(chunk)[1]:
        raise InputError(f"{file} is damaged: it has {table.num_rows} cases")
    return table


def _content(table: "pyarrow.Table") -> str:
    """The hash of names and values, whatever the encoding."""
    found = sha256()
    for name in table.column_names:
        values = table[name].to_numpy()
        raw = "\0".join(values).encode() if values.dtype == object else values.tobytes()
        found.update(f"{name}:{values.dtype}:{len(raw)}:".encode())
        found.update(raw)
    return found.hexdigest()


@lru_cache(maxsize=1)
def _manifest(folder: str, seal: str) -> Manifest:
    found = read_manifest(Path(folder))
    if found.seal != seal:
        raise InputError(f"{folder} holds another campaign now than when this one was begun")
    check_versions(found)
    return found


def arrow() -> Any:
    """Return pyarrow; `InputError` where it is not installed."""
    return imported("pyarrow", "campaigns need pyarrow", "campaign")


def _parquet() -> Any:
    arrow()
    import pyarrow.parquet

    return pyarrow.parquet
