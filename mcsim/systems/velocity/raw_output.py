"""Errors of an accelerometer whose raw output is in fractions of g: the velocity case's sensor.

Values in m/s^2 become fractions of g by the scenario's estimate of gravity.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.channel import ACCELEROMETER, Channel
from mcsim.sensors.error_model import ChannelErrors, Conditions, element_errors, scaled
from mcsim.systems.velocity.scenario import VelocityScenario

Array = NDArray[np.float64]

AXES = tuple(Channel(ACCELEROMETER, axis) for axis in range(3))


def raw_noise(model: VelocityScenario) -> Array:
    """u(am): standard deviation (3,) of one raw sample's white noise, in fractions of g.

    What the scenario writes as ``noise``, or ``ND sqrt(fs / 2)`` of the accelerometer.
    """
    sensor = model.sensor
    if sensor.noise is not None:
        return np.array([sensor.noise.x, sensor.noise.y, sensor.noise.z])
    errors = element_errors({ACCELEROMETER: sensor.terms}, sensor.rate, AXES, 0.0)
    return errors.white / model.gravity.local_gravity


def raw_errors(model: VelocityScenario) -> ChannelErrors:
    """All error terms of the axes x, y, z, in fractions of g.

    In-run noise spans a group: the rest and all runs after it.  Scale factors and
    misalignment mix what the axes sense, the raw output less the zero bias: among the
    signals that is columns 3 to 5, behind the raw output itself.
    """
    sensor, run = model.sensor, model.trajectory
    errors = element_errors(
        {ACCELEROMETER: sensor.terms},
        sensor.rate,
        AXES,
        run.rest + model.runs * run.duration,
        # What the axes sense at rest is not asked for: nothing is calibrated by it.
        conditions=Conditions(temperature=sensor.temperature),
    )
    errors = scaled(errors, np.full(len(AXES), 1.0 / model.gravity.local_gravity))
    sensed = len(AXES)
    return replace(
        errors,
        white=raw_noise(model),
        mixing=tuple(replace(m, source=sensed + m.source) for m in errors.mixing),
        columns=tuple(replace(c, channel=sensed + c.channel) for c in errors.columns),
    )
