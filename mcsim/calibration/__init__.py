"""Calibration of tri-axial accelerometers: six positions, any positions at rest, shaker."""

from mcsim.calibration.estimate import Estimate
from mcsim.calibration.norm import (
    NormFit,
    RestPositions,
    calibrate_by_norm,
    simulate_rest_positions,
)
from mcsim.calibration.rest_positions import find_rests, read_positions
from mcsim.calibration.shaker import LinearityFit, linearity, read_amplitudes, simulate_shaker
from mcsim.calibration.six_positions import (
    SixPositionFit,
    SixPositions,
    calibrate,
    read_six_positions,
    simulate_six_positions,
)
from mcsim.calibration.weighted import calibrate_weighted

__all__ = [
    "Estimate",
    "LinearityFit",
    "NormFit",
    "RestPositions",
    "SixPositionFit",
    "SixPositions",
    "calibrate",
    "calibrate_by_norm",
    "calibrate_weighted",
    "find_rests",
    "linearity",
    "read_amplitudes",
    "read_positions",
    "read_six_positions",
    "simulate_rest_positions",
    "simulate_shaker",
    "simulate_six_positions",
]
