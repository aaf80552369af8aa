"""The velocity of a group of recorded runs with its uncertainty, in both ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.gum import Budget, Course
from mcsim.gum.budget import StepPoint, budget_at
from mcsim.measured_velocity.group import Group
from mcsim.measured_velocity.propagation import (
    DRAWS,
    SOURCES,
    Drawn,
    Inputs,
    Sums,
    by_acceleration,
    draw,
    sums,
    velocities,
)

Array = NDArray[np.float64]

#: Draws for one source alone.
_DRAWS_ALONE = 2000


@dataclass(frozen=True)
class Measurement:
    """Velocities ``runs`` (M, n + 1) in m/s over ``group.time``, and their uncertainties."""

    group: Group
    inputs: Inputs
    runs: Array
    sums: Sums
    drawn: Drawn

    @property
    def mean(self) -> Array:
        """Mean velocity (n + 1,), the source's best estimate."""
        return np.asarray(self.runs.mean(axis=0))

    @property
    def reference(self) -> Array | None:
        """The reference's mean over the runs (n + 1,), if there is one."""
        given = self.group.reference
        return None if given is None else np.asarray(given.mean(axis=0))

    @property
    def summed(self) -> Array:
        """uc of the mean, Eq. (31); of a single run Eq. (30)."""
        return self.sums.mean if self.group.runs > 1 else self.sums.single[0]


def measure(inputs: Inputs, group: Group, draws: int = DRAWS, seed: int = 1) -> Measurement:
    """Correct, level and integrate all runs, and propagate what is uncertain."""
    runs = velocities(inputs, group)
    return Measurement(
        group, inputs, runs, sums(inputs, group, runs), draw(inputs, group, draws, seed)
    )


def step_budget_of(measurement: Measurement) -> Budget:
    """The 26 rows, with estimates averaged over the motion as in the source."""
    inputs, group = measurement.inputs, measurement.group
    known = inputs.known(group)
    rest = group.rests.mean(axis=0)
    u_x, u_z = (
        float(np.sqrt(sum(row.variances(rest, known.noise).values()))) for row in (known.x, known.z)
    )
    return budget_at(
        StepPoint(
            known=known,
            raw=group.raw.mean(axis=(0, 1)),
            rest_x=(float(known.x.value(rest)), u_x),
            rest_z=(float(known.z.value(rest)), u_z),
            interval=group.time_base.interval,
        )
    )


def course_of(measurement: Measurement, seed: int = 1) -> Course:
    """Uncertainty over time by sums and by Monte Carlo, source by source."""
    inputs, group, own = measurement.inputs, measurement.group, measurement.sums
    drawn = measurement.drawn
    alone = {
        source: _root_mean_square(draw(inputs, group, _DRAWS_ALONE, seed, source).single)
        for source in SOURCES
    }
    return Course(
        time=group.time,
        truth=measurement.mean,
        runs=group.runs,
        summed=own.by_source,
        summed_mean=own.mean,
        simulated=alone,
        total=_root_mean_square(drawn.single),
        total_mean=drawn.mean,
        scatter=own.scatter,
        other_scatter=drawn.scatter,
        stamps=inputs.stamps,
        by_acceleration=by_acceleration(inputs, group),
        measured=True,
    )


def _root_mean_square(values: Array) -> Array:
    return np.sqrt(np.mean(values**2, axis=0))
