"""Positions on the earth's ellipsoid as metres on a plane."""

from __future__ import annotations

import math

import numpy as np

from mcsim.trajectory.curves import Array

#: WGS 84 ellipsoid.
_SEMI_MAJOR, _FLATTENING = 6378137.0, 1 / 298.257223563


def local_position(latitude: Array, longitude: Array) -> tuple[Array, Array]:
    """East and north (m) from the first known fix on the WGS 84 ellipsoid's tangent plane.

    What is not known is nan.

    Uses the radii of curvature at the mean latitude: 1 cm over a few kilometres.
    """
    known = np.isfinite(latitude + longitude)
    first = int(np.argmax(known))
    middle = float(np.mean(latitude[known])) if np.any(known) else 0.0
    e2 = _FLATTENING * (2.0 - _FLATTENING)
    w = math.sqrt(1.0 - e2 * math.sin(middle) ** 2)
    prime_vertical = _SEMI_MAJOR / w
    meridian = _SEMI_MAJOR * (1.0 - e2) / w**3
    east = prime_vertical * math.cos(middle) * (longitude - longitude[first])
    return east, meridian * (latitude - latitude[first])
