"""Calibration of tri-axial accelerometers: six-position test, shaker test."""

from mcsim.calibration.estimate import Estimate
from mcsim.calibration.shaker import LinearityFit, linearity, read_amplitudes, simulate_shaker
from mcsim.calibration.six_positions import (
    SixPositionFit,
    SixPositions,
    calibrate,
    read_six_positions,
    simulate_six_positions,
)

__all__ = [
    "Estimate",
    "LinearityFit",
    "SixPositionFit",
    "SixPositions",
    "calibrate",
    "linearity",
    "read_amplitudes",
    "read_six_positions",
    "simulate_shaker",
    "simulate_six_positions",
]
