"""The law of propagation for the steps of the velocity measurement, Eq. (25) to (29).

Functions take arrays over steps, or single numbers, and return variances by input.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
AXES = "xyz"


@dataclass(frozen=True)
class Correction:
    """Row of the correction, Eq. (4) or (5): estimates and uncertainties (3,) of l and B."""

    factors: Array
    u_factors: Array
    bias: Array
    u_bias: Array

    def value(self, raw: Array) -> Any:
        """Corrected acceleration in fractions of g from raw output (…, 3)."""
        return (raw - self.bias) @ self.factors

    def sensitivities(self, raw: Array) -> tuple[Array, Array, Array]:
        """Derivatives (…, 3) with respect to l, am and B."""
        factors = np.broadcast_to(self.factors, np.shape(raw))
        return raw - self.bias, factors, -factors

    def variances(self, raw: Array, noise: Array) -> Mapping[str, Array]:
        """Variance by source, Eq. (26) or (27); ``noise`` (3,) is u(am)."""
        by_factor, by_raw, by_bias = self.sensitivities(raw)
        return {
            "calibration matrix": np.sum((by_factor * self.u_factors) ** 2, axis=-1),
            "zero bias": np.sum((by_bias * self.u_bias) ** 2, axis=-1),
            "noise": np.sum((by_raw * noise) ** 2, axis=-1),
        }


def tilt_sensitivities(rest_x: Any, rest_z: Any) -> tuple[Any, Any]:
    """Derivatives of arctan(acx0 / acz0) with respect to both, Eq. (28)."""
    q = rest_x**2 + rest_z**2
    return rest_z / q, -rest_x / q


def step_sensitivities(
    acx: Any, acz: Any, theta: Any, g: float, interval: Any
) -> tuple[Any, Any, Any, Any, Any]:
    """Derivatives of Dv with respect to acx, acz, theta, g and the interval, Eq. (29)."""
    tilted = acx - acz * theta
    return (
        g * interval,
        -theta * g * interval,
        -acz * g * interval,
        tilted * interval,
        tilted * g,
    )


@dataclass(frozen=True)
class Known:
    """What the steps of a run share, with standard uncertainties; see Eq. (26) to (29).

    ``noise`` (3,) is u(am) of one raw sample, ``tilt_change`` u(δα) (rad), ``gravity`` (m/s²) and
    ``interval_error`` u(Δt) (s).
    """

    x: Correction
    z: Correction
    noise: Array
    tilt_change: float
    gravity: float
    gravity_error: float
    interval_error: float


def step_variances(known: Known, raw: Array, rest: Array, interval: Any) -> dict[str, Array]:
    """Variances u²(Dv) (n,) of steps by source, Eq. (29) with (26) to (28) for its parts.

    ``raw`` (n, 3) is the output at the steps, ``rest`` (3,) at rest, ``interval`` one or (n,) in s.
    At rest the raw output enters with the uncertainty of a single sample, as in the source.
    """
    x, z, noise = known.x, known.z, known.noise
    by_rest_x, by_rest_z = tilt_sensitivities(x.value(rest), z.value(rest))
    theta = np.arctan(x.value(rest) / z.value(rest))
    acx, acz = x.value(raw), z.value(raw)
    by_x, by_z, by_theta, by_g, by_interval = step_sensitivities(
        acx, acz, theta, known.gravity, interval
    )
    of_x, of_z = x.variances(raw, noise), z.variances(raw, noise)
    of_rest_x, of_rest_z = x.variances(rest, noise), z.variances(rest, noise)
    steps = {
        source: by_x**2 * of_x[source]
        + by_z**2 * of_z[source]
        + by_theta**2 * (by_rest_x**2 * of_rest_x[source] + by_rest_z**2 * of_rest_z[source])
        for source in of_x
    }
    steps["tilt change"] = by_theta**2 * known.tilt_change**2 * np.ones_like(acx)
    steps["gravity"] = by_g**2 * known.gravity_error**2
    steps["time base"] = by_interval**2 * known.interval_error**2
    return steps


def summed(steps: Mapping[str, Array]) -> tuple[dict[str, Array], Array]:
    """Eq. (30) by source (n + 1,), and the variance of Eq. (31) without the raw output's noise."""
    sums = {source: np.append(0.0, np.cumsum(variance)) for source, variance in steps.items()}
    return (
        {source: np.sqrt(variance) for source, variance in sums.items()},
        np.sum([variance for source, variance in sums.items() if source != "noise"], axis=0),
    )
