"""The base of all mechanisms, and the random numbers of their simulated logs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, TypeVar
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError

Array = NDArray[np.float64]


class Mechanism:
    """What one term does to one channel; a frozen dataclass of its parameters (SI)."""

    #: Whether a channel has room for one term of it only.
    alone: ClassVar[bool] = False


#: What acts on a channel, by the names of the terms.
Acts = Mapping[str, Mechanism]
M = TypeVar("M", bound=Mechanism)


def of_kind(acts: Acts, kind: type[M]) -> dict[str, M]:
    """The terms of one mechanism.

    Raises
    ------
    InputError
        More than one, where a channel has room for one.
    """
    found = {name: act for name, act in acts.items() if isinstance(act, kind)}
    if kind.alone and len(found) > 1:
        raise InputError(f"{' and '.join(found)}: a channel has room for one of them")
    return found


def only(acts: Acts, kind: type[M], absent: M) -> M:
    """The one term of a mechanism that a channel has room for, or ``absent``."""
    return next(iter(of_kind(acts, kind).values()), absent)


def stream(seed: int, name: str, channel: int = 0) -> np.random.Generator:
    """Random numbers of a term's own: one that comes or goes shifts no other's."""
    return np.random.default_rng([seed, crc32(name.encode()), channel])
