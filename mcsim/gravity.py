"""Acceleration of gravity over latitude and height."""

from __future__ import annotations

import math


def normal_gravity(latitude: float, height: float = 0.0) -> float:
    """Acceleration of gravity (m/s²) at a geodetic latitude (rad) and a height (m) above the sea.

    The international formula of 1980 with the free-air gradient, as chapter 2.1 of the thesis has
    it, ``9.780327 (1 + 0.0053024 sin² φ − 0.0000058 sin² 2φ) − 0.000003086 h``.  What lies under
    the ground makes the local value differ by up to some 1e-3 m/s², mostly by a few 1e-4.
    """
    level = 1.0 + 0.0053024 * math.sin(latitude) ** 2 - 0.0000058 * math.sin(2.0 * latitude) ** 2
    return 9.780327 * level - 3.086e-6 * height
