"""Scrambled Sobol points for what a realization draws once.

Realizations come in *nets* of consecutive ones.  All nets share one Sobol sequence whose
digits are scrambled by a random lower-triangular matrix (Matousek 1998); each net shifts
it digitally by random numbers of its own (Owen 1995; L'Ecuyer & Lemieux 2000).  So every
net is an independent, unbiased sample of its realizations, and statistics that treat
nets as items keep right intervals, if errors are smooth in what is drawn; where they jump, nets
that hold what is rare are too few to tell how much nets scatter, and random points serve.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

#: Digits of a coordinate; nets may hold 2^30 points.
_BITS = 30


def net_normals(key: int, first: int, count: int, net: int, dimensions: int) -> NDArray[np.float32]:
    """Standard normals (dimensions, count) of the realizations ``first`` and following.

    ``net`` is the number of realizations of a net, a power of two; ``first`` begins a net.
    """
    from scipy.special import ndtri

    points = _sequence(net, dimensions)
    words = np.empty((dimensions, count), np.uint32)
    for start in range(0, count, net):
        stop = min(start + net, count)
        shift = _shift(key, (first + start) // net, dimensions)
        words[:, start:stop] = points[:, : stop - start] ^ shift[:, None]
    return ndtri((words + 0.5) * 2.0**-_BITS).astype(np.float32)


@lru_cache(maxsize=4)
def _sequence(net: int, dimensions: int) -> NDArray[np.uint32]:
    from scipy.stats import qmc

    # One matrix for all runs: the shifts alone make nets independent and unbiased.
    sequence = qmc.Sobol(dimensions, scramble=True, bits=_BITS, rng=np.random.default_rng(1))
    points = sequence.random_base2(net.bit_length() - 1)
    return np.ascontiguousarray((points.T * 2.0**_BITS).astype(np.uint32))


def _shift(key: int, number: int, dimensions: int) -> NDArray[np.uint32]:
    generator = np.random.Generator(np.random.Philox(key=key, counter=[0, 0, 0, number]))
    return generator.integers(0, 1 << _BITS, dimensions, dtype=np.uint32)
