"""A drive in the plane as three channels sense it: for every case that has these."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mcsim.scenario.sample_times import Intervals
from mcsim.scenario.sensors import Sensors
from mcsim.sensor_terms.channel import ACCELEROMETER, Channel
from mcsim.sensor_terms.mechanisms.linear_filter import filters_of, passed
from mcsim.sensors.error_model import ChannelErrors, channel_errors, per_interval
from mcsim.simulation.planar import CHANNELS, RATES
from mcsim.simulation.planar_samples import course_missing, planned, sampled, scheduled_count
from mcsim.simulation.problem import Array
from mcsim.tracks import Trajectory, drive_of
from mcsim.trajectory import Motion
from mcsim.units import STANDARD_GRAVITY

#: The axis of gravity, which a level vehicle does not measure, and the true signals at rest.
_VERTICAL = (Channel(ACCELEROMETER, 2),)
_AT_REST = np.array([0.0, 0.0, 0.0, STANDARD_GRAVITY])


@dataclass(frozen=True)
class Driven:
    """A drive as forward acceleration, left acceleration and yaw rate.

    ``signals`` (n + 1, 3, or 4 with gravity where it shows, or more with courses that follow
    from these) and ``sensor_errors`` have turns per interval in the place of yaw rates; ``truth``
    is the true motion at the samples.  ``missing`` and ``beyond_rate`` as in ``Reckoning``.
    """

    signals: Array
    sensor_errors: ChannelErrors
    truth: Motion
    interval: float
    missing: Mapping[str, str]
    beyond_rate: Array


def driven(
    trajectory: Trajectory, sensors: Sensors, folder: Path, intervals: Intervals = "measured"
) -> Driven:
    """What sensors of a level vehicle sample of a drive, with their errors.

    Parameters
    ----------
    trajectory, sensors
        The validated blocks of a scenario, SI.
    folder : path
        Where the files that they name are looked up.
    intervals : {"measured", "nominal"}
        What the reconstruction takes for the time between samples; ``sensor_errors`` keep it, with
        all that ``sensors.time`` says.

    Returns
    -------
    Driven
        ``signals`` (n + 1, 3, or 4 with gravity where it shows): forward and left acceleration
        (m/s^2), yaw turn (rad per interval); ``sensor_errors`` of these channels; ``truth`` at the
        samples; ``interval`` (s), ``missing`` and ``beyond_rate``, for ``OwnReckoning``.

    Raises
    ------
    InputError
        No such track, or one that is shorter than a sample or absurdly long.
    """
    drive = drive_of(trajectory, folder)
    errors = channel_errors(sensors, CHANNELS, drive.duration, _AT_REST, further=_VERTICAL)
    plan = planned(drive, sensors, folder, intervals)
    errors = replace(errors, schedule=plan)
    samples = sampled(
        drive,
        sensors.rate,
        sensors.sampling,
        errors.filters,
        plan.instants,
        sensors.time.latency,
    )
    signals = samples.signals
    if errors.mixing:
        # Gravity is not measured, but shows by misalignment and g-sensitivity.
        upward = passed(STANDARD_GRAVITY, filters_of(sensors.accelerometer.acts_on(2)))
        signals = np.column_stack([signals, np.full(len(signals), upward)])
    errors = per_interval(errors, (*RATES, False), 1.0 / sensors.rate)
    return Driven(
        signals=errors.with_columns(signals),
        sensor_errors=errors,
        truth=samples.truth,
        interval=1.0 / sensors.rate,
        missing=course_missing(drive),
        beyond_rate=samples.beyond_rate,
    )


def samples_of(trajectory: Trajectory, sensors: Sensors, folder: Path) -> int:
    """Samples of a realization, without sensing anything.

    Parameters
    ----------
    trajectory, sensors, folder
        As of ``driven``.

    Returns
    -------
    int
        n, of the samples 0 ... n.

    Raises
    ------
    InputError
        As ``driven``.
    """
    return scheduled_count(drive_of(trajectory, folder), sensors, folder)
