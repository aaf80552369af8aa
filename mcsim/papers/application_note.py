"""Table 1 of the application note as printed."""

from __future__ import annotations

#: Acceleration (m/s^2), velocity at 10 s (m/s), position (m) at 10 s,
#: 1 min, 10 min, 1 h, by the angle in degrees.
PRINTED: dict[str, tuple[float, ...]] = {
    "0.1 °": (0.017, 0.17, 1.7, 61.2, 6120.0, 220e3),
    "0.5 °": (0.086, 0.86, 8.6, 309.6, 30960.0, 1.1e6),
    "1 °": (0.17, 1.7, 17.0, 612.0, 61200.0, 2.2e6),
    "1.5 °": (0.256, 2.56, 25.6, 921.6, 92160.0, 3.3e6),
    "2 °": (0.342, 3.42, 34.2, 1231.2, 123120.0, 4.4e6),
    "3 °": (0.513, 5.13, 51.3, 1846.8, 184680.0, 6.6e6),
    "5 °": (0.854, 8.54, 85.4, 3074.4, 307440.0, 11e6),
}
