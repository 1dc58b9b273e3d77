"""Chunks: so many cases computed and written as one Parquet file, whole or not at all.

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
        _CONTENT: _content(_columns(table)).encode(),
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
    if not chunk_file(folder, chunk).exists():
        return "missing"
    try:
        read_columns(folder, manifest, chunk)
    except InputError as error:
        return str(error)
    return None


def read_columns(folder: Path, manifest: Manifest, chunk: int) -> dict[str, AnyArray]:
    """Return the columns of a chunk by name, ``(n,)`` each.

    They are the very arrays whose hash is that of the file, so that no damage to it, of values,
    types, names or order, changes a number without a word.

    Raises
    ------
    InputError
        For a file that is missing, damaged, or of another campaign or chunk.
    """
    file = chunk_file(folder, chunk)
    resume = f"tvclin campaign resume {folder}"
    try:
        columns, content, kept = _read(file)
    except FileNotFoundError:
        raise InputError(f"{file} is missing; go on with: {resume}") from None
    except Exception:  # pyarrow raises whatever a damaged file leads to
        raise InputError(f"{file} is damaged; compute it anew with: {resume}") from None
    if kept.get(_SEAL) != manifest.seal.encode() or kept.get(_CHUNK) != b"%d" % chunk:
        raise InputError(f"{file} is not chunk {chunk} of this campaign")
    if kept.get(_CONTENT) != content.encode():
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
    return {name: np.asarray(table[name].to_numpy()) for name in table.column_names}


def _content(columns: dict[str, AnyArray]) -> str:
    """The hash of names, types and values, whatever the encoding."""
    found = sha256()
    for name, values in columns.items():
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
