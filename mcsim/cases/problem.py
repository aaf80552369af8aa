"""What the engine knows of a case: error names, a simulation, the method's own errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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

    time (n + 1,) in s from the first sample; tracks (2, n + 1, r) along, across in m;
    truth (2, n + 1); errors (e, n + 1, r) in SI units, NaN where undefined.
    """

    time: Array
    tracks: Array
    truth: Array
    errors: Array


@dataclass(frozen=True)
class LinearModel:
    """First-order effect of every disturbance on the errors; SI units, (e,) each.

    ``mean`` and ``second_moment`` are the expectations of the controls and of their
    squares; ``variances`` those of the signed errors by source of disturbance (for the
    position error: of its components together).  ``centre`` (d,) and ``plane`` (d, d) are
    mean and covariance of the position error in a plane (d = 2) or in space (d = 3).
    """

    mean: Array
    second_moment: Array
    variances: Mapping[str, Array]
    centre: Array
    plane: Array


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

    def simulate(self, key: int, first: int, count: int, controls: bool = False) -> Sample:
        """Realizations first ... first + count - 1, with controls if asked for."""

    def method_errors(self) -> Array:
        """Errors (e,) of the undisturbed reconstruction."""

    def history(self, key: int, first: int, count: int) -> History:
        """The same realizations over time."""
