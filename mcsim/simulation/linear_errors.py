"""Linear errors: weights of all disturbances, and the moments of the errors that follow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from mcsim.simulation.lengths import length_quantile, mean_length
from mcsim.simulation.problem import Array, LinearModel


@dataclass(frozen=True)
class Weights:
    """Linear errors (l) per unit of every disturbance, in the order of the kernel's.

    ``samples`` (l, n + 1, c) of each channel's error at each sample; ``constants`` (l, k) of what
    a realization draws once, apart from the sensors' own, in the places of the kernel's;
    ``at_rest`` (l, c) of the channels' mean errors where the attitude is levelled before.
    """

    samples: Array
    constants: Array
    at_rest: Array

    @classmethod
    def without_rest(cls, samples: Array, constants: Array) -> Weights:
        """Of a run that nothing is levelled before."""
        return cls(samples, constants, np.zeros((len(samples), samples.shape[2])))


@dataclass(frozen=True)
class Errors:
    """How reported errors (e,) follow from linear ones (l,).

    ``linear`` are the rows of the errors that have a linear error, in the order of those;
    ``lengths`` those that are the length of a vector, with the rows of its components.
    """

    linear: tuple[int, ...]
    lengths: Mapping[int, tuple[int, ...]] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of reported errors."""
        return len(self.linear) + len(self.lengths)

    def of(self, components: Sequence[int]) -> list[int]:
        """Which linear errors are these reported ones."""
        return [self.linear.index(row) for row in components]

    def spread_out(self, linear: Array) -> Array:
        """Linear errors (l, …) at their places among the reported ones (e, …), zero elsewhere."""
        reported = np.zeros((self.count, *linear.shape[1:]))
        reported[list(self.linear)] = linear
        return reported

    def controls(self, linear: Array, method: Array) -> Array:
        """Controls (e, r) from linear errors (l, r): of a length, that of (method + linear)."""
        controls = self.spread_out(linear)
        for row, components in self.lengths.items():
            own = list(components)
            controls[row] = length_of(method[own, None] + controls[own]) - length_of(method[own])
        return controls

    def spike_events(self, linear: Array) -> Array:
        """Spikes per realization (e,); those of a length are of its rarest component's."""
        events = self.spread_out(linear)
        for row, components in self.lengths.items():
            events[row] = min((e for e in events[list(components)] if e > 0.0), default=0.0)
        return events

    def model(
        self, covariance: Array, by_source: Mapping[str, Array], method: Array
    ) -> LinearModel:
        """Moments of the linear errors and of the controls.

        ``covariance`` (l, l) is that of the controls, ``by_source`` the variances (l,) of all that
        disturbs, controlled or not.  The control of a length is the length of (method error +
        linear error) less that of the method error; its moments follow from the exact
        distribution.
        """
        everything = covariance + beyond_controls(covariance, by_source)
        mean, second = self._moments(covariance, method)
        all_mean, all_second = self._moments(everything, method)
        return LinearModel(
            mean=all_mean,
            second_moment=all_second,
            control_mean=mean,
            control_second_moment=second,
            variances={source: self._variances(v) for source, v in by_source.items()},
            quantiles={
                row: _Quantile(method[list(own)], everything[np.ix_(self.of(own), self.of(own))])
                for row, own in self.lengths.items()
            },
        )

    def _variances(self, linear: Array) -> Array:
        """Variances (e,): of a length, those of its components together."""
        reported = self.spread_out(linear)
        for row, components in self.lengths.items():
            reported[row] = reported[list(components)].sum()
        return reported

    def _moments(self, covariance: Array, method: Array) -> tuple[Array, Array]:
        """Mean and second moment (e,) of the reported errors less the method's."""
        mean, second = np.zeros(self.count), self.spread_out(np.diag(covariance))
        for row, components in self.lengths.items():
            own = np.ix_(self.of(components), self.of(components))
            mean[row], second[row] = length_moments(method[list(components)], covariance[own])
        return mean, second


@dataclass(frozen=True)
class _Quantile:
    """Quantile function of the length of a normal vector."""

    centre: Array
    covariance: Array

    def __call__(self, p: float) -> float:
        return length_quantile(self.centre, self.covariance, p)


def length_of(components: Array) -> Array:
    """Lengths (…) of vectors (d, …)."""
    if len(components) == 2:
        return np.asarray(np.hypot(*components))
    return np.asarray(np.sqrt(np.sum(components**2, axis=0)))


def length_moments(method: Array, covariance: Array) -> tuple[float, float]:
    """Mean and second moment of the control of a length."""
    offset = float(length_of(method))
    length = mean_length(method, covariance)
    return length - offset, 2.0 * offset**2 + float(np.trace(covariance)) - 2.0 * offset * length


def beyond_controls(covariance: Array, by_source: Mapping[str, Array]) -> Array:
    """What the sources have beyond the controls' covariance; taken as uncorrelated."""
    total = np.sum(list(by_source.values()), axis=0)
    beyond = total - np.diag(covariance)
    return np.diag(np.where(beyond > 1e-9 * total, beyond, 0.0))


def variances_of(
    weights: Array, deviations: Array, sources: Mapping[str, Iterable[int]]
) -> dict[str, Array]:
    """Variance (l,) by source among what a realization draws once.

    ``weights`` (l, k) per unit, ``deviations`` (k,); ``sources`` names the places of each.
    """
    drawn = weights * deviations
    return {
        source: np.sum(drawn[:, list(places)] ** 2, axis=1) for source, places in sources.items()
    }
