"""Compiled twins of kernels; only `kernels` imports them, and only through `choice`.

Every twin has the name of the module it stands in for. The rules inside: plain loops over the
case, no linear algebra library, functions at module level so that their machine code is cached,
and the same number of operations for a case wherever it stands in its batch.
"""
