"""How kernels and the scalar functions inside them are compiled."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from llvmlite import binding as llvm
from numba import config as _numba_config
from numba import njit

#: Kernels that are compiled anew by every process, for want of a writable folder.
unkept: list[str] = []

config: Any = _numba_config
_Function = TypeVar("_Function", bound=Callable[..., Any])


@cache
def _source_digest() -> str:
    """Digest of all kernel sources: what any of them is compiled from."""
    digest = hashlib.blake2b(digest_size=16)
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _stamp(compiled: Any) -> None:
    """Make a cached kernel stale when any kernel source changes.

    Numba looks at the kernel's own file only, and would go on using a kernel whose
    inlined functions have changed in another one.
    """
    # Not a public part of numba: where it is missing, numba's own stamp serves.
    with suppress(AttributeError):
        compiled._cache._cache_file._source_stamp = _source_digest()


def _use_full_vectors() -> None:
    """Let LLVM use all 512 bits of AVX-512, which it avoids on Intel by default.

    The lane loops gain a third of their speed; results stay the same to the bit.
    A choice made through numba's own settings (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES)
    is left alone.
    """
    if config.CPU_NAME is not None or config.CPU_FEATURES is not None:
        return
    features = llvm.get_host_cpu_features()
    if features.get("avx512f", False):
        features["prefer-256-bit"] = False
        config.CPU_FEATURES = features.flatten()


_use_full_vectors()

# Fused multiply-add is allowed, and nothing else that changes results; floats
# divide as in numpy.
_ARITHMETIC: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy"}
#: What scalar functions are compiled for: ``cpu`` or ``cuda``.
TARGET = os.environ.get("MCSIM_TARGET", "cpu")
#: Options of what is inlined into the loops that call it.
INLINED: dict[str, Any] = {"forceinline": True, **_ARITHMETIC}


def scalar(function: _Function) -> _Function:
    """A function of a few numbers, inlined into every loop that calls it.

    It is compiled for the processor, or for CUDA where the environment says
    ``MCSIM_TARGET=cuda``: the same source serves both.
    """
    compiled: _Function
    if TARGET == "cuda":
        from numba import cuda

        compiled = cuda.jit(device=True)(function)
    else:
        compiled = njit(**INLINED)(function)
    return compiled


def kernel(function: _Function) -> _Function:
    """A function over arrays: releases the interpreter lock, compiled once per machine."""
    compiled: _Function
    try:
        compiled = njit(nogil=True, cache=True, **_ARITHMETIC)(function)
        _stamp(compiled)
    except RuntimeError:
        # Neither the package's folder nor the user's can be written.
        unkept.append(function.__name__)
        compiled = njit(nogil=True, **_ARITHMETIC)(function)
    return compiled


def apart(compiled: Any, name: str) -> Any:
    """A copy of a kernel whose machine code is kept in a file of its own.

    For systems that not every process knows: numba could not read a common file without them.
    ``name`` tells apart what is compiled, sources included.
    """
    own = kernel(compiled.py_func)
    with suppress(AttributeError):
        kept = own._cache._cache_file
        own._cache._cache_file = type(kept)(
            cache_path=kept._cache_path,
            filename_base=f"{compiled.py_func.__name__}-{name}",
            source_stamp=_source_digest(),
        )
    return own
