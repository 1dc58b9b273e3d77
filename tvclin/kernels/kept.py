"""Cache of machine code on disk, verified by hashes: what is loaded is what was written.

numba's own cache trusts its files: a truncated file fails at every call, a file with flipped bits
may end the interpreter, and on a full disk the result is lost after compilation. Here each file
begins with the hash of its content.
"""

import pickle
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import Any
from warnings import warn

import numba
import numpy as np
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

from tvclin.base.errors import InputError
from tvclin.base.files import called, write_whole
from tvclin.base.warned import MachineWarning

_HASH = sha256().digest_size
_MIN_REPORTED_SECONDS = 2.0
"""Time of compilation [s] above which a warning reports it."""


class VerifiedCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Cache files of a function, one per signature and processor, in numba's cache folder."""

    _begun = np.inf

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the cached machine code; None where there is none, or it is damaged."""
        target_context.refresh()
        file = self._file(signature, target_context.codegen())
        try:
            content = file.read_bytes()
        except OSError:
            self._begun = monotonic()
            return None
        if sha256(content[_HASH:]).digest() != content[:_HASH]:
            damaged = f"{called(file)} is damaged; this machine code is compiled anew"
            warn(damaged, MachineWarning, stacklevel=2)
            return None
        return self._impl.rebuild(target_context, pickle.loads(content[_HASH:]))

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Write machine code to the cache; warn and continue where that fails."""
        seconds = monotonic() - self._begun
        if seconds > _MIN_REPORTED_SECONDS:
            compiled_once = f"a kernel was compiled in {seconds:.0f} s, once on this machine"
            warn(compiled_once, MachineWarning, stacklevel=2)
        if not self._impl.check_cachable(compiled):
            return
        content = dumps(self._impl.reduce(compiled))
        file = self._file(signature, compiled.codegen)
        try:
            write_whole(
                file, lambda target: Path(target).write_bytes(sha256(content).digest() + content)
            )
        except InputError as error:
            warn(f"{error}; this machine code is compiled anew in each process", stacklevel=2)

    def _file(self, signature: Any, codegen: Any) -> Path:
        stamp = self._impl.locator.get_source_stamp()
        key = self._index_key(signature, codegen)
        made_of = repr((numba.__version__, np.__version__, stamp, key))
        name = f"{self._impl.filename_base}.{sha256(made_of.encode()).hexdigest()[:16]}.nbc"
        return Path(self._cache_path) / name
