"""How kernels and the scalar functions inside them are compiled."""

from __future__ import annotations

import ast
import hashlib
import os
import re
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
_FIRST = re.compile(r"^(?:@|def |class )", re.MULTILINE)
_FOLDER, _PACKAGE = Path(__file__).parent, "mcsim.kernels"
_Function = TypeVar("_Function", bound=Callable[..., Any])


def sources_of(*files: Path) -> list[Path]:
    """Some source files and the kernel modules that they import, directly or not.

    Kernel modules are those of the folder ``kernels`` that a file lies in, or else of this one.
    """
    found: set[Path] = set()
    open_files = list(files)
    while open_files:
        path = open_files.pop()
        if path not in found:
            found.add(path)
            open_files += _imported(path)
    return sorted(found)


def _imported(path: Path) -> list[Path]:
    """The kernel modules that a source file imports itself."""
    folder = path.parent if path.parent.name == _PACKAGE.rpartition(".")[2] else _FOLDER
    names: set[str] = set()
    for node in _head(path.read_text("utf-8")).body:
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module == _PACKAGE:
            names.update(f"{_PACKAGE}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
    own = [n.removeprefix(f"{_PACKAGE}.") for n in names if n.startswith(f"{_PACKAGE}.")]
    return [file for file in (folder / f"{name}.py" for name in own) if file.exists()]


def _head(source: str) -> ast.Module:
    """What stands before the first function or class: parsing it all would take too long."""
    end = _FIRST.search(source)
    try:
        return ast.parse(source[: end.start()] if end else source)
    except SyntaxError:  # it was a line of the docstring
        return ast.parse(source)


@cache
def source_digest(*files: Path) -> str:
    """Digest of some source files and of all kernel modules that they import, directly or not."""
    digest = hashlib.blake2b(digest_size=16)
    for path in sources_of(*files):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def file_of(function: Callable[..., Any]) -> Path:
    """The source file of a function."""
    return Path(function.__code__.co_filename)


def _stamp(compiled: Any) -> None:
    """Make a cached kernel stale when a source changes that it is compiled from.

    Numba looks at the kernel's own file only, and would go on using a kernel whose
    inlined functions have changed in another one.
    """
    # Not a public part of numba: where it is missing, numba's own stamp serves.
    with suppress(AttributeError):
        compiled._cache._cache_file._source_stamp = source_digest(file_of(compiled.py_func))


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


def apart(compiled: Any, name: str, *files: Path) -> Any:
    """A copy of a kernel whose machine code is kept in a file of its own.

    For systems that not every process knows: numba could not read a common file without them.
    It is stale when the kernel's sources change or ``files``; what else tells compiled code apart
    stands in ``name``.
    """
    own = kernel(compiled.py_func)
    with suppress(AttributeError):
        kept = own._cache._cache_file
        own._cache._cache_file = type(kept)(
            cache_path=kept._cache_path,
            filename_base=f"{compiled.py_func.__name__}-{name}",
            source_stamp=source_digest(file_of(compiled.py_func), *files),
        )
    return own
