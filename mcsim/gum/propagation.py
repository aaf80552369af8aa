"""The law of propagation for one step of the velocity measurement, Eq. (25) to (29).

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
    acx: Any, acz: Any, theta: Any, g: float, interval: float
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
