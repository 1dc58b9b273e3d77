"""Machine code on disk: what another process runs is, bit for bit, what was written, or nothing.

numba's own cache trusts its files: one that was cut short fails at every call, one in which bits
have flipped may end the interpreter, and on a full disk the answer is lost after the wait for it.
Here each file begins with the hash of what follows.
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
_LONG = 2.0
"""Seconds of compiling of which somebody is told."""


class Kept(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Files of one function, one for each signature and processor, where numba has its own."""

    _begun = np.inf

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the machine code that is kept; None where there is none that is whole."""
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
        """Keep machine code; where that fails this process goes on with what it has."""
        took = monotonic() - self._begun
        if took > _LONG:
            compiled_once = f"a kernel was compiled in {took:.0f} s, once on this machine"
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
