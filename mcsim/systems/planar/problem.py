"""A point of a planar scenario as a problem: truth, sampling and sensor errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mcsim.sensors.error_model import ACCELEROMETER, Channel, channel_errors, per_interval
from mcsim.simulation.planar import CHANNELS, RATES, PlanarProblem, initial_deviations
from mcsim.simulation.planar_samples import course_missing, sampled
from mcsim.systems.planar.scenario import PlanarScenario
from mcsim.tracks import drive_of
from mcsim.units import STANDARD_GRAVITY

#: The axis of gravity, which a level vehicle does not measure, and the true signals at rest.
_VERTICAL = (Channel(ACCELEROMETER, 2),)
_AT_REST = np.array([0.0, 0.0, 0.0, STANDARD_GRAVITY])


def planar_problem(model: PlanarScenario, folder: Path) -> PlanarProblem:
    """Truth, sampling and error model of one point.

    Raises
    ------
    InputError
        No such track, or one that is shorter than a sample or absurdly long.
    """
    drive = drive_of(model.trajectory, folder)
    sensors = model.sensors
    errors = channel_errors(sensors, CHANNELS, drive.duration, _AT_REST, further=_VERTICAL)
    samples = sampled(drive, sensors.rate, sensors.sampling, errors.bandwidths)
    signals = samples.signals
    if errors.mixing:
        # Gravity is not measured, but shows by misalignment and g-sensitivity.
        signals = np.column_stack([signals, np.full(len(signals), STANDARD_GRAVITY)])
    return PlanarProblem(
        signals=signals,
        initial_deviations=initial_deviations(model.initial),
        sensor_errors=per_interval(errors, (*RATES, False), 1.0 / sensors.rate),
        truth=samples.truth,
        interval=1.0 / sensors.rate,
        rule=model.reconstruction.integration,
        previous_share=0.0 if sensors.sampling == "average" else 0.5,
        missing=course_missing(drive),
        beyond_rate=samples.beyond_rate,
    )
