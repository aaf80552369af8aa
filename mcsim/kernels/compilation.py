"""How kernels and the scalar functions inside them are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

_Function = TypeVar("_Function", bound=Callable[..., Any])

# Fused multiply-add is allowed, and nothing else that changes results; floats
# divide as in numpy.
_ARITHMETIC: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy"}


def scalar(function: _Function) -> _Function:
    """A function of a few numbers, inlined into every loop that calls it."""
    compiled: _Function = njit(forceinline=True, **_ARITHMETIC)(function)
    return compiled


def kernel(function: _Function) -> _Function:
    """A function over arrays: releases the interpreter lock, compiled once per machine."""
    compiled: _Function = njit(nogil=True, cache=True, **_ARITHMETIC)(function)
    return compiled
