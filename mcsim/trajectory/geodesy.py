"""Positions on the earth's ellipsoid as metres on a plane."""

from __future__ import annotations

import math

import numpy as np

from mcsim.trajectory.curves import Array

#: WGS 84 ellipsoid.
_SEMI_MAJOR, _FLATTENING = 6378137.0, 1 / 298.257223563


def local_position(latitude: Array, longitude: Array) -> tuple[Array, Array]:
    """East and north (m) from the first fix, on the WGS 84 ellipsoid's tangent plane.

    Uses the radii of curvature at the mean latitude: 1 cm over a few kilometres.
    """
    middle = float(np.mean(latitude))
    e2 = _FLATTENING * (2.0 - _FLATTENING)
    w = math.sqrt(1.0 - e2 * math.sin(middle) ** 2)
    prime_vertical = _SEMI_MAJOR / w
    meridian = _SEMI_MAJOR * (1.0 - e2) / w**3
    east = prime_vertical * math.cos(middle) * (longitude - longitude[0])
    return east, meridian * (latitude - latitude[0])
