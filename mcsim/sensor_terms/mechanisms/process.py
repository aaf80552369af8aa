"""In-run noise as a sum of first-order processes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.mechanism import Mechanism, stream

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FirstOrder:
    """``x[k+1] = decay x[k] + w[k]``: variances of w and of x[0]."""

    decay: float
    step_variance: float
    start: float


@dataclass(frozen=True)
class Process(Mechanism):
    """A sum of first-order processes: ``parts(interval, duration)``, in seconds both.

    ``interval`` is that between samples, ``duration`` that of the run with its rests.
    """

    parts: Callable[[float, float], Sequence[FirstOrder]]


def gauss_markov(variance: float, correlation_time: float, interval: float) -> FirstOrder:
    """A Gauss-Markov process in its stationary state, Eq. (3.27)-(3.29) of the thesis.

    An infinite time (s) makes it a constant, none at all makes it white.
    """
    ratio = interval / correlation_time if correlation_time > 0.0 else math.inf
    # expm1 keeps the small steps of long correlation times.
    return FirstOrder(math.exp(-ratio), -variance * math.expm1(-2.0 * ratio), variance)


def random_walk(intensity: float, interval: float) -> FirstOrder:
    """Brownian motion from zero, of Allan's K: steps of ``K √dt``."""
    return FirstOrder(1.0, intensity**2 * interval, 0.0)


@dataclass(frozen=True)
class Processes:
    """First-order processes whose sum is a channel's coloured noise.

    ``decay`` and ``step_variance`` (m,) per sample; ``start`` (m, m) is their covariance at the
    first sample; ``terms`` says which of them belong to which term of the error model.
    """

    decay: Array
    step_variance: Array
    start: Array
    terms: Mapping[str, slice]

    @property
    def count(self) -> int:
        return len(self.decay)

    def scaled(self, factor: float) -> Processes:
        """The same noise in another unit."""
        return replace(
            self, step_variance=factor**2 * self.step_variance, start=factor**2 * self.start
        )

    def only(self, term: str) -> Processes:
        """One term alone."""
        own = self.terms[term]
        return Processes(
            self.decay[own], self.step_variance[own], self.start[own, own], {term: slice(None)}
        )


NO_PROCESSES = Processes(np.zeros(0), np.zeros(0), np.zeros((0, 0)), {})


def processes_of(terms: Mapping[str, Process], interval: float, duration: float) -> Processes:
    """The processes of one channel, by the names of their terms.

    What starts at nothing comes last.
    """
    parts = {name: tuple(term.parts(interval, duration)) for name, term in terms.items()}
    named = [(name, own) for name, own in parts.items() if own]
    named.sort(key=lambda term: not any(part.start for part in term[1]))
    slices: dict[str, slice] = {}
    everything: list[FirstOrder] = []
    for name, own in named:
        slices[name] = slice(len(everything), len(everything) + len(own))
        everything += own
    return Processes(
        np.array([part.decay for part in everything]),
        np.array([part.step_variance for part in everything]),
        np.diag(np.array([part.start for part in everything])),
        slices,
    )


def process_noise(processes: Processes, random: np.random.Generator) -> Callable[[int], Array]:
    """Processes of a simulated log: their sum over the next n samples (n,) at each call."""
    from scipy.signal import lfilter

    deviations = np.sqrt(processes.step_variance)
    state = _root(processes.start) @ random.standard_normal(processes.count)

    def take(count: int) -> Array:
        driving = random.standard_normal((count, processes.count)) * deviations
        total = np.zeros(count)
        for k, decay in enumerate(processes.decay):
            # Value k is the state before noise k moves it on.
            driven = np.concatenate(([state[k]], driving[:, k]))
            states = lfilter([1.0], [1.0, -decay], driven)
            total += states[:-1]
            state[k] = states[-1]
        return total

    return take


def _root(covariance: Array) -> Array:
    """A matrix whose product with its transpose is the covariance, which may be singular."""
    if not np.any(covariance - np.diag(np.diag(covariance))):
        return np.diag(np.sqrt(np.diag(covariance)))
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def in_run_noise(processes: Sequence[Processes], seed: int) -> Callable[[int], Array]:
    """In-run noise of a simulated log: the next n samples (n, c) at each call."""
    taken = [
        [process_noise(own.only(term), stream(seed, term, k)) for term in own.terms]
        for k, own in enumerate(processes)
    ]

    def take(count: int) -> Array:
        noise = np.zeros((count, len(taken)))
        for k, terms in enumerate(taken):
            for term in terms:
                noise[:, k] += term(count)
        return noise

    return take
