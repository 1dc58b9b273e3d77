"""Cache of machine code on disk, verified by hashes: only code that was written is loaded.

numba's own cache (``cache=True``) finds and serialises the code, but not the files. Measured with
numba 0.68 on a kernel of ten lines: a file without its last byte raises at every call and is never
replaced; of 40 files with one byte changed 18 raise, 5 end the interpreter and 17 go unnoticed;
after a change of a constant in a called function of another file the old numbers are returned, for
only the file of the function itself is compared; and where the disk is full the result of the call
is lost. So its index and data files (`IndexDataCacheFile`) are replaced by files that begin with
the hash of their content, and whose names hold the digest of all sources.
"""

import pickle
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import Any
from warnings import warn

import numba
import numpy as np
from llvmlite import binding as llvm
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps

from tvclin.base.errors import InputError
from tvclin.base.files import called, reason, write_whole
from tvclin.base.package_warnings import MachineWarning

_HASH = sha256().digest_size
_MIN_REPORTED_SECONDS = 2.0
"""Time of compilation [s] above which a warning reports it."""


class _LoadableResults(CompileResultCacheImpl):  # type: ignore[misc]  # numba has no types
    """Results of compilation in a file, without what serves only to compile further functions."""

    def reduce(self, compiled: Any) -> tuple[Any, ...]:
        """Return the parts of a result that are written: machine code, and how it is called.

        The bitcode, from which machine code of callers would be made, is reduced to the names of
        its functions, and environments of called functions without constants are omitted. With
        numba 0.68 loading both took twice as long as all the rest. `compiled`: result of numba.
        """
        (name, kind, (code, bitcode)), *further, environments = super().reduce(compiled)
        defined = [f for f in llvm.parse_bitcode(bitcode).functions if not f.is_declaration]
        stubs = "\n".join(f'define void @"{f.name}"() {{ ret void }}' for f in defined)
        names = llvm.parse_assembly(stubs).as_bitcode()
        used = tuple(environment for environment in environments if environment.consts)
        return (name, kind, (code, names)), *further, used


class VerifiedCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Cache of a kernel in numba's cache folder, in files of `_VerifiedFiles`."""

    _impl_class = _LoadableResults

    def __init__(self, function: Callable[..., Any], digest: str) -> None:
        """Prepare the cache of a function; `digest` is the hash of all its sources."""
        super().__init__(function)
        # numba's names are name-line.python
        name, _, line_and_python = self._impl.filename_base.partition("-")
        self._cache_file = _VerifiedFiles(
            Path(self._cache_path) / f"{name}_{digest}-{line_and_python}",
            self._impl.locator.get_source_stamp(),
        )

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the machine code of a signature from the cache; None where there is none.

        `target`: numba's context of the processor. numba's own method fills the tables of its
        compiler first, which takes twice as long as the import of numba, and of which machine code
        needs only the runtime that allocates arrays.
        """
        rtsys.initialize(target)
        code = self._load_overload(signature, target)
        if code is None:
            target.refresh()
        return code

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Write machine code `compiled` of a signature to the cache; warn where that fails.

        The machine code is used all the same, in this process.
        """
        try:
            super().save_overload(signature, compiled)
        except (InputError, OSError) as error:
            words = f"{reason(error)}; this machine code is compiled anew in each process"
            warn(words, stacklevel=2)


class _VerifiedFiles:
    """Files of a kernel, one per signature and processor (`key`), each with its hash in front."""

    def __init__(self, base: Path, stamp: Any) -> None:
        """Prepare files whose names begin with `base`; `stamp` is numba's hash of the source."""
        self._base, self._stamp = base, stamp
        self._missed = np.inf  # time [s] when a file was last missing, and compilation began

    def load(self, key: Any) -> Any:
        """Return the serialised machine code of a key; None where it is missing or damaged."""
        file = self._file(key)
        try:
            content = file.read_bytes()
        except OSError:
            self._missed = monotonic()
            return None
        if sha256(content[_HASH:]).digest() != content[:_HASH]:
            damaged = f"{called(file)} is damaged; this machine code is compiled anew"
            warn(damaged, MachineWarning, stacklevel=4)
            return None
        return pickle.loads(content[_HASH:])

    def save(self, key: Any, code: Any) -> None:
        """Write serialised machine code under a key; `InputError` where that fails.

        It warns of a compilation that took long since `load` found no file.
        """
        seconds = monotonic() - self._missed
        if seconds > _MIN_REPORTED_SECONDS:
            compiled_once = f"a kernel was compiled in {seconds:.0f} s, once on this machine"
            warn(compiled_once, MachineWarning, stacklevel=5)
        content = dumps(code)
        hashed = sha256(content).digest() + content
        write_whole(self._file(key), lambda target: Path(target).write_bytes(hashed))

    def _file(self, key: Any) -> Path:
        """Return the file of a key; its hash is of signature, processor, versions and source."""
        made_of = repr((numba.__version__, np.__version__, self._stamp, key))
        return self._base.with_name(
            f"{self._base.name}.{sha256(made_of.encode()).hexdigest()[:16]}.nbc"
        )
