"""Measured velocities as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mcsim.measured_velocity.measurement import Measurement
from mcsim.measured_velocity.propagation import tilts
from mcsim.measured_velocity.reference import Reference
from mcsim.units import degrees

if TYPE_CHECKING:
    import pandas as pd


def velocity_table(found: Measurement, reference: Reference | None) -> pd.DataFrame:
    """Every run, their mean, and its uncertainties over time; all in m/s."""
    import pandas as pd

    many = found.group.runs > 1
    columns = {"time [s]": found.group.time}
    for i, run in enumerate(found.runs, start=1):
        columns[f"run {i} [m/s]"] = run
    columns["mean [m/s]"] = found.mean
    columns["uc of one run, Eq. (30) [m/s]"] = np.sqrt(np.mean(found.sums.single**2, axis=0))
    if many:
        columns["s(v) [m/s]"] = found.sums.scatter
        columns["uc of the mean, Eq. (31) [m/s]"] = found.sums.mean
    columns["u of one run, Monte Carlo [m/s]"] = np.sqrt(np.mean(found.drawn.single**2, axis=0))
    columns["u of the mean, Monte Carlo [m/s]"] = found.drawn.mean
    columns["2.5 % of the mean [m/s]"] = found.drawn.low
    columns["97.5 % of the mean [m/s]"] = found.drawn.high
    if reference is not None and found.reference is not None:
        columns["reference [m/s]"] = found.reference
        columns["u of the reference [m/s]"] = reference.deviation(found.reference)
        columns["error of the mean [m/s]"] = found.mean - found.reference
    return pd.DataFrame(columns)


def run_table(found: Measurement) -> pd.DataFrame:
    """One row per run: its rest, tilt, length, and velocity at the end."""
    import pandas as pd

    group = found.group
    columns = {
        "run": np.arange(1, group.runs + 1),
        "from": list(group.names),
        "samples at rest": group.rest_samples,
        "initial tilt [deg]": degrees(tilts(found.inputs, group)),
        "start of motion [s]": list(group.begins),
        "motion [s]": list(group.lengths),
        "largest velocity [m/s]": found.runs[np.arange(group.runs), _largest(found.runs)],
        "velocity at the end [m/s]": found.runs[:, -1],
    }
    if group.reference is not None:
        columns["error at the end [m/s]"] = found.runs[:, -1] - group.reference[:, -1]
    return pd.DataFrame(columns)


def _largest(runs: np.ndarray) -> np.ndarray:
    return np.asarray(np.argmax(np.abs(runs), axis=1))
