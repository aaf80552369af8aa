"""Where each coefficient is read off an Allan deviation, and what stands in the way there.

A coefficient is read where its own term makes up the curve.  Beside other terms the reading is too
large: by ``1/√share − 1`` where the term has that share of the Allan variance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.noise_terms import NoiseTerm, total_variance

Array = NDArray[np.float64]

_PER_DECADE = 100
#: On a plateau the share of its term is at least this part of the largest.
_PLATEAU = 0.95
#: Cluster times looked at (s): from the sampling interval to about a year.
_LONGEST = 3e7


@dataclass(frozen=True)
class Reading:
    """A place on the curve.

    ``tau`` (s) is where it is, ``share`` the term's part of the Allan variance there, ``region``
    (s) the cluster times over which the term's share suffices, None if it nowhere does.
    """

    term: NoiseTerm
    tau: float
    share: float
    region: tuple[float, float] | None

    @property
    def bias(self) -> float:
        """By how much the reading is too large, as a part of the coefficient."""
        return 1.0 / math.sqrt(self.share) - 1.0


def reading_of(
    term: NoiseTerm, terms: Sequence[NoiseTerm], shortest: float, error: float
) -> Reading:
    """Where a term is read off the curve of all ``terms`` so that it is too large by ``error``.

    White noise is read at τ = 1 s, or nearest to it where its region is not there; a random walk at
    the shortest cluster time of its region, which a log has most of; bias instability where its
    plateau begins, its share nearly the largest; a Gauss-Markov process at its peak.  Without a
    region it is where the share is largest.  ``shortest`` is the sampling interval (s).
    """
    tau = _cluster_times(shortest)
    shares = term.variance(tau) / total_variance(terms, tau)
    if term.letter == "GM" and term.read_off is not None:
        at_peak = np.abs(np.log10(tau / term.read_off.tau)) < 1.0 / _PER_DECADE
        shares = np.where(at_peak, shares, 0.0)
    enough = np.flatnonzero(shares >= 1.0 / (1.0 + error) ** 2)
    best = int(np.argmax(shares))
    if not len(enough):
        return Reading(term, float(tau[best]), float(shares[best]), None)
    region = float(tau[enough[0]]), float(tau[enough[-1]])
    if term.letter == "N":
        at = int(enough[np.argmin(np.abs(np.log(tau[enough])))])
    elif term.letter == "B":
        at = int(enough[np.argmax(shares[enough] >= _PLATEAU * shares[best])])
    else:
        at = int(enough[0])
    return Reading(term, float(tau[at]), float(shares[at]), region)


def _cluster_times(shortest: float) -> Array:
    count = int(_PER_DECADE * math.log10(_LONGEST / shortest)) + 1
    return np.asarray(shortest * 10.0 ** (np.arange(count) / _PER_DECADE))
