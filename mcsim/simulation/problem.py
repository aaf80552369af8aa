"""What the engine knows of a case: error names, a simulation, the method's own errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: How sources end that are spikes.
SPIKES = " spikes"


@dataclass(frozen=True)
class Sample:
    """Errors of some realizations, and the controls that go with them.

    ``errors`` (e, r) in SI units, NaN if undefined; ``controls`` (e, r) or (e, 0): what
    the linear model makes of the same disturbances, as deviation from the method error.
    """

    errors: Array
    controls: Array


@dataclass(frozen=True)
class History:
    """Reconstructed tracks and their errors over time.

    time (n + 1,) in s from the first sample; tracks (c, n + 1, r) of what ``coordinates``
    names, with units; truth (c, n + 1); errors (e, n + 1, r) in SI units, NaN where
    undefined.
    """

    time: Array
    tracks: Array
    truth: Array
    errors: Array
    coordinates: tuple[str, ...] = ("along [m]", "across [m]")


@dataclass(frozen=True)
class LinearModel:
    """First-order effect of every disturbance on the errors; SI units, (e,) each.

    ``mean`` and ``second_moment`` are those of the linear errors less the method's;
    ``control_mean`` and ``control_second_moment`` those of the controls, which may leave out
    disturbances whose random numbers a kernel does not weigh.  ``variances`` are those of
    the signed errors by source of disturbance (for the position error: of its components
    together).  ``quantiles`` are the quantile functions of errors (by row) that are not
    normal.  ``spike_events`` are the spikes that a realization has on average, as many as of
    equal weight scatter alike; ``flips`` the share of realizations whose angle jumps by half a
    turn; both are zero or absent where there are none.
    """

    mean: Array
    second_moment: Array
    control_mean: Array
    control_second_moment: Array
    variances: Mapping[str, Array]
    quantiles: Mapping[int, Callable[[float], float]]
    spike_events: Array = field(default_factory=lambda: np.zeros(0))
    flips: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def spread(self) -> Array:
        """Standard deviation (e,) of the controls."""
        variance = self.control_second_moment - self.control_mean**2
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)), float)

    def spike_variance(self) -> Array:
        """What spikes add to the variance of each error (e,)."""
        found = [v for source, v in self.variances.items() if source.endswith(SPIKES)]
        return np.asarray(sum(found, np.zeros(len(self.mean))), float)


@dataclass(frozen=True)
class Limit:
    """A bound of a sensor or of a model that a point reaches.

    Of ``looked_at`` realizations ``reached`` reach it; both are zero where it is a property of
    the point.  ``certain`` tells that the undisturbed motion reaches it already.  ``abrupt``
    ones make errors that no linear model follows; one that could be reached, but was not, has
    no text.
    """

    text: str
    reached: int = 0
    looked_at: int = 0
    certain: bool = True
    abrupt: bool = False


class Problem(Protocol):
    """One simulated system, ready to run."""

    @property
    def error_names(self) -> tuple[str, ...]:
        """Labels of the errors, in the order of every array."""

    @property
    def percentiles(self) -> tuple[float, ...]:
        """The percentiles that are estimated of every error."""

    @property
    def missing(self) -> Mapping[str, str]:
        """Errors that are undefined here, with the reason."""

    @property
    def n_samples(self) -> int:
        """Samples integrated per realization."""

    @property
    def linear(self) -> LinearModel:
        """The linear model around the undisturbed reconstruction."""

    def simulate(
        self, key: int, first: int, count: int, controls: bool = False, net: int = 0
    ) -> Sample:
        """Realizations first ... first + count - 1, with controls if asked for.

        What a realization draws once comes from Sobol nets of ``net`` realizations, unless
        that is zero.
        """

    def limits(self, key: int, count: int) -> Sequence[Limit]:
        """Bounds of sensors and models in reach, looked for in the first ``count`` realizations."""

    def method_errors(self) -> Array:
        """Errors (e,) of the undisturbed reconstruction."""

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        """The same realizations over time."""
