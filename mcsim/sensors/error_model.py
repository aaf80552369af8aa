"""Sensor errors of a scenario as the numbers that a kernel takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.sensors import Sensors
from mcsim.units import sample_deviation


@dataclass(frozen=True)
class ChannelErrors:
    """Standard deviations per channel, in SI units; arrays (3,): forward, left, yaw rate.

    ``white`` is that of one sample, ``miscalibration`` that of the constant offset.
    """

    white: NDArray[np.float64]
    miscalibration: NDArray[np.float64]


def channel_errors(sensors: Sensors) -> ChannelErrors:
    """The error parameters of the three planar channels."""
    accelerometer, gyroscope = sensors.accelerometer, sensors.gyroscope
    densities = (accelerometer.density, accelerometer.density, gyroscope.density)
    return ChannelErrors(
        white=np.array([sample_deviation(density, sensors.rate) for density in densities]),
        miscalibration=np.array(
            [accelerometer.miscalibration, accelerometer.miscalibration, gyroscope.miscalibration]
        ),
    )
