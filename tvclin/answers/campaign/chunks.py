"""Chunks: cases that are computed together and written as one Parquet file, whole or not at all.

A file says in its metadata to which campaign it belongs, which chunk it is, and the hash of its
columns. It is read as a whole, and the hash is that of the very arrays that are returned: whatever
changes in a file, its footer included, either changes these, and so the hash, or changes nothing.
"""

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
_MAX_WRITING_S = 3600.0
"""Longest time [s] for which a temporary file is still written to; an older file is removed."""
_SEAL, _CHUNK, _CONTENT = b"tvclin_campaign", b"tvclin_chunk", b"tvclin_content"
"""Keys of the metadata: hash of the manifest, number of the chunk, hash of its columns."""


def chunk_file(folder: Path, chunk: int) -> Path:
    """Return the path of the Parquet file of a chunk."""
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
    """Write the columns of a chunk; a folder or pipe of the same name is renamed."""
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
        _CONTENT: _content(_columns(table)).encode(),
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


def sweep(folder: Path) -> None:
    """Remove the temporary files of killed workers, older than `_MAX_WRITING_S`."""
    for file in (folder / FOLDER).glob(".*.parquet.*"):
        with suppress(OSError):
            if time() - file.stat().st_mtime > _MAX_WRITING_S:
                file.unlink()


def flaw(folder: Path, manifest: Manifest, chunk: int) -> str | None:
    """Return the fault of the file of a chunk in words; None for a sound file."""
    if not chunk_file(folder, chunk).exists():
        return "missing"
    try:
        read_columns(folder, manifest, chunk)
    except InputError as error:
        return str(error)
    return None


def read_columns(folder: Path, manifest: Manifest, chunk: int) -> dict[str, AnyArray]:
    """Return the columns of a chunk by name, ``(n,)`` each.

    The hash in the file is that of these very arrays, so that damage to values, types, names or
    order raises an exception and never changes a number.

    Raises
    ------
    InputError
        For a file that is missing, damaged, or of another campaign or chunk.
    """
    file = chunk_file(folder, chunk)
    resume = f"tvclin campaign resume {folder}"
    try:
        columns, content, metadata = _read(file)
    except FileNotFoundError:
        raise InputError(f"{file} is missing; go on with: {resume}") from None
    except Exception:  # pyarrow raises whatever a damaged file leads to
        raise InputError(f"{file} is damaged; compute it anew with: {resume}") from None
    if metadata.get(_SEAL) != manifest.seal.encode() or metadata.get(_CHUNK) != b"%d" % chunk:
        raise InputError(f"{file} is not chunk {chunk} of this campaign")
    if metadata.get(_CONTENT) != content.encode():
        raise InputError(
            f"{file} is damaged: its columns do not have the hash that it says; compute it anew"
            f" with: {resume}"
        )
    return columns


def _read(file: Path) -> tuple[dict[str, AnyArray], str, dict[bytes, bytes]]:
    """Return the columns of a file as arrays, their hash, and the metadata."""
    if exists(file) and not file.is_file():
        raise OSError  # a folder, or a pipe that would be waited for
    with _parquet().ParquetFile(file, page_checksum_verification=True) as source:
        table = source.read()
    columns = _columns(table)
    return columns, _content(columns), table.schema.metadata or {}


def _columns(table: "pyarrow.Table") -> dict[str, AnyArray]:
    """Return the columns of a table as arrays, ``(n,)`` each."""
    return {name: np.asarray(table[name].to_numpy()) for name in table.column_names}


def _content(columns: dict[str, AnyArray]) -> str:
    """Return the SHA-256 of names, types and values of columns, whatever the encoding."""
    digest = sha256()
    for name, values in columns.items():
        raw = "\0".join(values).encode() if values.dtype == object else values.tobytes()
        digest.update(f"{name}:{values.dtype}:{len(raw)}:".encode())
        digest.update(raw)
    return digest.hexdigest()


@lru_cache(maxsize=1)
def _manifest(folder: str, seal: str) -> Manifest:
    """Return the manifest of a folder; `InputError` for another hash or other versions."""
    manifest = read_manifest(Path(folder))
    if manifest.seal != seal:
        raise InputError(f"{folder} holds another campaign now than when this one was begun")
    check_versions(manifest)
    return manifest


def arrow() -> Any:
    """Return pyarrow; `InputError` where it is not installed."""
    return imported("pyarrow", "campaigns need pyarrow", "campaign")


def _parquet() -> Any:
    arrow()
    import pyarrow.parquet

    return pyarrow.parquet
